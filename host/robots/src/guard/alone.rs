//! A guard in the same thread as the calls to its robot, with its clock: for emulated robots on virtual time. It makes
//! the decisions and the calls of the guard's process, and between two calls decides again.

use std::cell::Cell;
use std::rc::Rc;
use std::sync::mpsc;
use std::time::Duration;

use super::message::{Report, VERSION};
use super::process::{Keeper, PULSE, TICK};
use super::values::Values;
use super::wheels::{Event, Hands, Pace, Wanted, ready};
use super::{Brake, Guard, State};
use crate::error::{Error, Result};
use crate::link::{Clock, Link};
use crate::recognise;

/// What connects a guard with its program, and gives it time.
pub trait Pipe: Clock + Clone {
    /// The lines that have come from the program since the last call.
    fn lines(&self) -> Vec<String>;

    /// Whether the program is gone.
    fn is_closed(&self) -> bool;

    /// Reports to the program.
    fn report(&self, report: &Report);

    /// Lets time pass until a moment, or until something has come from the program.
    fn wait(&self, until: Duration);
}

/// How long a call may take while the wheels are not to turn.
const ATTEMPT: Duration = Duration::from_secs(1);

/// The time between two calls.
struct Turns<P> {
    pipe: P,
    /// When the guard has to decide again, though nothing has come.
    decides: Rc<Cell<Duration>>,
}

impl<P: Pipe> Clock for Turns<P> {
    fn now(&self) -> Duration {
        self.pipe.now()
    }
}

impl<P: Pipe> Pace for Turns<P> {
    fn rest(&self, until: Duration) {
        let soonest = self.now() + TICK;
        self.pipe.wait(until.min(self.decides.get()).max(soonest));
    }

    fn pause(&self, time: Duration) {
        let until = self.now() + time;
        while self.now() < until && !self.pipe.is_closed() {
            self.pipe.wait(until);
        }
    }
}

/// Connects to the robot at the end of a link, and guards it until its program is gone and the wheels stand still, or
/// can't be stopped.
pub fn guard(link: Box<dyn Link>, pipe: &(impl Pipe + 'static), wanted: &Wanted, values: &Values) {
    pipe.report(&Report::Hello { version: VERSION });
    let brake = Brake::default();
    let mut keeper = Keeper::new(values.clone(), pipe.now());
    let (tell, told) = mpsc::channel();
    let connected = connected(brake.on(link, None), wanted, values);
    let (robot, kinds) = match connected {
        Ok(connected) => connected,
        Err(error) => {
            let failure = oneiro_base::exit::Failure::from(error);
            let (code, message) = (failure.code(), failure.to_string());
            return pipe.report(&Report::Failed { code, message });
        }
    };
    let wanted = Wanted {
        kinds,
        odometry: wanted.odometry,
    };
    // The receiver exists as long as the hands.
    let tell = move |event: Event| drop(tell.send(event));
    let decides = Rc::new(Cell::new(Duration::ZERO));
    let turns = Turns {
        pipe: pipe.clone(),
        decides: Rc::clone(&decides),
    };
    let mut hands = Hands::new(robot, wanted, turns, brake.clone(), tell);
    loop {
        for line in pipe.lines() {
            keeper.line(Some(&line));
        }
        if pipe.is_closed() {
            keeper.closed();
        }
        for event in told.try_iter() {
            if let Some(report) = keeper.news(event) {
                pipe.report(&report);
            }
        }
        let now = pipe.now();
        let Some(order) = keeper.step(now) else { continue };
        if let Some(status) = keeper.state(now) {
            pipe.report(&Report::State(status));
        }
        if keeper.is_over() {
            return hands.leave();
        }
        decides.set(now + keeper.patience());
        // A gain of speed can wait for an answer, and all else can not; a stop is repeated in that time, and this guard
        // has to report.
        let limit = keeper.validity().unwrap_or(ATTEMPT);
        brake.release(Some(now + limit));
        hands.turn(order);
    }
}

impl Guard {
    /// How long the wheels may turn yet, unless a command or an answer comes; none if they are not to turn.
    fn validity(&self) -> Option<Duration> {
        let expires = self.values.expiry().saturating_sub(self.age);
        let is_late = self.values.link().saturating_sub(self.quiet);
        (self.state == State::Moving).then_some(expires.min(is_late))
    }

    /// Whether the wheels have not yet reached the newest command's speeds.
    fn is_speeding_up(&self) -> bool {
        self.state == State::Moving && self.speeds != self.target
    }
}

impl Keeper {
    /// How long the wheels may turn yet, if nothing more comes; none if they are not to turn.
    fn validity(&self) -> Option<Duration> {
        self.guard.as_ref()?.validity()
    }

    /// How long it has nothing to decide and to report, if nothing comes.
    fn patience(&self) -> Duration {
        let is_speeding_up = self.guard.as_ref().is_some_and(Guard::is_speeding_up);
        let validity = self.validity().unwrap_or(PULSE);
        if is_speeding_up { TICK } else { validity.min(PULSE) }
    }
}

type Connected = (Box<dyn crate::Robot>, Vec<crate::Kind>);

fn connected(link: Box<dyn Link>, wanted: &Wanted, values: &Values) -> Result<Connected> {
    let name = link.name().to_owned();
    let robot = recognise(link)?.ok_or_else(|| Error::Unknown {
        link: name,
        problem: "no e-puck or Khepera answers".into(),
    })?;
    ready(robot, &wanted.kinds, values.fuse())
}
