//! Episodes of a connected robot. Every 100 ms its sensors are read, the controller computes speeds, and the wheels get them as
//! commands. The pose is computed from its odometers, or a tracker reports it. Controller and task give the same bits as in the
//! simulator, so the episode's record is enough to compute its fitness again.

pub mod logbook;
mod senses;
mod sharing;

use std::f64::consts::TAU;
use std::fmt::{self, Display};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use oneiro::batch::{Batch, Rollout, Trace, TraceRequest};
use oneiro::cpu::Cpu;
use oneiro::differential::Build;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::parameter::{Choice, Choices};
use oneiro::reported::{self, Reported};
use oneiro::world::{World, WorldSpec};
use oneiro_base::console::Console;
use oneiro_base::exit::{Failure, Result};
use oneiro_report::numbers::fixed;
use oneiro_robots::vehicle::late::Late;
use oneiro_robots::vehicle::{Moment, Profile, Vehicle};
use oneiro_robots::{Kind, guard, tracker};

use self::logbook::{Begun, Cycle, Identity, Logbook, Row};
use self::senses::Senses;
use self::sharing::{OnLived, Standing, Taker, shared};
use super::wander::{WALK, wanderer};
use super::{Life, Lived, Reality, Trouble};

/// A cycle of an episode.
const CYCLE: Duration = Duration::from_millis(100);
/// Maximum speed of a robot with sampled motors, mm/s: 10 of the Khepera's units of 8 mm/s.
const SAMPLED_SPEED: f64 = 80.0;

/// Default time for which a robot drives about before each episode, s.
pub const WALK_S: f64 = WALK as f64 / 10.0;
/// Speeds that a wheel may have at the controller's maximum output, mm/s: those that a guard allows.
pub const SPEEDS_MM_S: [f64; 2] = [1.0, 1100.0];
/// Maximum time for which a robot drives about before an episode, s.
pub const LONGEST_WALK_S: f64 = 600.0;

/// How the starts of episodes are chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Starts {
    #[default]
    Walk,
    Hand,
}

impl Choice for Starts {
    const CHOICES: Choices<Self> = &[
        ("walk", Self::Walk, "the robot drives at random before each episode"),
        (
            "hand",
            Self::Hand,
            "somebody puts the robot at the simulator's start and presses Enter",
        ),
    ];
}

/// Values of episodes on a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Values {
    /// How episodes get their starts.
    pub starts: Starts,
    /// Cycles of 100 ms for which it drives about.
    pub walk: u32,
    /// Speed of a wheel at the controller's maximum output, mm/s; the experiment's if none.
    pub speed_mm_s: Option<f64>,
    /// Names of the world's sensors and of the robot's, where they differ.
    pub sensors: Vec<(String, String)>,
    /// Directory of the episodes' record.
    pub directory: PathBuf,
    /// The trackers that measure the poses, one for each robot; without any, poses come from the odometers.
    pub trackers: Vec<tracker::Values>,
}

impl Values {
    /// Cycles of 100 ms in a time, s.
    pub fn cycles(seconds: f64) -> u32 {
        (10.0 * seconds).round() as u32
    }

    /// Cycles of 100 ms for which it drives about before each episode.
    pub(super) fn walk(&self) -> u32 {
        match self.starts {
            Starts::Walk => self.walk,
            Starts::Hand => 0,
        }
    }

    /// Speed of a wheel at the controller's maximum output, mm/s. `greatest` is the limit, and `whose` says where it is from.
    ///
    /// # Errors
    /// Exit 3: it exceeds the limit.
    fn speed(&self, spec: &WorldSpec, greatest: f64, whose: &str) -> Result<f64> {
        let own = match &spec.robot.build {
            Build::Differential(own) => own.greatest_speed.map_or(SAMPLED_SPEED, f64::from),
            Build::Sampled | Build::Forager(_) => SAMPLED_SPEED,
        };
        let speed = self.speed_mm_s.unwrap_or(own);
        // An experiment has its speeds in f32, in which 128.8 is more than the e-puck's.
        if speed as f32 > greatest as f32 {
            return Err(Failure::input(format_args!(
                "the maximum speed is {speed} mm/s, and {whose} {greatest:.1} mm/s; allowed: a lower reality.speed_mm_s \
                 (--speed), or a higher speed_mm_s of its guard"
            )));
        }
        Ok(speed)
    }

