//! The papers' claims and the studies' verdicts on them. Each claim's statement, criterion and printed figures stand in
//! one table per study, `experiments/*/claims.toml`, and nowhere else.

use std::collections::BTreeMap;

use oneiro_statistics::{Interval, Probability, StudentT, bootstrap_interval, mean, mean_interval};
use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};

use super::file::Edition;
use super::verdict::{Judged, LEVEL, Part, Verdict, of_parts};

/// Name of a claim's first effect if the claim is judged separately in several combinations of settings.
pub(crate) const MET_IN: &str = "combinations in which the registered criterion is met";
/// Draws of a bootstrap.
pub(crate) const RESAMPLES: usize = 2000;

/// A figure that a verdict rests on.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Effect {
    /// Label, such as `d, no noise, noise on in simulation`.
    pub name: String,
    pub value: f64,
    /// Both ends of its 95 % interval over runs, if it is an estimate from several.
    pub interval: Option<[f64; 2]>,
    /// The paper's own value, if it prints one.
    pub paper: Option<f64>,
}

/// A test of significance.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Test {
    /// The comparison and its method.
    pub name: String,
    /// Statistic: `F`, `t`, `U` or `z`.
    pub statistic: String,
    /// Value of the statistic.
    pub value: f64,
    /// Degrees of freedom; empty if the statistic has none.
    pub(crate) degrees_of_freedom: Vec<f64>,
    /// Two-sided p value.
    pub p: f64,
    /// p after Holm's correction over the family of tests named in the preregistration.
    pub p_holm: Option<f64>,
}

impl Test {
    /// A test that belongs to no family yet.
    pub fn new(name: String, (statistic, value): (&str, f64), degrees_of_freedom: &[f64], p: Probability) -> Self {
        Self {
            name,
            statistic: statistic.into(),
            value,
            degrees_of_freedom: degrees_of_freedom.into(),
            p: p.value,
            p_holm: None,
        }
    }

    /// A t test.
    pub fn t(name: String, StudentT { t, df, p }: StudentT) -> Self {
        Self::new(name, ("t", t), &[df], p)
    }
}

/// One claim and its verdict.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Claim {
    /// Identifier, such as `C1`.
    pub id: String,
    /// Key of the question that it is part of an answer to.
    pub question: String,
    /// The paper's statement.
    pub(crate) statement: String,
    /// Where the paper makes it.
    pub source: String,
    /// The criterion.
    pub criterion: String,
    /// Whether the criterion is later than the results. Else it was registered before the runs of its edition.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub(crate) is_later: bool,
    /// Unit of analysis of the criterion's figures.
    pub unit: String,
    pub verdict: Verdict,
    /// Why: the figures that decide it with their intervals, or what is missing.
    pub reasons: Vec<String>,
    /// Whether the figures alone meet the registered criterion, without their intervals; `None` if it can't be checked.
    pub registered: Option<bool>,
    /// Figures that the verdict rests on.
    pub effects: Vec<Effect>,
    /// Significance tests: the paper's, over individuals, and ours, over runs.
    pub tests: Vec<Test>,
    /// The chance that a study of the paper's size shows it, if known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub power: Option<Power>,
    /// Remarks for the reader.
    pub(crate) remark: String,
}

/// The verdict of many runs of many robots on a claim, and how often five of the runs of one robot give each verdict.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Power {
    /// The verdict of all robots.
    pub verdict: Verdict,
    /// Sets of five runs of one robot.
    pub sets: u32,
    /// Fractions of the sets.
    pub holds: f64,
    pub undecided: f64,
    pub opposed: f64,
}

impl Power {
    /// The chance that five runs of one robot give the verdict of all robots, if that decides.
    pub(crate) fn chance(&self) -> Option<f64> {
        match self.verdict {
            Verdict::Holds => Some(self.holds),
            Verdict::Opposed => Some(self.opposed),
            Verdict::Undecided | Verdict::NotJudged => None,
        }
    }
}

/// A claim before it is judged.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Preregistered {
    id: String,
    question: String,
    /// Title in the preregistration.
    #[cfg_attr(not(test), expect(dead_code, reason = "the preregistration is held against it"))]
    title: String,
    statement: String,
    source: String,
    criterion: String,
    /// Whether the criterion was written when the results were known.
    #[serde(default)]
    is_later: bool,
    unit: String,
    #[serde(default)]
    remark: String,
    /// The paper's own figures by the name of the effect.
    #[serde(default)]
    paper: BTreeMap<String, f64>,
}

