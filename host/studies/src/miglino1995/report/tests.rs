use oneiro::arena::Arena;
use oneiro::random::pcg4d;
use oneiro::tables::SensorTables;
use oneiro_report::page::check::{outside, part, unbalanced};

use super::*;
use crate::assumptions::Assumption;
use crate::claims::{Effect, Power, Test};
use crate::miglino1995::results::{
    Champion, Controls, DifferenceEffect, Discrepancy, Family, Level, MeasuredEpisode, Transferred, Variant,
};
use crate::verdict::Verdict;

pub(in crate::miglino1995) const GENERATIONS: u32 = 200;
const REAL: u32 = 20;
const POPULATION: u32 = 100;

/// Fixed sequence of numbers from 0 to 1.
struct Numbers(u32);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 += 1;
        f64::from(pcg4d([self.0, 1, 9, 95])[0]) / f64::from(u32::MAX)
    }

    fn around(&mut self, middle: f64, width: f64) -> f64 {
        middle + width * (self.next() - 0.5)
    }

    fn fitness(&mut self, middle: f64) -> Vec<f32> {
        (0..POPULATION).map(|_| self.around(middle, 160.0) as f32).collect()
    }

    /// Path straight ahead until a wall.
    fn path(&mut self, speed: f64) -> Vec<[f32; 2]> {
        let ((mut x, mut y), (mut dx, mut dy)) = ((300.0, 80.0), (speed, 0.6 * speed));
        (0..500)
            .map(|_| {
                if !(40.0..560.0).contains(&(x + dx)) {
                    (dx, dy) = (-dx, dy * self.around(0.9, 0.5));
                }
                if !(40.0..310.0).contains(&(y + dy)) {
                    (dx, dy) = (dx * self.around(1.0, 0.4), -dy);
                }
                (x, y) = (x + dx, y + dy);
                [x as f32, y as f32]
            })
            .collect()
    }

    fn episode(&mut self, fitness: f64, speed: f64) -> MeasuredEpisode {
        MeasuredEpisode {
            fitness: fitness as f32,
            path: self.path(speed),
            collided: 0.1 * self.next(),
            forwards: self.around(0.9, 0.2).min(1.0),
            visited: self.around(0.4, 0.3),
            speed: self.around(0.7, 0.2),
            length: 500.0 * speed,
            stuck_in_corner: self.next() < 0.2,
        }
    }

    fn sums(&mut self, each: f64) -> Vec<f64> {
        let mut sum = 0.0;
        (0..100)
            .map(|k| {
                sum += self.around(each, each) * f64::from(k) / 50.0;
                sum
            })
            .collect()
    }

    fn run(&mut self, condition: Condition, number: u32) -> Run {
        let (top, gap, apart) = match condition {
            Condition::None => (380.0, 60.0, 60.0),
            Condition::Sensor => (370.0, 110.0, 90.0),
            Condition::Conservative => (340.0, 5.0, 20.0),
        };
        let mut levels = |first: u32, last: u32, rise: f64, above: f64| -> Vec<Level> {
            (first..=last)
                .map(|g| {
                    let share = (f64::from(g) + 1.0) / (f64::from(g) + rise);
                    let peak = self.around((top - above) * share, 14.0);
                    let average = self.around(0.7 * (top - above) * share, 24.0);
                    Level { peak, average }
                })
                .collect()
        };
        let simulated = levels(0, GENERATIONS, 14.0, 0.0);
        let real = levels(0, REAL - 1, 1.5, gap);
        Run {
            controls: None,
            condition,
            number,
            seed: 40 + u64::from(number),
            simulated,
            real,
            transferred: Transferred {
                simulated: self.fitness(0.7 * top),
                simulated_again: self.fitness(0.7 * top),
                quiet: self.fitness(0.7 * top),
                real: self.fitness(0.7 * (top - gap)),
                real_again: self.fitness(0.7 * (top - gap)),
                other_robot: self.fitness(0.5 * (top - gap)),
            },
            last: self.fitness(0.7 * top - 0.3 * gap),
            champion: Champion {
                individual: 17,
                mean: None,
                genome: (0..18).map(|_| self.around(0.0, 8.0) as f32).collect(),
                simulated: self.episode(top, 7.0),
                real: self.episode(top - gap, 7.0 - apart / 60.0),
                discrepancy: Discrepancy {
                    paper: self.sums(apart),
                    starts: self.sums(1.2 * apart),
                    length: 1500.0,
                    repeated: self.sums(9.0),
                    unrelated: self.sums(180.0),
                },
            },
        }
    }
}

