//! Checks of combinations of an experiment's values, beyond the limits in each row.

use std::fmt::Display;

use oneiro::arena::{Arena, Field};
use oneiro::differential::{Build, Differential, Feature, Sensor};
use oneiro::parameter::Invalid;
use oneiro::world::{Gene, Start, World};
use oneiro_base::console::counted;
use oneiro_base::exit::Result;
use oneiro_evolve::settings::{self as optimiser, Surroundings};

use super::settings::{ArenaSize, Finalists, PictureFile, Settings, Transfer};
use super::source::Source;
use crate::lives::measures;

pub(super) type Checked = std::result::Result<(), Invalid>;

pub(super) fn invalid(key: &str, problem: impl Display) -> Checked {
    Err(Invalid {
        field: key.into(),
        problem: problem.to_string(),
    })
}

/// Checks what neither rows nor the world check.
pub(super) fn check(settings: &Settings) -> Checked {
    name(&settings.name)?;
    arena(settings)?;
    finalists(settings.finalists)?;
    reality(&settings.reality)
}

/// Checks that no setting gives a drawn number.
///
/// # Errors
/// Exit 3: its place and its key.
pub(super) fn drawn(settings: &Settings, source: &Source<'_>) -> Result {
    for (table, drawn) in settings.world.varied.keys() {
        if let Some(key) = source.given_over(&format!("{table}.{drawn}"), |key| is_one_of(key, drawn)) {
            let problem = format_args!("has no effect, as {table} draws {drawn}; allowed: --set '{table}={{..}}'");
            return Err(source.invalid(key, problem));
        }
    }
    Ok(())
}

/// Whether a key is another one, or one of those that it stands for: `[]` in it is any element.
fn is_one_of(key: &str, several: &str) -> bool {
    let mut parts = several.split("[]");
    let mut rest = parts.next().and_then(|first| key.strip_prefix(first));
    for part in parts {
        let element = rest.and_then(|rest| rest.strip_prefix('[')?.split_once(']'));
        rest = element.and_then(|(_, after)| after.strip_prefix(part));
    }
    rest == Some("")
}

fn reality(transfer: &Transfer) -> Checked {
    match transfer.site() {
        Ok(_) => Ok(()),
        Err(problem) => invalid("reality.robot", problem),
    }
}

/// Approximate memory of a run in progress, bytes: parents and offspring, each episode's genes and what a batch adds to them, and a row
/// for each generation. An optimiser that uses behaviour also needs each episode's trace, with one record of about `RECORD` bytes a
/// cycle, and a full archive.
pub(super) fn bytes(settings: &Settings, genes: usize) -> u64 {
    const RECORD: u64 = 160;
    let (genes, population) = (genes as u64, u64::from(settings.evolution.genomes_per_generation()));
    let lives = population * u64::from(settings.trials);
    let behaviour = if settings.evolution.uses_behaviour() {
        lives.saturating_mul(RECORD * u64::from(settings.world.cycles))
    } else {
        0
    };
    let kept = settings.evolution.genomes_kept().saturating_mul(4 * genes);
    let own = 4 * (2 * population * genes + lives * (genes + 16)) + 64 * u64::from(settings.evolution.generations);
    own.saturating_add(behaviour).saturating_add(kept)
}

/// Checks the optimiser's values, some of which depend on the genes.
pub(super) fn evolution(settings: &Settings, genes: &[Gene]) -> Checked {
    settings.evolution.check(&Surroundings {
        genes,
        records_individuals: settings.record.individuals,
        has_robot: !settings.reality.robot.0.is_empty(),
    })
}

/// Checks that genes begin within their own ranges, and not all at the same limit.
pub(super) fn beginnings(settings: &Settings, genes: &[Gene]) -> Checked {
    let optimiser::Settings {
        initial: [low, high],
        initial_shares: shares,
        limits,
        ..
    } = &settings.evolution;
    if let Some([least, greatest]) = limits
        && ((low < least && high <= least) || (high > greatest && low >= greatest))
    {
        let problem = format!(
            "is [{least}, {greatest}], and evolution.initial is [{low}, {high}]; allowed: limits that share a part of that range"
        );
        return invalid("evolution.limits", problem);
    }
    for (gene, share) in genes.iter().zip(&shares.0) {
        let [low, high] = gene.range.map_or([*low, *high], |range| range.map(f64::from));
        let [least, greatest] = match (gene.range, limits) {
            (Some(_), _) => [low, high],
            (None, Some(limits)) => *limits,
            (None, None) => continue,
        };
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let most = (greatest - middle).min(middle - least) / half;
        if *share > most {
            let name = &gene.name;
            let problem =
                format!("is {share} for {name}; allowed: up to {most}, where its range [{least}, {greatest}] ends");
            return invalid("evolution.initial_shares", problem);
        }
    }
    Ok(())
}

