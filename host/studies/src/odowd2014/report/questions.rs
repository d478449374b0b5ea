//! The paper's open questions: number and density of robots, range of messages, and distance of the light.

use oneiro::foraging::Light;
use oneiro_base::contents::Column;
use oneiro_report::csv::{Csv, number};
use oneiro_report::numbers::{Digits, NONE, shown};
use oneiro_report::page::{Cell, Head, Row, paragraph, table};
use oneiro_statistics::mean;

use super::measures::S0;
use crate::odowd2014::measures::{ALL, LATE, convergence_interval};
use crate::odowd2014::results::{Question, Results, Run};

/// Columns of the table of open questions.
pub(super) static COLUMNS: [Column; 12] = [
    Column::text(
        "about",
        "the question: the number of robots, their density, or their range",
    ),
    Column::whole("robots", "", "the number of robots"),
    Column::number("arena_radius_mm", "mm", "the arena's radius"),
    Column::number("range_mm", "mm", "the range at which robots hear each other"),
    Column::number("lamp_behind_wall_mm", "mm", "the distance of the lamp behind the wall"),
    Column::whole("runs", "", "the number of runs; the columns below are means over them"),
    Column::number("food_per_robot_minute", "items a robot-minute", "food brought"),
    Column::number(
        "late_share_over",
        "0 to 1",
        "the fraction of simulators with the light over the nest, late in the run",
    ),
    Column::number("late_s0", "0 to 0.99", "the mean gene of simulators, late in the run"),
    Column::whole(
        "converged_minute",
        "min",
        "the minute from which more than half of the simulators have the light over the nest, over five minutes; empty if never",
    ),
    Column::number(
        "heard",
        "robots",
        "the number of robots that a robot hears in an interval",
    ),
    Column::number(
        "reached_share",
        "0 to 1",
        "the fraction of robots linked to a robot in an interval",
    ),
];

/// Results for one of the questions.
struct Answer {
    food_per_robot: f64,
    late_share: f64,
    late_s0: f64,
    converged: Option<usize>,
    heard: f64,
    reached: f64,
}

fn answer(question: &Question) -> Answer {
    let over = |figure: &dyn Fn(&Run) -> f64| mean(question.runs.iter().map(figure));
    let robots = f64::from(question.robots);
    let each =
        |figure: fn(&crate::odowd2014::results::RobotInterval) -> f64| over(&|run| mean(run.robots(ALL).map(figure)));
    Answer {
        food_per_robot: over(&|run| run.rate(ALL)) / robots,
        late_share: over(&|run| run.share(Light::OverNest, LATE)),
        late_s0: over(&|run| run.mean(S0, LATE)),
        converged: convergence_interval(&question.runs),
        heard: each(|robot| f64::from(robot.heard)),
        reached: each(|robot| f64::from(robot.reached)) / robots,
    }
}

/// The paper's open questions as a table; empty if they were not run.
pub(super) fn html(results: &Results) -> String {
    if results.questions.is_empty() {
        return String::new();
    }
    let head = [
        Head::Text("Asked"),
        Head::Number("robots"),
        Head::Number("arena, mm"),
        Head::Number("range, mm"),
        Head::Number("lamp behind wall, mm"),
        Head::Number("food per robot and minute"),
        Head::Number("late fraction of Over"),
        Head::Number("late S0"),
        Head::Number("converged from minute"),
        Head::Number("heard per interval"),
        Head::Number("fraction reached"),
    ];
    let rows: Vec<Row> = results
        .questions
        .iter()
        .map(|question| {
            let answer = answer(question);
            let mut cells = vec![Cell::text(match question.about.as_str() {
                "density" => "robots at one density",
                "arena" => "robots in one arena",
                "lamp" => "how far off the light is",
                _ => "range of messages",
            })];
            let numbers = [
                f64::from(question.robots),
                question.arena_radius,
                question.range,
                question.lamp,
                answer.food_per_robot,
                answer.late_share,
                answer.late_s0,
            ];
            cells.extend(numbers.map(|value| Cell::number(shown(value, Digits::Three))));
            let converged = answer
                .converged
                .map_or(NONE.to_owned(), |interval| interval.to_string());
            cells.push(Cell::number(converged));
            cells.extend([answer.heard, answer.reached].map(|value| Cell::number(shown(value, Digits::Three))));
            cells.into()
        })
        .collect();
    let words = paragraph(
        "The light over the nest, mutations of s.d. 0.2, matched credit. Converged: from which minute on more than half of \
         the simulators have the light over the nest, mean of runs over five minutes. Seven items of food in every arena.",
    );
    format!("<h3>Open questions</h3>\n{words}{}", table("", "", &head, &rows))
}

/// The same table as CSV.
pub(super) fn csv(results: &Results) -> String {
    let mut rows = Csv::new(&COLUMNS);
    for question in &results.questions {
        let answer = answer(question);
        rows.row([
            question.about.clone(),
            question.robots.to_string(),
            number(question.arena_radius),
            number(question.range),
            number(question.lamp),
            question.runs.len().to_string(),
            number(answer.food_per_robot),
            number(answer.late_share),
            number(answer.late_s0),
            answer
                .converged
                .map_or_else(String::new, |interval| interval.to_string()),
            number(answer.heard),
            number(answer.reached),
        ]);
    }
    rows.text()
}
