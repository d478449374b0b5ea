//! Budgets: the episodes of a run, and what an optimiser makes of a number of them.

use oneiro::parameter::Invalid;

use super::{Feature, Given, Settings, refused};

/// The most generations that are counted.
pub const MOST_GENERATIONS: u32 = 1_000_000;

/// What the episodes of a run depend on besides the table `[evolution]`.
#[derive(Clone, Copy, Debug)]
pub struct Course {
    /// The controller's genes.
    pub genes: usize,
    /// Episodes of each individual in a generation.
    pub trials: u32,
    /// How many of the best are re-evaluated after the last generation, and the episodes of each.
    pub finalists: u32,
    pub finalist_episodes: u32,
}

/// Episodes of a run, at most. The same episode that is simulated again, for its trace, counts once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Episodes {
    /// Of all generations.
    pub generations: u64,
    /// Of the last pair of two populations.
    pub pair: u64,
    /// Of all finalists.
    pub finalists: u64,
}

impl Episodes {
    /// All of them.
    pub fn total(self) -> u64 {
        self.generations
            .saturating_add(self.pair)
            .saturating_add(self.finalists)
    }
}

impl Settings {
    /// Number of individuals that are re-evaluated after the last generation, at most: the luckiest, and `count` others if there
    /// are as many; of two populations their last pair.
    pub fn finalists(&self, count: u32, genes: usize) -> u32 {
        match count {
            0 => 0,
            _ if self.is(Feature::TwoPopulations) => 1,
            _ => 1 + count.min(self.population).min((self.kind.entry().survivors)(genes)),
        }
    }

    /// The episodes of a run.
    pub fn episodes(&self, course: Course) -> Episodes {
        let trials = u64::from(course.trials);
        let finalists = u64::from(self.finalists(course.finalists, course.genes));
        Episodes {
            generations: self.evaluations().saturating_mul(trials),
            pair: if self.is_coevolution() { trials } else { 0 },
            finalists: finalists * u64::from(course.finalist_episodes),
        }
    }

    /// Sets what follows from the budget of episodes, if there is one, once the rest is complete: the number of generations, or what an
    /// optimiser has instead. `is_given` says whether an experiment gives a key.
    ///
    /// # Errors
    /// A budget that is too small for one generation and the finalists.
    pub fn spend(&mut self, course: Course, is_given: &dyn Fn(&str) -> bool) -> Result<(), Invalid> {
        const KEY: &str = "evolution.episodes";
        let Some(budget) = self.budget else {
            return Ok(());
        };
        let given = Given {
            genes: course.genes,
            trials: course.trials,
            has_population: is_given("evolution.population"),
        };
        let left = |settings: &Self| {
            let Episodes { pair, finalists, .. } = settings.episodes(course);
            budget.saturating_sub(pair + finalists) / u64::from(course.trials)
        };
        (self.kind.entry().spend)(self, given, is_given, &left);
        let least = self.episodes(course).total();
        if least > budget {
            let problem = format!("is {budget}; allowed: {least} or more, for one generation and its finalists");
            return refused(KEY, problem);
        }
        if !self.is(Feature::SetsGenerations) && self.generations > MOST_GENERATIONS {
            let (generations, population) = (self.generations, self.population);
            let problem = format!(
                "makes {generations} generations of {population} individuals; allowed: up to {MOST_GENERATIONS}: a larger \
                 evolution.population, or fewer episodes"
            );
            return refused(KEY, problem);
        }
        Ok(())
    }
}

/// As many generations as fit, but at least one.
pub(crate) fn count_generations(settings: &mut Settings, individuals: u64) {
    let generations = individuals / u64::from(settings.genomes_per_generation());
    settings.generations = u32::try_from(generations).unwrap_or(u32::MAX).max(1);
}