/// Checks that the world has the measures that describe behaviour.
pub(super) fn measures(settings: &Settings, world: &World) -> Checked {
    let known = measures::descriptors(world);
    let names: Vec<&str> = known.iter().map(|own| &*own.column.name).collect();
    for (index, own) in settings.evolution.descriptors.iter().enumerate() {
        if !names.contains(&&*own.measure) {
            let problem = format!("is {:?}; allowed: {}", own.measure, names.join(", "));
            return invalid(&format!("evolution.descriptors[{index}].measure"), problem);
        }
    }
    Ok(())
}

/// Checks that a generation fits into memory, once it is known how many genes an individual has.
pub(super) fn memory(settings: &Settings, genes: usize) -> Checked {
    const MOST: u64 = 4 << 30;
    let bytes = bytes(settings, genes);
    if bytes <= MOST {
        return Ok(());
    }
    let (trials, population) = (settings.trials, settings.evolution.population);
    let gigabytes = |bytes: u64| bytes as f64 / f64::from(1 << 30);
    let problem = format!(
        "is {population}, of {} with {}: {:.1} GB of memory; allowed: up to {} GB",
        counted(genes, "gene", "genes"),
        counted(trials, "episode", "episodes"),
        gigabytes(bytes),
        gigabytes(MOST)
    );
    invalid("evolution.population", problem)
}

/// Distance from the middle in radii of the body beyond which sensors, and wheels, are probably not meant to be: some are just outside.
const BEYOND: f32 = 1.25;

/// Keys of values of a world that are allowed but probably not intended, with the reason.
pub(super) fn doubts(settings: &Settings, world: &World) -> Vec<(String, String)> {
    let spec = world.spec();
    let mut doubts = Vec::new();
    let lists_walls = !settings.world.arena.walls.is_empty();
    if lists_walls && settings.arena.open != Some(true) && world.is_enclosed() == Some(false) {
        let problem = "lists walls, so the arena has no sides, and the robot can leave it; add the four sides to the list, or say \
            arena.open = true";
        doubts.push(("arena.walls".to_owned(), problem.to_owned()));
    }
    doubts.extend(outside(settings, world));
    let radius = spec.robot.body_radius;
    for (index, sensor) in spec.robot.described_sensors().iter().enumerate() {
        if let Some(offset) = sensor.offset.filter(|offset| *offset > BEYOND * radius) {
            let problem = format!(
                "is {offset}, outside of the body of {radius} mm radius: next to a wall the sensor is beyond it"
            );
            doubts.push((format!("robot.sensors[{index}].offset_mm"), problem));
        }
    }
    if let Some(Differential {
        wheel_base: Some(base),
        greatest_speed: Some(speed),
        ..
    }) = spec.robot.build.described()
    {
        if *base > 2.0 * BEYOND * radius {
            let problem = format!("is {base}: the wheels are outside of the body of {radius} mm radius");
            doubts.push(("robot.wheel_base_mm".to_owned(), problem));
        }
        let way = speed * f32::from(u16::try_from(spec.cycles).unwrap_or(u16::MAX)) / 10.0;
        if way < radius {
            let problem = format!("is {speed}: in an episode the robot drives at most {way} mm, less than its radius");
            doubts.push(("robot.greatest_speed_mm_s".to_owned(), problem));
        }
    }
    let is_light = |sensor: &&Sensor| sensor.kind.entry().has(Feature::ReadsLights);
    let blind = spec.robot.described_sensors().iter().filter(is_light).count();
    if blind > 0 && spec.arena.lights.is_empty() {
        let sensors = counted(blind, "light sensor reads", "light sensors read");
        doubts.push(("arena.lights".into(), format!("is empty: the robot's {sensors} 0")));
    }
    doubts.extend(unread_floor(world).map(|key| {
        (
            key,
            "has no effect: no sensor, task or other part reads the floor".to_owned(),
        )
    }));
    if let Start::Poses(poses) = &spec.start {
        let (all, each) = (poses.0.len(), world.robots() as usize);
        let taken = each * settings.trials as usize;
        if taken < all {
            let problem = format!(
                "has {all} poses, of which the {} of a genome take the first {taken}",
                counted(settings.trials, "episode", "episodes")
            );
            doubts.push(("start.poses".to_owned(), problem));
        }
    }
    doubts
}

/// The first key of a floor that nothing reads.
fn unread_floor(world: &World) -> Option<String> {
    let spec = world.spec();
    let own = spec.robot.build.described()?;
    let is_read = spec
        .robot
        .described_sensors()
        .iter()
        .any(|sensor| sensor.kind.entry().has(Feature::ReadsFloor))
        || own.model.is_some()
        || !spec.own.is_empty()
        || spec.arena.patches.iter().any(|patch| patch.charges == Some(true))
        || matches!(spec.start, Start::Zone(_));
    let arena = &spec.arena;
    let keys = [
        ("arena.picture", arena.picture.is_some()),
        ("arena.patches", !arena.patches.is_empty()),
        ("arena.floor", arena.floor.is_some()),
    ];
    let key = keys.into_iter().find(|(_, is_given)| *is_given && !is_read);
    key.map(|(key, _)| key.to_owned())
}

