//! A surrogate of a real robot: an individual in its surroundings. A Khepera's surrogate has physics that no sampled table
//! contains. It stands in for a real robot: it is sampled, and controllers are transferred to it. A parametric robot's surrogate
//! differs as much from its description, see `docs/robots.md`; controllers are transferred to it.
//!
//! All of its random properties follow from seeds, by exactly rounded operations. The distributions are in
//! [`Individual::drawn`] and [`Surroundings::drawn`]; `studies/preregistration-1995.md` explains them. Every difference
//! from the simulator may have a severity; else one scales those of motion, and one the rest. At severity 0 a
//! Khepera behaves like its simulator except for rounding: its first readings are equal, and its motion is computed in
//! smaller steps. A parametric robot's episodes are then bit-identical to the simulator's without noise.

use std::fmt;

use oneiro_shaders::surrogate as kernel;

use crate::cells::Cells;
use crate::exact::{cosine, exponential};
use crate::parameter::{Invalid, number};
use crate::random::pcg4d;
use crate::world::sensors::SensorKind;
use crate::world::tables::SENSORS;

/// Objects farther than this from the rim, in mm, aren't sensed: no individual reads 1 of 1023 there.
pub(crate) const SIGHT: f32 = 80.0;

/// Distance between the contact points of the wheels, mm (evorobotpy2, `KiKS`).
const WHEEL_BASE: f64 = 53.0;
/// Speed of a wheel at its maximum command, 10 units of 8.2 mm/s (`KiKS`; Nolfi's recordings).
const FULL_SPEED: f64 = 82.0;
const CYCLE_MS: f64 = 100.0;
/// Amplitude of the field of light, and noise of reading: of 1023, and in proportion to the reading.
const BRIGHTER: f64 = 0.3;
const NOISE: f64 = 3.4;
const NOISE_SHARE: f64 = 0.03;
/// A Khepera's sensors look up to this many degrees aside, and see up to this share farther or less far than the middle of them:
/// half readings at 20.2 to 29.5 mm.
const ASIDE: f64 = 5.0;
const STRONGER: f64 = (29.5 - 20.2) / (29.5 + 20.2);
/// Rates are per step of a cycle's motion.
const SUBSTEP_MS: f64 = CYCLE_MS / kernel::SUBSTEPS as f64;

/// A difference between the surrogate and the simulator made from its samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Difference {
    /// Rays meet all objects at once, at any distance and angle: true corners, occlusion, no grid. Without it, each
    /// object is seen on the samples' grid as if it were alone, and readings are added.
    Geometry,
    /// Each object reflects up to 20 % more or less light.
    Reflectivity,
    /// A smooth field of light over the arena, up to 30 % more or less, and a constant of up to 0.02.
    Illumination,
    /// Each reading has noise: s.d. 3.4 of 1023, and 3 % of the reading.
    ReadNoise,
    /// Readings are old by the latency plus up to 20 ms, because sensors are read every 20 ms.
    Latency,
    /// Wheels follow their commands with a time constant of 20 ms.
    MotorLag,
    /// Each wheel turns up to 1 % faster or slower than it should.
    Wheels,
    /// A cycle's motion is an arc, not a straight line followed by a turn.
    Arcs,
    /// A blocked robot moves and turns half as far as if it slid along the object, instead of not at all.
    Slip,
}

impl Difference {
    /// All differences.
    pub const ALL: [Self; 9] = [
        Self::Geometry,
        Self::Reflectivity,
        Self::Illumination,
        Self::ReadNoise,
        Self::Latency,
        Self::MotorLag,
        Self::Wheels,
        Self::Arcs,
        Self::Slip,
    ];

    /// Whether it is of motion or of the age of readings, rather than of what sensors see.
    pub fn is_of_motion(self) -> bool {
        match self {
            Self::Latency | Self::MotorLag | Self::Wheels | Self::Arcs | Self::Slip => true,
            Self::Geometry | Self::Reflectivity | Self::Illumination | Self::ReadNoise => false,
        }
    }

    /// Name in files and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Geometry => "geometry",
            Self::Reflectivity => "reflectivity",
            Self::Illumination => "illumination",
            Self::ReadNoise => "read_noise",
            Self::Latency => "latency",
            Self::MotorLag => "motor_lag",
            Self::Wheels => "wheels",
            Self::Arcs => "arcs",
            Self::Slip => "slip",
        }
    }
}

