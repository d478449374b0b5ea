//! The job of a run of single robots: generations, the finalists' episodes, the champion's test, the last offspring's episodes in
//! reality if there is one, and the champion's episode again for its trace.

use std::sync::Arc;

use oneiro::batch::{Rollout, Trace};
use oneiro::random::{Key, Keys};
use oneiro_base::exit::{Failure, Result};
use oneiro_base::npy::{self, npy};
use oneiro_evolve::appraisal::{Appraisal, by_mean};
use oneiro_evolve::coevolution::{Coevolution, Scores};
use oneiro_evolve::map_elites::Archive;
use oneiro_evolve::race::Round;
use oneiro_evolve::{Champion, Evolution, SavedEvolution};
use serde::{Deserialize, Serialize};

use super::behaviour::Behaviour;
use super::champion::Individual;
use super::outcomes::Ended;
use super::pictures::Drawn;
use super::rows::Row;
use super::trace::{TraceTable, trace_every};
use super::transferred::{TERM, Transferred, positions};
use super::{
    BEHAVIOUR, CHAMPION, CHAMPION_GENES, CHAMPION_TEXT, COVERAGE, FITNESS, GENERATIONS, HALL, INDIVIDUALS, LUCKIEST,
    LUCKIEST_GENES, LUCKIEST_TEXT, POPULATION, Places, SECOND, Single, TRACE, pictures, race, report,
};
use crate::engine::job::{Added, Finished, Job, Outside, Place, Progress, Request, Results, Stage, Step};
use crate::experiment::Experiment;
use crate::experiment::settings::{Settings, TrialScore};
use crate::lives::worlds::{self, WorldTable};
use crate::runs::Recording;

/// A run of single robots.
pub(super) struct Evolving {
    single: Arc<Single>,
    places: Arc<Places>,
    seed: u64,
    /// Whether it is recorded in a directory.
    has_directory: bool,
    /// The connected robot that evaluates the last generations.
    outside: Option<Arc<dyn Outside>>,
    evolution: Evolution,
    /// Measures the behaviour of individuals, if the optimiser uses it.
    behaviour: Option<Behaviour>,
    /// Genomes and scores of the last generation, after all have been evaluated.
    last: Option<Generation>,
    /// Individuals that are re-evaluated at the end, the run's luckiest first. Empty if finalists are switched off.
    finalists: Vec<Champion>,
    /// Whether the last exhibition of two populations is over.
    is_exhibited: bool,
    progressed: Progressed,
    /// Fitness of each finalist's episodes, by finalist.
    appraised: Vec<f32>,
    /// Fitness of the champion's test: episodes after it was chosen. Empty where nothing is to choose.
    tested: Vec<f32>,
    /// Scores of the last generation's offspring in the simulator, and of each of their episodes in reality.
    simulated: Vec<f32>,
    real: Vec<f32>,
    /// The results of the robot's first generation elsewhere, if it is compared.
    transferred: Transferred,
    trace: Option<Trace>,
}

/// Purpose of the next request.
#[derive(Clone, Copy, PartialEq)]
enum Purpose {
    Generation,
    /// The last episodes of two populations: the best of both.
    Exhibition,
    Finalists,
    /// The champion's episodes after the finalists' have chosen it, since the best of several means is too high.
    Test,
    /// Episodes of the last offspring, which were never selected, in the simulator and in reality.
    Simulated,
    Real,
    /// Episodes of the robot's first generation: in the simulator, there without noise, and those of the best for its paths.
    Compared(Elsewhere),
    Trace,
}

/// Where the robot's first generation is also evaluated.
#[derive(Clone, Copy, PartialEq)]
enum Elsewhere {
    Simulated,
    Quiet,
    QuietPath,
    RealPaths,
}

/// Genomes and scores of a generation.
type Generation = (Vec<f32>, Vec<f32>);

