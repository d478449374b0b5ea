//! Which swarms the study has, and how they are run.

use serde::Serialize;

use super::arms;
use super::results::{Case, Combination, Credit, Kind, Question, Run};
use crate::engine::handle::Engine;
use crate::exit::Result;
use crate::studies::assumptions::Assumption;
use crate::swarm::settings::Settings;
use crate::swarm::{Plan, live, steps};

/// What is asked of the study; what its directory says of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Study {
    /// Everything random follows from it.
    pub(crate) seed: u64,
    /// Runs of each case and kind.
    pub(crate) runs: u32,
    /// Mutation scales.
    pub(crate) scales: Vec<f64>,
    /// Rules of credit.
    pub(crate) credits: Vec<Credit>,
    /// The paper's six cases alone, without null and interventions.
    pub(crate) only_cases: bool,
    /// The assumption that is made otherwise.
    pub(crate) arm: String,
    /// Whether the open questions are asked.
    pub(crate) questions: bool,
}

/// The runs of some numbers at one scale and credit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cohort {
    /// Standard deviation of mutations.
    pub(crate) scale: f64,
    /// The rule of credit.
    pub(crate) credit: Credit,
    /// First number, and how many.
    pub(crate) first: u32,
    pub(crate) runs: u32,
}

/// Cases and kinds that a combination has.
pub(crate) fn conditions(only_cases: bool) -> Vec<(Case, Kind)> {
    let mut all: Vec<(Case, Kind)> = Case::ALL.map(|case| (case, Kind::Evolved)).into();
    if !only_cases {
        let kinds = [
            Kind::FitnessShuffled,
            Kind::SimulatorShuffled,
            Kind::SimulatorRight,
            Kind::SimulatorWrong,
            Kind::SimulatorRandom,
        ];
        let evolving = Case::ALL.into_iter().filter(|case| *case != Case::Random);
        all.extend(evolving.flat_map(|case| kinds.map(|kind| (case, kind))));
        all.extend([(Case::NoLight, Kind::Alone), (Case::Over, Kind::Alone)]);
    }
    all
}

impl Study {
    /// The settings of a case under this study's assumptions.
    pub(crate) fn settings(&self, case: Case, kind: Kind, scale: f64, credit: Credit) -> Settings {
        let mut settings = Settings {
            case,
            ..Settings::default()
        };
        settings.controllers.mutation_scale = scale;
        settings.simulators.mutation_scale = scale;
        settings.simulators.credit = credit;
        if let Some(arm) = arms::named(&self.arm) {
            (arm.change)(&mut settings);
        }
        if kind == Kind::Alone {
            settings.world.robots = 1;
        }
        settings
    }

    /// All that it takes for granted.
    pub(crate) fn assumptions(&self) -> Vec<Assumption> {
        let row = |name: &str, value: String, source: &str| Assumption {
            name: name.into(),
            value,
            source: source.into(),
        };
        let mut all = vec![
            row("runs", format!("{} of each case", self.runs), "paper: 10"),
            row(
                "arm",
                self.arm.clone(),
                "ours: what is made otherwise than preregistered, if anything",
            ),
        ];
        let settings = self.settings(Case::Over, Kind::Evolved, self.scales[0], self.credits[0]);
        let scales: Vec<String> = self.scales.iter().map(f64::to_string).collect();
        let credits: Vec<&str> = self.credits.iter().map(|credit| credit.title()).collect();
        for (key, value, source) in settings.listed() {
            let value = match key.as_str() {
                "case" => "all six".to_owned(),
                "controllers.mutation_scale" | "simulators.mutation_scale" => scales.join(", "),
                "simulators.credit" => credits.join(", "),
                _ => value,
            };
            all.push(row(&key, value, source));
        }
        all
    }

    /// The cohorts of the study, each so many runs of each case and kind.
    pub(crate) fn cohorts(&self, size: u32) -> Vec<Cohort> {
        let mut all = Vec::new();
        for &scale in &self.scales {
            for &credit in &self.credits {
                all.extend((0..self.runs).step_by(size as usize).map(|first| Cohort {
                    scale,
                    credit,
                    first,
                    runs: size.min(self.runs - first),
                }));
            }
        }
        all
    }

