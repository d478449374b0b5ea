//! Foraging e-pucks, as in O'Dowd, Studley and Winfield, "The distributed co-evolution of an on-board simulator and
//! controller for swarm robot behaviours", Evolutionary Intelligence 7(2), 2014: the on-board simulator in which one
//! robot acts for its minute.
//!
//! The arena is a circle around the origin, with the nest at its left edge: x to the right and y up. A forager has two
//! genes, `G0` while it carries food and `G1` while it doesn't, from 0 to 0.99: below 0.33 it flees the light, from
//! 0.66 it seeks it, and in between it searches at random (Table 1). Obstacle avoidance takes precedence.

use std::sync::LazyLock;

/// Details of a record in a forager's trace: the readings of the four sensors in front, from the left, as a fraction of the
/// maximum; the behaviour's number; and 1 if it carries food.
pub use oneiro_shaders::forager::Details;
use oneiro_shaders::{Kernel, episode, forager};

use crate::batch::{Buffers, WorldKind};
use crate::cells::Cells;
use crate::exact::cosine;
use crate::genes::Gene;
use crate::parameter::Allowed::{Number, NumberUpTo, Whole};
use crate::parameter::{self, Choice, Choices, Invalid, Parameter, integer, number, row};

/// Names of a forager's readings: sensors of proximity and of light by their bearings, degrees to the left and to the right, and
/// whether it carries food.
pub const READINGS: [&str; 13] = [
    "near_left_17",
    "near_left_50",
    "near_right_50",
    "near_right_17",
    "light_left_17",
    "light_left_50",
    "light_right_50",
    "light_right_17",
    "light_left_90",
    "light_left_150",
    "light_right_150",
    "light_right_90",
    "carries",
];

/// Distances, mm, and what a sensor of proximity reads there, 0 to 1.
#[cfg(feature = "compose")]
pub(crate) fn proximity_points() -> [[f64; 2]; 11] {
    std::array::from_fn(|at| {
        let (distance, reading, _) = PROXIMITY[at];
        [distance, reading / GREATEST_PROXIMITY]
    })
}

/// Most items of food in an arena.
pub const GREATEST_ITEMS: u32 = forager::GREATEST_ITEMS;

/// Genes of a forager: `G0` and `G1`.
pub const GENES: usize = forager::FORAGER_GENES as usize;

/// Names of the genes, and their range.
pub(crate) fn genes() -> Vec<Gene> {
    let gene = |name: &str| Gene::ranged(name.to_owned(), Some([0.0, 0.99]));
    ["with_food", "without_food"].map(gene).into()
}

/// Duration of a cycle in seconds.
const CYCLE: f64 = 0.1;
/// Radians of a turn.
const TURN: f64 = 2.0 * std::f64::consts::PI;

/// Readings of an e-puck's proximity sensor by distance, of 4095, and the standard deviation of its noise as a fraction of
/// the reading (the table of Webots' e-puck, calibrated on a robot): mm, reading, share.
const PROXIMITY: [(f64, f64, f64); 12] = [
    (0.0, 4095.0, 0.002),
    (5.0, 2133.0, 0.003),
    (10.0, 1466.0, 0.007),
    (15.0, 601.0, 0.041),
    (20.0, 384.0, 0.015),
    (30.0, 235.0, 0.024),
    (40.0, 158.0, 0.029),
    (50.0, 120.0, 0.042),
    (60.0, 104.0, 0.031),
    (70.0, 67.0, 0.049),
    // Beyond this, readings can't be distinguished from noise.
    (70.0, 0.0, 0.0),
    (80.0, 0.0, 0.0),
];
const GREATEST_PROXIMITY: f64 = 4095.0;
/// Range of the sensor, mm.
const SIGHT: u32 = forager::CURVE_ENTRIES;

/// Bearings of the eight sensors, degrees counter-clockwise from the heading (ARGoS, GCtronic). The first four are
/// those that obstacle avoidance checks first.
const BEARINGS: [f64; 8] = [17.0, 50.0, -50.0, -17.0, 90.0, 150.0, 210.0, 270.0];

