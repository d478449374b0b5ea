//! `oneiro robot drive`: drives a robot by keys or by a file, always through the guard.

use std::io::{self, IsTerminal, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver};
use std::thread;
use std::time::{Duration, Instant};

use oneiro_base::console::Console;
use oneiro_base::exit::{Failure, Result};
use oneiro_lab::engine::signals::stop_signal;
use oneiro_robots::address::Wire;
use oneiro_robots::guard::client::{Client, Lost, failure};
use oneiro_robots::guard::message::{Report, Request, Sensors, Status};
use oneiro_robots::guard::values::Values;
use oneiro_robots::guard::wheels::Wanted;
use oneiro_robots::guard::{Condition, Guard, Inputs, Order, State};
use serde_json::{Map, Value, json};
use signal_hook::flag;

use super::{number, watch, wire};
use crate::cli::{Guard as Guarded, RobotDrive, Speed};
use crate::commands::live::Live;
use keys::{Action, Keys};
use script::Script;
use terminal::Terminal;

mod keys;
mod script;
mod terminal;

/// Between two looks at the keys, and between two commands.
const CYCLE: Duration = Client::CYCLE;
/// Between two lines of output.
const LINE: Duration = Duration::from_millis(100);

const HELP: &str = "(+ -)   arrows or WASD: drive while held   space: stop   R: resume after a stop   Q: quit";

/// Drives until the keys or the file say that it is over, or Ctrl-C.
pub(super) fn run(arguments: &RobotDrive, console: Console) -> Result {
    let wire = wire(&arguments.guard.link.address)?;
    let values = Values::of(&arguments.guard.values).map_err(Failure::input)?;
    let mut driver = Driver::new(arguments)?;
    if arguments.dry_run {
        return rehearse(&wire, values, &mut driver, console);
    }
    console.say(format!("connecting to {wire}"));
    let Guarded { link, kinds, values } = &arguments.guard;
    let wanted = Wanted {
        kinds: kinds.clone(),
        odometry: false,
    };
    let client = Client::start(&link.address, &wanted, values, link.record.as_deref())?;
    let mut ride = Ride {
        client,
        driver,
        panel: None,
        status: None,
        console,
    };
    let outcome = ride.go();
    let Ride {
        client,
        driver,
        mut panel,
        ..
    } = ride;
    let speed = driver.speed;
    // The terminal is as before whatever comes now.
    drop(driver);
    match (outcome, client) {
        (Ok(()), client) => finished(client, &wire, panel.as_mut(), speed, console),
        (Err(End::Lost(lost)), mut client) => {
            client.kill();
            drop(panel);
            Err(lost.stopped(&wire, console))
        }
        (Err(End::Failed(failure)), client) => match finished(client, &wire, panel.as_mut(), speed, console) {
            Ok(()) => Err(failure),
            Err(worse) => Err(worse.and(failure)),
        },
    }
}

/// Waits until the guard has stopped the robot, and shows that.
fn finished(client: Client, wire: &Wire, panel: Option<&mut Panel>, speed: f64, console: Console) -> Result {
    let mut shown = Ok(());
    let mut panel = panel;
    let outcome = client.finish(|status| {
        if let (Some(panel), Ok(())) = (&mut panel, &shown) {
            shown = panel.show(status, speed);
        }
    });
    match outcome {
        Ok(None) => shown,
        Ok(Some((code, message))) => Err(failure(code, &message)),
        Err(lost) => Err(lost.stopped(wire, console)),
    }
}

/// Why driving has ended early.
enum End {
    /// The guard does nothing more.
    Lost(Lost),
    /// Anything else.
    Failed(Failure),
}

impl From<Lost> for End {
    fn from(lost: Lost) -> Self {
        Self::Lost(lost)
    }
}

impl From<Failure> for End {
    fn from(failure: Failure) -> Self {
        Self::Failed(failure)
    }
}

