//! The study's foragers, and how they are run.

use std::fmt;

use oneiro::parameter::Choice;
use oneiro_base::exit::Result;
use oneiro_lab::engine::handle::Engine;
use oneiro_lab::experiment;
use oneiro_lab::experiment::source::{Parsed, Setting, Source};
use oneiro_lab::experiment::swarm::SwarmExperiment;
use oneiro_lab::swarm::settings::Settings;
use oneiro_lab::swarm::{Plan, live, steps};
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use super::results::{Case, Combination, Credit, Kind, Question, Run};
use crate::assumptions::Assumption;
use crate::file::{self, Arm, StudyFile};

/// Values from the command line.
#[derive(Clone, Debug)]
pub struct Asked {
    /// Seed of everything random.
    pub seed: u64,
    /// Runs of each case and kind; `None` takes the file's number.
    pub runs: Option<u32>,
    /// Mutation scales and rules of credit; empty takes the file's.
    pub scales: Vec<f64>,
    pub credits: Vec<Credit>,
    /// Whether to run only the paper's six cases, without the null and the interventions.
    pub only_cases: bool,
    /// Whether to run the open questions.
    pub questions: bool,
}

/// The study's file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    experiment: Option<String>,
    runs: u32,
    scales: Vec<f64>,
    credits: Vec<Credit>,
    #[serde(default)]
    set: Table,
    conditions: Vec<Conditions>,
    questions: Questions,
    /// Read before the rest.
    #[serde(default, rename = "arms")]
    _arms: IgnoredAny,
}

/// All kinds of all cases.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Conditions {
    cases: Vec<Case>,
    kinds: Vec<Kind>,
    #[serde(default)]
    set: Table,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Questions {
    scale: f64,
    credit: Credit,
    asked: Vec<OneQuestion>,
}

#[derive(Deserialize)]
struct OneQuestion {
    about: String,
    #[serde(flatten)]
    set: Table,
}

/// A study under an arm.
#[derive(Debug)]
pub(crate) struct Study {
    record: Record,
    arm: Arm,
    /// The foragers of each combination of scale and credit.
    combinations: Vec<Foragers>,
    /// The open questions with the settings of their foragers; empty if not requested.
    questions: Vec<(Open, Settings)>,
}

/// Record of the settings for the study's directory.
#[derive(Clone, Debug, Serialize)]
struct Record {
    seed: u64,
    runs: u32,
    scales: Vec<f64>,
    credits: Vec<Credit>,
    only_cases: bool,
    arm: String,
    questions: bool,
    /// Hash of a user's study file.
    #[serde(skip_serializing_if = "Option::is_none")]
    study: Option<String>,
}

/// The foragers of one scale and credit.
#[derive(Debug)]
struct Foragers {
    scale: f64,
    credit: Credit,
    all: Vec<(Case, Kind, Settings)>,
}

/// Some consecutively numbered runs of one combination.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cohort<'a> {
    foragers: &'a Foragers,
    /// First number, and how many.
    first: u32,
    runs: u32,
}

impl Cohort<'_> {
    /// Name under which the cohort's runs are saved.
    pub(crate) fn name(&self) -> String {
        let Foragers { scale, credit, .. } = self.foragers;
        format!("{scale}-{}-{:04}", credit.word(), self.first)
    }
}

impl Study {
    /// Whether open questions are asked.
    pub(crate) fn has_questions(&self) -> bool {
        !self.questions.is_empty()
    }

