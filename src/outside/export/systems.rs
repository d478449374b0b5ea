//! A controller as a program of a simulator's robots, or as a node of ROS 2: its code in Lua, C or Python, between what the robots of that
//! system read and how they drive.

use std::fmt::Write;

use super::c::{code, comment};
use super::objects::{lua, python};
use super::pieces::{fields, is_seed};
use super::{Controller, Fitted, Input, PERIOD, Recorded};
use crate::parameter::Invalid;
use crate::parts::compose::HEAD;

use crate::world::Build;
use crate::world::differential::{Differential, GREATEST_POINTS, Sensor, SensorKind};
use crate::world::reference::{Model, Reference};

/// Prints a controller as a script for ARGoS's e-puck.
///
/// # Errors
/// A robot that reads what ARGoS's e-puck doesn't.
pub fn argos(controller: &Controller, name: &str, origin: &[String], cycles: &[Recorded]) -> Result<Fitted, Invalid> {
    let (robot, full_speed) = parametric(controller, "argos", "epuck")?;
    let mut inputs = String::new();
    for input in &controller.inputs {
        let place = match (listed(robot, input), robot.model) {
            (Some(sensor), _) => of_argos(sensor)?,
            (None, Some(model)) if model.readings().contains(&input.name) => {
                of_model(model, &robot.reference, &input.name)
            }
            _ => {
                return Err(missing(
                    "argos",
                    input,
                    "proximity, light and ground sensors, and robot.model",
                ));
            }
        };
        let _ = writeln!(inputs, "        {place}, -- {}", input.name);
    }
    let has_model = robot.model.is_some();
    let of_model = |text: &'static str| if has_model { text } else { "" };
    let filled = [
        ("model", of_model(include_str!("systems/argos-model.txt")).to_owned()),
        ("forget", of_model("    forget()\n").to_owned()),
        ("sense", of_model("    sense()\n").to_owned()),
        // ARGoS has the distance of the bodies, whose radius is 35 mm, ours is that of their centres.
        ("reach", format!("{:?}", (robot.reference.range() - 70.0) / 10.0)),
        ("cycles", robot.reference.cycles().to_string()),
        ("attraction", format!("{:?}", robot.reference.factor())),
        ("period", (1000.0 * PERIOD).round().to_string()),
        ("full speed", format!("{:?}", full_speed / 10.0)),
        ("seeds", only_seeds(controller, ["drawn()", "drawn()"])),
        ("inputs", inputs),
        ("controller", lua(controller, name, origin, cycles)),
    ];
    Ok(exact(fill(include_str!("systems/argos.txt"), &filled)))
}

/// Directions of the rings of ARGoS's e-puck, of proximity and of light, degrees counter-clockwise from straight ahead.
///
/// Source: github.com/demiurge-project/argos3-epuck, `ci_epuck_proximity_sensor.cpp` and `ci_epuck_light_sensor.cpp`.
const ARGOS_RING: [f32; 8] = [17.0, 50.0, 90.0, 150.0, 210.0, 270.0, 310.0, 343.0];

/// Maximum angle between these and a sensor's direction, degrees.
const BESIDE: f32 = 5.0;

/// Where a script of ARGoS's e-puck reads a sensor of a list.
fn of_argos(sensor: &Sensor) -> Result<String, Invalid> {
    let ring = |what: &str| {
        let degrees: f32 = (360.0 * sensor.heading).rem_euclid(360.0);
        let found = ARGOS_RING.iter().position(|there| (degrees - there).abs() <= BESIDE);
        found
            .map(|place| format!("robot.{what}[{}].value", place + 1))
            .ok_or_else(|| {
                let allowed = ARGOS_RING.map(|degrees| degrees.to_string()).join(", ");
                let problem =
                    format!("looks to {degrees:.1} degrees; allowed for argos: {allowed}, up to {BESIDE} beside");
                Invalid::new(format!("robot.sensors: {}", sensor.name), problem)
            })
    };
    let aside = sensor.heading - sensor.heading.round();
    match sensor.kind {
        SensorKind::Proximity => ring("proximity"),
        SensorKind::Light => ring("light"),
        SensorKind::Ground if aside.abs() > 0.25 => {
            let problem = "is behind the body's centre; allowed for argos: ground sensors in front".to_owned();
            Err(Invalid::new(format!("robot.sensors: {}", sensor.name), problem))
        }
        SensorKind::Ground if aside > 0.0 => Ok("robot.ground.left".to_owned()),
        SensorKind::Ground if aside < 0.0 => Ok("robot.ground.right".to_owned()),
        SensorKind::Ground => Ok("robot.ground.center".to_owned()),
        _ => {
            let problem = format!(
                "is a {} sensor; allowed for argos: proximity, light, ground",
                sensor.kind.entry().name
            );
            Err(Invalid::new(format!("robot.sensors: {}", sensor.name), problem))
        }
    }
}

