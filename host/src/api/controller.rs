//! Controllers by themselves, stepped with readings from elsewhere.

use std::path::{Path, PathBuf};

use oneiro::export::{Controller as Alone, Input, State};
use oneiro_base::exit::Failure;
use oneiro_lab::exported::{self, Order};
use oneiro_lab::lives::Keys;
use rayon::prelude::*;

use super::experiment::Experiment;
use super::{Error, Result, device};

/// Robots whose controllers are worth waking another thread.
const FEW: usize = 16;

/// The controllers of some robots, each in a cycle of an episode.
#[derive(Debug)]
pub struct Controllers {
    experiment: Experiment,
    genomes: Vec<f32>,
    number: u32,
    /// One for all robots, or one for each.
    own: Vec<Alone>,
    states: Vec<State>,
}

impl Controllers {
    /// Controllers of `robots` robots: of one genome or of one for each, one after the other. In a swarm, they are those of the robot with
    /// this number. Their episodes have seed 0.
    ///
    /// # Errors
    /// Exit 3 for the foraging study, and for genomes, numbers or controllers that aren't allowed.
    pub fn new(experiment: &Experiment, genomes: &[f32], number: u32, robots: usize) -> Result<Self> {
        let world = experiment.world()?;
        let genes = world.genes();
        let count = genomes.len() / genes;
        if count * genes != genomes.len() || count == 0 || robots == 0 || !(count == 1 || count == robots) {
            return Err(Error::input(format_args!(
                "genomes: are {} genes for {robots} robots; allowed: one genome of {genes}, or one for each robot",
                genomes.len()
            )));
        }
        let own = genomes.chunks_exact(genes).enumerate().map(|(genome, values)| {
            let refused = |invalid| Error::input(format_args!("genomes[{genome}]: {invalid}"));
            Alone::new(world, values, number).map_err(refused)
        });
        let mut controllers = Self {
            own: own.collect::<Result<_>>()?,
            experiment: experiment.clone(),
            genomes: genomes.to_vec(),
            number,
            states: Vec::with_capacity(robots),
        };
        let key = Keys::of_seed(0).of(0, 0);
        controllers.states = (0..robots).map(|robot| controllers.of(robot).begin(key)).collect();
        Ok(controllers)
    }

    /// The experiment, the genomes and the number that they are made of.
    pub fn parts(&self) -> (&Experiment, &[f32], u32) {
        (&self.experiment, &self.genomes, self.number)
    }

    /// Writes its only genome's controller as `oneiro export` does, and returns the file or folder.
    ///
    /// # Errors
    /// Exit 3 for several genomes, another target or name, and a controller that the target can't hold; 6 if it can't be written.
    pub fn export(
        &self,
        to: &str,
        out: Option<&Path>,
        name: Option<&str>,
        with: &[String],
        seed: u64,
        checks: usize,
    ) -> Result<PathBuf> {
        let experiment = self.experiment.single()?;
        if self.own.len() > 1 {
            let problem = format!("genomes: are {}; allowed: one", self.own.len());
            return Err(Error::input(problem));
        }
        let target = exported::target(to)
            .ok_or_else(|| Error::input(format_args!("to: is {to:?}; allowed: {}", exported::targets())))?;
        let name = name.map_or_else(|| exported::identifier(experiment.name(), target), str::to_owned);
        if !exported::is_name(&name, target) {
            return Err(Error::input(format_args!(
                "name: is {name:?}; allowed for {to}: {}",
                exported::names(target)
            )));
        }
        let out = exported::place("out", out, &name, target)?;
        exported::export(&Order {
            experiment: experiment.name(),
            identities: experiment.identities(),
            world: experiment.world(),
            genome: &self.genomes,
            from: "a genome from Python",
            result: None,
            command: None,
            set: Some(""),
            number: self.number,
            target,
            also: exported::also("with_", with, target)?,
            name,
            out: out.clone(),
            seed,
            trial: 0,
            checks,
        })?;
        Ok(out)
    }

    /// Number of robots.
    pub fn robots(&self) -> usize {
        self.states.len()
    }

    /// What each reads in a cycle.
    pub fn inputs(&self) -> &[Input] {
        &self.own[0].inputs
    }

