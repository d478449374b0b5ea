//! Judges the claims of the paper by the criteria of `studies/preregistration-2014.md`, in the same way for each
//! combination of mutation scale and credit, except those that the open questions answer: whether each registered criterion is met, and the verdict. Comparisons that were registered
//! as tests hold by their p after Holm's correction, and are opposed by it where the difference has the other sign. Other figures are
//! judged by their 95 % intervals over runs.

use std::ops::Range;

use Case::{NoLight, Opposite, OppositeThenOver, Over, OverThenOpposite, Random};
use Kind::{Alone, Evolved, FitnessShuffled as Null, SimulatorRandom, SimulatorRight};
use oneiro::foraging::Light;
use oneiro_report::numbers::significant;
use oneiro_statistics::{Interval, cohens_d, holm, mean, one_sample_t, paired_t, ratio_interval, student_t, subset};
use rand_pcg::Pcg64;

use super::measures::{
    ALL, BEFORE_MOVE, BIN, FIRST_HALF, G0, G1, LATE, S0, SECOND_HALF, SETTLED, convergence_interval, minutes,
};
use super::results::{Case, Combination, Kind, Question, Results, Run};
use crate::ODOWD2014_CLAIMS;
use crate::claims::{Claim, Effect, Finding, MET_IN, Preregistered, Table, Test, over_runs};
use crate::verdict::{Judged as Judgement, Part, Verdict};

/// Significance level of the study and of the paper.
const LEVEL: f64 = 0.05;
const PAPERS_LEVEL: f64 = 0.005;
/// Standard deviation above which genes are widely spread: three quarters of that of a uniform distribution.
const WIDE: f64 = 0.214;
/// The bounds of the bins.
const LOW: f64 = 0.33;
const HIGH: f64 = 0.66;
/// Number of runs from which the fraction of smaller studies that would find the paper's verdict is reported.
const MANY: usize = 20;
const SETS: usize = 1000;

/// Why D11 has no verdict.
const HARDWARE: &str = "true by hardware: a computer of today simulates ten lives of 60 s in far less than 34 s";
/// What D12a and D12b lack where the open questions were not asked.
const NOT_ASKED: &str = "the open questions were not asked (--questions)";

/// Robots of the registered rule of convergence.
const SIZES: [u32; 4] = [5, 10, 20, 50];
/// Fraction of linked robots below which connectivity is limited.
const LINKED: f64 = 0.9;
/// The paper's range of messages, mm.
const PAPERS_RANGE: f64 = 250.0;

/// Judges all claims, D1 to D17.
pub(crate) fn judge(results: &Results) -> Vec<Claim> {
    let Table { claims, .. } = Table::of(ODOWD2014_CLAIMS);
    claims.iter().map(|criterion| claim(results, criterion)).collect()
}

/// Judges a claim: it holds if it does in all combinations, is opposed if it is in all, and is undecided otherwise.
fn claim(results: &Results, criterion: &Preregistered) -> Claim {
    let of_questions = match criterion.id() {
        "D12a" => Some(more_robots(&results.questions)),
        "D12b" => Some(connectivity(&results.questions)),
        _ => None,
    };
    if let Some(finding) = of_questions {
        return criterion.judged(finding.verdict(), finding, criterion.remark().into());
    }
    let mut all = Finding::default();
    let mut scopes = [Vec::new(), Vec::new(), Vec::new()];
    let mut verdicts = Vec::new();
    for combination in &results.combinations {
        let judged = Judged { results, combination };
        let title = combination.title();
        let finding = judged.finding(criterion.id()).unwrap_or_else(|| Finding {
            parts: vec![Part::undecided("the study lacks runs that it needs, or has too few")],
            ..Finding::default()
        });
        verdicts.push((title.clone(), finding.verdict()));
        let scope = finding.registered.map_or(2, usize::from);
        scopes[scope].push(title.clone());
        all.effects
            .extend(criterion.beside_the_papers(finding.effects).map(|effect| Effect {
                name: format!("{title}: {}", effect.name),
                ..effect
            }));
        all.tests.extend(finding.tests.into_iter().map(|test| Test {
            name: format!("{title}: {}", test.name),
            ..test
        }));
    }
    let [fails, met, unknown] = scopes;
    if results.combinations.len() > 1 {
        let scope = Effect {
            name: format!("{MET_IN}, of {}", results.combinations.len()),
            value: met.len() as f64,
            interval: None,
            paper: None,
        };
        all.effects.insert(0, scope);
    }
    all.registered = match (met.is_empty(), fails.is_empty(), unknown.is_empty()) {
        (false, true, true) => Some(true),
        (true, false, true) => Some(false),
        _ => None,
    };
    let list = |words: &str, titles: &[String]| match titles {
        [] => String::new(),
        titles => format!("{words} at {}. ", titles.join("; ")),
    };
    let remark = format!(
        "{}{}{}{}",
        list("The registered criterion is met", &met),
        list("It fails", &fails),
        list("The study lacks runs that it needs", &unknown),
        criterion.remark()
    );
    criterion.judged(in_all(verdicts), all, remark.trim_end().into())
}

