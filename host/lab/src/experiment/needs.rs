//! Values that have an effect only with another value. A file that gives one without the other is refused, unless a setting
//! of a higher rank made it needless, or it is the default.

use oneiro::arena::Arena;
use oneiro::differential::{Build, Feature};
use oneiro::reference::{Model, Reference};
use oneiro::surrogate::Difference;
use oneiro::world::{Controller, Gene, Start, World};
use oneiro_base::exit::Result;
pub(super) use oneiro_evolve::settings::Need;
use toml::Table;

use super::settings::Settings;
use super::source::Source;
use super::values::{self, Described};

/// Finds values whose needs are not met. Returns the paths of those that are to be left out, since a setting of a higher rank made
/// them needless.
///
/// # Errors
/// Exit 3: the place of another one, its key, and what it needs.
pub(super) fn check<T: Described>(
    needs: Vec<Need>,
    given: &Table,
    settings: &mut T,
    source: &Source<'_>,
) -> Result<Vec<String>> {
    let mut needless = Vec::new();
    for Need { keys, only, by, .. } in needs.into_iter().filter(|need| !need.is_met) {
        // Places are looked for only if there is something to refuse: a sweep has many cells.
        let keys = keys.iter().filter(|key| values::at(given, key).is_some());
        for path in keys.flat_map(|key| source.given(key)) {
            let Some(is) = no_default(path, settings) else {
                continue;
            };
            source.leave_out(path, by, format_args!("{is}; allowed: only {only}"))?;
            needless.push(path.to_owned());
        }
    }
    Ok(needless)
}

/// Refuses values of keys that are not used where an experiment is a part of something else, such as a study.
///
/// # Errors
/// Exit 3: the place of one that is not the default, and its key.
pub(super) fn check_used(
    settings: &mut Settings,
    source: &Source<'_>,
    is_used: &dyn Fn(&str) -> bool,
    by: &str,
) -> Result {
    for row in Settings::rows().iter().filter(|row| !is_used(row.key)) {
        for path in source.given(row.key) {
            if let Some(is) = no_default(path, settings) {
                let is = is.trim_end_matches(", which has no effect");
                return Err(source.invalid(
                    path,
                    format_args!("{is}, and {by} does not use it; allowed: leave it out"),
                ));
            }
        }
    }
    Ok(())
}

/// Describes the value at a path; `None` if it is the default, or if no row has the path.
fn no_default<T: Described>(path: &str, settings: &mut T) -> Option<String> {
    let (row, index) = values::row_of::<T>(path)?;
    let Some(now) = (row.field)(settings, index)?.get() else {
        return values::has_elements(row, settings).then(|| "is given".to_owned());
    };
    match values::default_of(row) {
        Some(default) if default == now => None,
        Some(_) => Some(format!("is {now}, which has no effect")),
        None => Some("is given".to_owned()),
    }
}

/// Needs that can be checked before there is a world.
pub(super) fn of_settings(settings: &Settings) -> Vec<Need> {
    const TRIALS: &[&str] = &["trials"];
    const NOISE: &[&str] = &[
        "noise.sensor",
        "noise.motor",
        "noise.gain",
        "noise.veer_turns_per_m",
        "noise.delay_cycles",
    ];
    const ROBOT: &[&str] = &["reality.robot"];
    const SURROGATE: &str = "with a surrogate as reality.robot";
    const WIRE: &str = "with a connected robot as reality.robot";
    let noise = &settings.world.noise;
    let is_some = |value: Option<f32>| value.is_some_and(|value| value > 0.0);
    let is_noisy = noise.sensor != (0.0, 0.0)
        || noise.motor > 0.0
        || [noise.gain, noise.veer, noise.delay].into_iter().any(is_some);
    let site = settings.reality.site();
    // A wrong robot is refused later.
    let is_unclear = site.is_err();
    let site = site.ok().flatten();
    let (is_real, is_wired) = (site.is_some(), site.is_some_and(|site| site.is_wired()));
    let mut needs = vec![
        Need::new(
            &["trial_score"],
            settings.trials > 1,
            "with trials of 2 and more",
            TRIALS,
        ),
        Need::new(
            &["evolution.finalist_lives"],
            settings.finalists.count > 0,
            "with evolution.finalists of 1 and more",
            &["evolution.finalists"],
        ),
        Need::new(
            &["evolution.finalists"],
            !is_wired || settings.finalists.count == 0,
            "without a connected robot as reality.robot",
            ROBOT,
        ),
        Need::new(
            &["noise.walk_step_mm"],
            noise.walk_range > 0.0,
            "with noise.walk_range_mm above 0",
            &["noise.walk_range_mm"],
        ),
        Need::new(
            &["noise.drawn"],
            is_noisy,
            "with other noise than that of the walk",
            NOISE,
        ),
        Need::new(
            &["reality.generations"],
            is_real || is_unclear,
            "with reality.robot",
            ROBOT,
        ),
        Need::new(
            &["reality.severity", "reality.motion_severity", "reality.differences"],
            is_unclear || is_real && !is_wired,
            SURROGATE,
            ROBOT,
        ),
        Need::new(
            &[
                "reality.starts",
                "reality.speed_mm_s",
                "reality.walk_s",
                "reality.sensors",
                "reality.tracker",
                "reality.tracker_age_ms",
                "reality.guard",
            ],
            is_unclear || is_wired,
            WIRE,
            ROBOT,
        ),
        Need::new(
            &["sensor.values"],
            settings.sensor.part.is_some(),
            "with sensor.part",
            &["sensor.part"],
        ),
    ];
    needs.extend(settings.evolution.needs());
    needs.extend(of_robot(settings));
    needs
}

