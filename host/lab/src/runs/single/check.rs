//! `oneiro check`: an experiment summarised and drawn.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use oneiro::compose::{self, Kind, OwnPart, OwnParts};
use oneiro::differential::{Build, Differential, SensorKind};
use oneiro::foraging::{Forager, Foraging};
use oneiro::parameter::Choice;
use oneiro::tables::SENSORS;
use oneiro::world::{Drawn, Noise, Robot, Start, Varied, WorldSpec};
use oneiro_base::answer::Answer;
use oneiro_base::console::{counted, decimal};
use oneiro_base::exit::Result;
use oneiro_base::files;
use oneiro_evolve::coevolution::OpponentKind;
use oneiro_evolve::settings::{Kind as Optimiser, SelectionKind, Settings};
use oneiro_evolve::{GivenGenomes, given_genomes, most_given};
use oneiro_report::figures;
use serde_json::{Value, json};

use crate::experiment::Experiment;

/// Draws the experiment's arena if a file is named, and summarises the experiment.
pub(super) fn run(experiment: &Experiment, picture: Option<&Path>) -> Result<Answer> {
    let spec = experiment.world().spec();
    let mut messages = Vec::new();
    if let Some(path) = picture {
        let drawn = figures::arena(
            &spec.arena,
            spec.robot.body_radius,
            spec.robot.described_sensors(),
            &spec.start,
        );
        files::write_new(path, drawn.as_bytes())?;
        messages.push(format!("drew {}", path.display()));
    }
    let values = values(&spec.own).into_iter().map(|(key, number, value)| {
        json!({
            "key": key,
            "value": number,
            "default": decimal(value.default),
            "allowed": value.allowed.to_string(),
            "unit": value.unit,
            "about": value.about,
        })
    });
    let value = json!({
        "name": experiment.name(),
        "robot": robot_values(&spec.robot, experiment.settings().robot.preset.0.as_deref()),
        "sensors": sensor_counts(&spec.robot).into_iter().collect::<BTreeMap<_, _>>(),
        "genes": experiment.world().genes(),
        "free_share": experiment.world().free_share(),
        "episodes": experiment.episodes().total(),
        "budget": experiment.budget(),
        "init": experiment.init().map(|(genomes, input)| json!({
            "file": input.named,
            "genomes": genomes.len(),
            "blake3": input.content.hash,
        })),
        "robot_steps": experiment.steps(),
        "gene_names": experiment.world().gene_layout().names(),
        "gene_ranges": experiment.world().gene_layout().ranges(),
        "parts": spec.own.iter().map(part_value).collect::<Vec<_>>(),
        "part_values": values.collect::<Vec<_>>(),
        "settings": experiment.values(),
    });
    Ok(Answer {
        messages,
        ..Answer::new(summary(experiment), value)
    })
}

/// The file of a custom part with its functions and its memory, or the name of a built-in part.
fn part(own: Option<&OwnPart>, shipped: &str) -> String {
    let Some(own) = own else {
        return shipped.to_owned();
    };
    let (part, memory) = (own.part(), remembered(own));
    let memory = if memory.is_empty() {
        "nothing".to_owned()
    } else {
        memory.join(", ")
    };
    format!("{}: {}; remembers {memory}", part.path(), part.functions().join(", "))
}

/// Names of what a part remembers, of a robot and of all.
fn remembered(own: &OwnPart) -> Vec<&str> {
    let part = own.part();
    let memory = part.memory().iter().chain(part.mission());
    memory.map(|(name, _)| name.as_str()).collect()
}

/// The same as values by key.
fn part_value(own: &OwnPart) -> Value {
    let part = own.part();
    json!({
        "kind": part.kind().word(),
        "file": part.path(),
        "functions": part.functions(),
        "memory": remembered(own),
    })
}

/// The number of sensors of each kind, in order of the kinds' first occurrence.
fn sensor_counts(robot: &Robot) -> Vec<(&'static str, usize)> {
    let mut counts: Vec<(&str, usize)> = Vec::new();
    for sensor in robot.described_sensors() {
        let kind = sensor.kind.word();
        match counts.iter_mut().find(|(known, _)| *known == kind) {
            Some((_, count)) => *count += 1,
            None => counts.push((kind, 1)),
        }
    }
    match robot.build {
        Build::Sampled => vec![(SensorKind::Proximity.word(), SENSORS)],
        Build::Differential(_) => counts,
        Build::Forager(_) => vec![
            (SensorKind::Proximity.word(), 4),
            (SensorKind::Light.word(), 8),
            ("food", 1),
        ],
    }
}

