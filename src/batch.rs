//! Batches: episodes in any mix of worlds, checked and packed once, to be evaluated in one call.

mod layout;
mod packing;
mod trace;

use std::ops::Range;
use std::sync::Arc;

/// One record of a trace: the pose at the start of a cycle, and the resulting action and reward.
pub use oneiro_shaders::episode::Record;
use oneiro_shaders::{Kernel, episode};
use rayon::prelude::*;

use crate::parameter::Invalid;
use crate::random::{Key, pcg4d};

use layout::{Layout, Places};
use packing::Packed;
pub use packing::{Buffers, WorldKind};
pub use trace::{Trace, parts_of};

/// Episodes per group: the kernels' workgroup size.
pub const LANES: usize = episode::LANES as usize;

/// Maximum magnitude of a gene, so that no sum in a controller overflows.
pub const GREATEST_GENE: f32 = 1e6;

/// Genes of smaller magnitude than this (2^-40) count as 0, as does zero of either sign. A gene times a unit's output,
/// at least 2^-63, is then a multiple of 2^-126, and so is every sum of such products: none is subnormal.
pub const LEAST_GENE: f32 = 1.0 / (1_u64 << 40) as f32;

/// Most words in all traces of a batch: 2.7 GB.
pub const GREATEST_TRACE: u64 = 640 << 20;

/// Most iterations of all loops in a cycle of a kernel composed at run time, and of each robot in the beginning of an episode.
pub const GREATEST_TURNS: u32 = 100_000;

/// The same for each robot of a swarm, which may look at all others again and again.
const GREATEST_TURNS_EACH: u32 = 20_000;

/// Most episodes that one thread lays out at a time.
const PIECE: usize = 4096;

/// Words of a group's keys, which precede its genes.
pub(crate) const KEY_WORDS: usize = episode::KEY_WORDS as usize;

/// A key as the kernels read it.
pub(crate) fn input_words(key: Key) -> [u32; KEY_WORDS] {
    let [low, high] = key.words;
    [low, high, key.trial]
}

/// A genome's episode in a world, with the random numbers of one key.
#[derive(Clone, Copy, Debug)]
pub struct Rollout<'a> {
    /// Index of its world.
    pub world: usize,
    /// As many genes as its world's controller takes, each of magnitude [`GREATEST_GENE`] at most. For a world of
    /// several robots, the output of [`crate::swarm::Swarm::inputs`].
    pub genes: &'a [f32],
    /// Key of its random numbers.
    pub key: Key,
}

/// The choice of an episode's variant of a world, by the episode's key alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Variants {
    /// Starts: trial after trial takes the next one.
    pub starts: u32,
    /// Worlds drawn beforehand, each with all starts. Each trial of a generation takes one at random, the same for all individuals,
    /// so that these are compared in the same worlds.
    pub drawn: u32,
}

impl Default for Variants {
    fn default() -> Self {
        Self { starts: 1, drawn: 1 }
    }
}

impl Variants {
    /// Number of variants.
    pub fn count(self) -> usize {
        self.starts as usize * self.drawn as usize
    }

    /// The variant of an episode.
    pub fn of(self, key: Key) -> usize {
        /// Distinguishes these random numbers from all others.
        const STREAM: u32 = 0x0057_4f52;
        let start = (key.trial % self.starts) as usize;
        if self.drawn == 1 {
            return start;
        }
        let [word, ..] = pcg4d([key.generation, key.trial, 0, STREAM]);
        let drawn = (u64::from(word) * u64::from(self.drawn)) >> u32::BITS;
        drawn as usize * self.starts as usize + start
    }
}

/// Requests a trace of each episode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TraceRequest {
    /// Record every Nth cycle, from 1, beginning with the first simulated cycle. Worlds of several robots have a line after
    /// every Nth cycle.
    pub every: u32,
}

/// Worlds packed as the kernels read them, once for any number of batches. Cheap to clone.
///
/// The worlds of a batch have one kernel, so all single robots have the same kind of controller.
#[derive(Clone, Debug)]
pub struct Worlds(Arc<PackedWorlds>);

#[derive(Debug)]
struct PackedWorlds {
    kernel: &'static Kernel,
    /// The first packed variant of each world, and how an episode chooses one.
    worlds: Vec<(usize, Variants)>,
    /// Facts of each packed world.
    facts: Vec<Facts>,
    /// Words that each slot keeps between dispatches, and words per record of its trace.
    state_words: u32,
    record_words: u32,
    packed: Packed,
}

