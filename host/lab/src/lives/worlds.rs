//! The worlds of episodes, where worlds or starts vary, as a table.

use oneiro::world::{DrawnNumbers, Start, World};
use oneiro_base::contents::{Column, Entry, head};

/// File of the table.
pub const FILE: &str = "worlds.csv";

static WORLD: Column = Column::whole("world", "", "its number, from 0");
static POSES: Column = Column::whole(
    "poses",
    "",
    "the number of its start among `start.poses`, from 0; in a swarm, that of its robots' starts",
);

/// The file of a directory with such episodes.
pub fn entry(columns: &[Column]) -> Entry {
    let about = "with `[worlds]` or several `start.poses`: one row per world of which episodes take one, with its drawn numbers by their keys";
    Entry::table(FILE, about, columns)
}

/// The columns that a table may begin with.
pub fn first_columns() -> [Column; 2] {
    [WORLD.clone(), POSES.clone()]
}

/// The table: a row for each world, with its drawn numbers.
#[derive(Debug)]
pub struct WorldTable {
    drawn: DrawnNumbers,
    /// Starts of each drawn world, if they are given.
    starts: Option<usize>,
}

impl WorldTable {
    /// `None` if nothing varies.
    pub fn new(world: &World) -> Option<Self> {
        let spec = world.spec();
        let starts = match &spec.start {
            Start::Poses(poses) => Some(poses.0.len() / spec.robot.count() as usize),
            _ => None,
        };
        (world.variants().len() > 1).then(|| Self {
            drawn: world.drawn(),
            starts,
        })
    }

    pub fn columns(&self) -> Vec<Column> {
        let key = |(key, unit): &(String, &'static str)| Column::number("", unit, "a drawn number").named(key.clone());
        let poses = self.starts.map(|_| POSES.clone());
        let first = std::iter::once(WORLD.clone()).chain(poses);
        first.chain(self.drawn.keys.iter().map(key)).collect()
    }

    pub fn csv(&self) -> String {
        let mut text = head(&self.columns());
        for (number, values) in self.drawn.values.iter().enumerate() {
            let poses = self.starts.map(|starts| (number % starts).to_string());
            let first = std::iter::once(number.to_string()).chain(poses);
            let row: Vec<String> = first.chain(values.iter().map(ToString::to_string)).collect();
            text += &(row.join(",") + "\n");
        }
        text
    }
}