    /// Reads the study under an arm.
    ///
    /// # Errors
    /// Exit 2 for an unknown arm. Exit 3: the file, line and column (or the arm), the key, the value found and the
    /// values allowed.
    pub(crate) fn new(file: &StudyFile, arm: &str, asked: &Asked) -> Result<Self> {
        let arm = file.arm(arm)?;
        file.under(&arm, |values: File, source| {
            check(&values, source)?;
            let (path, text) = file.experiment(values.experiment.as_deref())?;
            let base = Parsed::new(path.display().to_string(), &text)?;
            let or = |values: &[f64], file: &[f64]| if values.is_empty() { file } else { values }.to_vec();
            let record = Record {
                seed: asked.seed,
                runs: asked.runs.unwrap_or(values.runs),
                scales: or(&asked.scales, &values.scales),
                credits: if asked.credits.is_empty() {
                    &values.credits
                } else {
                    &asked.credits
                }
                .clone(),
                only_cases: asked.only_cases,
                arm: arm.name.clone(),
                questions: asked.questions,
                study: file.own_hash(),
            };
            let of_all = setting_list("set", &values.set, source)?;
            let of_null = if arm.is_main() {
                of_all.clone()
            } else {
                setting_list("set", &of_the_null(&values.set), source)?
            };
            let settings =
                |scale: f64, credit: Credit, (case, kind): (Case, Kind), more: Vec<Setting>| -> Result<Settings> {
                    const WORD: &str = "cases and rules are words";
                    let of_study = [
                        ("swarm.case", Value::try_from(case).expect(WORD)),
                        ("swarm.controllers.mutation_scale", Value::Float(scale)),
                        ("swarm.simulators.mutation_scale", Value::Float(scale)),
                        ("swarm.simulators.credit", Value::try_from(credit).expect(WORD)),
                    ];
                    // The case leaves out what only others need.
                    let rank = |key: &str| if key == "swarm.case" { 3 } else { 1 };
                    let of_study = of_study.map(|(key, value)| {
                        Setting::at(format!("{}, {key}", record.arm), key, &value).ranked(rank(key))
                    });
                    let more = more.into_iter().map(|setting| setting.ranked(2)).collect::<Vec<_>>();
                    let of_kind = if kind == Kind::FitnessShuffled {
                        &of_null
                    } else {
                        &of_all
                    };
                    let set = [&of_study[..], of_kind, &more].concat();
                    let why = "is a control, which the kinds of [[conditions]] give";
                    let experiment = SwarmExperiment::without_control(&path, &base, &set, why)?;
                    Ok(experiment.settings().clone())
                };
            let mut combinations = Vec::new();
            for &scale in &record.scales {
                for &credit in &record.credits {
                    let mut all = Vec::new();
                    for (place, conditions) in values.conditions.iter().enumerate() {
                        let set = setting_list(&format!("conditions[{place}].set"), &conditions.set, source)?;
                        for &case in &conditions.cases {
                            for &kind in conditions
                                .kinds
                                .iter()
                                .filter(|kind| !asked.only_cases || **kind == Kind::Evolved)
                            {
                                all.push((case, kind, settings(scale, credit, (case, kind), set.clone())?));
                            }
                        }
                    }
                    combinations.push(Foragers { scale, credit, all });
                }
            }
            let mut questions = Vec::new();
            for (place, question) in values.questions.asked.iter().enumerate().filter(|_| asked.questions) {
                let set = setting_list(&format!("questions.asked[{place}]"), &question.set, source)?;
                let Questions { scale, credit, .. } = values.questions;
                let settings = settings(scale, credit, (Case::Over, Kind::Evolved), set)?;
                questions.push((Open::new(&question.about, &settings), settings));
            }
            Ok(Self {
                record,
                arm: arm.clone(),
                combinations,
                questions,
            })
        })
    }

    /// Record of the settings for the study's directory.
    pub(crate) fn record(&self) -> String {
        serde_json::to_string_pretty(&self.record).expect("numbers and words are JSON")
    }

    pub(crate) fn seed(&self) -> u64 {
        self.record.seed
    }

    /// Runs of each case and kind.
    pub(crate) fn runs(&self) -> u32 {
        self.record.runs
    }

    /// Settings that all foragers share, before the values in which they differ.
    pub(crate) fn settings(&self) -> &Settings {
        let all = self.combinations.iter().flat_map(|combination| &combination.all);
        let mut of_light = all.filter(|(case, kind, _)| (*case, *kind) == (Case::Over, Kind::Evolved));
        &of_light.next().expect("every study has the light over the nest").2
    }

    /// All values in force.
    pub(crate) fn assumptions(&self) -> Vec<Assumption> {
        let join = |words: Vec<String>| words.join(", ");
        let scales = join(self.record.scales.iter().map(f64::to_string).collect());
        let credits = join(self.record.credits.iter().map(|credit| credit.word().into()).collect());
        let listed = self.settings().listed();
        let runs = ("runs".to_owned(), format!("{} of each case", self.record.runs));
        let rows = listed.iter().map(|(key, value, _)| {
            let value = match key.as_str() {
                "case" => "all six",
                "controllers.mutation_scale" | "simulators.mutation_scale" => &scales,
                "simulators.credit" => &credits,
                _ => value,
            };
            (format!("swarm.{key}"), value.to_owned())
        });
        self.arm.assumptions(std::iter::once(runs).chain(rows), |name| {
            match name.strip_prefix("swarm.") {
                None => Some("O'Dowd et al. 2014, section 4.5: 10"),
                Some(key) => listed.iter().find(|(name, ..)| name == key).map(|(.., source)| *source),
            }
        })
    }

