//! Judges the claims of the paper by the criteria of `docs/preregistration-1995.md`.

use oneiro::tables::{GREATEST_READING, SENSORS, SensorTable, SensorTables};
use rand_pcg::Pcg64;

use super::results::{Condition, Controls, Family, Level, Results, Run, Variant};
use crate::statistics::{
    anova, cohens_d, holm, mean, median, paired_t, quantile, random_intercept, student_t, subset, variance,
};
use crate::studies::claims::{Claim, Effect, Test, Verdict};

use Condition::{Conservative, None as Without, Sensor};

/// Tests over runs have this in their names; Holm's correction is over them.
const RUNS: &str = ": runs, ";

/// Runs of a condition in the paper, whose F has 1 and 998 degrees of freedom for it.
const PAPERS_RUNS: usize = 5;
/// So many sets of five are drawn out of more runs.
const SETS: usize = 2000;
/// What such sets are for.
const OF_SETS: &str = "Sets of five runs, drawn out of all, show what a study of the paper's size would find; of all runs pooled any \
     difference is significant";
/// The paper's level of significance.
const LEVEL: f64 = 0.01;

/// Every claim, C1 to C12.
pub(crate) fn judge(results: &Results, sensors: &SensorTables) -> Vec<Claim> {
    let study = Judged { results };
    let mut claims = vec![
        study.sensors_differ(sensors),
        study.quick_rise(),
        study.transfer_gap(),
        study.peak_and_average(),
        study.conservative(),
        study.evolving_on(),
        study.recovery(),
        study.paths(),
        study.behaviour(),
        study.deceptive_optimum(),
        study.parameters(),
        study.cost(),
    ];
    correct(&mut claims);
    claims
}

/// Holm's correction over all tests of runs.
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

fn effect(name: impl Into<String>, value: f64, paper: Option<f64>) -> Effect {
    Effect {
        name: name.into(),
        value,
        paper,
    }
}

fn verdict(holds: bool) -> Verdict {
    if holds {
        Verdict::Reproduced
    } else {
        Verdict::NotReproduced
    }
}

fn widened(values: &[f32]) -> impl Iterator<Item = f64> + '_ {
    values.iter().map(|&value| f64::from(value))
}

fn mean_of(values: &[f32]) -> f64 {
    mean(&widened(values).collect::<Vec<_>>())
}

/// A remark, and what sets of runs are for where there are figures of them.
fn with_sets(remark: &str, figures: &[Effect]) -> String {
    if figures.is_empty() {
        remark.to_owned()
    } else {
        format!("{remark}. {OF_SETS}")
    }
}

/// All individuals of some runs.
fn pooled(runs: &[&Run], lives: Lives) -> Vec<f64> {
    runs.iter().flat_map(|run| widened(lives(run))).collect()
}

/// C3's order of the sizes of d: no noise, sensor noise, conservative noise.
fn in_order([none, sensor, conservative]: [f64; 3]) -> bool {
    sensor > none && none > conservative
}

/// C3's criterion.
fn in_order_and_small(sizes: [f64; 3]) -> bool {
    in_order(sizes) && sizes[2] < 0.2
}

/// One of a run's controls.
type Control = fn(&Controls) -> f64;

/// One of a champion's sums of distances.
type Sums = fn(&Run) -> &Vec<f64>;

/// Which fitness of a run's individuals.
type Lives = fn(&Run) -> &[f32];

const SIMULATED: Lives = |run| &run.transferred.simulated;
const QUIET: Lives = |run| &run.transferred.quiet;
const REAL: Lives = |run| &run.transferred.real;
const LAST: Lives = |run| &run.last;

struct Judged<'a> {
    results: &'a Results,
}