    /// The swarms of a cohort.
    pub(crate) fn plans(&self, cohort: &Cohort) -> Vec<Plan> {
        let numbers = cohort.first..cohort.first + cohort.runs;
        let plan = |(case, kind): (Case, Kind), number: u32| Plan {
            settings: self.settings(case, kind, cohort.scale, cohort.credit),
            kind,
            number,
            seed: self.seed_of(&(case, kind, cohort.scale.to_bits(), cohort.credit, number)),
        };
        let conditions = conditions(self.only_cases);
        conditions
            .into_iter()
            .flat_map(|condition| numbers.clone().map(move |number| (condition, number)))
            .map(|(condition, number)| plan(condition, number))
            .collect()
    }

    /// A seed of whatever tells a run from others; the arm is none of it, so that arms begin alike.
    fn seed_of(&self, what: &impl std::fmt::Debug) -> u64 {
        let hash = blake3::hash(format!("{}, {what:?}", self.seed).as_bytes());
        let bytes: &[u8; 32] = hash.as_bytes();
        u64::from_le_bytes(*bytes.first_chunk().expect("a hash has 32 bytes"))
    }

    /// Runs a cohort.
    pub(crate) fn run(&self, cohort: &Cohort, evaluations: &Engine) -> Result<Vec<Run>> {
        live(&self.plans(cohort), evaluations)
    }

    /// Robot-steps of a cohort, on board and in the arena.
    pub(crate) fn steps(&self, cohort: &Cohort) -> u64 {
        self.plans(cohort).iter().map(steps).sum()
    }

    /// The open questions: how many robots, how densely, how far they hear each other, how far off the light is.
    pub(crate) fn asked() -> Vec<Asked> {
        const ROBOTS: [u32; 7] = [1, 2, 5, 10, 20, 50, 100];
        const RANGES: [f32; 4] = [100.0, 250.0, 500.0, 1200.0];
        const LAMPS: [f32; 4] = [50.0, 100.0, 300.0, 1000.0];
        let own = Asked {
            about: "",
            robots: 10,
            radius: 600.0,
            range: 250.0,
            lamp: 100.0,
        };
        let mut all = Vec::new();
        for robots in ROBOTS {
            // As many robots on the area as ten have.
            let radius = (600.0 * (f64::from(robots) / 10.0).sqrt()) as f32;
            all.push(Asked {
                about: "density",
                robots,
                radius: radius.max(300.0),
                ..own
            });
            all.push(Asked {
                about: "arena",
                robots,
                ..own
            });
        }
        all.extend(RANGES.map(|range| Asked {
            about: "range",
            range,
            ..own
        }));
        all.extend(LAMPS.map(|lamp| Asked {
            about: "lamp",
            lamp,
            ..own
        }));
        all
    }

    /// The swarms of one of them.
    pub(crate) fn asked_plans(&self, asked: &Asked) -> Vec<Plan> {
        let mut settings = self.settings(Case::Over, Kind::Evolved, 0.2, Credit::Matched);
        settings.world.robots = asked.robots;
        settings.world.forager.arena_radius = asked.radius;
        settings.world.range = asked.range;
        settings.world.forager.lamp_behind_wall = asked.lamp;
        (0..self.runs)
            .map(|number| Plan {
                settings: settings.clone(),
                kind: Kind::Evolved,
                number,
                seed: self.seed_of(&(asked, number)),
            })
            .collect()
    }

    /// Answers one of them.
    pub(crate) fn answer(&self, asked: &Asked, evaluations: &Engine) -> Result<Question> {
        let runs = live(&self.asked_plans(asked), evaluations)?;
        Ok(Question {
            about: asked.about.into(),
            robots: asked.robots,
            arena_radius: f64::from(asked.radius),
            range: f64::from(asked.range),
            lamp: f64::from(asked.lamp),
            runs,
        })
    }
}

/// One of the open questions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Asked {
    pub(crate) about: &'static str,
    pub(crate) robots: u32,
    pub(crate) radius: f32,
    pub(crate) range: f32,
    pub(crate) lamp: f32,
}

impl Asked {
    /// What its runs are kept under.
    pub(crate) fn name(&self) -> String {
        let Self {
            about,
            robots,
            radius,
            range,
            lamp,
        } = self;
        format!("{about}-{robots}-{radius}-{range}-{lamp}")
    }
}

/// Gathers runs of the same combination.
pub(crate) fn combined(cohorts: Vec<(Cohort, Vec<Run>)>) -> Vec<Combination> {
    let mut all: Vec<Combination> = Vec::new();
    for (cohort, runs) in cohorts {
        match all
            .iter_mut()
            .find(|own| own.scale == cohort.scale && own.credit == cohort.credit)
        {
            Some(own) => own.runs.extend(runs),
            None => all.push(Combination {
                scale: cohort.scale,
                credit: cohort.credit,
                runs,
            }),
        }
    }
    all
}
