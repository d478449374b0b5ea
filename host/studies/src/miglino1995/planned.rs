//! The chances of five runs of one robot: the second edition's outcomes over 30 robots whose bodies slide, at the calibrated
//! severities, and how often five of the eight runs of one of these robots give them.
//! `experiments/miglino1995/planned.toml` has the figures, and a test makes them from `studies/miglino1995/second/slide`.

use std::sync::LazyLock;

use oneiro_statistics::Interval;
use serde::{Deserialize, Serialize};

use crate::claims::Power;
use crate::verdict::Verdict;

/// A contrast over all robots.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Measured {
    name: String,
    pub(super) estimate: f64,
    low: f64,
    high: f64,
    outcome: Verdict,
    /// The fraction of sets of five runs of one robot whose interval has the same outcome.
    pub(super) chance: f64,
}

impl Measured {
    pub(super) fn interval(&self) -> Interval {
        Interval {
            low: self.low,
            high: self.high,
        }
    }
}

/// A claim over all robots.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct OfClaim {
    id: String,
    #[serde(flatten)]
    power: Power,
}

/// All figures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Planned {
    contrasts: Vec<Measured>,
    claims: Vec<OfClaim>,
}

/// The compiled-in figures.
pub(super) static PLANNED: LazyLock<Planned> =
    LazyLock::new(|| toml::from_str(oneiro_experiments::MIGLINO1995_PLANNED).expect("a test has read it"));

impl Planned {
    pub(super) fn contrast(&self, name: &str) -> Option<&Measured> {
        self.contrasts.iter().find(|contrast| contrast.name == name)
    }

    pub(super) fn claim(&self, id: &str) -> Option<Power> {
        self.claims.iter().find(|claim| claim.id == id).map(|claim| claim.power)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::path::Path;

    use super::super::second::{self, Runs, Trio};
    use super::*;

    const FEW: usize = 5;

    /// All sets of five of a robot's runs.
    fn sets(runs: &[Trio]) -> Vec<Vec<Trio>> {
        let chosen = (0_u32..1 << runs.len()).filter(|set| set.count_ones() as usize == FEW);
        let set = |set: u32| {
            let kept = (0..runs.len()).filter(|run| set >> run & 1 == 1);
            kept.map(|run| runs[run]).collect()
        };
        chosen.map(set).collect()
    }

    fn rounded(share: f64) -> f64 {
        (share * 1e6).round() / 1e6
    }

    /// The fractions of outcomes that hold, are undecided, and are opposed.
    fn shares(outcomes: impl Iterator<Item = Verdict>) -> [f64; 3] {
        let outcomes: Vec<Verdict> = outcomes.collect();
        [Verdict::Holds, Verdict::Undecided, Verdict::Opposed].map(|verdict| {
            let count = outcomes.iter().filter(|outcome| **outcome == verdict).count();
            rounded(count as f64 / outcomes.len() as f64)
        })
    }

    /// The figures of the claims that are wanted.
    fn made(runs: &Runs, is_wanted: fn(&str) -> bool) -> Planned {
        let mut robots: BTreeMap<&str, Vec<Trio>> = BTreeMap::new();
        for ((robot, _), trio) in runs {
            robots.entry(robot).or_default().push(*trio);
        }
        let sets: Vec<Vec<Trio>> = robots.values().flat_map(|runs| sets(runs)).collect();
        let (mut contrasts, mut claims) = (Vec::<Measured>::new(), Vec::new());
        let all = second::of_all_robots(runs).into_iter();
        for (claim, verdict, of_claim) in all.filter(|(claim, ..)| is_wanted(claim)) {
            // The outcomes of each set's contrasts; the claim's is the worst.
            let outcomes: Vec<Vec<Verdict>> = sets
                .iter()
                .map(|set| {
                    second::of_one_robot(claim, set)
                        .iter()
                        .map(|shown| shown.part.verdict)
                        .collect()
                })
                .collect();
            let [holds, undecided, opposed] = shares(outcomes.iter().filter_map(|of_set| of_set.iter().max().copied()));
            claims.push(OfClaim {
                id: claim.to_owned(),
                power: Power {
                    verdict,
                    sets: sets.len() as u32,
                    holds,
                    undecided,
                    opposed,
                },
            });
            for (place, (name, figures, outcome)) in of_claim.into_iter().enumerate() {
                if contrasts.iter().any(|known| known.name == name) {
                    continue;
                }
                let [holds, undecided, opposed] = shares(outcomes.iter().map(|of_set| of_set[place]));
                let [estimate, low, high] = figures.map(|figure| (figure * 10.0).round() / 10.0);
                contrasts.push(Measured {
                    name: name.to_owned(),
                    estimate,
                    low,
                    high,
                    outcome,
                    chance: match outcome {
                        Verdict::Holds => holds,
                        Verdict::Opposed => opposed,
                        _ => undecided,
                    },
                });
            }
        }
        Planned { contrasts, claims }
    }

    /// A change of the runs or of the judging has its figures written next to the old ones.
    #[test]
    fn the_figures_are_those_of_the_runs() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let runs = second::runs_of(&root.join("studies/miglino1995/second/slide/results.csv"));
        assert_eq!(runs.len(), 30 * 8);
        let made = made(&runs, |_| true);
        if made != *PLANNED {
            let words = "# What five runs of one robot can show of the second edition's contrasts and claims: each over 30 robots whose bodies\n\
                         # slide, at the calibrated severities, and the fraction of all sets of five of the eight runs of one of these\n\
                         # robots that have an outcome by 95 % intervals. A test makes this file from studies/miglino1995/second/slide.\n\n";
            let text = words.to_owned() + &toml::to_string(&made).unwrap();
            std::fs::write(root.join("experiments/miglino1995/planned.toml.new"), text).unwrap();
            panic!("experiments/miglino1995/planned.toml is not what the runs give; see planned.toml.new beside it");
        }
    }

    /// Five runs show a difference that is far larger than its spread, and none that is far smaller.
    #[test]
    fn power_grows_with_the_effect() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let mut runs = second::runs_of(&root.join("studies/miglino1995/second/slide/results.csv"));
        let of = |runs: &Runs| made(runs, |claim| claim == "C6").claim("C6").unwrap();
        let before = of(&runs);
        for [none, sensor, conservative] in runs.values_mut() {
            for run in [none, sensor, conservative] {
                run.last += 300.0;
            }
        }
        let after = of(&runs);
        assert!(before.holds < 0.9 && after.holds == 1.0, "{before:?} {after:?}");
        assert!((before.holds + before.undecided + before.opposed - 1.0).abs() < 2e-6);
    }
}