impl Judged<'_> {
    fn runs(&self, condition: Condition) -> impl Iterator<Item = &Run> + Clone {
        self.results.runs.iter().filter(move |run| run.condition == condition)
    }

    /// A figure of each run of a condition.
    fn each(&self, condition: Condition, figure: impl Fn(&Run) -> f64) -> Vec<f64> {
        self.runs(condition).map(figure).collect()
    }

    /// The mean of a figure over a condition's runs.
    fn mean(&self, condition: Condition, figure: impl Fn(&Run) -> f64) -> f64 {
        mean(&self.each(condition, figure))
    }

    /// All individuals of a condition's runs.
    fn pooled(&self, condition: Condition, lives: Lives) -> Vec<f64> {
        pooled(&self.runs(condition).collect::<Vec<_>>(), lives)
    }

    /// d of all individuals, one life against another.
    fn d(&self, condition: Condition, one: Lives, other: Lives) -> f64 {
        cohens_d(&self.pooled(condition, one), &self.pooled(condition, other)).unwrap_or(f64::NAN)
    }

    /// The paper's analysis of variance over individuals, the same question of runs, and a mixed model.
    fn compared(&self, condition: Condition, what: &str, one: Lives, other: Lives) -> Vec<Test> {
        let title = condition.title();
        let mut tests = Vec::new();
        let (a, b) = (self.pooled(condition, one), self.pooled(condition, other));
        if let Ok(all) = anova(&[&a, &b]) {
            tests.push(Test {
                name: format!("{title}, {what}: individuals, one-way analysis of variance"),
                statistic: "F".into(),
                value: all.f,
                degrees_of_freedom: vec![all.df_between, all.df_within],
                p: all.p.value,
                p_holm: None,
            });
        }
        let means = |lives: Lives| self.each(condition, |run| mean_of(lives(run)));
        if let Ok(runs) = paired_t(&means(one), &means(other)) {
            tests.push(Test {
                name: format!("{title}, {what}{RUNS}paired t of the means"),
                statistic: "t".into(),
                value: runs.t,
                degrees_of_freedom: vec![runs.df],
                p: runs.p.value,
                p_holm: None,
            });
        }
        let mut rows = (Vec::new(), Vec::new(), Vec::new());
        for (group, run) in self.runs(condition).enumerate() {
            for (x, lives) in [(0.0, other), (1.0, one)] {
                for y in widened(lives(run)) {
                    rows.0.push(x);
                    rows.1.push(y);
                    rows.2.push(group);
                }
            }
        }
        if let Ok(model) = random_intercept(&rows.0, &rows.1, &rows.2) {
            tests.push(Test {
                name: format!("{title}, {what}: mixed model, runs as random intercepts"),
                statistic: "z".into(),
                value: model.z,
                degrees_of_freedom: Vec::new(),
                p: model.p.value,
                p_holm: None,
            });
        }
        tests
    }

    /// Sets of as many runs as the paper has, drawn without putting back out of a condition's: always the same ones.
    /// None where there are no more runs than that.
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

    /// What the paper's analysis of variance comes to in sets of five runs. Of all runs pooled it would find any
    /// difference significant.
    fn paper_sized(&self, condition: Condition, papers: f64, one: Lives, other: Lives) -> Vec<Effect> {
        let anovas: Vec<_> = self
            .sets(condition)
            .iter()
            .filter_map(|set| anova(&[&pooled(set, one), &pooled(set, other)]).ok())
            .collect();
        let Some(first) = anovas.first() else {
            return Vec::new();
        };
        let name = |what: &str| {
            format!(
                "F({}, {}) of {PAPERS_RUNS} runs, {}: {what}",
                first.df_between,
                first.df_within,
                condition.title()
            )
        };
        let fs: Vec<f64> = anovas.iter().map(|anova| anova.f).collect();
        let significant = anovas.iter().filter(|anova| anova.p.value < LEVEL).count();
        vec![
            effect(name(&format!("median of {SETS} sets")), median(&fs), Some(papers)),
            effect(name(&format!("5 % quantile of {SETS} sets")), quantile(&fs, 0.05), None),
            effect(
                name(&format!("95 % quantile of {SETS} sets")),
                quantile(&fs, 0.95),
                None,
            ),
            effect(
                name(&format!("share of {SETS} sets with p < {LEVEL}")),
                significant as f64 / anovas.len() as f64,
                None,
            ),
        ]
    }

    /// In how many sets of five runs the gaps of C3 come in its order, and in how many its criterion holds: how often a
    /// study of the paper's size would say so.
    fn power(&self) -> Vec<Effect> {
        let gaps = Condition::ALL.map(|condition| -> Vec<f64> {
            let gap =
                |set: &Vec<&Run>| cohens_d(&pooled(set, SIMULATED), &pooled(set, REAL)).map_or(f64::NAN, f64::abs);
            self.sets(condition).iter().map(gap).collect()
        });
        let sets = gaps.iter().map(Vec::len).min().unwrap_or(0);
        if sets == 0 {
            return Vec::new();
        }
        let share = |holds: fn([f64; 3]) -> bool| {
            let held = (0..sets)
                .filter(|&set| holds(gaps.each_ref().map(|own| own[set])))
                .count();
            held as f64 / sets as f64
        };
        let name = |what: &str| format!("share of {sets} sets of {PAPERS_RUNS} runs a condition in which {what}");
        vec![
            effect(name("the order holds"), share(in_order), None),
            effect(name("the criterion holds"), share(in_order_and_small), None),
        ]
    }

    /// One figure of the runs of two conditions.
    fn between(&self, name: &str, conditions: [Condition; 2], figure: impl Fn(&Run) -> f64) -> Option<Test> {
        let [a, b] = conditions.map(|condition| self.each(condition, &figure));
        let test = student_t(&a, &b).ok()?;
        Some(Test {
            name: format!(
                "{} against {}, {name}{RUNS}t",
                conditions[0].title(),
                conditions[1].title()
            ),
            statistic: "t".into(),
            value: test.t,
            degrees_of_freedom: vec![test.df],
            p: test.p.value,
            p_holm: None,
        })
    }

    fn sensors_differ(&self, sensors: &SensorTables) -> Claim {
        let gaps = sensors
            .class("wall")
            .map(|wall| half_gaps(&sensors.classes[wall]))
            .unwrap_or_default();
        let least = gaps.iter().copied().fold(f64::INFINITY, f64::min);
        let most = gaps.iter().copied().fold(0.0, f64::max);
        let ratio = most / least;
        let loss = self.mean(Without, |run| {
            mean_of(&run.transferred.real) - mean_of(&run.transferred.other_robot)
        });
        let own = self.each(Without, |run| mean_of(&run.transferred.real));
        let other = self.each(Without, |run| mean_of(&run.transferred.other_robot));
        let test = paired_t(&own, &other).ok().map(|test| Test {
            name: format!("no noise, own robot against another{RUNS}paired t of the means"),
            statistic: "t".into(),
            value: test.t,
            degrees_of_freedom: vec![test.df],
            p: test.p.value,
            p_holm: None,
        });
        Claim {
            id: "C1".into(),
            statement: "The sensors of one robot differ strongly, and so two robots do very differently in the same place".into(),
            criterion: "The greatest gap of half readings of a wall is at least 1.4 times the least, and generation 200 without noise does worse in another robot than in its own".into(),
            verdict: verdict(ratio >= 1.4 && loss > 0.0),
            effects: vec![
                effect("greatest over least gap of half readings", ratio, Some(2.0)),
                effect("fitness in its own robot minus in another, mean over runs", loss, None),
            ],
            tests: test.into_iter().collect(),
            remark: "The paper's 2 is \"nearly twice\" of two neighbouring sensors; recordings of another Khepera have 1.46. On a surrogate whose sensors are drawn from that range the ratio holds nearly by construction".into(),
        }
    }

    fn quick_rise(&self) -> Claim {
        let mut holds = true;
        let mut effects = Vec::new();
        for condition in Condition::ALL {
            let rises = self
                .runs(condition)
                .all(|run| match (run.simulated.first(), run.simulated.last()) {
                    (Some(first), Some(last)) => last.peak > first.peak,
                    _ => false,
                });
            holds &= rises && self.runs(condition).next().is_some();
            for (name, figure) in [
                ("peak", (|level| level.peak) as fn(&Level) -> f64),
                ("average", |level| level.average),
            ] {
                let at = |generation: usize| {
                    self.mean(condition, |run| run.simulated.get(generation).map_or(f64::NAN, figure))
                };
                let last = self.results.simulated_generations as usize;
                let gained = (at(last / 2) - at(0)) / (at(last) - at(0));
                holds &= gained > 0.8;
                effects.push(effect(
                    format!(
                        "share of the {name}'s gain by generation {}, {}",
                        last / 2,
                        condition.title()
                    ),
                    gained,
                    None,
                ));
            }
        }
        Claim {
            id: "C2".into(),
            statement: "In all conditions performance rises quickly in simulation, then levels".into(),
            criterion: "In every run the peak of generation 200 is above that of generation 0, and more than 80 % of the mean gain of peak and average is there by generation 100".into(),
            verdict: verdict(holds),
            effects,
            tests: Vec::new(),
            remark: "A mean of single generations; the average moves by some per cent from one to the next".into(),
        }
    }

    fn transfer_gap(&self) -> Claim {
        let papers = [(0.81, 164.14), (1.48, 549.79), (0.05, 0.74)];
        let ds = Condition::ALL.map(|condition| self.d(condition, SIMULATED, REAL));
        let mut paper_sized = Vec::new();
        let mut effects = Vec::new();
        let mut tests = Vec::new();
        for ((condition, d), (paper, papers_f)) in Condition::ALL.into_iter().zip(ds).zip(papers) {
            let title = condition.title();
            effects.push(effect(format!("d, {title}, noise as evolved"), d, Some(paper)));
            effects.push(effect(
                format!("d, {title}, noise off in both"),
                self.d(condition, QUIET, REAL),
                None,
            ));
            paper_sized.extend(self.paper_sized(condition, papers_f, SIMULATED, REAL));
            tests.extend(self.compared(condition, "simulated and real", SIMULATED, REAL));
        }
        let remark = "As in the paper, noise is on in simulation and off in reality, which makes part of the gap by itself; noise off in both is the reality gap proper. The severity of reality was calibrated on the first of these figures, on other robots";
        let remark = with_sets(remark, &paper_sized);
        effects.extend(paper_sized);
        effects.extend(self.power());
        for condition in [Sensor, Conservative] {
            tests.extend(self.compared(condition, "simulated without noise and real", QUIET, REAL));
        }
        Claim {
            id: "C3".into(),
            statement: "At generation 200 fitness in simulation and reality differs without noise and with sensor noise, and not with conservative noise".into(),
            criterion: "As evolved, of all individuals: |d| of sensor noise > no noise > conservative noise, and that below 0.2".into(),
            verdict: verdict(in_order_and_small(ds.map(f64::abs))),
            effects,
            tests,
            remark,
        }
    }

    fn peak_and_average(&self) -> Claim {
        let drop = |figure: fn(&Level) -> f64| {
            move |run: &Run| match (run.simulated.last(), run.real.first()) {
                (Some(simulated), Some(real)) => figure(simulated) - figure(real),
                _ => f64::NAN,
            }
        };
        let (peak, average) = (drop(|level| level.peak), drop(|level| level.average));
        let figures = [Without, Sensor].map(|condition| (self.mean(condition, peak), self.mean(condition, average)));
        let [(peak_none, average_none), (peak_sensor, average_sensor)] = figures;
        let again = |condition| self.mean(condition, |run| best_again(run, self.results.parents as usize));
        let tests = [
            self.between("fall of the peak", [Without, Sensor], peak),
            self.between("fall of the average", [Without, Sensor], average),
        ];
        Claim {
            id: "C4".into(),
            statement: "With sensor noise the peak falls less than without noise, although the average falls more".into(),
            criterion: "From simulation to reality the mean peak falls less and the mean average falls more".into(),
            verdict: verdict(peak_sensor < peak_none && average_sensor > average_none),
            effects: vec![
                effect("fall of the peak, no noise", peak_none, None),
                effect("fall of the peak, sensor noise", peak_sensor, None),
                effect("fall of the average, no noise", average_none, None),
                effect("fall of the average, sensor noise", average_sensor, None),
                effect("the best 20 in simulation, their second real life below their second simulated one, no noise", again(Without), None),
                effect("the same, sensor noise", again(Sensor), None),
            ],
            tests: tests.into_iter().flatten().collect(),
            remark: "A peak is ranked within each environment and so partly luck; the last two figures follow the same 20 individuals through lives that they were not chosen by".into(),
        }
    }

    fn conservative(&self) -> Claim {
        let simulated = Condition::ALL.map(|condition| self.mean(condition, |run| mean_of(SIMULATED(run))));
        let real = Condition::ALL.map(|condition| self.mean(condition, |run| mean_of(REAL(run))));
        let lower = simulated[2] < simulated[0] && simulated[2] < simulated[1];
        let higher = real[2] > real[0] && real[2] > real[1];
        let mut effects = Vec::new();
        for (name, values) in [("in simulation", simulated), ("in reality", real)] {
            for (condition, value) in Condition::ALL.into_iter().zip(values) {
                effects.push(effect(
                    format!("average of generation 200 {name}, {}", condition.title()),
                    value,
                    None,
                ));
            }
        }
        let tests = [Without, Sensor].into_iter().flat_map(|other| {
            [
                self.between("average in simulation", [Conservative, other], |run| {
                    mean_of(SIMULATED(run))
                }),
                self.between("average in reality", [Conservative, other], |run| mean_of(REAL(run))),
            ]
        });
        Claim {
            id: "C5".into(),
            statement: "With conservative noise fitness is somewhat lower in simulation, and higher in reality".into(),
            criterion: "Its average of generation 200 is below both others in simulation and above both in reality"
                .into(),
            verdict: verdict(lower && higher),
            effects,
            tests: tests.flatten().collect(),
            remark: String::new(),
        }
    }

    fn evolving_on(&self) -> Claim {
        let papers = [0.54, 0.35, 0.32];
        let paper_sized = Condition::ALL
            .into_iter()
            .zip([74.09, 30.74, 26.01])
            .flat_map(|(condition, f)| self.paper_sized(condition, f, LAST, REAL))
            .collect::<Vec<_>>();
        let remark = "Generation 200 is mutated from parents that were selected in simulation, 219 from such that were selected in reality";
        let remark = with_sets(remark, &paper_sized);
        let ds = Condition::ALL.map(|condition| self.d(condition, LAST, REAL));
        let mut controls = Vec::new();
        for condition in Condition::ALL {
            let title = condition.title();
            let figures: [(&str, Control); 3] = [
                ("had all generations been simulated", |controls| controls.simulated_on),
                ("had the last parents been drawn by lot", |controls| controls.neutral),
                ("of 20 generations in reality from random genes", |controls| {
                    controls.from_random
                }),
            ];
            for (name, figure) in figures {
                let own: Vec<f64> = self
                    .runs(condition)
                    .filter_map(|run| run.controls.as_ref())
                    .map(figure)
                    .collect();
                if !own.is_empty() {
                    controls.push(effect(
                        format!("real fitness of generation 219 {name}, {title}"),
                        mean(&own),
                        None,
                    ));
                }
            }
            if !controls.is_empty() {
                let own = self.mean(condition, |run| mean_of(LAST(run)));
                controls.push(effect(
                    format!("real fitness of generation 219 as it is, {title}"),
                    own,
                    None,
                ));
            }
        }
        Claim {
            id: "C6".into(),
            statement: "Twenty generations in reality raise real fitness in all conditions".into(),
            criterion: "Real fitness of generation 219 is above that of 200 in all three conditions".into(),
            verdict: verdict(ds.iter().all(|d| *d > 0.0)),
            effects: Condition::ALL
                .into_iter()
                .zip(ds)
                .zip(papers)
                .map(|((condition, d), paper)| {
                    effect(
                        format!("d of generation 219 over 200, {}", condition.title()),
                        d,
                        Some(paper),
                    )
                })
                .chain(paper_sized)
                .chain(controls)
                .collect(),
            tests: Condition::ALL
                .into_iter()
                .flat_map(|condition| self.compared(condition, "generations 219 and 200 in reality", LAST, REAL))
                .collect(),
            remark,
        }
    }

    fn recovery(&self) -> Claim {
        let share = |condition, figure: fn(&Level) -> f64| {
            let at =
                |levels: fn(&Run) -> Option<&Level>| self.mean(condition, |run| levels(run).map_or(f64::NAN, figure));
            let (simulated, first, last) = (
                at(|run| run.simulated.last()),
                at(|run| run.real.first()),
                at(|run| run.real.last()),
            );
            ((simulated - first), (last - first) / (simulated - first), last - first)
        };
        let average: fn(&Level) -> f64 = |level| level.average;
        let peak: fn(&Level) -> f64 = |level| level.peak;
        let (none, sensor, sensor_peak) = (share(Without, average), share(Sensor, average), share(Sensor, peak));
        let (.., rise) = share(Conservative, average);
        let verdict = if none.0 <= 0.0 || sensor.0 <= 0.0 {
            Verdict::Undecided
        } else {
            verdict(none.1 > sensor.1 && sensor_peak.1 > sensor.1 && rise > 0.0)
        };
        Claim {
            id: "C7".into(),
            statement: "Without noise the loss is recovered quickly, with sensor noise only in the peak; with conservative noise there is none, and fitness rises nevertheless".into(),
            criterion: "Share of the average's gap that is recovered by generation 219: no noise above sensor noise; with sensor noise the peak's share above the average's; conservative noise rises".into(),
            verdict,
            effects: vec![
                effect("share of the average's gap recovered, no noise", none.1, None),
                effect("share of the average's gap recovered, sensor noise", sensor.1, None),
                effect("share of the peak's gap recovered, sensor noise", sensor_peak.1, None),
                effect("the average's gap, no noise", none.0, None),
                effect("the average's gap, sensor noise", sensor.0, None),
                effect("the peak's gap, sensor noise", sensor_peak.0, None),
                effect("rise of the average in reality, conservative noise", rise, None),
            ],
            tests: Vec::new(),
            remark: "A share is of no meaning where the gap is small or none".into(),
        }
    }

    fn paths(&self) -> Claim {
        let whole = |sums: fn(&Run) -> &Vec<f64>| move |run: &Run| sums(run).last().copied().unwrap_or(f64::NAN);
        let ends = Condition::ALL.map(|condition| self.mean(condition, whole(|run| &run.champion.discrepancy.paper)));
        let mut effects = Vec::new();
        for (condition, end) in Condition::ALL.into_iter().zip(ends) {
            let title = condition.title();
            effects.push(effect(format!("D after 500 cycles, one start, {title}, mm"), end, None));
            let figures: [(&str, Sums); 3] = [
                ("100 starts", |run| &run.champion.discrepancy.starts),
                ("two real lives, 100 starts", |run| &run.champion.discrepancy.repeated),
                ("unrelated champions, 100 starts", |run| {
                    &run.champion.discrepancy.unrelated
                }),
            ];
            for (name, figure) in figures {
                effects.push(effect(
                    format!("D after 500 cycles, {name}, {title}, mm"),
                    self.mean(condition, whole(figure)),
                    None,
                ));
            }
            let over_length = self.mean(condition, |run| run.champion.discrepancy.per_length);
            effects.push(effect(
                format!("D over the length of the path, 100 starts, {title}"),
                over_length,
                None,
            ));
        }
        let tests = [Without, Sensor].into_iter().filter_map(|other| {
            self.between(
                "D from 100 starts",
                [Conservative, other],
                whole(|run| &run.champion.discrepancy.starts),
            )
        });
        Claim {
            id: "C8".into(),
            statement: "With conservative noise paths in simulation and reality agree far better".into(),
            criterion: "D after 500 cycles from the shared start, mean of the runs: conservative noise below half of either other".into(),
            verdict: verdict(ends[2] < 0.5 * ends[0].min(ends[1])),
            effects,
            tests: tests.collect(),
            remark: "D alone rewards robots that stay on the spot; its share of the path's length does not. Unrelated champions show how large D grows when nothing agrees".into(),
        }
    }

    fn behaviour(&self) -> Claim {
        let share = |condition, which: fn(&Run) -> bool| self.mean(condition, |run| f64::from(u8::from(which(run))));
        let stuck_real = share(Without, |run| run.champion.real.stuck_in_corner);
        let stuck_simulated = share(Without, |run| run.champion.simulated.stuck_in_corner);
        let speed = |condition| {
            self.mean(condition, |run| run.champion.real.speed)
                / self.mean(condition, |run| run.champion.simulated.speed)
        };
        let collided_real = self.mean(Sensor, |run| run.champion.real.collided);
        let collided_simulated = self.mean(Sensor, |run| run.champion.simulated.collided);
        let holds = stuck_real > stuck_simulated
            && speed(Sensor) < 1.0
            && collided_real > collided_simulated
            && (0.9..=1.1).contains(&speed(Conservative));
        Claim {
            id: "C9".into(),
            statement: "In reality champions evolved without noise stick in corners, those with sensor noise go slower and hit things, those with conservative noise do neither".into(),
            criterion: "No noise: more stick in a corner in reality; sensor noise: lower speed and more collisions in reality; conservative noise: speed within 10 %".into(),
            verdict: verdict(holds),
            effects: vec![
                effect("share of champions stuck in a corner in reality, no noise", stuck_real, Some(0.8)),
                effect("share of champions stuck in a corner in simulation, no noise", stuck_simulated, None),
                effect("speed in reality over speed in simulation, sensor noise", speed(Sensor), None),
                effect("share of cycles colliding in reality, sensor noise", collided_real, None),
                effect("share of cycles colliding in simulation, sensor noise", collided_simulated, None),
                effect("speed in reality over speed in simulation, conservative noise", speed(Conservative), None),
            ],
            tests: Vec::new(),
            remark: "The paper names four of five champions that stick (a, b, c and e)".into(),
        }
    }

    fn deceptive_optimum(&self) -> Claim {
        let to_and_fro = mean_of(&self.results.to_and_fro);
        let champions = self.each(Without, |run| {
            let best_life = || widened(SIMULATED(run)).fold(f64::NEG_INFINITY, f64::max);
            run.champion.mean.unwrap_or_else(best_life)
        });
        let middle = median(&champions);
        // One that was chosen by its mean is known by that, as the controller made by hand is.
        let by_mean = self.results.runs.iter().any(|run| run.champion.mean.is_some());
        let fitness = if by_mean {
            "the mean that it was chosen by"
        } else {
            "its best life"
        };
        Claim {
            id: "C10".into(),
            statement: "Going to and fro without turning scores well under the fitness formula".into(),
            criterion: "A controller made by hand that does so scores above the median champion without noise, in the simulator without noise".into(),
            verdict: verdict(to_and_fro > middle),
            effects: vec![
                effect("fitness of going to and fro, mean of 100 lives", to_and_fro, None),
                effect(format!("median champion without noise, {fitness}"), middle, None),
            ],
            tests: Vec::new(),
            remark: "Only where driving backwards pays as forwards does (unsigned V)".into(),
        }
    }

    fn parameters(&self) -> Claim {
        let mut effects = Vec::new();
        let mut interior = Vec::new();
        for (family, noise) in [
            (Family::SensorRange, "sensor noise"),
            (Family::WalkRange, "conservative noise within"),
        ] {
            let own: Vec<&Variant> = self
                .results
                .variants
                .iter()
                .filter(|variant| variant.family == family)
                .collect();
            let means: Vec<f64> = own.iter().map(|variant| mean(&variant.real)).collect();
            for (variant, mean) in own.iter().zip(&means) {
                effects.push(effect(
                    format!("real fitness of generation 200, {noise} {}", variant.name),
                    *mean,
                    None,
                ));
                let spread = variance(&variant.real).sqrt();
                effects.push(effect(
                    format!("its s.d. over runs, {noise} {}", variant.name),
                    spread,
                    None,
                ));
            }
            let best = (0..means.len()).max_by(|&a, &b| means[a].total_cmp(&means[b]));
            interior.extend(best.map(|best| best > 0 && best + 1 < means.len()));
        }
        for variant in self
            .results
            .variants
            .iter()
            .filter(|variant| variant.family == Family::Simulator)
        {
            let name = &variant.name;
            effects.push(effect(
                format!("real fitness of generation 200, simulator from {name}"),
                mean(&variant.real),
                None,
            ));
        }
        let asked = interior.len() == 2;
        Claim {
            id: "C11".into(),
            statement: "Of the noise ranges tried, 0 to 0.4 and 30 mm were best".into(),
            criterion: "Of five ranges of each noise the best, by real fitness of generation 200, is neither the smallest nor the largest".into(),
            verdict: if asked { verdict(interior.iter().all(|interior| *interior)) } else { Verdict::Undecided },
            effects,
            tests: Vec::new(),
            remark: if asked {
                "The paper's second criterion, less dependency on initial seeds, is the s.d. over runs".into()
            } else {
                "Other ranges were not run in this study; `--full` runs them".into()
            },
        }
    }

    fn cost(&self) -> Claim {
        Claim {
            id: "C12".into(),
            statement: "A simulated life takes 2 s, a real one 50 s".into(),
            criterion: "A simulated life takes less than a 25th of the 50 s of a real one".into(),
            verdict: verdict(self.results.life_within_two_seconds),
            effects: vec![effect(
                "seconds of a real life of 500 cycles",
                f64::from(self.results.cycles) * 0.1,
                Some(50.0),
            )],
            tests: Vec::new(),
            remark: "How long it took is told on the terminal and not here, so that equal studies have equal reports"
                .into(),
        }
    }
}