/// Made-up results with `runs` runs of each condition.
pub(in crate::miglino1995) fn results(runs: u32) -> Results {
    let mut numbers = Numbers(0);
    Results {
        to_and_fro: Vec::new(),
        life_within_two_seconds: true,
        is_wired: false,
        variants: Vec::new(),
        simulated_generations: GENERATIONS,
        real_generations: REAL,
        population: POPULATION,
        parents: 20,
        cycles: 500,
        assumptions: vec![
            Assumption {
                name: "noise.walk_step".into(),
                value: "1.5 mm <a step>".into(),
                source: "ours; the paper says \"a small random value\"".into(),
            },
            Assumption {
                name: "fitness.difference".into(),
                value: "root".into(),
                source: "Floreano and Mondada (1994)".into(),
            },
        ],
        differences: ["illumination", "latency", "wheel mismatch & slip"]
            .into_iter()
            .map(|name| DifferenceEffect {
                name: name.into(),
                activation: 0.1 * numbers.next(),
                displacement: numbers.next(),
                turn: 3.0 * numbers.next(),
            })
            .collect(),
        runs: Condition::ALL
            .into_iter()
            .flat_map(|condition| (0..runs).map(move |number| (condition, number)))
            .map(|(condition, number)| numbers.run(condition, number))
            .collect(),
    }
}

fn test(name: String, value: f64, p: f64) -> Test {
    Test {
        name,
        statistic: "F".into(),
        value,
        degrees_of_freedom: vec![1.0, 998.0],
        p,
        p_holm: None,
    }
}

fn claims() -> Vec<Claim> {
    let table = Table::of(MIGLINO1995_CLAIMS);
    let claim = |number: u32| {
        let tests = Condition::ALL.map(|condition| {
            let name = format!("{}, simulated against real, individuals", condition.title());
            test(name, 123.456 + f64::from(number), 3.2e-143)
        });
        Claim {
            source: "section 4".into(),
            unit: "runs".into(),
            id: format!("C{number}"),
            question: table.claims[number as usize - 1].question().into(),
            statement: format!("What the paper says <{number}> of its robots, their noise & their transfer."),
            criterion: "The order of |d| is sensor noise > no noise > conservative noise.".into(),
            is_later: number == 10,
            verdict: match number % 4 {
                0 => Verdict::Opposed,
                3 => Verdict::Undecided,
                _ => Verdict::Holds,
            },
            reasons: Vec::new(),
            registered: None,
            effects: vec![
                Effect {
                    name: "peak at generation 200".into(),
                    value: -0.047_123_456,
                    interval: None,
                    paper: None,
                },
                Effect {
                    name: "d, no noise, noise on in simulation".into(),
                    value: 0.734_567_89,
                    interval: Some([0.512_345_6, 0.9]),
                    paper: Some(0.81),
                },
            ],
            tests: tests.into(),
            power: None,
            remark: "Runs, not individuals, are independent.".into(),
        }
    };
    (1..=12).map(claim).collect()
}

fn report(results: &Results, claims: &[Claim]) -> String {
    html(&Report {
        results,
        claims,
        sensors: &SensorTables::khepera(),
        arena: &Arena::miglino1995(),
        body_radius: 27.5,
        robot: "surrogate:1 <severity 1>, parameters 8f2a",
        seed: 7,
        edition: Edition::Second,
        arms: None,
    })
}

/// Made-up results with controls of each run and other simulators of each family.
fn full(runs: u32) -> Results {
    let mut results = results(runs);
    for (number, run) in (0_u32..).zip(&mut results.runs) {
        run.controls = Some(Controls {
            simulated_on: 201.0 + f64::from(number),
            neutral: 190.0,
            from_random: 222.0,
        });
    }
    let families = [
        (Family::SensorRange, "U(0, 0.1)", 0.1),
        (Family::Displacement, "drawn once an episode", 0.0),
        (Family::Displacement, "a \"slow\" walk & more", 1.5),
    ];
    results.variants = families
        .map(|(family, name, value)| Variant {
            family,
            name: name.into(),
            value,
            simulated: vec![300.0; runs as usize],
            real: (0..runs).map(|run| 250.0 + f64::from(run)).collect(),
        })
        .into();
    results
}

