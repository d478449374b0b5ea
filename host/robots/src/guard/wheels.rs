//! The thread that owns the robot. It carries out the guard's newest order, reads sensors between orders, and reports the
//! outcomes. The link may hold it up; the guard is never held up.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use super::{Brake, Order};
use crate as robots;
use crate::address::Wire;
use crate::error::{Error, Result};
use crate::link::{Clock, wall};
use crate::recording::Recording;
use crate::{Battery, Description, Kind, Odometry, Reading, Robot};

/// An outcome and its time on the links' clock.
#[derive(Clone, Debug)]
pub(super) struct Event {
    pub(super) at: Duration,
    pub(super) news: News,
}

/// The outcome of a call to the robot.
#[derive(Clone, Debug)]
pub(super) enum News {
    /// The robot is connected, and these kinds of sensors are read.
    Connected(Description, Vec<Kind>),
    /// It can't be: the thread has ended.
    Refused(Error),
    /// It has answered.
    Answered,
    /// A call has failed.
    Failed(Error),
    /// It has confirmed a stop.
    Stopped(u64),
    /// It has not confirmed a stop.
    NotStopped(Error),
    /// Readings.
    Read(Kind, Reading),
    /// How far the wheels have turned.
    Travelled(Travel),
    /// The state of the battery.
    Battery(Battery),
    /// Whether it is lifted.
    Lifted(bool),
}

/// How far the wheels have turned since the first reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Travel {
    /// When it was read.
    pub(super) at: Duration,
    /// Its maximum age then.
    pub(super) age: Duration,
    /// Of the left and of the right wheel, mm.
    pub(super) mm: [f64; 2],
}

/// What is read from a robot, besides what the guard itself needs.
#[derive(Clone, Debug, Default)]
pub struct Wanted {
    /// Kinds of sensors; all if there is none.
    pub kinds: Vec<Kind>,
    /// Whether its odometers are read, if it has some.
    pub odometry: bool,
}

/// Tells the thread what to do.
#[derive(Clone)]
pub(super) struct Wheels(Arc<Shared>);

struct Shared {
    order: Mutex<Option<Order>>,
    changed: Condvar,
    brake: Brake,
}

impl Wheels {
    /// Starts the thread, which connects to a robot first. It reads what is wanted, and gives its news to `tell`.
    pub(super) fn start(
        wire: Wire,
        recording: Option<Recording>,
        wanted: Wanted,
        fuse: bool,
        tell: impl Fn(Event) + Send + 'static,
    ) -> (Self, thread::JoinHandle<Option<String>>) {
        let wheels = Self(Arc::new(Shared {
            order: Mutex::new(Some(Order::Stop(0))),
            changed: Condvar::new(),
            brake: Brake::default(),
        }));
        let shared = Arc::clone(&wheels.0);
        let thread = thread::spawn(move || {
            match connected(&wire, recording.as_ref(), &shared.brake, &wanted.kinds, fuse) {
                Ok((robot, kinds)) => {
                    let brake = shared.brake.clone();
                    Hands::new(robot, Wanted { kinds, ..wanted }, Arc::clone(&shared), brake, tell).work(&shared);
                }
                Err(error) => tell(Event {
                    at: wall(),
                    news: News::Refused(error),
                }),
            }
            recording.and_then(Recording::finish)
        });
        (wheels, thread)
    }

    /// Gives an order. A new stop does not wait for the call in progress.
    pub(super) fn order(&self, order: Order) {
        let mut current = self.0.lock();
        if *current == Some(order) {
            return;
        }
        if let Order::Stop(_) = order {
            self.0.brake.press();
        }
        *current = Some(order);
        self.0.changed.notify_one();
    }

    /// Ends the thread, after the call in progress.
    pub(super) fn end(&self) {
        *self.0.lock() = None;
        self.0.brake.press();
        self.0.changed.notify_one();
    }
}

/// The time in which calls to a robot are made.
pub(super) trait Pace: Clock {
    /// Lets time pass: a moment, or until there is something to do, which is known of that time only if nothing new comes.
    fn rest(&self, until: Duration);

    /// Lets this time pass.
    fn pause(&self, time: Duration);
}

impl Pace for Arc<Shared> {
    fn rest(&self, _: Duration) {
        const MOMENT: Duration = Duration::from_millis(5);
        // A moment that is cut short does no harm.
        let _ = self.changed.wait_timeout(self.lock(), MOMENT);
    }

