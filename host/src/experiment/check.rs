//! What an experiment's values may be, as far as no world is needed to tell.

use std::fmt::Display;

use oneiro::arena::Arena;
use oneiro::batch::GREATEST_GENE;

use super::settings::{self, ControllerKind, DEFAULT_UNITS, Settings, StartKind};

/// A value that is not allowed.
#[derive(Debug)]
pub(super) struct Invalid {
    /// Its key.
    pub(super) field: String,
    /// What it is, and what is allowed.
    pub(super) problem: String,
}

pub(super) type Checked = Result<(), Invalid>;

pub(super) fn invalid(field: &str, problem: impl Display) -> Checked {
    Err(Invalid {
        field: field.into(),
        problem: problem.to_string(),
    })
}

pub(super) fn within<T: Copy + PartialOrd + Display>(field: &str, value: T, [least, greatest]: [T; 2]) -> Checked {
    if (least..=greatest).contains(&value) {
        return Ok(());
    }
    invalid(field, format_args!("is {value}; allowed: {least} to {greatest}"))
}

/// Two numbers, the smaller first.
fn range(field: &str, [low, high]: [f64; 2], allowed: [f64; 2]) -> Checked {
    within(field, low, allowed)?;
    within(field, high, allowed)?;
    if low < high {
        return Ok(());
    }
    invalid(
        field,
        format_args!("is [{low}, {high}]; allowed: a smaller and a greater number"),
    )
}

/// Checks what a world does not.
pub(super) fn check(settings: &Settings) -> Checked {
    name(&settings.name)?;
    within("seed", settings.seed.unwrap_or(0), [0, GREATEST_SEED])?;
    within("trials", settings.trials, [1, 10_000])?;
    arena(&settings.arena)?;
    controller(&settings.controller)?;
    start(&settings.start)?;
    evolution(&settings.evolution)?;
    within(
        "record.checkpoint_every",
        settings.record.checkpoint_every,
        [1, u32::MAX],
    )
}

/// TOML's integers have a sign.
pub(crate) const GREATEST_SEED: u64 = i64::MAX as u64;

pub(super) fn name(name: &str) -> Checked {
    let is_plain = |c: char| c.is_alphanumeric() || "-_.".contains(c);
    if (1..=100).contains(&name.len()) && name.chars().all(is_plain) && !name.starts_with('.') {
        return Ok(());
    }
    invalid(
        "name",
        format_args!("is {name:?}; allowed: letters, digits, - and _, since directories are named so"),
    )
}

fn arena(arena: &settings::Arena) -> Checked {
    let settings::Arena {
        preset,
        width_mm,
        height_mm,
        walls,
        obstacles,
        blocks,
    } = arena;
    let is_empty = walls.is_empty() && obstacles.is_empty() && blocks.is_empty();
    let is_own = width_mm.is_some() || height_mm.is_some() || !is_empty;
    match preset {
        Some(name) if Arena::named(name).is_none() => invalid(
            "arena.preset",
            format_args!("is {name:?}; allowed: {}", Arena::NAMES.join(", ")),
        ),
        Some(_) if is_own => invalid(
            "arena",
            "has a preset and values of its own; allowed: preset, or width_mm, height_mm, walls, obstacles and blocks",
        ),
        None if is_own && (width_mm.is_none() || height_mm.is_none()) => invalid(
            "arena",
            "lacks its size; allowed: width_mm and height_mm, and with them walls, obstacles and blocks",
        ),
        _ => Ok(()),
    }
}

fn controller(controller: &settings::Controller) -> Checked {
    if controller.kind != ControllerKind::Hidden && controller.units.is_some() {
        return invalid("controller.units", "is given; allowed: only with kind = \"hidden\"");
    }
    Ok(())
}

fn start(start: &settings::Start) -> Checked {
    let given = [start.x_mm, start.y_mm, start.heading_turns]
        .iter()
        .filter(|value| value.is_some())
        .count();
    match start.kind {
        StartKind::Random if given > 0 => invalid(
            "start",
            "is random and has a pose; allowed: kind = \"at\" with x_mm, y_mm and heading_turns",
        ),
        StartKind::At if start.x_mm.is_none() || start.y_mm.is_none() => invalid(
            "start",
            "has no place; allowed: kind = \"at\" with x_mm, y_mm and heading_turns",
        ),
        _ => Ok(()),
    }
}

fn evolution(evolution: &settings::Evolution) -> Checked {
    let greatest = f64::from(GREATEST_GENE);
    within("evolution.population", evolution.population, [1, 1_000_000])?;
    within("evolution.parents", evolution.parents, [1, evolution.population])?;
    if !evolution.population.is_multiple_of(evolution.parents) {
        return invalid(
            "evolution.parents",
            format_args!(
                "is {}; allowed: what divides the population, {}, since each parent makes equally many copies",
                evolution.parents, evolution.population
            ),
        );
    }
    within("evolution.generations", evolution.generations, [1, 1_000_000])?;
    within("evolution.elite", evolution.elite, [0, evolution.parents])?;
    range("evolution.initial", evolution.initial, [-greatest, greatest])?;
    if let Some(limits) = evolution.limits {
        range("evolution.limits", limits, [-greatest, greatest])?;
    }
    within("evolution.mutation.rate", evolution.mutation.rate, [0.0, 1.0])?;
    within("evolution.mutation.amount", evolution.mutation.amount, [0.0, greatest])
}

/// Writes out the defaults that depend on other values.
pub(super) fn complete(settings: &mut Settings) {
    if settings.arena == settings::Arena::default() {
        settings.arena.preset = Some(Arena::miglino1995().name);
    }
    if settings.controller.kind == ControllerKind::Hidden {
        settings.controller.units.get_or_insert(DEFAULT_UNITS);
    }
    if settings.start.kind == StartKind::At {
        settings.start.heading_turns.get_or_insert(0.0);
    }
}
