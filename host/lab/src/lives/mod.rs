//! Episodes of given genomes in one experiment's world, with or without their traces. They are evaluated in batches of bounded
//! memory, whatever their number and length.
//!
//! | file | contents |
//! |---|---|
//! | [`measures`] | measures of a robot's behaviour, from its trace |
//! | [`scores`] | scores of robots in a swarm |
//! | [`starts`] | starts of episodes, from a file |

pub mod measures;
pub mod scores;
pub mod starts;

use std::collections::BTreeMap;
use std::ops::Range;

use oneiro::batch::{Batch, LANES, Outcome, Rollout, Trace, TraceRequest, Worlds};
use oneiro::evaluator::{Control, Evaluator};
use oneiro::random::Key;
use oneiro::world::World;
use oneiro_base::exit::Result;
use oneiro_evolve::Population;

use measures::{Descriptor, Frames, Measures, Meter};

/// Groups of lanes per batch: enough for any device, and a few hundred megabytes at most.
const GROUPS: usize = 1 << 12;
/// Records of traces in memory at once: 117 MB, and more with custom parts.
const RECORDS: usize = 1 << 20;

/// The same number of episodes of each genome.
pub struct Lives<'a> {
    /// One world for all episodes, or one for each of a genome's episodes. They differ only in the start.
    pub worlds: &'a [World],
    pub genomes: &'a Population,
    /// Episodes of each genome.
    pub count: usize,
    /// Keys of their random numbers.
    pub keys: Keys<'a>,
}

/// Choice of the episodes' random numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Keys<'a> {
    pub seed: u64,
    /// Keys with different numbers are independent; those of evolution are below 2^32.
    pub generation: u64,
    /// Common random numbers: the episodes of all genomes use the random numbers of the first genome's. Random starts are then
    /// also the same.
    pub common: bool,
    /// Each genome's generation and number, instead of `generation` and its index.
    pub numbers: Option<&'a [[u64; 2]]>,
}

impl Keys<'_> {
    /// Keys of episodes for commands with a seed.
    pub fn of_seed(seed: u64) -> Self {
        Self {
            seed,
            generation: 0,
            common: false,
            numbers: None,
        }
    }

    /// Keys of new episodes that are common to all genomes, and that no run uses for its evolution or its finalists.
    pub fn of_champions(seed: u64) -> Self {
        Self {
            seed,
            generation: (1 << 32) + 1,
            common: true,
            numbers: None,
        }
    }

    /// Key of a genome's episode.
    pub fn of(self, genome: usize, life: usize) -> Key {
        let genome = if self.common { 0 } else { genome };
        let [generation, number] = self
            .numbers
            .map_or([self.generation, genome as u64], |numbers| numbers[genome]);
        Key::rollout(self.seed, generation, number, life as u64)
    }
}

/// Identifies one of the episodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct LifeIndex {
    pub genome: usize,
    /// Number among the genome's episodes.
    pub number: usize,
}

