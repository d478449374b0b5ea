//! Judges the claims of the paper: whether each criterion is met by the estimates alone, and the verdict by the 95 % intervals of its parts.
//! Runs are the unit of all intervals. Ratios enter as differences, such as half of one mean minus another, so that no interval divides by a
//! figure near zero. The first edition has the criteria of `studies/preregistration-1995.md`. The second has for C3 to C8 the contrasts of
//! `studies/preregistration-1995-second.md`, and corrected criteria for others.

use Condition::{Conservative, None as Without, Sensor};
use oneiro::tables::{GREATEST_READING, SENSORS, SensorTable, SensorTables};
use oneiro_base::console::counted;
use oneiro_report::numbers::fixed;
use oneiro_statistics::{
    Interval, anova, cohens_d, holm, mean, mean_interval, median, median_interval, paired_t, pseudo_values, quantile,
    random_intercept, student_t, subset, variance,
};
use rand_pcg::Pcg64;

use super::measures::corner_turns;
use super::planned::Planned;
use super::results::{Condition, Controls, Discrepancy, Family, Level, MeasuredEpisode, Results, Run};
use super::second::{self, Shown};
use crate::MIGLINO1995_CLAIMS;
use crate::claims::{Claim, Effect, Finding, Preregistered, Table, Test, over_runs};
use crate::file::Edition;
use crate::verdict::{self, Part, Verdict};

/// Part of the name of each test over runs; Holm's correction covers these tests.
const RUNS: &str = ": runs, ";

/// Runs of a condition in the paper, giving its F 1 and 998 degrees of freedom.
const PAPERS_RUNS: usize = 5;
/// Number of sets of five drawn if there are more runs.
const SETS: usize = 2000;
/// Explanation of these sets for the reader.
const OF_SETS: &str = "Sets of five runs, drawn out of all, show what a study of the paper's size would find; of all runs pooled any \
     difference is significant";
/// Explanation of paths on a wire for the reader.
const CONNECTED_PATHS: &str = "A connected robot's champion runs once, from one start, where a person has put it; its \
     path comes from its odometers or the tracker";
/// The paper's significance level.
const LEVEL: f64 = 0.01;
/// Values that an interval of a median needs.
const OF_A_MEDIAN: usize = 6;

/// Gap from a wall at which sensors' angles are compared, mm.
const ANGLES_AT: f64 = 15.0;
/// A sensor's range that is so many times another's is much larger.
const MUCH: f64 = 1.4;
/// The most times that the range of one sensor of the recorded Khepera is another's, by distance and by angle. A surrogate's are drawn
/// between the same ends (`studies/preregistration-1995.md`).
const MOST: [f64; 2] = [29.5 / 20.2, 92.0 / 52.0];
/// The fifth and the sixth sensor of the paper.
const FIFTH: usize = 4;
const SIXTH: usize = 5;
/// Why C12 is no question for a study.
const HARDWARE: &str =
    "true by hardware: a computer of today simulates a life in far less than 2 s, and a real one takes its 50 s";

/// The values by which a study's results are judged.
pub(crate) struct Judging<'a> {
    pub(crate) results: &'a Results,
    /// The sampled sensors.
    pub(crate) sensors: &'a SensorTables,
    /// Whether they are those of a real robot, and not drawn.
    pub(crate) is_real_robot: bool,
    /// Corners of the arena.
    pub(crate) corners: Vec<[f32; 2]>,
    pub(crate) edition: Edition,
    /// The chances of five runs, if they are known for such a study.
    pub(crate) planned: Option<&'a Planned>,
}

/// Judges all claims of an edition.
pub(crate) fn judge(judging: &Judging<'_>) -> Vec<Claim> {
    let table = Table::in_edition(MIGLINO1995_CLAIMS, judging.edition);
    let mut claims: Vec<Claim> = table.claims.iter().map(|criterion| judging.claim(criterion)).collect();
    correct(&mut claims);
    claims
}

impl Judging<'_> {
    /// Judges one claim.
    fn claim(&self, criterion: &Preregistered) -> Claim {
        let judged = Judged {
            results: self.results,
            sensors: self.sensors,
            criterion,
            judging: self,
        };
        let finding = judged.finding();
        let missing = finding.missing.unwrap_or_default();
        let remarks = [criterion.remark(), &finding.remark, missing];
        let remarks: Vec<&str> = remarks.into_iter().filter(|remark| !remark.is_empty()).collect();
        let remark = remarks.join(". ");
        Claim {
            power: self.planned.and_then(|planned| planned.claim(criterion.id())),
            ..criterion.judged(finding.verdict(), finding, remark)
        }
    }
}

/// Applies Holm's correction to all tests over runs.
fn correct(claims: &mut [Claim]) {
    let tests = || claims.iter().flat_map(|claim| &claim.tests);
    let ps: Vec<f64> = tests()
        .filter(|test| test.name.contains(RUNS))
        .map(|test| test.p)
        .collect();
    let Ok(corrected) = holm(&ps) else { return };
    let mut corrected = corrected.into_iter();
    for test in claims.iter_mut().flat_map(|claim| &mut claim.tests) {
        if test.name.contains(RUNS) {
            test.p_holm = corrected.next();
        }
    }
}

fn as_f64(values: &[f32]) -> impl Iterator<Item = f64> + '_ {
    values.iter().map(|&value| f64::from(value))
}

fn mean_of(values: &[f32]) -> f64 {
    mean(as_f64(values))
}

/// Fitness of all individuals of some runs.
fn pooled_fitness(runs: &[&Run], fitness_of: EpisodeFitness) -> Vec<f64> {
    runs.iter().flat_map(|run| as_f64(fitness_of(run))).collect()
}

/// Whether the sizes of d (no noise, sensor noise, conservative noise) are in C3's order.
fn in_order([none, sensor, conservative]: [f64; 3]) -> bool {
    sensor > none && none > conservative
}

/// C3's criterion.
fn in_order_and_small(sizes: [f64; 3]) -> bool {
    in_order(sizes) && sizes[2] < 0.2
}

/// Selects one of a run's controls.
type Control = fn(&Controls) -> f64;

/// Selects one of a champion's sums of distances.
type Sums = fn(&Run) -> &Vec<f64>;

/// Selects the fitness of a run's episodes.
type EpisodeFitness = fn(&Run) -> &[f32];

const SIMULATED: EpisodeFitness = |run| &run.transferred.simulated;
const QUIET: EpisodeFitness = |run| &run.transferred.quiet;
const REAL: EpisodeFitness = |run| &run.transferred.real;
const LAST: EpisodeFitness = |run| &run.last;

/// Selects a figure of a generation.
type Figure = fn(&Level) -> f64;

const PEAK: Figure = |level| level.peak;
const AVERAGE: Figure = |level| level.average;

const STARTS: Sums = |run| &run.champion.discrepancy.starts;

/// A claim that is judged.
struct Judged<'a> {
    results: &'a Results,
    sensors: &'a SensorTables,
    criterion: &'a Preregistered,
    judging: &'a Judging<'a>,
}