/// How far the best individuals by simulated fitness fall in lives that they were not chosen by.
fn best_again(run: &Run, parents: usize) -> f64 {
    let own = &run.transferred;
    let mut ranking: Vec<usize> = (0..own.simulated.len()).collect();
    ranking.sort_by(|&a, &b| own.simulated[b].total_cmp(&own.simulated[a]).then(a.cmp(&b)));
    ranking.truncate(parents);
    let falls: Vec<f64> = ranking
        .into_iter()
        .map(|individual| f64::from(own.simulated_again[individual]) - f64::from(own.real_again[individual]))
        .collect();
    mean(&falls)
}

/// For each sensor the gap at which its greatest reading of any bearing falls through one half, mm.
fn half_gaps(table: &SensorTable) -> Vec<f64> {
    let half = f64::from(GREATEST_READING) / 2.0;
    let bearings = table.bearings as usize;
    let greatest = |row: usize, sensor: usize| {
        let cells = &table.readings[row * bearings..][..bearings];
        cells.iter().map(|cell| f64::from(cell[sensor])).fold(0.0, f64::max)
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

#[cfg(test)]
mod tests {
    use super::super::report::tests::results;
    use super::*;

    fn claim(results: &Results, id: &str) -> Claim {
        let claims = judge(results, &SensorTables::khepera());
        claims.into_iter().find(|claim| claim.id == id).unwrap()
    }

    fn of_sets(claim: &Claim) -> Vec<(String, f64)> {
        let effects = claim.effects.iter().filter(|effect| effect.name.contains(" sets"));
        effects.map(|effect| (effect.name.clone(), effect.value)).collect()
    }

    /// So many copies of each condition's first run.
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
        for id in ["C3", "C6"] {
            assert_eq!(of_sets(&claim(&results(5), id)), [], "{id}");
        }
    }

    /// Any five of equal runs give the F that five of them give.
    #[test]
    fn sets_of_equal_runs_all_give_the_papers_test() {
        for id in ["C3", "C6"] {
            let five = claim(&copies(5), id);
            let fs: Vec<f64> = five
                .tests
                .iter()
                .filter(|test| test.statistic == "F")
                .map(|test| test.value)
                .take(3)
                .collect();
            let of_sets = of_sets(&claim(&copies(8), id));
            for (condition, f) in Condition::ALL.into_iter().zip(fs) {
                for what in ["median", "5 % quantile", "95 % quantile"] {
                    let name = format!("F(1, 998) of 5 runs, {}: {what} of 2000 sets", condition.title());
                    let (_, value) = of_sets.iter().find(|(own, _)| *own == name).expect(&name);
                    assert!((value - f).abs() < 1e-9 * f, "{id}, {name}: {value}, not {f}");
                }
            }
        }
        let shares: Vec<f64> = of_sets(&claim(&copies(8), "C3"))
            .into_iter()
            .filter(|(name, _)| name.contains("share"))
            .map(|(_, share)| share)
            .collect();
        // The made-up gaps are 60, 110 and 5: two are found and one not, and they come in the order.
        assert_eq!(shares, [1.0, 1.0, 0.0, 1.0, 1.0]);
    }

    /// Going to and fro scores 300 here, single lives of champions score more, and their means less.
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
        assert_eq!(by_life.verdict, Verdict::NotReproduced);
        assert!(by_mean.effects[1].value == 290.0 && by_mean.effects[1].name.ends_with("chosen by"));
        assert_eq!(by_mean.verdict, Verdict::Reproduced);
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
