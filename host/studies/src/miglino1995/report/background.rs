//! The study's methods and limits, and what it would have cost with the paper's hardware.

use oneiro_report::numbers::{Digits, count, shown};
use oneiro_report::page::{self, Cell, Head, Row, Section, paragraph, table};

use super::{Report, episode_seconds, last_generation, paper, runs_of};
use crate::file::Edition;
use crate::miglino1995::results::Condition;
use crate::{assumptions, verdicts};

const DIGITS: Digits = Digits::Four;
/// Seconds in a day.
const DAY: f64 = 86_400.0;

/// The study's subject, as HTML.
pub(super) const ABOUT: &str = "<p class=\"lead\">\u{201c}Evolving Mobile Robots in Simulated and Real \
     Environments\u{201d}, Artificial Life 2(4), 1995, replicated. A robot is sampled, controllers evolve in the \
     simulator made from the samples, move to reality and evolve on there. The paper asks whether noise in the \
     simulator makes this move succeed; each of its claims is compared with the results.</p>\n";

pub(super) fn methods(study: &Report<'_>) -> Section {
    let results = study.results;
    let runs: Vec<String> = Condition::ALL
        .iter()
        .map(|&condition| format!("{} with {}", runs_of(results, condition).count(), condition.title()))
        .collect();
    let facts = [
        ("robot", study.robot.to_owned()),
        ("runs", runs.join(", ")),
        (
            "generations",
            format!(
                "{} in simulation, then {} in reality: 0 to {}",
                results.simulated_generations,
                results.real_generations,
                last_generation(results)
            ),
        ),
        (
            "individuals",
            format!(
                "{} a generation; the best {} reproduce",
                results.population, results.parents
            ),
        ),
        (
            "an episode",
            format!(
                "{} cycles of 100 ms: {} s",
                results.cycles,
                shown(episode_seconds(results), DIGITS)
            ),
        ),
        ("seed", study.seed.to_string()),
    ];
    let robot = if results.is_wired {
        "A connected robot"
    } else {
        "A surrogate, a simulation that stands in for a real Khepera,"
    };
    let words = format!(
        "{robot} was sampled in front of the arena's objects, and the simulator replays the samples. In each run {} \
         networks of 16 weights and 2 biases evolve for {} generations in the simulator, under one of three \
         conditions: {}. Only the simulator has noise. Generation {} runs in the simulator and in reality, and {} \
         generations are then selected by their fitness in reality, on that robot. Fitness is equation 1 with the choices that \
         the list of assumptions begins with, 500 at most: the paper's own words and its equation do not fit together.",
        results.population,
        results.simulated_generations,
        Condition::ALL.map(Condition::title).join(", "),
        results.simulated_generations,
        results.real_generations,
    );
    let body = [
        paragraph(&words),
        page::facts(&facts),
        super::robot::methods(study),
        verdicts::judging_methods(),
    ];
    Section::new("methods", "Methods", body.concat())
}

/// The limits of the results.
pub(super) fn limits(study: &Report<'_>) -> Section {
    let mut limits = vec![
        match study.edition {
            Edition::First => {
                "One robot, one severity of the differences between simulator and reality, and one rule for collisions stand for all. \
                 The second edition of the study varies them, and contradicts some verdicts of studies like this one \
                 (docs/miglino1995.md)."
            }
            Edition::Second => {
                "One robot and few runs stand for all, and decide little: the chance beside each verdict says how little. Thirty robots, \
                 other collision rules and other severities are in docs/miglino1995.md. No pair of severities met both targets of the \
                 calibration; these repeat paths best."
            }
        },
        "Analyses of variance over individuals, as in Tables 1 and 2, take relatives as independent.",
    ];
    if !study.results.is_wired {
        limits.insert(
            0,
            "Reality is a simulation with differences that are published or assumed, listed below, and no Khepera.",
        );
    }
    let body = [
        page::list(&limits),
        study.arms.map_or_else(String::new, verdicts::by_assumption),
        differences(study),
        assumptions::html(&study.results.assumptions),
    ];
    Section::new("limits", "Limits", body.concat())
}