#[test]
fn every_figure_and_table_of_the_paper_is_there() {
    let html = report(&results(5), &claims());
    for number in 1..=12 {
        assert!(
            part(&html, "figure", &format!("figure-{number}")).contains("<svg"),
            "{number}"
        );
    }
    assert!(part(&html, "figure", "figure-3-round").contains("<svg"));
    for table in ["table-1", "table-2"] {
        assert_eq!(part(&html, "table", table).matches("<tr>").count(), 1 + 3, "{table}");
    }
    for number in 1..=12 {
        let words = if number == 10 {
            "written when results were known"
        } else {
            "Preregistered"
        };
        assert!(part(&html, "article", &format!("c{number}")).contains(words));
    }
}

/// Each question has its claims and something to look at, below the abstract and the methods.
#[test]
fn results_stand_by_question() {
    let html = report(&full(5), &claims());
    let table = Table::of(MIGLINO1995_CLAIMS);
    let mut order: Vec<&str> = table.questions().into_iter().map(|(key, _)| key).collect();
    for (key, question) in table.questions() {
        let section = part(&html, "section", key);
        assert!(section.contains(&format!("<h2>{question}</h2>")), "{key}");
        assert!(
            section.contains("<article") && (section.contains("<figure") || section.contains("<caption")),
            "{key}"
        );
        assert!(part(&html, "section", "abstract").contains(&format!("<a href=\"#{key}\">{question}</a>")));
    }
    order.splice(0..0, ["abstract", "methods"]);
    order.extend(["limits", "glossary"]);
    let places: Vec<Option<usize>> = order
        .iter()
        .map(|key| html.find(&format!("<section id=\"{key}\"")))
        .collect();
    assert!(places.is_sorted() && !places.contains(&None), "{places:?}");
    let answers = part(&html, "section", "abstract");
    assert!(answers.contains("</a> holds: <a href=\"#c2\">C2</a>, <a href=\"#c5\">C5</a>; undecided: "));
    assert!(part(&html, "section", "glossary").contains("<td>surrogate</td>"));
}

/// The chance of five runs stands next to the verdict, and a claim that nobody has to judge has none.
#[test]
fn power_stands_beside_verdicts() {
    let mut claims = claims();
    assert!(!report(&results(5), &claims).contains("30 robots"));
    claims[2].power = Some(Power {
        verdict: Verdict::Holds,
        sets: 1680,
        holds: 0.125,
        undecided: 0.85,
        opposed: 0.025,
    });
    claims[11].verdict = Verdict::NotJudged;
    claims[11].reasons = vec!["true by hardware".to_owned()];
    let html = report(&results(5), &claims);
    assert_eq!(unbalanced(&html), None);
    let verdicts = part(&html, "section", "abstract");
    assert!(verdicts.contains("<td class=\"number\">12.5 %</td>") && verdicts.contains("; 1 is not judged: "));
    assert!(verdicts.contains("Those of C10 were written when results were known"));
    let article = part(&html, "article", "c3");
    assert!(article.contains("Of 1680 sets of five runs of one of these robots, in 12.5 % the claim holds"));
    assert!(part(&html, "article", "c12").contains("<b>Not judged.</b> true by hardware."));
    // An undecided claim has no effect that five runs could show.
    assert_eq!(
        claims[2].power.map(|power| Power {
            verdict: Verdict::Undecided,
            ..power
        }
        .chance()),
        Some(None)
    );
}

/// The robot is drawn to scale, with each sensor where it was sampled.
#[test]
fn the_robot_is_drawn_as_sampled() {
    let html = report(&results(5), &claims());
    let figure = part(&html, "figure", "figure-1");
    assert!(figure.contains(">55 mm<"));
    // Eight sensors on either side, and what the built-in tables say of the sixth.
    assert_eq!(figure.matches("<g transform=\"rotate(").count(), 16);
    let table = SensorTables::khepera();
    let half = crate::miglino1995::judge::half_gaps(&table.classes[table.class("wall").unwrap()])[5];
    assert!(figure.contains(&format!(">6: {half:.0} mm<")), "{half}");
}

#[test]
fn the_page_is_well_formed_and_needs_nothing_else() {
    let html = report(&results(2), &claims());
    assert_eq!(unbalanced(&html), None);
    assert_eq!(outside(&html), None);
    assert!(!html.contains("NaN") && !html.contains("inf<"));
}