/// The verdict over all combinations, and what makes it in each.
fn in_all(verdicts: Vec<(String, Judgement)>) -> Judgement {
    let verdict = match &verdicts[..] {
        [(_, (first, _)), others @ ..] if others.iter().all(|(_, (verdict, _))| verdict == first) => *first,
        _ => Verdict::Undecided,
    };
    let is_one = verdicts.len() == 1 || verdict == Verdict::NotJudged;
    let verdicts = verdicts.into_iter().take(if is_one { 1 } else { usize::MAX });
    let reasons = verdicts.flat_map(|(title, (of_combination, reasons))| match of_combination {
        _ if is_one => reasons,
        Verdict::Holds if verdict != Verdict::Holds => vec![format!("{title}: holds")],
        _ => reasons
            .into_iter()
            .map(|reason| format!("{title}: {of_combination}: {reason}"))
            .collect(),
    });
    (verdict, reasons.collect())
}

/// Of robots at one density, whether simulators converge earlier with more robots.
fn more_robots(questions: &[Question]) -> Finding {
    let at_one_density = |robots: u32| {
        questions
            .iter()
            .find(|question| question.about == "density" && question.robots == robots)
    };
    let Some(asked) = SIZES.map(at_one_density).into_iter().collect::<Option<Vec<_>>>() else {
        return not_asked();
    };
    let mut finding = Finding::default();
    let minutes: Vec<Option<usize>> = asked
        .iter()
        .map(|question| convergence_interval(&question.runs))
        .collect();
    for (question, minute) in asked.iter().zip(&minutes) {
        if let Some(minute) = minute {
            finding.note(
                format!("converged from minute, {} robots", question.robots),
                *minute as f64,
            );
        }
        let shares: Vec<f64> = question
            .runs
            .iter()
            .map(|run| run.share(Light::OverNest, LATE))
            .collect();
        finding.mean(format!("late share of Over, {} robots", question.robots), &shares);
    }
    let is_earlier = minutes.is_sorted_by(|few, many| matches!((few, many), (Some(few), Some(many)) if many < few));
    let runs = asked.iter().map(|question| question.runs.len()).min().unwrap_or(0);
    let what = "simulators converge at one density, and earlier with more robots: 5, 10, 20 and 50";
    finding.registered = Some(is_earlier);
    finding.parts = vec![Part::fact(what, is_earlier).of_runs(runs)];
    finding
}

/// Whether encounters link few of the paper's robots.
fn connectivity(questions: &[Question]) -> Finding {
    let linked = |question: &Question| -> Vec<f64> {
        let robots = f64::from(question.robots);
        let each = question.runs.iter();
        each.map(|run| mean(run.robots(ALL).map(|own| f64::from(own.reached))) / robots)
            .collect()
    };
    let ranges = questions.iter().filter(|question| question.about == "range");
    let Some(papers) = ranges
        .clone()
        .find(|question| question.range.to_bits() == PAPERS_RANGE.to_bits())
    else {
        return not_asked();
    };
    let mut finding = Finding::default();
    for question in ranges {
        finding.mean(
            format!("fraction linked, range of {} mm", question.range),
            &linked(question),
        );
    }
    let linked = linked(papers);
    let what = format!("fraction of robots linked by an interval's encounters, range of {PAPERS_RANGE} mm");
    finding.registered = Some(mean(&linked) < LINKED);
    finding.parts = vec![Part::below(&what, &[(1.0, &linked)], LINKED)];
    finding
}

fn not_asked() -> Finding {
    Finding {
        missing: Some(NOT_ASKED),
        ..Finding::default()
    }
}

/// Two samples of runs to compare.
struct Pair {
    name: String,
    a: Vec<f64>,
    b: Vec<f64>,
    kind: Comparison,
}

/// How two samples are related.
#[derive(Clone, Copy, PartialEq)]
enum Comparison {
    /// Independent.
    Apart,
    /// Paired run by run.
    Paired,
    /// The second is a number that the first is compared with.
    Number,
}

fn pair(name: impl Into<String>, a: Vec<f64>, b: Vec<f64>) -> Pair {
    Pair {
        name: name.into(),
        a,
        b,
        kind: Comparison::Apart,
    }
}

impl Pair {
    fn kind(self, kind: Comparison) -> Self {
        Self { kind, ..self }
    }

    /// The interval of Cohen's d over runs; pairs stay together.
    fn interval_of_d(&self) -> Option<Interval> {
        let Self { a, b, kind, .. } = self;
        let d = |a: &[f64], b: &[f64]| cohens_d(a, b).unwrap_or(f64::NAN);
        match kind {
            Comparison::Apart => over_runs(&[a, b], |samples| d(&samples[0], &samples[1])),
            Comparison::Paired => {
                let numbers: Vec<f64> = (0_u32..).zip(a).map(|(number, _)| f64::from(number)).collect();
                over_runs(&[&numbers], |samples| {
                    d(&resample(a, &samples[0]), &resample(b, &samples[0]))
                })
            }
            Comparison::Number => None,
        }
    }

