//! An episode as a table.

use std::fmt::Write;

use oneiro::batch::{Record, Trace};
use oneiro::compose::{Detail, DetailKind, Scalar};
use oneiro::differential::Build;
use oneiro::foraging;
use oneiro::parameter::Choice;
use oneiro::tables::SENSOR_NAMES;
use oneiro::world::{Robot, World};
use oneiro_base::contents::{Column, head};

use crate::experiment::Experiment;

/// Cycles from one record of a champion's trace to the next: a long episode is traced less often.
pub(super) fn trace_every(experiment: &Experiment) -> u32 {
    const LONGEST: u32 = 10_000;
    experiment.world().cycles().div_ceil(LONGEST)
}

/// The table of a world's traces.
pub struct TraceTable {
    cells: Vec<(Column, Cell)>,
}

/// Source of a column's values.
enum Cell {
    Record(fn(&Record) -> f32),
    /// A word of the details.
    Detail(usize, Scalar),
}

impl TraceTable {
    /// The pose at the start of the cycle, the perceived readings, the outputs and their results, the readings before noise,
    /// where they were sensed, and what parts remember.
    pub fn new(world: &World) -> Self {
        let records = |columns: &'static [Recorded]| {
            let cell = |(column, value): &Recorded| (column.clone(), Cell::Record(*value));
            columns.iter().map(cell)
        };
        let robot = &world.spec().robot;
        let details = |is_wanted: fn(DetailKind) -> bool| {
            // A reference model's readings have their noise already.
            let is_again = |own: &Detail| own.kind == DetailKind::Real && is_of_model(&own.name, robot);
            let wanted = world
                .details()
                .iter()
                .enumerate()
                .filter(move |(_, own)| is_wanted(own.kind) && !is_again(own));
            wanted.map(move |(index, own)| (column(own, robot), Cell::Detail(index, own.scalar)))
        };
        let cells = records(&POSE)
            .chain(details(|kind| kind == DetailKind::Perceived))
            .chain(records(&ACTION))
            .chain(details(|kind| kind == DetailKind::Real))
            .chain(records(&SEEN))
            .chain(details(|kind| matches!(kind, DetailKind::Memory(_))))
            .chain(details(|kind| matches!(kind, DetailKind::Other | DetailKind::Puck)))
            .chain(details(|kind| matches!(kind, DetailKind::Heard | DetailKind::Earned)));
        Self { cells: cells.collect() }
    }

    /// Its columns.
    pub fn columns(&self) -> impl Iterator<Item = &Column> {
        std::iter::once(&CYCLE).chain(self.cells.iter().map(|(column, _)| column))
    }

    /// Name and type of the words of each column but the first, which is the cycle.
    pub fn scalars(&self) -> Vec<(String, Scalar)> {
        let scalar = |cell: &Cell| match *cell {
            Cell::Record(_) => Scalar::Float,
            Cell::Detail(_, scalar) => scalar,
        };
        let each = self.cells.iter();
        each.map(|(column, cell)| (column.name.clone().into_owned(), scalar(cell)))
            .collect()
    }

    /// The words of those columns in a line.
    pub fn words<'a>(&'a self, record: &'a Record, details: &'a [u32]) -> impl Iterator<Item = u32> {
        self.cells.iter().map(move |(_, cell)| match *cell {
            Cell::Record(value) => value(record).to_bits(),
            Cell::Detail(word, _) => details[word],
        })
    }

    /// A trace with a record each `every` cycles as CSV: a line a record.
    pub fn csv(&self, trace: &Trace, every: u32) -> String {
        self.head() + &self.lines(trace, 0, every)
    }

    /// The names of the columns.
    pub fn head(&self) -> String {
        head(self.columns())
    }

    /// Lines of a trace, from that of the cycle `first` on.
    pub fn lines(&self, trace: &Trace, first: u32, every: u32) -> String {
        let mut text = String::with_capacity(trace.len() * 8 * (1 + self.cells.len()));
        for ((record, details), index) in trace.lines().zip(0_u64..) {
            // Writing to a string can't fail.
            let _ = write!(text, "{}", u64::from(first) + index * u64::from(every));
            for (_, cell) in &self.cells {
                let _ = match *cell {
                    Cell::Record(value) => write!(text, ",{}", value(record)),
                    Cell::Detail(word, Scalar::Float) => write!(text, ",{}", f32::from_bits(details[word])),
                    Cell::Detail(word, Scalar::Unsigned) => write!(text, ",{}", details[word]),
                    Cell::Detail(word, Scalar::Signed) => write!(text, ",{}", details[word].cast_signed()),
                };
            }
            text.push('\n');
        }
        text
    }
}

/// Whether a reading is that of a robot's reference model.
fn is_of_model(name: &str, robot: &Robot) -> bool {
    let model = robot.build.described().and_then(|own| own.model);
    model.is_some_and(|model| model.readings().iter().any(|own| own == name))
}

