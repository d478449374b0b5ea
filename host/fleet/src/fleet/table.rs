//! What is known of a fleet's robots while they live, as a table for a terminal and as a line of JSON.

use oneiro_base::console::counted;
use oneiro_base::console::{columns, decimal};
use oneiro_lab::exchange::radio::Status;
use oneiro_report::numbers::significant;
use serde_json::{Value, json};

use super::operator::{Ears, Known};
use crate::daemon::activity::{Activity, Problems};

const HEAD: [&str; 11] = [
    "robot",
    "state",
    "age s",
    "interval",
    "S0",
    "real",
    "simulated",
    "food",
    "V",
    "ignored",
    "problems",
];

/// The table, below a line with the experiment's time in ms.
pub fn text(ears: &Ears, time: Option<i64>) -> String {
    let rows: Vec<Vec<String>> = ears.robots.iter().map(|(number, known)| row(*number, known)).collect();
    let food: u32 = ears
        .robots
        .values()
        .filter_map(|known| Some(known.status.as_ref()?.brought))
        .fold(0, u32::saturating_add);
    let (here, all) = (ears.present(), ears.robots.len());
    let time = time.map_or_else(String::new, |time| {
        format!("{}:{:02} of the experiment, ", time / 60_000, time / 1000 % 60)
    });
    let refused: u64 = ears.refused.values().sum();
    let refused = if refused > 0 {
        format!(", {} refused", counted(refused, "datagram", "datagrams"))
    } else {
        String::new()
    };
    let table = columns(&HEAD, &rows);
    let robots = counted(all, "robot", "robots");
    format!("{time}food {food}; {here} of {robots} here{refused}\n\n{table}")
}

fn row(number: u32, known: &Known) -> Vec<String> {
    let age = known
        .heard
        .map_or_else(|| "never".to_owned(), |at| format!("{:.1}", at.elapsed().as_secs_f64()));
    let mut cells = vec![number.to_string(), state(known), age];
    match &known.status {
        None => cells.resize(HEAD.len() - 1, String::new()),
        Some(status) => cells.extend([
            status.interval.to_string(),
            format!("{:.2}", status.simulator),
            significant(status.real.into(), 4),
            known_value(status.simulated).map_or_else(String::new, |fitness| significant(fitness.into(), 4)),
            format!("{}{}", status.brought, if status.carries { "+" } else { "" }),
            known_value(status.volts).map_or_else(String::new, |volts| format!("{volts:.2}")),
            status.ignored.to_string(),
        ]),
    }
    cells.push(problems(known).join(", "));
    cells
}

/// What a robot does, in a word.
pub(super) fn state(known: &Known) -> String {
    match (known.refusal(), &known.status, known.heard) {
        (Some(_), ..) => "refused".to_owned(),
        (None, _, None) => "silent".to_owned(),
        (None, _, Some(_)) if !known.is_here() => "away".to_owned(),
        (None, Some(status), Some(_)) => match Activity::of(status.state) {
            Some(activity) => activity.word().to_owned(),
            None => format!("state {}", status.state),
        },
        (None, None, Some(_)) => "ready".to_owned(),
    }
}

/// What is in a robot's way.
pub(super) fn problems(known: &Known) -> Vec<String> {
    let bits = known.status.as_ref().map_or(0, |status| status.problems);
    let problems = Problems::of(bits).words().into_iter().map(str::to_owned);
    known.refusal().map(str::to_owned).into_iter().chain(problems).collect()
}

/// A value of a status that may be unknown.
pub(super) fn known_value(value: f32) -> Option<f32> {
    (value >= 0.0).then_some(value)
}

/// The same as JSON.
pub fn json(ears: &Ears, time: Option<i64>) -> Value {
    let robot = |(number, known): (&u32, &Known)| {
        let status = |status: &Status| {
            json!({
                "milliseconds": status.milliseconds,
                "interval": status.interval,
                "simulator": decimal(status.simulator),
                "real": decimal(status.real),
                "simulated": known_value(status.simulated).map(decimal),
                "controller": status.controller.map(decimal),
                "brought": status.brought,
                "carries": status.carries,
                "pose": status.pose.map(decimal),
                "volts": known_value(status.volts).map(decimal),
                "ignored": status.ignored,
            })
        };
        json!({
            "robot": number,
            "state": state(known),
            "age_ms": known.heard.map(|at| at.elapsed().as_millis() as u64),
            "status": known.status.as_ref().map(status),
            "problems": problems(known),
        })
    };
    json!({
        "milliseconds": time,
        "robots": ears.robots.iter().map(robot).collect::<Vec<_>>(),
        "refused": ears.refused,
    })
}