/// Position of the light, seen from the nest: Figure 2 of the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Light {
    /// Behind the nest.
    OverNest,
    /// No light.
    Nowhere,
    /// On the other side of the arena.
    OppositeNest,
}

impl Light {
    /// Scenario that a simulator's gene `S0` selects by thirds of its hundredths: opposite, nowhere, over the nest
    /// (Table 2). The gene must be from 0 to 0.99.
    pub fn of_gene(s0: f32) -> Self {
        match (100.0 * s0) as u32 {
            0..33 => Self::OppositeNest,
            33..66 => Self::Nowhere,
            _ => Self::OverNest,
        }
    }
}

impl Choice for Light {
    const CHOICES: Choices<Self> = &[
        ("over_nest", Self::OverNest, "behind the nest"),
        ("nowhere", Self::Nowhere, "there is none"),
        ("opposite_nest", Self::OppositeNest, "on the other side of the arena"),
    ];
}

/// One foraging robot and everything about its world: lengths in mm, speeds in mm/s and rad/s, times in s.
/// [`parameters`] has the source of each value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foraging {
    /// Radius of the arena.
    pub arena_radius: f32,
    /// Radius of the nest, whose centre is on the wall.
    pub nest_radius: f32,
    /// Number of food items in the arena at all times, up to [`GREATEST_ITEMS`].
    pub food_items: u32,
    /// Distance from its centre within which a robot takes an item.
    pub food_radius: f32,
    /// Scenario.
    pub light: Light,
    /// Distance of the lamp behind the wall.
    pub lamp_behind_wall: f32,
    /// The light fades as `exp(-decay * metres)`.
    pub light_decay: f32,
    /// Sensor reading without any lamp, of 1.
    pub ambient: f32,
    /// Uniform noise of each light reading, plus or minus this.
    pub light_noise: f32,
    /// Radius of the body.
    pub body_radius: f32,
    /// Distance between the wheels.
    pub wheel_base: f32,
    /// Maximum speed of a wheel.
    pub greatest_speed: f32,
    /// Uniform noise of each wheel's travel in a cycle, as a fraction.
    pub wheel_noise: f32,
    /// Speed when going straight.
    pub cruise: f32,
    /// Speed of turns on the spot, rad/s.
    pub turn: f32,
    /// Speed of phototactic turns, rad/s for each rad off the light.
    pub phototaxis_gain: f32,
    /// Maximum speed of phototactic turns, rad/s.
    pub phototaxis_turn: f32,
    /// Reading of its brightest light sensor below which a robot searches at random instead of phototaxis; 0: phototaxis
    /// always acts.
    pub phototaxis_threshold: f32,
    /// Distance of a wall below which a robot turns away.
    pub near: f32,
    /// Time for which it goes straight after the wall is clear, s.
    pub escape: f32,
    /// Mean time between the turns of random search, s.
    pub search_interval: f32,
    /// Start of the robot: x, y, and heading in turns. `None`: a random free pose.
    pub start: Option<[f32; 3]>,
    /// Cycles of 100 ms: 600, a minute (paper). Collected food earns the time that remains.
    pub cycles: u32,
}

/// What may have a forager's values.
pub trait AsForaging {
    /// They, if it has them.
    fn as_foraging(&mut self) -> Option<&mut Foraging>;
}

