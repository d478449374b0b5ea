//! Readings: the simulator's at the robot's poses, compared with the robot's there.

use oneiro::batch::{Batch, Rollout, TraceRequest};
use oneiro::compose::DetailKind;
use oneiro::random::Key;
use oneiro::world::{Collision, Noise, Robot, Start, World, WorldSpec};
use oneiro_base::exit::{Failure, Result};
use oneiro_statistics::{mean, variance};

use super::{Logged, half_width};
use crate::engine::handle::Engine;
use crate::lives::measures::free_distance;

/// Errors of readings.
#[derive(Clone, Debug)]
pub struct Readings {
    /// One for each of the robot's sensors, in their order.
    pub sensors: Vec<SensorErrors>,
    /// Age of readings with the smallest squared error, s.
    pub age: f64,
    /// Cycles compared, and cycles left out because the body would touch something at the recorded pose.
    pub compared: usize,
    pub left_out: usize,
}

/// Errors of a sensor, as activations.
#[derive(Clone, Debug)]
pub struct SensorErrors {
    pub name: String,
    /// In each range of [`RANGES`], then in all of them.
    pub at: Vec<Errors>,
    /// Pairs of predicted and read activations.
    pub pairs: Vec<[f64; 2]>,
}

/// Errors: read minus predicted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    pub count: usize,
    pub mean: f64,
    pub deviation: f64,
}

impl Errors {
    fn of<'a>(pairs: impl Iterator<Item = &'a [f64; 2]>) -> Self {
        let errors: Vec<f64> = pairs.map(|[predicted, read]| read - predicted).collect();
        Self {
            count: errors.len(),
            mean: mean(&errors),
            deviation: variance(&errors).sqrt(),
        }
    }

    /// The square root of the mean squared error.
    pub fn size(&self) -> f64 {
        self.mean.hypot(self.deviation)
    }
}

/// Ranges of the free distance from the robot's rim to the nearest object, mm, and their names.
pub const RANGES: [(f64, &str); 4] = [
    (10.0, "up to 10 mm"),
    (25.0, "10 to 25 mm"),
    (50.0, "25 to 50 mm"),
    (f64::INFINITY, "more than 50 mm"),
];

/// Maximum number of compared cycles: enough to estimate errors to about one percent, in a few seconds.
const MOST: usize = 5000;
/// Maximum age that is tried, and the step between two, s.
const AGES: (f64, f64) = (0.5, 0.01);

/// A cycle's free distance, and the simulator's readings at the robot's pose, if the robot fits there.
struct Predicted {
    distance: f64,
    readings: Option<Vec<f64>>,
}

impl Readings {
    pub(super) fn of(world: &World, lives: &[Logged], engine: &Engine) -> Result<Self> {
        let lives = chosen(lives);
        let predicted = lives
            .iter()
            .map(|life| predicted(world, life, engine))
            .collect::<Result<Vec<_>>>()?;
        let (oldest, step) = AGES;
        let ages = (0..=(oldest / step) as u32).map(|tried| f64::from(tried) * step);
        let names = world.spec().robot.build.readings();
        let at = |age: f64| pairs(&lives, &predicted, age, names.len());
        let squares = |pairs: &[Vec<(f64, [f64; 2])>]| -> f64 {
            let all: Vec<f64> = pairs
                .iter()
                .flatten()
                .map(|(_, [predicted, read])| (read - predicted) * (read - predicted))
                .collect();
            mean(&all)
        };
        let best = ages
            .map(|age| (age, squares(&at(age))))
            .filter(|(_, error)| error.is_finite());
        let (age, _) = best
            .min_by(|one, other| one.1.total_cmp(&other.1))
            .unwrap_or((0.0, f64::NAN));
        let pairs = at(age);
        let all = || predicted.iter().flatten();
        let left_out = all().filter(|cycle| cycle.readings.is_none()).count();
        Ok(Self {
            compared: all().count() - left_out,
            left_out,
            age,
            sensors: names
                .into_iter()
                .zip(pairs)
                .map(|(name, pairs)| SensorErrors::new(name, &pairs))
                .collect(),
        })
    }

