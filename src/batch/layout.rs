//! The layout of a batch: which slot each episode has, and what kernels read of it there.

use oneiro_shaders::episode;
use rayon::prelude::*;

use super::{Facts, GREATEST_GENE, KEY_WORDS, LANES, LEAST_GENE, Rollout, Variants, input_words};
use crate::parameter::Invalid;

/// Most episodes of a batch.
const GREATEST: usize = 1 << 28;

/// The worlds of a batch, and where each is among the packed ones.
#[derive(Clone, Copy)]
pub(super) struct Places<'a> {
    /// The first packed variant of each, and how an episode chooses one.
    pub(super) worlds: &'a [(usize, Variants)],
    /// Facts of each packed world.
    pub(super) facts: &'a [Facts],
}

impl Places<'_> {
    /// The packed world of an episode, in a world that there is.
    fn packed(&self, rollout: &Rollout<'_>) -> usize {
        let (first, variants) = self.worlds[rollout.world];
        first + variants.of(rollout.key)
    }
}

/// Episodes in their slots.
pub(super) struct Layout {
    pub(super) groups: Vec<episode::Group>,
    /// Slot of each episode.
    pub(super) slots: Vec<u32>,
    /// Inputs of the groups: for each field 64 values, first the words of the keys, then the genes.
    pub(super) inputs: Vec<u32>,
}

impl Layout {
    /// Checks episodes and lays them out, list after list. Lists are laid out at the same time, on all processors.
    pub(super) fn new(worlds: Places<'_>, lists: &[&[Rollout<'_>]]) -> Result<Self, Invalid> {
        let facts = worlds.facts;
        let mut count = 0;
        let firsts: Vec<usize> = lists.iter().map(|list| replaced_sum(&mut count, list.len())).collect();
        if count == 0 || count > GREATEST {
            let problem = format!("there are {count}; allowed: 1 to {GREATEST}");
            return Err(Invalid::new("rollouts", problem));
        }
        let counts = on_all(lists.iter().zip(&firsts).collect(), |(list, first)| {
            counted(worlds, list, *first)
        })?;
        let (groups, words, mut next) = grouped(facts, &counts)?;

        let mut slots = vec![0; count];
        let mut rest = &mut slots[..];
        let mut tasks = Vec::with_capacity(lists.len());
        for ((list, first), counts) in lists.iter().zip(firsts).zip(counts) {
            let (of_list, others) = std::mem::take(&mut rest).split_at_mut(list.len());
            rest = others;
            let begins = next
                .iter_mut()
                .zip(counts)
                .map(|(next, count)| replaced_sum(next, count));
            tasks.push((*list, first, of_list, begins.collect::<Vec<_>>()));
        }
        let mut inputs: Vec<u32> = Vec::with_capacity(words);
        let lanes = Lanes(inputs.as_mut_ptr());
        lanes.clear_idle(facts, &groups);
        on_all(tasks, |(list, first, slots, next)| {
            lanes.fill(worlds, &groups, list, first, slots, next)
        })?;
        // SAFETY: every word has been written: those of the slots that episodes have, each by its episode, and the others by
        // `clear_idle`.
        unsafe { inputs.set_len(words) };
        Ok(Self { groups, slots, inputs })
    }
}

/// Adds to a sum, and returns what it was.
fn replaced_sum(sum: &mut usize, more: usize) -> usize {
    *sum += more;
    *sum - more
}

/// Does tasks on all processors, or on this thread if there is only one. Of several errors it returns that of the first task.
fn on_all<T: Send, R: Send>(
    tasks: Vec<T>,
    work: impl Fn(T) -> Result<R, Invalid> + Send + Sync,
) -> Result<Vec<R>, Invalid> {
    let done: Vec<Result<R, Invalid>> = if tasks.len() > 1 {
        tasks.into_par_iter().with_max_len(1).map(work).collect()
    } else {
        tasks.into_iter().map(work).collect()
    };
    done.into_iter().collect()
}

/// Number of a list's episodes in each packed world. `first` is the index of its first one.
fn counted(worlds: Places<'_>, list: &[Rollout<'_>], first: usize) -> Result<Vec<usize>, Invalid> {
    let mut counts = vec![0; worlds.facts.len()];
    let known = worlds.worlds.len();
    for (rollout, index) in list.iter().zip(first..) {
        if rollout.world >= known {
            let problem = format!("is {}; allowed: 0 to {}", rollout.world, known - 1);
            return Err(Invalid::new(format!("rollouts[{index}].world"), problem));
        }
        counts[worlds.packed(rollout)] += 1;
    }
    Ok(counts)
}

