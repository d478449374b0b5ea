//! Lives that are commanded cycle by cycle.

use oneiro::differential::Build;
use oneiro::foraging::Drive;
use oneiro::random::Key;
use oneiro::reference::Model;
use oneiro::stepped::MANY;
use oneiro::swarm::{Command, Driven, Lamp, Swarm};
use oneiro_base::exit::Failure;
use oneiro_lab::experiment::check_seed;

use super::experiment::Experiment;
use super::{Error, Result, Task, device};

/// Lives in an experiment's world, whose controller is left out.
#[derive(Debug)]
pub struct Stepped {
    own: oneiro::stepped::Stepped,
    /// Numbers of all episodes.
    all: Vec<usize>,
    backend: String,
    length: u32,
}

impl Stepped {
    /// Lives of which none has begun.
    ///
    /// # Errors
    /// Exit 3 for the foraging study, and for episodes that can't be stepped; exit 4 if there is no such device.
    pub fn new(experiment: &Experiment, lives: usize, backend: &str) -> Result<Self> {
        let spec = experiment.world()?.spec();
        let own = oneiro::stepped::Stepped::new(spec, lives)?;
        device::with(backend, |_| ())?;
        Ok(Self {
            own,
            all: (0..lives).collect(),
            backend: backend.to_owned(),
            length: spec.cycles,
        })
    }

    /// Names of the readings of each life.
    pub fn names(&self) -> Vec<String> {
        self.own.names()
    }

    /// Which readings are 0 to 1: the robot's own, but for some of a reference model. A user's sensors may read anything up to 1000 either
    /// way.
    pub fn bounded(&self) -> Vec<bool> {
        let spec = self.own.world().spec();
        let model = match &spec.robot.build {
            Build::Differential(own) => own.model,
            Build::Sampled | Build::Forager(_) => None,
        };
        let of_robot = spec.robot.build.readings();
        let of_model = model.map_or_else(Vec::new, Model::readings);
        let is_bounded = |name: &String| {
            let is_other = of_model.contains(name) && model.is_some_and(|model| !model.is_within_one(name));
            of_robot.contains(name) && !is_other
        };
        self.names().iter().map(is_bounded).collect()
    }

    /// Most cycles of a life.
    pub fn length(&self) -> u32 {
        self.length
    }

    /// The arguments of [`Stepped::new`]: the number of episodes, and the device.
    pub fn parts(&self) -> (usize, &str) {
        (self.own.cycles().len(), &self.backend)
    }

    /// Continues from what [`oneiro::stepped::Stepped::saved`] returned.
    ///
    /// # Errors
    /// Exit 5 for another number of words; then nothing has changed.
    pub fn restore(&mut self, words: &[u32]) -> Result {
        self.own
            .restore(words)
            .map_err(|problem| Failure::corrupt(problem).into())
    }

    /// What lives are now.
    pub fn state(&self) -> &oneiro::stepped::Stepped {
        &self.own
    }

    /// Simulates a cycle of episodes, by their numbers or all, with two commands for each robot, and at the same time begins others anew: each with the seed, and
    /// the two numbers, from which its random numbers are made. With (i, j) they are those of the episode j of the genome i that
    /// [`evaluate`](super::evaluate::evaluate) evaluates with that seed.
    ///
    /// # Errors
    /// Exit 3 for episodes, commands or seeds that aren't allowed; those of the device.
    pub fn step(
        &mut self,
        who: Option<&[usize]>,
        commands: &[f32],
        begin: &[(usize, u64, [u64; 2])],
        task: &Task,
    ) -> Result {
        check_seed(begin.iter().map(|(_, seed, _)| *seed).max().unwrap_or(0))?;
        let key =
            |&(life, seed, [genome, number]): &(usize, u64, [u64; 2])| (life, Key::rollout(seed, 0, genome, number));
        let begin: Vec<(usize, Key)> = begin.iter().map(key).collect();
        let Self { own, all, backend, .. } = self;
        let who = who.unwrap_or(all);
        let are_many = all.len() >= MANY;
        let mut step = || {
            device::with(backend, |evaluator| {
                own.step_and_begin(evaluator, &task.control, who, commands, &begin)
            })
        };
        // Another thread takes longer to wake up than a few episodes to pack.
        let stepped = if are_many { device::threaded(step) } else { step() };
        stepped?.map_err(Error::from)
    }
}

/// The arena of the foraging study, whose robots are commanded cycle by cycle. All are switched on from the first cycle on.
#[derive(Debug)]
pub struct Arena {
    swarm: Swarm,
    lamp: Lamp,
    backend: String,
    own: Option<Driven>,
    rewards: Vec<f32>,
    cycle: u32,
}

