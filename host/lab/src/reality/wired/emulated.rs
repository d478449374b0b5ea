//! An emulated Khepera, byte by byte on a virtual clock, whose body is a surrogate. For tests.

use std::time::Duration;

use oneiro::arena::Arena;
use oneiro::random::Key;
use oneiro_robots::Kind;
use oneiro_robots::emulated::Bench;
use oneiro_robots::emulated::khepera::surrogate::Simulated;
use oneiro_robots::emulated::khepera::{Firmware, Khepera};
use oneiro_robots::khepera;
use oneiro_robots::vehicle::direct::Direct;
use oneiro_robots::vehicle::trouble::Trouble;
use oneiro_robots::vehicle::{Moment, Profile, Vehicle};

#[cfg(test)]
mod tests;

pub const SEED: u64 = 5;
/// A line that takes no time: 2 ns for a byte, the shortest possible.
pub const INSTANT: u32 = 4_000_000_000;

/// A robot that is placed where episodes start, with a record of its readings and commands.
pub struct Watched {
    own: Direct<Bench<Simulated>>,
    pub bench: Bench<Simulated>,
    /// Start of the next episode, and the key of its noise.
    pub next: ([f32; 3], Key),
    /// The user stops it after as many looks.
    pub looks: usize,
    readings: Vec<Vec<f64>>,
    /// Units that have arrived.
    units: Vec<[i32; 2]>,
    /// Where the body was at each look.
    poses: Vec<[f32; 3]>,
}

impl Vehicle for Watched {
    fn profile(&self) -> &Profile {
        self.own.profile()
    }

    fn now(&self) -> Duration {
        self.own.now()
    }

    fn look(&mut self) -> Result<Moment, Trouble> {
        if self.readings.len() >= self.looks {
            self.own.stop()?;
            return Err(Trouble::Stopped);
        }
        let moment = self.own.look()?;
        self.readings.push(moment.readings.clone());
        self.poses.push(self.bench.line().robot.body.pose);
        Ok(moment)
    }

    fn drive(&mut self, speeds: [f64; 2]) -> Result<(), Trouble> {
        self.own.drive(speeds)?;
        self.units.push(self.bench.line().robot.speeds());
        Ok(())
    }

    fn keep_until(&mut self, until: Duration) -> Result<(), Trouble> {
        self.own.keep_until(until)
    }

    fn stop(&mut self) -> Result<(), Trouble> {
        self.own.stop()
    }

    fn ask(&mut self, _: &str) -> Result<(), Trouble> {
        let body = &mut self.bench.line().robot.body;
        body.key = self.next.1;
        body.place(self.next.0);
        Ok(())
    }

    fn recover(&mut self) -> Result<(), Trouble> {
        self.own.recover()
    }
}

/// Connects to a new robot in the paper's arena.
pub fn connected(baud: u32) -> Watched {
    let body = Simulated::new(SEED, Arena::miglino1995(), [100.0, 90.0, 0.0]);
    let bench = Bench::new(Khepera::new(body, Firmware::ALL[0], baud));
    let mut robot = khepera::Khepera::new(Box::new(bench.clone()));
    robot.begin().unwrap();
    Watched {
        own: Direct::new(Box::new(robot), bench.clone(), &[Kind::Proximity]),
        bench,
        next: ([0.0; 3], Key::default()),
        looks: usize::MAX,
        readings: Vec::new(),
        units: Vec::new(),
        poses: Vec::new(),
    }
}