/// Properties of a world that batches need, besides its packed values.
#[derive(Clone, Copy, Debug)]
struct Facts {
    /// Genes of an episode.
    genes: usize,
    /// Robots of an episode.
    robots: u32,
    /// Whether an episode may be shorter than its world says.
    may_end_early: bool,
    /// Most iterations of all loops in one cycle, and in the beginning of an episode.
    loops: u32,
    begin_loops: u32,
}

impl Facts {
    fn of(world: &impl WorldKind, index: usize, packed: &Packed) -> Self {
        let turns = |cycles| packed.turns(world.kernel(), index, cycles);
        let begin_loops = turns(0);
        Self {
            genes: world.genes(),
            robots: world.robots(),
            may_end_early: world.may_end_early(),
            loops: turns(1).saturating_sub(begin_loops),
            begin_loops,
        }
    }
}

impl Worlds {
    /// Checks and packs worlds: values of one type that implements [`WorldKind`], or references to values of several
    /// types (`&dyn WorldKind`).
    ///
    /// # Errors
    /// No world; the first invalid value; worlds of different kernels.
    pub fn new<W: WorldKind>(worlds: &[W]) -> Result<Self, Invalid> {
        let Some(first) = worlds.first() else {
            return Err(Invalid::new("worlds", "is empty; allowed: at least one"));
        };
        let kernel = first.kernel();
        for (index, world) in worlds.iter().enumerate() {
            world
                .check()
                .map_err(|invalid| Invalid::new(format!("worlds[{index}].{}", invalid.field), invalid.problem))?;
            if world.kernel().name != kernel.name {
                let problem = format!(
                    "is {}, but the first world's is {}; allowed: one kernel per batch",
                    world.kernel().name,
                    kernel.name
                );
                return Err(Invalid::new(format!("worlds[{index}].kernel"), problem));
            }
        }
        let packed = Packed::new(worlds);
        let mut facts: Vec<Facts> = Vec::new();
        let mut places = Vec::with_capacity(worlds.len());
        for world in worlds {
            let (first, variants) = (facts.len(), world.variants());
            places.push((first, variants));
            facts.extend((first..first + variants.count()).map(|index| Facts::of(world, index, &packed)));
        }
        // Shipped kernels are within bounds.
        let too_long = |facts: &Facts| {
            let in_cycle = (
                facts.loops,
                GREATEST_TURNS.max(GREATEST_TURNS_EACH * facts.robots),
                "a cycle",
            );
            let at_first = (facts.begin_loops, GREATEST_TURNS * facts.robots, "as an episode begins");
            [in_cycle, at_first].into_iter().find(|(turns, most, _)| turns > most)
        };
        let long = |(place, facts)| too_long(facts).map(|found| (place, found));
        let long = facts
            .iter()
            .enumerate()
            .filter(|_| kernel.variants.is_empty())
            .find_map(long);
        if let Some((long, (turns, most, when))) = long {
            let index = places.iter().rposition(|(first, _)| *first <= long).unwrap_or(0);
            let problem =
                format!("loops up to {turns} times {when}; allowed: at most {most}, so that a run can be stopped");
            return Err(Invalid::new(format!("worlds[{index}].kernel"), problem));
        }
        let most = |words: fn(&W) -> u32| worlds.iter().map(words).max().unwrap_or(0);
        Ok(Self(Arc::new(PackedWorlds {
            kernel,
            worlds: places,
            facts,
            state_words: most(W::state_words),
            record_words: most(W::record_words),
            packed,
        })))
    }