/// The same of a reading of a reference model, from what `argos-model.txt` computes.
fn of_model(model: Model, reference: &Reference, reading: &str) -> String {
    let (what, which) = reading.split_once('_').unwrap_or((reading, ""));
    let vector = match (what, model) {
        ("prox", Model::Rm12) => "shortened(sum_of(robot.proximity))",
        ("light", Model::Rm12) => "toward_light()",
        ("prox", _) => "sum_of(robot.proximity)",
        ("light", _) => "sum_of(robot.light)",
        (_, Model::Rm11) => "squashed(attraction)",
        _ => "attraction",
    };
    match (what, which, model) {
        ("neighbours", _, Model::Vectors) => "heard".to_owned(),
        ("neighbours", ..) => "1 - 2 / (1 + math.exp(math.min(heard, 40)))".to_owned(),
        ("ground", _, Model::Vectors) => "by_vote(0.5)".to_owned(),
        ("ground", side, _) => {
            let side = ["left", "middle", "right"]
                .iter()
                .position(|own| *own == side)
                .unwrap_or(0);
            let [mean, deviation] = reference.grey()[side];
            format!("by_vote(grey({mean:?}, {deviation:?}))")
        }
        (_, "ahead", _) => format!("{vector}.x"),
        (_, "left", _) => format!("{vector}.y"),
        ("prox" | "light", place, Model::Rm11) => {
            let ring = if what == "prox" { "proximity" } else { what };
            format!("robot.{ring}[{place} + 1].value")
        }
        (_, degrees, _) => format!("along({vector}, {degrees})"),
    }
}

/// Prints a controller as a C program for robots of Webots.
///
/// # Errors
/// A robot with sensors that Webots has no counterpart of.
pub fn webots(controller: &Controller, name: &str, origin: &[String], cycles: &[Recorded]) -> Result<Fitted, Invalid> {
    let (robot, full_speed) = parametric(controller, "webots", "khepera")?;
    let mut sensors = String::new();
    for input in &controller.inputs {
        let refused = || missing("webots", input, "proximity, distance, ground and light sensors");
        let sensor = listed(robot, input).ok_or_else(refused)?;
        let range = sensor.range.unwrap_or_default();
        let (kind, straight) = match sensor.kind {
            SensorKind::Proximity => ("OF_DISTANCE", vec![[0.0, 1.0], [range, 0.0]]),
            SensorKind::Distance => ("OF_DISTANCE", vec![[0.0, 0.0], [range, 1.0]]),
            SensorKind::Ground => ("OF_GROUND", vec![[0.0, 0.0]]),
            SensorKind::Light => ("OF_LIGHT", vec![[0.0, 0.0]]),
            _ => return Err(refused()),
        };
        let points = sensor.response.as_ref().map_or(&straight, |response| &response.0);
        let beyond = if sensor.kind == SensorKind::Distance {
            1.0_f32
        } else {
            0.0
        };
        let listed: Vec<_> = points
            .iter()
            .map(|[distance, reading]| format!("{{{distance:?}, {reading:?}}}"))
            .collect();
        let _ = writeln!(
            sensors,
            "    {{\"{}\", {kind}, {range:?}, {beyond:?}, {}, {{{}}}}},",
            sensor.name,
            points.len(),
            listed.join(", ")
        );
    }
    if sensors.is_empty() {
        // No array is empty.
        sensors += "    {\"\", OF_DISTANCE, 0.0, 0.0, 0, {{0.0}}},\n";
    }
    let filled = [
        ("name", name.to_owned()),
        ("points", GREATEST_POINTS.to_string()),
        ("sensors", sensors),
        ("full speed", format!("{full_speed:?}")),
        ("seeds", seeds(controller, ["SEED", "of_name()"])),
        (
            "comment",
            comment(
                controller,
                name,
                origin,
                "A robot controller of Webots: controllers/NAME/NAME.c of a project.",
            )
            .replace("NAME", name),
        ),
        ("controller", code(controller, name, cycles, "static ")),
    ];
    Ok(exact(fill(include_str!("systems/webots.txt"), &filled)))
}