impl Judged<'_> {
    fn finding(&self) -> Finding {
        match self.judging.edition {
            Edition::First => self.finding_of_first(),
            Edition::Second => {
                let mut finding = match self.criterion.id() {
                    "C1" => self.ranges_differ(),
                    "C9" => self.behaviour_in_corners(),
                    "C10" => self.above_the_average(),
                    "C12" => self.hardware(),
                    "C13" => Finding::default(),
                    _ => self.finding_of_first(),
                };
                self.by_contrasts(&mut finding);
                finding
            }
        }
    }

    /// Judges a claim by the second edition's contrasts instead, if it has some.
    fn by_contrasts(&self, finding: &mut Finding) {
        let shown = second::of_one_robot(self.criterion.id(), &second::trios(&self.results.runs));
        if shown.is_empty() {
            return;
        }
        finding.registered = Some(shown.iter().all(|shown| shown.is_met));
        let mut of_contrasts = Finding::default();
        for Shown { name, values, .. } in &shown {
            of_contrasts.mean(format!("{name}, mean over runs"), values);
            if let Some(measured) = self.judging.planned.and_then(|planned| planned.contrast(name)) {
                of_contrasts.estimate(
                    format!("{name}, 30 robots"),
                    measured.estimate,
                    Some(measured.interval()),
                );
                of_contrasts.note(
                    format!("{name}, chance that five runs of one robot show this outcome"),
                    measured.chance,
                );
            }
        }
        finding.effects.splice(0..0, of_contrasts.effects);
        finding.parts = shown.into_iter().map(|shown| shown.part).collect();
    }

    fn finding_of_first(&self) -> Finding {
        match self.criterion.id() {
            "C1" => self.sensors_differ(),
            "C2" => self.quick_rise(),
            "C3" => self.transfer_gap(),
            "C4" => self.peak_and_average(),
            "C5" => self.conservative(),
            "C6" => self.evolving_on(),
            "C7" => self.recovery(),
            "C8" => self.paths(),
            "C9" => self.behaviour(),
            "C10" => self.deceptive_optimum(),
            "C11" => self.parameters(),
            "C12" => self.cost(),
            id => unreachable!("no claim is called {id}"),
        }
    }

    /// `missing`, if reality is a connected robot.
    fn if_connected(&self, missing: &'static str) -> Option<&'static str> {
        self.results.is_wired.then_some(missing)
    }

    fn runs(&self, condition: Condition) -> impl Iterator<Item = &Run> + Clone {
        self.results.runs.iter().filter(move |run| run.condition == condition)
    }

    /// One figure for each run of a condition.
    fn each(&self, condition: Condition, figure: impl Fn(&Run) -> f64) -> Vec<f64> {
        self.runs(condition).map(figure).collect()
    }

    /// Mean of a figure over a condition's runs.
    fn mean(&self, condition: Condition, figure: impl Fn(&Run) -> f64) -> f64 {
        mean(self.each(condition, figure))
    }

    /// Fitness of all individuals of a condition's runs.
    fn pooled_fitness(&self, condition: Condition, fitness_of: EpisodeFitness) -> Vec<f64> {
        pooled_fitness(&self.runs(condition).collect::<Vec<_>>(), fitness_of)
    }

    /// Adds Cohen's d between two episodes over all individuals of a condition, and returns it.
    fn d(&self, finding: &mut Finding, name: String, condition: Condition, [one, other]: [EpisodeFitness; 2]) -> f64 {
        let runs: Vec<&Run> = self.runs(condition).collect();
        let of = |runs: &[&Run]| cohens_d(&pooled_fitness(runs, one), &pooled_fitness(runs, other)).unwrap_or(f64::NAN);
        let d = of(&runs);
        let numbers: Vec<f64> = (0_u32..).zip(&runs).map(|(number, _)| f64::from(number)).collect();
        let drawn = |samples: &[Vec<f64>]| {
            of(&samples[0]
                .iter()
                .map(|&number| runs[number as usize])
                .collect::<Vec<_>>())
        };
        finding.estimate(name, d, over_runs(&[&numbers], drawn));
        d
    }

    /// The paper's analysis of variance over individuals, the same comparison over runs, and a mixed model.
    fn compare(&self, condition: Condition, what: &str, one: EpisodeFitness, other: EpisodeFitness) -> Vec<Test> {
        let title = condition.title();
        let mut tests = Vec::new();
        let (a, b) = (
            self.pooled_fitness(condition, one),
            self.pooled_fitness(condition, other),
        );
        if let Ok(all) = anova(&[&a, &b]) {
            let name = format!("{title}, {what}: individuals, one-way analysis of variance");
            tests.push(Test::new(name, ("F", all.f), &[all.df_between, all.df_within], all.p));
        }
        let means = |fitness_of: EpisodeFitness| self.each(condition, |run| mean_of(fitness_of(run)));
        if let Ok(runs) = paired_t(&means(one), &means(other)) {
            tests.push(Test::t(format!("{title}, {what}{RUNS}paired t of the means"), runs));
        }
        let mut rows = (Vec::new(), Vec::new(), Vec::new());
        for (group, run) in self.runs(condition).enumerate() {
            for (x, fitness_of) in [(0.0, other), (1.0, one)] {
                for y in as_f64(fitness_of(run)) {
                    rows.0.push(x);
                    rows.1.push(y);
                    rows.2.push(group);
                }
            }
        }
        if let Ok(model) = random_intercept(&rows.0, &rows.1, &rows.2) {
            let name = format!("{title}, {what}: mixed model, runs as random intercepts");
            tests.push(Test::new(name, ("z", model.z), &[], model.p));
        }
        tests
    }

    /// Draws sets of as many runs as the paper has from a condition's runs, without replacement and always the same
    /// ones. Empty if there are no more runs than that.
    fn sets(&self, condition: Condition) -> Vec<Vec<&Run>> {
        let runs: Vec<&Run> = self.runs(condition).collect();
        if runs.len() <= PAPERS_RUNS {
            return Vec::new();
        }
        let mut random = Pcg64::new(1995, condition as u128);
        let mut set = || subset(runs.len(), PAPERS_RUNS, &mut random);
        (0..SETS)
            .map(|_| set().into_iter().map(|run| runs[run]).collect())
            .collect()
    }

    /// Adds the outcome of the paper's analysis of variance in sets of five runs. Pooled over all runs it would find
    /// any difference significant.
    fn paper_sized(&self, finding: &mut Finding, condition: Condition, one: EpisodeFitness, other: EpisodeFitness) {
        let anovas: Vec<_> = self
            .sets(condition)
            .iter()
            .filter_map(|set| anova(&[&pooled_fitness(set, one), &pooled_fitness(set, other)]).ok())
            .collect();
        let Some(first) = anovas.first() else {
            return;
        };
        let (of, title) = (
            format!("F({}, {})", first.df_between, first.df_within),
            condition.title(),
        );
        let name = |what: &str| format!("{of} of {PAPERS_RUNS} runs, {title}: {what}");
        let fs: Vec<f64> = anovas.iter().map(|anova| anova.f).collect();
        let significant = anovas.iter().filter(|anova| anova.p.value < LEVEL).count();
        finding.effects.push(Effect {
            name: name(&format!("median of {SETS} sets")),
            value: median(&fs),
            interval: None,
            paper: self.criterion.paper(&format!("{of}, {title}")),
        });
        finding.note(name(&format!("5 % quantile of {SETS} sets")), quantile(&fs, 0.05));
        finding.note(name(&format!("95 % quantile of {SETS} sets")), quantile(&fs, 0.95));
        finding.note(
            name(&format!("share of {SETS} sets with p < {LEVEL}")),
            significant as f64 / anovas.len() as f64,
        );
        OF_SETS.clone_into(&mut finding.remark);
    }

    /// Adds the fractions of sets of five runs in which the gaps have C3's order and meet its criterion: the power of a
    /// study of the paper's size.
    fn power(&self, finding: &mut Finding) {
        let gaps = Condition::ALL.map(|condition| -> Vec<f64> {
            let gap = |set: &Vec<&Run>| {
                cohens_d(&pooled_fitness(set, SIMULATED), &pooled_fitness(set, REAL)).map_or(f64::NAN, f64::abs)
            };
            self.sets(condition).iter().map(gap).collect()
        });
        let sets = gaps.iter().map(Vec::len).min().unwrap_or(0);
        if sets == 0 {
            return;
        }
        let share = |holds: fn([f64; 3]) -> bool| {
            let held = (0..sets)
                .filter(|&set| holds(gaps.each_ref().map(|gap| gap[set])))
                .count();
            held as f64 / sets as f64
        };
        let name = |what: &str| format!("share of {sets} sets of {PAPERS_RUNS} runs a condition in which {what}");
        finding.note(name("the order holds"), share(in_order));
        finding.note(name("the criterion holds"), share(in_order_and_small));
    }

    /// Compares a figure between the runs of two conditions.
    fn between(&self, name: &str, conditions: [Condition; 2], figure: impl Fn(&Run) -> f64) -> Option<Test> {
        let [a, b] = conditions.map(|condition| self.each(condition, &figure));
        let test = student_t(&a, &b).ok()?;
        let [one, other] = conditions.map(Condition::title);
        Some(Test::t(format!("{one} against {other}, {name}{RUNS}t"), test))
    }

    fn sensors_differ(&self) -> Finding {
        let mut finding = Finding::default();
        let wall = self.sensors.class("wall");
        let gaps = wall
            .map(|wall| half_gaps(&self.sensors.classes[wall]))
            .unwrap_or_default();
        let least = gaps.iter().copied().fold(f64::INFINITY, f64::min);
        let most = gaps.iter().copied().fold(0.0, f64::max);
        let ratio = most / least;
        let losses = self.each(Without, |run| {
            mean_of(&run.transferred.real) - mean_of(&run.transferred.other_robot)
        });
        finding.note("greatest over least distance of half readings", ratio);
        let loss = finding.mean("fitness in its own robot minus in another, mean over runs", &losses);
        let same = self.each(Without, |run| mean_of(&run.transferred.real));
        let other = self.each(Without, |run| mean_of(&run.transferred.other_robot));
        let name = format!("no noise, own robot against another{RUNS}paired t of the means");
        finding
            .tests
            .extend(paired_t(&same, &other).ok().map(|test| Test::t(name, test)));
        finding.registered = Some(ratio >= 1.4 && loss > 0.0);
        let what = "the greatest distance of half readings is at least 1.4 times the least";
        finding.parts = vec![
            Part::fact(what, ratio >= 1.4),
            Part::above("loss of fitness in another robot", &[(1.0, &losses)], 0.0),
        ];
        finding.missing = self.if_connected("Not measured: fitness in another robot, since only one is connected");
        finding
    }

    /// C1 by distance and by angle.
    fn ranges_differ(&self) -> Finding {
        let mut finding = self.sensors_differ();
        let Some(wall) = self.sensors.class("wall") else {
            return finding;
        };
        let wall = &self.sensors.classes[wall];
        let rows = [("distance", half_gaps(wall)), ("angle", half_angles(wall))];
        let loss = finding.parts.pop();
        let (mut effects, mut is_met) = (Finding::default(), true);
        finding.parts.clear();
        for ((what, ranges), most) in rows.into_iter().zip(MOST) {
            let [least, greatest] =
                [f64::min, f64::max].map(|of| ranges.iter().copied().reduce(of).unwrap_or(f64::NAN));
            let ratio = greatest / least;
            effects.note(format!("greatest over least {what} of half readings"), ratio);
            effects.note(
                format!("sixth over fifth sensor, {what} of half readings"),
                ranges[SIXTH] / ranges[FIFTH],
            );
            effects.note(format!("the most that the recordings' range can show, {what}"), most);
            is_met &= ratio >= MUCH;
            let name = format!("the greatest {what} of half readings is at least {MUCH} times the least");
            finding.parts.push(if ratio >= MUCH || self.judging.is_real_robot {
                Part::fact(&name, ratio >= MUCH)
            } else {
                let [ratio, most] = [ratio, most].map(|ratio| fixed(ratio, 2));
                Part::undecided(format!(
                    "{what} of half readings: {ratio} times, of {most} that can be drawn"
                ))
            });
        }
        let is_worse = finding.registered == Some(true) || finding.effects[1].value > 0.0;
        finding.registered = Some(is_met && is_worse);
        finding.effects.splice(0..1, effects.effects);
        finding.parts.extend(loss);
        finding
    }

    fn quick_rise(&self) -> Finding {
        let mut finding = Finding::default();
        let mut holds = true;
        for condition in Condition::ALL {
            let rises = self
                .runs(condition)
                .all(|run| match (run.simulated.first(), run.simulated.last()) {
                    (Some(first), Some(last)) => last.peak > first.peak,
                    _ => false,
                });
            let is_run = self.runs(condition).next().is_some();
            holds &= rises && is_run;
            let what = format!("the peak rises in every run, {}", condition.title());
            finding.parts.push(if is_run {
                Part::fact(&what, rises)
            } else {
                Part::undecided(format!("{what}: there is no run"))
            });
            for (name, figure) in [("peak", PEAK), ("average", AVERAGE)] {
                let at = |generation: usize| {
                    self.mean(condition, |run| run.simulated.get(generation).map_or(f64::NAN, figure))
                };
                let last = self.results.simulated_generations as usize;
                let gained = (at(last / 2) - at(0)) / (at(last) - at(0));
                holds &= gained > 0.8;
                let (half, title) = (last / 2, condition.title());
                // How much more of the gain there is by half of the generations than 80 %.
                let beyond = self.each(condition, |run| {
                    let at = |generation: usize| run.simulated.get(generation).map_or(f64::NAN, figure);
                    at(half) - at(0) - 0.8 * (at(last) - at(0))
                });
                let what = format!("the {name}'s gain by generation {half} minus 80 % of its gain, {title}");
                finding.parts.push(Part::above(&what, &[(1.0, &beyond)], 0.0));
                finding.note(
                    format!("share of the {name}'s gain by generation {half}, {title}"),
                    gained,
                );
            }
        }
        finding.registered = Some(holds);
        finding
    }

    fn transfer_gap(&self) -> Finding {
        let mut finding = Finding::default();
        let ds = Condition::ALL.map(|condition| {
            let title = condition.title();
            let name = format!("d, {title}, noise on in simulation");
            let d = self.d(&mut finding, name, condition, [SIMULATED, REAL]);
            let name = format!("d, {title}, noise off in both");
            self.d(&mut finding, name, condition, [QUIET, REAL]);
            let tests = self.compare(condition, "simulated and real", SIMULATED, REAL);
            finding.tests.extend(tests);
            d
        });
        for condition in Condition::ALL {
            self.paper_sized(&mut finding, condition, SIMULATED, REAL);
        }
        self.power(&mut finding);
        for condition in [Sensor, Conservative] {
            let tests = self.compare(condition, "simulated without noise and real", QUIET, REAL);
            finding.tests.extend(tests);
        }
        finding.registered = Some(in_order_and_small(ds.map(f64::abs)));
        let values = |condition, of: fn(f64) -> f64| {
            let runs: Vec<&Run> = self.runs(condition).collect();
            pseudo_values(runs.len(), |kept| {
                let kept: Vec<&Run> = kept.iter().map(|&run| runs[run]).collect();
                of(cohens_d(&pooled_fitness(&kept, SIMULATED), &pooled_fitness(&kept, REAL)).unwrap_or(f64::NAN))
            })
        };
        let [none, sensor, conservative] = Condition::ALL.map(|condition| values(condition, f64::abs));
        let signed = values(Conservative, |d| d);
        finding.parts = vec![
            Part::above("abs(d), sensor minus none", &[(1.0, &sensor), (-1.0, &none)], 0.0),
            Part::above(
                "abs(d), none minus conservative",
                &[(1.0, &none), (-1.0, &conservative)],
                0.0,
            ),
            Part::within("d, conservative noise", &[(1.0, &signed)], [-0.2, 0.2]),
        ];
        finding
    }

    fn peak_and_average(&self) -> Finding {
        let mut finding = Finding::default();
        let fall = |figure: Figure| {
            move |run: &Run| match (run.simulated.last(), run.real.first()) {
                (Some(simulated), Some(real)) => figure(simulated) - figure(real),
                _ => f64::NAN,
            }
        };
        let falls = [("peak", fall(PEAK)), ("average", fall(AVERAGE))].map(|(name, fall)| {
            let means = [Without, Sensor].map(|condition| {
                let name = format!("fall of the {name}, {}", condition.title());
                finding.mean(name, &self.each(condition, fall))
            });
            let test = self.between(&format!("fall of the {name}"), [Without, Sensor], fall);
            finding.tests.extend(test);
            means
        });
        let again = |condition| self.each(condition, |run| best_again(run, self.results.parents as usize));
        finding.mean(
            "the best 20 in simulation, their second real life below their second simulated one, no noise",
            &again(Without),
        );
        finding.mean("the same, sensor noise", &again(Sensor));
        let [[peak_without, peak_sensor], [average_without, average_sensor]] = falls;
        finding.registered = Some(peak_sensor < peak_without && average_sensor > average_without);
        let of = |condition, figure| self.each(condition, fall(figure));
        let [none, sensor] = [Without, Sensor].map(|condition| [of(condition, PEAK), of(condition, AVERAGE)]);
        finding.parts = vec![
            Part::above(
                "fall of the peak, none minus sensor",
                &[(1.0, &none[0]), (-1.0, &sensor[0])],
                0.0,
            ),
            Part::above(
                "fall of the average, sensor minus none",
                &[(1.0, &sensor[1]), (-1.0, &none[1])],
                0.0,
            ),
        ];
        finding
    }

    fn conservative(&self) -> Finding {
        let mut finding = Finding::default();
        let [simulated, real] = [("in simulation", SIMULATED), ("in reality", REAL)].map(|(name, fitness_of)| {
            Condition::ALL.map(|condition| {
                let name = format!("average of generation 200 {name}, {}", condition.title());
                finding.mean(name, &self.each(condition, |run| mean_of(fitness_of(run))))
            })
        });
        for other in [Without, Sensor] {
            for (name, fitness_of) in [("average in simulation", SIMULATED), ("average in reality", REAL)] {
                let test = self.between(name, [Conservative, other], |run| mean_of(fitness_of(run)));
                finding.tests.extend(test);
            }
        }
        let lower = simulated[2] < simulated[0] && simulated[2] < simulated[1];
        let higher = real[2] > real[0] && real[2] > real[1];
        finding.registered = Some(lower && higher);
        for (name, fitness_of, sign) in [("simulation", SIMULATED, -1.0), ("reality", REAL, 1.0)] {
            let conservative = self.each(Conservative, |run| mean_of(fitness_of(run)));
            for other in [Without, Sensor] {
                let others = self.each(other, |run| mean_of(fitness_of(run)));
                let words = ["conservative noise", other.title()];
                let [one, less] = if sign > 0.0 { words } else { [words[1], words[0]] };
                let what = format!("average in {name}, {one} minus {less}");
                finding
                    .parts
                    .push(Part::above(&what, &[(sign, &conservative), (-sign, &others)], 0.0));
            }
        }
        finding
    }

    fn evolving_on(&self) -> Finding {
        const CONTROLS: [(&str, Control); 3] = [
            ("had all generations been simulated", |controls| controls.simulated_on),
            ("had the last parents been drawn by lot", |controls| controls.neutral),
            ("of 20 generations in reality from random genes", |controls| {
                controls.from_random
            }),
        ];
        let mut finding = Finding::default();
        let ds = Condition::ALL.map(|condition| {
            let name = format!("d of generation 219 over 200, {}", condition.title());
            let d = self.d(&mut finding, name, condition, [LAST, REAL]);
            let tests = self.compare(condition, "generations 219 and 200 in reality", LAST, REAL);
            finding.tests.extend(tests);
            d
        });
        for condition in Condition::ALL {
            self.paper_sized(&mut finding, condition, LAST, REAL);
        }
        let are_there = self.results.runs.iter().any(|run| run.controls.is_some());
        for condition in Condition::ALL.into_iter().filter(|_| are_there) {
            let title = condition.title();
            for (name, figure) in CONTROLS {
                let controls = self.runs(condition).filter_map(|run| run.controls.as_ref());
                let of_controls: Vec<f64> = controls.map(figure).collect();
                finding.mean(format!("real fitness of generation 219 {name}, {title}"), &of_controls);
            }
            let of_condition = self.each(condition, |run| mean_of(LAST(run)));
            finding.mean(
                format!("real fitness of generation 219 as it is, {title}"),
                &of_condition,
            );
        }
        finding.registered = Some(ds.iter().all(|d| *d > 0.0));
        for condition in Condition::ALL {
            let rises = self.each(condition, |run| mean_of(LAST(run)) - mean_of(REAL(run)));
            let what = format!("real fitness, generation 219 minus 200, {}", condition.title());
            finding.parts.push(Part::above(&what, &[(1.0, &rises)], 0.0));
        }
        finding
    }

    fn recovery(&self) -> Finding {
        let mut finding = Finding::default();
        let share = |condition, figure: Figure| {
            let at =
                |levels: fn(&Run) -> Option<&Level>| self.mean(condition, |run| levels(run).map_or(f64::NAN, figure));
            let (simulated, first, last) = (
                at(|run| run.simulated.last()),
                at(|run| run.real.first()),
                at(|run| run.real.last()),
            );
            ((simulated - first), (last - first) / (simulated - first), last - first)
        };
        let (none, sensor, sensor_peak) = (share(Without, AVERAGE), share(Sensor, AVERAGE), share(Sensor, PEAK));
        let (.., rise) = share(Conservative, AVERAGE);
        finding.note("share of the average's loss recovered, no noise", none.1);
        finding.note("share of the average's loss recovered, sensor noise", sensor.1);
        finding.note("share of the peak's loss recovered, sensor noise", sensor_peak.1);
        finding.note("loss of the average at the transfer, no noise", none.0);
        finding.note("loss of the average at the transfer, sensor noise", sensor.0);
        finding.note("loss of the peak at the transfer, sensor noise", sensor_peak.0);
        finding.note("rise of the average in reality, conservative noise", rise);
        let no_gap = none.0 <= 0.0 || sensor.0 <= 0.0;
        finding.registered = (!no_gap).then_some(none.1 > sensor.1 && sensor_peak.1 > sensor.1 && rise > 0.0);
        finding.parts = self.parts_of_recovery();
        finding
    }

    /// The parts of C7. A fraction of a loss needs a loss.
    fn parts_of_recovery(&self) -> Vec<Part> {
        let runs = |condition| self.runs(condition).collect::<Vec<_>>();
        let at = |run: &Run, figure: Figure| {
            let of = |level: Option<&Level>| level.map_or(f64::NAN, figure);
            [of(run.simulated.last()), of(run.real.first()), of(run.real.last())]
        };
        for condition in [Without, Sensor] {
            let losses = self.each(condition, |run| {
                let [simulated, first, _] = at(run, AVERAGE);
                simulated - first
            });
            let what = format!("loss of the average at the transfer, {}", condition.title());
            let part = Part::above(&what, &[(1.0, &losses)], 0.0);
            if part.verdict != Verdict::Holds {
                return vec![Part::undecided(format!(
                    "{}, so that there may be nothing to recover",
                    part.reason
                ))];
            }
        }
        let share = |runs: &[&Run], kept: &[usize], figure: Figure| {
            let mean_at = |place: usize| mean(kept.iter().map(|&run| at(runs[run], figure)[place]));
            let (simulated, first, last) = (mean_at(0), mean_at(1), mean_at(2));
            (last - first) / (simulated - first)
        };
        let shares = |condition, of: &dyn Fn(&[&Run], &[usize]) -> f64| {
            let runs = runs(condition);
            pseudo_values(runs.len(), |kept| of(&runs, kept))
        };
        let none = shares(Without, &|runs, kept| share(runs, kept, AVERAGE));
        let sensor = shares(Sensor, &|runs, kept| share(runs, kept, AVERAGE));
        let peak = shares(Sensor, &|runs, kept| {
            share(runs, kept, PEAK) - share(runs, kept, AVERAGE)
        });
        let rise = self.each(Conservative, |run| {
            let [_, first, last] = at(run, AVERAGE);
            last - first
        });
        vec![
            Part::above(
                "recovered share of the average, none minus sensor",
                &[(1.0, &none), (-1.0, &sensor)],
                0.0,
            ),
            Part::above(
                "recovered share, peak minus average, sensor noise",
                &[(1.0, &peak)],
                0.0,
            ),
            Part::above(
                "rise of the average in reality, conservative noise",
                &[(1.0, &rise)],
                0.0,
            ),
        ]
    }

    fn paths(&self) -> Finding {
        const FIGURES: [(&str, Sums); 4] = [
            ("one start", |run| &run.champion.discrepancy.paper),
            ("100 starts", STARTS),
            ("two real lives, 100 starts", |run| &run.champion.discrepancy.repeated),
            ("unrelated champions, 100 starts", |run| {
                &run.champion.discrepancy.unrelated
            }),
        ];
        let mut finding = Finding::default();
        let whole = |sums: Sums| move |run: &Run| sums(run).last().copied().unwrap_or(f64::NAN);
        let ends = Condition::ALL.map(|condition| {
            let title = condition.title();
            let means = FIGURES.map(|(name, sums)| {
                let name = format!("D after 500 cycles, {name}, {title}, mm");
                finding.mean(name, &self.each(condition, whole(sums)))
            });
            let all: Vec<&Discrepancy> = self.runs(condition).map(|run| &run.champion.discrepancy).collect();
            let per_length = |kept: &[usize]| Discrepancy::per_length(kept.iter().map(|&run| all[run]));
            let values = pseudo_values(all.len(), per_length);
            finding.estimate(
                format!("D over the length of the path, ratio of sums, 100 starts, {title}"),
                Discrepancy::per_length(all.iter().copied()),
                mean_interval(&values, verdict::LEVEL).ok(),
            );
            means[0]
        });
        for other in [Without, Sensor] {
            let test = self.between("D from 100 starts", [Conservative, other], whole(STARTS));
            finding.tests.extend(test);
        }
        finding.registered = Some(ends[2] < 0.5 * ends[0].min(ends[1]));
        let [none, sensor, conservative] = Condition::ALL.map(|condition| self.each(condition, whole(FIGURES[0].1)));
        for (other, title) in [(&none, "none"), (&sensor, "sensor")] {
            let what = format!("D from one start, half of {title} minus conservative, mm");
            finding
                .parts
                .push(Part::above(&what, &[(0.5, other), (-1.0, &conservative)], 0.0));
        }
        if self.results.is_wired {
            CONNECTED_PATHS.clone_into(&mut finding.remark);
        }
        finding
    }

    fn behaviour(&self) -> Finding {
        let mut finding = Finding::default();
        // No interval: a fraction of a few runs is far from normal.
        let share = |which: fn(&Run) -> bool| self.mean(Without, |run| f64::from(u8::from(which(run))));
        let stuck_real = share(|run| run.champion.real.stuck_in_corner);
        let stuck_simulated = share(|run| run.champion.simulated.stuck_in_corner);
        finding.note("share of champions stuck in a corner in reality, no noise", stuck_real);
        finding.note(
            "share of champions stuck in a corner in simulation, no noise",
            stuck_simulated,
        );
        let speed = |condition| {
            self.mean(condition, |run| run.champion.real.speed)
                / self.mean(condition, |run| run.champion.simulated.speed)
        };
        finding.note("speed in reality over speed in simulation, sensor noise", speed(Sensor));
        finding.mean(
            "share of cycles colliding in reality, sensor noise",
            &self.each(Sensor, |run| run.champion.real.collided),
        );
        finding.mean(
            "share of cycles colliding in simulation, sensor noise",
            &self.each(Sensor, |run| run.champion.simulated.collided),
        );
        finding.note(
            "speed in reality over speed in simulation, conservative noise",
            speed(Conservative),
        );
        finding.registered =
            Some(self.sticks_and_hits() && speed(Sensor) < 1.0 && (0.9..=1.1).contains(&speed(Conservative)));
        finding.parts = self.parts_of_behaviour("speed", |episode| episode.speed);
        finding.missing =
            self.if_connected("Not measured: collisions in reality, which a connected robot does not report");
        finding
    }

    /// Whether more champions stick in a corner without noise, and champions collide more with sensor noise, in reality.
    fn sticks_and_hits(&self) -> bool {
        let more = |condition, of: fn(&MeasuredEpisode) -> f64| {
            self.mean(condition, |run| of(&run.champion.real)) > self.mean(condition, |run| of(&run.champion.simulated))
        };
        more(Without, |episode| f64::from(u8::from(episode.stuck_in_corner)))
            && more(Sensor, |episode| episode.collided)
    }

    /// The parts of C9; `pace` is how fast a champion is.
    fn parts_of_behaviour(&self, name: &str, pace: fn(&MeasuredEpisode) -> f64) -> Vec<Part> {
        let stuck = self.each(Without, |run| {
            let stuck = |path: bool| f64::from(u8::from(path));
            stuck(run.champion.real.stuck_in_corner) - stuck(run.champion.simulated.stuck_in_corner)
        });
        // Champions that stick in both or in neither say nothing.
        let stuck: Vec<f64> = stuck.into_iter().filter(|differs| *differs != 0.0).collect();
        let what = "champions that stick in just one of both, in reality (1) or in simulation (-1), no noise";
        let stuck = match median_interval(&stuck, verdict::LEVEL) {
            Ok(interval) => Part::of_interval(what, interval, [0.0, f64::INFINITY], stuck.len()),
            Err(_) => Part::undecided(format!(
                "too few runs: {} in just one of both, no noise: an interval needs {OF_A_MEDIAN}",
                counted(stuck.len(), "champion sticks", "champions stick")
            )),
        };
        // How much faster a champion is in reality than a factor times its speed in simulation.
        let faster = |condition, factor: f64| {
            self.each(condition, |run| {
                pace(&run.champion.real) - factor * pace(&run.champion.simulated)
            })
        };
        let collided = self.each(Sensor, |run| {
            run.champion.real.collided - run.champion.simulated.collided
        });
        vec![
            stuck,
            Part::below(
                &format!("{name}, reality minus simulation, sensor noise"),
                &[(1.0, &faster(Sensor, 1.0))],
                0.0,
            ),
            Part::above(
                "share of cycles colliding, reality minus simulation, sensor noise",
                &[(1.0, &collided)],
                0.0,
            ),
            Part::above(
                &format!("{name}, reality minus 0.9 of simulation, conservative noise"),
                &[(1.0, &faster(Conservative, 0.9))],
                0.0,
            ),
            Part::below(
                &format!("{name}, reality minus 1.1 of simulation, conservative noise"),
                &[(1.0, &faster(Conservative, 1.1))],
                0.0,
            ),
        ]
    }

    /// C9 with what champions do in corners, and how far they come: wheels that turn at a wall are no speed.
    fn behaviour_in_corners(&self) -> Finding {
        let mut finding = self.behaviour();
        let distance = |condition| {
            let of = |place: fn(&Run) -> &MeasuredEpisode| self.mean(condition, |run| place(run).length);
            of(|run| &run.champion.real) / of(|run| &run.champion.simulated)
        };
        let [sensor, conservative] = [Sensor, Conservative].map(distance);
        finding.note(
            "distance covered in reality over that in simulation, sensor noise",
            sensor,
        );
        finding.note(
            "distance covered in reality over that in simulation, conservative noise",
            conservative,
        );
        finding.parts = self.parts_of_behaviour("distance covered", |episode| episode.length);
        let turns = |episode: &MeasuredEpisode| corner_turns(&episode.path, &self.judging.corners);
        let champions: Vec<[[f64; 2]; 2]> = self
            .runs(Without)
            .map(|run| [turns(&run.champion.real), turns(&run.champion.simulated)])
            .collect();
        let mut shares = Vec::new();
        for (place, name) in ["reality", "simulation"].into_iter().enumerate() {
            let sum = |of: usize| champions.iter().map(|champion| champion[place][of]).sum::<f64>();
            let name = format!("fraction of corners left by more than 90 degrees in {name}, no noise");
            finding.note(name, sum(1) / sum(0));
            shares.push(sum(1) / sum(0));
        }
        // Champions that leave no corner in one of both say nothing.
        let both = champions
            .iter()
            .filter(|champion| champion.iter().all(|[visits, _]| *visits > 0.0));
        let more: Vec<f64> = both
            .map(|[real, simulated]| real[1] / real[0] - simulated[1] / simulated[0])
            .collect();
        let what = "fraction of corners left by more than 90 degrees, reality minus simulation, no noise";
        finding.parts.insert(0, Part::above(what, &[(1.0, &more)], 0.0));
        let sticks_and_hits = self.sticks_and_hits();
        finding.registered =
            Some(sticks_and_hits && shares[0] > shares[1] && sensor < 1.0 && (0.9..=1.1).contains(&conservative));
        finding
    }

    /// C10 by the population's average.
    fn above_the_average(&self) -> Finding {
        let mut finding = Finding::default();
        let episodes: Vec<f64> = as_f64(&self.results.to_and_fro).collect();
        let averages = self.each(Without, |run| mean_of(SIMULATED(run)));
        let to_and_fro = finding.mean("fitness of going to and fro, mean of 100 lives", &episodes);
        let average = finding.mean("average of generation 200 in simulation, no noise", &averages);
        finding.registered = Some(to_and_fro > average);
        let what = "going to and fro minus the population's average";
        let part = Part::above(what, &[(1.0, &episodes), (-1.0, &averages)], 0.0);
        // Another that goes to and fro may do better.
        finding.parts = vec![if part.verdict == Verdict::Opposed {
            Part::undecided(format!("{}; one controller says nothing of others", part.reason))
        } else {
            part
        }];
        finding
    }

    /// C12, which no study has to ask.
    fn hardware(&self) -> Finding {
        Finding {
            registered: None,
            not_judged: Some(HARDWARE),
            ..self.cost()
        }
    }

    fn deceptive_optimum(&self) -> Finding {
        let mut finding = Finding::default();
        let to_and_fro = mean_of(&self.results.to_and_fro);
        let champions = self.each(Without, |run| {
            let best_life = || as_f64(SIMULATED(run)).fold(f64::NEG_INFINITY, f64::max);
            run.champion.mean.unwrap_or_else(best_life)
        });
        let middle = median(&champions);
        // A champion chosen by its mean is represented by that mean, like the handmade controller.
        let by_mean = self.results.runs.iter().any(|run| run.champion.mean.is_some());
        let fitness = if by_mean {
            "the mean that it was chosen by"
        } else {
            "its best life"
        };
        finding.note("fitness of going to and fro, mean of 100 lives", to_and_fro);
        finding.note(format!("median champion without noise, {fitness}"), middle);
        finding.registered = Some(to_and_fro > middle);
        let what = "going to and fro minus the median champion";
        let episodes: Vec<f64> = as_f64(&self.results.to_and_fro).collect();
        let intervals = (
            mean_interval(&episodes, verdict::LEVEL),
            median_interval(&champions, verdict::LEVEL),
        );
        finding.parts = vec![match intervals {
            (Ok(to_and_fro), Ok(others)) => {
                let (low, high) = (to_and_fro.low - others.high, to_and_fro.high - others.low);
                Part::of_interval(what, Interval { low, high }, [0.0, f64::INFINITY], champions.len())
            }
            (Err(_), _) => Part::undecided(format!("{what}: going to and fro has no interval")),
            (_, Err(_)) => {
                let champions = counted(champions.len(), "champion", "champions");
                Part::undecided(format!(
                    "too few runs ({champions}): {what}: an interval needs {OF_A_MEDIAN}"
                ))
            }
        }];
        finding
    }

    fn parameters(&self) -> Finding {
        let mut finding = Finding::default();
        let of = |family| {
            self.results
                .variants
                .iter()
                .filter(move |variant| variant.family == family)
        };
        let mut interior = Vec::new();
        for (family, noise) in [
            (Family::SensorRange, "sensor noise"),
            (Family::WalkRange, "conservative noise within"),
        ] {
            let mut means = Vec::new();
            for variant in of(family) {
                let name = &variant.name;
                let mean = finding.mean(format!("real fitness of generation 200, {noise} {name}"), &variant.real);
                finding.note(
                    format!("its s.d. over runs, {noise} {name}"),
                    variance(&variant.real).sqrt(),
                );
                means.push(mean);
            }
            let best = (0..means.len()).max_by(|&a, &b| means[a].total_cmp(&means[b]));
            interior.extend(best.map(|best| best > 0 && best + 1 < means.len()));
            let ranges: Vec<&[f64]> = of(family).map(|variant| &variant.real[..]).collect();
            finding.parts.extend(best_is_inside(noise, &ranges));
        }
        for variant in of(Family::Simulator) {
            let name = &variant.name;
            finding.mean(
                format!("real fitness of generation 200, simulator from {name}"),
                &variant.real,
            );
        }
        let asked = interior.len() == 2;
        finding.registered = asked.then_some(interior.iter().all(|interior| *interior));
        if !asked {
            finding.parts = vec![Part::undecided(
                "other ranges were not run in this study; `--full` runs them",
            )];
        }
        finding.missing = self
            .if_connected("Not measured: other ranges of noise, which only a study of a surrogate runs, with `--full`");
        let remark = match finding.missing {
            Some(_) => "",
            None if asked => "The paper's second criterion, less dependency on initial seeds, is the s.d. over runs",
            None => "Other ranges were not run in this study; `--full` runs them",
        };
        remark.clone_into(&mut finding.remark);
        finding
    }

    fn cost(&self) -> Finding {
        let mut finding = Finding::default();
        let seconds = f64::from(self.results.cycles) * 0.1;
        finding.note("seconds of a real life of 500 cycles", seconds);
        let is_met = self.results.life_within_two_seconds;
        finding.registered = Some(is_met);
        finding.parts = vec![Part::fact("a simulated life takes less than 2 s", is_met)];
        finding
    }
}