/// Names of what a robot in an arena reads: proximity, light, and whether it carries food.
pub use oneiro::foraging::READINGS as ROBOT_READINGS;

impl Arena {
    /// An arena that has not begun.
    ///
    /// # Errors
    /// Exit 3 for experiments without the foraging study's swarm; exit 4 if there is no such device.
    pub fn new(experiment: &Experiment, backend: &str) -> Result<Self> {
        let Some(own) = experiment.any().swarm() else {
            return Err(Error::input(format_args!(
                "{}: isn't of the foraging study; allowed: experiments with a table `swarm`, such as odowd2014-over.toml",
                experiment.name()
            )));
        };
        device::with(backend, |_| ())?;
        let plan = own.plan(0);
        let swarm = plan.settings.swarm();
        Ok(Self {
            swarm,
            lamp: plan.lamp(),
            backend: backend.to_owned(),
            own: None,
            rewards: vec![0.0; swarm.robots as usize],
            cycle: 0,
        })
    }

    /// Number of robots.
    pub fn robots(&self) -> usize {
        self.rewards.len()
    }

    /// Cycles of a life.
    pub fn length(&self) -> u32 {
        self.swarm.forager.cycles
    }

    /// Cycles that have passed.
    pub fn cycle(&self) -> u32 {
        self.cycle
    }

    /// Begins anew, with random numbers from a seed and a life's number.
    ///
    /// # Errors
    /// Exit 3 for more robots than can be commanded, and for a seed above 2^63 - 1; those of the device.
    pub fn begin(&mut self, seed: u64, life: u64) -> Result {
        check_seed(seed)?;
        let key = Key::rollout(seed, 0, 0, life);
        let made = device::with(&self.backend, |evaluator| {
            Driven::new(evaluator, &self.swarm, self.lamp, key)
        })?;
        self.own = Some(made?);
        self.rewards.fill(0.0);
        self.cycle = 0;
        Ok(())
    }

    /// Lets all robots live for a cycle, with two wheels' speeds each as shares of the greatest, -1 to 1.
    ///
    /// # Errors
    /// Exit 3 for speeds that aren't allowed, or before the beginning or after the end; those of the device.
    pub fn step(&mut self, speeds: &[f32]) -> Result {
        let length = self.length();
        let forager = &self.swarm.forager;
        let Some(world) = self.own.as_mut().filter(|_| self.cycle < length) else {
            return Err(Error::input(
                "step: the episode has ended or not begun; allowed: after reset",
            ));
        };
        let begins = self.cycle.is_multiple_of(self.swarm.interval);
        let command = |&[left, right]: &[f32; 2]| Command {
            drive: Some(Drive::of_wheels(
                [left, right].map(|share| share * forager.greatest_speed),
                forager,
            )),
            begins,
        };
        let commands: Vec<Command> = speeds.as_chunks().0.iter().map(command).collect();
        let before: Vec<f32> = world.line().robots.iter().map(|seen| seen.earned).collect();
        let line = device::with(&self.backend, |evaluator| world.cycle(evaluator, &commands))??;
        for ((reward, seen), before) in self.rewards.iter_mut().zip(&line.robots).zip(before) {
            // In an interval's first cycle its fitness restarts.
            *reward = seen.earned - if begins { 0.0 } else { before };
        }
        self.cycle += 1;
        Ok(())
    }

    /// Each robot's readings, as [`ROBOT_READINGS`] names them, 0 to 1.
    pub fn readings(&self) -> Vec<f32> {
        let Some(world) = &self.own else {
            return vec![0.0; self.robots() * ROBOT_READINGS.len()];
        };
        let each = world
            .readings()
            .iter()
            .zip(&world.line().robots)
            .flat_map(|(own, seen)| {
                let carries = f32::from(u8::from(seen.carries));
                own.near.into_iter().chain(own.light).chain([carries])
            });
        each.collect()
    }

    /// Pose of each robot: x and y in mm, and the heading in turns.
    pub fn poses(&self) -> Vec<[f32; 3]> {
        let Some(world) = &self.own else {
            return vec![[0.0; 3]; self.robots()];
        };
        let robots = world.line().robots.iter();
        robots.map(|seen| [seen.x, seen.y, seen.heading]).collect()
    }

    /// What each robot earned in the last cycle.
    pub fn rewards(&self) -> &[f32] {
        &self.rewards
    }
}