    /// The cohorts of the study, with `size` runs of each case and kind in each.
    pub(crate) fn cohorts(&self, size: u32) -> impl Iterator<Item = Cohort<'_>> {
        let runs = self.record.runs;
        self.combinations.iter().flat_map(move |foragers| {
            (0..runs).step_by(size as usize).map(move |first| Cohort {
                foragers,
                first,
                runs: size.min(runs - first),
            })
        })
    }

    /// The foragers of a cohort.
    fn plans(&self, cohort: &Cohort<'_>) -> Vec<Plan> {
        let Foragers { scale, credit, all } = cohort.foragers;
        let numbers = cohort.first..cohort.first + cohort.runs;
        let plans = all.iter().flat_map(|(case, kind, settings)| {
            numbers.clone().map(move |number| Plan {
                settings: settings.clone(),
                kind: *kind,
                number,
                seed: self.seed_of(&(case, kind, scale.to_bits(), credit, number)),
            })
        });
        plans.collect()
    }

    /// Seed derived from a run's identity. The arm isn't part of it, so that all arms begin alike.
    fn seed_of(&self, what: &impl fmt::Debug) -> u64 {
        let hash = blake3::hash(format!("{}, {what:?}", self.record.seed).as_bytes());
        let bytes: &[u8; 32] = hash.as_bytes();
        u64::from_le_bytes(*bytes.first_chunk().expect("a hash has 32 bytes"))
    }

    /// Runs a cohort.
    pub(crate) fn run(&self, cohort: &Cohort<'_>, evaluations: &Engine) -> Result<Vec<Run>> {
        live(&self.plans(cohort), evaluations)
    }

    /// The open questions.
    pub(crate) fn questions(&self) -> &[(Open, Settings)] {
        &self.questions
    }

    /// Total robot-steps, on board and in the arena.
    pub(crate) fn steps(&self) -> u64 {
        let of = |settings: &Settings| steps(&plan(settings, 0, 0)).iter().sum::<u64>();
        let foragers = self
            .combinations
            .iter()
            .flat_map(|combination| &combination.all)
            .map(|(.., settings)| of(settings));
        let questions = self.questions.iter().map(|(_, settings)| of(settings));
        u64::from(self.record.runs) * foragers.chain(questions).sum::<u64>()
    }

    /// Answers an open question.
    pub(crate) fn answer(&self, (open, settings): &(Open, Settings), evaluations: &Engine) -> Result<Question> {
        let numbers = 0..self.record.runs;
        let plans: Vec<Plan> = numbers
            .map(|number| plan(settings, number, self.seed_of(&(open, number))))
            .collect();
        Ok(Question {
            about: open.about.clone(),
            robots: open.robots,
            arena_radius: f64::from(open.radius),
            range: f64::from(open.range),
            lamp: f64::from(open.lamp),
            runs: live(&plans, evaluations)?,
        })
    }
}

/// Keys that the study gives its foragers itself, and where it has them from.
const GIVEN: [(&str, &str); 7] = [
    ("name", "no such key: the study's runs have no names"),
    ("seed", "--seed"),
    ("swarm.case", "the cases of [[conditions]]"),
    ("swarm.control", "the kinds of [[conditions]]"),
    ("swarm.controllers.mutation_scale", "scales"),
    ("swarm.simulators.mutation_scale", "scales"),
    ("swarm.simulators.credit", "credits"),
];

/// What an arm sets of the null: all except the size of the store. Within an interval a robot's fitness only grows, and of a full store
/// the lowest pair leaves, so the best pair nearly always stays whatever the size. Fitness that was shuffled may fall: the size would change the
/// null far more than the swarm, and with it verdicts.
fn of_the_null(set: &Table) -> Table {
    let mut set = set.clone();
    let simulators = set.get_mut("swarm").and_then(|swarm| swarm.get_mut("simulators"));
    if let Some(Value::Table(simulators)) = simulators {
        simulators.remove("pairs");
    }
    set
}

/// Settings from a table of the study's file, without keys that the study gives itself.
fn setting_list(under: &str, table: &Table, source: &Source<'_>) -> Result<Vec<Setting>> {
    let leaves = file::leaves(table);
    let given = |(name, _): &&(&str, &str)| leaves.iter().any(|(key, _)| key == name);
    match GIVEN.iter().find(given) {
        Some((key, instead)) => {
            let problem = format!("is given by the study; allowed: {instead}");
            Err(source.invalid_key(&format!("{under}.{key}"), problem))
        }
        None => Ok(file::settings(under, table, source)),
    }
}