/// Whether the best of several ranges is neither the first nor the last: it must be above both. Opposed if one of these is above all
/// between them.
fn best_is_inside(noise: &str, ranges: &[&[f64]]) -> Option<Part> {
    let [first, inner @ .., last] = ranges else { return None };
    let best = inner.iter().max_by(|a, b| mean(**a).total_cmp(&mean(**b)))?;
    let above = |one: &[f64], other: &[f64], words: &str| {
        let what = format!("real fitness, {words}, {noise}");
        Part::above(&what, &[(1.0, one), (-1.0, other)], 0.0)
    };
    let parts = [
        above(best, first, "best inner range minus the smallest"),
        above(best, last, "best inner range minus the largest"),
    ];
    let (verdict, reasons) = verdict::of_parts(parts.into());
    Some(Part {
        verdict,
        reason: reasons.join("; "),
    })
}

/// Mean gap, simulated minus real, in new episodes of the individuals with the best simulated fitness.
fn best_again(run: &Run, parents: usize) -> f64 {
    let transferred = &run.transferred;
    let mut ranking: Vec<usize> = (0..transferred.simulated.len()).collect();
    ranking.sort_by(|&a, &b| {
        transferred.simulated[b]
            .total_cmp(&transferred.simulated[a])
            .then(a.cmp(&b))
    });
    ranking.truncate(parents);
    let falls: Vec<f64> = ranking
        .into_iter()
        .map(|individual| {
            f64::from(transferred.simulated_again[individual]) - f64::from(transferred.real_again[individual])
        })
        .collect();
    mean(&falls)
}