/// Summary of the generations so far, for the run's outcome.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Progressed {
    /// Number of NaN scores, and of individuals with a measure that is NaN.
    nan: u64,
    unmeasured: u64,
    /// The last generation, and that of the second of two populations.
    last: Option<Row>,
    second: Option<Row>,
    /// The first generation on the robot.
    first_real: Option<Row>,
    /// Of a race, all generations, if they are recorded.
    rounds: Vec<Round>,
}

/// Saved state. It lacks the trace, which is requested again.
#[derive(Serialize, Deserialize)]
struct Saved {
    evolution: SavedEvolution,
    last: Option<Generation>,
    is_exhibited: bool,
    progressed: Progressed,
    appraised: Vec<f32>,
    tested: Vec<f32>,
    simulated: Vec<f32>,
    real: Vec<f32>,
    transferred: Transferred,
}

/// Numbers of the generation in the keys of finalists' episodes and of the champion's test, larger than any generation of an
/// evolution; [`crate::lives::Keys::of_champions`] has the number between them.
const FINALISTS: u64 = 1 << 32;
const TEST: u64 = FINALISTS + 2;

impl Evolving {
    pub(super) fn new(single: Arc<Single>, seed: u64, recording: Recording<'_>) -> Result<Self> {
        let outside = match (&single.robot, recording) {
            (Some(robot), Recording::Directory { path, console }) => {
                robot.outside(single.experiment.world().spec(), path, console)
            }
            _ => None,
        };
        Ok(Self {
            places: single.places()?,
            seed,
            has_directory: matches!(recording, Recording::Directory { .. }),
            outside,
            evolution: single.experiment.evolution(seed),
            behaviour: Behaviour::new(&single.experiment),
            single,
            last: None,
            finalists: Vec::new(),
            is_exhibited: false,
            progressed: Progressed::default(),
            appraised: Vec::new(),
            tested: Vec::new(),
            simulated: Vec::new(),
            real: Vec::new(),
            transferred: Transferred::default(),
            trace: None,
        })
    }

    /// Restores a job from the output of [`Job::save`].
    pub(super) fn restored(mut self, saved: &[u8]) -> Result<Self> {
        let Saved {
            evolution,
            last,
            is_exhibited,
            progressed,
            appraised,
            tested,
            simulated,
            real,
            transferred,
        } = unsealed(saved)?;
        self.evolution.restore(evolution)?;
        if self.evolution.is_finished() != last.is_some() {
            return Err(Failure::corrupt("a saved run lacks its last generation"));
        }
        if progressed.last.is_some() != (self.evolution.generation() > 0) {
            return Err(Failure::corrupt("a saved run lacks its generations"));
        }
        self.last = last;
        self.is_exhibited = is_exhibited;
        self.finalists = self.chosen_finalists()?;
        let lives = self.single.experiment.settings().finalists.lives as usize;
        let is_other =
            |fitness: &[f32], individuals: usize| !fitness.is_empty() && fitness.len() != individuals * lives;
        if is_other(&appraised, self.finalists.len()) || is_other(&tested, 1) {
            return Err(Failure::corrupt("a saved run has other finalists"));
        }
        Ok(Self {
            progressed,
            appraised,
            tested,
            simulated,
            real,
            transferred,
            ..self
        })
    }

    /// The elites so far, if the optimiser keeps some.
    pub(super) fn archive(&self) -> Option<&Archive> {
        self.evolution.optimizer().archive()
    }

    /// Chooses the individuals that are re-evaluated after the last generation: the run's luckiest, and the optimiser's best.
    fn chosen_finalists(&self) -> Result<Vec<Champion>> {
        // One of them is the luckiest.
        let count = self.single.experiment.finalists() as usize;
        let Some((genomes, fitness)) = self.last.as_ref().filter(|_| count > 0) else {
            return Ok(Vec::new());
        };
        let luckiest = self.luckiest()?;
        let others = self.evolution.optimizer().finalists(luckiest, genomes, fitness);
        Ok(std::iter::once(luckiest.clone())
            .chain(others.take(count - 1))
            .collect())
    }

    /// The mean of each finalist's episodes; empty before they are simulated.
    fn appraisals(&self) -> Vec<Appraisal> {
        let lives = self.single.experiment.settings().finalists.lives as usize;
        self.appraised.chunks_exact(lives).map(Appraisal::of).collect()
    }