/// How a sensor of a parametric robot differs from its description.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Mounting {
    /// Error of its direction, turns.
    pub(crate) heading: f32,
    /// Of a proximity sensor: share of their distance at which objects seem to be. Of light and ground sensors: share of the
    /// reading.
    pub(crate) strength: f32,
}

impl Mounting {
    /// No difference.
    pub(crate) const TRUE: Self = Self {
        heading: 0.0,
        strength: 1.0,
    };
}

/// How strong each difference is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Differences {
    /// Scales all of them: 0 for none, 1 for the drawn sizes, at most 2.
    pub severity: f32,
    /// Scales those of motion and of the age of readings in its place, see [`Difference::is_of_motion`].
    pub motion: f32,
    /// Minimum age of readings at severity 1, ms: 0 to 100. The study has 20.
    pub latency_ms: f32,
    /// Severities of single differences, in the order of [`Difference::ALL`], instead of the two above.
    /// Hashes that identify a surrogate contain this field's name.
    own: [Option<f32>; Difference::ALL.len()],
}

impl Differences {
    /// All differences.
    pub fn all(severity: f32) -> Self {
        Self {
            severity,
            motion: severity,
            latency_ms: 20.0,
            own: [None; Difference::ALL.len()],
        }
    }

    /// Only one difference.
    pub fn only(severity: f32, difference: Difference) -> Self {
        let others_off = Self {
            own: [Some(0.0); Difference::ALL.len()],
            ..Self::all(severity)
        };
        others_off.with(difference, severity)
    }

    /// All differences but one.
    pub fn without(severity: f32, difference: Difference) -> Self {
        Self::all(severity).with(difference, 0.0)
    }

    /// Sets the severity of one difference, apart from that of the others: 0 for none.
    #[must_use]
    pub fn with(mut self, difference: Difference, severity: f32) -> Self {
        self.own[difference as usize] = Some(severity);
        self
    }

    /// Sets the minimum age of readings at severity 1, ms.
    #[must_use]
    pub fn with_latency(self, latency_ms: f32) -> Self {
        Self { latency_ms, ..self }
    }

    /// Sets the severity of what differs in motion and in the age of readings, apart from that of the rest.
    #[must_use]
    pub fn with_motion(self, motion: f32) -> Self {
        Self { motion, ..self }
    }

    /// Severity of one difference: 0 if it is off.
    pub fn strength(&self, difference: Difference) -> f32 {
        let shared = if difference.is_of_motion() {
            self.motion
        } else {
            self.severity
        };
        self.own[difference as usize].unwrap_or(shared)
    }

    fn of(&self, difference: Difference) -> f64 {
        f64::from(self.strength(difference))
    }
}

impl fmt::Display for Differences {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "severity {}", self.severity)?;
        if self.motion != self.severity {
            write!(f, ", of motion {}", self.motion)?;
        }
        for difference in Difference::ALL {
            if let Some(severity) = self.own[difference as usize] {
                write!(f, ", of {} {severity}", difference.name())?;
            }
        }
        Ok(())
    }
}

/// An infrared sensor: its direction, and its readings of a white wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InfraRed {
    /// Position on the rim, facing outwards: degrees clockwise from the heading.
    pub bearing: f64,
    /// Gap between rim and wall at which it reads 50 % of the maximum, head-on, mm.
    pub half: f64,
    /// Gap at which it reads 5 %, mm.
    pub twentieth: f64,
    /// Angle over which it reads at least 50 % at a gap of 15 mm, degrees.
    pub width: f64,
}

/// An individual robot, whose parts differ from those of others.
#[derive(Clone, Debug, PartialEq)]
pub struct Individual {
    /// Left 90, left 45, left 10, right 10, right 45, right 90, back right, back left.
    pub sensors: [InfraRed; SENSORS],
    /// Share by which each wheel is too fast: left, right.
    pub wheels: [f64; 2],
}

/// Named sources of random numbers. A number is identified by its source and index.
#[derive(Clone, Copy)]
enum Source {
    Sensor = 0,
    Wheel = 1,
    Wall = 2,
    Obstacle = 3,
    Light = 4,
    Block = 5,
    Floor = 6,
}

/// Four random numbers in `0..1`.
fn units(seed: u64, source: Source, index: usize) -> [f64; 4] {
    let words = pcg4d([seed as u32, (seed >> 32) as u32, source as u32, index as u32]);
    words.map(|word| f64::from(word >> 8) / f64::from(1 << 24))
}