/// The values that custom parts declare: key, value, and declaration.
fn values(parts: &OwnParts) -> Vec<(String, f64, &compose::Value)> {
    let mut values = Vec::new();
    for own in parts.iter() {
        let word = own.part().kind().word();
        let numbers = own.named_values();
        for value in own.part().values() {
            values.push((format!("{word}.values.{}", value.name), numbers[&value.name], value));
        }
    }
    values
}

/// A line for each value of custom parts: the value, its default, what is allowed, and its meaning.
fn value_lines(parts: &OwnParts) -> String {
    let line = |(key, number, value): (String, f64, &compose::Value)| {
        let compose::Value {
            default,
            allowed,
            unit,
            about,
            ..
        } = value;
        let unit = if unit.is_empty() { "" } else { &format!(" {unit}") };
        format!("    {key} = {number}{unit}: {about} (default: {default}; allowed: {allowed}{unit})\n")
    };
    let lines: String = values(parts).into_iter().map(line).collect();
    if lines.is_empty() {
        lines
    } else {
        format!("  values of parts\n{lines}")
    }
}

fn summary(experiment: &Experiment) -> String {
    let settings = experiment.settings();
    let world = experiment.world();
    let spec = world.spec();
    let evolution = &settings.evolution;
    let run = experiment.evolution(0);
    let optimizer = run.optimizer();
    let lines = [
        ("robot", robot(&spec.robot, settings.robot.preset.0.as_deref())),
        (
            "arena",
            format!(
                "{}; {:.0} % of the field is free",
                arena(spec),
                100.0 * world.free_share()
            ),
        ),
        ("sensors", sensors(&spec.robot, spec.own.get(Kind::Sensor))),
        (
            "noise",
            foragers_noise(&spec.robot).unwrap_or_else(|| noise(spec.noise, &spec.robot, &spec.own))
                + &drawn_noise(&spec.varied),
        ),
        (
            "controller",
            format!(
                "{}; {}",
                part(spec.own.get(Kind::Controller), spec.controller.word()),
                counted(world.genes(), "gene", "genes")
            ),
        ),
        ("task", part(spec.own.get(Kind::Task), spec.task.word())),
        (
            "start",
            match &spec.start {
                Start::Random if spec.robot.has_starts() => {
                    "each robot at its place (robot.starts_mm), with a random heading".to_owned()
                }
                Start::Random => "a random free pose for each episode".to_owned(),
                Start::At { x, y, heading } => format!("at ({x}, {y}) mm, heading {heading} turns"),
                Start::Poses(poses) => {
                    let poses = counted(poses.0.len(), "pose", "poses");
                    let next = match world.robots() {
                        1 => "the next".to_owned(),
                        robots => format!("the next {robots}, one for each robot"),
                    };
                    format!("{poses}, of which trial after trial takes {next}")
                }
                Start::Zone(zone) => format!("a random free pose for each episode, in {}", zone.words()),
            },
        ),
        (
            "worlds",
            match world.variants().len() {
                _ if spec.varied.vary.0.is_empty() && spec.varied.choose.0.is_empty() => String::new(),
                count => format!(
                    "{count} with {} drawn; each trial of a generation takes one",
                    counted(
                        spec.varied.vary.0.len() + spec.varied.choose.0.len(),
                        "number",
                        "numbers"
                    )
                ),
            },
        ),
        (
            "test",
            match &settings.test.0[..] {
                [] => String::new(),
                values => {
                    let keys: Vec<&str> = values.iter().map(|(key, _)| &**key).collect();
                    format!("other values of {} with `oneiro evaluate --test`", keys.join(", "))
                }
            },
        ),
        (
            "episode",
            format!(
                "{} of 100 ms, {} for each individual",
                counted(settings.world.cycles, "cycle", "cycles"),
                counted(settings.trials, "episode", "episodes")
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
                "{}, {}{}",
                counted(evolution.population, "individual", "individuals"),
                counted(evolution.generations, "generation", "generations"),
                breeding(evolution)
            ),
        ),
        (
            "begins with",
            experiment.init().map_or_else(String::new, |_| init(experiment)),
        ),
        ("budget", experiment.budget().unwrap_or_default()),
        (
            "reality",
            match experiment.first_real() {
                Some(first) => {
                    let robots = settings.reality.robot.0.join(" and ");
                    let time = experiment.robot_time();
                    let time = time.map_or_else(String::new, |time| format!(": {time}"));
                    let last = evolution.generations - 1;
                    if first == last {
                        format!("generation {last} is evaluated on {robots}{time}")
                    } else {
                        format!("generations {first} to {last} are evaluated on {robots}{time}")
                    }
                }
                None => "none".to_owned(),
            },
        ),
        (
            "champion",
            match experiment.finalists() {
                0 => "the luckiest individual of the run".to_owned(),
                _ if evolution.is_coevolution() => {
                    let lives = counted(settings.finalists.lives, "episode", "episodes");
                    format!("the best of both populations in the last generation, with the mean of {lives}")
                }
                finalists => {
                    let lives = counted(settings.finalists.lives, "episode", "episodes");
                    format!(
                        "the best mean of {lives}, of {}",
                        counted(finalists, "finalist", "finalists")
                    )
                }
            },
        ),
        (
            "work",
            format!("{:.1} million robot-steps a run", experiment.steps() as f64 / 1e6),
        ),
    ];
    let lines = lines.into_iter().filter(|(_, value)| !value.is_empty());
    let lines = lines.fold(String::new(), |mut text, (what, value)| {
        let _ = writeln!(text, "  {what:<12}{value}");
        text
    });
    let (names, ranges) = (world.gene_layout().names(), world.gene_layout().ranges());
    let genes = names.iter().zip(ranges).enumerate().map(|(gene, (name, range))| {
        let range = range.map_or_else(String::new, |[least, greatest]| format!(", {least} to {greatest}"));
        format!("  {gene:>5}  {name}{range}\n")
    });
    format!(
        "{} is valid\n{}{}  genes\n{}",
        experiment.name(),
        lines,
        value_lines(&spec.own),
        genes.collect::<String>()
    )
}