    /// The maximum time for `lives` episodes of `cycles` cycles each on some robots, in words.
    pub(super) fn time(&self, lives: u64, cycles: u32, robots: usize) -> String {
        let before = match self.starts {
            Starts::Walk => format!(", each after {} s of driving about", f64::from(self.walk) / 10.0),
            Starts::Hand => ", and the time to put it at each start".to_owned(),
        };
        let time = Time::new(lives, 1, cycles + self.walk(), robots);
        let noun = if lives == 1 { "episode" } else { "episodes" };
        let seconds = f64::from(cycles) / 10.0;
        format!("{lives} {noun} of {seconds} s{before}: {time}, less for those that are on record")
    }
}

/// Time that episodes take on robots.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Time {
    /// Of all robots together, min.
    pub robot_minutes: f64,
    /// By the clock, min.
    pub minutes: f64,
    robots: usize,
}

impl Time {
    /// The time of generations with `lives` episodes each. An episode takes `cycles` cycles, and a generation begins when the one
    /// before is complete.
    pub fn new(lives: u64, generations: u32, cycles: u32, robots: usize) -> Self {
        let minutes = |lives: u64| lives as f64 * f64::from(generations) * f64::from(cycles) / 600.0;
        Self {
            robot_minutes: minutes(lives),
            minutes: minutes(lives.div_ceil(robots as u64)),
            robots,
        }
    }

    /// The time of these episodes, and then of the other ones, repeated `times` times.
    pub fn and(self, times: usize, other: Self) -> Self {
        Self {
            robot_minutes: self.robot_minutes + times as f64 * other.robot_minutes,
            minutes: self.minutes + times as f64 * other.minutes,
            robots: self.robots.max(other.robots),
        }
    }
}

impl Display for Time {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words = |minutes: f64, of: &str| match minutes {
            ..120.0 => format!("{minutes:.1} {of}minutes"),
            _ => format!("{:.1} {of}hours", minutes / 60.0),
        };
        f.write_str(&words(self.robot_minutes, "robot-"))?;
        if self.robots > 1 {
            write!(f, ", {} with {} robots", words(self.minutes, ""), self.robots)?;
        }
        Ok(())
    }
}

/// Settings of a guard for episodes: the given ones, and wheels that respond as fast as simulated ones.
pub fn guarded(guard: &[String]) -> Vec<String> {
    // A later setting replaces this one.
    [&["acceleration_mm_s2=10000".to_owned()], guard].concat()
}

/// Kinds of sensors that episodes in a world need.
///
/// # Errors
/// A sensor of a kind that no connected robot has.
pub fn kinds(spec: &WorldSpec) -> std::result::Result<Vec<Kind>, String> {
    senses::kinds(spec)
}

/// Whether episodes in a world are possible, as far as this can be checked without a robot. Returns the kinds of sensors that they need.
///
/// # Errors
/// Exit 3: a world that is not valid, a sensor of a kind that no connected robot has, or a speed that the guard does not allow.
pub fn possible(spec: &WorldSpec, values: &Values, guard: &[String]) -> Result<Vec<Kind>> {
    if spec.varies() {
        let problem =
            "start.kind, worlds: vary, which a real robot's world doesn't; allowed: one world for all episodes";
        return Err(Failure::input(problem));
    }
    let kinds = kinds(spec).map_err(Failure::input)?;
    let greatest = guard::values::Values::of(guard).map_err(Failure::input)?.speed_mm_s;
    values.speed(spec, greatest, "the guard allows")?;
    Reported::new(spec)?;
    Ok(kinds)
}

/// Whether episodes in a world are possible, and can be recorded. Returns the kinds of sensors that they need.
///
/// # Errors
/// As [`possible`], and as the record's.
pub fn check(spec: &WorldSpec, values: &Values, guard: &[String]) -> Result<Vec<Kind>> {
    let kinds = possible(spec, values, guard)?;
    Logbook::check(&values.directory)?;
    Ok(kinds)
}

/// Episodes of a robot in a world. Those of several robots share one record.
#[derive(Debug)]
pub struct Lives {
    /// Address of the robot, and what its messages begin with: nothing if it is the only one.
    robot: String,
    label: String,
    spec: WorldSpec,
    reported: Reported,
    /// Hash of everything except chance that can make episodes with the same genes and key differ.
    world: String,
    cpu: Cpu,
    senses: Senses,
    starts: Starts,
    /// Cycles for which it drives about before an episode.
    walk: u32,
    /// Maximum speed, mm/s.
    speed: f64,
    /// Distance between the wheels, mm.
    base: f64,
    logbook: Arc<Mutex<Logbook>>,
    /// Where the robot is: x and y in mm, heading in turns. The middle of the field at first.
    pose: [f64; 3],
    console: Console,
}

