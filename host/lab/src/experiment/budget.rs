//! A budget of episodes in words.

use oneiro_base::console::counted;
use oneiro_evolve::Kind;
use oneiro_evolve::settings::{Course, Episodes, Settings};
use oneiro_report::numbers::count;

/// What an optimiser makes of a budget.
pub(super) fn words(budget: u64, episodes: Episodes, evolution: &Settings, course: Course) -> String {
    let count = |n: u64| count(n).replace('\u{202f}', ",");
    let individuals = counted(evolution.population, "individual", "individuals");
    let individuals = if evolution.kind == Kind::Race {
        format!("generations of up to {individuals}")
    } else {
        let generations = counted(evolution.generations, "generation", "generations");
        if evolution.is_coevolution() {
            let opponents = counted(evolution.tables.opponents.contests, "opponent", "opponents");
            format!("{generations} of 2 x {individuals} x {opponents}")
        } else {
            format!("{generations} of {individuals}")
        }
    };
    let trials = counted(course.trials, "trial", "trials");
    let mut parts = vec![format!("{individuals} x {trials} = {}", count(episodes.generations))];
    if episodes.pair > 0 {
        parts.push(format!("the last pair x {trials} = {}", count(episodes.pair)));
    }
    if episodes.finalists > 0 {
        let finalists = evolution.finalists(course.finalists, course.genes);
        let finalists = counted(finalists, "finalist", "finalists");
        let (each, all) = (course.finalist_episodes, count(episodes.finalists));
        parts.push(format!("{finalists} x {each} = {all}"));
    }
    let unused = count(budget.saturating_sub(episodes.total()));
    format!("{} episodes: {}; {unused} unused", count(budget), parts.join(", "))
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

    use oneiro::batch::Rollout;
    use oneiro::cpu::Cpu;
    use oneiro::parameter::Choice;
    use oneiro_base::exit::Result;
    use oneiro_evolve::Kind;

    use crate::engine::handle::Engine;
    use crate::engine::job::{Finished, Job, Request, Results, Step};
    use crate::engine::scheduler::{Record, Runs, UnderWay, Waiting};
    use crate::runs::{self, Experiment, Recording};

    /// A run whose episodes are counted: all of them, and the most that it asked for at once.
    struct Counted {
        experiment: Arc<dyn Experiment>,
        all: Arc<AtomicU64>,
        most: Arc<AtomicU64>,
    }

    struct Counting {
        job: Box<dyn Job>,
        all: Arc<AtomicU64>,
        most: Arc<AtomicU64>,
    }

    impl Job for Counting {
        fn ask(&self) -> Option<Request<'_>> {
            self.job.ask()
        }

        fn rollouts<'a>(&'a self, into: &mut Vec<Rollout<'a>>) {
            self.job.rollouts(into);
        }

        fn tell(&mut self, results: &Results<'_>) -> Result<Step> {
            let count = results.fitness.len() as u64;
            self.all.fetch_add(count, Ordering::Relaxed);
            self.most.fetch_max(count, Ordering::Relaxed);
            self.job.tell(results)
        }

        fn save(&self) -> Vec<u8> {
            self.job.save()
        }

        fn finish(&mut self, table: &str) -> Result<Finished> {
            self.job.finish(table)
        }
    }

    struct Unrecorded;

    impl Record<Counting> for Unrecorded {
        fn add(&mut self, _: &Counting, _: Step) -> Result {
            Ok(())
        }
    }

    impl Runs for Counted {
        type Job = Counting;
        type Record = Unrecorded;

        fn begin(&mut self, _: usize) -> Result<(Counting, Unrecorded)> {
            let job = Arc::clone(&self.experiment).job(1, Recording::Tables)?;
            let [all, most] = [&self.all, &self.most].map(Arc::clone);
            Ok((Counting { job, all, most }, Unrecorded))
        }

        fn finish(&mut self, _: Vec<UnderWay<Self>>) -> Result {
            Ok(())
        }

        fn end(&mut self, _: Vec<&mut UnderWay<Self>>) -> Result {
            Ok(())
        }

        fn stopped(&self) -> String {
            String::new()
        }
    }

    /// The episodes of a run, and the most that it asked for at once.
    fn counted(experiment: &Arc<dyn Experiment>) -> [u64; 2] {
        let engine = Engine::new(Box::new(Cpu::new(Some(1)).unwrap()), Arc::new(AtomicBool::new(false)));
        let mut runs = Counted {
            experiment: Arc::clone(experiment),
            all: Arc::default(),
            most: Arc::default(),
        };
        let waiting = vec![Waiting {
            run: 0,
            kernel: experiment.kernel(),
        }];
        engine.run(waiting, 1, &mut runs, &mut ()).unwrap();
        [&runs.all, &runs.most].map(|count| count.load(Ordering::Relaxed))
    }

    fn read(kind: Kind, more: &[String]) -> Result<Arc<dyn Experiment>> {
        let name = kind.entry().name;
        let mut set: Vec<String> = [
            &format!("evolution.kind={name}"),
            "cycles=10",
            "trials=2",
            "evolution.finalists=3",
            "evolution.finalist_lives=4",
        ]
        .map(str::to_owned)
        .into();
        let file = match kind {
            Kind::Coevolution => {
                let few = [
                    "evolution.population=6",
                    "evolution.parents=3",
                    "evolution.opponents.contests=2",
                ];
                set.extend(few.map(str::to_owned));
                "predator-prey.toml"
            }
            // It has four genes.
            Kind::Grid => "aggregation.toml",
            _ => "khepera-avoidance.toml",
        };
        if kind == Kind::Race {
            set.push("record.individuals=false".into());
        }
        if matches!(kind, Kind::MapElites | Kind::Novelty) {
            let descriptor = "{ measure = 'end_x_mm', least = 0, greatest = 600, cells = 20 }";
            set.push(format!("evolution.descriptors=[{descriptor}]"));
        }
        set.extend_from_slice(more);
        let path = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../../experiments")
            .join(file);
        runs::read(&path, &set)
    }

    /// No optimiser passes its budget, and what is left is too little for another generation; or another level of a grid.
    #[test]
    fn a_budget_bounds_all_optimisers_alike() {
        for &(name, kind, _) in Kind::CHOICES {
            // Enough for a race, which ends where too little is left for another.
            let budget: u64 = if kind == Kind::Race { 12_345 } else { 1_234 };
            let with = |more: &str| read(kind, &[format!("evolution.episodes={budget}"), more.to_owned()]);
            let experiment = with("seed=1").unwrap();
            let [all, most] = counted(&experiment);
            let own = experiment.single().unwrap();
            // The champion's test decides nothing.
            let all = all - u64::from(own.test_episodes());
            assert!(all <= budget, "{name}: {all}");
            let words = experiment.budget().unwrap();
            if kind == Kind::Grid {
                let levels = own.settings().evolution.tables.grid.levels;
                let refused = with(&format!("evolution.grid.levels={}", levels + 1))
                    .unwrap_err()
                    .to_string();
                assert!(refused.contains("evolution.episodes: is 1234; allowed: "), "{refused}");
            } else {
                assert!(all + most > budget, "{name}: {all}, {most} at once");
            }
            if kind != Kind::Race {
                assert_eq!(own.episodes().total(), all, "{name}");
                assert!(
                    words.ends_with(&format!("; {} unused", budget - all)),
                    "{name}: {words}"
                );
            }
            assert!(
                experiment.episodes() == Some(budget) && words.contains(" episodes: "),
                "{words}"
            );
        }
    }

    #[test]
    fn a_budget_takes_the_place_of_generations() {
        let text = |kind: Kind, set: &[&str]| {
            let set: Vec<String> = set.iter().map(|own| (*own).to_owned()).collect();
            read(kind, &set)
                .map(|own| own.resolved_toml(1))
                .map_err(|failure| failure.to_string())
        };
        // The file has generations, which a setting outranks, and the other way round.
        let made = text(Kind::Genetic, &["evolution.episodes=1016"]).unwrap();
        assert!(
            made.contains("\nepisodes = 1016\n") && !made.contains("generations"),
            "{made}"
        );
        for (kind, other) in [
            (Kind::Genetic, "evolution.generations=200"),
            (Kind::Race, "evolution.race.lives=500"),
        ] {
            let refused = text(kind, &["evolution.episodes=1016", other]).unwrap_err();
            assert!(refused.contains("is given beside evolution."), "{refused}");
        }
        let small = text(Kind::Genetic, &["evolution.episodes=215"]).unwrap_err();
        assert!(
            small.contains("evolution.episodes: is 215; allowed: 216 or more, for one generation and its finalists"),
            "{small}"
        );
        let many = text(
            Kind::CmaEs,
            &["evolution.episodes=100000000", "evolution.population=12"],
        )
        .unwrap_err();
        assert!(many.contains("makes 4166666 generations of 12 individuals"), "{many}");
    }

    #[test]
    fn words_say_what_becomes_of_a_budget() {
        let words = |kind: Kind, set: &[&str]| {
            let set: Vec<String> = set.iter().map(|own| (*own).to_owned()).collect();
            read(kind, &set).unwrap().budget().unwrap()
        };
        assert_eq!(
            words(Kind::Genetic, &["evolution.episodes=20000"]),
            "20,000 episodes: 99 generations of 100 individuals x 2 trials = 19,800, 4 finalists x 4 = 16; 184 unused"
        );
        assert_eq!(
            words(Kind::Coevolution, &["evolution.episodes=1000"]),
            "1,000 episodes: 20 generations of 2 x 6 individuals x 2 opponents x 2 trials = 960, the last pair x 2 trials = 2, \
             1 finalist x 4 = 4; 34 unused"
        );
        assert_eq!(
            words(Kind::Race, &["evolution.episodes=1000"]),
            "1,000 episodes: generations of up to 100 individuals x 2 trials = 984, 4 finalists x 4 = 16; 0 unused"
        );
    }
}
