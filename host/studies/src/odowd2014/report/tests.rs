use oneiro::foraging::Light;
use oneiro::random::pcg4d;
use oneiro_report::page::check::{outside, part, unbalanced};

use super::measures::{self, runs_of};
use super::*;
use crate::claims::{Effect, Test};
use crate::odowd2014::measures::convergence_interval;
use crate::odowd2014::results::{RobotInterval, Run};
use crate::verdict::Verdict;

const MINUTES: u32 = 50;
const ROBOTS: u32 = 10;

/// Fixed sequence of numbers from 0 to 1.
struct Numbers(u32);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 += 1;
        f64::from(pcg4d([self.0, 1, 20, 14])[0]) / f64::from(u32::MAX)
    }

    /// Moves a gene randomly, and a little towards its goal.
    fn gene(&mut self, gene: f64, goal: f64, scale: f64) -> f64 {
        let step = (2.0 * self.next() - 1.0) * scale.min(0.5);
        (gene + 0.08 * (goal - gene) + step).clamp(0.0, 0.99)
    }

    fn run(&mut self, scale: f64, case: Case, kind: Kind, number: u32) -> Run {
        let robots = if kind == Kind::Alone { 1 } else { ROBOTS };
        let light = |minute: u32| case.lights()[usize::from(minute >= MINUTES / 2)];
        let brought = (0..MINUTES * 60).map(|second| {
            let each = match light(second / 60) {
                Light::OverNest => 0.012,
                Light::Nowhere => 0.005,
                Light::OppositeNest => 0.006,
            };
            u16::from(self.next() < each * f64::from(robots))
        });
        let brought = brought.collect();
        let mut genes = vec![[0.5; 3]; robots as usize];
        let intervals = if case == Case::Random { 0 } else { MINUTES };
        let intervals = (0..intervals).map(|minute| {
            let [s0, g0, g1] = match light(minute) {
                _ if kind == Kind::FitnessShuffled => [0.5, 0.5, 0.5],
                Light::OverNest => [0.85, 0.9, 0.1],
                Light::Nowhere => [0.5, 0.5, 0.5],
                Light::OppositeNest => [0.4, 0.2, 0.6],
            };
            let each = genes.iter_mut().map(|values| {
                let before = values[0];
                *values = [(values[0], s0), (values[1], g0), (values[2], g1)]
                    .map(|(gene, goal)| self.gene(gene, goal, scale));
                RobotInterval {
                    s0: values[0] as f32,
                    chosen_under: before as f32,
                    g0: values[1] as f32,
                    g1: values[2] as f32,
                    real: (30.0 * self.next()) as f32,
                    simulated: (minute > 0).then(|| (60.0 * self.next()) as f32),
                    heard: (3.9 * self.next()) as u16,
                    reached: 1 + ((f64::from(robots) - 0.1) * self.next()) as u16,
                    taken: self.next() < 0.4,
                    founder: 0,
                }
            });
            each.collect()
        });
        let intervals = intervals.collect();
        Run {
            case,
            kind,
            number,
            switched_on: vec![0; ROBOTS as usize],
            brought,
            intervals,
        }
    }

    fn combination(&mut self, scale: f64, credit: Credit, kinds: &[Kind], runs: u32) -> Combination {
        let mut all = Vec::new();
        for &kind in kinds {
            for case in Case::ALL {
                if case == Case::Random && kind != Kind::Evolved {
                    continue;
                }
                all.extend((0..runs).map(|number| self.run(scale, case, kind, number)));
            }
        }
        Combination {
            scale,
            credit,
            runs: all,
        }
    }
}

fn of(combinations: Vec<Combination>, runs: u32) -> Results {
    Results {
        combinations,
        robots: ROBOTS,
        minutes: MINUTES,
        light_moves_minute: MINUTES / 2,
        runs,
        generation_within_34_s: true,
        questions: Vec::new(),
    }
}

/// One combination, with the paper's kind of runs and those without selection.
fn small(runs: u32) -> Results {
    let kinds = [Kind::Evolved, Kind::FitnessShuffled];
    of(vec![Numbers(0).combination(0.2, Credit::Matched, &kinds, runs)], runs)
}

/// Two combinations with all kinds.
fn full(runs: u32) -> Results {
    let mut numbers = Numbers(0);
    let combinations = [(0.2, Credit::Lagged), (2.0, Credit::Matched)];
    let combinations = combinations.map(|(scale, credit)| numbers.combination(scale, credit, &Kind::OF_STUDY, runs));
    of(combinations.into(), runs)
}