/// The outcome of an episode.
struct Done {
    fitness: f32,
    cycles: Vec<Cycle>,
}

impl Lives {
    /// Prepares episodes of a robot at an address, and opens their record, or shares another robot's, which must have the same
    /// sensors.
    ///
    /// # Errors
    /// Exit 3: a sensor that the robot lacks, a speed that it can't have, a robot without odometers or unlike the other one, or a world
    /// that is not valid; as the record's.
    pub(super) fn new(
        spec: &WorldSpec,
        vehicle: &dyn Vehicle,
        values: &Values,
        console: Console,
        robot: &str,
        other: Option<&Self>,
    ) -> Result<Self> {
        let address = robot;
        let profile = vehicle.profile();
        let Profile { robot, base_mm, .. } = profile;
        if !profile.has_odometers && values.trackers.is_empty() {
            return Err(Failure::input(format_args!(
                "the {robot} has no odometers; allowed: a robot with odometers, or a tracker (--tracker)"
            )));
        }
        let senses = Senses::new(spec, profile, &values.sensors).map_err(Failure::input)?;
        let speed = values.speed(spec, profile.greatest_mm_s, &format!("the {robot} has"))?;
        let mut cpu = Cpu::new(Some(1)).map_err(Failure::from)?;
        let reported = Reported::new(spec)?;
        warm_up(&reported, &mut cpu)?;
        let sees = format!("{:?} {senses:?} {speed}", reported.world().spec());
        let raw = profile
            .sensors
            .iter()
            .flat_map(|sensors| sensors.names.clone())
            .collect();
        let names = [raw, senses.names().map(str::to_owned).collect()];
        let world = logbook::short(sees.as_bytes());
        let logbook = match other {
            None => Arc::new(Mutex::new(Logbook::open(&values.directory, names)?)),
            Some(other) if other.world == world && lock(&other.logbook).names == names => Arc::clone(&other.logbook),
            Some(other) => {
                return Err(Failure::input(format_args!(
                    "the {robot} at {address} has other sensors than the robot at {}, and both evaluate \
                     the same generation; allowed: robots with the same sensors",
                    other.robot
                )));
            }
        };
        let field = spec.arena.field;
        let middle = |from: f32, length: f32| f64::from(from) + 0.5 * f64::from(length);
        Ok(Self {
            robot: address.to_owned(),
            label: String::new(),
            logbook,
            spec: spec.clone(),
            reported,
            world,
            cpu,
            senses,
            starts: values.starts,
            walk: values.walk,
            speed,
            base: *base_mm,
            pose: [middle(field.x, field.width), middle(field.y, field.height), 0.0],
            console,
        })
    }

    /// Whether an episode is recorded as complete.
    pub fn has_lived(&self, life: &Life<'_>) -> bool {
        let identity = Identity::new(life.key, life.genes, &self.world);
        lock(&self.logbook).complete(&identity).is_some()
    }

    /// Prints a message about the robot.
    fn say(&self, words: &str) {
        self.console.say(format!("{}{words}", self.label));
    }

    /// The same, also if messages are hidden.
    fn warn(&self, words: &str) {
        self.console.ask(format!("{}{words}", self.label));
    }

    /// Runs an episode, unless it is recorded as complete.
    fn attempt(
        &mut self,
        vehicle: &mut dyn Vehicle,
        life: &Life<'_>,
        traced: bool,
    ) -> std::result::Result<Lived, Trouble> {
        let identity = Identity::new(life.key, life.genes, &self.world);
        let known = lock(&self.logbook).complete(&identity).cloned();
        if let Some(row) = known {
            return self.recorded(&row, life, traced);
        }
        let start = self.place(vehicle, life)?;
        let mut begun = lock(&self.logbook).begin(identity, life.genes, start, &self.robot)?;
        let mut late = Vec::new();
        let outcome = self.cycles(vehicle, life, start, &mut begun, &mut late);
        let late = Late::of_all(late);
        let stopped = vehicle.stop();
        let done = match outcome {
            Ok(done) => done,
            Err(trouble) => {
                let ended = lock(&self.logbook).end(&begun, Err(trouble.to_string()), late);
                // On a full disk the first failure names what was lost.
                return Err(match ended {
                    Err(unrecorded) if trouble.may_pass() => unrecorded.into(),
                    _ => trouble,
                });
            }
        };
        lock(&self.logbook).end(&begun, Ok(done.fitness), late)?;
        let [_, median, high, _] = late.quantiles();
        let battery = vehicle
            .volts()
            .map_or_else(String::new, |volts| format!(", battery {volts:.2} V"));
        self.say(&format!(
            "life-{}.csv: fitness {}, commands late by {median:.1} ms (median) and {high:.1} ms (99 %){battery}",
            begun.number, done.fitness
        ));
        stopped?;
        self.lived(life, start, &done, traced)
    }