/// Needs that depend on the robot.
fn of_robot(settings: &Settings) -> Vec<Need> {
    const KIND: &[&str] = &["robot.kind", "robot.preset"];
    const MODEL: &[&str] = &["robot.model", "robot.preset"];
    const CONTROLLER: &[&str] = &["controller.kind"];
    let world = &settings.world;
    let Arena { lights, patches, .. } = &world.arena;
    let reads_sensors = !matches!(
        world.controller,
        Controller::StateMachine(_) | Controller::BehaviourTree(_) | Controller::Behaviours
    );
    let starts_drawn = match &world.robot.build {
        Build::Differential(own) => own.count.is_some() && own.starts.is_none() && world.start == Start::Random,
        Build::Sampled | Build::Forager(_) => false,
    };
    let mut needs = vec![
        Need::new(
            &["arena.start_radius_mm"],
            starts_drawn,
            "with robot.count, and without robot.starts_mm and start.kind; start.kind = \"zone\" is a disc for any robots",
            &["robot.count", "robot.starts_mm", "start.kind"],
        ),
        Need::new(
            &["sensor", "robot.sensors"],
            reads_sensors || world.task.is_part(),
            "with a controller or a custom task that reads it",
            CONTROLLER,
        ),
        Need {
            keys: (0..patches.len())
                .filter(|index| patches[*index].sides.is_none())
                .map(|index| format!("arena.patches[{index}].heading_turns"))
                .collect(),
            is_met: false,
            only: "with sides_mm: a disc looks the same from all sides",
            by: &[],
        },
        Need::new(
            &[
                "arena.picture.x_mm",
                "arena.picture.y_mm",
                "arena.picture.sides_mm",
                "arena.picture.cell_mm",
            ],
            settings.arena.picture.file.is_some(),
            "with arena.picture.file",
            &["arena.picture.file"],
        ),
        Need::new(
            &["arena.wall_height_mm"],
            matches!(world.robot.build, Build::Differential(_)),
            "with robot.model",
            KIND,
        ),
    ];
    if let Build::Forager(_) = world.robot.build {
        needs.push(Need::new(
            &[
                "robot.cruise_mm_s",
                "robot.turn_rad_s",
                "robot.phototaxis_gain",
                "robot.phototaxis_turn_rad_s",
                "robot.phototaxis_threshold",
                "robot.near_mm",
                "robot.escape_s",
                "robot.search_interval_s",
            ],
            world.controller == Controller::Behaviours,
            "with controller.kind = \"behaviours\"",
            CONTROLLER,
        ));
    }
    let Build::Differential(own) = &world.robot.build else {
        return needs;
    };
    let has = |feature| own.sensors.iter().any(|sensor| sensor.kind.entry().has(feature));
    needs.push(Need::new(
        &["robot.battery_s"],
        has(Feature::ReadsBattery) || own.battery_ends_life == Some(true),
        "with a sensor of the kind battery, or robot.battery_ends_life = true",
        &["robot.sensors", "robot.battery_ends_life"],
    ));
    needs.push(Need::new(
        &["noise.sensor"],
        !own.sensors.is_empty(),
        "with robot.sensors; a reference model has its own noise, robot.proximity_noise and others",
        &["robot.sensors", "robot.model", "robot.preset"],
    ));
    if own.model.is_some() {
        let brightness = (0..lights.len()).map(|index| format!("arena.lights[{index}].brightness"));
        needs.push(Need {
            keys: brightness.collect(),
            is_met: has(Feature::ReadsLights),
            only: "with a sensor of the kind light; the model goes by the intensity",
            by: MODEL,
        });
        // A preset gives them to every model, and the record of a run has them.
        let reference = &own.reference;
        let greys = [
            (
                "robot.grey_left",
                reference.grey_left,
                own.model != Some(Model::Vectors),
            ),
            (
                "robot.grey_middle",
                reference.grey_middle,
                own.model == Some(Model::Rm11),
            ),
            ("robot.grey_right", reference.grey_right, own.model == Some(Model::Rm11)),
        ];
        for ((key, grey, is_read), default) in greys.into_iter().zip(Reference::GREY) {
            let only = match key {
                "robot.grey_left" => "with robot.model = \"rm1.1\" or \"rm1.2\"",
                _ => "with robot.model = \"rm1.1\"",
            };
            needs.push(Need::new(&[key], is_read || grey == Some(default), only, MODEL));
        }
    }
    needs
}

/// Needs that depend on the genes.
pub(super) fn of_world(world: &World) -> Vec<Need> {
    let has_range = |gene: &Gene| gene.range.is_some();
    let mut needs = vec![Need::new(
        &["evolution.initial", "evolution.limits"],
        !world.gene_layout().all().iter().all(has_range),
        "with a gene that has no range",
        &["controller.kind", "controller.part", "robot.kind"],
    )];
    needs.extend(Difference::ALL.map(|difference| Need {
        keys: vec![format!("reality.differences.{}", difference.name())],
        is_met: world.spec().robot.differs_by(difference),
        only: "with a robot that it changes",
        by: &[
            "robot.kind",
            "robot.preset",
            "robot.sensors",
            "robot.collision",
            "robot.motors",
        ],
    }));
    needs
}
