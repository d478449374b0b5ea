//! The surrogate of a Khepera as a reality: every call is a batch for an evaluator.

use std::sync::Arc;

use oneiro::arena::{Arena, Field};
use oneiro::batch::{Batch, Rollout, Trace, TraceRequest};
use oneiro::random::{Key, pcg4d};
use oneiro::surrogate::Surrogate;
use oneiro::tables::{MotorStates, MotorTable, SensorTable, SensorTables};
use oneiro::world::{Controller, Robot, Start, World, WorldSpec};

use super::place::{arena, direction, turned};
use super::{Driven, Life, Lived, Object, Reality, Sampled, Shape, Trouble, Turned};
use crate::engine::handle::Engine;

/// A surrogate in its world, and on the sampling table.
pub(super) struct SurrogateRobot<'a> {
    engine: &'a Engine,
    surrogate: Arc<Surrogate>,
    seed: u64,
    /// The world of its episodes.
    world: World,
    /// Position in the light field where objects are sampled.
    place: [f32; 2],
    /// Number of episodes that sampling has taken so far: their keys continue from it.
    sampled: u64,
}

impl<'a> SurrogateRobot<'a> {
    /// The robot and surroundings of `surrogate`, which must be the world's.
    pub(super) fn new(engine: &'a Engine, seed: u64, surrogate: Arc<Surrogate>, world: World) -> Self {
        let Field { x, y, width, height } = world.spec().arena.field;
        let [across, up, ..] = pcg4d([seed as u32, (seed >> 32) as u32, u32::MAX, 0]);
        let share = |word: u32| (word >> 8) as f32 / (1 << 24) as f32;
        Self {
            engine,
            surrogate,
            seed,
            world,
            place: [x + width * share(across), y + height * share(up)],
            sampled: 0,
        }
    }

    /// The world of episodes from a given start, or from a random one, with a cycle more for a trace.
    fn started(&self, start: Option<[f32; 3]>, traced: bool) -> Result<World, Trouble> {
        if start.is_none() && !traced {
            return Ok(self.world.clone());
        }
        let mut spec = self.world.spec().clone();
        if let Some([x, y, heading]) = start {
            spec.start = Start::At { x, y, heading };
        }
        if traced {
            spec = spec.seen_to_its_end();
        }
        World::new(spec).map_err(|invalid| Trouble::Broken(invalid.to_string()))
    }

    /// The grid on which an object is sampled, instead of its future table.
    fn grid(&self, object: &Object) -> Arc<SensorTables> {
        let mut grid = SensorTable {
            class: object.class.clone(),
            views: object.views(),
            ..self.world.spec().robot.sensors.classes[0].clone()
        };
        grid.readings = vec![0; grid.cells() * grid.sensors as usize];
        Arc::new(SensorTables::new(vec![grid]))
    }

    /// Runs one episode from a pose, the wheels held at two speeds.
    fn held(
        &mut self,
        sensors: Arc<SensorTables>,
        arena: Arena,
        start: Start,
        speeds: (i32, i32),
        cycles: u32,
    ) -> Result<Trace, Trouble> {
        let genes = holding(speeds).ok_or_else(|| {
            let (left, right) = speeds;
            Trouble::Broken(format!("speeds {left} and {right}; allowed: -10 to 10"))
        })?;
        let world = World::new(WorldSpec {
            robot: Robot {
                sensors,
                motors: MotorTable::khepera(MotorStates::Evorobot21),
                ..self.world.spec().robot.clone()
            },
            surrogate: Some(Arc::clone(&self.surrogate)),
            arena,
            start,
            controller: Controller::Perceptron,
            cycles,
            ..WorldSpec::miglino1995()
        })
        .map_err(|invalid| Trouble::Broken(invalid.to_string()))?;
        let rollout = Rollout {
            world: 0,
            genes: &genes,
            key: Key::rollout(self.seed, u64::MAX, self.sampled, 0),
        };
        self.sampled += 1;
        let outcome = self.engine.evaluate(&one_batch(&[world], &[rollout], true)?)?;
        Ok(outcome.traces.into_iter().next().unwrap_or_default())
    }
}