/// Rows of the values that experiments can set.
#[rustfmt::skip]
pub fn parameters<T: AsForaging>() -> Vec<Parameter<T>> {
    vec![
        row("arena.radius_mm", "mm", Number(100.0, 10_000.0), "O'Dowd et al. 2014, section 4.5",
            "Radius of the arena.", |spec, _| Some(&mut spec.as_foraging()?.arena_radius)),
        row("arena.nest_radius_mm", "mm", NumberUpTo(10.0, 1.0, "arena.radius_mm"), "O'Dowd et al. 2014, section 4.5; its centre on the wall is ours",
            "Radius of the nest, whose centre is on the wall.", |spec, _| Some(&mut spec.as_foraging()?.nest_radius)),
        row("arena.food_items", "", Whole(0, GREATEST_ITEMS.into()), "O'Dowd et al. 2014, section 4.5",
            "Items of food in the arena at all times.", |spec, _| Some(&mut spec.as_foraging()?.food_items)),
        row("arena.food_radius_mm", "mm", NumberUpTo(1.0, 1.0, "arena.radius_mm"), "ours: no size in O'Dowd et al. 2014, section 4.5",
            "Distance from a robot's centre at which it takes an item.", |spec, _| Some(&mut spec.as_foraging()?.food_radius)),
        row("arena.lamp_behind_wall_mm", "mm", Number(10.0, 10_000.0), "ours",
            "Distance of the lamp behind the wall.", |spec, _| Some(&mut spec.as_foraging()?.lamp_behind_wall)),
        row("arena.light_decay", "1/m", Number(0.001, 1000.0), "ARGoS; arms",
            "The light fades as exp(-decay * metres).", |spec, _| Some(&mut spec.as_foraging()?.light_decay)),
        row("arena.ambient", "", Number(0.0, 1.0), "ours",
            "Reading of light sensors without a lamp, from 0 to 1.", |spec, _| Some(&mut spec.as_foraging()?.ambient)),
        row("arena.light_noise", "", Number(0.0, 1.0), "ARGoS' form, our size; arms",
            "Uniform noise of each light reading, plus and minus.", |spec, _| Some(&mut spec.as_foraging()?.light_noise)),
        row("robot.body_radius_mm", "mm", NumberUpTo(1.0, 0.5, "arena.radius_mm"), "ARGoS, GCtronic",
            "Radius of the body.", |spec, _| Some(&mut spec.as_foraging()?.body_radius)),
        row("robot.wheel_base_mm", "mm", NumberUpTo(1.0, 2.0, "robot.body_radius_mm"), "ARGoS, GCtronic",
            "Distance of the wheels.", |spec, _| Some(&mut spec.as_foraging()?.wheel_base)),
        row("robot.greatest_speed_mm_s", "mm/s", Number(1.0, 1000.0), "Webots, GCtronic",
            "Maximum speed of a wheel.", |spec, _| Some(&mut spec.as_foraging()?.greatest_speed)),
        row("robot.wheel_noise", "", Number(0.0, 0.5), "Enki",
            "Uniform noise of each wheel's travel in a cycle, as a fraction.", |spec, _| Some(&mut spec.as_foraging()?.wheel_noise)),
        row("robot.cruise_mm_s", "mm/s", NumberUpTo(0.0, 1.0, "robot.greatest_speed_mm_s"), "ours; arms",
            "Speed straight on.", |spec, _| Some(&mut spec.as_foraging()?.cruise)),
        row("robot.turn_rad_s", "rad/s", Number(0.01, 30.0), "ours",
            "Speed of turns on the spot.", |spec, _| Some(&mut spec.as_foraging()?.turn)),
        row("robot.phototaxis_gain", "1/s", Number(0.0, 10.0), "ours",
            "Phototaxis turns by this many rad/s for each rad between heading and light.", |spec, _| Some(&mut spec.as_foraging()?.phototaxis_gain)),
        row("robot.phototaxis_turn_rad_s", "rad/s", Number(0.0, 30.0), "ours",
            "Maximum speed of its turns.", |spec, _| Some(&mut spec.as_foraging()?.phototaxis_turn)),
        row("robot.phototaxis_threshold", "", Number(0.0, 1.0), "ours: 0, it always acts; of swarms what darkness never reaches: \"random movement behaviour in the absence of a light source\" in O'Dowd et al. 2014, section 5.6; arms",
            "Phototaxis acts if the brightest light sensor reads at least this, from 0 to 1; else the robot searches at random.", |spec, _| Some(&mut spec.as_foraging()?.phototaxis_threshold)),
        row("robot.near_mm", "mm", Number(0.0, SIGHT.into()), "ours",
            "A robot turns away from what is nearer than this.", |spec, _| Some(&mut spec.as_foraging()?.near)),
        row("robot.escape_s", "s", Number(0.0, 1000.0), "ours; arms",
            "Time that it drives straight on after avoiding an obstacle.", |spec, _| Some(&mut spec.as_foraging()?.escape)),
        row("robot.search_interval_s", "s", Number(0.0, 1000.0), "ours",
            "Mean time between the turns of random search.", |spec, _| Some(&mut spec.as_foraging()?.search_interval)),
    ]
}