/// Lines of a node whose controller draws random numbers.
const SEED: &str = "        # Random numbers begin with it and with the node's name.
        self.declare_parameter(\"seed\", 1)
        self.seed = self.get_parameter(\"seed\").value % 2**32
";

/// Prints a controller as a package of ROS 2 with a node in Python.
pub fn ros2(controller: &Controller, name: &str, origin: &[String], cycles: &[Recorded]) -> Vec<(String, String)> {
    let robot = &controller.world.spec().robot;
    let wheel_base = match &robot.build {
        Build::Sampled => None,
        Build::Differential(robot) => robot.wheel_base,
        Build::Forager(forager) => Some(forager.foraging.wheel_base),
    };
    let meters = |millimeters: Option<f32>| format!("{:?}", f64::from(millimeters.unwrap_or(0.0)) / 1000.0);
    let inputs: Vec<_> = controller
        .inputs
        .iter()
        .map(|input| format!("    \"{}\",\n", input.name))
        .collect();
    let of_seed = |text: &str| {
        if controller.draws() {
            text.to_owned()
        } else {
            String::new()
        }
    };
    let filled = [
        ("name", name.to_owned()),
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("inputs", inputs.concat()),
        ("period", format!("{PERIOD:?}")),
        ("full speed", meters(controller.full_speed)),
        ("wheel base", meters(wheel_base)),
        (
            "seeds",
            only_seeds(
                controller,
                ["self.seed", "crc32(self.get_fully_qualified_name().encode())"],
            ),
        ),
        ("imports", of_seed("from zlib import crc32\n")),
        ("seed", of_seed(SEED)),
    ];
    let file = |path: &str, text: &str| (fill(path, &filled), fill(text, &filled));
    vec![
        file("package.xml", include_str!("systems/ros2-package.txt")),
        file("setup.py", include_str!("systems/ros2-setup.txt")),
        file(
            "setup.cfg",
            "[develop]\nscript_dir=$base/lib/@name@\n[install]\ninstall_scripts=$base/lib/@name@\n",
        ),
        file("resource/@name@", ""),
        file("@name@/__init__.py", ""),
        file("@name@/node.py", include_str!("systems/ros2-node.txt")),
        (
            format!("{name}/controller.py"),
            python(controller, name, origin, cycles),
        ),
    ]
}

/// A file with the simulator's bits.
fn exact(text: String) -> Fitted {
    Fitted {
        bytes: text.into_bytes(),
        note: None,
    }
}

/// A robot that an experiment describes, and its wheels' full speed, mm/s. A preset is an example of one that the target takes.
fn parametric<'a>(controller: &'a Controller, target: &str, preset: &str) -> Result<(&'a Differential, f32), Invalid> {
    let build = &controller.world.spec().robot.build;
    build.described().zip(controller.full_speed).ok_or_else(|| {
        let why = match build {
            Build::Forager(_) => "is a forager, of whose food other programs know nothing",
            _ => "was sampled, which says nothing of its sensors in other programs",
        };
        let problem = format!("{why}; allowed for {target}: parametric robots, such as `robot.preset = \"{preset}\"`");
        Invalid::new("robot", problem)
    })
}

/// The sensor of a robot's list that an input is the reading of.
fn listed<'a>(robot: &'a Differential, input: &Input) -> Option<&'a Sensor> {
    robot.sensors.iter().find(|sensor| sensor.name == input.name)
}

fn missing(target: &str, input: &Input, allowed: &str) -> Invalid {
    Invalid::new(
        input.name.clone(),
        format!("is no reading there; allowed for {target}: those of {allowed}"),
    )
}

/// The numbers that an episode begins with, each after a comma: the words of its key, if the controller draws, and its trial.
fn seeds(controller: &Controller, key: [&str; 2]) -> String {
    let seeds = fields(controller).into_iter().filter(is_seed);
    seeds.fold(String::new(), |all, field| {
        all + ", "
            + HEAD
                .iter()
                .zip(key)
                .find(|(name, _)| **name == field.name)
                .map_or("0", |(_, word)| word)
    })
}

/// The same without the first comma.
fn only_seeds(controller: &Controller, key: [&str; 2]) -> String {
    seeds(controller, key).trim_start_matches(", ").to_owned()
}

/// Fills in the places between `@` of a text.
fn fill(text: &str, places: &[(&str, String)]) -> String {
    places.iter().fold(text.to_owned(), |text, (place, content)| {
        text.replace(&format!("@{place}@"), content)
    })
}