/// For each sensor, the gap in mm at which its maximum reading over all bearings falls below one half.
pub(super) fn half_gaps(table: &SensorTable) -> Vec<f64> {
    let half = f64::from(GREATEST_READING) / 2.0;
    let bearings = table.bearings as usize;
    let greatest = |row: usize, sensor: usize| {
        let cells = row * bearings..(row + 1) * bearings;
        cells
            .map(|cell| f64::from(table.cell(cell)[sensor]))
            .fold(0.0, f64::max)
    };
    let gap = |row: f64| f64::from(table.nearest) + f64::from(table.spacing) * row;
    (0..SENSORS)
        .map(|sensor| {
            let last = (0..table.rows as usize).rfind(|&row| greatest(row, sensor) >= half);
            match last {
                Some(row) if row + 1 < table.rows as usize => {
                    let (here, next) = (greatest(row, sensor), greatest(row + 1, sensor));
                    gap(row as f64 + (here - half) / (here - next))
                }
                Some(row) => gap(row as f64),
                None => gap(0.0),
            }
        })
        .collect()
}

/// For each sensor, the angle in degrees over which its reading, [`ANGLES_AT`] from the object, is one half or more.
fn half_angles(table: &SensorTable) -> Vec<f64> {
    let row = ((ANGLES_AT - f64::from(table.nearest)) / f64::from(table.spacing))
        .round()
        .max(0.0) as u32;
    let row = row.min(table.rows.saturating_sub(1)) as usize;
    let bearings = table.bearings as usize;
    let is_half = |cell: usize, sensor: usize| 2.0 * f64::from(table.cell(cell)[sensor]) >= f64::from(GREATEST_READING);
    let angle = |sensor: usize| {
        let count = (row * bearings..(row + 1) * bearings)
            .filter(|cell| is_half(*cell, sensor))
            .count();
        360.0 * count as f64 / bearings as f64
    };
    (0..SENSORS).map(angle).collect()
}