static PARAMETERS: LazyLock<Vec<Parameter<Foraging>>> = LazyLock::new(parameters);

impl AsForaging for Foraging {
    fn as_foraging(&mut self) -> Option<&mut Foraging> {
        Some(self)
    }
}

/// What a forager wants to drive in a cycle of 100 ms.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Drive {
    /// Way of its centre, mm.
    pub forward: f32,
    /// Turns, counter-clockwise.
    pub turn: f32,
}

impl Drive {
    /// Speeds of the left and of the right wheel that drive it, mm/s. None is faster than the robot's wheels are, as in the simulator;
    /// these have no noise.
    pub fn wheels(&self, robot: &Foraging) -> [f32; 2] {
        let body = robot.body();
        let apart = body.half_turn_path * self.turn;
        [self.forward - apart, self.forward + apart].map(|way| {
            let way = way.clamp(-body.farthest, body.farthest);
            (f64::from(way) / CYCLE) as f32
        })
    }

    /// What wheels drive at these speeds of the left and of the right one, mm/s: the inverse of [`Drive::wheels`], to rounding.
    pub fn of_wheels(speeds: [f32; 2], robot: &Foraging) -> Self {
        let [left, right] = speeds.map(|speed| f64::from(speed) * CYCLE);
        Self {
            forward: (0.5 * (left + right)) as f32,
            turn: ((right - left) / (TURN * f64::from(robot.wheel_base))) as f32,
        }
    }
}