    /// The champion: the finalist with the best mean, or the luckiest individual if there are no finalists. Its mean is that of its
    /// test, which is not too high for having been chosen.
    fn champion(&self) -> Result<(&Champion, Option<Appraisal>)> {
        let appraisals = self.appraisals();
        match by_mean(&appraisals).first() {
            Some(&best) if self.tested.is_empty() => Ok((&self.finalists[best], Some(appraisals[best]))),
            Some(&best) => Ok((&self.finalists[best], Some(Appraisal::of(&self.tested)))),
            None => Ok((self.luckiest()?, None)),
        }
    }

    fn purpose(&self) -> Option<Purpose> {
        let has_reality = self.single.has_reality();
        if let Some(elsewhere) = self.elsewhere() {
            Some(Purpose::Compared(elsewhere))
        } else if !self.evolution.is_finished() {
            Some(Purpose::Generation)
        } else if self.is_coevolution() && !self.is_exhibited {
            Some(Purpose::Exhibition)
        } else if self.appraised.is_empty() && !self.finalists.is_empty() {
            Some(Purpose::Finalists)
        } else if self.tested.is_empty() && self.finalists.len() > 1 {
            Some(Purpose::Test)
        } else if has_reality && self.simulated.is_empty() {
            Some(Purpose::Simulated)
        } else if has_reality && self.real.is_empty() {
            Some(Purpose::Real)
        } else if self.has_directory && self.trace.is_none() && !self.single.ends_outside() {
            Some(Purpose::Trace)
        } else {
            None
        }
    }

    /// Where the robot's first generation is evaluated next, before the robot; none if all is done or it is not compared.
    fn elsewhere(&self) -> Option<Elsewhere> {
        let is_now = self.single.experiment.first_real() == Some(self.evolution.generation());
        self.places.compared.as_ref().filter(|_| is_now)?;
        let own = &self.transferred;
        if own.simulated.is_empty() {
            Some(Elsewhere::Simulated)
        } else if own.quiet.is_empty() {
            Some(Elsewhere::Quiet)
        } else if own.path.is_empty() {
            Some(Elsewhere::QuietPath)
        } else if own.real_paths.is_empty() {
            Some(Elsewhere::RealPaths)
        } else {
            None
        }
    }

    pub(super) fn luckiest(&self) -> Result<&Champion> {
        let luckiest = self.evolution.champion();
        luckiest.ok_or_else(|| Failure::failed("a run has no generation"))
    }

    /// Whether two populations compete.
    fn is_coevolution(&self) -> bool {
        self.evolution.optimizer().coevolution().is_some()
    }

    /// Whether a generation is evaluated on the experiment's robot.
    fn is_real(&self, generation: u32) -> bool {
        let first = self.single.experiment.first_real();
        first.is_some_and(|first| generation >= first)
    }

    /// The robot outside of the device that evaluates a generation, if there is one.
    fn outside_of(&self, generation: u32) -> Option<&Arc<dyn Outside>> {
        self.outside.as_ref().filter(|_| self.is_real(generation))
    }

    /// The world of a generation; the simulator's if a robot outside of the device evaluates it.
    fn place_of(&self, generation: u32) -> &[Place] {
        match &self.places.transfer {
            Some(place) if self.is_real(generation) => std::slice::from_ref(place),
            _ => std::slice::from_ref(&self.places.simulator),
        }
    }

    /// Keys of an individual's episodes in its generation.
    fn keys(&self, individual: &Champion) -> Vec<Key> {
        let settings = self.single.experiment.settings();
        keys(settings, self.seed, individual.generation, individual.individual).collect()
    }