/// What is wanted at a moment.
#[derive(Debug, Default)]
struct Wish {
    /// Of the left and the right wheel, mm/s.
    speeds: [f64; 2],
    stops: bool,
    resumes: bool,
    /// Why it is over, if it is.
    over: Option<Over>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Over {
    /// By the user or at the file's end.
    Done,
    /// By Ctrl-C before the file's end.
    Cut,
}

/// Who drives.
struct Driver {
    hands: Hands,
    /// Set by Ctrl-C and the like.
    ended: Arc<AtomicBool>,
    /// Greatest speed, mm/s.
    greatest: f64,
    /// Speed of the keys, mm/s.
    speed: f64,
    wanted: Speed,
}

enum Hands {
    /// Keys of the terminal.
    Keys {
        keys: Keys,
        bytes: Receiver<Vec<u8>>,
        terminal: Box<Terminal>,
        /// Set when a suspended program continues.
        continued: Arc<AtomicBool>,
    },
    /// A file.
    Script(Script),
}

impl Driver {
    /// By a file if one is named, else by keys.
    ///
    /// # Errors
    /// The file is not valid, or there is no terminal.
    fn new(arguments: &RobotDrive) -> Result<Self> {
        let script = arguments.commands.as_deref().map(Script::read).transpose()?;
        let ended = stop_signal()?;
        let hands = match script {
            Some(script) => Hands::Script(script),
            None => Self::keys(&ended)?,
        };
        Ok(Self {
            hands,
            ended,
            greatest: 0.0,
            speed: 0.0,
            wanted: arguments.speed,
        })
    }

    fn keys(ended: &Arc<AtomicBool>) -> Result<Hands> {
        if !io::stdin().is_terminal() {
            return Err(Failure::input(
                "standard input is no terminal, so there are no keys; allowed: a terminal, or commands of a file by \
                 --commands",
            ));
        }
        let continued = Arc::new(AtomicBool::new(false));
        #[cfg(unix)]
        for (signal, raised) in [
            (signal_hook::consts::SIGHUP, ended),
            (signal_hook::consts::SIGQUIT, ended),
            (signal_hook::consts::SIGCONT, &continued),
        ] {
            flag::register(signal, Arc::clone(raised))
                .map_err(|error| Failure::failed(format_args!("can't listen for signals: {error}")))?;
        }
        let terminal = Box::new(Terminal::enter()?);
        let (sender, bytes) = mpsc::channel();
        thread::spawn(move || {
            let mut buffer = [0; 64];
            while let Ok(count @ 1..) = io::stdin().read(&mut buffer) {
                if sender.send(buffer[..count].to_vec()).is_err() {
                    return;
                }
            }
        });
        Ok(Hands::Keys {
            keys: Keys::default(),
            bytes,
            terminal,
            continued,
        })
    }

    /// Sets the greatest speed, mm/s, and the speed that was asked for.
    fn limit(&mut self, greatest: f64) {
        self.greatest = greatest;
        self.speed = match self.wanted {
            Speed::MmPerS(speed) => speed.min(greatest),
            Speed::Share(share) => share * greatest,
        };
    }

    /// What is wanted now, by a clock that begins when the robot may first move.
    fn wish(&mut self, now: Duration) -> Result<Wish> {
        let mut wish = Wish::default();
        match &mut self.hands {
            Hands::Script(script) => match script.speeds(now) {
                Some(speeds) => wish.speeds = speeds,
                None => wish.over = Some(Over::Done),
            },
            Hands::Keys {
                keys,
                bytes,
                terminal,
                continued,
            } => {
                if continued.swap(false, Ordering::Relaxed) {
                    terminal.again()?;
                }
                let actions: Vec<Action> = bytes.try_iter().flat_map(|bytes| keys.press(&bytes, now)).collect();
                for action in actions {
                    match action {
                        Action::Faster(share) => {
                            let speed = self.speed + share * self.greatest;
                            self.speed = speed.clamp(0.1 * self.greatest, self.greatest);
                        }
                        Action::Stop => wish.stops = true,
                        Action::Resume => wish.resumes = true,
                        Action::Quit => wish.over = Some(Over::Done),
                        // Held keys are asked for below.
                        Action::Turn(_) => {}
                    }
                }
                wish.speeds = keys.shares(now).map(|share| share * self.speed);
            }
        }
        if self.ended.load(Ordering::Relaxed) {
            wish.over = wish.over.or(Some(match self.hands {
                Hands::Keys { .. } => Over::Done,
                Hands::Script(_) => Over::Cut,
            }));
        }
        Ok(wish)
    }