impl Foraging {
    /// The on-board simulator of the 2014 study, in one scenario.
    ///
    /// ```
    /// use oneiro::batch::{Rollout, Worlds};
    /// use oneiro::cpu::Cpu;
    /// use oneiro::evaluator::{Control, Evaluator};
    /// use oneiro::foraging::{Foraging, Light};
    /// use oneiro::random::Key;
    ///
    /// let worlds = Worlds::new(&[Foraging::odowd2014(Light::OverNest)])?;
    /// // To the light with food, away from it without.
    /// let genes = [0.99, 0.0];
    /// let episode = |i| Rollout { world: 0, genes: &genes, key: Key::rollout(1, 0, i, 0) };
    /// let episodes: Vec<_> = (0..100).map(episode).collect();
    /// let outcome = Cpu::new(None)?.evaluate(&worlds.batch(&episodes, None)?, &Control::new())?;
    /// assert!(outcome.fitness.iter().sum::<f32>() > 0.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub const fn odowd2014(light: Light) -> Self {
        Self {
            arena_radius: 600.0,
            nest_radius: 200.0,
            food_items: 7,
            food_radius: 50.0,
            light,
            lamp_behind_wall: 100.0,
            light_decay: 2.0,
            ambient: 0.1,
            light_noise: 0.05,
            body_radius: 35.0,
            wheel_base: 53.0,
            greatest_speed: 128.8,
            wheel_noise: 0.05,
            cruise: 80.0,
            turn: 2.0,
            phototaxis_gain: 3.0,
            phototaxis_turn: 2.4,
            phototaxis_threshold: 0.0,
            near: 30.0,
            escape: 1.0,
            search_interval: 3.0,
            start: None,
            cycles: 600,
        }
    }

    /// Whether its items need the kernel with more room for food.
    pub(crate) fn has_many_items(&self) -> bool {
        self.food_items > forager::FOOD_ROOM
    }

    /// The world in the kernel's form, before its cells have a position.
    pub(crate) fn world(&self) -> episode::World {
        let radius = self.arena_radius;
        let [start_x, start_y, start_heading] = self.start.unwrap_or_default();
        episode::World {
            steps: self.cycles,
            field_x: -radius,
            field_y: -radius,
            field_width: 2.0 * radius,
            field_height: 2.0 * radius,
            zone_x: -radius,
            zone_y: -radius,
            zone_width: 2.0 * radius,
            zone_height: 2.0 * radius,
            random_start: u32::from(self.start.is_none()),
            start_x,
            start_y,
            start_heading,
            ..episode::World::default()
        }
    }

    /// The kernel's cell of its body and its wheels.
    fn body(&self) -> forager::RobotCell {
        let of = f64::from;
        forager::RobotCell {
            radius: in_kernel(of(self.body_radius)),
            half_turn_path: in_kernel(0.5 * TURN * of(self.wheel_base)),
            farthest: in_kernel(of(self.greatest_speed) * CYCLE),
            wheel_noise: in_kernel(of(self.wheel_noise)),
        }
    }

    /// The kernel's cells of these values, `count` of them; food earns the time that remains of `seconds` seconds.
    pub(crate) fn cells(&self, count: u32, robots: u32, seconds: f64) -> Cells {
        let of = f64::from;
        let (arena, nest, food) = (of(self.arena_radius), of(self.nest_radius), of(self.food_radius));
        let lamp = arena + of(self.lamp_behind_wall);
        let (lamp_x, shines) = match self.light {
            Light::OverNest => (-lamp, 1.0),
            Light::Nowhere => (0.0, 0.0),
            Light::OppositeNest => (lamp, 1.0),
        };
        let turns_per_cycle = |radians_per_second: f32| in_kernel(of(radians_per_second) * CYCLE / TURN);
        let mut cells = Cells::new(count);
        cells.put(
            forager::NEST,
            forager::NestCell {
                x: in_kernel(-arena),
                y: 0.0,
                squared_radius: in_kernel(nest * nest),
                squared_reach: in_kernel(food * food),
            },
        );
        cells.put(
            forager::LAMP,
            forager::LampCell {
                x: in_kernel(lamp_x),
                y: 0.0,
                decay: in_kernel(of(self.light_decay) / 1000.0),
                shines,
            },
        );
        cells.put(
            forager::SENSING,
            forager::SensingCell {
                ambient: in_kernel(of(self.ambient)),
                light_noise: in_kernel(of(self.light_noise)),
                sight: SIGHT as f32,
                entries_per_mm: 1.0,
            },
        );
        cells.put(forager::ROBOT, self.body());
        cells.put(
            forager::DRIVING,
            forager::DrivingCell {
                cruise: in_kernel(of(self.cruise) * CYCLE),
                turn: turns_per_cycle(self.turn),
                gain: in_kernel(of(self.phototaxis_gain) * CYCLE),
                greatest_turn: turns_per_cycle(self.phototaxis_turn),
            },
        );
        cells.put(
            forager::TIMES,
            forager::TimesCell {
                straight: in_kernel((of(self.escape) / CYCLE).round()),
                interval: in_kernel(of(self.search_interval) / CYCLE),
                near: in_kernel(proximity(of(self.near)).0),
                limit: in_kernel(seconds),
            },
        );
        cells.put(
            forager::ARENA,
            forager::ArenaCell {
                radius: in_kernel(arena),
                cycle: in_kernel(CYCLE),
                items: self.food_items as f32,
                robots: robots as f32,
            },
        );
        cells.put(
            forager::PHOTOTAXIS,
            forager::PhototaxisCell {
                threshold: in_kernel(of(self.phototaxis_threshold)),
                ..forager::PhototaxisCell::default()
            },
        );
        for (axes, four) in (forager::AXES..).step_by(2).zip(BEARINGS.as_chunks::<4>().0) {
            cells.put(axes, four.map(|degrees| in_kernel(cosine(degrees))));
            cells.put(axes + 1, four.map(|degrees| in_kernel(cosine(degrees - 90.0))));
        }
        for (pair, mm) in (forager::CURVE..).zip((0..SIGHT).step_by(2)) {
            let [here, next] = [mm, mm + 1].map(|mm| proximity(f64::from(mm) + 0.5));
            cells.put(
                pair,
                forager::CurveCell {
                    reading: in_kernel(here.0),
                    noise: in_kernel(here.1),
                    next_reading: in_kernel(next.0),
                    next_noise: in_kernel(next.1),
                },
            );
        }
        cells
    }
}

