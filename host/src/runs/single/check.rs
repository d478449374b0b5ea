//! `oneiro check`: an experiment summarised and drawn.

use std::path::Path;

use oneiro::compose::{Kind, OwnPart};
use oneiro::differential::{Build, SensorKind};
use oneiro::parameter::Choice;
use oneiro::world::{Noise, Robot, Start};
use serde_json::json;

use crate::console::{Console, counted};
use crate::exit::Result;
use crate::experiment::Experiment;
use crate::experiment::settings::Finalists;
use crate::files;
use crate::report::figures;

/// Draws the experiment's arena if a file is named, and prints a summary of the experiment.
pub(super) fn run(experiment: &Experiment, picture: Option<&Path>, console: Console) -> Result {
    let spec = experiment.world().spec();
    if let Some(path) = picture {
        files::write_new(path, figures::arena(&spec.arena, spec.robot.body_radius).as_bytes())?;
        console.say(format!("drew {}", path.display()));
    }
    if console.json() {
        return console.json_data(&json!({
            "name": experiment.name(),
            "genes": experiment.world().genes(),
            "free_share": experiment.world().free_share(),
            "robot_steps": experiment.steps(),
            "gene_names": experiment.world().gene_layout().names(),
            "settings": experiment.values(),
        }));
    }
    console.data(summary(experiment))
}

/// The file and the values of a user's part, or the word for what ships.
fn part(own: Option<&OwnPart>, shipped: &str) -> String {
    let Some(own) = own else {
        return shipped.to_owned();
    };
    let values = own.named_values();
    let shown = own.part().values().iter().map(|value| {
        let unit = if value.unit.is_empty() {
            String::new()
        } else {
            format!(" {}", value.unit)
        };
        format!("{} = {}{unit}", value.name, values[&value.name])
    });
    std::iter::once(own.part().path().to_owned())
        .chain(shown)
        .collect::<Vec<_>>()
        .join(", ")
}

fn summary(experiment: &Experiment) -> String {
    let settings = experiment.settings();
    let world = experiment.world();
    let spec = world.spec();
    let arena = &spec.arena;
    let evolution = &settings.evolution;
    let run = experiment.evolution(0);
    let optimizer = run.optimizer();
    let lines = [
        ("robot", robot(&spec.robot, settings.robot.preset.0.as_deref())),
        (
            "arena",
            format!(
                "{}, {} x {} mm, {}, {}, {}; {:.0} % of the field is free",
                arena.name,
                arena.field.width,
                arena.field.height,
                counted(arena.walls.len() as u32, "wall", "walls"),
                counted(arena.obstacles.len() as u32, "round obstacle", "round obstacles"),
                counted(arena.blocks.len() as u32, "block", "blocks"),
                100.0 * world.free_share()
            ),
        ),
        (
            "sensors",
            match spec.own.get(Kind::Sensor) {
                Some(own) => format!("{}, and {}", sensors(&spec.robot.build), part(Some(own), "")),
                None => sensors(&spec.robot.build),
            },
        ),
        ("noise", noise(spec.noise)),
        (
            "controller",
            format!(
                "{}; {} genes",
                part(spec.own.get(Kind::Controller), spec.controller.word()),
                world.genes()
            ),
        ),
        ("task", part(spec.own.get(Kind::Task), spec.task.word())),
        (
            "start",
            match spec.start {
                Start::Random => "a random free pose for each life".to_owned(),
                Start::At { x, y, heading } => format!("at ({x}, {y}) mm, heading {heading} turns"),
            },
        ),
        (
            "life",
            format!(
                "{} cycles of 100 ms, {} for each individual",
                settings.world.cycles,
                counted(settings.trials, "life", "lives")
            ),
        ),
        (
            "optimiser",
            format!(
                "{}, {} on every machine",
                optimizer.name(),
                if optimizer.is_exact() {
                    "the same bits"
                } else {
                    "not the same bits"
                }
            ),
        ),
        (
            "evolution",
            format!(
                "{} individuals, {} generations; the best {} make {} copies each",
                evolution.population,
                evolution.generations,
                evolution.parents,
                evolution.population / evolution.parents.max(1)
            ),
        ),
        (
            "champion",
            match settings.finalists {
                Finalists { count: 0, .. } => "the luckiest life of the run".to_owned(),
                Finalists { lives, .. } => format!(
                    "the best mean of {lives} lives, of {} finalists",
                    experiment.finalists()
                ),
            },
        ),
        (
            "work",
            format!("{:.1} million robot-steps a run", experiment.steps() as f64 / 1e6),
        ),
    ];
    let lines = lines.map(|(what, value)| format!("  {what:<12}{value}\n"));
    let names = world.gene_layout().names();
    let genes = names
        .iter()
        .enumerate()
        .map(|(gene, name)| format!("  {gene:>5}  {name}\n"));
    format!(
        "{} is valid\n{}  genes\n{}",
        experiment.name(),
        lines.concat(),
        genes.collect::<String>()
    )
}

