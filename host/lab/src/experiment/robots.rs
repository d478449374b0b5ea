//! Robots by name: descriptions that ship, which an experiment may change key by key.

use oneiro::parameter::{Datum, Field, nearest};
use oneiro_base::exit::{Failure, Result};
use toml::{Table, Value};

use super::source::Source;
use super::values::instead;

/// Names of robots, and their descriptions: experiments with a robot only.
const ROBOTS: [(&str, &str); 6] = [
    ("khepera", include_str!("robots/khepera.toml")),
    ("epuck", include_str!("robots/epuck.toml")),
    ("thymio2", include_str!("robots/thymio2.toml")),
    ("kheperax", include_str!("robots/kheperax.toml")),
    ("epuck-rm1.1", include_str!("robots/epuck-rm1.1.toml")),
    ("epuck-rm1.2", include_str!("robots/epuck-rm1.2.toml")),
];

/// Keys of a parametric robot's wheels.
const WHEELS: [&str; 5] = [
    "wheel_base_mm",
    "greatest_speed_mm_s",
    "speeds",
    "acceleration_mm_s2",
    "latency_cycles",
];

/// A robot that ships.
#[derive(Clone, Copy, Debug)]
pub struct Shipped {
    pub name: &'static str,
    /// An experiment with this robot only, with comments.
    pub(super) text: &'static str,
}

impl Shipped {
    /// The robot of a name.
    ///
    /// # Errors
    /// Exit 3: the name, and the allowed names.
    pub fn named(name: &str) -> Result<Self> {
        let found = ROBOTS.iter().find(|(known, _)| *known == name);
        found.map(|&(name, text)| Self { name, text }).ok_or_else(|| {
            let instead = instead(nearest(ROBOTS.iter().map(|(known, _)| *known), name), &names());
            Failure::input(format_args!("--robot {name}: is unknown{instead}"))
        })
    }

    /// Whether it is only for swarms: it has a reference model.
    pub fn is_for_swarms(&self) -> bool {
        values(self.text).contains_key("model")
    }

    /// Whether several may share a world: swarms need robots that move at most 0.75 of their radius in a cycle.
    pub fn may_swarm(&self) -> bool {
        let robot = values(self.text);
        let number = |key: &str| robot.get(key).and_then(Value::as_float).unwrap_or_default();
        number("greatest_speed_mm_s") / 10.0 <= 0.75 * number("body_radius_mm")
    }

    /// Whether it has this key.
    pub(super) fn has(&self, key: &str) -> bool {
        values(self.text).contains_key(key)
    }
}

/// All names, separated by commas.
pub fn names() -> String {
    ROBOTS.map(|(name, _)| name).join(", ")
}

/// Name of the robot that an experiment changes. Experiments with all their values have the robot's values instead of its name, so that
/// a change of the robot that ships doesn't affect them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Preset(pub Option<String>);

impl Field for Preset {
    fn get(&self) -> Option<Datum> {
        None
    }

    fn set(&mut self, datum: &Datum) -> bool {
        let Datum::Word(name) = datum else {
            return false;
        };
        self.0 = Some(name.clone());
        true
    }

    fn kind(&self) -> &'static str {
        "a word"
    }
}

/// The values of an experiment, completed with those of the robot that it names. Lists are taken whole, unless their elements are named
/// by number.
///
/// # Errors
/// Exit 3: the place, the name, and the allowed names.
pub(super) fn described(mut given: Table, source: &Source<'_>) -> Result<Table> {
    let robot = given.get_mut("robot").and_then(Value::as_table_mut);
    let Some((robot, name)) = robot.and_then(|robot| robot.get("preset").cloned().map(|name| (robot, name))) else {
        return Ok(given);
    };
    let found = ROBOTS.iter().find(|(known, _)| name.as_str() == Some(known));
    let Some((name, text)) = found else {
        let meant = name
            .as_str()
            .and_then(|name| nearest(ROBOTS.iter().map(|(known, _)| *known), name));
        let problem = format!("is {name}{}", instead(meant, &names()));
        return Err(source.invalid("robot.preset", problem));
    };
    let preset = values(text);
    if robot.get("kind").is_some_and(|kind| *kind != preset["kind"]) {
        let problem = format!(
            "is {}, and robot.preset is \"{name}\"; allowed: {}",
            robot["kind"], preset["kind"]
        );
        return Err(source.invalid("robot.kind", problem));
    }
    // Sampled motors replace wheels.
    let has_motors = robot.contains_key("motors");
    // Swarms have a different rule for bodies that meet, so they leave out a single robot's `collision`.
    let has_count = robot.contains_key("count");
    for (key, value) in preset {
        if !(has_motors && WHEELS.contains(&key.as_str()) || has_count && key == "collision") {
            let value = match (robot.get(&key), value) {
                (Some(Value::Table(own)), Value::Array(list)) => with_elements(list, own, &key, source)?,
                (Some(own), _) => own.clone(),
                (None, value) => value,
            };
            robot.insert(key, value);
        }
    }
    Ok(given)
}