    /// Checks and packs whole episodes in these worlds.
    ///
    /// # Errors
    /// No episode, or too many; an unknown world; genes that are too many, too few, not finite or beyond
    /// [`GREATEST_GENE`]; a trace with more than [`GREATEST_TRACE`] words.
    pub fn batch(&self, rollouts: &[Rollout<'_>], trace: Option<TraceRequest>) -> Result<Batch, Invalid> {
        self.episodes(&pieces([rollouts]), 0..u32::MAX, &[], false, trace)
    }

    /// As [`Worlds::batch`], of the first `cycles` cycles of each episode, whose states are not kept.
    ///
    /// # Errors
    /// As [`Worlds::batch`], and no cycle.
    pub fn beginnings(&self, rollouts: &[Rollout<'_>], cycles: u32) -> Result<Batch, Invalid> {
        if cycles == 0 {
            return Err(Invalid::new("cycles", "are 0; allowed: at least 1"));
        }
        self.episodes(&pieces([rollouts]), 0..cycles, &[], false, None)
    }

    /// As [`Worlds::batch`], of episodes in several lists, one after the other. They are packed at the same time.
    ///
    /// # Errors
    /// As [`Worlds::batch`].
    pub fn batch_of(&self, lists: &[Vec<Rollout<'_>>], trace: Option<TraceRequest>) -> Result<Batch, Invalid> {
        self.episodes(&pieces(lists.iter().map(Vec::as_slice)), 0..u32::MAX, &[], false, trace)
    }

    /// Checks and packs a stretch of episodes, given by its first cycle and number of cycles, and requests the states for
    /// continuing them. `states` has each episode's state after the previous stretch, or is empty if episodes begin. Genes
    /// and keys may have changed since.
    ///
    /// # Errors
    /// As [`Worlds::batch`], and an empty stretch, an episode that has ended by its start, or states that don't
    /// fit the episodes.
    pub fn stretch(
        &self,
        rollouts: &[Rollout<'_>],
        cycles: Range<u32>,
        states: &[Vec<u32>],
        trace: Option<TraceRequest>,
    ) -> Result<Batch, Invalid> {
        self.continued(&pieces([rollouts]), cycles, states, trace)
    }

    /// As [`Worlds::stretch`], of episodes in several lists, one after the other. They are packed at the same time.
    ///
    /// # Errors
    /// As [`Worlds::stretch`].
    pub fn stretch_of(
        &self,
        lists: &[Vec<Rollout<'_>>],
        cycles: Range<u32>,
        states: &[Vec<u32>],
        trace: Option<TraceRequest>,
    ) -> Result<Batch, Invalid> {
        self.continued(&pieces(lists.iter().map(Vec::as_slice)), cycles, states, trace)
    }

    fn continued(
        &self,
        lists: &[&[Rollout<'_>]],
        cycles: Range<u32>,
        states: &[Vec<u32>],
        trace: Option<TraceRequest>,
    ) -> Result<Batch, Invalid> {
        if cycles.is_empty() {
            let problem = format!("are {} to {}; allowed: at least 1", cycles.start, cycles.end);
            return Err(Invalid::new("cycles", problem));
        }
        let words = self.0.state_words as usize;
        let rollouts = || lists.iter().copied().flatten();
        let all = rollouts().count();
        let count = if cycles.start == 0 { 0 } else { all };
        if states.len() != count || states.iter().any(|state| state.len() != words) {
            let problem = format!(
                "there are {} for {} episodes from cycle {} on; allowed: {count}, each of {words} words",
                states.len(),
                all,
                cycles.start
            );
            return Err(Invalid::new("states", problem));
        }
        let ended = |rollout: &Rollout<'_>| {
            let world = self.0.worlds.get(rollout.world);
            world.is_some_and(|(first, _)| self.0.packed.worlds[*first].steps <= cycles.start)
        };
        if let Some(index) = rollouts().position(ended) {
            let problem = format!("has ended by cycle {}; allowed: longer episodes", cycles.start);
            return Err(Invalid::new(format!("rollouts[{index}]"), problem));
        }
        self.episodes(lists, cycles, states, true, trace)
    }

    fn episodes(
        &self,
        lists: &[&[Rollout<'_>]],
        cycles: Range<u32>,
        states: &[Vec<u32>],
        keeps_states: bool,
        trace: Option<TraceRequest>,
    ) -> Result<Batch, Invalid> {
        let PackedWorlds {
            worlds, facts, packed, ..
        } = &*self.0;
        let Layout { groups, slots, inputs } = Layout::new(Places { worlds, facts }, lists)?;
        let mut batch = Batch {
            worlds: self.clone(),
            groups,
            inputs,
            slots,
            states: Vec::new(),
            keeps_states,
            trace_every: trace.map_or(0, |trace| trace.every),
            cycles,
        };
        if trace.is_some_and(|trace| trace.every == 0) {
            return Err(Invalid::new("trace.every", "is 0; allowed: at least 1 cycle"));
        }
        let longest = batch
            .groups
            .iter()
            .map(|group| packed.worlds[group.world as usize].steps);
        batch.cycles.end = batch.cycles.end.min(longest.max().unwrap_or(0));
        let words = batch.trace_words() as u64 * batch.groups.len() as u64 * LANES as u64;
        if words > GREATEST_TRACE {
            let problem =
                format!("{words} words in all; allowed: up to {GREATEST_TRACE}: trace fewer episodes, or less often");
            return Err(Invalid::new("trace", problem));
        }
        if !states.is_empty() {
            let words = self.0.state_words as usize;
            let place = self.places("state", words);
            batch.states = vec![0; batch.groups.len() * LANES * words];
            for (state, &slot) in states.iter().zip(&batch.slots) {
                for (word, &value) in state.iter().enumerate() {
                    batch.states[place(slot as usize, word)] = value;
                }
            }
        }
        Ok(batch)
    }

    /// Finds words in the kernel's buffer `state` or `trace`, which has `words` words per slot: the index of a slot's word, given both
    /// numbers. Buffers of structs keep the words of a slot together; buffers of single words keep the same word of a group's slots
    /// together.
    pub(crate) fn places(&self, buffer: &str, words: usize) -> impl Fn(usize, usize) -> usize + use<> {
        let is_together = self.0.kernel.stride(buffer) != size_of::<u32>();
        move |slot, word| {
            if is_together {
                slot * words + word
            } else {
                (slot / LANES * words + word) * LANES + slot % LANES
            }
        }
    }

    /// A cycle of episodes that are commanded from outside, see [`crate::stepped`]: their groups, inputs and states.
    pub(crate) fn commanded(&self, groups: Vec<episode::Group>, inputs: Vec<u32>, states: Vec<u32>) -> Batch {
        Batch {
            worlds: self.clone(),
            slots: Vec::new(),
            groups,
            inputs,
            states,
            keeps_states: true,
            trace_every: 1,
            cycles: 0..1,
        }
    }

    /// Kernel that simulates them.
    pub fn kernel(&self) -> &'static Kernel {
        self.0.kernel
    }

    #[cfg(feature = "compose")]
    /// Them as the kernel reads them.
    pub(crate) fn packed(&self) -> &Packed {
        &self.0.packed
    }

    /// Whether both have the same packed worlds, even if they were packed separately.
    #[cfg(all(
        feature = "compose",
        any(feature = "gpu", feature = "native"),
        not(target_family = "wasm")
    ))]
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || self.0.packed.is_same(&other.0.packed)
    }

    /// Words that each episode keeps between stretches.
    pub fn state_words(&self) -> usize {
        self.0.state_words as usize
    }

    /// Words per record of a trace.
    pub fn record_words(&self) -> usize {
        self.0.record_words as usize
    }

    /// Number of genes of an episode in each world.
    pub fn genes(&self) -> Vec<usize> {
        self.0
            .worlds
            .iter()
            .map(|(first, _)| self.0.facts[*first].genes)
            .collect()
    }
}

/// Lists of episodes in pieces that are worth a thread each.
fn pieces<'a>(lists: impl IntoIterator<Item = &'a [Rollout<'a>]>) -> Vec<&'a [Rollout<'a>]> {
    lists.into_iter().flat_map(|list| list.chunks(PIECE)).collect()
}

/// Checked episodes, packed as the kernels read them: in groups of 64 slots that share a world. Episodes keep their
/// order within a world; a world's last group may have idle slots.
///
/// The worlds of a batch have one kernel, see [`Worlds`].
#[derive(Debug)]
pub struct Batch {
    worlds: Worlds,
    groups: Vec<episode::Group>,
    inputs: Vec<u32>,
    /// Slot of each episode.
    slots: Vec<u32>,
    /// State of each slot's episode so far, in the kernel's layout; empty if episodes begin.
    states: Vec<u32>,
    keeps_states: bool,
    trace_every: u32,
    cycles: Range<u32>,
}

impl Batch {
    /// Checks and packs episodes. To make many batches, pack their worlds once with [`Worlds::new`].
    ///
    /// # Errors
    /// As [`Worlds::new`] and [`Worlds::batch`].
    pub fn new<W: WorldKind>(
        worlds: &[W],
        rollouts: &[Rollout<'_>],
        trace: Option<TraceRequest>,
    ) -> Result<Self, Invalid> {
        Worlds::new(worlds)?.batch(rollouts, trace)
    }

    #[cfg(all(
        feature = "compose",
        any(feature = "gpu", feature = "native"),
        not(target_family = "wasm")
    ))]
    /// The worlds of its episodes.
    pub(crate) fn worlds(&self) -> &Worlds {
        &self.worlds
    }

    /// Number of episodes.
    pub fn rollouts(&self) -> usize {
        self.slots.len()
    }

    /// Total robot-steps: a step is one robot for one cycle.
    pub fn steps(&self) -> u64 {
        self.all().steps()
    }

    /// Kernel that simulates it.
    pub fn kernel(&self) -> &'static Kernel {
        self.worlds.kernel()
    }

    /// Number of groups.
    pub fn groups(&self) -> u32 {
        self.groups.len() as u32
    }

    /// Range of simulated cycles, up to the end of the longest episode.
    pub fn cycles(&self) -> Range<u32> {
        self.cycles.clone()
    }

    /// Words that each slot keeps between dispatches.
    pub fn state_words(&self) -> usize {
        self.worlds.0.state_words as usize
    }

    /// Words per record of a trace.
    pub fn record_words(&self) -> usize {
        self.worlds.0.record_words as usize
    }

    /// Words of each slot's trace; 0 without a trace.
    pub fn trace_words(&self) -> usize {
        self.trace_records() as usize * self.record_words()
    }

    /// Whether slots' states are part of the result, so that episodes can continue.
    pub fn keeps_states(&self) -> bool {
        self.keeps_states
    }

    /// Words of each slot's state in a result; 0 if states were not requested.
    pub fn kept_words(&self) -> usize {
        if self.keeps_states { self.state_words() } else { 0 }
    }

    /// Finds words in a result's `state` or `trace`, which has `words` words per slot: the index of a slot's word, given both numbers.
    pub fn places(&self, buffer: &str, words: usize) -> impl Fn(usize, usize) -> usize + use<> {
        self.worlds.places(buffer, words)
    }

    /// Cycles between records of a trace; 0 without a trace.
    pub fn trace_every(&self) -> u32 {
        self.trace_every
    }

    /// Records per slot; 0 without a trace.
    pub fn trace_records(&self) -> u32 {
        if self.trace_every == 0 {
            0
        } else {
            self.cycles.len().div_ceil(self.trace_every as usize) as u32
        }
    }

    /// Slot of an episode: its lane is `slot % 64` of the group `slot / 64`.
    pub fn slot(&self, rollout: usize) -> Option<usize> {
        self.slots.get(rollout).map(|&slot| slot as usize)
    }

    /// The episode in a slot.
    pub fn rollout(&self, slot: usize) -> Option<usize> {
        self.slots.iter().position(|&other| other as usize == slot)
    }

    /// The whole batch.
    pub fn all(&self) -> Part<'_> {
        self.part(0..self.groups())
    }