/// The genomes that an evolution begins with, and what becomes of them.
fn init(experiment: &Experiment) -> String {
    let Some((genomes, input)) = experiment.init() else {
        return String::new();
    };
    let evolution = &experiment.settings().evolution;
    let count = genomes.len();
    let made = match given_genomes(evolution) {
        GivenGenomes::None(_) => String::new(),
        GivenGenomes::Mean if count == 1 => ": the mean of the first samples".to_owned(),
        GivenGenomes::Mean => ": their mean is that of the first samples".to_owned(),
        GivenGenomes::First(_) if Some(count) == most_given(evolution, experiment.world().gene_layout().all()) => {
            ": the first generation".to_owned()
        }
        GivenGenomes::First(others) => format!(": the first individuals; the others are {others}"),
    };
    format!("{} of {}{made}", counted(count, "genome", "genomes"), input.named)
}

/// How a genetic algorithm breeds, after the numbers of its individuals and generations.
fn breeding(evolution: &Settings) -> String {
    if evolution.is_coevolution() {
        let opponents = &evolution.tables.opponents;
        let met = match opponents.kind {
            OpponentKind::Recent => format!(
                "the last {}",
                counted(opponents.generations, "generation", "generations")
            ),
            OpponentKind::HallOfFame => "all earlier generations".to_owned(),
        };
        return format!(
            " of each of two populations; each individual meets {}, the best of {met}",
            counted(opponents.contests, "opponent", "opponents")
        );
    }
    if evolution.kind != Optimiser::Genetic {
        return String::new();
    }
    let elite = match evolution.elite {
        0 => String::new(),
        1 => "; the best one survives unchanged".to_owned(),
        elite => format!("; the best {elite} survive unchanged"),
    };
    let parents = match evolution.selection.kind {
        SelectionKind::Truncation => format!(
            "; the best {} make {} copies each",
            evolution.parents,
            evolution.population / evolution.parents.max(1)
        ),
        SelectionKind::Uniform => format!("; parents are drawn from the best {}", evolution.parents),
        other => format!("; parents are drawn by {}", other.word()),
    };
    parents + &elite
}

/// A further number of objects; nothing for none.
fn counted_if_any(count: usize, one: &str, many: &str) -> String {
    match count {
        0 => String::new(),
        count => format!(", {}", counted(count, one, many)),
    }
}

/// An arena's size, and the objects in it.
fn arena(spec: &WorldSpec) -> String {
    if let Build::Forager(Forager { foraging, .. }) = &spec.robot.build {
        let food = counted(foraging.food_items, "item", "items");
        return format!(
            "round, radius {} mm, a nest of radius {} mm, {food} of food, the lamp {}",
            foraging.arena_radius,
            foraging.nest_radius,
            foraging.light.word()
        );
    }
    let arena = &spec.arena;
    let picture = arena.picture.as_ref().map(|picture| {
        let cells = [picture.columns(), picture.rows()];
        format!(", a floor picture of {} x {} cells", cells[0], cells[1])
    });
    format!(
        "{}, {} x {} mm, {}, {}, {}{}{}{}",
        arena.name,
        arena.within_walls().width,
        arena.within_walls().height,
        counted(arena.walls.len(), "wall", "walls"),
        counted(arena.obstacles.len(), "round obstacle", "round obstacles"),
        counted(arena.blocks.len(), "block", "blocks"),
        counted_if_any(arena.lights.len(), "light", "lights"),
        picture.unwrap_or_default(),
        counted_if_any(arena.patches.len(), "floor patch", "floor patches"),
    )
}