#[test]
fn reports_are_the_same_each_time() {
    assert_eq!(report(&results(3), &claims()), report(&results(3), &claims()));
    assert_eq!(csv_files(&results(3)), csv_files(&results(3)));
}

#[test]
fn names_are_escaped() {
    let html = report(&results(1), &claims());
    for text in [
        "surrogate:1 &lt;severity 1&gt;",
        "&lt;7&gt; of its robots, their noise &amp; their transfer",
        "1.5 mm &lt;a step&gt;",
        "wheel mismatch &amp; slip",
    ] {
        assert!(html.contains(text), "{text}");
    }
}

#[test]
fn the_papers_figures_stand_beside_ours() {
    let html = report(&results(5), &claims());
    let first = part(&html, "table", "table-1");
    for value in [
        ">126.5<",
        "164.14",
        "549.79",
        "0.74",
        "10<sup>\u{2212}143</sup>",
        "1, 998",
    ] {
        assert!(first.contains(value), "{value} in {first}");
    }
    let second = part(&html, "table", "table-2");
    for value in [">129.5<", "74.09", "30.74", "26.01"] {
        assert!(second.contains(value), "{value} in {second}");
    }
    // The effect that the paper prints comes first, though it is the second in the list.
    let verdicts = part(&html, "section", "abstract");
    assert_eq!(verdicts.matches("<td class=\"number\">0.5123 to 0.9</td>").count(), 12);
    assert_eq!(verdicts.matches("<td class=\"number\">0.7346</td>").count(), 12);
    assert_eq!(verdicts.matches("<span class=\"paper\">0.81</span>").count(), 12);
    assert!(verdicts.contains("<b>6</b>holds") && verdicts.contains("<b>3</b>undecided"));
}

#[test]
fn the_transfer_divides_the_generations() {
    let html = report(&results(5), &claims());
    let figure = part(&html, "figure", "figure-6");
    let points = |line: &str| line.split('"').nth(1).map_or(0, |points| points.split(' ').count());
    let lines: Vec<usize> = figure
        .lines()
        .filter(|line| line.starts_with("<polyline"))
        .map(points)
        .collect();
    // Average and peak, simulated and real: all generations, then those around the transfer.
    assert_eq!(lines, [201, 20, 201, 20, 11, 20, 11, 20]);
    assert_eq!(figure.matches(">reality<").count(), 2);
}

#[test]
fn the_papers_cost_is_worked_out() {
    let html = report(&results(5), &claims());
    assert_eq!(
        html.matches("17.4 days").count(),
        3,
        "in words, the paper's, and as much here"
    );
    assert!(html.contains("6.9 days") && html.contains("300\u{202f}000") && html.contains("30\u{202f}000"));
}

#[test]
fn many_runs_are_summed_up() {
    let html = report(&results(12), &claims());
    assert!(part(&html, "figure", "figure-9").contains("the first 5 of 12 runs"));
    assert!(part(&html, "figure", "figure-6").contains("quartile"));
    assert_eq!(
        html.matches("mean of 12").count(),
        3 + 3,
        "figures 6 to 8, rows of the behaviour"
    );
    assert_eq!(
        part(&html, "figure", "figure-9").matches("stroke-dasharray").count(),
        5 + 1
    );
}

#[test]
fn short_data_are_shown_as_far_as_they_go() {
    let empty = Results {
        runs: vec![],
        assumptions: vec![],
        differences: vec![],
        ..results(0)
    };
    let html = report(&empty, &[]);
    assert_eq!(unbalanced(&html), None);
    assert!(html.contains("nothing recorded") && html.contains("no data") && !html.contains("NaN"));

    let mut short = results(1);
    short.runs.retain(|run| run.condition == Condition::Sensor);
    let run = &mut short.runs[0];
    run.real.clear();
    run.simulated.truncate(1);
    run.transferred.real.truncate(3);
    run.last.clear();
    run.champion.genome.truncate(4);
    run.champion.real.path.clear();
    run.champion.discrepancy.paper.clear();
    let html = report(&short, &claims()[..1]);
    assert_eq!(unbalanced(&html), None);
    assert!(!html.contains("NaN"));
    assert!(part(&html, "table", "table-1").contains("not tested"));

    short.simulated_generations = 0;
    short.real_generations = 0;
    assert_eq!(unbalanced(&report(&short, &[])), None);
}