    /// A recorded episode, with its fitness computed again.
    fn recorded(&mut self, row: &Row, life: &Life<'_>, traced: bool) -> std::result::Result<Lived, Trouble> {
        let cycles = lock(&self.logbook).cycles(row)?;
        let (fitness, _) = replayed(&self.reported, &mut self.cpu, life, row.start, &cycles)?;
        if row.fitness().map(f32::to_bits) != Some(fitness.to_bits()) {
            return Err(Failure::corrupt(format_args!(
                "episode {}: its table gives the fitness {fitness}, but the index has another",
                row.number
            ))
            .into());
        }
        self.lived(life, row.start, &Done { fitness, cycles }, traced)
    }

    /// The result of an episode, with a trace if requested: one record more than cycles, for the pose at the end.
    fn lived(
        &mut self,
        life: &Life<'_>,
        start: [f32; 3],
        done: &Done,
        traced: bool,
    ) -> std::result::Result<Lived, Trouble> {
        let mut trace = Trace::default();
        if traced && let Some(last) = done.cycles.last() {
            let longer = Reported::new(&self.spec.clone().seen_to_its_end())?;
            let cycles = [&done.cycles[..], std::slice::from_ref(last)].concat();
            trace = replayed(&longer, &mut self.cpu, life, start, &cycles)?.1;
        }
        Ok(Lived {
            fitness: done.fitness,
            trace,
        })
    }

    /// Moves the robot to an episode's start, and returns that.
    fn place(&mut self, vehicle: &mut dyn Vehicle, life: &Life<'_>) -> std::result::Result<[f32; 3], Trouble> {
        self.pose = vehicle.seen().unwrap_or(self.pose);
        let here = self.pose.map(|number| number as f32);
        if life.start == Some(here) {
            return Ok(here);
        }
        if self.starts == Starts::Walk && life.start.is_none() {
            self.walk(vehicle, life)?;
            return Ok(self.pose.map(|number| number as f32));
        }
        let start = match life.start {
            Some(start) => start,
            None => self.drawn(life)?,
        };
        let [x, y, heading] = start;
        vehicle.ask(&format!(
            "put the robot at x = {} mm and y = {} mm, {} degrees counter-clockwise from the x axis",
            fixed(x.into(), 0),
            fixed(y.into(), 0),
            fixed((360.0 * heading).into(), 0)
        ))?;
        self.pose = vehicle.seen().unwrap_or(start.map(f64::from));
        Ok(self.pose.map(|number| number as f32))
    }

    /// The simulator's start for an episode.
    fn drawn(&mut self, life: &Life<'_>) -> std::result::Result<[f32; 3], Trouble> {
        let world = World::new(WorldSpec {
            cycles: 1,
            ..self.spec.clone()
        });
        let rollout = Rollout {
            world: 0,
            genes: life.genes,
            key: life.key,
        };
        let trace = Some(TraceRequest { every: 1 });
        let batch = Batch::new(&[world?], &[rollout], trace)?;
        let outcome = self.cpu.evaluate(&batch, &Control::new())?;
        let record = outcome.traces.first().and_then(|trace| trace.first());
        let record = record.ok_or_else(|| Trouble::Broken("an episode without a trace".into()))?;
        Ok([record.x, record.y, record.heading])
    }

    /// Drives about under random genes, and stops.
    fn walk(&mut self, vehicle: &mut dyn Vehicle, life: &Life<'_>) -> std::result::Result<(), Trouble> {
        if self.walk == 0 {
            return Ok(());
        }
        let inputs = self.senses.names().count();
        let genes = wanderer(life.key, inputs, 2 * (inputs + 1));
        vehicle.drive([0.0; 2])?;
        let mut now = vehicle.look()?;
        let mut tick = vehicle.now();
        for _ in 0..self.walk {
            let seen = self.senses.obstacles(&self.senses.activations(&now.readings));
            let output = |genes: &[f32]| {
                let weighed = genes.iter().zip(&seen).map(|(gene, seen)| f64::from(*gene) * seen);
                let sum = f64::from(genes[inputs]) + weighed.sum::<f64>();
                self.speed * (2.0 / (1.0 + (-sum).exp()) - 1.0)
            };
            let (left, right) = genes.split_at(inputs + 1);
            vehicle.drive([output(left), output(right)])?;
            tick = next(tick, vehicle.now());
            vehicle.keep_until(tick)?;
            let then = vehicle.look()?;
            self.pose = place(vehicle, self.pose, way(&now, &then), self.base);
            now = then;
        }
        vehicle.stop()
    }