/// Evidence found for or against a claim.
#[derive(Debug, Default)]
pub(crate) struct Finding {
    /// Whether its registered criterion is met; `None` if the runs it needs are missing.
    pub registered: Option<bool>,
    /// The parts of its criterion with their verdicts.
    pub parts: Vec<Part>,
    /// What its criterion needs and was not measured, and why, if so.
    pub missing: Option<&'static str>,
    /// Why it is no question for a study, if so.
    pub not_judged: Option<&'static str>,
    pub effects: Vec<Effect>,
    pub tests: Vec<Test>,
    /// Remark that depends on the results, in addition to the claim's fixed one.
    pub(crate) remark: String,
}

impl Finding {
    /// The verdict by the intervals of the criterion's parts, and why, unless something is missing that it needs.
    pub(crate) fn verdict(&self) -> Judged {
        match (self.not_judged, self.missing) {
            (Some(why), _) => (Verdict::NotJudged, vec![why.to_owned()]),
            (None, Some(missing)) => (Verdict::Undecided, vec![missing.to_owned()]),
            (None, None) => of_parts(self.parts.clone()),
        }
    }

    /// Adds a figure. The paper's own figure comes from the table of claims.
    pub(crate) fn note(&mut self, name: impl Into<String>, value: f64) {
        self.estimate(name, value, None);
    }

    /// Adds a figure with its interval.
    pub(crate) fn estimate(&mut self, name: impl Into<String>, value: f64, interval: Option<Interval>) {
        self.effects.push(Effect {
            name: name.into(),
            value,
            interval: interval.map(|Interval { low, high }| [low, high]),
            paper: None,
        });
    }

    /// Adds the mean of a figure of each run, and returns it.
    pub(crate) fn mean(&mut self, name: impl Into<String>, runs: &[f64]) -> f64 {
        let mean = mean(runs);
        self.estimate(name, mean, mean_interval(runs, LEVEL).ok());
        mean
    }
}

/// The bootstrap's interval of a statistic of samples of runs, by draws that are always the same; `None` of single runs.
pub(crate) fn over_runs(samples: &[&[f64]], statistic: impl Fn(&[Vec<f64>]) -> f64) -> Option<Interval> {
    if samples.iter().any(|sample| sample.len() < 2) {
        return None;
    }
    bootstrap_interval(samples, statistic, LEVEL, RESAMPLES, &mut Pcg64::new(0, 0)).ok()
}

/// A study's claims, with the questions that they belong to and the words that its report uses.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Table {
    questions: BTreeMap<String, String>,
    /// Meanings of words.
    pub words: BTreeMap<String, String>,
    pub claims: Vec<Preregistered>,
}

impl Table {
    /// Parses a compiled-in table.
    pub(crate) fn of(table: &str) -> Self {
        Self::in_edition(table, Edition::default())
    }

    /// Parses a compiled-in table, with the criteria of an edition.
    pub(crate) fn in_edition(table: &str, edition: Edition) -> Self {
        const READ: &str = "a test has read it";
        let mut table: toml::Table = table.parse().expect(READ);
        if let Some(toml::Value::Array(claims)) = table.get_mut("claims") {
            let is_new = |claim: &toml::Value| claim.get("is_new").is_some();
            claims.retain(|claim| edition != Edition::First || !is_new(claim));
            for claim in claims.iter_mut().filter_map(toml::Value::as_table_mut) {
                claim.remove("is_new");
                if let Some(toml::Value::Table(first)) = claim.remove("first")
                    && edition == Edition::First
                {
                    claim.extend(first);
                }
            }
        }
        table.try_into().expect(READ)
    }

    /// Keys and words of all questions, in the order of their first claims.
    pub(crate) fn questions(&self) -> Vec<(&str, &str)> {
        let mut all: Vec<(&str, &str)> = Vec::new();
        for Preregistered { question, .. } in &self.claims {
            if all.iter().all(|(key, _)| key != question) {
                all.push((question, &self.questions[question]));
            }
        }
        all
    }
}

impl Preregistered {
    /// Identifier of the claim within its study, such as `C1`.
    pub(crate) fn id(&self) -> &str {
        &self.id
    }

    /// Key of the question that it is part of an answer to.
    #[cfg(test)]
    pub(crate) fn question(&self) -> &str {
        &self.question
    }

    /// The paper's own figure, if it prints one.
    pub(crate) fn paper(&self, name: &str) -> Option<f64> {
        self.paper.get(name).copied()
    }