#[test]
fn csv_files_have_a_row_for_each_value() {
    let results = results(2);
    let files = csv_files(&results);
    let rows: Vec<(&str, usize)> = files
        .iter()
        .map(|(name, text)| (*name, text.lines().count() - 1))
        .collect();
    let expected = [
        ("generations.csv", 6 * (201 + 20)),
        ("transferred.csv", 6 * 100),
        ("last.csv", 6 * 100),
        ("discrepancy.csv", 6 * 100),
        ("champions.csv", 6),
    ];
    assert_eq!(rows, expected);
    for (name, text) in &files {
        let columns = |line: &str| line.split(',').count();
        let head = text.lines().next().map_or(0, columns);
        assert!(text.lines().all(|line| columns(line) == head), "{name}");
        let digits = |field: &str| field.chars().filter(char::is_ascii_digit).count();
        let longest = text.lines().skip(1).flat_map(|line| line.split(',')).map(digits).max();
        assert!(longest <= Some(6 + 4), "{name}: {longest:?} digits");
    }
    let (_, generations) = &files[0];
    assert!(generations.contains("\nnone,0,200,simulation,") && generations.contains("\nnone,0,200,reality,"));
    assert!(
        generations
            .lines()
            .last()
            .is_some_and(|line| line.starts_with("conservative,1,219,reality,"))
    );
}

#[test]
fn csv_rows_of_short_lists_have_empty_fields() {
    let mut short = results(1);
    short.runs.truncate(1);
    short.runs[0].transferred.quiet.truncate(2);
    let (_, text) = csv_files(&short).swap_remove(1);
    let fields: Vec<&str> = text.lines().nth(3).unwrap_or_default().split(',').collect();
    assert_eq!((fields[2], fields[5]), ("2", ""));
    assert!(!fields[4].is_empty() && !fields[6].is_empty());
}

#[test]
fn conditions_have_one_name_in_all_files() {
    for condition in Condition::ALL {
        let json = serde_json::to_string(&condition).expect("a name");
        assert_eq!(json, format!("\"{}\"", condition.name()));
    }
}

#[test]
fn runs_are_called_as_in_the_paper() {
    assert_eq!(
        ["a", "e", "z", "27"],
        [0, 4, 25, 26].map(run_name).each_ref().map(String::as_str)
    );
}

#[test]
fn controls_and_other_simulators_are_shown_where_they_were_run() {
    assert!(!report(&results(5), &claims()).contains("<svg class=\"strip\""));
    let html = report(&full(5), &claims());
    assert_eq!(unbalanced(&html), None);
    let section = ["reality", "noise"].map(|key| part(&html, "section", key)).concat();
    // Five figures per condition; two families with a title each, and three simulators.
    assert_eq!(section.matches("<svg class=\"strip\"").count(), 5 * 3 + 3);
    assert_eq!(section.matches("<tr class=\"sum\">").count(), 2);
    // Only the runs with sensor noise, 206 to 210.
    let of_sensor = section
        .lines()
        .filter(|line| line.contains(">208</td>"))
        .collect::<Vec<_>>();
    assert_eq!(of_sensor.len(), 1);
    assert!(of_sensor[0].contains("had all been simulated") && of_sensor[0].matches("<circle").count() == 5);
    assert!(section.contains("a &quot;slow&quot; walk &amp; more"));
    // One run has no interval.
    assert_eq!(unbalanced(&report(&full(1), &claims())), None);
}

#[test]
fn controls_and_other_simulators_have_files() {
    let results = full(3);
    let files = csv_files(&results);
    let file = |name: &str| &files.iter().find(|(path, _)| *path == name).expect(name).1;
    let mut controls = ::csv::Reader::from_reader(file("controls.csv").as_bytes());
    assert_eq!(controls.records().map(Result::unwrap).count(), 9);
    let mut variants = ::csv::Reader::from_reader(file("variants.csv").as_bytes());
    let rows: Vec<::csv::StringRecord> = variants.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 9);
    assert_eq!(rows[0], vec!["sensor_range", "U(0, 0.1)", "0.1", "0", "300", "250"]);
    assert_eq!(
        rows[8],
        vec!["displacement", "a \"slow\" walk & more", "1.5", "2", "300", "252"]
    );
}
