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
pub mod worlds;

use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use oneiro::batch::{LANES, Outcome, Rollout, TraceRequest, WorldKind, Worlds, parts_of};
use oneiro::evaluator::{Control, Evaluator};
use oneiro::random::Key;
use oneiro::world::World;
use oneiro_base::exit::Result;
use oneiro_evolve::Population;

use measures::{Descriptor, Frames, Measures, Meter};

/// Groups of lanes per batch: enough for any device, and a few hundred megabytes at most.
const GROUPS: usize = 1 << 12;
/// Records of a batch that is traced. On a GPU they are in memory at once: 117 MB, and more with custom parts.
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

/// Takes the next lines of an episode's trace, given the cycle of the first; of each episode first those from cycle 0 on, of which there
/// are none if the task ends it at once. A line has the words of a record and its details, as [`oneiro::batch::parts_of`] takes it apart.
pub type Lines<'a> = &'a (dyn Fn(LifeIndex, u32, &[u32]) -> Result + Sync);

/// An episode while it is simulated.
struct Life {
    meter: Meter,
    /// Lines so far, once it has begun.
    lines: Option<u32>,
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

    /// The number of the world that each episode has among its variants, by genome; none if worlds don't vary.
    pub fn variants(&self) -> Option<Vec<usize>> {
        if self.worlds.iter().all(|world| world.variants().len() == 1) {
            return None;
        }
        let mut all = vec![0; self.genomes.len() * self.count];
        for index in 0..all.len() {
            let LifeIndex { genome, number } = self.at(index);
            let world = &self.worlds[if self.worlds.len() == 1 { 0 } else { number }];
            all[self.place(index)] = world.variant(self.keys.of(genome, number));
        }
        Some(all)
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
    /// `trace` is called with consecutive pieces of each episode's lines and the cycle at which a piece starts, by several threads;
    /// `ended` once for each episode, with its fitness and measures.
    ///
    /// # Errors
    /// As the evaluator's, and as `trace`.
    pub fn measured(
        &self,
        evaluator: &mut dyn Evaluator,
        control: &Control,
        cycles: u32,
        measures: &[Descriptor],
        trace: Option<Lines<'_>>,
        ended: &mut dyn FnMut(LifeIndex, f32, &Measures),
    ) -> Result {
        let world = &self.worlds[0];
        let frames = Frames::new(world, cycles, measures);
        // Two records show the end of episodes that all have as many cycles.
        let only_ends = trace.is_none() && frames.needs_only_the_end() && !world.may_end_early();
        let (frames, groups, stretch) = if only_ends {
            (Frames::new(world, cycles.min(2), measures), GROUPS, u32::MAX)
        } else {
            let groups = (RECORDS / LANES / world.cycles() as usize).clamp(1, GROUPS);
            (frames, groups, (RECORDS / LANES / groups) as u32)
        };
        for chunk in self.chunks(groups) {
            let (rollouts, worlds) = (self.rollouts(&chunk), self.packed(&chunk)?);
            let life = |index| {
                let LifeIndex { genome, number } = self.at(index);
                Mutex::new(Life {
                    meter: Meter::new(frames.of(self.keys.of(genome, number))),
                    lines: None,
                })
            };
            let lives: Vec<Mutex<Life>> = chunk.lives.clone().map(life).collect();
            let failed = Mutex::new(Ok(()));
            let width = worlds.record_words();
            let observe = |index: usize, words: &[u32]| {
                let life = &mut *lives[index].lock().unwrap_or_else(PoisonError::into_inner);
                let lines = words.chunks_exact(width);
                let begins = life.lines.is_none();
                let first = life.lines.unwrap_or(0);
                life.lines = Some(first + lines.len() as u32);
                if !measures.is_empty() {
                    for line in lines {
                        let (record, details) = parts_of(line);
                        life.meter.add(record, details);
                    }
                }
                if let Some(trace) = trace
                    && first < cycles
                    && (begins || !words.is_empty())
                {
                    let own = &words[..words.len().min((cycles - first) as usize * width)];
                    if let Err(failure) = trace(self.at(chunk.lives.start + index), first, own) {
                        *failed.lock().unwrap_or_else(PoisonError::into_inner) = Err(failure);
                    }
                }
            };
            let (mut states, mut fitness, mut first) = (Vec::new(), Vec::new(), 0);
            while first < world.cycles() {
                let cut = if first < cycles { cycles } else { world.cycles() };
                let end = first.saturating_add(stretch).min(cut);
                let every = if only_ends { (end - first - 1).max(1) } else { 1 };
                let request = Some(TraceRequest { every });
                let batch = if (first, end) == (0, world.cycles()) {
                    worlds.batch(&rollouts, request)?
                } else {
                    worlds.stretch(&rollouts, first..end, &states, request)?
                };
                let outcome = evaluator.observe(&batch, control, &observe)?;
                std::mem::replace(&mut *failed.lock().unwrap_or_else(PoisonError::into_inner), Ok(()))?;
                if end == cycles {
                    fitness = outcome.fitness;
                }
                (states, first) = (outcome.states, end);
            }
            for ((index, life), fitness) in chunk.lives.clone().zip(&lives).zip(fitness) {
                let life = life.lock().unwrap_or_else(PoisonError::into_inner);
                ended(self.at(index), fitness, &life.meter.finish());
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

    /// Traces are complete, and their last fitness is the fitness, also if episodes are cut into stretches. Ends alone are measured
    /// as with everything else.
    #[test]
    fn traces_are_complete_however_lives_are_cut() {
        let genomes = genomes(70);
        for (cycles, longer) in [(20, 0), (20, 1), (1, 1), (2, 0), (40_000, 1)] {
            let world = World::new(WorldSpec {
                cycles: cycles + longer,
                ..WorldSpec::miglino1995()
            })
            .unwrap();
            let shorter = [World::new(WorldSpec {
                cycles,
                ..world.spec().clone()
            })
            .unwrap()];
            let few = Population::new(18, genomes.values()[..18 * if cycles > 100 { 1 } else { 70 }].to_vec());
            let mut lives = Lives {
                worlds: &shorter,
                genomes: &few,
                count: 2,
                keys: KEYS,
            };
            let mut cpu = oneiro::cpu::Cpu::new(Some(2)).unwrap();
            let fitness = lives.fitness(&mut cpu, &Control::new()).unwrap();
            let measures = measures::descriptors(&world);
            let worlds = [world];
            lives.worlds = &worlds;
            let seen: Vec<_> = fitness.iter().map(|_| Mutex::new(Vec::new())).collect();
            let width = Worlds::new(&worlds).unwrap().record_words();
            let trace = |life: LifeIndex, first: u32, words: &[u32]| {
                let mut own = seen[life.genome * 2 + life.number].lock().unwrap();
                assert_eq!(own.len(), first as usize * width);
                own.extend_from_slice(words);
                Ok(())
            };
            let mut measured = Vec::new();
            let mut ended = |life: LifeIndex, last: f32, own: &Measures| {
                assert_eq!(last.to_bits(), fitness[life.genome * 2 + life.number].to_bits());
                measured.push(own.clone());
            };
            lives
                .measured(&mut cpu, &Control::new(), cycles, &measures, Some(&trace), &mut ended)
                .unwrap();
            for (fitness, words) in fitness.iter().zip(seen) {
                let words = words.into_inner().unwrap();
                assert_eq!(words.len(), cycles as usize * width);
                let (last, _) = parts_of(&words[words.len() - width..]);
                assert_eq!(last.fitness.to_bits(), fitness.to_bits());
            }
            let of_ends: Vec<_> = measures
                .into_iter()
                .filter(|own| Frames::new(&worlds[0], cycles, std::slice::from_ref(own)).needs_only_the_end())
                .collect();
            assert!(of_ends.len() >= 2);
            let mut all = measured.iter();
            let mut ended = |_: LifeIndex, _: f32, own: &Measures| {
                let whole = all.next().unwrap();
                for end in &of_ends {
                    assert_eq!(
                        end.value(own).to_bits(),
                        end.value(whole).to_bits(),
                        "{}",
                        end.column.name
                    );
                }
            };
            lives
                .measured(&mut cpu, &Control::new(), cycles, &of_ends, None, &mut ended)
                .unwrap();
            assert!(all.next().is_none());
        }
    }
}