#[cfg(test)]
mod tests {
    use super::super::report::tests::{GENERATIONS, results};
    use super::*;

    const GENERATION: usize = GENERATIONS as usize;

    fn judging<'a>(results: &'a Results, sensors: &'a SensorTables, edition: Edition) -> Judging<'a> {
        Judging {
            results,
            sensors,
            is_real_robot: false,
            corners: vec![[0.0, 0.0], [600.0, 0.0], [600.0, 350.0], [0.0, 350.0]],
            edition,
            planned: None,
        }
    }

    /// One claim, since bootstraps of all take long.
    fn of(judging: &Judging<'_>, id: &str) -> Claim {
        let table = Table::in_edition(MIGLINO1995_CLAIMS, judging.edition);
        judging.claim(table.claims.iter().find(|claim| claim.id() == id).unwrap())
    }

    fn claims<const N: usize>(results: &Results, ids: [&str; N]) -> [Claim; N] {
        let sensors = SensorTables::khepera();
        ids.map(|id| of(&judging(results, &sensors, Edition::First), id))
    }

    fn claim(results: &Results, id: &str) -> Claim {
        let [claim] = claims(results, [id]);
        claim
    }

    fn of_sets(claim: &Claim) -> Vec<(String, f64)> {
        let effects = claim.effects.iter().filter(|effect| effect.name.contains(" sets"));
        effects.map(|effect| (effect.name.clone(), effect.value)).collect()
    }