/// Checks what the study needs, and values that mean the same as a key of experiments.
fn check(values: &File, source: &Source<'_>) -> Result {
    let has_light_over =
        |conditions: &Conditions| conditions.cases.contains(&Case::Over) && conditions.kinds.contains(&Kind::Evolved);
    if !values.conditions.iter().any(has_light_over) {
        let problem = "lack the case \"over\" of the kind \"evolved\", the reference of the others; allowed: with it";
        return Err(source.invalid("conditions", problem));
    }
    for (place, conditions) in values.conditions.iter().enumerate() {
        if let Some(rival) = conditions.kinds.iter().find(|kind| Kind::RIVALS.contains(kind)) {
            let problem = format!(
                "has {}, which no claim is about; allowed: evolved, or a control",
                rival.title()
            );
            return Err(source.invalid(&format!("conditions[{place}].kinds"), problem));
        }
    }
    for (key, is_empty) in [
        ("scales", values.scales.is_empty()),
        ("credits", values.credits.is_empty()),
    ] {
        if is_empty {
            return Err(source.invalid(key, "is empty; allowed: at least one"));
        }
    }
    let scales = values.scales.iter().enumerate();
    let scales = scales.map(|(index, scale)| (format!("scales[{index}]"), scale));
    for (key, scale) in scales.chain([("questions.scale".to_owned(), &values.questions.scale)]) {
        let (is_allowed, allowed) = experiment::allows("swarm.controllers.mutation_scale", scale);
        if !is_allowed {
            return Err(source.invalid(&key, format_args!("is {scale}; allowed: {allowed}")));
        }
    }
    Ok(())
}

fn plan(settings: &Settings, number: u32, seed: u64) -> Plan {
    Plan {
        settings: settings.clone(),
        kind: Kind::Evolved,
        number,
        seed,
    }
}

/// An open question.
#[derive(Clone, PartialEq)]
pub(crate) struct Open {
    about: String,
    robots: u32,
    radius: f32,
    range: f32,
    lamp: f32,
}

/// Seeds are derived from this text, so it must never change.
impl fmt::Debug for Open {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Asked")
            .field("about", &self.about)
            .field("robots", &self.robots)
            .field("radius", &self.radius)
            .field("range", &self.range)
            .field("lamp", &self.lamp)
            .finish()
    }
}

impl Open {
    fn new(about: &str, settings: &Settings) -> Self {
        Self {
            about: about.into(),
            robots: settings.world.robots,
            radius: settings.world.forager.arena_radius,
            range: settings.world.range,
            lamp: settings.world.forager.lamp_behind_wall,
        }
    }

    /// Name under which its runs are saved.
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

/// Groups runs by combination.
pub(crate) fn combine(cohorts: Vec<(Cohort<'_>, Vec<Run>)>) -> Vec<Combination> {
    let mut all: Vec<Combination> = Vec::new();
    for (Cohort { foragers, .. }, runs) in cohorts {
        let is_of = |combination: &&mut Combination| {
            combination.scale == foragers.scale && combination.credit == foragers.credit
        };
        match all.iter_mut().find(is_of) {
            Some(combination) => combination.runs.extend(runs),
            None => all.push(Combination {
                scale: foragers.scale,
                credit: foragers.credit,
                runs,
            }),
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use oneiro::foraging::Foraging;

    use super::*;
    use crate::file::ODOWD2014;

    fn study(arm: &str) -> Study {
        let asked = Asked {
            seed: 1,
            runs: Some(2),
            scales: vec![0.2],
            credits: Vec::new(),
            only_cases: false,
            questions: false,
        };
        Study::new(&StudyFile::open(&ODOWD2014, None).unwrap(), arm, &asked).unwrap()
    }

    /// The settings of a kind with the light over the nest.
    fn of(study: &Study, kind: Kind) -> &Settings {
        let all = &study.combinations[0].all;
        &all.iter().find(|one| (one.0, one.1) == (Case::Over, kind)).unwrap().2
    }

    #[test]
    fn other_stores_of_pairs_have_the_main_null() {
        let (main, one) = (study("main"), study("pairs-1"));
        let [evolved, null] = [Kind::Evolved, Kind::FitnessShuffled].map(|kind| of(&one, kind));
        assert_eq!((evolved.simulators.pairs, null.simulators.pairs), (1, 10));
        assert_eq!(null, of(&main, Kind::FitnessShuffled));
        // Other arms change the null.
        let oldest = study("oldest-leaves");
        assert_ne!(of(&oldest, Kind::FitnessShuffled), of(&main, Kind::FitnessShuffled));
    }

    #[test]
    fn phototaxis_needs_light_except_in_its_arm() {
        let threshold = |arm| of(&study(arm), Kind::Evolved).world.forager.phototaxis_threshold;
        let Foraging {
            ambient, light_noise, ..
        } = of(&study("main"), Kind::Evolved).world.forager;
        assert!(threshold("main") > ambient + light_noise);
        assert_eq!(threshold("phototaxis-always"), 0.0);
    }
}
