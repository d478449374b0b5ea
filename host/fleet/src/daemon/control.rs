//! The control thread of a daemon. Every 100 ms it takes the received datagrams, reads the robot's sensors, drives by
//! its controller, and sends its messages. Nothing here waits for the disk, for the network or for the evolution.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use oneiro::acting::{Acting, Mind};
use oneiro::cpu::Cpu;
use oneiro::random::Key;
use oneiro::swarm::SECOND;
use oneiro_base::exit::{Failure, Result};
use oneiro_evolve::encapsulated::Genome;
use oneiro_lab::exchange::radio::beacon::Beacons;
use oneiro_lab::exchange::radio::key::Key as Secret;
use oneiro_lab::exchange::radio::{Packet, Radio, Received, Refusal, Status};
use oneiro_robots::tracker::{Budget, Seen, lines};
use oneiro_robots::vehicle::Vehicle;
use oneiro_robots::vehicle::late::Late;
use oneiro_robots::vehicle::trouble::Trouble;
use serde_json::json;

use super::activity::{Activity, Problems};
use super::air::{Air, Channel};
use super::evolution::Evolution;
use super::intervals::Saved;
use super::keeper::Keeper;
use super::log::Log;
use super::member::{Deeds, Member, Sighted};
use super::notify::Notify;
use super::settings::Settings;
use super::{epuck, log};

/// A cycle, ms.
const MILLISECONDS: i64 = 100;
const HALF_CYCLE: Duration = Duration::from_millis(50);
/// Purpose of the random numbers of behaviours, among those of a robot's seed.
const BEHAVIOUR: u64 = 1;

fn milliseconds_since(tick: Duration, now: Duration) -> f64 {
    1000.0 * now.saturating_sub(tick).as_secs_f64()
}

/// The cycle of a time of the experiment, ms, if it has begun.
fn cycle_at(milliseconds: i64) -> Option<u32> {
    milliseconds.div_euclid(MILLISECONDS).try_into().ok()
}

/// A daemon at work.
pub struct Daemon<'a> {
    settings: &'a Settings,
    vehicle: Box<dyn Vehicle>,
    air: Box<dyn Air>,
    member: Member,
    acting: Acting,
    mind: Mind,
    cpu: Cpu,
    evolution: Evolution,
    /// Whether it waits for the evolution and the disk, on a clock that does.
    waits: bool,
    radio: Radio,
    beacons: Beacons,
    seen: Seen,
    /// The newest sighting, until a cycle has taken it.
    sighted: Option<Sighted>,
    /// Lines of the tracker that are looked at in a cycle.
    lines: Budget,
    /// The numbers of the operator's last received start, and of its datagram.
    call: Option<(u64, u64)>,
    keeper: Keeper<Saved>,
    saved: Saved,
    log: Log,
    notify: Notify,
    problems: Problems,
    activity: Activity,
    /// The cycle that it has lived through last.
    cycle: Option<u32>,
    /// Time of the last report to the operator.
    told: Option<Duration>,
    /// Logged counts of refused and lost datagrams, and the senders refused by name.
    refused: Vec<(&'static str, u64)>,
    refusals: BTreeSet<String>,
    /// The last trouble that was logged.
    trouble: Option<String>,
    /// Speeds of the wheels, mm/s.
    speeds: [f64; 2],
    /// When the cycle begins that comes next, and how late those of this interval were in which the robot lived, ms.
    tick: Option<Duration>,
    late: Vec<f64>,
    /// Maximum lateness of a cycle's start in this interval, whatever the robot did, ms.
    begins: f64,
    began: Duration,
}

/// What a daemon reads before it connects to its robot: its key, and what was saved.
pub struct Files {
    radio: Radio,
    keeper: Keeper<Saved>,
    saved: Saved,
}