    /// Copies each condition's first run `count` times.
    fn copies(count: u32) -> Results {
        let mut results = results(1);
        let firsts = results.runs.clone();
        results.runs = firsts
            .iter()
            .flat_map(|run| (0..count).map(|number| Run { number, ..run.clone() }))
            .collect();
        results
    }

    #[test]
    fn the_papers_number_of_runs_is_not_resampled() {
        for claim in claims(&results(5), ["C3", "C6"]) {
            assert_eq!(of_sets(&claim), [], "{}", claim.id);
        }
    }

    /// Any five of several equal runs give the F of five of them.
    #[test]
    fn sets_of_equal_runs_all_give_the_papers_test() {
        let ids = ["C3", "C6"];
        let all = claims(&copies(8), ids).map(|claim| of_sets(&claim));
        for (five, of_sets) in claims(&copies(5), ids).iter().zip(&all) {
            let fs: Vec<f64> = five
                .tests
                .iter()
                .filter(|test| test.statistic == "F")
                .map(|test| test.value)
                .take(3)
                .collect();
            for (condition, f) in Condition::ALL.into_iter().zip(fs) {
                for what in ["median", "5 % quantile", "95 % quantile"] {
                    let name = format!("F(1, 998) of 5 runs, {}: {what} of 2000 sets", condition.title());
                    let (_, value) = of_sets.iter().find(|(title, _)| *title == name).expect(&name);
                    assert!((value - f).abs() < 1e-9 * f, "{}, {name}: {value}, not {f}", five.id);
                }
            }
        }
        let shares: Vec<f64> = all[0]
            .iter()
            .filter(|(name, _)| name.contains("share"))
            .map(|(_, share)| *share)
            .collect();
        // The made-up gaps are 60, 110 and 5: two are found, one isn't, and they are in order.
        assert_eq!(shares, [1.0, 1.0, 0.0, 1.0, 1.0]);
    }

