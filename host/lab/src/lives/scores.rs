//! The task's score of each robot in episodes of swarms.

use oneiro::batch::{LANES, Rollout, TraceRequest, Worlds};
use oneiro::compose::DetailKind;
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator as _};
use oneiro_base::exit::Result;

use super::measures::Descriptor;
use super::{Chunk, GROUPS, Lives};

/// Words of states in memory at a time, 256 MB.
const WORDS: usize = 64 << 20;

/// The measures with the robots' scores; none for single robots, or if only a mission scores the swarm as a whole.
pub fn descriptors(lives: &Lives<'_>) -> Vec<Descriptor> {
    let world = &lives.worlds[0];
    let is_scored = world.robots() > 1 && world.spec().own.scores_each();
    let robots = if is_scored { world.robots() } else { 0 };
    (0..robots).map(Descriptor::score).collect()
}

/// The score of each robot in each episode of `cycles` cycles, by genome.
///
/// # Errors
/// A world whose robots can't be observed; the processor's.
pub fn by_robot(lives: &Lives<'_>, cycles: u32, threads: Option<usize>, control: &Control) -> Result<Vec<Vec<f32>>> {
    // Every device gives the same scores. The code requested by the user may exist only for unobserved worlds.
    let mut cpu = Cpu::new(threads)?;
    let world = lives.worlds[0].observed()?;
    let details = world.details();
    let place = details.iter().position(|own| own.kind == DetailKind::Earned);
    let place = place.expect("each robot is scored");
    let worlds = Worlds::new(std::slice::from_ref(&world))?;
    let groups = (WORDS / LANES / worlds.state_words()).clamp(1, GROUPS);
    let mut all = vec![Vec::new(); lives.genomes.len() * lives.count];
    for chunk in lives.chunks(groups) {
        let rollouts: Vec<Rollout<'_>> = lives.rollouts(&chunk);
        // A robot's record has its earnings since the record before: only the last cycle has one.
        let mut states = Vec::new();
        if cycles > 1 {
            let batch = worlds.stretch(&rollouts, 0..cycles - 1, &states, None)?;
            states = cpu.evaluate(&batch, control)?.states;
        }
        let batch = worlds.stretch(&rollouts, cycles - 1..cycles, &states, Some(TraceRequest { every: 1 }))?;
        let outcome = cpu.evaluate(&batch, control)?;
        let Chunk { lives: numbers, .. } = chunk;
        for (life, trace) in numbers.zip(&outcome.traces) {
            let robots = trace.by_robot(world.robots());
            let scores = robots.iter().map(|own| f32::from_bits(own.details(0)[place]));
            all[lives.place(life)] = scores.collect();
        }
    }
    Ok(all)
}