fn claims() -> Vec<Claim> {
    let table = Table::of(ODOWD2014_CLAIMS);
    let question = |id: &str| table.claims.iter().find(|claim| claim.id() == id).unwrap().question();
    let claim = |number: u32| Claim {
        source: "section 5".into(),
        is_later: false,
        unit: "runs".into(),
        id: format!("D{number}"),
        question: question(&format!("D{number}")).into(),
        statement: format!("What the paper says <{number}> of S0 & its robots."),
        criterion: "The fraction of the right third is above the null's.".into(),
        verdict: match number % 4 {
            0 => Verdict::Opposed,
            3 => Verdict::Undecided,
            _ => Verdict::Holds,
        },
        reasons: Vec::new(),
        registered: None,
        effects: vec![Effect {
            name: "rate, over nest / random".into(),
            value: 2.123_456,
            interval: Some([1.5, 3.0]),
            paper: Some(2.0),
        }],
        power: None,
        tests: vec![Test {
            name: "over against random, minutes".into(),
            statistic: "t".into(),
            value: 4.5,
            degrees_of_freedom: vec![98.0],
            p: 1.3e-5,
            p_holm: None,
        }],
        remark: "Minutes of a run are not independent.".into(),
    };
    (1..=17).map(claim).collect()
}

fn report(results: &Results, claims: &[Claim]) -> String {
    html(&Report {
        results,
        claims,
        foragers: &Swarm::odowd2014(ROBOTS),
        assumptions: &[Assumption {
            name: "light.decay".into(),
            value: "2 <a metre>".into(),
            source: "ARGoS".into(),
        }],
        seed: 7,
        arms: None,
    })
}

#[test]
fn every_figure_of_the_paper_is_there() {
    let html = report(&full(2), &claims());
    for number in 1..=4 {
        assert!(part(&html, "figure", &format!("figure-{number}")).contains("<svg"));
    }
    for combination in ["s-d-0-2-lagged-credit", "s-d-2-matched-credit"] {
        for number in 5..=10 {
            let figure = part(&html, "figure", &format!("figure-{number}-{combination}"));
            assert!(figure.contains("<svg") && figure.contains("In the paper"));
        }
        for table in ["rates", "simulators", "controllers", "encounters", "interventions"] {
            assert!(part(&html, "table", &format!("{table}-{combination}")).contains("<td"));
        }
    }
    for number in 1..=17 {
        assert!(part(&html, "article", &format!("d{number}")).contains("Preregistered"));
    }
    assert!(part(&html, "section", "limits").contains("2 &lt;a metre&gt;"));
    let mut ids: Vec<&str> = html
        .split(" id=\"")
        .skip(1)
        .filter_map(|rest| rest.split('"').next())
        .collect();
    let all = ids.len();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), all, "an id stands twice");
}

/// Each question except the cost of episodes has its claims and something to look at.
#[test]
fn results_stand_by_question() {
    let html = report(&full(2), &claims());
    for (key, question) in Table::of(ODOWD2014_CLAIMS).questions() {
        let section = part(&html, "section", key);
        assert!(
            section.contains(&format!("<h2>{question}</h2>")) && section.contains("<article"),
            "{key}"
        );
        assert_eq!(
            section.contains("<figure") || section.contains("<caption"),
            key != "cost",
            "{key}"
        );
    }
    assert!(part(&html, "section", "moves").contains("figure-10-s-d-2-matched-credit"));
    assert!(
        part(&html, "section", "abstract").contains(
            "<a href=\"#swarm\">Does the evolution need several robots?</a> holds: <a href=\"#d10\">D10</a>."
        )
    );
}

#[test]
fn the_page_is_well_formed_and_needs_nothing_else() {
    for (results, claims) in [(full(2), claims()), (small(1), vec![])] {
        let html = report(&results, &claims);
        assert_eq!(unbalanced(&html), None);
        assert_eq!(outside(&html), None);
        assert!(!html.contains("NaN") && !html.contains("inf<"));
        assert_eq!(html, report(&results, &claims));
    }
}

#[test]
fn sections_are_there_where_their_data_is() {
    let html = report(&small(2), &claims());
    assert!(!html.contains("id=\"sensitivity\"") && !html.contains("Mutations and credit"));
    assert!(report(&full(1), &[]).contains("Mutations and credit"));
    let mut bare = small(2);
    bare.combinations[0]
        .runs
        .retain(|run| run.kind == Kind::Evolved && run.case == Case::Over);
    let html = report(&bare, &[]);
    assert_eq!(unbalanced(&html), None);
    assert!(!html.contains("NaN") && !html.contains("id=\"interventions") && !html.contains("figure-6"));
    assert!(!part(&html, "figure", "figure-7-s-d-0-2-matched-credit").contains("Dashed"));
    let nothing = of(vec![], 0);
    let html = report(&nothing, &[]);
    assert_eq!(unbalanced(&html), None);
    assert!(csv_files(&nothing).iter().all(|(_, text)| text.lines().count() == 1));
    // A run that was cut short in its first minute.
    let mut short = small(1);
    for run in &mut short.combinations[0].runs {
        run.brought.truncate(10);
        run.intervals.clear();
    }
    let html = report(&short, &[]);
    assert_eq!(unbalanced(&html), None);
    assert!(!html.contains("NaN") && html.contains("no data"));
    assert!(csv_files(&short).iter().all(|(_, text)| !text.contains("NaN")));
}