impl Files {
    /// Reads them, and counts this start.
    ///
    /// # Errors
    /// Exit 3: an unusable key or directory; exit 5: the saved state is damaged; exit 6: the disk.
    pub fn open(settings: &Settings) -> Result<Self> {
        let Settings {
            plan,
            robot,
            experiment,
            ..
        } = settings;
        let number = *robot as usize;
        let key = Secret::read(&settings.key)?;
        let owner = blake3::hash(&[experiment.as_bytes().as_slice(), &robot.to_le_bytes()].concat());
        let (mut keeper, saved) = Keeper::<Saved>::open(&settings.directory, owner)?;
        let saved = match saved {
            Some(saved) => Saved {
                boots: saved.boots.saturating_add(1),
                ..saved
            },
            None => Saved::new(
                Member::new(plan.clone(), number, settings.radio.contact)
                    .state()
                    .clone(),
            ),
        };
        // A start that is not counted on disk could seal numbers that it has sealed before.
        keeper.save_now(&saved)?;
        let limits = plan.settings.limits();
        let mut radio = Radio::new(*robot as u16, limits, &key, *experiment.as_bytes(), saved.boots);
        radio.restore(saved.windows.clone());
        Ok(Self { radio, keeper, saved })
    }
}

impl<'a> Daemon<'a> {
    /// Prepares all. With `waits`, the daemon waits for its evolution and its disk, on a clock that stops for that
    /// time.
    ///
    /// # Errors
    /// The evolution can't be computed.
    pub fn new(
        settings: &'a Settings,
        files: Files,
        vehicle: Box<dyn Vehicle>,
        air: Box<dyn Air>,
        waits: bool,
    ) -> Result<Self> {
        let Settings { plan, robot, .. } = settings;
        let Files {
            radio,
            mut keeper,
            saved,
        } = files;
        let (number, boots) = (*robot as usize, saved.boots);
        if !waits {
            keeper.start();
        }
        let began = vehicle.now();
        Ok(Self {
            member: Member::at(plan.clone(), number, settings.radio.contact, saved.state.clone()),
            acting: Acting::new(&plan.settings.world.forager)?,
            mind: Acting::begin(Key::rollout(plan.robot_seed(number), BEHAVIOUR, 0, 0)),
            cpu: Cpu::new(Some(1))?,
            evolution: Evolution::start(plan.clone(), number, settings.evolution.share),
            waits,
            radio,
            beacons: Beacons::new(settings.beacon.limit()),
            seen: Seen::new(
                u64::from(*robot),
                vehicle.profile().greatest_mm_s,
                settings.tracker.age(),
            ),
            sighted: None,
            lines: Budget::default(),
            call: None,
            keeper,
            saved,
            log: Log::open(&settings.directory, *robot, boots, log::Limits::default()),
            notify: Notify::of_environment(),
            problems: Problems::default(),
            activity: Activity::Waiting,
            cycle: None,
            told: None,
            refused: Vec::new(),
            refusals: BTreeSet::new(),
            trouble: None,
            speeds: [0.0; 2],
            tick: None,
            late: Vec::new(),
            begins: 0.0,
            began,
            settings,
            vehicle,
            air,
        })
    }

    /// Runs until the experiment is over or `stop` is set. Then the wheels stand still.
    ///
    /// # Errors
    /// Exit 4: the robot fails for good; exit 75: `stop` was set before the experiment was over.
    pub fn live(mut self, stop: &AtomicBool) -> Result {
        let experiment = self.settings.experiment.to_hex();
        self.log(
            "start",
            json!({ "program": env!("CARGO_PKG_VERSION"), "experiment": experiment.as_str() }),
        );
        let profile = self.vehicle.profile();
        self.log(
            "connected",
            json!({ "robot": profile.robot, "firmware": profile.firmware }),
        );
        self.notify.ready();
        let outcome = loop {
            if stop.load(Ordering::Relaxed) {
                break Err(Failure::stopped("stopped; start the daemon again to go on"));
            }
            if self.activity == Activity::Over {
                break Ok(());
            }
            if let Err(failure) = self.cycle() {
                break Err(failure);
            }
        };
        self.notify.stopping();
        let stopped = self.vehicle.stop();
        let saved = self.save_last();
        self.log("end", json!({ "stopped": stopped.is_ok() }));
        outcome.and(stopped.map_err(Failure::from)).and(saved)
    }