fn between(low: f64, high: f64, share: f64) -> f64 {
    low + (high - low) * share
}

/// Bearings of a Khepera's sensors, degrees clockwise from straight ahead: those of the recordings of 1995, made symmetric.
pub const BEARINGS: [f64; SENSORS] = [-72.0, -43.0, -11.0, 11.0, 43.0, 72.0, 167.5, -167.5];

impl Individual {
    /// Draws an individual within the range of a real Khepera's eight recorded sensors: half readings at 20.2 to 29.5
    /// mm; a further 8.9 to 13.6 mm to 5 %; widths of 52 to 92 degrees. As in the recordings, far-sighted sensors have
    /// wide views: one random number makes up 60 % of the fade and 85 % of the width, another the rest. Bearings are
    /// those of the recordings, made symmetric, plus or minus up to 5 degrees; wheels vary by up to 1 %.
    pub fn drawn(seed: u64) -> Self {
        let sensor = |index: usize| {
            let [strength, fade, width, bearing] = units(seed, Source::Sensor, index);
            let half = between(20.2, 29.5, strength);
            InfraRed {
                bearing: BEARINGS[index] + between(-ASIDE, ASIDE, bearing),
                half,
                twentieth: half + between(8.9, 13.6, 0.6 * strength + 0.4 * fade),
                width: between(52.0, 92.0, 0.85 * strength + 0.15 * width),
            }
        };
        let [left, right, ..] = units(seed, Source::Wheel, 0);
        Self {
            sensors: std::array::from_fn(sensor),
            wheels: [left, right].map(|share| between(-0.01, 0.01, share)),
        }
    }
}

/// A wave of light intensity along a direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wave {
    /// Turns per mm along x and y.
    pub turns_per_mm: [f64; 2],
    /// Turns.
    pub phase: f64,
}

/// Kinds of objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Object {
    /// A wall.
    Wall,
    /// A round obstacle.
    Obstacle,
    /// A rectangular obstacle.
    Block,
    /// The floor, and after it its patches.
    Floor,
}

/// Surroundings of a robot: light, and the reflectivity of objects.
#[derive(Clone, Debug, PartialEq)]
pub struct Surroundings {
    /// Waves of the light field, each with a quarter of its amplitude.
    pub waves: [Wave; kernel::WAVE_COUNT as usize],
    /// Ambient light, added to every activation.
    pub ambient: f64,
    seed: u64,
}

impl Surroundings {
    /// Draws surroundings: waves of 300 to 1,000 mm in any direction and phase; an ambient activation of 0 to 0.02; and
    /// objects with a reflectivity of 0.8 to 1.2.
    pub fn drawn(seed: u64) -> Self {
        let wave = |index: usize| {
            let [length, direction, phase, _] = units(seed, Source::Light, index);
            let per_mm = 1.0 / between(300.0, 1000.0, length);
            let degrees = 360.0 * direction;
            Wave {
                turns_per_mm: [per_mm * cosine(degrees), per_mm * cosine(degrees - 90.0)],
                phase,
            }
        };
        let [.., ambient] = units(seed, Source::Light, 0);
        Self {
            waves: std::array::from_fn(wave),
            ambient: between(0.0, 0.02, ambient),
            seed,
        }
    }

    /// Reflectivity of an object, by its index among those of its kind.
    pub fn reflectivity(&self, kind: Object, index: usize) -> f64 {
        let source = match kind {
            Object::Wall => Source::Wall,
            Object::Obstacle => Source::Obstacle,
            Object::Block => Source::Block,
            Object::Floor => Source::Floor,
        };
        let [share, ..] = units(self.seed, source, index);
        between(0.8, 1.2, share)
    }
}

/// An individual in its surroundings.
#[derive(Clone, Debug, PartialEq)]
pub struct Surrogate {
    /// Its body.
    pub individual: Individual,
    /// Its light and its objects' reflectivity.
    pub surroundings: Surroundings,
    /// Differences from the simulator.
    pub differences: Differences,
}

impl Surrogate {
    /// Draws an individual and its surroundings from one seed.
    pub fn drawn(seed: u64, differences: Differences) -> Self {
        Self {
            individual: Individual::drawn(seed),
            surroundings: Surroundings::drawn(seed),
            differences,
        }
    }