/// The column of one of the details of a robot.
fn column(detail: &Detail, robot: &Robot) -> Column {
    const SAMPLED: Column = Column::number("", "0 to 1", "");
    const OWN: Column = Column::number("", "", "");
    let name = &detail.name;
    let sampled = name.parse().ok().and_then(|sensor: usize| SENSOR_NAMES.get(sensor));
    let described = robot.described_sensors().iter().find(|sensor| sensor.name == *name);
    let is_foragers = matches!(robot.build, Build::Forager(_)) && foraging::READINGS.contains(&name.as_str());
    let robots = match (sampled, described) {
        (None, None) if is_of_model(name, robot) => Some(format!("reading `{name}` of the reference model")),
        (Some(sensor), _) => Some(format!("activation of `{sensor}`")),
        (None, Some(sensor)) => Some(format!("reading of the {} sensor `{name}`", sensor.kind.word())),
        (None, None) if is_foragers => Some(format!("reading `{name}`")),
        (None, None) => None,
    };
    match (detail.kind, robots) {
        (DetailKind::Perceived, Some(reading)) => SAMPLED
            .named(format!("sensor_{name}"))
            .about(format!("the perceived {reading}, noise included")),
        (DetailKind::Real, Some(reading)) => SAMPLED
            .named(format!("real_{name}"))
            .about(format!("the {reading} before sensor noise")),
        (DetailKind::Perceived, None) => OWN
            .named(format!("sensor_{name}"))
            .about(format!("the reading `{name}` of the experiment's custom sensors")),
        (DetailKind::Real, None) => OWN
            .named(format!("real_{name}"))
            .about(format!("the reading `{name}` before sensor noise")),
        (DetailKind::Other, _) => OWN.named(name.clone()).about(
            "another robot's pose at the start of the cycle: x and y in mm, and z, its heading in turns".to_owned(),
        ),
        (DetailKind::Puck, _) => OWN
            .named(name.clone())
            .about("a puck's place at the start of the cycle: x and y in mm".to_owned()),
        (DetailKind::Heard, _) => Column::whole("", "", "").named(name.clone()).about(
            "the robots whose messages it has received since the row before: a bit for each, the lowest for robot 0"
                .to_owned(),
        ),
        (DetailKind::Earned, _) => OWN
            .named(name.clone())
            .about("the robot's score from the task since the row before".to_owned()),
        (DetailKind::Memory(part), _) => {
            let word = part.word();
            let own = match detail.scalar {
                Scalar::Float => OWN,
                Scalar::Unsigned | Scalar::Signed => Column::whole("", "", ""),
            };
            own.named(format!("{word}.{name}"))
                .about(format!("`{name}` of the {word}'s memory after the cycle"))
        }
    }
}

type Recorded = (Column, fn(&Record) -> f32);

static CYCLE: Column = Column::whole("cycle", "100 ms", "its number, from 0");
#[rustfmt::skip]
static POSE: [Recorded; 3] = [
    (Column::number("x_mm", "mm", "x at the start of the cycle"), |record| record.x),
    (Column::number("y_mm", "mm", "y at the start of the cycle"), |record| record.y),
    (Column::number("heading_turns", "turns", "the heading at the start of the cycle, counter-clockwise from the x axis"), |record| record.heading),
];
#[rustfmt::skip]
static ACTION: [Recorded; 7] = [
    (Column::number("output_left", "0 to 1", "the controller's output for the left wheel"), |record| record.left),
    (Column::number("output_right", "0 to 1", "the controller's output for the right wheel"), |record| record.right),
    (Column::number("speed_left", "-1 to 1", "the speed of the left wheel as a fraction of the maximum: the selected speed, or a parametric robot's mean over the cycle"), |record| record.speed_left),
    (Column::number("speed_right", "-1 to 1", "the speed of the right wheel, in the same way"), |record| record.speed_right),
    (Column::number("collided", "", "1 if the cycle ended in a collision, else 0"), |record| record.collided),
    (Column::number("reward", "", "the reward of the cycle"), |record| record.reward),
    (Column::number("fitness", "", "the sum of the rewards up to and including this cycle; if a custom task has `task_score`, the episode's fitness is its result for the last sum"), |record| record.fitness),
];
#[rustfmt::skip]
static SEEN: [Recorded; 2] = [
    (Column::number("seen_x_mm", "mm", "x of the place where the activations were sensed, displaced by conservative noise"), |record| record.seen_x),
    (Column::number("seen_y_mm", "mm", "y of that place"), |record| record.seen_y),
];

#[cfg(test)]
mod tests {
    use oneiro::batch::{Batch, Rollout, TraceRequest};
    use oneiro::evaluator::{Control, Evaluator};
    use oneiro::random::Key;
    use oneiro::world::WorldSpec;

    use super::*;

    #[test]
    fn a_line_a_record() {
        let world = World::new(WorldSpec {
            cycles: 7,
            ..WorldSpec::miglino1995()
        })
        .unwrap();
        let rollout = Rollout {
            world: 0,
            genes: &[0.5; 18],
            key: Key::of_words([1, 2]),
        };
        let table = TraceTable::new(&world);
        let batch = Batch::new(&[world], &[rollout], Some(TraceRequest { every: 5 })).unwrap();
        let mut cpu = oneiro::cpu::Cpu::new(Some(1)).unwrap();
        let outcome = cpu.evaluate(&batch, &Control::new()).unwrap();
        let trace = &outcome.traces[0];
        let text = table.csv(trace, 5);
        let lines: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
        assert_eq!(lines.len(), 3);
        assert!(lines.iter().all(|line| line.len() == 29));
        let cell = |name: &str| lines[2][lines[0].iter().position(|column| *column == name).unwrap()];
        assert_eq!((lines[0][0], lines[0][28]), ("cycle", "seen_y_mm"));
        assert_eq!(lines[2][0], "5");
        for (name, value) in [
            ("x_mm", trace[1].x),
            ("sensor_7", trace.activations(1)[7]),
            ("real_0", f32::from_bits(trace.details(1)[8])),
            ("fitness", trace[1].fitness),
            ("seen_y_mm", trace[1].seen_y),
        ] {
            assert_eq!(cell(name), value.to_string(), "{name}");
        }
    }
}