    /// Episodes of finalists, all with the same random numbers.
    fn finalists_lives<'a>(
        &self,
        finalists: impl Iterator<Item = &'a Champion>,
        generation: u64,
    ) -> impl Iterator<Item = Rollout<'a>> {
        let lives = self.single.experiment.settings().finalists.lives;
        let keys = Keys::new(self.seed, generation);
        finalists.flat_map(move |finalist| {
            (0..lives).map(move |life| Rollout {
                world: 0,
                genes: &finalist.genome,
                key: keys.of(0, life.into()),
            })
        })
    }

    /// Number of episodes for a purpose.
    fn count(&self, purpose: Purpose) -> u64 {
        let settings = self.single.experiment.settings();
        let individuals = self.evolution.ask().len() as u64;
        match purpose {
            Purpose::Generation | Purpose::Simulated | Purpose::Compared(Elsewhere::Simulated | Elsewhere::Quiet) => {
                individuals * u64::from(settings.trials)
            }
            Purpose::Exhibition => settings.trials.into(),
            Purpose::Compared(Elsewhere::RealPaths) => 2,
            Purpose::Finalists => self.finalists.len() as u64 * u64::from(settings.finalists.lives),
            Purpose::Test => settings.finalists.lives.into(),
            Purpose::Real => individuals * self.places.reality.len() as u64,
            Purpose::Trace | Purpose::Compared(Elsewhere::QuietPath) => 1,
        }
    }

    /// Each individual's episodes, in the simulator or on the robot.
    fn lives(&self) -> impl Iterator<Item = Rollout<'_>> {
        let settings = self.single.experiment.settings();
        let (seed, generation) = (self.seed, self.evolution.generation());
        let each = move |(genes, individual)| {
            let keys = keys(settings, seed, generation, individual);
            keys.map(move |key| Rollout { world: 0, genes, key })
        };
        self.evolution.ask().genomes().zip(0..).flat_map(each)
    }

    /// An episode of each individual with each robot of reality.
    fn real_lives(&self) -> impl Iterator<Item = Rollout<'_>> {
        let keys = Keys::new(self.seed, self.evolution.generation().into());
        (0..self.places.reality.len()).flat_map(move |robot| {
            let each = move |(genes, individual): (_, u32)| Rollout {
                world: robot,
                genes,
                // Larger than the number of any simulated trial.
                key: keys.of(individual.into(), (1 << 32) + robot as u64),
            };
            self.evolution.ask().genomes().zip(0..).map(each)
        })
    }

    /// Episodes of the individual whose paths are compared.
    fn paths(&self, count: u64) -> impl Iterator<Item = Rollout<'_>> {
        let best = self.transferred.best();
        let keys = Keys::new(self.seed, self.evolution.generation().into());
        let genes = self.evolution.ask().genomes().nth(best as usize).unwrap_or_default();
        (0..count).map(move |life| Rollout {
            world: 0,
            genes,
            // Larger than the number of any episode in reality.
            key: keys.of(best.into(), (1 << 33) + life),
        })
    }

    /// Episodes spent after each of so many generations.
    fn spent(&self, generations: usize) -> Vec<u64> {
        let settings = self.single.experiment.settings();
        let rounds = &self.progressed.rounds;
        if rounds.is_empty() {
            let each = u64::from(settings.evolution.genomes_per_generation()) * u64::from(settings.trials);
            return (1..=generations as u64).map(|done| done * each).collect();
        }
        race::spent(rounds, settings.trials).collect()
    }

    fn scores(&self, fitness: &[f32]) -> Vec<f32> {
        let settings = self.single.experiment.settings();
        let lives = fitness.chunks_exact(settings.trials as usize);
        lives.map(|lives| score(settings.trial_score, lives)).collect()
    }

    /// Takes the fitness of a generation.
    fn bred(&mut self, results: &Results<'_>) -> Result<Step> {
        let settings = self.single.experiment.settings();
        // Individuals of a generation have the same worlds.
        let keys: Vec<Key> = keys(settings, self.seed, self.evolution.generation(), 0).collect();
        let (behaviour, unmeasured) = match &mut self.behaviour {
            Some(own) => match own.of(results.traces, &keys) {
                Some(behaviour) => {
                    let unmeasured = own.unmeasured(&behaviour);
                    (behaviour, Some(unmeasured))
                }
                // The next request is the same generation.
                None => return Ok(Step::default()),
            },
            None => (Vec::new(), None),
        };
        if self.single.experiment.first_real() == Some(self.evolution.generation()) {
            self.evolution.forget_champion();
        }
        let generation = self.evolution.tell(self.scores(results.fitness), &behaviour)?;
        let done = self.evolution.generation();
        let luckiest = self.luckiest()?.fitness;
        let best = settings.evolution.best();
        let of = |scores: &Scores| Row::of(generation.number, &scores.fitness, &scores.ranking, best);
        let coevolution = self.evolution.optimizer().coevolution();
        let (row, second) = match coevolution.map(Coevolution::scores) {
            Some(scores) => {
                let [first, second] = scores.map(of);
                (first, Some(second))
            }
            None => (Row::new(&generation, best), None),
        };
        let rows = [(GENERATIONS, Some(&row)), (SECOND, second.as_ref())].into_iter();
        let mut added: Vec<Added> = rows
            .filter_map(|(file, row)| {
                let bytes = row?.line().into_bytes();
                Some(Added { file, bytes })
            })
            .collect();
        if let Some(count) = unmeasured.filter(|_| self.has_directory) {
            added.push(Added {
                file: BEHAVIOUR,
                bytes: format!("{},{count}\n", generation.number).into_bytes(),
            });
        }
        let own = &mut self.progressed;
        own.nan += u64::from(row.nan);
        own.unmeasured += unmeasured.map_or(0, u64::from);
        if self.single.experiment.first_real() == Some(generation.number) {
            own.first_real = Some(row.clone());
        }
        (own.last, own.second) = (Some(row), second);
        if let Some(round) = self.evolution.optimizer().round().filter(|_| self.has_directory) {
            own.rounds.push(round);
            added.push(Added {
                file: race::FILE,
                bytes: race::line(&own.rounds, settings.trials).into_bytes(),
            });
        }
        if settings.record.individuals && self.has_directory {
            let mut bytes = Vec::new();
            for (genome, fitness) in generation.population.genomes().zip(&generation.fitness) {
                npy::put(genome.iter().chain([fitness]), &mut bytes);
            }
            added.push(Added {
                file: INDIVIDUALS,
                bytes,
            });
        }
        if let Some(archive) = self.archive()
            && self.has_directory
        {
            let line = super::archive::line(generation.number, archive, settings.evolution.tables.archive.offset);
            added.push(Added {
                file: COVERAGE,
                bytes: line.into_bytes(),
            });
        }
        let is_finished = self.evolution.is_finished();
        if is_finished {
            self.last = Some((generation.population.values().to_vec(), generation.fitness));
            self.finalists = self.chosen_finalists()?;
        }
        Ok(Step {
            added,
            progress: Some(Progress { done, best: luckiest }),
            is_checkpoint: !is_finished && done.is_multiple_of(settings.record.checkpoint_every),
        })
    }

    /// Takes the trace of the champion's episode; its fitness must be the same as before.
    fn traced(&mut self, results: &Results<'_>) -> Result {
        let (champion, _) = self.champion()?;
        let (then, now) = (champion.fitness, results.fitness.first().copied().unwrap_or(f32::NAN));
        if self.single.experiment.settings().trials == 1 && then.to_bits() != now.to_bits() {
            return Err(Failure::failed(format_args!(
                "seed {}: the champion's fitness was {then} (bits {:08x}) in its generation and is {now} (bits {:08x}) in \
                 its trace; results of this device can't be trusted",
                self.seed,
                then.to_bits(),
                now.to_bits()
            )));
        }
        self.trace = Some(results.traces.first().cloned().unwrap_or_default());
        Ok(())
    }
}