impl WorldKind for Foraging {
    fn check(&self) -> Result<(), Invalid> {
        parameter::check(&PARAMETERS, &mut self.clone())?;
        integer("cycles", self.cycles, 1..=1_000_000)?;
        let Some([x, y, heading]) = self.start else {
            return Ok(());
        };
        number("start.heading", heading, 0.0..=1.0)?;
        let room = self.arena_radius - self.body_radius;
        // NaN isn't inside.
        if x * x + y * y < room * room && heading < 1.0 {
            return Ok(());
        }
        let problem = format!(
            "is ({x}, {y}) mm, heading {heading} turns; allowed: within {room} mm of the origin, turns from 0 to less than 1"
        );
        Err(Invalid::new("start", problem))
    }

    fn kernel(&self) -> &'static Kernel {
        if self.has_many_items() {
            &oneiro_shaders::FORAGER_MANY
        } else {
            &oneiro_shaders::FORAGER
        }
    }

    fn genes(&self) -> usize {
        GENES
    }

    fn pack(&self, _: usize, buffers: &mut Buffers) -> episode::World {
        let numbers = buffers.add_table(
            self.cells(forager::FORAGER_CELLS, 1, f64::from(self.cycles) * CYCLE)
                .into_table(),
        );
        episode::World {
            numbers,
            ..self.world()
        }
    }
}

/// Converts a number to the kernels' form.
pub(crate) fn in_kernel(number: f64) -> f32 {
    // Zero has one sign, and no other number is too close to zero.
    if number.abs() < 1e-9 { 0.0 } else { number as f32 }
}

/// Reading of a proximity sensor at a distance in mm, of 1, and its noise as a fraction of the reading.
fn proximity(distance: f64) -> (f64, f64) {
    let after = PROXIMITY
        .partition_point(|(at, ..)| *at <= distance)
        .clamp(1, PROXIMITY.len() - 1);
    let [(near, here, noise), (far, there, other)] = [PROXIMITY[after - 1], PROXIMITY[after]];
    let share = if far > near {
        (distance - near) / (far - near)
    } else {
        0.0
    };
    let between = |a: f64, b: f64| a + share.min(1.0) * (b - a);
    (between(here, there) / GREATEST_PROXIMITY, between(noise, other))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_goes_through_its_points() {
        for (distance, reading) in [(0.0, 4095.0), (2.5, 3114.0), (30.0, 235.0), (35.0, 196.5), (75.0, 0.0)] {
            assert!(
                (proximity(distance).0 * GREATEST_PROXIMITY - reading).abs() < 1e-9,
                "{distance} mm"
            );
        }
    }

    #[test]
    fn drives_are_those_of_wheels_up_to_their_greatest_speed() {
        let robot = Foraging::odowd2014(Light::Nowhere);
        // 2 rad/s on the spot, 26.5 mm from the centre; and ahead at more than the wheels can.
        let spot = Drive {
            forward: 0.0,
            turn: (0.2 / TURN) as f32,
        };
        let ahead = |forward| Drive { forward, turn: 0.01 };
        let near = |[left, right]: [f32; 2], expected: [f32; 2]| {
            assert!(
                (left - expected[0]).abs() < 1e-3 && (right - expected[1]).abs() < 1e-3,
                "{left}, {right}"
            );
        };
        near(spot.wheels(&robot), [-53.0, 53.0]);
        near(ahead(5.0).wheels(&robot), [33.3496, 66.6504]);
        assert_eq!(ahead(50.0).wheels(&robot), [128.8; 2]);
        assert_eq!(ahead(-50.0).wheels(&robot), [-128.8; 2]);
        for drive in [spot, ahead(5.0), ahead(-1.0)] {
            let again = Drive::of_wheels(drive.wheels(&robot), &robot);
            assert!((again.forward - drive.forward).abs() < 1e-6 && (again.turn - drive.turn).abs() < 1e-7);
        }
    }

    #[test]
    fn genes_select_scenarios_by_hundredths() {
        for (gene, light) in [
            (0.0, Light::OppositeNest),
            (0.32, Light::OppositeNest),
            (0.33, Light::Nowhere),
            (0.65, Light::Nowhere),
            (0.66, Light::OverNest),
            (0.99, Light::OverNest),
        ] {
            assert_eq!(Light::of_gene(gene), light, "{gene}");
        }
    }
}