/// Which noise differs from world to world.
fn drawn_noise(varied: &Varied) -> String {
    let keys: Vec<&str> = varied
        .keys()
        .map(|(_, key)| key)
        .filter(|key| Noise::is_key(key))
        .collect();
    if keys.is_empty() {
        String::new()
    } else {
        format!("; {} drawn for each world", keys.join(", "))
    }
}

/// The noise of one forager.
fn foragers_noise(robot: &Robot) -> Option<String> {
    let Build::Forager(Forager { foraging, .. }) = &robot.build else {
        return None;
    };
    let (light, wheels) = (foraging.light_noise, foraging.wheel_noise);
    Some(format!(
        "of proximity as measured, {light} of light, a fraction of {wheels} of each wheel's travel"
    ))
}

/// A robot's body and wheels, and its battery; the name of a built-in robot.
fn robot(robot: &Robot, name: Option<&str>) -> String {
    let radius = format!("radius {} mm", robot.body_radius);
    let own = match &robot.build {
        Build::Sampled => {
            let classes: Vec<&str> = robot.sensors.classes.iter().map(|table| table.class.as_str()).collect();
            let (classes, states) = (classes.join(", "), robot.motors.states);
            return format!("{radius}, sensors sampled for {classes}, {states} x {states} motor states");
        }
        Build::Differential(own) => own,
        Build::Forager(own) => {
            let Foraging {
                wheel_base,
                greatest_speed,
                ..
            } = own.foraging;
            return format!("a forager, {radius}, wheels {wheel_base} mm apart, up to {greatest_speed} mm/s");
        }
    };
    let mut parts: Vec<String> = name.map(str::to_owned).into_iter().collect();
    parts.push(radius);
    parts.extend(own.wheel_base.map(|base| format!("wheels {base} mm apart")));
    parts.extend(own.greatest_speed.map(|speed| format!("up to {speed} mm/s")));
    parts.extend(own.wheel_noise.map(|noise| format!("{} % wheel noise", 100.0 * noise)));
    parts.extend(own.count.map(|count| {
        let contact = own.contact.unwrap_or_default().word();
        format!("{}: {contact}", counted(count, "robot in a swarm", "robots in a swarm"))
    }));
    let states = robot.motors.states;
    parts.extend(own.sampled_motors.then(|| format!("{states} x {states} motor states")));
    parts.extend((own.speeds > 0).then(|| counted(own.speeds, "speed", "speeds")));
    let acceleration = own.acceleration.filter(|acceleration| *acceleration > 0.0);
    parts.extend(acceleration.map(|acceleration| format!("accelerates by up to {acceleration} mm/s^2")));
    let latency = own.latency.filter(|latency| *latency > 0);
    parts.extend(latency.map(|latency| format!("obeys {} late", counted(latency, "cycle", "cycles"))));
    parts.extend(own.battery.map(|seconds| {
        let ends = own.battery_ends_life == Some(true);
        let end = if ends {
            ", which ends the episode when empty"
        } else {
            ""
        };
        format!("a battery of {seconds} s{end}")
    }));
    parts.join(", ")
}

/// The same as values by key, null where the robot has none.
fn robot_values(robot: &Robot, preset: Option<&str>) -> Value {
    let own = match &robot.build {
        Build::Differential(own) => Some(own),
        Build::Sampled | Build::Forager(_) => None,
    };
    let foraging = match &robot.build {
        Build::Forager(own) => Some(own.foraging),
        _ => None,
    };
    let number = |value: fn(&Differential) -> Option<f32>| own.and_then(value).map(decimal);
    let has_sampled_motors = own.map_or(foraging.is_none(), |own| own.sampled_motors);
    let classes = robot
        .tables()
        .map(|tables| tables.classes.iter().map(|table| &table.class).collect::<Vec<_>>());
    json!({
        "kind": robot.build.word(),
        "preset": preset,
        "body_radius_mm": decimal(robot.body_radius),
        "wheel_base_mm": foraging.map_or_else(|| number(|own| own.wheel_base), |own| Some(decimal(own.wheel_base))),
        "greatest_speed_mm_s": foraging.map_or_else(|| number(|own| own.greatest_speed), |own| Some(decimal(own.greatest_speed))),
        "speeds": own.map(|own| own.speeds).filter(|speeds| *speeds > 0),
        "acceleration_mm_s2": number(|own| own.acceleration),
        "latency_cycles": own.and_then(|own| own.latency),
        "battery_s": number(|own| own.battery),
        "battery_ends_life": own.and_then(|own| own.battery_ends_life),
        "classes": classes,
        "motor_states": has_sampled_motors.then_some(robot.motors.states),
        "collision": robot.collision.word(),
    })
}