    fn pause(&self, time: Duration) {
        thread::sleep(time);
    }
}

impl Clock for Arc<Shared> {
    fn now(&self) -> Duration {
        wall()
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Option<Order>> {
        self.order.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The order, with the brake released; none at the end.
    fn take(&self) -> Option<Order> {
        // Locked until the brake is released: the guard presses it either before that or after.
        let order = self.lock();
        order.is_some().then(|| self.brake.release(None));
        *order
    }
}

/// The robot, and the kinds of sensors to read.
fn connected(
    wire: &Wire,
    recording: Option<&Recording>,
    brake: &Brake,
    kinds: &[Kind],
    fuse: bool,
) -> Result<(Box<dyn Robot>, Vec<Kind>)> {
    ready(robots::connect_braked(wire, recording, brake)?, kinds, fuse)
}

/// A robot that is connected, and the kinds of sensors to read.
pub(super) fn ready(mut robot: Box<dyn Robot>, kinds: &[Kind], fuse: bool) -> Result<(Box<dyn Robot>, Vec<Kind>)> {
    let all = || robot.description().sensors.iter().map(|group| group.kind).collect();
    let kinds = if kinds.is_empty() { all() } else { kinds.to_vec() };
    match robot.description().groups(&kinds) {
        Ok(_) => {
            if fuse {
                robot.arm()?;
            }
            Ok((robot, kinds))
        }
        // The lack is worse to know than a stop that failed, which connecting has just done.
        Err(lack) => robot.stop().and(Err(lack)),
    }
}

/// What is read from time to time.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Sense {
    Kind(Kind),
    Odometry,
    Lifted,
    Battery,
}

impl Sense {
    /// Time between two readings.
    fn period(self) -> Duration {
        Duration::from_millis(match self {
            Self::Kind(_) | Self::Odometry => 50,
            Self::Lifted => 100,
            Self::Battery => 1000,
        })
    }
}

/// Counts of the wheels, continued when the robot's own counters restart.
#[derive(Debug, Default)]
struct Odometer {
    last: Option<[i64; 2]>,
    total: [i64; 2],
}

impl Odometer {
    /// Takes the robot's counts, which can have changed by so many since the last ones. Returns those since the first; none if they
    /// have changed by more.
    fn add(&mut self, counts: [i64; 2], most: f64) -> Option<[i64; 2]> {
        let last = self.last.replace(counts).unwrap_or(counts);
        let change = [0, 1].map(|wheel| counts[wheel].saturating_sub(last[wheel]));
        if change.iter().any(|change| change.unsigned_abs() as f64 > most) {
            return None;
        }
        for (total, change) in self.total.iter_mut().zip(change) {
            *total += change;
        }
        Some(self.total)
    }

    /// Notes that the robot's counters restart. Whatever its wheels turn until the next reading is lost.
    fn begin_anew(&mut self) {
        self.last = None;
    }
}

/// What calls the robot.
pub(super) struct Hands<P, T> {
    robot: Box<dyn Robot>,
    pace: P,
    brake: Brake,
    tell: T,
    /// What is read, and when next.
    senses: Vec<(Sense, Duration)>,
    odometer: Odometer,
    /// When the odometers were read last.
    travelled_at: Option<Duration>,
    /// The last command that was sent, and when.
    told: Option<([f64; 2], Duration)>,
    /// Whether the last call was for an order: then it is the sensors' turn.
    was_order: bool,
    /// Whether the last stop is not confirmed yet.
    is_stopping: bool,
    /// The stop that was confirmed last.
    stopped: u64,
}

impl<T: Fn(Event)> Hands<Arc<Shared>, T> {
    /// Works until the end is ordered. One call for each order: two calls never keep a new order waiting.
    fn work(mut self, shared: &Shared) {
        loop {
            let Some(order) = shared.take() else {
                return self.leave();
            };
            self.turn(order);
        }
    }
}

impl<P: Pace, T: Fn(Event)> Hands<P, T> {
    /// Time after which a command is repeated, in case something else has changed it.
    const REPEAT: Duration = Duration::from_millis(100);
    /// Interval between two commands while a wheel gains speed: more would leave the link no time for sensors.
    const GAIN: Duration = Duration::from_millis(20);
    /// How much farther wheels may have turned than by their speed, mm.
    const SLIP: f64 = 20.0;
    /// Time that a last stop has when the guard ends.
    const FAREWELL: Duration = Duration::from_millis(250);
    /// Minimum time of a failed attempt to stop, or to open the link again: less than between two stops.
    const PAUSE: Duration = Duration::from_millis(100);