    /// Checks every number, and that something differs if anything is to: `acts` says which differences change anything.
    pub(crate) fn check(&self, acts: impl Fn(Difference) -> bool) -> Result<(), Invalid> {
        let is_on = |difference: &Difference| self.differences.own[*difference as usize] != Some(0.0);
        let (acts, idle): (Vec<_>, Vec<_>) = Difference::ALL.into_iter().partition(|difference| acts(*difference));
        if !acts.iter().any(is_on) && idle.iter().any(is_on) {
            let names =
                |all: &mut dyn Iterator<Item = Difference>| all.map(Difference::name).collect::<Vec<_>>().join(", ");
            let on = names(&mut idle.into_iter().filter(is_on));
            let allowed = names(&mut acts.into_iter());
            let problem = format!("are {on}, which have no effect on this robot; allowed with one of {allowed}");
            return Err(Invalid::new("surrogate.differences", problem));
        }
        number("surrogate.severity", self.differences.severity, 0.0..=2.0)?;
        number("surrogate.motion", self.differences.motion, 0.0..=2.0)?;
        for difference in Difference::ALL {
            let field = format!("surrogate.differences.{}", difference.name());
            number(field, self.differences.strength(difference), 0.0..=2.0)?;
        }
        number("surrogate.latency_ms", self.differences.latency_ms, 0.0..=100.0)?;
        for (index, sensor) in self.individual.sensors.iter().enumerate() {
            let key = |name| format!("surrogate.sensors[{index}].{name}");
            number(key("bearing"), sensor.bearing as f32, -180.0..=180.0)?;
            number(key("half"), sensor.half as f32, 15.5..=50.0)?;
            number(key("twentieth"), (sensor.twentieth - sensor.half) as f32, 1.0..=20.0)?;
            number(key("width"), sensor.width as f32, 20.0..=120.0)?;
        }
        for (name, share) in ["left", "right"].into_iter().zip(self.individual.wheels) {
            number(format!("surrogate.wheels.{name}"), share as f32, -0.5..=0.5)?;
        }
        for (index, wave) in self.surroundings.waves.iter().enumerate() {
            for turns in wave.turns_per_mm {
                number(
                    format!("surrogate.waves[{index}]"),
                    1000.0 * turns as f32,
                    -100.0..=100.0,
                )?;
            }
        }
        number("surrogate.ambient", self.surroundings.ambient as f32, 0.0..=1.0)
    }

    /// Reflectivity of an object for the kernel; 1 if that difference is off.
    pub(crate) fn reflectivity(&self, kind: Object, index: usize) -> f32 {
        let strength = self.differences.of(Difference::Reflectivity);
        (1.0 + strength * (self.surroundings.reflectivity(kind, index) - 1.0)) as f32
    }

    /// The fraction of its distance at which an object seems to be to a parametric robot: what returns falls with the square of the
    /// distance.
    pub(crate) fn seeming(&self, kind: Object, index: usize) -> f32 {
        (1.0 / f64::from(self.reflectivity(kind, index)).sqrt()) as f32
    }

    /// How a sensor of a parametric robot differs from its description, by its index: as the bearing and the sight of a Khepera's
    /// differ from the middle of all.
    pub(crate) fn mounting(&self, index: usize, kind: SensorKind) -> Mounting {
        let difference = self.differences.of(Difference::Geometry);
        // Drawn together, an individual and its surroundings have one seed.
        let [sight, .., aside] = units(self.surroundings.seed, Source::Sensor, index);
        let turns = difference * between(-ASIDE, ASIDE, aside) / 360.0;
        let stronger = 1.0 + difference * between(-STRONGER, STRONGER, sight);
        kind.entry().mounting.map_or(Mounting::TRUE, |mounting| {
            let [heading, strength] = mounting(turns, stronger).map(in_kernel);
            Mounting { heading, strength }
        })
    }