    /// One cycle.
    fn cycle(&mut self) -> Result {
        let now = self.vehicle.now();
        self.begins = self
            .begins
            .max(self.tick.map_or(0.0, |tick| milliseconds_since(tick, now)));
        self.receive(now);
        let time = self.beacons.time(now);
        self.problems
            .set(Problems::BEACON, time.is_some() && !self.beacons.may_move(now));
        self.problems
            .set(Problems::TRACKER, time.is_some() && self.seen.place(now).is_none());
        self.problems.set(Problems::DISK, self.keeper.problem().is_some());
        let before = self.activity;
        match time.map(cycle_at) {
            None => self.activity = Activity::Waiting,
            Some(None) => self.activity = Activity::Off,
            // Otherwise time has not passed: there is nothing new to decide.
            Some(Some(cycle)) if self.cycle.is_none_or(|last| cycle > last) => {
                self.cycle = Some(cycle);
                self.evolve()?;
                let deeds = self.member.cycle(cycle, self.sighted.take());
                self.act(cycle, &deeds)?;
                self.say(&deeds);
                self.record(deeds);
            }
            Some(Some(_)) => {}
        }
        if self.activity != Activity::Living || self.problems.any() {
            self.speeds = [0.0; 2];
        }
        let driven = self.vehicle.drive(self.speeds);
        self.check_trouble(driven)?;
        if let Some(tick) = self.tick.filter(|_| self.activity == Activity::Living) {
            self.late.push(milliseconds_since(tick, self.vehicle.now()));
        }
        if before != self.activity {
            let activity = self.activity.word();
            self.log(
                "activity",
                json!({ "activity": activity, "problems": self.problems.words() }),
            );
        }
        self.tell(now);
        let past = time.map_or(0, |time| time.rem_euclid(MILLISECONDS));
        let rest = Duration::from_millis((MILLISECONDS - past) as u64);
        self.tick = Some(now + rest);
        let kept = self.vehicle.keep_until(now + rest);
        self.check_trouble(kept)
    }

    /// Takes what has come through the air.
    fn receive(&mut self, now: Duration) {
        /// Ten times what ten robots, a tracker and an operator send in a second. The rest waits for the next cycle.
        const MOST: usize = 1000;
        for _ in 0..MOST {
            let Some((channel, datagram)) = self.air.receive() else {
                return;
            };
            match channel {
                Channel::Tracker => lines(&datagram).for_each(|line| {
                    if self.lines.take(now) {
                        self.see(line, now);
                    } else {
                        self.seen.skip();
                    }
                }),
                Channel::Radio => match self.radio.open(&datagram, now, self.beacons.second(now)) {
                    Ok(received) => self.hear(received, now),
                    Err(refusal) => self.refuse(&refusal),
                },
            }
        }
    }

    /// Takes a line of the tracker.
    fn see(&mut self, line: &[u8], now: Duration) {
        let Some(sighting) = self.seen.take(line, now) else {
            return;
        };
        // What is seen was so before it came.
        let second = self.beacons.second(now.saturating_sub(HALF_CYCLE));
        if let (Some(second), Some(heard)) = (second, sighting.heard) {
            self.member.meet(second, heard);
        }
        if let (Some(carries), Some(brought)) = (sighting.carries, sighting.brought) {
            let cycle = self.beacons.time(now).and_then(cycle_at);
            if cycle.is_none_or(|cycle| self.member.can_have_brought(brought, cycle)) {
                self.sighted = Some(Sighted { carries, brought });
            } else {
                self.seen.disbelieve();
            }
        }
    }

    /// Takes a datagram.
    fn hear(
        &mut self,
        Received {
            sender,
            sequence,
            packet,
        }: Received,
        now: Duration,
    ) {
        match packet {
            Packet::Pair { second, message } => {
                if self.member.hear(second, message) {
                    self.log(
                        "heard",
                        json!({ "sender": sender, "sequence": sequence, "second": second }),
                    );
                }
            }
            Packet::Beacon {
                milliseconds,
                go,
                start,
            } => {
                self.beacons.hear(sequence, milliseconds, go, now);
                self.note_start(sequence, start);
            }
            Packet::Call { start } => self.note_start(sequence, start),
            // These are for the operator.
            Packet::Status(_) | Packet::Hello { .. } => {}
        }
    }

    /// Stores the number of the operator's start, unless a newer datagram had one.
    fn note_start(&mut self, sequence: u64, start: u64) {
        if self.call.is_none_or(|(newest, _)| newest < sequence) {
            self.call = Some((sequence, start));
        }
    }