    pub(super) fn new(robot: Box<dyn Robot>, wanted: Wanted, pace: P, brake: Brake, tell: T) -> Self {
        let mut hands = Self {
            senses: Vec::new(),
            odometer: Odometer::default(),
            travelled_at: None,
            robot,
            pace,
            brake,
            tell,
            told: None,
            was_order: false,
            is_stopping: false,
            stopped: 0,
        };
        let now = hands.pace.now();
        let others = [Sense::Odometry, Sense::Lifted, Sense::Battery];
        let is_read = |sense: &Sense| (wanted.odometry || *sense != Sense::Odometry) && hands.has(*sense);
        let others = others.into_iter().filter(is_read).collect::<Vec<_>>();
        let senses = wanted.kinds.iter().copied().map(Sense::Kind).chain(others);
        hands.senses = senses.map(|sense| (sense, now)).collect();
        hands.say(News::Connected(hands.robot.description().clone(), wanted.kinds));
        hands
    }

    fn say(&self, news: News) {
        let at = self.pace.now();
        (self.tell)(Event { at, news });
    }

    /// Whether the robot can be asked this.
    fn has(&mut self, sense: Sense) -> bool {
        let outcome = match sense {
            Sense::Kind(_) => return true,
            Sense::Odometry => return self.robot.description().wheels.mm_per_count.is_some(),
            Sense::Lifted => self.robot.lifted().map(drop),
            Sense::Battery => self.robot.battery().map(drop),
        };
        !matches!(outcome, Err(Error::Unsupported { .. }))
    }

    /// Makes one call for an order, or rests if there is nothing to do.
    pub(super) fn turn(&mut self, order: Order) {
        match order {
            Order::Stop(number) if number != self.stopped => self.stop(number),
            Order::Stop(_) => self.keep([0.0; 2]),
            Order::Drive(speeds) => {
                self.brake.rest();
                self.keep(speeds);
            }
        }
    }

    /// Closes the robot, if its wheels stand still.
    pub(super) fn leave(self) {
        if !self.is_stopping {
            self.brake.release(Some(self.pace.now() + Self::FAREWELL));
            // It stands: nothing depends on it.
            let _ = self.robot.close();
        }
    }

    /// Attempts to stop. The brake repeats the stop, however long this takes.
    fn stop(&mut self, number: u64) {
        let began = self.pace.now();
        (self.told, self.is_stopping) = (None, true);
        self.brake.repeat(self.robot.halt(), began);
        match self.robot.stop_briefly() {
            Ok(()) => {
                self.brake.rest();
                (self.stopped, self.is_stopping) = (number, false);
                self.say(News::Answered);
                self.say(News::Stopped(number));
            }
            // The guard has a newer order.
            Err(Error::Interrupted) => {}
            Err(Error::Restarted) => {
                self.odometer.begin_anew();
                self.say(News::Failed(Error::Restarted));
                self.pause_since(began);
            }
            Err(error) => {
                self.say(News::NotStopped(error.clone()));
                self.reconnect();
                self.say(News::NotStopped(error));
            }
        }
    }

    /// Opens the link again, which also stops the wheels.
    fn reconnect(&mut self) {
        let began = self.pace.now();
        self.brake.release(None);
        self.odometer.begin_anew();
        match self.robot.reconnect() {
            Ok(()) | Err(Error::Interrupted) => {}
            Err(error) => {
                self.say(News::NotStopped(error));
                self.pause_since(began);
            }
        }
    }

    /// Waits where something has failed at once, and may do so again.
    fn pause_since(&self, began: Duration) {
        let spent = self.pace.now().saturating_sub(began);
        self.pace.pause(Self::PAUSE.saturating_sub(spent));
    }

    /// Keeps the wheels at these speeds, and reads sensors in turn.
    fn keep(&mut self, speeds: [f64; 2]) {
        let now = self.pace.now();
        let tell = self.told.map_or(now, |(told, at)| at + Self::patience(told, speeds));
        let must_tell = tell <= now;
        let next = self.senses.iter_mut().min_by_key(|(_, due)| *due);
        let until = next.as_ref().map_or(tell, |(_, due)| tell.min(*due));
        let next = next.filter(|(_, due)| *due <= now);
        match next {
            Some((sense, due)) if self.was_order || !must_tell => {
                let sense = *sense;
                *due = now + sense.period();
                self.was_order = false;
                self.sense(sense);
            }
            _ if must_tell => {
                self.was_order = true;
                self.told = Some((speeds, now));
                // Sending proves nothing about the robot: some links have no answer to it.
                if let Err(error) = self.robot.drive_mm_s(speeds[0], speeds[1]) {
                    self.failed(error);
                }
            }
            _ => {
                self.was_order = false;
                self.pace.rest(until);
            }
        }
    }