#[test]
fn the_light_s_move_is_marked_where_it_moves() {
    let html = report(&small(1), &[]);
    let marks = |number: u32| {
        let figure = part(&html, "figure", &format!("figure-{number}-s-d-0-2-matched-credit"));
        figure.matches(">the light moves<").count()
    };
    assert_eq!([6, 7, 8, 9, 10].map(marks), [0, 0, 0, 4, 4]);
}

fn run(brought: Vec<u16>) -> Run {
    Run {
        case: Case::Random,
        kind: Kind::Evolved,
        number: 0,
        switched_on: Vec::new(),
        brought,
        intervals: vec![],
    }
}

#[test]
fn rates_are_food_per_minute() {
    // An item every ten seconds, and none after 250 s.
    let first = run((0..500)
        .map(|second| u16::from(second < 250 && second % 10 == 0))
        .collect());
    assert_eq!(first.rates(250), [6.0, 0.0]);
    assert_eq!(first.rates(200), [6.0, 1.5, 0.0], "the last bin is half as long");
    assert_eq!(first.rate(0..9), 3.0);
    assert_eq!(first.rate(4..9), 1.0 * 60.0 / 260.0);
    assert!(first.rate(9..10).is_nan() && first.rate(15..20).is_nan());
    let other = run(vec![1; 130]);
    // The third minute includes 10 s of the other run.
    assert_eq!(measures::minutes([&first, &other].into_iter()), [33.0, 33.0, 33.0]);
}

#[test]
fn shares_are_those_of_thirds() {
    let robot = |s0: f32| RobotInterval {
        s0,
        chosen_under: 0.0,
        g0: 0.99,
        g1: 0.0,
        real: 0.0,
        simulated: None,
        heard: 0,
        reached: 1,
        taken: false,
        founder: 0,
    };
    let robots = [0.0, 0.32, 0.33, 0.65, 0.66, 0.7, 0.8, 0.99].map(robot);
    assert_eq!(measures::shares(&robots, measures::S0), [0.25, 0.25, 0.5]);
    assert_eq!(measures::shares(&robots, measures::G0), [0.0, 0.0, 1.0]);
    assert_eq!(measures::shares(&robots, measures::G1), [1.0, 0.0, 0.0]);
    assert!(measures::shares(&[], measures::S0)[0].is_nan());
    let (mean, deviation) = measures::level(&[robot(0.25), robot(0.75)], measures::S0);
    assert!(mean == 0.5 && (deviation - 0.125_f64.sqrt()).abs() < 1e-12);
    // The end is the last ten of twelve intervals.
    let mut long = run(vec![]);
    long.intervals = (0..12).map(|i| vec![robot(if i < 2 { 0.0 } else { 0.7 })]).collect();
    assert_eq!(
        measures::shares(measures::at_the_end(&long), measures::S0),
        [0.0, 0.0, 1.0]
    );
}

fn records(text: &str) -> Vec<::csv::StringRecord> {
    let mut reader = ::csv::Reader::from_reader(text.as_bytes());
    reader
        .records()
        .map(|record| record.expect("as many fields as columns"))
        .collect()
}

fn field(record: &::csv::StringRecord, place: usize) -> f64 {
    record[place].parse().unwrap_or_else(|_| panic!("{record:?} {place}"))
}