    /// Kind of the controllers, as experiments name it.
    pub fn kind(&self) -> &str {
        &self.own[0].kind
    }

    fn of(&self, robot: usize) -> &Alone {
        self.own.get(robot).unwrap_or(&self.own[0])
    }

    /// The next cycle of each robot.
    pub fn cycles(&self) -> Vec<u32> {
        self.states.iter().map(State::cycle).collect()
    }

    /// Words of all states, those of a robot together.
    pub fn states(&self) -> Vec<u32> {
        self.states.iter().flat_map(State::words).copied().collect()
    }

    /// Continues from such words.
    ///
    /// # Errors
    /// Exit 5 for another number of words; then nothing has changed.
    pub fn restore(&mut self, words: &[u32]) -> Result {
        let each = words.len() / self.states.len();
        let states = words.chunks_exact(each.max(1)).enumerate();
        let states: Vec<State> = states
            .map(|(robot, words)| self.of(robot).restored(words).map_err(Failure::corrupt))
            .collect::<oneiro_base::exit::Result<_>>()?;
        if states.len() != self.states.len() {
            return Err(Failure::corrupt("states: are of another number of robots").into());
        }
        self.states = states;
        Ok(())
    }

    /// Begins the episode `life` of each robot again, with the random numbers that [`evaluate`](super::evaluate::evaluate) gives the
    /// genome with its two numbers.
    pub fn reset(&mut self, seed: u64, numbers: &[[u64; 2]], life: usize) {
        let keys = Keys {
            numbers: Some(numbers),
            ..Keys::of_seed(seed)
        };
        self.states = (0..self.robots())
            .map(|robot| self.of(robot).begin(keys.of(robot, life)))
            .collect();
    }

    /// A cycle of all robots: each one's readings, as [`Controllers::inputs`] names them, to two outputs each.
    ///
    /// # Errors
    /// Exit 3 for another number of readings, or some that aren't allowed; then nothing has changed.
    pub fn step(&mut self, readings: &[f32]) -> Result<Vec<f32>> {
        let width = self.inputs().len();
        if readings.len() != width * self.robots() {
            let problem = format_args!(
                "are {} for {} robots; allowed: {width} each",
                readings.len(),
                self.robots()
            );
            return Err(Error::input(format_args!("readings: {problem}")));
        }
        let mut states = self.states.clone();
        let step = |robot: usize, state: &mut State| {
            let own = &readings[robot * width..][..width];
            let outputs = self.of(robot).step(state, own);
            outputs.map_err(|invalid| {
                let place = invalid.field.strip_prefix("readings").unwrap_or_default();
                let place = place.trim_start_matches('[');
                Error::input(format_args!("readings[{robot}, {place}: {}", invalid.problem))
            })
        };
        let outputs: Vec<[f32; 2]> = if states.len() <= FEW {
            let all = states.iter_mut().enumerate();
            all.map(|(robot, state)| step(robot, state)).collect::<Result<_>>()?
        } else {
            device::threaded(|| {
                let all = states.par_iter_mut().enumerate();
                all.map(|(robot, state)| step(robot, state)).collect::<Result<_>>()
            })?
        };
        self.states = states;
        Ok(outputs.into_flattened())
    }

    /// The speeds of both wheels that outputs command, as fractions of full speed, -1 to 1.
    ///
    /// # Errors
    /// Exit 3 for outputs that are not from 0 to 1, or not two each.
    pub fn wheels(&self, outputs: &[f32]) -> Result<Vec<f32>> {
        let pairs = outputs.as_chunks().0;
        if pairs.len() != self.robots() || pairs.len() * 2 != outputs.len() {
            let problem = format_args!("outputs: are {}; allowed: 2 for each robot", outputs.len());
            return Err(Error::input(problem));
        }
        let speeds = pairs.iter().enumerate().map(|(robot, pair)| {
            let refused = |invalid| Error::input(format_args!("robot {robot}: {invalid}"));
            self.of(robot).wheels(*pair).map_err(refused)
        });
        Ok(speeds.collect::<Result<Vec<_>>>()?.into_flattened())
    }
}