    /// Differences of a parametric robot as a whole, for the kernel. `track` is the distance between its wheels, mm, if it is known.
    pub(crate) fn differing(&self, track: Option<f64>) -> Vec<[f32; 4]> {
        let strength = |difference| self.differences.of(difference);
        let light = strength(Difference::Illumination);
        let amplitude = light * BRIGHTER / f64::from(kernel::WAVE_COUNT);
        let wave = |wave: &Wave| [wave.turns_per_mm[0], wave.turns_per_mm[1], wave.phase, amplitude];
        let noise = strength(Difference::ReadNoise);
        let age = strength(Difference::Latency);
        // What is left of a difference in speed after each step of a cycle, by the implicit Euler method.
        let lag = strength(Difference::MotorLag);
        let rest = lag / (1.0 + lag);
        let (mut left_over, mut mean) = (1.0, 0.0);
        for _ in 0..kernel::SUBSTEPS {
            left_over *= rest;
            mean += left_over / f64::from(kernel::SUBSTEPS);
        }
        let [left, right] = self.individual.wheels.map(|share| strength(Difference::Wheels) * share);
        // A turn leads a wheel on a circle of half the track.
        let circle = track.map_or(0.0, |track| std::f64::consts::PI * track);
        let unlike = 0.5 * (right - left);
        let cells = [
            [
                noise * NOISE / f64::from(kernel::GREATEST_READING),
                noise * NOISE_SHARE,
                light * self.surroundings.ambient,
                age * f64::from(self.differences.latency_ms) / CYCLE_MS,
            ],
            [age * SUBSTEP_MS / CYCLE_MS, left_over, mean, self.slip()],
            [
                0.5 * (left + right),
                unlike * circle,
                if circle > 0.0 { unlike / circle } else { 0.0 },
                0.0,
            ],
        ];
        let waves = self.surroundings.waves.iter().map(wave);
        waves.chain(cells).map(|cell| cell.map(in_kernel)).collect()
    }

    /// The fraction of a cycle's turn that a parametric robot makes before its displacement, given that of its sampled motors: an arc
    /// makes half of it.
    pub(crate) fn turn_before_move(&self, sampled: f32) -> f32 {
        let arc = self.differences.strength(Difference::Arcs).min(1.0);
        sampled + arc * (0.5 - sampled)
    }

    /// The fraction of sliding and turning that a stopped robot does.
    fn slip(&self) -> f64 {
        (0.5 * self.differences.of(Difference::Slip)).min(1.0)
    }

    /// Packs it for the kernel.
    pub(crate) fn cells(&self, body_radius: f32) -> Vec<[u32; 4]> {
        // The logistic falls from 1/2 to 1/20 where 2 exp(x) grows from 2 to 29.
        const LOGARITHM_OF_29_HALVES: f64 = 2.674_148_649_426_529;
        let radius = f64::from(body_radius);
        let strength = |difference| self.differences.of(difference);
        let mut cells = Cells::new(kernel::INDIVIDUAL_CELLS);
        for (cell, sensor) in (0..)
            .step_by(kernel::SENSOR_CELLS as usize)
            .zip(&self.individual.sensors)
        {
            // The kernel's angles are counter-clockwise.
            let (x, y) = (cosine(sensor.bearing), cosine(sensor.bearing + 90.0));
            cells.put(
                cell + kernel::PLACE,
                kernel::PlaceCell {
                    x: in_kernel(radius * x),
                    y: in_kernel(radius * y),
                    axis_x: in_kernel(x),
                    axis_y: in_kernel(y),
                },
            );
            cells.put(cell + kernel::RAY_WEIGHTS, ray_weights(sensor, radius).map(in_kernel));
            let fade = (sensor.twentieth - sensor.half) / LOGARITHM_OF_29_HALVES;
            cells.put(
                cell + kernel::CURVE,
                kernel::CurveCell {
                    half: in_kernel(sensor.half),
                    steepness: in_kernel(1.0 / fade),
                    ..kernel::CurveCell::default()
                },
            );
        }
        let light = strength(Difference::Illumination);
        for (cell, wave) in (kernel::WAVES..).zip(&self.surroundings.waves) {
            let [x, y] = wave.turns_per_mm;
            cells.put(
                cell,
                kernel::WaveCell {
                    turns_x: in_kernel(x),
                    turns_y: in_kernel(y),
                    phase: in_kernel(wave.phase),
                    amplitude: in_kernel(light * BRIGHTER / 4.0),
                },
            );
        }
        let noise = strength(Difference::ReadNoise);
        cells.put(
            kernel::SENSING,
            kernel::SensingCell {
                geometry: in_kernel(strength(Difference::Geometry)),
                noise: in_kernel(noise * NOISE / f64::from(kernel::GREATEST_READING)),
                noise_share: in_kernel(noise * NOISE_SHARE),
                ambient: in_kernel(light * self.surroundings.ambient),
            },
        );
        let age = strength(Difference::Latency);
        cells.put(
            kernel::TIMING,
            kernel::TimingCell {
                latency: in_kernel(age * f64::from(self.differences.latency_ms) / CYCLE_MS),
                period: in_kernel(age * SUBSTEP_MS / CYCLE_MS),
                arc: in_kernel(strength(Difference::Arcs).min(1.0)),
                slip: in_kernel(self.slip()),
            },
        );
        let [left, right] = self
            .individual
            .wheels
            .map(|share| FULL_SPEED * (1.0 + strength(Difference::Wheels) * share));
        cells.put(
            kernel::WHEELS,
            kernel::WheelsCell {
                full_left: in_kernel(left),
                full_right: in_kernel(right),
                turns_per_mm: in_kernel(1.0 / (WHEEL_BASE * 2.0 * std::f64::consts::PI)),
                // A time constant of 20 ms, by the implicit Euler method.
                response: in_kernel(1.0 / (1.0 + strength(Difference::MotorLag))),
            },
        );
        cells.into_table()
    }
}