    /// Going to and fro scores 300 here: champions score more in single episodes, and less in the mean.
    #[test]
    fn champions_are_measured_by_what_they_were_chosen_by() {
        let mut by_life = results(5);
        by_life.to_and_fro = vec![300.0; 100];
        let mut by_mean = by_life.clone();
        for run in &mut by_mean.runs {
            run.champion.mean = Some(290.0);
        }
        let [by_life, by_mean] = [by_life, by_mean].map(|results| claim(&results, "C10"));
        assert!(by_life.effects[1].value > 300.0 && by_life.effects[1].name.ends_with("its best life"));
        assert_eq!(by_life.verdict, Verdict::Undecided);
        assert!(by_mean.effects[1].value == 290.0 && by_mean.effects[1].name.ends_with("chosen by"));
        assert_eq!(by_mean.verdict, Verdict::Undecided);
    }

    fn all(results: &Results) -> Vec<Claim> {
        judge(&judging(results, &SensorTables::khepera(), Edition::First))
    }

    /// Fewer runs than the paper's decide nothing, whatever their intervals. An episode's speed needs no runs.
    #[test]
    fn few_runs_decide_nothing() {
        for runs in 1..5 {
            let mut results = results(runs);
            results.to_and_fro = vec![299.0, 300.0, 301.0];
            for claim in all(&results) {
                let expected = if claim.id == "C12" {
                    Verdict::Holds
                } else {
                    Verdict::Undecided
                };
                assert_eq!(claim.verdict, expected, "{} of {runs}", claim.id);
                assert_eq!(claim.registered.is_none(), claim.id == "C11", "{}", claim.id);
                let says_so = claim.reasons.iter().all(|reason| reason.contains("too few runs"));
                let needs_none = ["C11", "C12"].contains(&&*claim.id);
                assert!(says_so || needs_none, "{}: {:?}", claim.id, claim.reasons);
            }
        }
    }

    fn of_second(results: &Results, id: &str) -> Claim {
        of(&judging(results, &SensorTables::khepera(), Edition::Second), id)
    }

    /// The second edition's claims are judged by its contrasts: made-up gaps of 42, 77 and 3.5 are in the paper's order.
    #[test]
    fn the_second_edition_has_its_contrasts() {
        let mut results = results(20);
        results.to_and_fro = vec![299.0, 300.0, 301.0];
        for id in ["C3", "C5", "C6"] {
            let claim = of_second(&results, id);
            assert_eq!(
                (claim.verdict, claim.registered),
                (Verdict::Holds, Some(true)),
                "{id}: {:?}",
                claim.reasons
            );
        }
        let gap = |claim: &Claim, name: &str| {
            let found = claim
                .effects
                .iter()
                .find(|effect| effect.name == format!("{name}, mean over runs"));
            found.unwrap_or_else(|| panic!("{name} in {:?}", claim.effects)).value
        };
        let transfer = of_second(&results, "C3");
        assert!((gap(&transfer, "gap sensor - none") - 35.0).abs() < 5.0);
        assert!((gap(&transfer, "gap none - conservative") - 38.5).abs() < 5.0);
        // The paper's F are still there, for Table 1.
        assert_eq!(transfer.tests.iter().filter(|test| test.statistic == "F").count(), 5);
        // A gap with conservative noise of 35 is beyond the margin.
        for run in results.runs.iter_mut().filter(|run| run.condition == Conservative) {
            run.transferred.real.iter_mut().for_each(|life| *life -= 31.5);
        }
        let wider = of_second(&results, "C3");
        assert_eq!(wider.verdict, Verdict::Opposed);
        assert!(
            wider
                .reasons
                .iter()
                .any(|reason| reason.starts_with("gap conservative = 0: ") && reason.ends_with(", above 25"))
        );
    }

    /// C13 asks for falls of the peak below 25 in each condition.
    #[test]
    fn the_gap_of_the_peak_is_limited_in_all_conditions() {
        let mut results = results(12);
        for run in results.runs.iter_mut().filter(|run| run.condition == Conservative) {
            run.real[0].peak = run.simulated[GENERATION].peak - 10.0;
        }
        let claim = of_second(&results, "C13");
        assert_eq!((claim.verdict, claim.is_later), (Verdict::Opposed, true));
        assert_eq!(claim.reasons.len(), 2, "{:?}", claim.reasons);
        for run in &mut results.runs {
            run.real[0].peak = run.simulated[GENERATION].peak - 10.0;
        }
        assert_eq!(of_second(&results, "C13").verdict, Verdict::Holds);
        let first = Table::in_edition(MIGLINO1995_CLAIMS, Edition::First);
        assert!(first.claims.iter().all(|claim| claim.id() != "C13"));
    }

    /// C12 needs no study, whatever the clock said.
    #[test]
    fn what_hardware_answers_is_not_judged() {
        let mut results = results(5);
        results.life_within_two_seconds = false;
        let claim = of_second(&results, "C12");
        assert_eq!((claim.verdict, claim.registered), (Verdict::NotJudged, None));
        assert_eq!(claim.reasons, [HARDWARE]);
        assert_eq!(claims(&results, ["C12"])[0].verdict, Verdict::Opposed);
    }