    /// Runs of the smaller sample.
    fn runs(&self) -> usize {
        match self.kind {
            Comparison::Number => self.a.len(),
            _ => self.a.len().min(self.b.len()),
        }
    }

    /// t, its degrees of freedom and p. Samples that don't vary have p = 0 or 1. `None` if the needed runs are missing.
    fn test(&self) -> Option<(f64, f64, f64)> {
        let least = if self.kind == Comparison::Number { 1 } else { 2 };
        let finite = self.a.iter().chain(&self.b).all(|value| value.is_finite());
        if self.a.len() < 2 || self.b.len() < least || !finite {
            return None;
        }
        let test = match self.kind {
            Comparison::Apart => student_t(&self.a, &self.b),
            Comparison::Paired => paired_t(&self.a, &self.b),
            Comparison::Number => one_sample_t(&self.a, self.b[0]),
        };
        let df = match self.kind {
            Comparison::Apart => self.a.len() + self.b.len() - 2,
            Comparison::Paired | Comparison::Number => self.a.len() - 1,
        };
        let certain = if mean(&self.a) == mean(&self.b) { 1.0 } else { 0.0 };
        Some(test.map_or((0.0, df as f64, certain), |test| (test.t, test.df, test.p.value)))
    }
}

/// The second of two samples, drawn along with the first.
fn resample(sample: &[f64], numbers: &[f64]) -> Vec<f64> {
    numbers.iter().map(|&number| sample[number as usize]).collect()
}

/// Whether a sample is greater than another by Student's t test, uncorrected.
fn is_greater(a: &[f64], b: &[f64], level: f64) -> bool {
    student_t(a, b).is_ok_and(|test| test.t > 0.0 && test.p.value < level)
}

/// Outcome of a comparison: the sign of the difference, and p after Holm's correction.
#[derive(Clone)]
struct Compared {
    name: String,
    /// Runs of the smaller sample.
    runs: usize,
    difference: f64,
    p: f64,
}

impl Compared {
    fn is_above(&self, level: f64) -> bool {
        self.difference > 0.0 && self.p < level
    }

    fn is_below(&self, level: f64) -> bool {
        self.difference < 0.0 && self.p < level
    }

    /// A part of a criterion with what decides it.
    fn part(&self, verdict: Verdict, more: &str) -> Part {
        let (difference, p) = (significant(self.difference, 3), significant(self.p, 2));
        let reason = format!(
            "{}: difference {difference}, p = {p} after Holm's correction{more}",
            self.name
        );
        Part { verdict, reason }.of_runs(self.runs)
    }

    /// Whether the first is above the second at a level. Opposed if it is below by the study's level.
    fn above(&self, level: f64) -> Part {
        self.part(
            match (self.is_above(level), self.is_below(LEVEL)) {
                (true, _) => Verdict::Holds,
                (false, true) => Verdict::Opposed,
                (false, false) => Verdict::Undecided,
            },
            "",
        )
    }

    fn below(&self) -> Part {
        let mirrored = Self {
            difference: -self.difference,
            ..self.clone()
        };
        self.part(mirrored.above(LEVEL).verdict, "")
    }

    /// Whether the first is not above the second. That it was not found to be above does not show it.
    fn not_above(&self) -> Part {
        self.part(self.below().verdict, "")
    }

    fn differs(&self) -> Part {
        let verdict = if self.p < LEVEL {
            Verdict::Holds
        } else {
            Verdict::Undecided
        };
        self.part(verdict, "")
    }

    /// Whether both are the same, which no test shows.
    fn same(&self) -> Part {
        if self.p < LEVEL {
            return self.part(Verdict::Opposed, "");
        }
        self.part(
            Verdict::Undecided,
            ": no difference was found, and no margin was registered within which there is none",
        )
    }
}

impl Finding {
    /// Tests several pairs and corrects over them; `None` if runs of any are missing.
    fn compare<const N: usize>(&mut self, pairs: &[Pair; N]) -> Option<[Compared; N]> {
        let mut tested = [(0.0, 0.0, 1.0); N];
        for (place, pair) in tested.iter_mut().zip(pairs) {
            *place = pair.test()?;
        }
        let corrected = holm(&tested.map(|(.., p)| p)).ok()?;
        for ((pair, (t, df, p)), &p_holm) in pairs.iter().zip(tested).zip(&corrected) {
            self.tests.push(Test {
                name: pair.name.clone(),
                statistic: "t".into(),
                value: t,
                degrees_of_freedom: vec![df],
                p,
                p_holm: Some(p_holm),
            });
            if let Ok(d) = cohens_d(&pair.a, &pair.b) {
                self.estimate(format!("d, {}", pair.name), d, pair.interval_of_d());
            }
        }
        Some(std::array::from_fn(|index| Compared {
            name: pairs[index].name.clone(),
            runs: pairs[index].runs(),
            difference: mean(&pairs[index].a) - mean(&pairs[index].b),
            p: corrected[index],
        }))
    }