/// Makes the groups for `counts` episodes of each list in each world. Also returns the number of input words, and the first slot of
/// each world.
fn grouped(facts: &[Facts], counts: &[Vec<usize>]) -> Result<(Vec<episode::Group>, usize, Vec<usize>), Invalid> {
    let mut groups = Vec::new();
    let mut words = 0_usize;
    let mut slots = Vec::with_capacity(facts.len());
    for (world, facts) in facts.iter().enumerate() {
        slots.push(groups.len() * LANES);
        let count: usize = counts.iter().map(|counts| counts[world]).sum();
        for first in (0..count).step_by(LANES) {
            groups.push(episode::Group {
                world: world as u32,
                rollouts: (count - first).min(LANES) as u32,
                inputs: words as u32,
            });
            words += (KEY_WORDS + facts.genes) * LANES;
        }
    }
    if words > u32::MAX as usize {
        let problem = format!(
            "their genes and keys fill {words} words; allowed: up to {}: evaluate several batches",
            u32::MAX
        );
        return Err(Invalid::new("rollouts", problem));
    }
    Ok((groups, words, slots))
}

/// The inputs of all slots while they are written for the first time, by several threads.
struct Lanes(*mut u32);

// SAFETY: slots share no words, and only one thread writes a slot: that of the list whose episode has it.
unsafe impl Sync for Lanes {}

impl Lanes {
    /// Writes a word.
    ///
    /// # Safety
    /// It is one of the inputs, and no other thread writes it.
    unsafe fn put(&self, word: usize, value: u32) {
        // SAFETY: as the caller promises.
        unsafe { self.0.add(word).write(value) };
    }

    /// Clears the slots that no episode has.
    fn clear_idle(&self, facts: &[Facts], groups: &[episode::Group]) {
        for group in groups {
            let fields = KEY_WORDS + facts[group.world as usize].genes;
            for lane in group.rollouts as usize..LANES {
                for field in 0..fields {
                    // SAFETY: each of the group's `fields` fields has `LANES` words, and no episode has this lane.
                    unsafe { self.put(group.inputs as usize + field * LANES + lane, 0) };
                }
            }
        }
    }

    /// Checks a list's episodes, gives each the next slot of its world, and writes its inputs there. `first` is the index of the
    /// first episode, and `next` this list's first slot in each world.
    fn fill(
        &self,
        worlds: Places<'_>,
        groups: &[episode::Group],
        list: &[Rollout<'_>],
        first: usize,
        slots: &mut [u32],
        mut next: Vec<usize>,
    ) -> Result<(), Invalid> {
        for ((rollout, slot), index) in list.iter().zip(slots).zip(first..) {
            let world = worlds.packed(rollout);
            let slot_of_episode = replaced_sum(&mut next[world], 1);
            *slot = slot_of_episode as u32;
            if rollout.genes.len() != worlds.facts[world].genes {
                return Err(bad_genes(index, rollout.genes, worlds.facts[world].genes));
            }
            // Strided writes stay within a group's few kilobytes.
            let lane = groups[slot_of_episode / LANES].inputs as usize + slot_of_episode % LANES;
            let mut is_good = true;
            // SAFETY: these are the words of this slot, in a group that has as many fields as there are words of a key and genes
            // of an episode in this world. The slot is this episode's alone: lists have as many slots of a world as they have
            // episodes in it.
            unsafe {
                for (field, word) in input_words(rollout.key).into_iter().enumerate() {
                    self.put(lane + field * LANES, word);
                }
                for (&gene, field) in rollout.genes.iter().zip(KEY_WORDS..) {
                    // NaN isn't within. Without a branch for each gene.
                    is_good &= gene.abs() <= GREATEST_GENE;
                    self.put(lane + field * LANES, canonical(gene).to_bits());
                }
            }
            if !is_good {
                return Err(bad_genes(index, rollout.genes, worlds.facts[world].genes));
            }
        }
        Ok(())
    }
}

/// Converts a gene to the kernels' form.
fn canonical(gene: f32) -> f32 {
    if gene.abs() < LEAST_GENE { 0.0 } else { gene }
}

/// Says what is wrong with an episode's genes, of which there should be `count`.
fn bad_genes(rollout: usize, genes: &[f32], count: usize) -> Invalid {
    if genes.len() != count {
        let problem = format!(
            "there are {}; allowed: {count}, for its world's controller",
            genes.len()
        );
        return Invalid::new(format!("rollouts[{rollout}].genes"), problem);
    }
    let within = |gene: &f32| gene.abs() <= GREATEST_GENE;
    let bad = genes.iter().position(|gene| !within(gene)).unwrap_or_default();
    let problem = format!("is {}; allowed: -{GREATEST_GENE} to {GREATEST_GENE}", genes[bad]);
    Invalid::new(format!("rollouts[{rollout}].genes[{bad}]"), problem)
}