    /// How long after a command the next one is sent.
    fn patience(told: [f64; 2], speeds: [f64; 2]) -> Duration {
        let only_gains = |(told, speed): (f64, f64)| told * speed >= 0.0 && speed.abs() >= told.abs();
        if told == speeds {
            Self::REPEAT
        } else if told.into_iter().zip(speeds).all(only_gains) {
            Self::GAIN
        } else {
            Duration::ZERO
        }
    }

    fn sense(&mut self, sense: Sense) {
        let news = match sense {
            Sense::Kind(kind) => self.robot.sense(&[kind]).map(|reading| News::Read(kind, reading)),
            Sense::Lifted => self.robot.lifted().map(News::Lifted),
            Sense::Odometry => self.robot.odometry().and_then(|odometry| self.travelled(odometry)),
            Sense::Battery => self.robot.battery().map(News::Battery),
        };
        match news {
            Ok(news) => {
                self.say(News::Answered);
                self.say(news);
            }
            Err(error) => self.failed(error),
        }
    }

    /// The distance that the wheels have turned, if they can have turned as far since the last reading: three times as
    /// fast as they are driven, since a person may push the robot.
    fn travelled(&mut self, Odometry { at, age, counts }: Odometry) -> Result<News> {
        let wheels = self.robot.description().wheels;
        let mm = wheels.mm_per_count.unwrap_or_default();
        let speed = 3.0 * f64::from(wheels.greatest) * wheels.mm_s;
        let time = at.saturating_sub(self.travelled_at.replace(at).unwrap_or(at)) + age;
        let most = (speed * time.as_secs_f64() + Self::SLIP) / mm;
        let counts = self.odometer.add(counts, most).ok_or_else(|| Error::Garbage {
            command: "the odometers".into(),
            received: format!("{counts:?}, farther than the wheels can have turned"),
        })?;
        let mm = counts.map(|count| count as f64 * mm);
        Ok(News::Travelled(Travel { at, age, mm }))
    }

    /// Handles a failed call: the robot's state is unknown, so no command counts as sent.
    fn failed(&mut self, error: Error) {
        self.told = None;
        if error == Error::Restarted {
            self.odometer.begin_anew();
        }
        if error != Error::Interrupted {
            self.say(News::Failed(error));
            // It may fail again at once.
            self.pace.rest(self.pace.now() + Self::REPEAT);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn travel_goes_on_where_the_counts_begin_anew() {
        let mut odometer = Odometer::default();
        let mut add = |counts| odometer.add(counts, 70.0);
        assert_eq!(add([100, -7]), Some([0, 0]));
        assert_eq!(add([160, -17]), Some([60, -10]));
        // Farther than wheels can have turned: counting continues from there.
        assert_eq!(add([160, 54]), None);
        assert_eq!(add([160, 44]), Some([60, -20]));
        assert_eq!(add([i64::MAX, i64::MIN]), None);
        assert_eq!(add([i64::MIN, i64::MIN]), None);
        odometer.begin_anew();
        assert_eq!(odometer.add([0, 3], 70.0), Some([60, -20]));
        assert_eq!(odometer.add([-5, 13], 70.0), Some([55, -10]));
    }

    #[test]
    fn only_a_gain_of_speed_can_wait() {
        type Any = Hands<Arc<Shared>, fn(Event)>;
        let told = [50.0, -20.0];
        assert_eq!(Any::patience(told, told), Any::REPEAT);
        for gain in [[54.0, -20.0], [50.0, -24.0], [54.0, -24.0]] {
            assert_eq!(Any::patience(told, gain), Any::GAIN, "{gain:?}");
        }
        assert_eq!(Any::patience([0.0, 0.0], told), Any::GAIN);
        for other in [[54.0, -19.0], [49.0, -20.0], [-54.0, -24.0], [0.0, 0.0]] {
            assert_eq!(Any::patience(told, other), Duration::ZERO, "{other:?}");
        }
    }
}