/// For an evolution on a robot's computer only.
#[cfg(all(unix, feature = "compose"))]
impl Evolving {
    /// Number of generations that have been evaluated.
    pub(super) fn generation(&self) -> u32 {
        self.evolution.generation()
    }

    /// Whether all generations have been evaluated.
    pub(super) fn is_over(&self) -> bool {
        self.evolution.is_finished()
    }

    /// Takes the fitness of a generation. The luckiest individual of earlier ones is forgotten.
    pub(super) fn bred_anew(&mut self, results: &Results<'_>) -> Result<Step> {
        self.evolution.forget_champion();
        self.bred(results)
    }
}

impl Job for Evolving {
    fn ask(&self) -> Option<Request<'_>> {
        let purpose = self.purpose()?;
        let experiment = &self.single.experiment;
        let settings = experiment.settings();
        let reality = &self.places.reality[..];
        let lived = match purpose {
            Purpose::Generation => self.place_of(self.evolution.generation()),
            Purpose::Exhibition | Purpose::Finalists | Purpose::Test | Purpose::Trace => {
                self.place_of(self.evolution.generation() - 1)
            }
            Purpose::Simulated => std::slice::from_ref(&self.places.simulator),
            Purpose::Real => reality,
            Purpose::Compared(elsewhere) => {
                let compared = self.places.compared.as_ref()?;
                std::slice::from_ref(match elsewhere {
                    Elsewhere::Simulated => &self.places.simulator,
                    Elsewhere::Quiet => &compared.quiet,
                    Elsewhere::QuietPath => &compared.quiet_path,
                    Elsewhere::RealPaths => &compared.real_path,
                })
            }
        };
        let kernel = lived.first().map_or("", |place| place.world.kernel().name);
        let life = u64::from(settings.world.cycles);
        let outside = match purpose {
            Purpose::Generation => self.outside_of(self.evolution.generation()),
            _ => None,
        };
        let mut stage = outside.map_or_else(|| Stage::lives(kernel), |_| Stage::OUTSIDE);
        match purpose {
            Purpose::Trace => stage.trace_every = Some(trace_every(experiment)),
            Purpose::Generation => stage.trace_every = self.behaviour.as_ref().map(Behaviour::every),
            Purpose::Compared(Elsewhere::QuietPath | Elsewhere::RealPaths) => stage.trace_every = Some(TERM),
            _ => (),
        }
        Some(Request {
            stage,
            worlds: lived,
            outside,
            states: &[],
            lives: self.count(purpose) as usize,
            steps: self.count(purpose) * life,
        })
    }

    fn rollouts<'a>(&'a self, into: &mut Vec<Rollout<'a>>) {
        match self.purpose() {
            // Internal iteration is faster here than `extend`.
            Some(
                Purpose::Generation | Purpose::Simulated | Purpose::Compared(Elsewhere::Simulated | Elsewhere::Quiet),
            ) => self.lives().for_each(|life| into.push(life)),
            Some(own @ Purpose::Compared(_)) => into.extend(self.paths(self.count(own))),
            Some(Purpose::Finalists) => into.extend(self.finalists_lives(self.finalists.iter(), FINALISTS)),
            Some(Purpose::Test) => {
                let champion = self.champion().ok().map(|(champion, _)| champion);
                into.extend(self.finalists_lives(champion.into_iter(), TEST));
            }
            Some(Purpose::Exhibition) => {
                let pair = self.evolution.champion();
                into.extend(pair.into_iter().flat_map(|pair| {
                    self.keys(pair).into_iter().map(|key| Rollout {
                        world: 0,
                        genes: &pair.genome,
                        key,
                    })
                }));
            }
            Some(Purpose::Real) => into.extend(self.real_lives()),
            Some(Purpose::Trace) => into.extend(self.champion().ok().map(|(champion, _)| Rollout {
                world: 0,
                genes: &champion.genome,
                key: self.keys(champion)[0],
            })),
            None => (),
        }
    }

    fn tell(&mut self, results: &Results<'_>) -> Result<Step> {
        match self.purpose() {
            Some(Purpose::Generation) => return self.bred(results),
            Some(Purpose::Exhibition) => {
                let settings = self.single.experiment.settings();
                self.evolution.exhibit(score(settings.trial_score, results.fitness));
                self.is_exhibited = true;
                self.finalists = self.chosen_finalists()?;
            }
            Some(Purpose::Finalists) => self.appraised = results.fitness.to_vec(),
            Some(Purpose::Test) => self.tested = results.fitness.to_vec(),
            Some(Purpose::Simulated) => self.simulated = self.scores(results.fitness),
            Some(Purpose::Real) => self.real = results.fitness.to_vec(),
            Some(Purpose::Compared(elsewhere)) => {
                let mut paths = results.traces.iter().map(positions);
                match elsewhere {
                    Elsewhere::Simulated => self.transferred.simulated = self.scores(results.fitness),
                    Elsewhere::Quiet => self.transferred.quiet = self.scores(results.fitness),
                    Elsewhere::QuietPath => self.transferred.path = paths.next().unwrap_or_default(),
                    Elsewhere::RealPaths => self.transferred.real_paths = paths.collect(),
                }
            }
            Some(Purpose::Trace) => self.traced(results)?,
            None => (),
        }
        Ok(Step::default())
    }

    fn save(&self) -> Vec<u8> {
        let saved = Saved {
            evolution: self.evolution.save(),
            last: self.last.clone(),
            appraised: self.appraised.clone(),
            tested: self.tested.clone(),
            simulated: self.simulated.clone(),
            real: self.real.clone(),
            is_exhibited: self.is_exhibited,
            progressed: self.progressed.clone(),
            transferred: self.transferred.clone(),
        };
        postcard::to_allocvec(&saved).expect("numbers")
    }

    fn finish(&mut self, table: &str) -> Result<Finished> {
        let (luckiest, (champion, appraisal)) = (self.luckiest()?, self.champion()?);
        let individual = |own, appraisal| Individual {
            own,
            appraisal,
            seed: self.seed,
            keys: self.keys(own),
            layout: self.single.experiment.world().gene_layout(),
        };
        let mut files = individual(champion, appraisal).files([CHAMPION, CHAMPION_GENES, CHAMPION_TEXT]);
        if let Some(&own) = self.appraisals().first() {
            files.extend(individual(luckiest, Some(own)).files([LUCKIEST, LUCKIEST_GENES, LUCKIEST_TEXT]));
        }
        if let Some((genomes, fitness)) = &self.last {
            let shape = [fitness.len(), genomes.len() / fitness.len()];
            files.push((POPULATION, npy(&shape, genomes)));
            files.push((FITNESS, npy(&shape[..1], fitness)));
        }
        if let Some(coevolution) = self.evolution.optimizer().coevolution() {
            let hall = coevolution.hall();
            files.push((HALL, npy(&[hall.len(), hall.genes()], hall.values())));
        }
        let archive = self.archive();
        if let Some(archive) = archive {
            files.extend(super::archive::files(archive, &self.single.experiment));
        }
        if self.has_directory {
            let rows = Row::parse(table);
            let rows = rows.map_err(|problem| Failure::corrupt(format_args!("{GENERATIONS}: {problem}")))?;
            let experiment = &self.single.experiment;
            if let Some(trace) = &self.trace {
                let table = TraceTable::new(experiment.world()).csv(trace, trace_every(experiment));
                files.push((TRACE, table.into_bytes()));
            }
            let worlds = WorldTable::new(experiment.world());
            files.extend(worlds.map(|table| (worlds::FILE, table.csv().into_bytes())));
            let drawn = Drawn {
                experiment,
                seed: self.seed,
                champion,
                finalists: &self.finalists,
                appraisals: &self.appraisals(),
                appraisal,
                trace: self.trace.as_ref(),
                rows: &rows,
                spent: &self.spent(rows.len()),
                rounds: &self.progressed.rounds,
                archive,
            };
            let pictures = pictures::all(&drawn);
            let page = report::html(&drawn, &pictures);
            files.extend(pictures.into_iter().map(|(own, svg)| (own.name, svg.into_bytes())));
            files.push((crate::runs::report::FILE, page.into_bytes()));
        }
        let evolution = &self.single.experiment.settings().evolution;
        let generations = &self.progressed;
        let last = generations.last.as_ref();
        let last = last.ok_or_else(|| Failure::failed("a run has no generation"))?;
        let first_real = generations
            .first_real
            .as_ref()
            .filter(|_| self.places.compared.is_some());
        let outcomes = self.single.outcomes_of(&Ended {
            luckiest,
            champion,
            appraisal,
            last,
            second: generations.second.as_ref(),
            nan: generations.nan,
            unmeasured: generations.unmeasured,
            simulated: &self.simulated,
            real: &self.real,
            compared: first_real.map(|first| self.transferred.compared(evolution.parents, first, last)),
            archive: archive.map(|archive| (archive, evolution.tables.archive.offset)),
        });
        Ok(Finished {
            files,
            outcomes,
            champion: champion.genome.clone(),
        })
    }
}

