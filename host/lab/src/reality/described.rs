//! Sampling of a parametric robot: its proximity sensors before an object, at each distance and bearing, and its motion under
//! each pair of speeds. All of it is simulated.
//!
//! A simulator uses a table's cell for all distances and bearings within it, so each is sampled in its middle.

use std::f32::consts::TAU;
use std::sync::Arc;

use oneiro::arena::Arena;
use oneiro::batch::{Batch, Rollout, Trace, TraceRequest};
use oneiro::compose::{Kind, OwnPart, OwnParts, Part};
use oneiro::differential::{Build, Differential, SensorKind};
use oneiro::random::Key;
use oneiro::tables::{GREATEST_READING, MotorSamples, SensorTable, SensorTables};
use oneiro::world::{Controller, Robot, Start, World, WorldSpec};
use oneiro_base::exit::{Failure, Result};

use super::place::{arena, direction, turned};
use super::sampling::{self, BEARINGS, SPACING, SPEEDS};
use super::{Driven, Object, Trouble};
use crate::engine::handle::Engine;

/// A controller with unused genes, whose outputs are values.
const HELD: &str = "\
const CONTROLLER_GENES: u32 = 1u;
struct ControllerValues {
    left: f32, // 0.5, 0 to 1: output for the left wheel
    right: f32, // 0.5, 0 to 1: output for the right wheel
}
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    let own = controller_values(episode);
    return Command(vec2<f32>(own.left, own.right), before);
}
";

/// Maximum range of a sensor, mm.
const MOST_SIGHT: f32 = 10_000.0;
/// Minimum motion in a cycle, mm and turns: smaller ones count as 0.
const LEAST_WAY: f64 = 2e-6;
/// Maximum number of a table's rows.
const MOST_ROWS: f32 = 1000.0;

/// A parametric robot.
#[derive(Debug)]
pub struct Described {
    /// Radius of its body, mm.
    body_radius: f32,
    /// Its proximity sensors and its wheels.
    robot: Differential,
    /// Maximum range of those sensors, from the body's centre, mm.
    sight: f32,
}

impl Described {
    /// The robot of a world.
    ///
    /// # Errors
    /// The values that it lacks for sampling, and what is allowed.
    pub fn new(spec: &WorldSpec) -> std::result::Result<Self, String> {
        let Build::Differential(own) = &spec.robot.build else {
            return Err("its robot.kind is `sampled`; allowed: an experiment with a parametric robot".into());
        };
        let mut robot = own.clone();
        robot.sensors.retain(|sensor| sensor.kind == SensorKind::Proximity);
        if robot.sensors.is_empty() {
            return Err(
                "has no sensor of the kind proximity; allowed: one or more. Only proximity readings depend on an \
                        object's distance and bearing alone: leave other sensors in the experiment unchanged"
                    .into(),
            );
        }
        let body_radius = spec.robot.body_radius;
        let sight = robot
            .sensors
            .iter()
            .map(|sensor| sensor.offset.unwrap_or(body_radius) + sensor.range.unwrap_or(0.0))
            .fold(0.0, f32::max);
        if sight > MOST_SIGHT {
            return Err(format!(
                "has a sensor that reaches {sight} mm from the centre; allowed: up to {MOST_SIGHT}"
            ));
        }
        Ok(Self {
            body_radius,
            robot,
            sight,
        })
    }

    /// One line that says which robot this is.
    pub fn describe(&self) -> String {
        let hash = blake3::hash(format!("{self:?}").as_bytes()).to_hex();
        format!("described robot {}", &hash[..16])
    }

    /// Names of the sensors that are sampled, in the order of the tables' columns.
    pub fn names(&self) -> Vec<&str> {
        self.robot.sensors.iter().map(|sensor| sensor.name.as_str()).collect()
    }

    /// A world for one episode from the point (0, 0) mm, with both outputs held.
    fn held(&self, robot: Differential, arena: Arena, heading: f32, outputs: [f64; 2], cycles: u32) -> Result<World> {
        let part = Part::new(Kind::Controller, "held", HELD).map_err(Failure::failed)?;
        let values = [("left", outputs[0]), ("right", outputs[1])];
        let part = OwnPart::new(Arc::new(part), &values).map_err(Failure::failed)?;
        let spec = WorldSpec {
            robot: Robot {
                body_radius: self.body_radius,
                build: Build::Differential(robot),
                ..Robot::khepera()
            },
            arena,
            controller: Controller::Own,
            own: OwnParts::from([part]),
            start: Start::At {
                x: 0.0,
                y: 0.0,
                heading,
            },
            cycles,
            ..WorldSpec::miglino1995()
        };
        World::new(spec).map_err(Failure::failed)
    }

    /// Samples its sensors before each object, from the rim to their range: rows of 2 mm, or of the fewest whole mm that need at
    /// most 1000 rows.
    ///
    /// # Errors
    /// Those of the device.
    pub fn sensors(&self, engine: &Engine, objects: &[Object]) -> Result<SensorTables> {
        let reach = self.sight - self.body_radius;
        let spacing = SPACING.max((reach / MOST_ROWS).ceil());
        let rows = (reach / spacing).ceil().clamp(1.0, MOST_ROWS) as u32;
        let tables = objects.iter().map(|object| self.table(engine, object, rows, spacing));
        Ok(SensorTables::new(tables.collect::<Result<_>>()?))
    }