impl Lives<'_> {
    /// Total robot-steps.
    pub fn steps(&self) -> u64 {
        (self.genomes.len() * self.count) as u64
            * u64::from(self.worlds[0].cycles())
            * u64::from(self.worlds[0].robots())
    }

    /// Fitness of each episode, by genome.
    ///
    /// # Errors
    /// As the evaluator's.
    pub fn fitness(&self, evaluator: &mut dyn Evaluator, control: &Control) -> Result<Vec<f32>> {
        let mut all = vec![0.0; self.genomes.len() * self.count];
        for chunk in self.chunks(GROUPS) {
            let rollouts = self.rollouts(&chunk);
            let batch = self.packed(&chunk)?.batch(&rollouts, None)?;
            let Outcome { fitness, .. } = evaluator.evaluate(&batch, control)?;
            for (life, fitness) in chunk.lives.zip(fitness) {
                all[self.place(life)] = fitness;
            }
        }
        Ok(all)
    }

    /// Simulates and measures episodes of `cycles` cycles. Worlds may last one cycle more, which shows where each episode ends.
    /// `trace` is called with consecutive pieces of each episode's records and the cycle at which a piece starts; `ended` once
    /// for each episode, with its fitness and measures.
    ///
    /// # Errors
    /// As the evaluator's, and as `trace`.
    pub fn measured(
        &self,
        evaluator: &mut dyn Evaluator,
        control: &Control,
        cycles: u32,
        measures: &[Descriptor],
        mut trace: impl FnMut(LifeIndex, u32, &Trace) -> Result,
        mut ended: impl FnMut(LifeIndex, f32, &Measures),
    ) -> Result {
        let world = &self.worlds[0];
        let frames = Frames::new(world, cycles, measures);
        let mut under_way = BTreeMap::new();
        self.traced(evaluator, control, cycles, |life, lived, records, fitness| {
            let new = || (f32::NAN, Meter::new(frames.of(self.keys.of(life.genome, life.number))));
            let (own, meter) = under_way.entry(life).or_insert_with(new);
            if !measures.is_empty() {
                meter.add_all(records);
            }
            if lived.end == cycles {
                *own = fitness;
            }
            if lived.end <= cycles {
                trace(life, lived.start, records)?;
            }
            if lived.end == world.cycles()
                && let Some((fitness, meter)) = under_way.remove(&life)
            {
                ended(life, fitness, &meter.finish());
            }
            Ok(())
        })
    }

    /// Passes all traces to an observer, with a record for each cycle, in pieces, one of which ends at the cycle `cut`. Each call
    /// has an episode, its next cycles, their records, and its fitness if it ended with the last of them. There are fewer records
    /// than cycles if the episode ended early. Episodes come in any order, the pieces of an episode in theirs.
    ///
    /// # Errors
    /// As the evaluator's and the observer's.
    fn traced(
        &self,
        evaluator: &mut dyn Evaluator,
        control: &Control,
        cut: u32,
        mut observe: impl FnMut(LifeIndex, &Range<u32>, &Trace, f32) -> Result,
    ) -> Result {
        let cycles = self.worlds[0].cycles();
        let groups = (RECORDS / LANES / cycles as usize).clamp(1, GROUPS);
        let stretch = (RECORDS / LANES / groups) as u32;
        for chunk in self.chunks(groups) {
            let (rollouts, worlds) = (self.rollouts(&chunk), self.packed(&chunk)?);
            let (mut states, mut first) = (Vec::new(), 0);
            while first < cycles {
                let end = first
                    .saturating_add(stretch)
                    .min(if first < cut { cut } else { cycles });
                let batch: Batch = worlds.stretch(&rollouts, first..end, &states, Some(TraceRequest { every: 1 }))?;
                let outcome = evaluator.evaluate(&batch, control)?;
                let lived = outcome.traces.iter().zip(outcome.fitness);
                for (life, (records, fitness)) in chunk.lives.clone().zip(lived) {
                    observe(self.at(life), &(first..end), records, fitness)?;
                }
                (states, first) = (outcome.states, end);
            }
        }
        Ok(())
    }

    /// Episodes are numbered by genome if all have one world, otherwise by world, so that the episodes of a world are contiguous.
    fn at(&self, index: usize) -> LifeIndex {
        let (genomes, count) = (self.genomes.len(), self.count);
        if self.worlds.len() == 1 {
            LifeIndex {
                genome: index / count,
                number: index % count,
            }
        } else {
            LifeIndex {
                genome: index % genomes,
                number: index / genomes,
            }
        }
    }

    /// Index of an episode's result, by genome.
    fn place(&self, index: usize) -> usize {
        let LifeIndex { genome, number } = self.at(index);
        genome * self.count + number
    }

    /// Divides all episodes into chunks that fill at most `groups` groups of lanes.
    fn chunks(&self, groups: usize) -> Vec<Chunk> {
        let each = self.genomes.len() * self.count / self.worlds.len();
        let groups_of_world = each.div_ceil(LANES);
        if groups_of_world <= groups {
            let worlds = groups / groups_of_world;
            return (0..self.worlds.len())
                .step_by(worlds)
                .map(|first| {
                    let end = (first + worlds).min(self.worlds.len());
                    Chunk {
                        worlds: first..end,
                        lives: first * each..end * each,
                    }
                })
                .collect();
        }
        (0..self.worlds.len())
            .flat_map(|world| {
                (0..each).step_by(groups * LANES).map(move |first| Chunk {
                    worlds: world..world + 1,
                    lives: world * each + first..world * each + (first + groups * LANES).min(each),
                })
            })
            .collect()
    }

    fn packed(&self, chunk: &Chunk) -> Result<Worlds> {
        Ok(Worlds::new(&self.worlds[chunk.worlds.clone()])?)
    }

    fn rollouts(&self, chunk: &Chunk) -> Vec<Rollout<'_>> {
        let rollout = |index| {
            let LifeIndex { genome, number } = self.at(index);
            Rollout {
                world: if self.worlds.len() == 1 {
                    0
                } else {
                    number - chunk.worlds.start
                },
                genes: self.genomes.genome(genome),
                key: self.keys.of(genome, number),
            }
        };
        chunk.lives.clone().map(rollout).collect()
    }
}