    /// Limits of uniform noise with the mean and the deviation of all errors, without pairs in which both activations are 0.
    pub fn noise(&self) -> [f64; 2] {
        let all: Vec<[f64; 2]> = self
            .sensors
            .iter()
            .flat_map(|sensor| sensor.pairs.iter().copied())
            .collect();
        let something = |pair: &&[f64; 2]| pair.iter().any(|activation| *activation > 0.0);
        let errors = Errors::of(all.iter().filter(something));
        if errors.count < 2 {
            return [0.0; 2];
        }
        let half = half_width(errors.deviation);
        [errors.mean - half, errors.mean + half].map(|limit| limit.clamp(-1.0, 1.0))
    }
}

impl SensorErrors {
    fn new(name: String, pairs: &[(f64, [f64; 2])]) -> Self {
        let mut at = Vec::new();
        let mut low = f64::NEG_INFINITY;
        for (high, _) in RANGES {
            let own = pairs.iter().filter(|(distance, _)| (low..high).contains(distance));
            at.push(Errors::of(own.map(|(_, pair)| pair)));
            low = high;
        }
        let pairs: Vec<[f64; 2]> = pairs.iter().map(|(_, pair)| *pair).collect();
        at.push(Errors::of(pairs.iter()));
        Self { name, at, pairs }
    }
}

/// Whole episodes, evenly chosen, with about as many cycles as are compared.
fn chosen(lives: &[Logged]) -> Vec<&Logged> {
    let cycles: usize = lives.iter().map(|life| life.cycles.len()).sum();
    let every = cycles.div_ceil(MOST).max(1);
    lives.iter().step_by(every).collect()
}

/// For each sensor, the free distance and a pair of predicted and read activations in each cycle. The robot's readings are as old as
/// `age`.
fn pairs(lives: &[&Logged], predicted: &[Vec<Predicted>], age: f64, sensors: usize) -> Vec<Vec<(f64, [f64; 2])>> {
    let mut pairs = vec![Vec::new(); sensors];
    for (life, predicted) in lives.iter().zip(predicted) {
        let mut before = 0;
        for cycle in &life.cycles {
            let then = cycle.time - age;
            while before + 1 < life.cycles.len() && life.cycles[before + 1].time <= then {
                before += 1;
            }
            let (Some(earlier), Some(later)) = (predicted.get(before), predicted.get(before + 1)) else {
                continue;
            };
            let [from, to] = [before, before + 1].map(|index| life.cycles[index].time);
            let (Some(first), Some(second)) = (&earlier.readings, &later.readings) else {
                continue;
            };
            if then < from || to <= from {
                continue;
            }
            let share = (then - from) / (to - from);
            let distance = earlier.distance + share * (later.distance - earlier.distance);
            for (sensor, own) in pairs.iter_mut().enumerate() {
                let predicted = first[sensor] + share * (second[sensor] - first[sensor]);
                own.push((distance, [predicted, cycle.activations[sensor]]));
            }
        }
    }
    pairs
}