    #[expect(clippy::unnecessary_wraps, reason = "the last step of each claim that has its runs")]
    fn judged(mut self, registered: bool, parts: impl IntoIterator<Item = Part>) -> Option<Self> {
        self.registered = Some(registered);
        self.parts = parts.into_iter().collect();
        Some(self)
    }
}

/// A gene and its name.
type NamedGene = (&'static str, super::measures::Gene);

const CONTROLLER: [NamedGene; 2] = [("G0", G0), ("G1", G1)];
const SIMULATOR: NamedGene = ("S0", S0);
/// The middle bin.
const MIDDLE: [f64; 2] = [LOW, HIGH];

/// One combination.
struct Judged<'a> {
    results: &'a Results,
    combination: &'a Combination,
}

impl Judged<'_> {
    /// Evidence for a claim; `None` if the runs it needs are missing.
    fn finding(&self, claim: &str) -> Option<Finding> {
        match claim {
            "D1" => self.against_random(),
            "D2" => self.doubles(),
            "D3" => self.order(),
            "D4" => self.no_light(),
            "D5" => self.over(),
            "D6" => self.opposite(),
            "D7" => self.moved_away(),
            "D8" => self.moved_over(),
            "D9" => self.anomaly(),
            "D10" => self.alone(),
            "D11" => Some(self.cost()),
            "D12" => self.weak_cue(),
            "D13" => self.informs(),
            "D14" => self.exploration(),
            "D15" => self.stability(),
            "D16" => self.dissociation(),
            "D17" => self.precedence(),
            id => unreachable!("no claim is called {id}"),
        }
    }

    /// One figure for each run of a case and kind.
    fn each(&self, case: Case, kind: Kind, figure: impl Fn(&Run) -> f64) -> Vec<f64> {
        self.combination.of(case, kind).map(figure).collect()
    }

    fn rates(&self, case: Case, kind: Kind) -> Vec<f64> {
        self.each(case, kind, |run| run.rate(ALL))
    }

    fn shares(&self, case: Case, kind: Kind, light: Light, intervals: Range<usize>) -> Vec<f64> {
        self.each(case, kind, |run| run.share(light, intervals.clone()))
    }

    /// Pair of foraging rates.
    fn by_rate(&self, (case, kind): (Case, Kind), (other, its_kind): (Case, Kind)) -> Pair {
        let words = |case: Case, kind: Kind| match kind {
            Evolved => case.title().to_owned(),
            _ => format!("{} ({})", case.title(), kind.title()),
        };
        pair(
            format!("rate, {} and {}", words(case, kind), words(other, its_kind)),
            self.rates(case, kind),
            self.rates(other, its_kind),
        )
    }

    /// Pair of foraging rates of one case, evolved and under the null.
    fn by_null(&self, case: Case) -> Pair {
        self.by_rate((case, Evolved), (case, Null))
    }

    /// Pair of a bin's fractions, evolved and under the null.
    fn share_by_null(&self, case: Case, light: Light, intervals: Range<usize>, when: &str) -> Pair {
        pair(
            format!(
                "share of {light:?}, {when}, {}, evolved and fitness shuffled",
                case.title()
            ),
            self.shares(case, Evolved, light, intervals.clone()),
            self.shares(case, Null, light, intervals),
        )
    }

    /// A gene's mean and standard deviation, averaged over runs.
    fn gene(&self, case: Case, gene: super::measures::Gene, intervals: Range<usize>) -> (f64, f64) {
        (
            mean(self.each(case, Evolved, |run| run.mean(gene, intervals.clone()))),
            mean(self.each(case, Evolved, |run| run.deviation(gene, intervals.clone()))),
        )
    }

    /// Whether a gene's mean, over a case's runs, is in a range in some intervals.
    fn gene_within(&self, case: Case, (name, gene): NamedGene, intervals: Range<usize>, range: [f64; 2]) -> Part {
        let runs = self.each(case, Evolved, |run| run.mean(gene, intervals.clone()));
        let (from, to) = (intervals.start, intervals.end);
        let what = format!("mean {name}, intervals {from} to {to}, {}", case.title());
        Part::within(&what, &[(1.0, &runs)], range)
    }

    /// A gene's standard deviation in the late intervals of each run.
    fn late_deviations(&self, case: Case, gene: super::measures::Gene) -> Vec<f64> {
        self.each(case, Evolved, |run| run.deviation(gene, LATE))
    }

    /// Whether it is wide in the mean over runs.
    fn is_wide(&self, case: Case, (name, gene): NamedGene) -> Part {
        let what = format!("late s.d. of {name}, {}", case.title());
        Part::above(&what, &[(1.0, &self.late_deviations(case, gene))], WIDE)
    }

    /// Adds late G0 and G1 to the finding and returns them.
    fn late_controllers(&self, case: Case, finding: &mut Finding) -> [(f64, f64); 2] {
        CONTROLLER.map(|(name, gene)| {
            let (middle, deviation) = self.gene(case, gene, LATE);
            finding.note(format!("late mean {name}, {}", case.title()), middle);
            finding.note(format!("late s.d. of {name}, {}", case.title()), deviation);
            (middle, deviation)
        })
    }

    fn against_random(&self) -> Option<Finding> {
        let mut finding = Finding::default();
        let cases = [Over, Opposite, OverThenOpposite, OppositeThenOver];
        let [over, opposite, away, towards] = cases.map(|case| self.by_rate((case, Evolved), (Random, Evolved)));
        let [over_null, opposite_null, away_null, towards_null] = cases.map(|case| self.by_null(case));
        let all = finding.compare(&[
            over,
            opposite,
            away,
            towards,
            over_null,
            opposite_null,
            away_null,
            towards_null,
        ])?;
        let (random, null) = all.split_at(cases.len());
        let (none, control) = (self.rates(NoLight, Evolved), self.rates(Random, Evolved));
        let interval = ratio_interval(&none, &control, 0.9).ok()?;
        finding.note("No Light over Random Movement", mean(&none) / mean(&control));
        finding.note("its 90 % interval from", interval.low);
        finding.note("to", interval.high);
        // The paper's own test.
        let minutes = |case| minutes(self.combination.of(case, Evolved));
        for case in [NoLight, Over, Opposite, OverThenOpposite, OppositeThenOver] {
            if let Ok(test) = student_t(&minutes(case), &minutes(Random)) {
                let name = format!("the paper's, minute means, {} and Random Movement", case.title());
                finding.tests.push(Test::t(name, test));
            }
        }
        for case in cases {
            let verdict = format!("p < 0.005, {}", case.title());
            self.power(&mut finding, [case, Random], &verdict, |[rates, control]| {
                is_greater(rates, control, PAPERS_LEVEL)
            });
        }
        self.power(
            &mut finding,
            [NoLight, Random],
            "p > 0.5, No Light",
            |[rates, control]| student_t(rates, control).is_ok_and(|test| test.p.value > 0.5),
        );
        let differs = random.iter().all(|compared| compared.is_above(PAPERS_LEVEL));
        let informed = null.iter().all(|compared| compared.is_above(LEVEL));
        let equivalent = interval.low >= 0.9 && interval.high <= 1.1;
        let within = Part::of_interval("No Light over Random Movement, 90 %", interval, [0.9, 1.1], none.len());
        let parts = random.iter().map(|compared| compared.above(PAPERS_LEVEL));
        let parts: Vec<Part> = parts.chain(null.iter().map(|compared| compared.above(LEVEL))).collect();
        finding.judged(differs && informed && equivalent, parts.into_iter().chain([within]))
    }

    /// With many runs, adds the fraction of sets of 5 or 10 of them that would reach the verdict on the rates of some
    /// cases.
    fn power<const N: usize>(
        &self,
        finding: &mut Finding,
        cases: [Case; N],
        verdict: &str,
        gives: impl Fn(&[Vec<f64>; N]) -> bool,
    ) {
        let all = cases.map(|case| self.rates(case, Evolved));
        if all.iter().any(|rates| rates.len() < MANY) {
            return;
        }
        let mut random = Pcg64::new(2014, 1);
        for size in [5, 10] {
            let mut drawn = || {
                all.each_ref().map(|rates| {
                    let chosen = subset(rates.len(), size, &mut random);
                    chosen.iter().map(|&index| rates[index]).collect::<Vec<f64>>()
                })
            };
            let found = (0..SETS).filter(|_| gives(&drawn())).count();
            finding.note(
                format!("share of sets of {size} runs with {verdict}"),
                found as f64 / SETS as f64,
            );
        }
    }

    fn doubles(&self) -> Option<Finding> {
        let mut finding = Finding::default();
        let [null] = finding.compare(&[self.by_null(Over)])?;
        let ratios = [("random", Random), ("opposite", Opposite)].map(|(name, other)| {
            let [over, other] = [Over, other].map(|case| self.rates(case, Evolved));
            let ratio = mean(&over) / mean(&other);
            let interval = ratio_interval(&over, &other, 0.95).ok();
            let what = format!("over the nest to {name}");
            finding.estimate(what.clone(), ratio, interval);
            let part = match interval {
                Some(interval) => Part::of_interval(&what, interval, [1.5, 2.5], over.len()),
                None => Part::undecided(format!("{what}: has no interval")),
            };
            (ratio, part)
        });
        let [(to_random, one), (to_opposite, other)] = ratios;
        let doubles = |ratio: f64| (1.5..=2.5).contains(&ratio);
        let verdict = "a ratio of 1.5 to 2.5 to either";
        self.power(
            &mut finding,
            [Over, Random, Opposite],
            verdict,
            |[over, random, opposite]| doubles(mean(over) / mean(random)) || doubles(mean(over) / mean(opposite)),
        );
        let is_met = (doubles(to_random) || doubles(to_opposite)) && null.is_above(LEVEL);
        finding.judged(is_met, [one.or(other), null.above(LEVEL)])
    }

    fn order(&self) -> Option<Finding> {
        let mut finding = Finding::default();
        let all = finding.compare(&[
            self.by_rate((Over, Evolved), (Opposite, Evolved)),
            self.by_rate((Opposite, Evolved), (Random, Evolved)),
            self.by_null(Opposite),
        ])?;
        let verdict = "over above opposite above random, p < 0.05";
        self.power(
            &mut finding,
            [Over, Opposite, Random],
            verdict,
            |[over, opposite, random]| is_greater(over, opposite, LEVEL) && is_greater(opposite, random, LEVEL),
        );
        for case in Case::ALL {
            finding.mean(format!("food per minute, {}", case.title()), &self.rates(case, Evolved));
        }
        let is_met = all.iter().all(|compared| compared.is_above(LEVEL));
        finding.judged(is_met, all.iter().map(|compared| compared.above(LEVEL)))
    }

    fn no_light(&self) -> Option<Finding> {
        let mut finding = Finding::default();
        let [share] = finding.compare(&[self.share_by_null(NoLight, Light::Nowhere, SETTLED, "minutes 10 to 50")])?;
        let shares = |kind| self.shares(NoLight, kind, Light::Nowhere, SETTLED);
        finding.mean("share of No Light, minutes 10 to 50", &shares(Evolved));
        finding.mean("the same, fitness shuffled", &shares(Null));
        let mut stays = true;
        let mut parts = vec![share.above(LEVEL)];
        for first in (0..50).step_by(10) {
            parts.push(self.gene_within(NoLight, SIMULATOR, first..first + 10, MIDDLE));
            let (middle, _) = self.gene(NoLight, S0, first..first + 10);
            finding.note(format!("mean S0, minutes {first} to {}", first + 10), middle);
            stays &= (LOW..HIGH).contains(&middle);
        }
        let wide = self
            .late_controllers(NoLight, &mut finding)
            .iter()
            .all(|(middle, deviation)| (LOW..HIGH).contains(middle) && *deviation >= WIDE);
        for gene in CONTROLLER {
            parts.extend([
                self.gene_within(NoLight, gene, LATE, MIDDLE),
                self.is_wide(NoLight, gene),
            ]);
        }
        finding.judged(share.is_above(LEVEL) && stays && wide, parts)
    }

    fn over(&self) -> Option<Finding> {
        let mut finding = Finding::default();
        let [share] = finding.compare(&[self.share_by_null(Over, Light::OverNest, LATE, "late")])?;
        let late = self.each(Over, Evolved, |run| run.mean(S0, LATE));
        finding.mean("late mean S0", &late);
        let shares = |kind| self.shares(Over, kind, Light::OverNest, LATE);
        finding.mean("late share of Over", &shares(Evolved));
        finding.mean("the same, fitness shuffled", &shares(Null));
        let [with, without] = self.late_controllers(Over, &mut finding);
        let [wide_with, wide_without] = self.late_controllers(NoLight, &mut finding);
        let narrow = with.1 < wide_with.1 && without.1 < wide_without.1;
        let narrower = CONTROLLER.map(|(name, gene)| {
            let [over, none] = [Over, NoLight].map(|case| self.late_deviations(case, gene));
            let what = format!("late s.d. of {name}, Light Over Nest minus No Light");
            Part::below(&what, &[(1.0, &over), (-1.0, &none)], 0.0)
        });
        let ends = [
            self.gene_within(Over, CONTROLLER[0], LATE, [HIGH, f64::INFINITY]),
            self.gene_within(Over, CONTROLLER[1], LATE, [f64::NEG_INFINITY, LOW]),
            share.above(LEVEL),
        ];
        let is_met = with.0 > HIGH && without.0 < LOW && narrow && share.is_above(LEVEL);
        finding.judged(is_met, ends.into_iter().chain(narrower))
    }

    fn opposite(&self) -> Option<Finding> {
        let mut finding = Finding::default();
        let [share] = finding.compare(&[self.share_by_null(Opposite, Light::OppositeNest, LATE, "late")])?;
        let late = self.each(Opposite, Evolved, |run| run.mean(S0, LATE));
        let simulator = finding.mean("late mean S0", &late);
        let shares = |kind| self.shares(Opposite, kind, Light::OppositeNest, LATE);
        finding.mean("late share of Opposite", &shares(Evolved));
        finding.mean("the same, fitness shuffled", &shares(Null));
        let wide = self
            .late_controllers(Opposite, &mut finding)
            .iter()
            .all(|(_, deviation)| *deviation >= WIDE);
        let parts = [share.not_above(), self.gene_within(Opposite, SIMULATOR, LATE, MIDDLE)];
        let is_met = !share.is_above(LEVEL) && (LOW..HIGH).contains(&simulator) && wide;
        let spreads = CONTROLLER.map(|gene| self.is_wide(Opposite, gene));
        finding.judged(is_met, parts.into_iter().chain(spreads))
    }

    fn moved_away(&self) -> Option<Finding> {
        let mut finding = Finding::default();
        let s0 = |intervals: Range<usize>| self.each(OverThenOpposite, Evolved, |run| run.mean(S0, intervals.clone()));
        let [before, moved] = finding.compare(&[
            self.share_by_null(OverThenOpposite, Light::OverNest, BEFORE_MOVE, "before the move"),
            pair("late S0 and S0 before the move", s0(LATE), s0(BEFORE_MOVE)).kind(Comparison::Paired),
        ])?;
        let bin = self.results.light_moves_minute as usize * 60 / BIN;
        let rates = |bins: Range<usize>| {
            self.each(OverThenOpposite, Evolved, |run| {
                mean(run.rates(BIN).get(bins.clone()).unwrap_or(&[]))
            })
        };
        let (after, earlier) = (rates(bin..bin + 2), rates(bin - 1..bin));
        let fall = 1.0 - mean(&after) / mean(&earlier);
        finding.note("fall of the rate", fall);
        let beyond: Vec<f64> = after
            .iter()
            .zip(&earlier)
            .map(|(after, before)| 0.75 * before - after)
            .collect();
        let shares = self.shares(OverThenOpposite, Evolved, Light::OppositeNest, LATE);
        let converged = finding.mean("late share of Opposite", &shares);
        let is_met = before.is_above(LEVEL) && fall > 0.25 && moved.is_below(LEVEL) && converged <= 0.5;
        let parts = [
            before.above(LEVEL),
            Part::above(
                "75 % of the rate before the move minus that after it",
                &[(1.0, &beyond)],
                0.0,
            ),
            moved.below(),
            Part::below("late share of Opposite", &[(1.0, &shares)], 0.5),
        ];
        finding.judged(is_met, parts)
    }

    fn moved_over(&self) -> Option<Finding> {
        let mut finding = Finding::default();
        let half = |case| self.each(case, Evolved, |run| run.rate(SECOND_HALF));
        let share = |intervals| self.shares(OppositeThenOver, Evolved, Light::OverNest, intervals);
        let [rate, share] = finding.compare(&[
            pair(
                "rate of the second half, case 5 and Light Over Nest",
                half(OppositeThenOver),
                half(Over),
            ),
            pair(
                "share of Over, late and before the move",
                share(LATE),
                share(BEFORE_MOVE),
            )
            .kind(Comparison::Paired),
        ])?;
        let before = self.each(OppositeThenOver, Evolved, |run| run.mean(S0, BEFORE_MOVE));
        finding.mean("mean S0 before the move", &before);
        finding.note(
            "rate of its second half to Light Over Nest's",
            mean(half(OppositeThenOver)) / mean(half(Over)),
        );
        finding.judged(
            rate.is_below(LEVEL) && share.is_above(LEVEL),
            [rate.below(), share.above(LEVEL)],
        )
    }

    fn anomaly(&self) -> Option<Finding> {
        let mut finding = Finding::default();
        let first = |case| self.each(case, Evolved, |run| run.mean(S0, FIRST_HALF));
        let [compared] = finding.compare(&[pair(
            "mean S0 of the first 25 minutes, cases 3 and 5",
            first(Opposite),
            first(OppositeThenOver),
        )])?;
        finding.note("difference of mean S0", compared.difference);
        finding.judged(compared.p < LEVEL, [compared.differs()])
    }

    fn alone(&self) -> Option<Finding> {
        let mut finding = Finding::default();
        let [compared] = finding.compare(&[pair(
            "late share of Over, one robot, light over the nest and no light",
            self.shares(Over, Alone, Light::OverNest, LATE),
            self.shares(NoLight, Alone, Light::OverNest, LATE),
        )])?;
        finding.judged(compared.p >= LEVEL, [compared.same()])
    }

    fn cost(&self) -> Finding {
        Finding {
            registered: Some(self.results.generation_within_34_s),
            not_judged: Some(HARDWARE),
            ..Finding::default()
        }
    }

    fn weak_cue(&self) -> Option<Finding> {
        let mut finding = Finding::default();
        let control = self.rates(Random, Evolved);
        let rates = [Over, Opposite].map(|case| self.rates(case, SimulatorRight));
        let [over, opposite] = rates.each_ref().map(|rates| mean(rates) - mean(&control));
        if over.is_nan() || opposite.is_nan() {
            return None;
        }
        finding.note("gain in food per minute, over", over);
        finding.note("gain in food per minute, opposite", opposite);
        let [gain, weak_gain] = [("gain, over", &rates[0]), ("gain, opposite", &rates[1])]
            .map(|(what, rates)| Part::above(what, &[(1.0, rates), (-1.0, &control)], 0.0));
        let weak = [(1.0, &rates[1][..]), (-0.5, &rates[0]), (-0.5, &control)];
        let weak = Part::below("gain, opposite minus half of over", &weak, 0.0);
        // A loss is no weak help, though the registered criterion takes it for one.
        finding.judged(over > 0.0 && opposite < 0.5 * over, [gain, weak_gain, weak])
    }

    /// Area under the curve, for each run, of fitness as a predictor of whether a simulator has the light where it is.
    /// `of` gives the simulator that a robot's fitness belongs to, by run, interval and robot.
    fn areas(&self, case: Case, of: impl Fn(&Run, usize, usize) -> f32) -> Vec<f64> {
        let moves = self.results.light_moves_minute as usize;
        let area = |run: &Run| run.area(moves, |interval, robot| of(run, interval, robot));
        self.combination.of(case, SimulatorRandom).filter_map(area).collect()
    }

    fn informs(&self) -> Option<Finding> {
        let mut finding = Finding::default();
        let chosen = |case: Case| {
            let areas = self.areas(case, |run, interval, robot| run.intervals[interval][robot].chosen_under);
            pair(format!("area under the curve, {}", case.title()), areas, vec![0.5]).kind(Comparison::Number)
        };
        let all = finding.compare(&[Over, Opposite].map(chosen))?;
        let holds = all.iter().all(|compared| compared.is_above(LEVEL));
        for case in [Over, Opposite] {
            finding.mean(format!("area, {}", case.title()), &chosen(case).a);
            for lag in 0..=2 {
                let areas = self.areas(case, |run, interval, robot| run.intervals[interval - lag][robot].s0);
                finding.mean(
                    format!("area by S0 of {lag} intervals before, {}", case.title()),
                    &areas,
                );
            }
            let moves = self.results.light_moves_minute as usize;
            let gap = |right: bool| {
                let gaps: Vec<f64> = self
                    .combination
                    .of(case, SimulatorRandom)
                    .flat_map(|run| run.intervals.iter().enumerate().map(move |interval| (run, interval)))
                    .flat_map(|(run, (interval, robots))| {
                        let light = run.case.light_in(interval, moves);
                        robots
                            .iter()
                            .filter(move |robot| (Light::of_gene(robot.chosen_under) == light) == right)
                            .filter_map(|robot| Some(f64::from(robot.simulated?) - f64::from(robot.real)))
                    })
                    .collect();
                mean(&gaps)
            };
            finding.note(format!("F_sim - F_R, simulator right, {}", case.title()), gap(true));
            finding.note(format!("F_sim - F_R, simulator wrong, {}", case.title()), gap(false));
        }
        finding.judged(holds, all.iter().map(|compared| compared.above(LEVEL)))
    }

    fn exploration(&self) -> Option<Finding> {
        let mut finding = Finding::default();
        let [null, by_genes] = finding.compare(&[
            self.by_rate((Opposite, Null), (Random, Evolved)),
            self.by_null(Opposite),
        ])?;
        finding.judged(
            null.is_above(LEVEL) && !by_genes.is_above(LEVEL),
            [null.above(LEVEL), by_genes.not_above()],
        )
    }

    fn stability(&self) -> Option<Finding> {
        let mut finding = Finding::default();
        let spread = |case| self.each(case, Evolved, |run| run.deviation(S0, SECOND_HALF));
        let [share, deviation] = finding.compare(&[
            pair(
                "share of the right bin, second half, cases 2 and 4",
                self.shares(Over, Evolved, Light::OverNest, SECOND_HALF),
                self.shares(OverThenOpposite, Evolved, Light::OppositeNest, SECOND_HALF),
            ),
            pair(
                "s.d. of S0, second half, cases 4 and 2",
                spread(OverThenOpposite),
                spread(Over),
            ),
        ])?;
        let is_met = share.is_above(LEVEL) && deviation.is_above(LEVEL);
        finding.judged(is_met, [share.above(LEVEL), deviation.above(LEVEL)])
    }

    fn dissociation(&self) -> Option<Finding> {
        let mut finding = Finding::default();
        let spread = |kind| self.each(NoLight, kind, |run| run.deviation(S0, LATE));
        let [compared] = finding.compare(&[pair(
            "late s.d. of S0, No Light, fitness shuffled and evolved",
            spread(Null),
            spread(Evolved),
        )])?;
        finding.judged(compared.is_above(LEVEL), [compared.above(LEVEL)])
    }

    fn precedence(&self) -> Option<Finding> {
        let mut finding = Finding::default();
        let all = finding
            .compare(&[Over, Opposite].map(|case| self.by_rate((case, SimulatorRight), (case, SimulatorRandom))))?;
        let is_met = all.iter().all(|compared| compared.is_above(LEVEL));
        finding.judged(is_met, all.iter().map(|compared| compared.above(LEVEL)))
    }
}

#[cfg(test)]
mod tests;
