//! Values that tests try for a key.

use oneiro::parameter::{Allowed, Parameter};
use toml::{Table, Value};

use super::values::{self, Described};

/// Values to try that can't be made up from the row and the value at hand.
const VALUES: &[(&str, &[&str])] = &[
    ("robot.genomes", &["'heterogeneous'", "'homogeneous'", "[0, 0, 1]"]),
    (
        "robot.starts_mm",
        &["[[70, 60], [150, 60], [60, 150]]", "[[80, 100], [200, 100]]"],
    ),
    ("pucks.places_mm", &["[[130, 70], [70, 130], [250, 200]]"]),
    ("pucks.count", &["1", "4"]),
    ("robot.preset", &["'thymio2'", "'kheperax'", "'epuck'"]),
    (
        "robot.tables",
        &[
            "'khepera'",
            "'surrogate:1'",
            "['../tests/transfer/epuck/wall.sam', '../tests/transfer/epuck/round.sam']",
            "'reality'",
        ],
    ),
    ("robot.motors", &["'khepera'", "'surrogate:1'", "'reality'"]),
    ("arena.preset", &["'open'", "'octagon'"]),
    ("arena.corners_mm", &["[[0, 0], [600, 0], [600, 600], [0, 600]]"]),
    ("start.poses", &["[[70, 60, 0.1], [230, 60, 0.2]]"]),
    ("worlds.vary", &["{ 'arena.obstacles[0].x_mm' = [100, 140] }"]),
    ("worlds.choose", &["{ 'arena.obstacles[0].radius_mm' = [12, 22] }"]),
    ("evolution.init", &["'TWO'"]),
    ("evolution.initial_shares", &["SHARES"]),
    ("evolution.finalists", &["0", "1", "3"]),
    ("evolution.episodes", &["120", "400"]),
    ("robot.sensors[].name", &["'zz'"]),
    ("robot.sensors[].response", &["[[0, 1], [30, 0.2]]"]),
    ("evolution.opponents.first_gene", &["'prey_to_left_1'"]),
    (
        "evolution.descriptors[].measure",
        &["'distance_mm'", "'wall_distance_mm'"],
    ),
    ("evolution.descriptors[].least", &["-500.0", "100.0"]),
    ("arena.floor", &["0.0", "1.0", "0.4"]),
    (
        "arena.picture.file",
        &["'line-follower/track.png'", "'map-maze/map.png'"],
    ),
    ("arena.wall_height_mm", &["10.0", "200.0"]),
    ("robot.body_height_mm", &["10.0", "300.0"]),
    ("sensor.part", &["'road-sign/sensors.wgsl'"]),
    ("controller.part", &["'road-sign/ctrnn.wgsl'"]),
    (
        "task.part",
        &[
            "'phototaxis/task.wgsl'",
            "'evostick/shelter.wgsl'",
            "'kheperax/task.wgsl'",
        ],
    ),
    ("sensor.values", &["{ lamp = 0.1 }"]),
    ("task.values", &["{ cycles = 50 }"]),
    ("controller.values", &["{ prey_speed = 0.7 }"]),
    ("reality.robot", &["'surrogate:2'"]),
    ("reality.sensors", &["{ left_90 = 'x' }"]),
    ("reality.tracker", &["'udp:127.0.0.1:5005'"]),
    ("reality.guard", &["{ expiry_ms = 250 }"]),
    ("arena.walls[].class", &["'round'", "'wall'", "'block'"]),
    ("arena.obstacles[].class", &["'round'", "'wall'", "'block'"]),
    ("arena.blocks[].class", &["'round'", "'wall'", "'block'"]),
    ("test", &["{ cycles = 33 }"]),
    ("files", &["{ x = '00' }"]),
    ("name", &["'other'"]),
];

/// Other values to try for a row, given the one that it has.
pub fn others<T: Described>(row: &Parameter<T>, now: Option<&Value>) -> Vec<Value> {
    let mut own = values::with_default(row);
    let field = (row.field)(&mut own, 0).expect("every row has its field somewhere");
    let mut found: Vec<Value> = field.choices().iter().map(|(word, _)| Value::from(*word)).collect();
    let is_flag = field.kind() == "true or false";
    if is_flag {
        found.extend([true, false].map(Value::from));
    }
    let listed = VALUES.iter().find(|(key, _)| *key == row.key);
    for text in listed.iter().flat_map(|(_, texts)| *texts) {
        let text = match *text {
            "SHARES" => format!("[{}]", vec!["0.5"; 18].join(", ")),
            other => other.to_owned(),
        };
        let table: Table = format!("x = {text}").parse().unwrap();
        found.push(table["x"].clone());
    }
    if let Some(Value::Array(list)) = now
        && list.first().is_some_and(Value::is_table)
    {
        found.push(list[1..].to_vec().into());
    }
    if !found.is_empty() || listed.is_some() {
        found.retain(|value| Some(value) != now);
        return found;
    }
    let near = |now: f64| {
        [
            now * 1.3,
            now * 0.7,
            now + 0.1,
            now - 0.1,
            now * 3.0,
            now + 1.0,
            now + 30.0,
        ]
    };
    let number = |value: &Value| value.as_float().or(value.as_integer().map(|number| number as f64));
    let whole = matches!(row.allowed, Allowed::Whole(..) | Allowed::WholeUpTo(..));
    match (now, now.and_then(number)) {
        (_, Some(now)) if whole => {
            let now = now as i64;
            found.extend([now + 1, now - 1, now.saturating_mul(2), now / 2, now + 2].map(Value::from));
        }
        (_, Some(now)) => found.extend(near(now).map(Value::from)),
        (Some(Value::Array(list)), _) => {
            let each: Vec<[f64; 7]> = list.iter().filter_map(number).map(near).collect();
            for index in 0..7 {
                found.push(each.iter().map(|own| own[index]).collect::<Vec<_>>().into());
            }
            if let [low, high] = &each[..] {
                found.extend([[low[1], high[0]], [low[0], high[1]]].map(|pair| Value::from(pair.to_vec())));
            }
        }
        _ if whole => found.extend([1, 2, 3, 5, 10].map(Value::from)),
        _ => {
            let numbers = [0.1, 0.5, 1.0, 2.0, 20.0, 60.0, 100.0];
            found.extend(numbers.map(Value::from));
            found.extend(numbers.map(|number| Value::from(vec![number, 2.0 * number])));
            found.extend(numbers.map(|number| Value::from(vec![-number, number])));
        }
    }
    found.retain(|value| Some(value) != now);
    found
}

/// Whether a refusal names a key, a table of keys, or a value within a key's.
pub fn names_a_key<T: Described>(message: &str) -> bool {
    let is_place = |part: &&str| *part != "SET" && !part.contains(".toml");
    let key = message.split(": ").find(is_place).unwrap_or_default();
    let key = key.strip_prefix("set.").unwrap_or(key);
    let mut plain = String::new();
    for (index, part) in key.split('[').enumerate() {
        plain += if index == 0 { "" } else { "[]" };
        plain += part.split_once(']').map_or(part, |(_, rest)| rest);
    }
    let is_key = |row: &Parameter<T>| {
        let ends = |longer: &str, shorter: &str| {
            let rest = longer.strip_prefix(shorter);
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
        };
        ends(row.key, &plain) || ends(&plain, row.key)
    };
    // A mistake in a part has a place in that part.
    message.contains(".wgsl:") || T::rows().iter().any(is_key)
}