    /// Runs the cycles of an episode, and records them.
    fn cycles(
        &mut self,
        vehicle: &mut dyn Vehicle,
        life: &Life<'_>,
        start: [f32; 3],
        begun: &mut Begun,
        late: &mut Vec<f64>,
    ) -> std::result::Result<Done, Trouble> {
        let mut reported = self.reported.begin(life.genes, life.key, start)?;
        let mut cycles = Vec::new();
        // The guard lets it move before the first look.
        vehicle.drive([0.0; 2])?;
        let first = vehicle.look()?;
        let begin = vehicle.now();
        let (mut now, mut tick) = (first.clone(), begin);
        loop {
            let looked = vehicle.now();
            let activations = self.senses.activations(&now.readings);
            let Some(shares) = reported.speeds(&mut self.cpu, &activations).map_err(failed)? else {
                break;
            };
            let speeds = shares.map(|share| f64::from(share) * self.speed);
            vehicle.drive(speeds)?;
            let late_ms = milliseconds(vehicle.now().saturating_sub(tick));
            late.push(late_ms);
            tick = next(tick, vehicle.now());
            vehicle.keep_until(tick)?;
            let then = vehicle.look()?;
            self.pose = place(vehicle, self.pose, way(&now, &then), self.base);
            let end = self.pose.map(|number| number as f32);
            let trace = reported.moved(&mut self.cpu, end).map_err(failed)?;
            let cycle = Cycle { activations, end };
            begun.record(&logbook::Lived {
                cycle: &cycle,
                time_s: looked.saturating_sub(begin).as_secs_f64(),
                late_ms,
                age_ms: milliseconds(now.age + looked.saturating_sub(now.at)),
                readings: &now.readings,
                speeds,
                travel: then.travel.map(|_| way(&first, &then)),
                reward: trace.first().map_or(0.0, |record| record.reward),
            })?;
            cycles.push(cycle);
            now = then;
        }
        let fitness = reported.fitness();
        Ok(Done { fitness, cycles })
    }
}

/// Evaluates a cycle that does not count: what is compiled at first use would make the first cycle late.
fn warm_up(world: &Reported, cpu: &mut Cpu) -> Result {
    let genes = vec![0.0; world.world().genes()];
    let mut life = world.begin(&genes, oneiro::random::Key::default(), [0.0; 3])?;
    let readings = vec![0.0; world.readings()];
    life.speeds(cpu, &readings).map_err(failed)?;
    Ok(())
}

/// Fitness and trace of a recorded episode, computed again.
fn replayed(
    world: &Reported,
    cpu: &mut Cpu,
    life: &Life<'_>,
    start: [f32; 3],
    cycles: &[Cycle],
) -> std::result::Result<(f32, Trace), Trouble> {
    let mut reported = world.begin(life.genes, life.key, start)?;
    let mut trace = Trace::default();
    for Cycle { activations, end } in cycles {
        if reported.speeds(cpu, activations).map_err(failed)?.is_none() {
            break;
        }
        trace.append(&reported.moved(cpu, *end).map_err(failed)?);
    }
    Ok((reported.fitness(), trace))
}

/// End of a cycle that began on time or late. A missed cycle is not made up for.
fn next(tick: Duration, now: Duration) -> Duration {
    let next = tick + CYCLE;
    if now < next { next } else { now + CYCLE }
}

/// How far the wheels have turned from one moment to another, mm.
fn way(from: &Moment, to: &Moment) -> [f64; 2] {
    let [from, to] = [from, to].map(|moment| moment.travel.unwrap_or_default());
    [to[0] - from[0], to[1] - from[1]]
}

/// The pose that a tracker reports, or without one the pose at the end of the arc measured by the odometers.
fn place(vehicle: &dyn Vehicle, pose: [f64; 3], way: [f64; 2], base: f64) -> [f64; 3] {
    vehicle.seen().unwrap_or_else(|| moved(pose, way, base))
}