    /// A range of its groups, clipped to the batch.
    pub fn part(&self, groups: Range<u32>) -> Part<'_> {
        let end = groups.end.min(self.groups());
        Part {
            batch: self,
            groups: groups.start.min(end)..end,
        }
    }

    /// Whether a slot's episode may have fewer records than its world has cycles.
    pub(crate) fn may_end_early(&self, slot: u32) -> bool {
        self.worlds.0.facts[self.groups[slot as usize / LANES].world as usize].may_end_early
    }

    /// The written ones of an episode's lines.
    pub(crate) fn written<'a>(&self, slot: u32, lines: &'a [u32]) -> &'a [u32] {
        if !self.may_end_early(slot) {
            return lines;
        }
        // From an early end on there are no records. One that is all zero would be of a robot that stands at (0, 0), looks
        // along x, senses nothing, wants both wheels backwards at full speed and has earned nothing.
        let width = self.record_words();
        let last = lines.iter().rposition(|word| *word != 0);
        &lines[..last.map_or(0, |last| last / width + 1) * width]
    }

    /// The lines of a slot's episode in the trace of the whole batch.
    fn lines_of<'a>(&self, slot: u32, trace: &'a [u32]) -> &'a [u32] {
        let world = self.groups[slot as usize / LANES].world;
        let end = self.worlds.0.packed.worlds[world as usize].steps.min(self.cycles.end);
        let count = end.saturating_sub(self.cycles.start).div_ceil(self.trace_every);
        let lines = &trace[slot as usize * self.trace_words()..][..count as usize * self.record_words()];
        self.written(slot, lines)
    }

    /// The episode in each slot; `u32::MAX` in idle ones.
    pub(crate) fn rollouts_by_slot(&self) -> Vec<u32> {
        let mut rollouts = vec![u32::MAX; self.groups.len() * LANES];
        for (&slot, rollout) in self.slots.iter().zip(0..) {
            rollouts[slot as usize] = rollout;
        }
        rollouts
    }

    /// Shows the lines of all episodes to an observer, and returns the other results.
    pub(crate) fn observed(&self, mut result: PartResult, observer: Observer<'_>) -> Outcome {
        let trace = std::mem::take(&mut result.trace);
        let slots = self.slots.par_iter().enumerate();
        slots.for_each(|(rollout, &slot)| observer(rollout, self.lines_of(slot, &trace)));
        self.outcome_of(&result, &[])
    }

    /// Converts the result of [`Batch::all`] to results by episode.
    ///
    /// # Panics
    /// If the result isn't that of the whole batch.
    pub fn outcome(&self, mut result: PartResult) -> Outcome {
        let trace = std::mem::take(&mut result.trace);
        let words = result.fitness.len() * self.trace_words();
        assert_eq!(trace.len(), words, "a trace for each slot");
        self.outcome_of(&result, &trace)
    }

    /// Results by episode; none of traces if there are no words of these.
    pub(crate) fn outcome_of(&self, result: &PartResult, trace: &[u32]) -> Outcome {
        let PartResult { fitness, states, .. } = result;
        let records = if trace.is_empty() { 0 } else { self.trace_records() };
        let (words, state_words) = (self.trace_words(), self.state_words());
        assert_eq!(fitness.len(), self.groups.len() * LANES, "a fitness for each slot");
        let trace_of = |&slot: &u32| Trace::read(self.lines_of(slot, trace), self.record_words());
        let gathered = |buffer, from: &[u32], slots: &[u32], words| -> Vec<Vec<u32>> {
            let place = self.places(buffer, words);
            let words_of = |&slot: &u32| (0..words).map(|word| from[place(slot as usize, word)]).collect();
            slots.iter().map(words_of).collect()
        };
        // Worlds of several robots have traces of single words.
        let has_records = self.kernel().stride("trace") > size_of::<u32>();
        let each = |wanted: bool| if wanted { &self.slots[..] } else { &[] };
        Outcome {
            fitness: self.slots.iter().map(|&slot| fitness[slot as usize]).collect(),
            traces: each(records > 0 && has_records).iter().map(trace_of).collect(),
            logs: gathered("trace", trace, each(records > 0 && !has_records), words),
            states: gathered("state", states, each(self.keeps_states), state_words),
        }
    }
}