/// Makes a batch of valid episodes, which can only be too large.
fn one_batch(worlds: &[World], rollouts: &[Rollout<'_>], traced: bool) -> Result<Batch, Trouble> {
    let trace = traced.then_some(TraceRequest { every: 1 });
    Batch::new(worlds, rollouts, trace).map_err(|invalid| Trouble::Broken(invalid.to_string()))
}

/// Genes that hold the wheels at two of the speeds -10 to 10, whatever the sensors read.
fn holding((left, right): (i32, i32)) -> Option<Vec<f32>> {
    let bias = |speed: i32| {
        if !(-10..=10).contains(&speed) {
            return None;
        }
        // In the middle of the outputs that round to the state, so that rounding of the logistic doesn't matter.
        let output = ((f64::from(speed) + 10.0) / 20.0).clamp(0.001, 0.999);
        Some((output / (1.0 - output)).ln() as f32)
    };
    let mut genes = vec![0.0; Controller::Perceptron.layout().genes()];
    (genes[8], genes[17]) = (bias(left)?, bias(right)?);
    Some(genes)
}

/// Readings of a record as the integers that the robot gave.
fn readings(trace: &Trace, record: usize) -> Vec<u16> {
    let readings = trace.activations(record);
    readings
        .map(|activation| (f64::from(activation) * 1023.0 + 0.5) as u16)
        .into()
}

impl Sampled for SurrogateRobot<'_> {
    fn describe(&self) -> String {
        format!("surrogate:{}, {}", self.seed, self.surrogate.differences)
    }

    fn turn_before(&mut self, object: &Object, view: f64, gap: f32) -> Result<Vec<Turned>, Trouble> {
        // At the slowest turn on the spot, 1.8 degrees a cycle, and one bearing's worth more than once around.
        const CYCLES: u32 = 230;
        /// Rounding never brings the robot into the row below.
        const MARGIN: f32 = 0.01;
        /// Farther than any robot sees.
        const HALF_WALL: f32 = 1000.0;
        let spec = self.world.spec();
        let [x, y] = self.place;
        let apart = [spec.robot.body_radius, gap, MARGIN];
        let arena = arena(object, view, self.place, &apart, HALF_WALL, spec.arena.field);
        let heading = match object.shape {
            Shape::Wall | Shape::Round { .. } => 0.0,
            // A block's nearest point is straight ahead except for rounding, so this keeps readings off the edges
            // between bearings.
            Shape::Block { .. } => 0.001,
        };
        let start = Start::At { x, y, heading };
        let trace = self.held(self.grid(object), arena, start, (-1, 1), CYCLES)?;
        // The object lies in the direction 0, so that its bearing, clockwise, is the heading.
        let moment = |record: usize| Turned {
            bearing: f64::from(trace[record].heading),
            readings: readings(&trace, record),
        };
        Ok((0..trace.len()).map(moment).collect())
    }

    /// The keys of episodes are counted.
    fn leave_out(&mut self, turns: u32, drives: u32) {
        self.sampled += u64::from(turns) + u64::from(drives);
    }

    fn drive(&mut self, speeds: (i32, i32)) -> Result<Driven, Trouble> {
        /// Enough for wheels with any allowed lag to reach their speeds.
        const CYCLES: u32 = 22;
        let arena = Arena {
            name: "open".into(),
            walls: Vec::new(),
            ..Arena::rectangle(1000.0, 1000.0)
        };
        let start = Start::At {
            x: 500.0,
            y: 500.0,
            heading: 0.0,
        };
        let sensors = Arc::clone(&self.world.spec().robot.sensors);
        let trace = self.held(sensors, arena, start, speeds, CYCLES)?;
        let [.., before, after] = &trace[..] else {
            return Err(Trouble::Broken("an episode without a trace".into()));
        };
        let [along_x, along_y] = direction(f64::from(before.heading));
        let (x, y) = (f64::from(after.x - before.x), f64::from(after.y - before.y));
        Ok(Driven {
            displacement: x * along_x + y * along_y,
            turn: turned(before.heading, after.heading),
        })
    }
}

impl Reality for SurrogateRobot<'_> {
    fn describe(&self) -> String {
        Sampled::describe(self)
    }

    fn live_each(
        &mut self,
        lives: &[Life<'_>],
        traced: bool,
        on_lived: &(dyn Fn(usize, &Lived) + Sync),
    ) -> Result<Vec<Lived>, Trouble> {
        let cycles = self.world.cycles();
        let mut starts: Vec<Option<[f32; 3]>> = Vec::new();
        let mut worlds = Vec::new();
        let mut rollouts = Vec::with_capacity(lives.len());
        for life in lives {
            let world = if let Some(known) = starts.iter().rposition(|start| *start == life.start) {
                known
            } else {
                starts.push(life.start);
                worlds.push(self.started(life.start, traced)?);
                worlds.len() - 1
            };
            rollouts.push(Rollout {
                world,
                genes: life.genes,
                key: life.key,
            });
        }
        let outcome = self.engine.evaluate(&one_batch(&worlds, &rollouts, traced)?)?;
        let quiet = |fitness| Lived {
            fitness,
            trace: Trace::default(),
        };
        let shown = |trace: Trace| Lived {
            fitness: trace.get(cycles as usize - 1).map_or(0.0, |last| last.fitness),
            trace,
        };
        let lived: Vec<Lived> = if traced {
            outcome.traces.into_iter().map(shown).collect()
        } else {
            outcome.fitness.into_iter().map(quiet).collect()
        };
        for (number, lived) in lived.iter().enumerate() {
            on_lived(number, lived);
        }
        Ok(lived)
    }
}
