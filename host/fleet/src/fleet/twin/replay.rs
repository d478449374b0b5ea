//! A page that plays what a twin recorded: its arena second by second, and its robots' genes interval by interval.

use std::path::{Path, PathBuf};

use oneiro::swarm::SECOND;
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files::whole_lines;
use oneiro_lab::swarm::Plan;
use oneiro_report::figures::{Act, ForagersReplay, Genes, Moment, Sight, Teller, foragers_page};
use serde::Deserialize;

use super::super::page::REPLAY;
use super::super::statuses::read;
use super::record::{ARENA, Row};
use crate::daemon::intervals::INTERVALS;
use crate::daemon::settings::Settings;

/// What the wheels of a robot do.
const ACTS: [Act; 2] = [
    Act {
        name: "stands",
        short: "stands",
        colour: "#c9ccd3",
        front: Act::DARK,
    },
    Act {
        name: "drives",
        short: "drives",
        colour: "#2a9d8f",
        front: Act::LIGHT,
    },
];

/// Genes of a robot's interval.
#[derive(Clone, Copy, Debug, Deserialize)]
struct Lived {
    interval: u32,
    s0: f32,
    g0: f32,
    g1: f32,
}

/// Writes the page into a twin's directory, and returns its path.
///
/// # Errors
/// Exit 3: the directory is not that of a twin; exit 5: its tables are damaged, with the line; exit 6.
pub fn write(directory: &Path) -> Result<PathBuf> {
    let robots = directory.join("robots");
    let settings = robots.join("0.toml");
    if !settings.is_file() || !directory.join(ARENA).is_file() {
        return Err(Failure::input(format_args!(
            "{}: has no {ARENA} and robots/0.toml; allowed: a fleet's file, or the directory of a twin",
            directory.display()
        )));
    }
    let plan = Settings::read(&settings)?.plan;
    let page = foragers_page(&ForagersReplay {
        title: &format!("Twin {}, seed {}", name(directory), plan.seed),
        foragers: &plan.settings.swarm(),
        lamp: plan.lamp(),
        names: &(0..plan.settings.world.robots).collect::<Vec<_>>(),
        acts: &ACTS,
        teller: Teller::Record,
        lines: &moments(&directory.join(ARENA), plan.settings.world.robots)?,
        genes: &genes(&plan, &robots)?,
    });
    let path = directory.join(REPLAY);
    disk::write(&path, page.as_bytes())?;
    Ok(path)
}

/// The last part of a directory's path.
fn name(directory: &Path) -> String {
    let whole = directory.canonicalize().unwrap_or_else(|_| directory.to_owned());
    let name = whole.file_name().map(|name| name.to_string_lossy().into_owned());
    name.unwrap_or_else(|| whole.display().to_string())
}

/// The arena second by second, without a second that is torn at the end.
fn moments(path: &Path, robots: u32) -> Result<Vec<Moment>> {
    let rows: Vec<Row> = read(path, whole_lines(&disk::read_text(path)?))?;
    let mut totals = vec![0; robots as usize];
    let mut moments: Vec<Moment> = Vec::new();
    for (index, seconds) in rows.chunks_exact(robots as usize).enumerate() {
        let cycle = |row: &Row| SECOND * (row.second + 1);
        let before = moments.last().map_or(0, |last| last.cycle);
        let is_next = |(number, row): (u32, &Row)| row.robot == number && cycle(row) == cycle(&seconds[0]);
        if cycle(&seconds[0]) <= before || !(0..).zip(seconds).all(is_next) {
            return Err(Failure::corrupt(format_args!(
                "{}: line {} and those after it; expected: robots 0 to {} in a later second",
                path.display(),
                index * robots as usize + 2,
                robots - 1
            )));
        }
        let sights = seconds.iter().zip(&mut totals).map(|(row, total)| {
            let before = std::mem::replace(total, row.brought);
            Sight {
                pose: Some([row.x, row.y, row.heading]),
                act: usize::from(row.left != 0.0 || row.right != 0.0),
                carries: row.carries == 1,
                brought: row.brought.saturating_sub(before),
                ..Sight::default()
            }
        });
        moments.push(Moment {
            cycle: cycle(&seconds[0]),
            robots: sights.collect(),
            food: Vec::new(),
        });
    }
    Ok(moments)
}

/// Each robot's genes: none if its daemon has ended no interval.
fn genes(plan: &Plan, robots: &Path) -> Result<Vec<Vec<Genes>>> {
    let clocks = plan.clocks();
    let of_robot = |(robot, clock): (usize, &oneiro_lab::swarm::clock::Clock)| {
        let path = robots.join(robot.to_string()).join(INTERVALS);
        let text = if path.is_file() {
            disk::read_text(&path)?
        } else {
            String::new()
        };
        let intervals: Vec<Lived> = read(&path, whole_lines(&text))?;
        let genes = |interval: Lived| Genes {
            cycle: SECOND * clock.seconds_of(interval.interval).start,
            s0: interval.s0,
            g0: interval.g0,
            g1: interval.g1,
        };
        Ok(intervals.into_iter().map(genes).collect())
    };
    clocks.iter().enumerate().map(of_robot).collect()
}

#[cfg(test)]
mod tests;
