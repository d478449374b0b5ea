//! Measures how well a simulator predicts a robot. Compares readings and moves in logged episodes of the robot with those of the
//! simulator at the same poses and with the same commands. Returns noise and motor settings that fit; changes nothing.
//!
//! | file | contents |
//! |---|---|
//! | [`logged`] | reads recorded episodes |
//! | [`readings`] | errors of readings, by sensor and distance, and their age |
//! | [`moves`] | gains of the wheels, the latency of commands, errors of moves |
//! | [`page`] | the page with figures |

pub mod logged;
mod moves;
pub mod page;
pub mod readings;

use std::fmt::Write as _;

use oneiro::differential::Build;
use oneiro::world::World;
use oneiro_base::exit::Result;
use oneiro_report::numbers::fixed;

use crate::engine::handle::Engine;
use moves::Moves;
use readings::Readings;

/// A logged episode of a robot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Logged {
    /// Its cycles, in order of time.
    pub cycles: Vec<Cycle>,
}

/// Values logged at the beginning of a cycle, and the command that followed.
#[derive(Clone, Debug, PartialEq)]
pub struct Cycle {
    /// Time since the episode began, s.
    pub time: f64,
    /// Activations that the controller received; one for each of the robot's sensors.
    pub activations: Vec<f64>,
    /// Commanded speeds of the left and the right wheel, mm/s.
    pub commanded: [f64; 2],
    /// Travel of both wheels since the episode began, mm; `None` without odometers.
    pub travel: Option<[f64; 2]>,
    /// x and y in mm, heading in turns.
    pub pose: [f64; 3],
}

/// Results of a comparison.
#[derive(Clone, Debug)]
pub struct Calibration {
    pub readings: Readings,
    /// `None` without odometers.
    pub moves: Option<Moves>,
    /// Number of episodes, and of cycles, that were compared.
    pub lives: usize,
    pub cycles: usize,
}

impl Calibration {
    /// Compares a simulator's world with episodes of the robot.
    ///
    /// Errors of the device.
    /// Those of the device.
    pub fn of(world: &World, lives: &[Logged], engine: &Engine) -> Result<Self> {
        Ok(Self {
            readings: Readings::of(world, lives, engine)?,
            moves: Moves::of(lives),
            lives: lives.len(),
            cycles: lives.iter().map(|life| life.cycles.len()).sum(),
        })
    }

    /// Settings for an experiment, as TOML with comments: the measured values that the simulator has a setting for.
    pub fn settings(&self, world: &World) -> String {
        let [low, high] = self.readings.noise();
        let mut text = format!(
            "# Noise that spreads readings and moves as the robot's are spread around the simulator's.\n[noise]\nsensor = [{}, {}]\n",
            fixed(low, 3),
            fixed(high, 3)
        );
        let Some(moves) = &self.moves else { return text };
        // Writing to a string can't fail.
        let _ = writeln!(text, "motor = {:.3}", moves.noise());
        if let Build::Differential(own) = &world.spec().robot.build
            && let Some(speed) = own.greatest_speed
        {
            let _ = writeln!(
                text,
                "\n# The wheels' speeds as they were measured, and how late commands took effect.\n[robot]\n\
                 greatest_speed_mm_s = {:.1}\nlatency_cycles = {}",
                f64::from(speed) * moves.mean_gain(),
                (moves.latency / CYCLE).round()
            );
        } else if moves.is_far_off() {
            let _ = writeln!(
                text,
                "\n# The wheels turn at {:.3} (left) and {:.3} (right) times their commanded speeds: sample the motors again.",
                moves.gains[0], moves.gains[1]
            );
        }
        text
    }
}

/// Length of a simulated cycle, s.
const CYCLE: f64 = 0.1;

/// Half the width of a uniform distribution with a standard deviation.
fn half_width(deviation: f64) -> f64 {
    deviation * 3_f64.sqrt()
}

#[cfg(test)]
mod tests {
    use oneiro::world::WorldSpec;

    use super::readings::{Errors, SensorErrors};
    use super::*;
    use oneiro_report::page::check::{outside, unbalanced};

    fn calibration(gains: [f64; 2]) -> Calibration {
        let errors = Errors {
            count: 5,
            mean: 0.01,
            deviation: 0.02,
        };
        let sensor = |name: &str| SensorErrors {
            name: name.into(),
            at: vec![errors; 5],
            pairs: vec![[0.1, 0.15], [0.5, 0.45], [1.0, 1.0]],
        };
        Calibration {
            readings: Readings {
                sensors: vec![sensor("left_90"), sensor("<right>")],
                age: 0.05,
                compared: 100,
                left_out: 3,
            },
            moves: Some(Moves {
                gains,
                latency: 0.13,
                deviation: [0.2, 0.3],
                relative: 0.05,
                moving: 80,
            }),
            lives: 2,
            cycles: 103,
        }
    }

    #[test]
    fn settings_are_toml_and_say_what_to_do() {
        let world = World::new(WorldSpec::miglino1995()).unwrap();
        let settings = calibration([0.99, 1.01]).settings(&world);
        let values: toml::Table = settings.parse().unwrap();
        let noise = values["noise"]["sensor"].as_array().unwrap();
        let [low, high] = [0, 1].map(|limit: usize| noise[limit].as_float().unwrap());
        assert!(low < 0.0 && high > 0.0, "{settings}");
        assert_eq!(values["noise"]["motor"].as_float(), Some(0.087));
        assert!(!settings.contains("sample the motors again"), "{settings}");
        let far = calibration([0.9, 1.01]).settings(&world);
        assert!(far.contains("0.900 (left) and 1.010 (right) times their commanded speeds: sample the motors again"));
        assert_eq!(far.parse::<toml::Table>().unwrap(), values);
    }

    #[test]
    fn the_page_is_whole() {
        for moves in [calibration([0.9, 1.0]).moves, None] {
            let calibration = Calibration {
                moves,
                ..calibration([0.9, 1.0])
            };
            let html = page::page("a & b", &calibration, "[noise]\nmotor = 0.1\n");
            assert_eq!(unbalanced(&html), None);
            // A sensor's panel has the line on which readings are as predicted, from corner to corner.
            let lines: Vec<&str> = html
                .lines()
                .filter(|line| line.contains("stroke-dasharray=\"4 4\" data-series=\"equal\""))
                .collect();
            assert_eq!(lines.len(), 2);
            let points: Vec<f64> = lines[0]
                .split('"')
                .nth(1)
                .unwrap()
                .split([' ', ','])
                .map(|x| x.parse().unwrap())
                .collect();
            let plot: Vec<f64> = html
                .split("data-plot=\"")
                .nth(1)
                .unwrap()
                .split('"')
                .next()
                .unwrap()
                .split(' ')
                .map(|x| x.parse().unwrap())
                .collect();
            assert_eq!([points[0], points[2], points[3], points[1]], plot[..]);
            assert_eq!(outside(&html), None);
            assert!(html.contains("a &amp; b") && html.contains("&lt;right&gt;") && !html.contains("NaN"));
        }
    }
}
