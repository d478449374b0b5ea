//! What evolves in the simulator beside the robot.

use std::time::{Duration, Instant};

use oneiro::cpu::Cpu;
use oneiro_base::exit::Result;
use oneiro_evolve::Champion;
use oneiro_lab::runs::single::on_board::OnBoard;

use crate::daemon::beside::{Beside, rest};

/// Work from one rest to the next, at least: a shorter rest would take longer than it should.
const SPELL: Duration = Duration::from_millis(10);

/// What some generations leave.
#[derive(Clone, Debug)]
pub(super) struct Evolved {
    /// The best of the last of them.
    pub(super) best: Option<Champion>,
    /// All that is needed to continue.
    pub(super) saved: Vec<u8>,
    /// How many generations have been evaluated.
    pub(super) generation: u32,
    /// Whether that is all.
    pub(super) is_over: bool,
    /// Time for which it kept a processor busy, at most, and time from its beginning to its end.
    pub(super) worked: Duration,
    pub(super) taken: Duration,
}

/// The thread. Each time it is asked, it evolves some generations, with a share of one processor.
pub(super) fn start(mut own: OnBoard, generations: u32, share: f64) -> Beside<(), Evolved> {
    let mut cpu = None;
    Beside::start(move |()| {
        let cpu = match &mut cpu {
            Some(cpu) => cpu,
            none => none.insert(Cpu::new(Some(1))?),
        };
        evolved(&mut own, cpu, generations, share)
    })
}

/// Evolves some generations, or as many as are left.
fn evolved(own: &mut OnBoard, cpu: &mut Cpu, generations: u32, share: f64) -> Result<Evolved> {
    let (start, mut worked) = (Instant::now(), Duration::ZERO);
    let mut began = start;
    let mut pause = || {
        let busy = began.elapsed();
        if busy >= SPELL {
            worked += busy;
            rest(busy, share);
            began = Instant::now();
        }
    };
    for _ in 0..generations {
        if own.is_over() {
            break;
        }
        own.breed(cpu, &mut pause)?;
    }
    Ok(Evolved {
        best: own.best().cloned(),
        saved: own.save(),
        generation: own.generation(),
        is_over: own.is_over(),
        worked: worked + began.elapsed(),
        taken: start.elapsed(),
    })
}