    /// The number of the operator's start; 0 if none was heard.
    fn start(&self) -> u64 {
        self.call.map_or(0, |(_, start)| start)
    }

    /// Logs each sender that is refused by name once; other refused datagrams are counted.
    fn refuse(&mut self, refusal: &Refusal) {
        /// A flood of invented names is not logged.
        const MOST: usize = 100;
        if !matches!(refusal, Refusal::OtherVersion(_) | Refusal::OtherExperiment { .. }) {
            return;
        }
        let words = refusal.to_string();
        if self.refusals.len() < MOST && self.refusals.insert(words.clone()) {
            self.log("refused", json!({ "reason": refusal.reason(), "words": words }));
        }
    }

    /// Asks for evaluations on board, and takes their results.
    fn evolve(&mut self) -> Result {
        self.evolution.ask(self.member.evolution());
        loop {
            let must_wait = self.waits && self.member.evolution().is_to_simulate();
            let Some(simulated) = self.evolution.result(must_wait)? else {
                return Ok(());
            };
            self.member.take_simulated(simulated.interval, &simulated.fitness);
            let [worked, taken] = [simulated.worked, simulated.taken].map(|time| time.as_secs_f64());
            let best = simulated.fitness.iter().copied().fold(0.0, f32::max);
            self.log(
                "simulated",
                json!({ "interval": simulated.interval, "best": best, "worked_s": worked, "taken_s": taken }),
            );
        }
    }

    /// Reads the sensors and decides how fast the wheels turn.
    fn act(&mut self, cycle: u32, deeds: &Deeds) -> Result {
        self.activity = match deeds.controller {
            _ if deeds.is_over => Activity::Over,
            None => Activity::Off,
            Some(_) if self.problems.has(Problems::BEACON) => Activity::Standing,
            Some(_) if self.problems.without(Problems::ROBOT).any() => Activity::Troubled,
            Some(controller) => return self.live_by(cycle, controller),
        };
        Ok(())
    }

    fn live_by(&mut self, cycle: u32, controller: Genome) -> Result {
        let readings = match self.vehicle.look() {
            Ok(moment) => epuck::activations(&moment.readings).map_err(Failure::device)?,
            Err(trouble) => {
                self.activity = Activity::Troubled;
                return self.check_trouble(Err(trouble));
            }
        };
        self.problems.set(Problems::ROBOT, false);
        self.activity = Activity::Living;
        self.mind.skip_to(cycle);
        let carries = self.member.carries();
        let deed = self
            .acting
            .cycle(&mut self.mind, &mut self.cpu, controller, &readings, carries)
            .map_err(Failure::failed)?;
        self.speeds = deed
            .drive()
            .wheels(&self.settings.plan.settings.world.forager)
            .map(f64::from);
        Ok(())
    }

    /// Notes the outcome of a call to the robot.
    ///
    /// # Errors
    /// The robot fails for good.
    fn check_trouble(&mut self, outcome: std::result::Result<(), Trouble>) -> Result {
        match outcome {
            // The caller looks at the flag.
            Ok(()) | Err(Trouble::Stopped) => Ok(()),
            // The guard still tries to stop the wheels: ending here would not help.
            Err(trouble) if trouble.may_pass() || matches!(trouble, Trouble::Runaway(_)) => {
                self.problems.set(Problems::ROBOT, true);
                let words = trouble.to_string();
                if self.trouble.replace(words.clone()) != Some(words.clone()) {
                    self.log("trouble", json!({ "words": words }));
                }
                // One request a cycle; the guard decides when the robot may move again.
                self.vehicle.resume();
                Ok(())
            }
            Err(trouble) => {
                self.log("trouble", json!({ "words": trouble.to_string() }));
                Err(trouble.into())
            }
        }
    }

    /// Broadcasts the robot's simulator.
    fn say(&mut self, deeds: &Deeds) {
        if let Some((second, message)) = deeds.say {
            self.send(&Packet::Pair { second, message });
            self.log("said", json!({ "sequence": self.radio.sequence(), "second": second }));
        }
    }

    fn send(&mut self, packet: &Packet) {
        let datagram = self.radio.seal(packet);
        self.air.send(&datagram);
    }