/// Takes lines of traces while episodes are simulated: an episode's index in its batch, and the words of its next lines, as many words
/// a line as [`Batch::record_words`] says. Episodes are shown in any order and at the same time, the lines of an episode in theirs.
pub type Observer<'a> = &'a (dyn Fn(usize, &[u32]) + Sync);

/// Results of a part: one fitness per slot and, if requested, traces and states as words, found with [`Batch::places`].
///
/// Every word is the same on every device. A word that no episode writes is 0, or in a state what the slot was given. Idle slots
/// have such words, records after an early end, and slots of a world smaller than the batch's largest.
#[derive(Clone, Debug, Default)]
pub struct PartResult {
    /// `part.slots()` values.
    pub fitness: Vec<f32>,
    /// `part.slots() * batch.trace_words()` words, or empty.
    pub trace: Vec<u32>,
    /// `part.slots() * batch.state_words()` words, or empty.
    pub states: Vec<u32>,
}

/// Results of a batch, in the order of its episodes.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Fitness; higher is better. For a world of several robots, all food collected so far.
    pub fitness: Vec<f32>,
    /// Traces of single robots, each as long as its episode; empty unless requested.
    pub traces: Vec<Trace>,
    /// Traces of worlds of several robots, as [`crate::swarm`] reads them.
    pub logs: Vec<Vec<u32>>,
    /// States for continuing each episode; empty for whole episodes.
    pub states: Vec<Vec<u32>>,
}