/// A robot's body and wheels, and its battery; the name if it is one that ships.
fn robot(robot: &Robot, name: Option<&str>) -> String {
    let radius = format!("radius {} mm", robot.body_radius);
    let own = match &robot.build {
        Build::Sampled => {
            let classes: Vec<&str> = robot.sensors.classes.iter().map(|table| table.class.as_str()).collect();
            let (classes, states) = (classes.join(", "), robot.motors.states);
            return format!("{radius}, sensors sampled for {classes}, {states} x {states} motor states");
        }
        Build::Differential(own) => own,
    };
    let mut parts: Vec<String> = name.map(str::to_owned).into_iter().collect();
    parts.extend([
        radius,
        format!("wheels {} mm apart", own.wheel_base),
        format!("up to {} mm/s", own.greatest_speed),
    ]);
    parts.extend((own.speeds > 0).then(|| format!("{} speeds", own.speeds)));
    let acceleration = own.acceleration.filter(|acceleration| *acceleration > 0.0);
    parts.extend(acceleration.map(|acceleration| format!("accelerates by up to {acceleration} mm/s^2")));
    let latency = own.latency.filter(|latency| *latency > 0);
    parts.extend(latency.map(|latency| format!("obeys {} late", counted(latency, "cycle", "cycles"))));
    parts.extend(own.battery.map(|seconds| {
        let ends = own.battery_ends_life == Some(true);
        let end = if ends { ", which ends life when it is empty" } else { "" };
        format!("a battery of {seconds} s{end}")
    }));
    parts.join(", ")
}

/// The robot's own sensors by their kinds, with their names.
fn sensors(build: &Build) -> String {
    let Build::Differential(own) = build else {
        return "8 of proximity".to_owned();
    };
    let of_kind = |(word, kind, _): &(&str, SensorKind, &str)| {
        let sensors = own.sensors.iter().filter(|sensor| sensor.kind == *kind);
        let names: Vec<&str> = sensors.map(|sensor| sensor.name.as_str()).collect();
        (!names.is_empty()).then(|| format!("{} {word} ({})", names.len(), names.join(", ")))
    };
    let kinds: Vec<_> = SensorKind::CHOICES.iter().filter_map(of_kind).collect();
    if kinds.is_empty() {
        "none".to_owned()
    } else {
        kinds.join(", ")
    }
}

fn noise(noise: Noise) -> String {
    let mut parts = Vec::new();
    let (low, high) = noise.sensor;
    if low != 0.0 || high != 0.0 {
        parts.push(format!("{low} to {high} is added to each activation"));
    }
    if noise.walk_range > 0.0 {
        let Noise {
            walk_range, walk_step, ..
        } = noise;
        parts.push(format!(
            "what is perceived walks within {walk_range} mm, {walk_step} mm a cycle"
        ));
    }
    if noise.motor > 0.0 {
        parts.push(format!("motion varies by a share of {}", noise.motor));
    }
    if parts.is_empty() {
        "none".to_owned()
    } else {
        parts.join("; ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_told_in_words() {
        assert_eq!(noise(Noise::default()), "none");
        let all = Noise {
            sensor: (-0.2, 0.2),
            walk_range: 30.0,
            walk_step: 1.5,
            motor: 0.1,
        };
        assert_eq!(
            noise(all),
            "-0.2 to 0.2 is added to each activation; what is perceived walks within 30 mm, 1.5 mm a cycle; \
             motion varies by a share of 0.1"
        );
    }
}