#[test]
fn csv_rows_add_up_to_the_data() {
    let results = full(2);
    let files: std::collections::BTreeMap<_, _> = csv_files(&results).into_iter().collect();
    let all_runs: Vec<&Run> = results.combinations.iter().flat_map(|one| &one.runs).collect();
    let food: u64 = all_runs.iter().map(|run| measures::total(&run.brought)).sum();
    let sum = |rows: &[::csv::StringRecord], place| rows.iter().map(|row| field(row, place)).sum::<f64>();

    let runs = records(&files["runs.csv"]);
    assert_eq!(runs.len(), all_runs.len());
    assert_eq!(sum(&runs, 5), food as f64);
    assert_eq!(sum(&runs, 6) + sum(&runs, 7), food as f64);
    assert_eq!(
        &runs[0].iter().take(5).collect::<Vec<_>>()[..],
        ["0.2", "lagged", "no-light", "evolved", "0"]
    );
    let random = runs.iter().find(|row| &row[2] == "random").expect("the control");
    assert!(random.iter().skip(8).all(str::is_empty), "nothing evolves");

    let rates = records(&files["rates.csv"]);
    assert_eq!(rates.len(), 12 * all_runs.len());
    assert_eq!(sum(&rates, 7), food as f64);

    let intervals = records(&files["intervals.csv"]);
    let evolved = all_runs.iter().filter(|run| run.kind == Kind::Evolved);
    let robots: usize = evolved.flat_map(|run| &run.intervals).map(Vec::len).sum();
    assert_eq!(intervals.len(), robots);
    assert_eq!(&intervals[0][12], "", "no fitness in simulation in the first interval");

    let genes = records(&files["genes.csv"]);
    let bins = records(&files["bins.csv"]);
    assert_eq!(genes.len(), bins.len());
    assert_eq!(
        genes.len(),
        2 * 7 * 5 * MINUTES as usize,
        "combinations, kinds, cases, intervals"
    );
    let runs = runs_of(&results.combinations[0], Case::NoLight, Kind::Evolved);
    let mean = runs
        .iter()
        .flat_map(|run| &run.intervals[3])
        .map(|robot| f64::from(robot.s0))
        .sum::<f64>()
        / 20.0;
    assert_eq!((&genes[3][4], field(&genes[3], 5)), ("3", 20.0));
    assert!((field(&genes[3], 6) - mean).abs() < 1e-6);
    for row in &bins {
        for first in [5, 8, 11] {
            let all: f64 = (first..first + 3).map(|place| field(row, place)).sum();
            assert!((all - 1.0).abs() < 1e-5, "{row:?}");
        }
    }
    let digits = |field: &str| {
        field
            .trim_start_matches("0.")
            .chars()
            .filter(char::is_ascii_digit)
            .count()
    };
    for (name, text) in &files {
        let longest = text.lines().skip(1).flat_map(|line| line.split(',')).map(digits).max();
        assert!(longest <= Some(6 + 3), "{name}: {longest:?} digits");
    }
}

#[test]
fn other_cases_are_compared_with_the_control() {
    let html = report(&small(3), &[]);
    let table = part(&html, "table", "rates-s-d-0-2-matched-credit");
    assert_eq!(table.matches("<tr>").count(), 1 + 6);
    assert!(table.contains("the reference for the others"));
    assert_eq!(table.matches("&lt; 0.005").count(), 4);
    assert_eq!(table.matches("&gt; 0.5").count(), 1);
}

#[test]
fn convergence_is_from_when_on_most_simulators_are_right() {
    let run_with = |right_from: usize, wrong_again: usize| {
        let mut one = run(Vec::new());
        one.intervals = (0..20)
            .map(|interval| {
                let right = interval >= right_from && interval != wrong_again;
                vec![RobotInterval {
                    s0: if right { 0.9 } else { 0.1 },
                    chosen_under: 0.5,
                    g0: 0.5,
                    g1: 0.5,
                    real: 0.0,
                    simulated: None,
                    heard: 0,
                    reached: 1,
                    taken: false,
                    founder: 0,
                }]
            })
            .collect();
        [one]
    };
    // Three of five intervals are enough.
    assert_eq!(convergence_interval(&run_with(10, 99)), Some(8));
    assert_eq!(convergence_interval(&run_with(0, 99)), Some(0));
    assert_eq!(convergence_interval(&run_with(18, 99)), None);
    assert_eq!(convergence_interval(&run_with(10, 12)), Some(9));
    assert_eq!(convergence_interval(&[]), None);
}

#[test]
fn tables_of_genes_stand_beside_the_papers() {
    let html = system::html(&Report {
        results: &Results {
            robots: ROBOTS,
            minutes: MINUTES,
            light_moves_minute: 25,
            runs: 1,
            generation_within_34_s: true,
            combinations: Vec::new(),
            questions: Vec::new(),
        },
        claims: &[],
        foragers: &Swarm::odowd2014(ROBOTS),
        assumptions: &[],
        seed: 1,
        arms: None,
    });
    for (paper, here) in [
        ("Light Opposite Nest", "light opposite the nest"),
        ("No Light", "no light"),
        ("Light Over Nest", "light over the nest"),
    ] {
        let row = html.split("<tr>").find(|row| row.contains(&format!(">{paper}<")));
        let row = row.unwrap_or_else(|| panic!("no row of {paper}"));
        assert!(row.contains(&format!(">{here}<")), "{row}");
    }
    assert!(html.contains("Table 1 of the paper") && html.contains(">flee the light<"));
}
