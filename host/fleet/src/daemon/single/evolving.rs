//! The evolution in the simulator while the robot acts.

use std::time::{Duration, Instant};

use oneiro::cpu::Cpu;
use oneiro_base::exit::Result;
use oneiro_evolve::Champion;
use oneiro_lab::runs::single::on_board::OnBoard;

use crate::daemon::beside::{Beside, rest};

/// Minimum work between two rests: a shorter rest would take longer than it should.
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

/// The thread. On each request it evolves some generations, with a fraction of one processor.
pub(super) fn start(mut on_board: OnBoard, generations: u32, share: f64) -> Beside<(), Evolved> {
    let mut cpu = None;
    Beside::start(move |()| {
        let cpu = match &mut cpu {
            Some(cpu) => cpu,
            none => none.insert(Cpu::new(Some(1))?),
        };
        evolved(&mut on_board, cpu, generations, share)
    })
}

/// Evolves some generations, or as many as are left.
fn evolved(on_board: &mut OnBoard, cpu: &mut Cpu, generations: u32, share: f64) -> Result<Evolved> {
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
        if on_board.is_over() {
            break;
        }
        on_board.breed(cpu, &mut pause)?;
    }
    Ok(Evolved {
        best: on_board.best().cloned(),
        saved: on_board.save(),
        generation: on_board.generation(),
        is_over: on_board.is_over(),
        worked: worked + began.elapsed(),
        taken: start.elapsed(),
    })
}
