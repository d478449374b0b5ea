//! The report as JSON, without pictures.

use serde_json::{Value, json};

use super::Tables;
use super::cells::Cells;
use super::champions::champions;
use super::effects::{Comparison, Effects, Family, LEVEL};
use super::factors::{Best, Place};
use super::levels::Kind;
use super::runs::{Run, Runs};
use super::sample::Sample;

/// The whole report.
pub(super) fn json(
    tables: &Tables<'_>,
    runs: &Runs,
    samples: &[Vec<Sample>],
    cells: &Cells<'_>,
    effects: &Effects,
) -> Value {
    let all = runs.outcomes();
    let best_cell = cells.ranked.first().filter(|best| !best.sample.values.is_empty());
    json!({
        "title": tables.title,
        "outcome": tables.outcome.0,
        "runs": runs.all.len(),
        "planned_runs": tables.unfinished.as_ref().map_or(runs.all.len(), |unfinished| unfinished.runs),
        "missing": tables.unfinished.as_ref().map_or(&[][..], |unfinished| &unfinished.missing),
        "not_numbers": all.not_numbers,
        "cells": cells.ranked.len(),
        "factors": (0..runs.factors.len()).map(|place| factor(runs, place, &samples[place], effects)).collect::<Vec<_>>(),
        "best_cell": best_cell.map(|best| json!({
            "levels": levels(runs, &best.cell.levels),
            "outcome": figures(&best.sample),
        })),
        "champions": champions(runs).into_iter().map(|run| champion(runs, run)).collect::<Vec<_>>(),
        "families": {
            "levels": family(&effects.levels),
            "cells": family(&effects.cells),
        },
    })
}

fn factor(runs: &Runs, place: usize, samples: &[Sample], effects: &Effects) -> Value {
    let factor = &runs.factors[place];
    let best = Best::of(factor, samples);
    let effect = effects.factors.iter().find(|effect| effect.factor == place);
    let test = effect.and_then(|effect| effect.test.as_ref());
    let groups = factor.groups.iter().zip(samples).map(|(group, sample)| {
        json!({
            "label": group.label,
            "outcome": figures(sample),
        })
    });
    json!({
        "name": factor.name,
        "kind": match factor.kind {
            Kind::Numbers => "numbers",
            Kind::Ranges => "ranges",
            Kind::Words => "words",
        },
        "tested_as": runs.tested_as(place).map(|first| &runs.factors[first].name),
        "levels": factor.levels.len(),
        "binned": factor.is_binned(),
        "groups": groups.collect::<Vec<_>>(),
        "best": best.map(|best| &factor.groups[best.group].label),
        "best_is": best.and_then(|best| best.place).map(|place| match place {
            Place::Inside => "inside",
            Place::LowEnd => "lower end",
            Place::HighEnd => "upper end",
        }),
        "epsilon_squared": effect.map(|effect| effect.explained),
        "kruskal_wallis": test.map(|test| json!({
            "h": test.h,
            "df": test.df,
            "p": test.p,
            "p_holm": test.p_holm,
        })),
    })
}

fn levels(runs: &Runs, levels: &[u32]) -> Value {
    let names = runs.factors.iter().map(|factor| factor.name.clone());
    names.zip(runs.texts(levels).map(Value::from)).collect()
}

pub(super) fn figures(sample: &Sample) -> Value {
    let [least, lower, median, upper, greatest] = sample.quartiles();
    json!({
        "n": sample.values.len(),
        "not_numbers": sample.not_numbers,
        "mean": sample.mean(),
        "sd": sample.deviation(),
        "quartiles": [least, lower, median, upper, greatest],
    })
}

fn champion(runs: &Runs, run: &Run) -> Value {
    json!({
        "run": run.number,
        "id": run.id,
        "seed": run.seed,
        "levels": levels(runs, &run.levels),
        "outcome": run.outcome,
        "result": run.result,
    })
}

fn family(family: &Family) -> Value {
    let marked = |one: &&Comparison| one.p_holm < LEVEL;
    json!({
        "tests": family.comparisons.len(),
        "below_0_05": family.comparisons.iter().filter(marked).count(),
        "untested": family.untested,
    })
}