    /// Going to and fro is held against the population's average, 266 here, and not against champions' best.
    #[test]
    fn going_to_and_fro_is_held_against_the_average() {
        let mut results = results(5);
        let mut verdict = |fitness: f32| {
            results.to_and_fro = (0..100_u8).map(|life| fitness + f32::from(life % 3)).collect();
            (of_second(&results, "C10").verdict, claim(&results, "C10").registered)
        };
        assert_eq!(verdict(300.0), (Verdict::Holds, Some(false)));
        // One that scores less opposes nothing.
        assert_eq!(verdict(200.0), (Verdict::Undecided, Some(false)));
    }

    /// Champions whose wheels turn as fast as ever against a wall are slower in reality.
    #[test]
    fn slower_is_by_the_distance_covered() {
        let mut results = results(5);
        for (run, number) in results.runs.iter_mut().zip(0_u8..) {
            run.champion.real.speed = run.champion.simulated.speed;
            run.champion.simulated.length = 3000.0 + f64::from(number);
            run.champion.real.length = 2000.0 - f64::from(number % 3);
        }
        let has = |claim: &Claim, words: &str| claim.reasons.iter().any(|reason| reason.contains(words));
        let [first, second] = [claim(&results, "C9"), of_second(&results, "C9")];
        assert!(
            has(&first, "speed, reality minus simulation, sensor noise"),
            "{:?}",
            first.reasons
        );
        assert!(
            !has(&second, "reality minus simulation, sensor noise: -"),
            "{:?}",
            second.reasons
        );
        let kept = "distance covered, reality minus 0.9 of simulation, conservative noise: ";
        assert!(
            second.verdict == Verdict::Opposed && has(&second, kept),
            "{:?}",
            second.reasons
        );
    }

    /// Ranges are compared by distance and by angle. A drawn robot whose sensors are alike is no evidence, a real one is.
    #[test]
    fn ranges_are_compared_by_distance_and_angle() {
        let results = results(5);
        let judged = |sensors: &SensorTables, is_real_robot| {
            let judging = Judging {
                is_real_robot,
                ..judging(&results, sensors, Edition::Second)
            };
            of(&judging, "C1")
        };
        let own = SensorTables::khepera();
        let mut alike = SensorTables::clone(&own);
        let wall = alike.class("wall").unwrap();
        for readings in alike.classes[wall].readings.chunks_mut(SENSORS) {
            let first = readings[0];
            readings.fill(first);
        }
        let claim = judged(&alike, false);
        assert_eq!((claim.verdict, claim.registered), (Verdict::Undecided, Some(false)));
        assert_eq!(
            claim.reasons[0],
            "distance of half readings: 1.00 times, of 1.46 that can be drawn"
        );
        assert_eq!(
            claim.reasons[1],
            "angle of half readings: 1.00 times, of 1.77 that can be drawn"
        );
        let claim = judged(&alike, true);
        assert_eq!(claim.verdict, Verdict::Opposed);
        let figures: Vec<f64> = judged(&own, true)
            .effects
            .iter()
            .take(6)
            .map(|effect| effect.value)
            .collect();
        assert!(figures[0] > 1.0 && figures[3] > 1.0, "{figures:?}");
        println!("{figures:?}");
        let papers: Vec<Option<f64>> = claim.effects.iter().take(6).map(|effect| effect.paper).collect();
        assert_eq!(papers, [Some(2.0), Some(2.0), None, Some(2.0), Some(2.0), None]);
    }

    /// Without noise champions leave corners against the way that they came, in reality only.
    #[test]
    fn turns_in_corners_are_counted() {
        let mut results = results(8);
        // Into the corner and out of it again, or along both walls.
        let back: Vec<[f32; 2]> = (0..50_u8)
            .map(|cycle| [f32::from(cycle.abs_diff(25)) * 8.0 + 40.0, 40.0])
            .collect();
        let along: Vec<[f32; 2]> = (0..50_u8)
            .map(|cycle| match cycle {
                0..25 => [f32::from(25 - cycle) * 8.0 + 40.0, 40.0],
                _ => [40.0, f32::from(cycle - 25) * 8.0 + 40.0],
            })
            .collect();
        for (run, number) in results.runs.iter_mut().zip(0_u8..) {
            run.champion.real.path = if number % 4 == 3 { along.clone() } else { back.clone() };
            run.champion.simulated.path = along.clone();
        }
        let claim = of_second(&results, "C9");
        let share = |place: &str| {
            let name = format!("fraction of corners left by more than 90 degrees in {place}, no noise");
            claim.effects.iter().find(|effect| effect.name == name).unwrap().value
        };
        assert_eq!((share("reality"), share("simulation")), (0.75, 0.0));
        assert!(
            !claim.reasons.iter().any(|reason| reason.contains("corners left")),
            "{:?}",
            claim.reasons
        );
        for run in &mut results.runs {
            std::mem::swap(&mut run.champion.real.path, &mut run.champion.simulated.path);
        }
        let claim = of_second(&results, "C9");
        assert!(claim.verdict == Verdict::Opposed && claim.registered == Some(false));
        assert!(
            claim.reasons[0].starts_with("fraction of corners left"),
            "{:?}",
            claim.reasons
        );
    }

    /// More runs may decide a claim, but not the other way round.
    #[test]
    fn no_verdict_turns_round_with_more_runs() {
        let counts = [5, 8, 12].map(|runs| all(&results(runs)));
        let mut decided = 0;
        for (few, (more, many)) in counts[0].iter().zip(counts[1].iter().zip(&counts[2])) {
            let found = [few.verdict, more.verdict, many.verdict];
            assert!(
                !(found.contains(&Verdict::Holds) && found.contains(&Verdict::Opposed)),
                "{}: {found:?}",
                few.id
            );
            decided += usize::from(many.verdict != Verdict::Undecided);
        }
        assert!(decided >= 6, "{decided}");
    }

    /// Means that differ in the right direction, by much less than runs do.
    #[test]
    fn a_criterion_that_is_met_by_signs_alone_is_undecided() {
        let mut results = results(5);
        let of_none: Vec<Vec<f32>> = results
            .runs
            .iter()
            .filter(|run| run.condition == Without)
            .map(|run| run.transferred.real.clone())
            .collect();
        for (condition, more) in [(Without, 0.0), (Sensor, -0.1), (Conservative, 0.1)] {
            let of_condition = results.runs.iter_mut().filter(|run| run.condition == condition);
            for (run, (number, real)) in of_condition.zip((0_u8..).zip(&of_none)) {
                run.transferred.real = real.iter().map(|life| life + 20.0 * f32::from(number) + more).collect();
            }
        }
        let conservative = claim(&results, "C5");
        assert_eq!(
            (conservative.registered, conservative.verdict),
            (Some(true), Verdict::Undecided)
        );
        let reasons = &conservative.reasons;
        assert!(
            reasons
                .iter()
                .all(|reason| reason.contains("average in reality") && reason.contains(" spans 0")),
            "{reasons:?}"
        );
    }

    /// Each part of each claim has its condition the right way round: the paper's statement holds, and its contrary is opposed.
    #[test]
    fn contraries_are_opposed() {
        let as_published = results(40);
        let mut contrary = as_published.clone();
        // None and conservative noise change places.
        for run in &mut contrary.runs {
            run.condition = match run.condition {
                Without => Conservative,
                Sensor => Sensor,
                Conservative => Without,
            };
        }
        let ids = ["C3", "C5", "C8"];
        for claim in claims(&as_published, ids) {
            assert_eq!(claim.verdict, Verdict::Holds, "{}: {:?}", claim.id, claim.reasons);
        }
        for Claim {
            id, verdict, reasons, ..
        } in claims(&contrary, ids)
        {
            assert_eq!(verdict, Verdict::Opposed, "{id}: {reasons:?}");
            let is_beyond = |reason: &String| reason.contains(", below 0") || reason.contains(", above 0.2");
            assert!(reasons.iter().all(is_beyond), "{id}: {reasons:?}");
        }
    }

    #[test]
    fn sets_of_different_runs_spread() {
        let once = of_sets(&claim(&results(12), "C3"));
        assert_eq!(once, of_sets(&claim(&results(12), "C3")), "the same sets each time");
        let figures: Vec<f64> = once.iter().map(|(_, value)| *value).collect();
        for condition in figures[..12].chunks(4) {
            let [median, low, high, share] = condition else {
                unreachable!()
            };
            assert!(
                low < median && median < high && (0.0..=1.0).contains(share),
                "{condition:?}"
            );
        }
    }
}