/// A robot's list, with an experiment's values of some of its elements, by their number.
fn with_elements(mut list: Vec<Value>, own: &Table, key: &str, source: &Source<'_>) -> Result<Value> {
    let count = list.len();
    for (number, value) in own {
        match (number.parse().ok().and_then(|index: usize| list.get_mut(index)), value) {
            (Some(Value::Table(element)), Value::Table(value)) => element.extend(value.clone()),
            (Some(element), value) => *element = value.clone(),
            (None, _) => {
                let problem = format_args!(
                    "is no element of the robot's list; allowed: 0 to {}",
                    count.saturating_sub(1)
                );
                return Err(source.invalid(&format!("robot.{key}.{number}"), problem));
            }
        }
    }
    Ok(Value::Array(list))
}

/// The values of a robot that ships.
fn values(text: &str) -> Table {
    let mut whole: Table = text.parse().expect("a test reads each of them");
    match whole.remove("robot") {
        Some(Value::Table(robot)) => robot,
        _ => Table::new(),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::f64::consts::TAU;

    use super::*;

    #[test]
    fn each_robot_has_nothing_but_a_description() {
        for (name, text) in ROBOTS {
            let whole: Table = text.parse().unwrap();
            assert_eq!(whole.keys().collect::<Vec<_>>(), ["robot"], "{name}");
            assert_eq!(values(text)["kind"].as_str(), Some("differential"), "{name}");
        }
    }

    /// Numbers of sensors by their kinds.
    #[test]
    fn each_robot_has_the_sensors_that_the_page_lists() {
        let kinds = |text: &str| {
            let mut kinds = BTreeMap::new();
            for sensor in values(text)["sensors"].as_array().unwrap() {
                *kinds.entry(sensor["kind"].as_str().unwrap().to_owned()).or_insert(0) += 1;
            }
            let kinds = kinds.into_iter().map(|(kind, count)| format!("{count} {kind}"));
            kinds.collect::<Vec<_>>().join(", ")
        };
        let found = ROBOTS.map(|(name, text)| format!("{name}: {}", kinds(text)));
        assert_eq!(
            found,
            [
                "khepera: 8 proximity",
                "epuck: 3 ground, 8 light, 8 proximity",
                "thymio2: 2 ground, 7 proximity",
                "kheperax: 2 bumper, 3 distance",
                "epuck-rm1.1: ",
                "epuck-rm1.2: ",
            ]
        );
    }

    /// Positions of sensors in the sources, mm from the middle between the wheels, and their directions, degrees.
    #[test]
    fn sensors_are_where_the_sources_have_them() {
        let [(_, khepera), (_, epuck), (_, thymio), (_, kheperax), ..] = ROBOTS;
        for (text, name, [x, y], look) in [
            (khepera, "left_90", [12.0, 24.5], 85.0),
            (khepera, "left_45", [21.0, 18.5], 45.0),
            (khepera, "left_10", [27.0, 7.5], 0.0),
            (khepera, "right_10", [27.0, -7.5], 0.0),
            (khepera, "right_45", [21.0, -18.5], -45.0),
            (khepera, "right_90", [12.0, -24.5], -85.0),
            (khepera, "back_right", [-26.0, -9.0], 180.0),
            (khepera, "back_left", [-26.0, 9.0], 180.0),
            (epuck, "prox_0", [34.427, -10.525], -17.0),
            (epuck, "prox_1", [23.140, -27.578], -50.0),
            (epuck, "prox_2", [0.0, -36.0], -90.0),
            (epuck, "prox_3", [-31.177, -18.0], -150.0),
            (epuck, "prox_4", [-31.177, 18.0], 150.0),
            (epuck, "prox_5", [0.0, 36.0], 90.0),
            (epuck, "prox_6", [23.140, 27.578], 50.0),
            (epuck, "prox_7", [34.427, 10.525], 17.0),
            (epuck, "light_1", [0.0, 0.0], -50.0),
            (epuck, "light_7", [0.0, 0.0], 17.0),
            (epuck, "ground_left", [30.0, 9.0], 16.699),
            (epuck, "ground_centre", [30.0, 0.0], 0.0),
            (epuck, "ground_right", [30.0, -9.0], -16.699),
            (thymio, "prox_0", [62.0, 48.5], 40.0),
            (thymio, "prox_1", [75.0, 25.5], 20.0),
            (thymio, "prox_2", [79.5, 0.0], 0.0),
            (thymio, "prox_3", [75.0, -25.5], -20.0),
            (thymio, "prox_4", [62.0, -48.5], -40.0),
            (thymio, "prox_5", [-29.5, 29.5], 180.0),
            (thymio, "prox_6", [-29.5, -29.5], 180.0),
            (thymio, "ground_left", [72.0, 11.5], 9.075),
            (thymio, "ground_right", [72.0, -11.5], -9.075),
            (kheperax, "right", [0.0, 0.0], -45.0),
            (kheperax, "left", [0.0, 0.0], 45.0),
        ] {
            let robot = values(text);
            let sensors = robot["sensors"].as_array().unwrap();
            let sensor = sensors
                .iter()
                .find(|sensor| sensor["name"].as_str() == Some(name))
                .unwrap();
            let number = |key: &str| sensor.get(key).and_then(Value::as_float);
            let heading = number("heading_turns").unwrap();
            let angle = TAU * number("bearing_turns").unwrap_or(heading);
            let offset = number("offset_mm").unwrap();
            let off = (offset * angle.cos() - x).hypot(offset * angle.sin() - y);
            assert!(
                off < 0.01 && (360.0 * heading - look).abs() < 0.002,
                "{name}: {off} {heading}"
            );
        }
    }

    /// A reading of a robot's first sensor at a distance, mm, by the points of its response.
    fn read(text: &str, at: f64) -> f64 {
        let robot = values(text);
        let points = robot["sensors"][0]["response"].as_array().unwrap().iter();
        let points: Vec<_> = points
            .map(|point| [0, 1].map(|axis| point[axis].as_float().unwrap()))
            .collect();
        match points.iter().position(|[distance, _]| *distance > at) {
            Some(0) => points[0][1],
            Some(after) => {
                let [near, far] = [points[after - 1], points[after]];
                near[1] + (far[1] - near[1]) * (at - near[0]) / (far[0] - near[0])
            }
            None => points[points.len() - 1][1],
        }
    }

    /// The maximum difference between that and a formula, up to a range in steps of 0.1 mm.
    fn off(text: &str, range: u32, formula: impl Fn(f64) -> f64) -> f64 {
        let distances = (0..=10 * range).map(|step| 0.1 * f64::from(step));
        let off = distances.map(|at| (read(text, at) - formula(at).clamp(0.0, 1.0)).abs());
        off.fold(0.0, f64::max)
    }

    /// The curves that the files name, as their sources have them.
    #[test]
    fn responses_are_those_of_the_sources() {
        let argos = |mm: f64| {
            let metres = mm / 1000.0;
            298.701 * metres * metres - 36.8961 * metres + 1.08212
        };
        let enki = |mm: f64| {
            let cm = mm / 10.0;
            (73.0 - 0.03 * 0.03) / (cm * cm - 2.0 * 0.03 * cm + 73.0)
        };
        let [_, (_, epuck), (_, thymio), ..] = ROBOTS;
        assert!(off(epuck, 50, argos) < 0.002);
        assert!(off(thymio, 140, enki) < 0.0035);
        assert!(off(epuck, 50, enki) > 0.1);
    }

    /// Readings of the middle sensor of a Thymio II at a wall in Aseba's playground 1.6.99: distance in mm, and reading out of 4505.
    #[test]
    fn a_thymio_reads_what_the_playground_shows() {
        let seen = [
            (5.0, 4488.0),
            (10.0, 4440.0),
            (20.0, 4267.0),
            (30.0, 4004.0),
            (40.0, 3688.0),
            (60.0, 3011.0),
            (80.0, 2394.0),
            (100.0, 1896.0),
            (120.0, 1511.0),
        ];
        let [_, _, (_, thymio), ..] = ROBOTS;
        for (at, value) in seen {
            let off = (read(thymio, at) - value / 4505.0).abs();
            assert!(off < 0.005, "{at}: {off}");
        }
    }
}
