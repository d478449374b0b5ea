//! `oneiro robot watch`: shows a robot's sensors live.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use ::console::Term;
use oneiro_base::console::Console;
use oneiro_base::exit::{Failure, Result};
use oneiro_lab::engine::signals::stop_signal;
use oneiro_report::numbers::fixed;
use oneiro_robots::error::Error;
use oneiro_robots::{Group, Kind, Reading, Robot, stopped, unstopped};
use serde_json::{Map, Value, json};

use super::{connected, milliseconds, number, used};
use crate::cli::RobotWatch;
use crate::commands::live::Live;

/// Shows readings until Ctrl-C, or until there are as many as wanted.
pub(super) fn run(arguments: &RobotWatch, console: Console) -> Result {
    connected(&arguments.link, console, |_, robot| {
        used(robot?, |robot| readings(robot, arguments, console))
    })
}

fn readings(robot: &mut dyn Robot, arguments: &RobotWatch, console: Console) -> Result {
    let stop = stop_signal()?;
    let kinds: Vec<Kind> = match &arguments.kinds[..] {
        [] => robot.description().sensors.iter().map(|group| group.kind).collect(),
        kinds => kinds.to_vec(),
    };
    let mut display = Display::new(&robot.description().groups(&kinds)?, console);
    let (cycle, start) = (Duration::from_secs_f64(1.0 / arguments.hz), Instant::now());
    let mut shown = 0;
    while arguments.cycles.is_none_or(|cycles| shown < cycles) {
        if stop.load(Ordering::Relaxed) {
            return ended(shown, arguments.cycles, console);
        }
        match robot.sense(&kinds) {
            // A program of its own may drive it now.
            Err(Error::Restarted) => {
                stopped(robot).map_err(|error| unstopped(&error))?;
                console.say("the robot has restarted, and its wheels have been stopped; check its battery");
            }
            reading => {
                display.show(&reading?)?;
                shown += 1;
            }
        }
        wait(start, cycle, &stop);
    }
    Ok(())
}

/// Ctrl-C is how a watch without an end is ended; one of a given length is cut short by it.
fn ended(shown: u64, wanted: Option<u64>, console: Console) -> Result {
    match wanted {
        None => {
            console.say("stopped by Ctrl-C");
            Ok(())
        }
        Some(wanted) => Err(Failure::stopped(format_args!(
            "stopped after {shown} of {wanted} readings"
        ))),
    }
}

/// Waits for the beginning of the next cycle; not as long if the program is to stop.
fn wait(start: Instant, cycle: Duration, stop: &AtomicBool) {
    const GLANCE: Duration = Duration::from_millis(20);
    let past = start.elapsed().as_secs_f64() / cycle.as_secs_f64();
    let next = start + cycle.mul_f64(past.floor() + 1.0);
    while !stop.load(Ordering::Relaxed) {
        match next.saturating_duration_since(Instant::now()) {
            Duration::ZERO => return,
            left => thread::sleep(left.min(GLANCE)),
        }
    }
}

/// What shows readings.
struct Display {
    /// The sensors with their names.
    sensors: Vec<(&'static str, Group)>,
    /// When the first readings were taken.
    first: Option<Duration>,
    live: Live,
}

impl Display {
    fn new(groups: &[Group], console: Console) -> Self {
        let sensors = groups
            .iter()
            .flat_map(|group| group.names.iter().map(|name| (*name, *group)));
        Self {
            sensors: sensors.collect(),
            first: None,
            live: Live::new(console),
        }
    }

    /// Shows a row for each sensor, or all in one line of JSON.
    fn show(&mut self, reading: &Reading) -> Result {
        let first = *self.first.get_or_insert(reading.at);
        let readings = || self.sensors.iter().zip(&reading.values);
        self.live.show(
            || {
                let rows = readings().map(|((name, group), value)| row(name, group.unit, group.range, *value));
                fitted(rows.collect(), usize::from(Term::stdout().size().0))
            },
            || {
                let values: Map<String, Value> = readings()
                    .map(|((name, _), value)| ((*name).to_owned(), number(*value)))
                    .collect();
                let time = reading.at.saturating_sub(first).as_micros() as f64 / 1e6;
                json!({ "time_s": time, "age_ms": milliseconds(reading.age), "values": values })
            },
        )
    }
}

/// Lines that a terminal of some height shows, its last row left to the cursor; what is left out is counted.
fn fitted(mut lines: Vec<String>, height: usize) -> String {
    let most = height.saturating_sub(1).max(1);
    if lines.len() > most {
        let left = lines.split_off(most - 1).len();
        lines.push(format!("{left} more rows; choose with --kinds"));
    }
    lines.join("\n")
}

/// A sensor's name, its reading as a bar over its usual range, and the reading itself.
pub(super) fn row(name: &str, unit: &str, (least, greatest): (f64, f64), value: f64) -> String {
    const WIDTH: usize = 32;
    // Beyond the range the bar is empty or full.
    let share = ((value - least) / (greatest - least)).clamp(0.0, 1.0);
    let bar = "█".repeat((share * WIDTH as f64).round() as usize);
    let shown = if value.fract() == 0.0 {
        value.to_string()
    } else {
        fixed(value, 2)
    };
    format!("{name:22} {bar:·<WIDTH$} {shown:>8} {unit}")
        .trim_end()
        .to_owned()
}

#[cfg(test)]
mod tests {
    use super::{fitted, row};

    #[test]
    fn a_table_fits_its_terminal_and_says_what_is_left_out() {
        let lines = || (0..35).map(|line| line.to_string()).collect::<Vec<_>>();
        assert_eq!(fitted(lines(), 36), lines().join("\n"));
        let cut = fitted(lines(), 35);
        assert!(cut.ends_with("\n32\n2 more rows; choose with --kinds"), "{cut}");
        assert_eq!(cut.lines().count(), 34);
        assert_eq!(fitted(lines(), 0), "35 more rows; choose with --kinds");
    }

    #[test]
    fn bars_are_as_long_as_the_share_of_the_range() {
        let drawn = |value, range| {
            let row = row("distance_front", "mm", range, value);
            row.chars().filter(|c| *c == '█').count()
        };
        assert_eq!([0.0, 50.0, 100.0].map(|value| drawn(value, (0.0, 100.0))), [0, 16, 32]);
        assert_eq!([-32.0, 0.0, 32.0].map(|value| drawn(value, (-32.0, 32.0))), [0, 16, 32]);
        assert_eq!([-1.0, 1e9].map(|value| drawn(value, (0.0, 100.0))), [0, 32]);
        let bar = "█".repeat(8) + &"·".repeat(24);
        assert_eq!(
            row("distance_front", "mm", (0.0, 1000.0), 250.0),
            format!("distance_front         {bar}      250 mm")
        );
        assert_eq!(
            row("x", "", (0.0, 1.0), 0.254),
            format!("x                      {bar}     0.25")
        );
    }
}