    /// Adds the paper's own figures to the effects.
    pub(crate) fn beside_the_papers(&self, effects: Vec<Effect>) -> impl Iterator<Item = Effect> {
        effects.into_iter().map(|effect| Effect {
            paper: effect.paper.or_else(|| self.paper(&effect.name)),
            ..effect
        })
    }

    /// The claim with its verdict, its effects next to the paper's figures, and its remarks joined.
    pub(crate) fn judged(&self, (verdict, reasons): Judged, finding: Finding, remark: String) -> Claim {
        Claim {
            id: self.id.clone(),
            question: self.question.clone(),
            statement: self.statement.clone(),
            source: self.source.clone(),
            criterion: self.criterion.clone(),
            is_later: self.is_later,
            unit: self.unit.clone(),
            verdict,
            reasons,
            registered: finding.registered.filter(|_| finding.missing.is_none()),
            effects: self.beside_the_papers(finding.effects).collect(),
            tests: finding.tests,
            power: None,
            remark,
        }
    }

    /// Remark for any result.
    pub(crate) fn remark(&self) -> &str {
        &self.remark
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::{MIGLINO1995_CLAIMS, ODOWD2014_CLAIMS};
    use super::*;

    fn document(name: &str) -> String {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        std::fs::read_to_string(root.join(name)).unwrap()
    }

    /// Rows of all tables in a document, split into cells.
    fn rows(document: &str) -> impl Iterator<Item = Vec<&str>> {
        let rows = document
            .lines()
            .filter_map(|line| line.strip_prefix("| ")?.strip_suffix(" |"));
        rows.map(|row| row.split(" | ").collect())
    }

    /// Criteria match the preregistration word for word, and neither side has one that the other lacks.
    #[test]
    fn criteria_are_those_that_were_preregistered() {
        for (table, name, letter) in [
            (MIGLINO1995_CLAIMS, "studies/preregistration-1995.md", 'C'),
            (ODOWD2014_CLAIMS, "studies/preregistration-2014.md", 'D'),
        ] {
            let document = document(name);
            let is_claim = |row: &Vec<&str>| {
                let number = row[0].strip_prefix(letter).and_then(|rest| rest.split(' ').next());
                number.is_some_and(|number| number.parse::<u32>().is_ok())
            };
            let preregistered: Vec<Vec<&str>> = rows(&document).filter(is_claim).collect();
            let Table {
                questions,
                claims: criteria,
                ..
            } = Table::in_edition(table, Edition::First);
            assert!(
                criteria
                    .iter()
                    .all(|criterion| questions.contains_key(&criterion.question))
            );
            assert_eq!(Table::of(table).questions().len(), questions.len(), "each has claims");
            // Of a claim that makes several, those with a letter say what was registered elsewhere.
            let is_registered = |criterion: &&Preregistered| criterion.id.ends_with(|last: char| last.is_ascii_digit());
            let ours: Vec<Vec<String>> = criteria
                .iter()
                .filter(is_registered)
                .map(|criterion| {
                    vec![
                        format!("{} {}", criterion.id, criterion.title),
                        criterion.criterion.clone(),
                    ]
                })
                .collect();
            assert_eq!(ours, preregistered, "{name}");
            for criterion in criteria {
                assert!(
                    ![criterion.statement, criterion.source, criterion.unit].contains(&String::new()),
                    "{}",
                    criterion.id
                );
            }
        }
    }

    /// Words mean in the documents what they mean in the reports.
    #[test]
    fn documents_have_the_reports_words() {
        for (table, name) in [
            (MIGLINO1995_CLAIMS, "docs/miglino1995.md"),
            (ODOWD2014_CLAIMS, "docs/odowd2014.md"),
        ] {
            let document = document(name);
            for (word, meaning) in Table::of(table).words {
                assert!(
                    document.contains(&format!("\n| {word} | {meaning} |\n")),
                    "{name}: {word}"
                );
            }
        }
    }

    /// The paper's figures in the study's tables are those of the table of claims.
    #[test]
    fn documents_have_the_papers_figures() {
        let document = document("studies/miglino1995/README.md");
        let mut compared = 0;
        for criterion in Table::of(MIGLINO1995_CLAIMS).claims {
            let start = format!("{}: ", criterion.id);
            for row in rows(&document) {
                let Some(effect) = row[0].strip_prefix(&start) else {
                    continue;
                };
                let paper = criterion
                    .paper(effect)
                    .map_or_else(|| "-".to_owned(), |figure| figure.to_string());
                assert_eq!(row[1], paper, "{}", row[0]);
                compared += usize::from(paper != "-");
            }
        }
        assert!(compared >= 8, "{compared} figures");
    }
}