/// The pose, mm and turns, after an arc on which the wheels, `base` mm apart, have travelled this far, mm.
fn moved([x, y, heading]: [f64; 3], [left, right]: [f64; 2], base: f64) -> [f64; 3] {
    let (ahead, turn) = (0.5 * (left + right), (right - left) / base);
    let half = 0.5 * turn;
    // The chord is shorter than the arc; where the turn is small, by less than a rounding.
    let chord = if half.abs() < 1e-9 {
        ahead
    } else {
        ahead * half.sin() / half
    };
    let (sin, cos) = (TAU * heading + half).sin_cos();
    let heading = (heading + turn / TAU).rem_euclid(1.0);
    // As a float32 it may be rounded up to a whole turn, which is 0.
    let heading = if (heading as f32) < 1.0 { heading } else { 0.0 };
    [x + chord * cos, y + chord * sin, heading]
}

fn milliseconds(time: Duration) -> f64 {
    1000.0 * time.as_secs_f64()
}

fn failed(error: reported::Error) -> Trouble {
    match error {
        reported::Error::Invalid(invalid) => invalid.into(),
        reported::Error::Device(error) => error.into(),
    }
}

/// A connected robot that everything in a command shares.
#[derive(Clone, Default)]
pub struct Shared(Arc<Mutex<Connected>>);

/// A robot, once it is connected.
pub type Connected = Option<Box<dyn Vehicle + Send>>;

impl Shared {
    /// A robot that is connected.
    #[cfg(any(test, all(unix, feature = "compose")))]
    pub fn of(vehicle: impl Vehicle + Send + 'static) -> Self {
        Self(Arc::new(Mutex::new(Some(Box::new(vehicle)))))
    }

    pub fn lock(&self) -> MutexGuard<'_, Connected> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A connected robot that runs episodes.
struct Wired {
    robot: Shared,
    lives: Lives,
    standing: Standing,
    name: String,
}

/// Connected robots as a reality: they share the episodes to run.
#[derive(Default)]
pub struct WiredRobots(Vec<Wired>);

impl WiredRobots {
    /// Adds a robot at an address that is connected.
    ///
    /// # Errors
    /// As [`Lives::new`].
    pub fn add(
        &mut self,
        robot: &Shared,
        address: &str,
        spec: &WorldSpec,
        values: &Values,
        console: Console,
    ) -> Result {
        let connected = robot.lock();
        let Some(vehicle) = &*connected else {
            return Err(Failure::failed(format_args!("{address} is not connected")));
        };
        let other = self.0.first().map(|other| &other.lives);
        let lives = Lives::new(spec, &**vehicle, values, console, address, other)?;
        let profile = vehicle.profile();
        self.0.push(Wired {
            robot: robot.clone(),
            lives,
            standing: Standing::default(),
            name: format!("{} ({}) at {address}", profile.robot, profile.firmware),
        });
        Ok(())
    }

    /// Lets each robot's messages begin with its address.
    pub(super) fn label(&mut self) {
        for own in &mut self.0 {
            own.lives.label = format!("{}: ", own.lives.robot);
        }
    }

    /// How many they are.
    pub(super) fn count(&self) -> usize {
        self.0.len()
    }
}

impl Reality for WiredRobots {
    fn describe(&self) -> String {
        let names: Vec<&str> = self.0.iter().map(|own| &*own.name).collect();
        names.join(", ")
    }

    fn has_lived(&self, life: &Life<'_>) -> bool {
        self.0.first().is_some_and(|own| own.lives.has_lived(life))
    }

    fn live_each(
        &mut self,
        lives: &[Life<'_>],
        traced: bool,
        on_lived: OnLived<'_>,
    ) -> std::result::Result<Vec<Lived>, Trouble> {
        let (robots, own): (Vec<_>, Vec<_>) = self
            .0
            .iter_mut()
            .map(|own| (&own.robot, (&mut own.lives, &mut own.standing)))
            .unzip();
        let mut robots: Vec<_> = robots.into_iter().map(Shared::lock).collect();
        let takers = robots.iter_mut().zip(own).filter_map(|(robot, (lives, standing))| {
            Some(Taker {
                vehicle: &mut **robot.as_mut()?,
                lives,
                standing,
            })
        });
        shared(takers.collect(), lives, traced, on_lived)
    }
}

fn lock(logbook: &Mutex<Logbook>) -> MutexGuard<'_, Logbook> {
    logbook.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(any(test, feature = "testing"))]
pub mod emulated;
#[cfg(test)]
mod several;
#[cfg(test)]
mod tests;