    /// Saves what the intervals that have ended leave.
    fn record(&mut self, deeds: Deeds) {
        for interval in &deeds.ended {
            self.log("interval", json!(interval));
        }
        if deeds.ended.is_empty() {
            return;
        }
        self.log_lateness();
        self.saved.ended.extend(deeds.ended);
        self.saved.state = self.member.state().clone();
        self.saved.windows = self.radio.windows().clone();
        self.keeper.save(self.saved.clone());
    }

    /// Logs how late cycles of the interval began at most, and how late the commands of those were in which the robot lived; on a
    /// clock that waits they never are.
    fn log_lateness(&mut self) {
        let (late, begins) = (std::mem::take(&mut self.late), std::mem::take(&mut self.begins));
        let cycles = late.len();
        if !self.waits {
            let [_, median, high, greatest] = Late::of_all(late).quantiles();
            self.log(
                "late",
                json!({ "cycles": cycles, "median_ms": median, "high_ms": high, "greatest_ms": greatest, "begins_ms": begins }),
            );
        }
    }

    /// Tells the operator once a second how the robot is, or that it is there.
    fn tell(&mut self, now: Duration) {
        const PERIOD: Duration = Duration::from_secs(1);
        if self.told.is_some_and(|told| now < told + PERIOD) {
            return;
        }
        self.told = Some(now);
        if self.keeper.is_to_repeat() {
            self.keeper.save(self.saved.clone());
        }
        let losses = self.air.losses();
        let here = [
            ("unsent", losses.unsent),
            ("socket_errors", losses.errors),
            ("not_logged", self.log.lost()),
        ];
        let ignored = self.radio.refused().counts().chain([("too_long", losses.too_long)]);
        let ignored: Vec<(&str, u64)> = ignored.chain(self.seen.ignored().counts()).collect();
        // Its own come back by a broadcast.
        let others = ignored.iter().filter(|(reason, _)| *reason != Refusal::Own.reason());
        let total: u64 = others.map(|(_, count)| count).sum();
        let all = ignored.into_iter().chain(here);
        let counts: Vec<(&str, u64)> = all.filter(|(_, count)| *count > 0).collect();
        if counts != self.refused {
            self.log(
                "losses",
                counts
                    .iter()
                    .map(|(reason, count)| ((*reason).to_owned(), json!(count)))
                    .collect(),
            );
            self.refused = counts;
        }
        let packet = match self.beacons.time(now) {
            None => Packet::Hello {
                program: env!("CARGO_PKG_VERSION").into(),
                experiment: *self.settings.experiment.as_bytes(),
                start: self.start(),
            },
            Some(milliseconds) => Packet::Status(Status {
                ignored: total.try_into().unwrap_or(u32::MAX),
                ..self.status(milliseconds, now)
            }),
        };
        self.send(&packet);
        let words = format!(
            "{}, interval {}",
            self.activity.word(),
            self.member.evolution().interval()
        );
        self.notify.watchdog();
        self.notify.status(&words);
    }

    fn status(&self, milliseconds: i64, now: Duration) -> Status {
        let evolution = self.member.evolution();
        let second = self.cycle.unwrap_or_default() / SECOND;
        Status {
            start: self.start(),
            milliseconds,
            state: self.activity as u8,
            interval: evolution.interval(),
            simulator: evolution.simulator(),
            real: self.member.earned(),
            simulated: evolution
                .simulated
                .last()
                .copied()
                .filter(|fitness| fitness.is_finite())
                .unwrap_or(-1.0),
            controller: evolution.acts(second),
            brought: self.member.state().brought.unwrap_or_default(),
            carries: self.member.carries(),
            pose: self
                .seen
                .place(now)
                .map_or([0.0; 3], |seen| seen.pose())
                .map(|number| number as f32),
            volts: self.vehicle.volts().map_or(-1.0, |volts| volts as f32),
            problems: self.problems.bits(),
            ignored: 0,
        }
    }

    /// Saves a last time. An interval in progress is lost, as after a crash.
    fn save_last(&mut self) -> Result {
        self.saved.windows = self.radio.windows().clone();
        self.keeper.save_now(&self.saved)
    }

    fn log(&self, event: &str, fields: serde_json::Value) {
        let now = self.vehicle.now();
        self.log
            .event(now.saturating_sub(self.began), self.beacons.time(now), event, fields);
    }
}

#[cfg(test)]
mod tests;