/// The saved job of a run of `experiment`, given that of a run of `earlier`, which differs only in having fewer generations.
///
/// # Errors
/// Exit 5 if the bytes aren't what a job of that run saves.
pub(super) fn extended(experiment: &Experiment, earlier: &Experiment, seed: u64, saved: &[u8]) -> Result<Vec<u8>> {
    let saved: Saved = unsealed(saved)?;
    let mut evolution = earlier.evolution(seed);
    evolution.restore(saved.evolution)?;
    evolution.set_generations(experiment.settings().evolution.generations);
    // The stages after the last generation are done again.
    let longer = Saved {
        evolution: evolution.save(),
        last: None,
        is_exhibited: false,
        appraised: Vec::new(),
        tested: Vec::new(),
        simulated: Vec::new(),
        real: Vec::new(),
        ..saved
    };
    Ok(postcard::to_allocvec(&longer).expect("numbers"))
}

/// Reads the output of [`Job::save`].
fn unsealed(saved: &[u8]) -> Result<Saved> {
    postcard::from_bytes(saved).map_err(|_| Failure::corrupt("a saved run has unexpected contents"))
}

/// Keys of an individual's episodes: different for each individual, or the same for a whole generation or grid.
pub fn keys(settings: &Settings, seed: u64, generation: u32, individual: u32) -> impl Iterator<Item = Key> + use<> {
    let own = Keys::new(seed, settings.evolution.draw(generation).into());
    let individual = settings.evolution.lot(individual);
    (0..settings.trials).map(move |trial| own.of(individual.into(), trial.into()))
}