/// The simulator's readings at each pose of an episode.
fn predicted(world: &World, life: &Logged, engine: &Engine) -> Result<Vec<Predicted>> {
    let spec = world.spec();
    let standing = |[x, y, heading]: [f64; 3]| {
        let heading = (heading - heading.floor()) as f32;
        World::new(WorldSpec {
            robot: Robot {
                collision: Collision::Undo,
                ..spec.robot.clone()
            },
            noise: Noise::NONE,
            start: Start::At {
                x: x as f32,
                y: y as f32,
                heading: if heading < 1.0 { heading } else { 0.0 },
            },
            cycles: 1,
            ..spec.clone()
        })
        .ok()
    };
    let worlds: Vec<Option<World>> = life.cycles.iter().map(|cycle| standing(cycle.pose)).collect();
    let known: Vec<&World> = worlds.iter().flatten().collect();
    let genes = vec![0.0; world.genes()];
    let rollout = |index| Rollout {
        world: index,
        genes: &genes,
        key: Key::rollout(0, 0, index as u64, 0),
    };
    let rollouts: Vec<_> = (0..known.len()).map(rollout).collect();
    let mut traces = Vec::new();
    if !rollouts.is_empty() {
        let batch = Batch::new(&known, &rollouts, Some(TraceRequest { every: 1 })).map_err(Failure::failed)?;
        traces = engine.evaluate(&batch)?.traces;
    }
    let mut traces = traces.into_iter();
    let real: Vec<usize> = (0..world.details().len())
        .filter(|&detail| world.details()[detail].kind == DetailKind::Real)
        .collect();
    Ok(life
        .cycles
        .iter()
        .zip(&worlds)
        .map(|(cycle, world)| Predicted {
            distance: free_distance(
                &spec.arena,
                spec.robot.body_radius.into(),
                [cycle.pose[0], cycle.pose[1]],
            ),
            readings: world.as_ref().and_then(|_| traces.next()).map(|trace| {
                let details = trace.details(0);
                real.iter()
                    .map(|&detail| f64::from(f32::from_bits(details[detail])))
                    .collect()
            }),
        })
        .collect())
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;

    use oneiro::cpu::Cpu;

    use super::super::Cycle;
    use super::*;

    fn engine() -> Engine {
        Engine::new(Box::new(Cpu::new(Some(1)).unwrap()), Arc::new(AtomicBool::new(false)))
    }

    /// Episodes in the simulator itself, with noise, and readings as old as `late` cycles.
    fn lives(world: &World, noise: Noise, late: usize) -> Vec<Logged> {
        let noisy = World::new(WorldSpec {
            noise,
            ..world.spec().clone()
        })
        .unwrap();
        let genes: Vec<Vec<f32>> = (0..6_u32)
            .map(|life| {
                (0..18)
                    .map(|gene| ((life * 7 + gene * 5) % 11) as f32 * 0.6 - 2.5)
                    .collect()
            })
            .collect();
        let rollouts: Vec<_> = genes
            .iter()
            .zip(0..)
            .map(|(genes, life)| Rollout {
                world: 0,
                genes,
                key: Key::rollout(5, 0, life, 0),
            })
            .collect();
        let batch = Batch::new(&[noisy], &rollouts, Some(TraceRequest { every: 1 })).unwrap();
        let traces = engine().evaluate(&batch).unwrap().traces;
        let life = |trace: &oneiro::batch::Trace| Logged {
            cycles: (late..trace.len())
                .map(|record| Cycle {
                    time: 0.1 * (record - late) as f64,
                    activations: trace.activations(record - late).map(f64::from).into(),
                    commanded: [0.0; 2],
                    travel: None,
                    pose: [trace[record].x, trace[record].y, trace[record].heading].map(f64::from),
                })
                .collect(),
        };
        traces.iter().map(life).collect()
    }

    fn world() -> World {
        World::new(WorldSpec {
            cycles: 200,
            ..WorldSpec::miglino1995()
        })
        .unwrap()
    }

    #[test]
    fn the_simulator_predicts_itself() {
        let world = world();
        let readings = Readings::of(&world, &lives(&world, Noise::NONE, 0), &engine()).unwrap();
        assert_eq!((readings.age, readings.left_out), (0.0, 0));
        assert!(readings.compared >= 1200);
        assert_eq!(readings.noise(), [0.0, 0.0]);
        for sensor in &readings.sensors {
            let all = sensor.at.last().unwrap();
            assert_eq!((all.mean, all.deviation), (0.0, 0.0), "{}", sensor.name);
            assert_eq!(
                all.count,
                sensor.at[..RANGES.len()].iter().map(|own| own.count).sum::<usize>()
            );
        }
        let busy = readings.sensors.iter().filter(|sensor| sensor.at[0].count > 20).count();
        assert_eq!(busy, 8, "near objects");
    }

    #[test]
    fn old_and_noisy_readings_are_found_to_be_so() {
        let world = world();
        let noise = Noise {
            sensor: (-0.1, 0.1),
            ..Noise::NONE
        };
        for late in [0, 2] {
            let readings = Readings::of(&world, &lives(&world, noise, late), &engine()).unwrap();
            assert!((readings.age - 0.1 * late as f64).abs() < 0.015, "{}", readings.age);
            // Negative noise on readings of 0 is cut off.
            let [low, high] = readings.noise();
            assert!(low < -0.02 && high > 0.06 && high < 0.14, "{low} to {high}");
        }
    }

    /// A pose at which the robot can't stand is not compared.
    #[test]
    fn impossible_places_are_left_out_and_counted() {
        let world = world();
        let mut lives = lives(&world, Noise::NONE, 0);
        for cycle in &mut lives[0].cycles[10..30] {
            cycle.pose = [-100.0, 0.0, 0.0];
        }
        let readings = Readings::of(&world, &lives, &engine()).unwrap();
        assert_eq!(readings.left_out, 20);
        assert_eq!(readings.noise(), [0.0, 0.0]);
    }
}