/// A range of a batch's groups: the unit of work for evaluators. Groups, inputs and results are numbered within it.
#[derive(Clone, Debug)]
pub struct Part<'a> {
    batch: &'a Batch,
    groups: Range<u32>,
}

impl<'a> Part<'a> {
    /// The batch.
    pub fn batch(&self) -> &'a Batch {
        self.batch
    }

    /// The range of the batch's groups.
    pub fn groups(&self) -> Range<u32> {
        self.groups.clone()
    }

    /// A part of this part; groups are numbered within this one.
    #[must_use]
    pub fn part(&self, groups: Range<u32>) -> Part<'a> {
        let end = self.groups.start.saturating_add(groups.end).min(self.groups.end);
        self.batch.part(self.groups.start.saturating_add(groups.start)..end)
    }

    /// Kernel that simulates it.
    pub fn kernel(&self) -> &'static Kernel {
        self.batch.kernel()
    }

    /// All worlds of the batch.
    pub fn worlds(&self) -> &'a [episode::World] {
        &self.batch.worlds.0.packed.worlds
    }

    /// All objects of the batch; at least one, so that the buffer isn't empty.
    pub fn shapes(&self) -> &'a [episode::Shape] {
        &self.batch.worlds.0.packed.shapes
    }

    /// All tables of the batch.
    pub fn tables(&self) -> &'a [[u32; 4]] {
        &self.batch.worlds.0.packed.tables
    }

    /// Groups of this part. Their `inputs` count from the start of the batch's.
    pub fn group_table(&self) -> &'a [episode::Group] {
        &self.batch.groups[self.groups.start as usize..self.groups.end as usize]
    }

    /// Inputs of this part.
    pub fn inputs(&self) -> &'a [u32] {
        &self.batch.inputs[self.inputs_before(self.groups.start)..self.inputs_before(self.groups.end)]
    }

    /// Index of this part's first input in the batch's: `Dispatch::first_input`.
    pub fn first_input(&self) -> u32 {
        self.inputs_before(self.groups.start) as u32
    }

    fn inputs_before(&self, group: u32) -> usize {
        self.batch
            .groups
            .get(group as usize)
            .map_or(self.batch.inputs.len(), |group| group.inputs as usize)
    }

    /// Number of slots, 64 per group.
    pub fn slots(&self) -> usize {
        self.groups.len() * LANES
    }

    /// Number of episodes, without idle slots.
    pub fn rollouts(&self) -> usize {
        self.group_table().iter().map(|group| group.rollouts as usize).sum()
    }

    /// Total robot-steps.
    pub fn steps(&self) -> u64 {
        self.steps_of(self.group_table(), &self.batch.cycles)
    }

    /// Robot-steps of some groups in a range of cycles.
    pub fn steps_of(&self, groups: &[episode::Group], cycles: &Range<u32>) -> u64 {
        let steps = |group: &episode::Group| {
            let world = group.world as usize;
            let end = self.worlds()[world].steps.min(cycles.end);
            let robots = group.rollouts * self.batch.worlds.0.facts[world].robots;
            u64::from(robots) * u64::from(end.saturating_sub(cycles.start))
        };
        groups.iter().map(steps).sum()
    }

    /// Range of simulated cycles, up to the end of the longest episode.
    pub fn cycles(&self) -> Range<u32> {
        let episodes = self
            .group_table()
            .iter()
            .map(|group| self.worlds()[group.world as usize].steps);
        let Range { start, end } = self.batch.cycles();
        start..end.min(episodes.max().unwrap_or(0))
    }

    /// State of this part's slots so far, in the kernel's layout; empty if episodes begin.
    pub fn states(&self) -> &'a [u32] {
        if self.batch.states.is_empty() {
            return &[];
        }
        let words = LANES * self.batch.state_words();
        &self.batch.states[self.groups.start as usize * words..self.groups.end as usize * words]
    }

    /// Most iterations of all of the kernel's loops in one cycle of one episode, at least 1.
    pub fn loops(&self) -> u32 {
        self.most(|facts| facts.loops)
    }

    /// Most additional iterations in the beginning of an episode, as for a random start.
    pub fn begin_loops(&self) -> u32 {
        self.most(|facts| facts.begin_loops)
    }

    fn most(&self, figure: impl Fn(&Facts) -> u32) -> u32 {
        let facts = &self.batch.worlds.0.facts;
        let groups = self.group_table().iter();
        groups
            .map(|group| figure(&facts[group.world as usize]))
            .max()
            .unwrap_or(1)
    }

    /// Cycles between records of a trace; 0 without a trace.
    pub fn trace_every(&self) -> u32 {
        self.batch.trace_every()
    }

    /// Records per slot; 0 without a trace. The same in each part of a batch.
    pub fn trace_records(&self) -> u32 {
        self.batch.trace_records()
    }
}