/// Objects that no robot notices, and starts outside of the arena.
fn outside(settings: &Settings, world: &World) -> Vec<(String, String)> {
    let arena = &world.spec().arena;
    let within = arena.within_walls();
    let Field { x, y, width, height } = within;
    let origin = match settings.arena.corners {
        Some(_) => "its origin (0, 0) is that of arena.corners_mm",
        None => "its origin (0, 0) is its lower left corner",
    };
    let of_arena = format!(
        "the arena has x from {x} to {} and y from {y} to {} mm; {origin}",
        x + width,
        y + height
    );
    let listed = |key: &String| {
        let walls = settings.world.arena.walls.len();
        let wall = key
            .strip_prefix("arena.walls[")
            .and_then(|rest| rest.trim_end_matches(']').parse().ok());
        wall.is_none_or(|wall: usize| wall < walls)
    };
    let keys = world.unreached().into_iter().filter(listed);
    let of_key = |key: String| {
        let is_start = key == "start" || key == "robot.starts_mm";
        let is = if is_start {
            "is outside of the arena"
        } else {
            "is too far away for any robot to sense"
        };
        (key, format!("{is}: {of_arena}"))
    };
    let mut found: Vec<_> = keys.map(of_key).collect();
    for (index, light) in arena.lights.iter().enumerate() {
        let is_above = arena.wall_height.is_some_and(|wall| light.height.unwrap_or(0.0) > wall);
        if !is_above && !within.contains(light.x, light.y) && world.is_enclosed() != Some(false) {
            let problem = format!("is outside of the arena, and walls between hide it: {of_arena}");
            found.push((format!("arena.lights[{index}]"), problem));
        }
    }
    found
}

fn finalists(Finalists { count, lives }: Finalists) -> Checked {
    const MOST: u64 = 1_000_000;
    if (1 + u64::from(count)) * u64::from(lives) > MOST {
        let problem =
            format!("is {lives} for {count} finalists and the luckiest; allowed: up to {MOST} episodes in all");
        return invalid("evolution.finalist_lives", problem);
    }
    Ok(())
}

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

/// Whether an experiment has a forager, which brings its arena.
pub(super) fn is_forager(settings: &Settings) -> bool {
    matches!(settings.world.robot.build, Build::Forager(_))
}

/// Whether an experiment defines any part of a custom arena.
pub(super) fn is_own_arena(settings: &Settings) -> bool {
    let ArenaSize {
        preset: _,
        width_mm,
        height_mm,
        open,
        ref corners,
        start_radius,
        ref picture,
    } = settings.arena;
    let has_size = width_mm.is_some() || height_mm.is_some() || corners.is_some() || start_radius.is_some();
    has_size || open.is_some() || *picture != PictureFile::default() || settings.world.arena != Arena::default()
}

fn arena(settings: &Settings) -> Checked {
    let ArenaSize {
        preset,
        width_mm,
        height_mm,
        open,
        corners,
        start_radius,
        picture: _,
    } = &settings.arena;
    if is_forager(settings) && (preset.is_some() || is_own_arena(settings)) {
        return invalid(
            "arena",
            "has a preset, sides or objects; allowed: none of them, a forager's arena is round (arena.radius_mm)",
        );
    }
    match preset {
        Some(name) if Arena::named(name).is_none() => invalid(
            "arena.preset",
            format_args!("is {name:?}; allowed: {}", Arena::NAMES.join(", ")),
        ),
        Some(_) if is_own_arena(settings) => invalid(
            "arena",
            "has a preset and other keys; allowed: only preset, or width_mm, height_mm and objects",
        ),
        None if corners.is_some() && (width_mm.is_some() || height_mm.is_some() || open.is_some()) => invalid(
            "arena.corners_mm",
            "is given beside a width, a height or `open`; allowed: corners alone, or width_mm and height_mm",
        ),
        None if is_own_arena(settings) && corners.is_none() && (width_mm.is_none() || height_mm.is_none()) => invalid(
            "arena",
            "lacks its size; allowed: width_mm and height_mm, or corners_mm, and objects",
        ),
        _ => match (start_radius, width_mm, height_mm) {
            (Some(radius), Some(width), Some(height)) if 2.0 * radius > width.min(*height) => invalid(
                "arena.start_radius_mm",
                format_args!(
                    "is {radius}; allowed: up to {}, half the arena's shorter side",
                    0.5 * width.min(*height)
                ),
            ),
            _ => Ok(()),
        },
    }
}
