//! The evolution on board: evaluates a robot's controllers in its simulator beside the control thread, at low priority and with a
//! bounded share of a processor.

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
pub struct Simulated {
    /// The interval.
    pub interval: u32,
    /// One for each controller.
    pub fitness: Vec<f32>,
    /// Time for which it kept a processor busy, at most.
    pub worked: Duration,
    /// Time from its beginning to its end.
    pub taken: Duration,
}

/// Evaluates the controllers of a robot in its present simulator. After each second of their lives it rests for as long as
/// leaves others the rest of a processor, of which it uses `share`.
///
/// # Errors
/// Those of the evaluator.
pub fn simulate(plan: &Plan, robot: usize, own: &OnBoard, device: &mut dyn Evaluator, share: f64) -> Result<Simulated> {
    let (start, mut worked) = (Instant::now(), Duration::ZERO);
    let worlds = Worlds::new(&[plan.settings.simulator(own.scenario())])?;
    let rollouts: Vec<_> = own.rollouts(0, plan.seed, robot as u64).collect();
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
        interval: own.interval(),
        fitness,
        worked,
        taken: start.elapsed(),
    })
}

/// A thread that evaluates, one interval after the other.
pub struct Evolution {
    thread: Beside<OnBoard, Simulated>,
    /// The interval that was asked for last.
    asked: Option<u32>,
}

impl Evolution {
    /// Starts the thread, for a robot that may use a share of one processor.
    pub fn start(plan: Plan, robot: usize, share: f64) -> Self {
        let mut cpu = None;
        let thread = Beside::start(move |own| {
            let cpu = match &mut cpu {
                Some(cpu) => cpu,
                none => none.insert(Cpu::new(Some(1))?),
            };
            simulate(&plan, robot, &own, cpu, share)
        });
        Self { thread, asked: None }
    }

    /// Asks for the controllers of a robot's interval to be evaluated, once.
    pub fn ask(&mut self, own: &OnBoard) {
        if own.is_to_simulate() && self.asked.replace(own.interval()) != Some(own.interval()) {
            self.thread.ask(own.clone());
        }
    }

    /// The result, if there is one; waits for it if `must_wait`.
    ///
    /// # Errors
    /// Those of the evaluator.
    pub fn result(&self, must_wait: bool) -> Result<Option<Simulated>> {
        self.thread.result(must_wait)
    }
}
