//! Summary of the study as JSON: a few figures for each run. The tables have the rest.

use oneiro::foraging::Light;
use serde_json::{Value, json};

use crate::odowd2014::measures::{ALL, FIRST_HALF, G0, G1, LATE, S0, SECOND_HALF};
use crate::odowd2014::results::{Results, Run};

pub(crate) fn summary(results: &Results) -> Value {
    let combinations = results.combinations.iter().map(|combination| {
        json!({
            "scale": combination.scale,
            "credit": combination.credit,
            "runs": combination.runs.iter().map(run).collect::<Vec<_>>(),
        })
    });
    let questions = results.questions.iter().map(|question| {
        json!({
            "about": question.about,
            "robots": question.robots,
            "arena_radius_mm": question.arena_radius,
            "range_mm": question.range,
            "lamp_behind_wall_mm": question.lamp,
            "runs": question.runs.iter().map(run).collect::<Vec<_>>(),
        })
    });
    json!({
        "robots": results.robots,
        "minutes": results.minutes,
        "light_moves_minute": results.light_moves_minute,
        "runs": results.runs,
        "combinations": combinations.collect::<Vec<_>>(),
        "questions": questions.collect::<Vec<_>>(),
    })
}

fn run(run: &Run) -> Value {
    let summary = json!({
        "case": run.case,
        "kind": run.kind,
        "number": run.number,
        "brought": run.total(),
        "food_per_minute": run.rate(ALL),
        "first_half": run.rate(FIRST_HALF),
        "second_half": run.rate(SECOND_HALF),
    });
    if run.intervals.is_empty() {
        return summary;
    }
    let Value::Object(mut summary) = summary else {
        return summary;
    };
    let lights = [Light::OppositeNest, Light::Nowhere, Light::OverNest];
    summary.insert("late_shares".into(), json!(lights.map(|light| run.share(light, LATE))));
    summary.insert(
        "late_means".into(),
        json!([S0, G0, G1].map(|gene| run.mean(gene, LATE))),
    );
    Value::Object(summary)
}