/// Episodes in one batch, and their worlds.
#[derive(Clone, Debug, PartialEq)]
struct Chunk {
    worlds: Range<usize>,
    lives: Range<usize>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use oneiro::world::{Start, WorldSpec};

    fn genomes(count: u16) -> Population {
        Population::new(
            18,
            (0..count * 18).map(|gene| f32::from(gene % 37) / 18.0 - 1.0).collect(),
        )
    }

    fn worlds(count: u8) -> Vec<World> {
        let world = |index| {
            let start = Start::At {
                x: 60.0 + f32::from(index),
                y: 60.0,
                heading: 0.0,
            };
            World::new(WorldSpec {
                cycles: 20,
                start: if count == 1 { Start::Random } else { start },
                ..WorldSpec::miglino1995()
            })
            .unwrap()
        };
        (0..count).map(world).collect()
    }

    const KEYS: Keys<'_> = Keys {
        seed: 7,
        generation: 0,
        common: false,
        numbers: None,
    };

    /// Each episode is in one chunk, with its world, genome and key, wherever chunks are cut.
    #[test]
    fn chunks_take_each_life_once() {
        for (genome_count, world_count) in [(200, 1), (3, 1), (3, 5), (200, 3)] {
            let (genomes, worlds) = (genomes(genome_count), worlds(world_count));
            let lives = Lives {
                worlds: &worlds,
                genomes: &genomes,
                count: if world_count == 1 { 2 } else { worlds.len() },
                keys: KEYS,
            };
            for groups in [1, 2, 3, 100] {
                let mut seen = vec![0; genomes.len() * lives.count];
                for chunk in lives.chunks(groups) {
                    let rollouts = lives.rollouts(&chunk);
                    let batch = lives.packed(&chunk).unwrap().batch(&rollouts, None).unwrap();
                    assert!(batch.groups() as usize <= groups);
                    for (index, rollout) in chunk.lives.clone().zip(rollouts) {
                        let LifeIndex { genome, number } = lives.at(index);
                        seen[lives.place(index)] += 1;
                        assert_eq!(rollout.genes, genomes.genome(genome));
                        assert_eq!(rollout.key, Key::rollout(7, 0, genome as u64, number as u64));
                        let world = &worlds[chunk.worlds.start + rollout.world];
                        assert_eq!(world.spec().start, worlds[number % worlds.len()].spec().start);
                    }
                }
                assert!(seen.iter().all(|times| *times == 1), "{groups} groups: {seen:?}");
            }
        }
    }

    #[test]
    fn common_random_numbers_are_the_first_genomes() {
        let common = Keys { common: true, ..KEYS };
        assert_eq!(common.of(5, 3), KEYS.of(0, 3));
        assert_ne!(KEYS.of(5, 3), KEYS.of(0, 3));
    }

    /// Traces are complete, and their last fitness is the fitness, also if episodes are cut into stretches.
    #[test]
    fn traces_are_complete_however_lives_are_cut() {
        let genomes = genomes(70);
        for cycles in [20, 40_000] {
            let world = World::new(WorldSpec {
                cycles,
                ..WorldSpec::miglino1995()
            })
            .unwrap();
            let few = Population::new(18, genomes.values()[..18 * if cycles == 20 { 70 } else { 1 }].to_vec());
            let lives = Lives {
                worlds: &[world],
                genomes: &few,
                count: 2,
                keys: KEYS,
            };
            let mut cpu = oneiro::cpu::Cpu::new(Some(2)).unwrap();
            let fitness = lives.fitness(&mut cpu, &Control::new()).unwrap();
            let (mut seen, mut is_cut) = (vec![Trace::default(); fitness.len()], false);
            let observe = |life: LifeIndex, cycles: &Range<u32>, records: &Trace, fitness: f32| {
                let own = &mut seen[life.genome * 2 + life.number];
                assert_eq!(own.len(), cycles.start as usize);
                own.append(records);
                assert_eq!(own.len(), cycles.end as usize);
                assert_eq!(own.last().unwrap().fitness.to_bits(), fitness.to_bits());
                is_cut |= cycles.end == 7;
                Ok(())
            };
            lives.traced(&mut cpu, &Control::new(), 7, observe).unwrap();
            assert!(is_cut, "one piece ends at the cut");
            for (fitness, trace) in fitness.iter().zip(&seen) {
                assert_eq!(trace.len(), cycles as usize);
                assert_eq!(trace.last().unwrap().fitness.to_bits(), fitness.to_bits());
            }
        }
    }
}