    fn table(&self, engine: &Engine, object: &Object, rows: u32, spacing: f32) -> Result<SensorTable> {
        // It turns on the spot by a bearing a cycle, whatever wheels the robot has.
        const BASE: f32 = 10.0;
        let turning = Differential {
            sensors: self.robot.sensors.clone(),
            ..Differential::new(BASE, 10.0 * 0.5 * TAU * BASE / BEARINGS as f32)
        };
        let views = object.views();
        // Rays meet it within their range.
        let half_wall = self.sight + 1000.0;
        let worlds = (0..views * rows).map(|row| {
            let gap = ((row % rows) as f32 + 0.5) * spacing;
            let view = (f64::from(row / rows) + 0.5) / f64::from(2 * views);
            let field = Arena::rectangle(1000.0, 1000.0).field;
            let arena = arena(object, view, [0.0; 2], &[self.body_radius, gap], half_wall, field);
            let first = 0.5 / BEARINGS as f32;
            self.held(turning.clone(), arena, first, [0.0, 1.0], BEARINGS)
        });
        let worlds: Vec<World> = worlds.collect::<Result<_>>()?;
        let count = self.robot.sensors.len();
        let mut readings = Vec::new();
        for trace in lived(engine, &worlds)? {
            for (_, details) in trace.lines() {
                let shares = details[count..2 * count].iter().map(|word| f32::from_bits(*word));
                let greatest = f64::from(GREATEST_READING);
                readings.extend(shares.map(|share| (f64::from(share) * greatest + 0.5) as u16));
            }
        }
        Ok(SensorTable {
            class: object.class.clone(),
            sensors: count as u32,
            rows,
            bearings: BEARINGS,
            nearest: 0.0,
            spacing,
            views,
            readings,
        })
    }

    /// Samples the motion under each pair of speeds, tenths of the maximum, once wheels have reached them; none if the motors are
    /// already sampled. The displacement is the distance from start to end.
    ///
    /// # Errors
    /// Exit 3 if it can turn by half a turn or more in a cycle; those of the device.
    pub fn motors(&self, engine: &Engine) -> Result<Option<MotorSamples>> {
        let (Some(base), Some(speed)) = (self.robot.wheel_base, self.robot.greatest_speed) else {
            return Ok(None);
        };
        if 0.2 * speed >= 0.5 * TAU * base {
            return Err(Failure::input(format_args!(
                "the robot can turn by {} turns in a cycle; allowed: less than 0.5, as tables of motors have it",
                0.2 * speed / (TAU * base)
            )));
        }
        let robot = Differential {
            sensors: Vec::new(),
            acceleration: None,
            latency: None,
            battery: None,
            battery_ends_life: None,
            ..self.robot.clone()
        };
        let open = Arena {
            walls: Vec::new(),
            ..Arena::rectangle(1000.0, 1000.0)
        };
        let output = |speed: i32| f64::from(speed + 10) / 20.0;
        let pairs = SPEEDS.flat_map(|left| SPEEDS.map(move |right| [left, right].map(output)));
        let worlds = pairs.map(|outputs| self.held(robot.clone(), open.clone(), 0.0, outputs, 2));
        let worlds: Vec<World> = worlds.collect::<Result<_>>()?;
        let driven: Vec<Driven> = lived(engine, &worlds)?.iter().map(driven).collect();
        let rows: Vec<Vec<Driven>> = driven.chunks(SPEEDS.count()).map(<[_]>::to_vec).collect();
        Ok(Some(sampling::motors(&rows)))
    }
}

/// The first cycle's motion: along the chord of its arc.
fn driven(trace: &Trace) -> Driven {
    let turn = turned(trace[0].heading, trace[1].heading);
    let [along_x, along_y] = direction(0.5 * turn);
    let displacement = f64::from(trace[1].x) * along_x + f64::from(trace[1].y) * along_y;
    // Roundings of opposite speeds; a world allows no such small numbers.
    let [displacement, turn] = [displacement, turn].map(|way| if way.abs() < LEAST_WAY { 0.0 } else { way });
    Driven { displacement, turn }
}

/// A traced episode in each world.
fn lived(engine: &Engine, worlds: &[World]) -> Result<Vec<Trace>> {
    let rollout = |(world, index)| Rollout {
        world,
        genes: &[0.0],
        key: Key::rollout(0, 0, index, 0),
    };
    let rollouts: Vec<_> = (0..worlds.len()).zip(0..).map(rollout).collect();
    let batch = Batch::new(worlds, &rollouts, Some(TraceRequest { every: 1 })).map_err(Failure::failed)?;
    let outcome = engine.evaluate(&batch).map_err(Trouble::from)?;
    Ok(outcome.traces)
}
