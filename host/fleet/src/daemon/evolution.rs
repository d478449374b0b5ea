//! The evolution on board: evaluates a robot's controllers in its simulator while the control thread runs, at low
//! priority and with a limited fraction of a processor.

use std::time::{Duration, Instant};

use oneiro::batch::Worlds;
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::swarm::SECOND;
use oneiro_base::exit::Result;
use oneiro_lab::swarm::Plan;
use oneiro_lab::swarm::on_board::OnBoard;

use super::beside::{Beside, rest};

/// The fitness of an interval's controllers.
#[derive(Clone, Debug)]
pub(super) struct Simulated {
    /// The interval.
    pub interval: u32,
    /// One for each controller.
    pub fitness: Vec<f32>,
    /// Time for which it kept a processor busy, at most.
    pub worked: Duration,
    /// Time from its beginning to its end.
    pub taken: Duration,
}

/// Evaluates a robot's controllers in its current simulator. After each simulated second it rests, so that it uses only
/// the fraction `share` of a processor.
///
/// # Errors
/// Those of the evaluator.
pub(super) fn simulate(
    plan: &Plan,
    robot: usize,
    on_board: &OnBoard,
    device: &mut dyn Evaluator,
    share: f64,
) -> Result<Simulated> {
    let (start, mut worked) = (Instant::now(), Duration::ZERO);
    let worlds = Worlds::new(&[plan.settings.simulator(on_board.scenario())])?;
    let rollouts: Vec<_> = on_board.rollouts(0, plan.seed, robot as u64).collect();
    let cycles = SECOND * plan.settings.clock.interval_s;
    let (mut states, mut fitness) = (Vec::new(), Vec::new());
    for cycle in (0..cycles).step_by(SECOND as usize) {
        let began = Instant::now();
        let batch = worlds.stretch(&rollouts, cycle..cycle + SECOND, &states, None)?;
        let outcome = device.evaluate(&batch, &Control::new())?;
        (states, fitness) = (outcome.states, outcome.fitness);
        let busy = began.elapsed();
        worked += busy;
        rest(busy, share);
    }
    Ok(Simulated {
        interval: on_board.interval(),
        fitness,
        worked,
        taken: start.elapsed(),
    })
}

/// A thread that evaluates, one interval after the other.
pub(super) struct Evolution {
    thread: Beside<OnBoard, Simulated>,
    /// The last requested interval.
    asked: Option<u32>,
}

impl Evolution {
    /// Starts the thread, for a robot that may use the fraction `share` of one processor.
    pub(super) fn start(plan: Plan, robot: usize, share: f64) -> Self {
        let mut cpu = None;
        let thread = Beside::start(move |on_board| {
            let cpu = match &mut cpu {
                Some(cpu) => cpu,
                none => none.insert(Cpu::new(Some(1))?),
            };
            simulate(&plan, robot, &on_board, cpu, share)
        });
        Self { thread, asked: None }
    }

    /// Asks for the controllers of a robot's interval to be evaluated, once.
    pub(super) fn ask(&mut self, on_board: &OnBoard) {
        if on_board.is_to_simulate() && self.asked.replace(on_board.interval()) != Some(on_board.interval()) {
            self.thread.ask(on_board.clone());
        }
    }

    /// The result, if there is one; waits for it if `must_wait`.
    ///
    /// # Errors
    /// Those of the evaluator.
    pub(super) fn result(&self, must_wait: bool) -> Result<Option<Simulated>> {
        self.thread.result(must_wait)
    }
}