fn differences(study: &Report<'_>) -> String {
    if study.results.differences.is_empty() {
        return String::new();
    }
    let head = [
        Head::Text("Difference"),
        Head::Number("activation, 0 to 1"),
        Head::Number("displacement, mm"),
        Head::Number("turn, degrees"),
    ];
    let rows: Vec<Row> = study
        .results
        .differences
        .iter()
        .map(|difference| {
            let number = |x| Cell::number(shown(x, Digits::Three));
            Row::from(vec![
                Cell::text(&difference.name),
                number(difference.activation),
                number(difference.displacement),
                number(difference.turn),
            ])
        })
        .collect();
    let words = "Root mean square change of the sensors' activations, of the place and of the heading after one \
                 cycle, over episodes of random controllers, with only one difference switched on.";
    format!(
        "<h3>Differences between reality and the simulator</h3>\n{}",
        table("", words, &head, &rows)
    )
}

/// Episodes, and their duration at the paper's rates.
struct Bill {
    what: &'static str,
    simulated: u64,
    real: u64,
    cycles: f64,
}

/// The episodes' cost with the paper's hardware.
pub(super) fn cost(study: &Report<'_>) -> String {
    let results = study.results;
    let episodes = |generations: fn(&super::Run) -> usize| -> u64 {
        let generations: usize = results.runs.iter().map(generations).sum();
        generations as u64 * u64::from(results.population)
    };
    let bills = [
        Bill {
            what: "the paper",
            simulated: paper::RUNS * paper::SIMULATED_GENERATIONS * paper::POPULATION,
            real: paper::RUNS * paper::REAL_GENERATIONS * paper::POPULATION,
            cycles: paper::CYCLES,
        },
        Bill {
            what: "this study",
            simulated: episodes(|run| run.simulated.len()),
            real: episodes(|run| run.real.len()),
            cycles: f64::from(results.cycles),
        },
    ];
    let rows: Vec<Row> = bills.iter().map(|bill| Row::from(bill.cells())).collect();
    let head = [
        Head::Text("Whose"),
        Head::Number("simulated episodes"),
        Head::Number("workstation time"),
        Head::Number("real episodes"),
        Head::Number("robot time"),
        Head::Number("cycles in all"),
    ];
    let [papers, _] = &bills;
    let (simulated, real) = papers.seconds();
    format!(
        "{}{}",
        paragraph(&format!(
            "An episode took the paper's authors about {} s on an IBM RISC/6000 and {} s on the robot, {} times as \
             long. Their {} runs of {} and {} generations of {} individuals are {} days of workstation time and {} \
             days of robot time.",
            paper::SIMULATED_EPISODE,
            paper::REAL_EPISODE,
            paper::REAL_EPISODE / paper::SIMULATED_EPISODE,
            paper::RUNS,
            paper::SIMULATED_GENERATIONS,
            paper::REAL_GENERATIONS,
            paper::POPULATION,
            days(simulated),
            days(real),
        )),
        table(
            "",
            "The generations' episodes at the paper's rates, without further tests. Here the transferred generation is \
             counted in both, since Table 1 compares it in both; the paper's numbers of generations count it once.",
            &head,
            &rows
        )
    )
}

impl Bill {
    /// Seconds on a workstation and on a robot.
    fn seconds(&self) -> (f64, f64) {
        let episodes = self.cycles / paper::CYCLES;
        (
            self.simulated as f64 * episodes * paper::SIMULATED_EPISODE,
            self.real as f64 * episodes * paper::REAL_EPISODE,
        )
    }

    fn cells(&self) -> Vec<Cell> {
        let (simulated, real) = self.seconds();
        let cycles = (self.simulated + self.real) as f64 * self.cycles;
        let number = |html: String| Cell::number(html);
        vec![
            Cell::text(self.what),
            number(count(self.simulated)),
            number(format!("{} days", days(simulated))),
            number(count(self.real)),
            number(format!("{} days", days(real))),
            number(count(cycles as u64)),
        ]
    }
}

/// Formats seconds as days, to a tenth.
fn days(seconds: f64) -> String {
    format!("{:.1}", seconds / DAY)
}