/// Converts a number to the kernel's form.
fn in_kernel(number: f64) -> f32 {
    let number = number as f32;
    // Zero has one sign, and nothing is subnormal.
    if number.abs() < 1e-30 { 0.0 } else { number }
}

/// Weights of the pairs of rays: a bell curve over the rays' angles. Its width matches the sensor's width, and its
/// scale makes a wall head-on read as at its own distance.
fn ray_weights(sensor: &InfraRed, radius: f64) -> [f64; 4] {
    const GAP: f64 = 15.0;
    let half_width = sensor.width / 2.0;
    // Off the axis, the rim curves away from the wall.
    let distance = GAP + radius * (1.0 - cosine(half_width));
    let rays = kernel::RAY_DEGREES.map(f64::from);
    let wanted = distance / sensor.half;
    // Light that comes back by each pair of rays from a wall at a bearing.
    let light = |bearing: f64| {
        let cube = |degrees: f64| {
            let c = cosine(degrees).max(0.0);
            c * c * c
        };
        rays.map(|ray| cube(ray - bearing) + cube(ray + bearing))
    };
    let (ahead, aside) = (light(0.0), light(half_width));
    let returned = |weights: [f64; 4], light: [f64; 4]| {
        weights
            .into_iter()
            .zip(light)
            .map(|(weight, light)| weight * light)
            .sum::<f64>()
    };
    let bell = |spread: f64| {
        let weights = rays.map(|ray| exponential(-0.5 * (ray / spread) * (ray / spread)));
        let sum = returned(weights, ahead);
        weights.map(|weight| weight / sum)
    };
    // A wider bell returns more light from the side.
    let (mut narrow, mut wide) = (5.0, 500.0);
    for _ in 0..60 {
        let spread = 0.5 * (narrow + wide);
        if returned(bell(spread), aside) < wanted * wanted {
            narrow = spread;
        } else {
            wide = spread;
        }
    }
    bell(wide)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn motion_has_a_severity_of_its_own() {
        let differences = Differences::without(1.5, Difference::Arcs).with_motion(0.5);
        let strengths = Difference::ALL.map(|difference| differences.strength(difference));
        assert_eq!(strengths, [1.5, 1.5, 1.5, 1.5, 0.5, 0.5, 0.5, 0.0, 0.5]);
        let refused = Surrogate::drawn(1, differences.with_motion(2.5))
            .check(|_| true)
            .unwrap_err();
        assert_eq!(refused.field, "surrogate.motion");
    }

    #[test]
    fn a_difference_may_have_a_severity_of_its_own() {
        let differences = Differences::all(1.0).with_motion(0.5).with(Difference::Wheels, 2.0);
        let strengths = Difference::ALL.map(|difference| differences.strength(difference));
        assert_eq!(strengths, [1.0, 1.0, 1.0, 1.0, 0.5, 0.5, 2.0, 0.5, 0.5]);
        assert_eq!(differences.to_string(), "severity 1, of motion 0.5, of wheels 2");
        let refused = Surrogate::drawn(1, differences.with(Difference::Slip, -0.5))
            .check(|_| true)
            .unwrap_err();
        assert_eq!(refused.field, "surrogate.differences.slip");
    }

    #[test]
    fn rays_go_where_their_angles_say() {
        for (ray, degrees) in kernel::RAY_DEGREES.map(f64::from).into_iter().enumerate() {
            let near = |rounded: f32, exact: f64| (f64::from(rounded) - exact).abs() < 1e-7;
            assert!(near(kernel::RAY_COSINES[ray], cosine(degrees)), "{degrees}");
            assert!(near(kernel::RAY_SINES[ray], cosine(90.0 - degrees)), "{degrees}");
        }
    }
}