    fn is_script(&self) -> bool {
        matches!(self.hands, Hands::Script(_))
    }
}

/// A robot that is driven.
struct Ride {
    client: Client,
    driver: Driver,
    panel: Option<Panel>,
    status: Option<Status>,
    console: Console,
}

impl Ride {
    /// Drives until it is over.
    fn go(&mut self) -> std::result::Result<(), End> {
        // The clock of the keys or of the file, and whether the robot has been ready.
        let (mut start, mut is_ready) = (Instant::now(), false);
        loop {
            if self.hear()? {
                return Ok(());
            }
            if !is_ready
                && self
                    .status
                    .as_ref()
                    .is_some_and(|status| status.state == State::Standing)
            {
                (start, is_ready) = (Instant::now(), true);
            }
            // A file begins when the robot is ready; keys that were pressed before are forgotten.
            let is_waiting = !is_ready && self.driver.is_script();
            let now = if is_waiting { Duration::ZERO } else { start.elapsed() };
            let mut wish = self.driver.wish(now)?;
            if !is_ready {
                wish.speeds = [0.0; 2];
            }
            if wish.stops {
                self.client.send(Request::Stop);
            }
            if wish.resumes {
                self.client.send(Request::Resume);
            }
            match wish.over {
                Some(Over::Done) => return Ok(()),
                Some(Over::Cut) => return Err(Failure::stopped("stopped before the end of the commands").into()),
                None => {}
            }
            if self.status.is_some() {
                self.client.drive(wish.speeds);
            }
            self.follow()?;
        }
    }

    /// Hears the guard for a cycle, and shows what it says. Returns whether it has failed.
    fn hear(&mut self) -> std::result::Result<bool, End> {
        let end = Instant::now() + CYCLE;
        while Instant::now() < end {
            let Some(report) = self.client.report()? else { break };
            match report {
                Report::Hello { .. } | Report::Travel { .. } | Report::Battery { .. } => {}
                Report::Connected {
                    robot,
                    greatest_mm_s,
                    sensors,
                    ..
                } => {
                    self.driver.limit(greatest_mm_s);
                    self.console.say(format!("connected: {robot}"));
                    self.panel = Some(Panel::new(&sensors, self.driver.is_script(), self.console));
                }
                Report::Reading { kind, values, .. } => {
                    if let Some(panel) = &mut self.panel {
                        panel.read(&kind, &values);
                    }
                }
                Report::State(status) => {
                    if let Some(panel) = &mut self.panel {
                        panel.show(&status, self.driver.speed)?;
                    }
                    self.status = Some(status);
                }
                Report::Failed { .. } => return Ok(true),
            }
        }
        Ok(false)
    }

    /// Ends a file's ride that only a person can continue, or that can't be stopped.
    fn follow(&self) -> Result {
        let Some(status) = self.status.as_ref().filter(|_| self.driver.is_script()) else {
            return Ok(());
        };
        if status.cannot_stop {
            return Err(Failure::device(format_args!("cannot stop: {}", problem(status))));
        }
        if status.needs_resume {
            return Err(Failure::failed(format_args!(
                "the guard has stopped the robot: {}",
                reasons(status)
            )));
        }
        Ok(())
    }
}

/// Why a stop is not confirmed.
fn problem(status: &Status) -> &str {
    let problem = status.problem.as_deref();
    problem.unwrap_or("it does not confirm that its wheels stand")
}

/// Why the wheels stand, for people.
fn reasons(status: &Status) -> String {
    let words: Vec<&str> = status.reasons.iter().copied().map(Condition::words).collect();
    words.join("; ")
}

/// What a person sees first: what the wheels do, and what to do about it.
fn headline(status: &Status) -> String {
    let state = match status.state {
        State::Moving => "driving".to_owned(),
        _ if status.cannot_stop => format!("CANNOT STOP: {}. Lift the robot", problem(status)),
        State::Stopping => "stopping".to_owned(),
        State::Standing => "standing".to_owned(),
    };
    let reasons = match &reasons(status)[..] {
        "" => String::new(),
        reasons => format!(": {reasons}"),
    };
    let advice = if status.needs_resume { "; R to resume" } else { "" };
    state + &reasons + advice
}

/// What shows the state and the sensors.
struct Panel {
    sensors: Vec<Sensors>,
    /// The latest readings of each kind.
    values: Vec<Option<Vec<f64>>>,
    has_keys: bool,
    start: Instant,
    /// What was shown last, and when.
    shown: Option<(Status, Instant)>,
    live: Live,
}

impl Panel {
    fn new(sensors: &[Sensors], is_script: bool, console: Console) -> Self {
        Self {
            sensors: sensors.to_vec(),
            values: vec![None; sensors.len()],
            has_keys: !is_script,
            start: Instant::now(),
            shown: None,
            live: Live::new(console),
        }
    }

