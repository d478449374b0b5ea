//! Reads episodes from the directory where they were recorded.

use std::path::Path;

use csv::StringRecord;
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};

use super::{Cycle, Logged};
use crate::reality::wired::logbook::{COMPLETE, INDEX, table};

/// Reads the complete episodes of a directory. `sensors` are the names of the robot's sensors in the experiment.
///
/// # Errors
/// Exit 3 for a directory without episodes, or with those of other sensors; exit 5 for files that aren't what was written.
pub fn lives(directory: &Path, sensors: &[String]) -> Result<Vec<Logged>> {
    let index = directory.join(INDEX);
    if !index.is_file() {
        return Err(Failure::input(format_args!(
            "{}: has no {INDEX}; allowed: a folder that `oneiro evaluate --robot --log` wrote, or a run's folder `lives`",
            directory.display()
        )));
    }
    let mut lives = Vec::new();
    Table::read(
        &index,
        &["life", "status", "start_x_mm", "start_y_mm", "start_heading_turns"],
    )?
    .each(|cells| {
        if cells.text(1) != COMPLETE {
            return Some(Ok(()));
        }
        let start = [cells.number(2)?, cells.number(3)?, cells.number(4)?];
        let path = directory.join(table(cells.text(0)));
        Some(life(&path, start, sensors).map(|life| lives.push(life)))
    })?;
    Ok(lives)
}

/// Reads an episode that began at the pose `start`.
fn life(path: &Path, start: [f64; 3], sensors: &[String]) -> Result<Logged> {
    const OTHERS: [&str; 8] = [
        "time_s",
        "left_mm_s",
        "right_mm_s",
        "left_mm",
        "right_mm",
        "x_mm",
        "y_mm",
        "heading_turns",
    ];
    let names: Vec<&str> = OTHERS.into_iter().chain(sensors.iter().map(String::as_str)).collect();
    let mut life = Logged::default();
    // Travel and pose are those at the end of a cycle.
    let (mut pose, mut travel) = (start, Some([0.0; 2]));
    Table::read(path, &names)?.each(|cells| {
        life.cycles.push(Cycle {
            time: cells.number(0)?,
            commanded: [cells.number(1)?, cells.number(2)?],
            travel,
            pose,
            activations: (OTHERS.len()..names.len())
                .map(|cell| cells.number(cell))
                .collect::<Option<_>>()?,
        });
        travel = cells.number(3).zip(cells.number(4)).map(|(left, right)| [left, right]);
        pose = [cells.number(5)?, cells.number(6)?, cells.number(7)?];
        Some(Ok(()))
    })?;
    Ok(life)
}

/// Some columns of a table.
struct Table {
    path: String,
    records: Vec<StringRecord>,
    columns: Vec<usize>,
}

/// A row of a table.
struct Cells<'a>(&'a StringRecord, &'a [usize]);

impl Cells<'_> {
    fn text(&self, column: usize) -> &str {
        self.0.get(self.1[column]).unwrap_or_default()
    }

    fn number(&self, column: usize) -> Option<f64> {
        self.text(column).parse().ok().filter(|number: &f64| number.is_finite())
    }
}

impl Table {
    fn read(path: &Path, names: &[&str]) -> Result<Self> {
        let text = disk::read_text(path)?;
        let path = path.display().to_string();
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let head = reader.headers().cloned().unwrap_or_default();
        let column = |name: &&str| {
            head.iter().position(|own| own == *name).ok_or_else(|| {
                let own: Vec<&str> = head.iter().collect();
                Failure::input(format_args!(
                    "{path}: has no column `{name}`, but {}; allowed: episodes of the experiment's robot",
                    own.join(", ")
                ))
            })
        };
        let columns = names.iter().map(column).collect::<Result<_>>()?;
        let records = reader.records().collect::<std::result::Result<_, _>>();
        let records = records.map_err(|error| Failure::corrupt(format_args!("{path}: {error}")))?;
        Ok(Self { path, records, columns })
    }

    /// Takes each row; `take` returns `None` for a cell that is no number.
    fn each(&self, mut take: impl FnMut(Cells<'_>) -> Option<Result>) -> Result {
        for (record, line) in self.records.iter().zip(2..) {
            let corrupt = || Failure::corrupt(format_args!("{}: line {line} isn't what was written", self.path));
            take(Cells(record, &self.columns)).ok_or_else(corrupt)??;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scratch::Scratch;

    fn scratch(name: &str, files: &[(&str, &str)]) -> Scratch {
        let scratch = Scratch::new(&format!("logged-{name}"));
        for (file, text) in files {
            scratch.write(file, text);
        }
        scratch
    }

    const INDEX: &str =
        "life,status,start_x_mm,start_y_mm,start_heading_turns\n1,complete,100,50,0.5\n2,lifted,0,0,0\n";
    const LIFE: &str = "cycle,time_s,raw_a,front,left_mm_s,right_mm_s,left_mm,right_mm,x_mm,y_mm,heading_turns,reward\n\
                        0,0,12,0.25,80,72,7.9,7.1,92.5,50,0.49,1\n1,0.1,13,0.5,8,-8,8.6,6.4,92,51,0.5,1\n";

    #[test]
    fn poses_and_travel_are_those_at_the_beginning_of_a_cycle() {
        let scratch = scratch("whole", &[("lives.csv", INDEX), ("life-1.csv", LIFE)]);
        let lives = lives(scratch.path(), &["front".into()]).unwrap();
        let cycle = |time, activation, commanded, travel, pose| Cycle {
            time,
            activations: vec![activation],
            commanded,
            travel: Some(travel),
            pose,
        };
        let cycles = vec![
            cycle(0.0, 0.25, [80.0, 72.0], [0.0; 2], [100.0, 50.0, 0.5]),
            cycle(0.1, 0.5, [8.0, -8.0], [7.9, 7.1], [92.5, 50.0, 0.49]),
        ];
        assert_eq!(lives, [Logged { cycles }]);
    }

    #[test]
    fn what_is_no_directory_of_lives_is_refused() {
        let refused = |name: &str, files: &[(&str, &str)]| {
            let scratch = scratch(name, files);
            lives(scratch.path(), &["front".into()]).unwrap_err().to_string()
        };
        assert!(refused("empty", &[]).contains("has no lives.csv; allowed: a folder that `oneiro evaluate --robot"));
        let other = LIFE.replace("front", "back");
        let words = refused("other", &[("lives.csv", INDEX), ("life-1.csv", &other)]);
        assert!(words.contains("has no column `front`, but cycle, time_s"), "{words}");
        let torn = LIFE.replace("0.1,13", "x,13");
        let words = refused("torn", &[("lives.csv", INDEX), ("life-1.csv", &torn)]);
        assert!(words.contains("life-1.csv: line 3 isn't what was written"), "{words}");
    }
}