/// The robot's sensors by their kinds, with their names, and the file of custom ones.
fn sensors(robot: &Robot, own: Option<&OwnPart>) -> String {
    let tables = robot.tables().filter(|_| robot.build != Build::Sampled);
    let tables = tables.and_then(|tables| Some((tables, tables.classes.first()?)));
    let tables = tables.map(|(tables, first)| {
        let classes: Vec<&str> = tables.classes.iter().map(|table| table.class.as_str()).collect();
        let (count, reach) = (counted(first.sensors, "sensor", "sensors"), first.reach());
        format!(
            "tables of {count} for {}, {} to {reach} mm from the rim",
            classes.join(", "),
            first.nearest
        )
    });
    let kinds = sensor_counts(robot).into_iter().map(|(word, count)| {
        let sensors = robot
            .described_sensors()
            .iter()
            .filter(|sensor| sensor.kind.word() == word);
        let names: Vec<&str> = sensors.map(|sensor| sensor.name.as_str()).collect();
        let names = if names.is_empty() {
            String::new()
        } else {
            format!(" ({})", names.join(", "))
        };
        format!("{count} {word}{names}")
    });
    let model = match &robot.build {
        Build::Differential(own) => own.model,
        Build::Sampled | Build::Forager(_) => None,
    };
    let model = model.map(|model| {
        format!(
            "{} of the model {}",
            counted(model.readings().len(), "reading", "readings"),
            model.word()
        )
    });
    let own = own.map(|own| part(Some(own), ""));
    let all: Vec<String> = kinds.chain(tables).chain(model).chain(own).collect();
    if all.is_empty() {
        "none".to_owned()
    } else {
        all.join(", ")
    }
}

/// The noise of an episode, and whether the user's parts may draw more.
fn noise(noise: Noise, robot: &Robot, own: &OwnParts) -> String {
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
        parts.push(format!("motion varies by a fraction of {}", noise.motor));
    }
    let given = |value: Option<f32>| value.filter(|value| *value > 0.0);
    if let Some(gain) = given(noise.gain) {
        parts.push(format!("each activation varies by a fraction of {gain}"));
    }
    if let Some(veer) = given(noise.veer) {
        parts.push(format!("the robot veers by up to {veer} turns a metre"));
    }
    if let Some(delay) = given(noise.delay) {
        parts.push(format!("commands act up to {} late", counted(delay, "cycle", "cycles")));
    }
    if noise.drawn == Some(Drawn::Life) {
        parts.push("all except the walk is drawn once an episode".to_owned());
    }
    if let Build::Differential(Differential {
        wheel_noise: Some(wheels),
        ..
    }) = robot.build
        && wheels > 0.0
    {
        parts.push(format!("each wheel's speed varies by a fraction of {wheels}"));
    }
    if parts.is_empty() {
        parts.push("none".to_owned());
    }
    if !own.is_empty() {
        parts.push("custom parts may add noise".to_owned());
    }
    parts.join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_told_in_words() {
        let (mut robot, own) = (WorldSpec::miglino1995().robot, OwnParts::default());
        assert_eq!(noise(Noise::default(), &robot, &own), "none");
        let all = Noise {
            sensor: (-0.2, 0.2),
            walk_range: 30.0,
            walk_step: 1.5,
            motor: 0.1,
            gain: Some(0.5),
            veer: Some(0.06),
            delay: Some(0.6),
            drawn: Some(Drawn::Life),
        };
        assert_eq!(
            noise(all, &robot, &own),
            "-0.2 to 0.2 is added to each activation; what is perceived walks within 30 mm, 1.5 mm a cycle; \
             motion varies by a fraction of 0.1; each activation varies by a fraction of 0.5; \
             the robot veers by up to 0.06 turns a metre; commands act up to 0.6 cycles late; all except the walk is drawn once an episode"
        );
        robot.build = Build::Differential(Differential {
            wheel_noise: Some(0.05),
            ..Differential::new(52.0, 80.0)
        });
        assert_eq!(
            noise(Noise::default(), &robot, &own),
            "each wheel's speed varies by a fraction of 0.05"
        );
    }
}