    /// Takes readings.
    fn read(&mut self, kind: &str, values: &[f64]) {
        let sensors = self.sensors.iter().zip(&mut self.values);
        for (_, latest) in sensors.filter(|(sensors, _)| sensors.kind == kind) {
            *latest = Some(values.to_vec());
        }
    }

    /// Shows the state and the latest readings; at once if the state is another.
    fn show(&mut self, status: &Status, speed: f64) -> Result {
        let is_known = self.shown.as_ref().is_some_and(|(shown, at)| {
            let same =
                (shown.state, shown.cannot_stop, &shown.reasons) == (status.state, status.cannot_stop, &status.reasons);
            same && at.elapsed() < LINE
        });
        if is_known {
            return Ok(());
        }
        self.shown = Some((status.clone(), Instant::now()));
        self.live.show(|| self.text(status, speed), || self.line(status))
    }

    /// All sensors with a reading: the name, the sensors of its kind, and the reading.
    fn readings(&self) -> impl Iterator<Item = (&str, &Sensors, f64)> {
        let kinds = self.sensors.iter().zip(&self.values);
        let kinds = kinds.filter_map(|(sensors, values)| Some((sensors, values.as_ref()?)));
        kinds.flat_map(|(sensors, values)| {
            let names = sensors.names.iter().zip(values);
            names.map(move |(name, value)| (name.as_str(), sensors, *value))
        })
    }

    fn text(&self, status: &Status, speed: f64) -> String {
        let speeds = format!("left {:.0} mm/s, right {:.0} mm/s", status.left_mm_s, status.right_mm_s);
        let mut lines = vec![headline(status), speeds];
        if self.has_keys {
            lines.push(format!("speed {speed:.0} mm/s   {HELP}"));
        }
        lines.extend(
            self.readings()
                .map(|(name, sensors, value)| watch::row(name, &sensors.unit, sensors.range, value)),
        );
        lines.join("\n")
    }

    fn line(&self, status: &Status) -> Value {
        let values: Map<String, Value> = self
            .readings()
            .map(|(name, _, value)| (name.to_owned(), number(value)))
            .collect();
        json!({
            "time_s": self.start.elapsed().as_millis() as f64 / 1e3,
            "state": status.state,
            "left_mm_s": number(status.left_mm_s),
            "right_mm_s": number(status.right_mm_s),
            "reasons": status.reasons,
            "needs_resume": status.needs_resume,
            "cannot_stop": status.cannot_stop,
            "values": values,
        })
    }
}

/// Prints what would be sent, without a robot: the guard's decisions for one that always obeys. A file is gone through at
/// once.
fn rehearse(wire: &Wire, values: Values, driver: &mut Driver, console: Console) -> Result {
    console.say(format!("dry run: nothing is sent to {wire}"));
    driver.limit(values.speed_mm_s);
    let mut guard = Guard::new(values, f64::INFINITY);
    let (start, mut now, mut said) = (Instant::now(), Duration::ZERO, None);
    let mut confirmed = 1;
    guard.step(&Inputs {
        confirmed,
        ..Inputs::default()
    });
    loop {
        let wish = driver.wish(now)?;
        let mut inputs = Inputs {
            passed: CYCLE,
            command: Some(wish.speeds),
            resume: wish.resumes,
            confirmed,
            ..Inputs::default()
        };
        inputs.conditions.add(Condition::Operator, wish.stops);
        inputs.conditions.add(Condition::Closed, wish.over.is_some());
        let order = guard.step(&inputs);
        let [left, right] = guard.speeds();
        if said != Some([left, right]) {
            said = Some([left, right]);
            let time = now.as_millis() as f64 / 1e3;
            console.print_line(
                format!("{time:7.3} s: left {left:6.1} mm/s, right {right:6.1} mm/s"),
                &json!({ "time_s": time, "left_mm_s": number(left), "right_mm_s": number(right) }),
            )?;
        }
        if let Order::Stop(number) = order {
            confirmed = number;
        }
        match wish.over {
            Some(Over::Done) => return Ok(()),
            Some(Over::Cut) => return Err(Failure::stopped("stopped before the end of the commands")),
            None => {}
        }
        if driver.is_script() {
            now += CYCLE;
        } else {
            thread::sleep(CYCLE);
            now = start.elapsed();
        }
    }
}