/// An individual's score: the mean or the minimum of its episodes; NaN if one of them is.
pub fn score(kind: TrialScore, lives: &[f32]) -> f32 {
    let nan = lives.iter().copied().find(|life| life.is_nan());
    nan.unwrap_or_else(|| match kind {
        TrialScore::Mean => (lives.iter().map(|&life| f64::from(life)).sum::<f64>() / lives.len() as f64) as f32,
        TrialScore::Least => lives.iter().copied().fold(f32::INFINITY, f32::min),
    })
}

/// The mean of each of `numbers` numbers over an individual's episodes, given one episode after the other.
pub fn means(episodes: &[f64], numbers: usize) -> impl Iterator<Item = f64> {
    let count = (episodes.len() / numbers) as f64;
    (0..numbers).map(move |number| episodes.iter().skip(number).step_by(numbers).sum::<f64>() / count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_several_episodes() {
        assert!(means(&[1.0, 10.0, 2.0, 20.0, 6.0, 60.0], 2).eq([3.0, 30.0]));
        assert!(means(&[0.1, 0.2], 2).eq([0.1, 0.2]));
    }

    #[test]
    fn scores_of_several_lives() {
        assert_eq!(score(TrialScore::Mean, &[1.0, 2.0, 6.0]), 3.0);
        assert_eq!(score(TrialScore::Least, &[1.0, -2.0, 6.0]), -2.0);
        assert_eq!(score(TrialScore::Mean, &[0.1]), 0.1);
        assert!(score(TrialScore::Least, &[1.0, f32::NAN]).is_nan());
        assert!(score(TrialScore::Mean, &[f32::NAN, 1.0]).is_nan());
    }
}
