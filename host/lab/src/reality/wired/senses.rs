//! From the readings of a robot's sensors to the activations that a world's controller gets.

use oneiro::differential::{Build, Scale, Sensor, SensorKind};
use oneiro::parameter::Choice;
use oneiro::tables::{GREATEST_READING, SENSOR_NAMES};
use oneiro::world::WorldSpec;
use oneiro_robots::Kind;
use oneiro_robots::vehicle::Profile;

/// How a reading becomes an activation. Readings have a range from 0 to a maximum.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Law {
    /// Rounded to an integer from 0 to 1023, as tables have it, and multiplied by the tables' scale.
    Sampled { greatest: f64, scale: f32 },
    /// The reading as a fraction of the maximum.
    Share { greatest: f64 },
    /// 1 minus that fraction: the brighter the light, the lower robots read.
    Rest { greatest: f64 },
}

impl Law {
    fn activation(self, reading: f64) -> f32 {
        let share = |greatest: f64| (reading / greatest).clamp(0.0, 1.0);
        match self {
            Self::Sampled { greatest, scale } => {
                let integer = (share(greatest) * f64::from(GREATEST_READING)).round();
                (integer as f32 * scale).min(1.0)
            }
            Self::Share { greatest } => share(greatest) as f32,
            Self::Rest { greatest } => (1.0 - share(greatest)) as f32,
        }
    }
}

/// A reading of the world's robot.
#[derive(Clone, Debug, PartialEq)]
struct Sense {
    /// Its name in the world.
    name: String,
    /// Index of the robot's reading.
    source: usize,
    law: Law,
    /// How it responds to obstacles that come nearer: 1 if it grows, -1 if it falls from 1, 0 if it does not.
    nearness: f32,
}

/// All readings of the world's robot, in its order, and where each is from.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Senses(Vec<Sense>);

/// A reading that a world's robot has.
struct Wanted<'a> {
    name: &'a str,
    kind: SensorKind,
    /// The sensor, if the robot is parametric.
    sensor: Option<&'a Sensor>,
}

fn wanted(spec: &WorldSpec) -> Vec<Wanted<'_>> {
    match &spec.robot.build {
        Build::Sampled => SENSOR_NAMES
            .iter()
            .map(|name| Wanted {
                name,
                kind: SensorKind::Sampled,
                sensor: None,
            })
            .collect(),
        Build::Differential(own) => own
            .sensors
            .iter()
            .map(|sensor| Wanted {
                name: &sensor.name,
                kind: sensor.kind,
                sensor: Some(sensor),
            })
            .collect(),
        Build::Forager(_) => Vec::new(),
    }
}

/// The kind of real sensor that reads the same as a world's sensor.
fn kind_of(wanted: &Wanted<'_>) -> Result<Kind, String> {
    let kind = |kind: SensorKind| {
        let name = kind.entry().counterpart?.kind;
        Kind::CHOICES
            .iter()
            .find(|choice| choice.0 == name)
            .map(|choice| choice.1)
    };
    kind(wanted.kind).ok_or_else(|| {
        let all = SensorKind::CHOICES.iter();
        let allowed: Vec<&str> = all.filter(|own| kind(own.1).is_some()).map(|own| own.0).collect();
        format!(
            "sensor {}: is of the kind {}, which no connected robot has; allowed: {}",
            wanted.name,
            wanted.kind.word(),
            allowed.join(", ")
        )
    })
}

/// Kinds of sensors that a world's robot has.
///
/// # Errors
/// A sensor of a kind that no connected robot has.
pub(super) fn kinds(spec: &WorldSpec) -> Result<Vec<Kind>, String> {
    if let Build::Forager(_) = spec.robot.build {
        return Err(
            "robot.kind is `forager`, whose food exists only in its simulator; allowed: another kind of robot"
                .to_owned(),
        );
    }
    let mut kinds = Vec::new();
    for wanted in wanted(spec) {
        let kind = kind_of(&wanted)?;
        if !kinds.contains(&kind) {
            kinds.push(kind);
        }
    }
    Ok(kinds)
}

impl Senses {
    /// Finds each of the world's readings among a robot's: under the name in `renamed`, which has pairs of the world's and the
    /// robot's names, otherwise under the world's name, with or without the kind before it: `proximity_left_90` is the Khepera's
    /// `left_90`.
    ///
    /// # Errors
    /// A sensor that the robot lacks, and its sensors of that kind; a renamed one that the world lacks.
    pub(super) fn new(spec: &WorldSpec, profile: &Profile, renamed: &[(String, String)]) -> Result<Self, String> {
        let all = wanted(spec);
        if let Some((name, _)) = renamed.iter().find(|(name, _)| all.iter().all(|own| own.name != name)) {
            let names: Vec<&str> = all.iter().map(|own| own.name).collect();
            return Err(format!(
                "sensor {name}: is none of the experiment's; allowed: {}",
                names.join(", ")
            ));
        }
        let sense = |own: &Wanted<'_>| Self::sense(own, spec, profile, renamed);
        all.iter().map(sense).collect::<Result<_, _>>().map(Self)
    }

    fn sense(
        own: &Wanted<'_>,
        spec: &WorldSpec,
        profile: &Profile,
        renamed: &[(String, String)],
    ) -> Result<Sense, String> {
        let kind = kind_of(own)?.to_string();
        let renamed = renamed.iter().find(|(name, _)| name == own.name);
        let of_kind = || profile.sensors.iter().filter(|sensors| sensors.kind == kind);
        let is_it = |name: &str| match renamed {
            Some((_, robots)) => name == robots,
            None => name == own.name || name.strip_prefix(&*kind) == Some(&*format!("_{}", own.name)),
        };
        let mut first = 0;
        let mut found = None;
        for sensors in &profile.sensors {
            if sensors.kind == kind
                && let Some(index) = sensors.names.iter().position(|name| is_it(name))
            {
                found = Some((first + index, sensors.range.1));
            }
            first += sensors.names.len();
        }
        let Some((source, greatest)) = found else {
            let names: Vec<&str> = of_kind()
                .flat_map(|sensors| &sensors.names)
                .map(String::as_str)
                .collect();
            let robot = &profile.robot;
            let lacked = renamed.map_or(own.name, |(_, robots)| robots);
            return Err(match names[..] {
                [] => format!("sensor {}: the {robot} has none of the kind {kind}", own.name),
                _ => format!(
                    "sensor {}: the {robot} has no sensor {lacked} of the kind {kind}; allowed: {}={}",
                    own.name,
                    own.name,
                    names.join(&format!(", {}=", own.name))
                ),
            });
        };
        let counterpart = own.kind.entry().counterpart;
        let law = match counterpart.map_or(Scale::Greatest, |own| own.scale) {
            Scale::Samples => Law::Sampled {
                greatest,
                scale: spec.robot.sensors.reading_scale,
            },
            Scale::Range => Law::Share {
                greatest: own.sensor.and_then(|sensor| sensor.range).map_or(greatest, f64::from),
            },
            Scale::Rest => Law::Rest { greatest },
            Scale::Greatest => Law::Share { greatest },
        };
        Ok(Sense {
            name: own.name.into(),
            source,
            law,
            nearness: counterpart.map_or(0.0, |own| own.nearness),
        })
    }

    /// Names of the activations.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|sense| sense.name.as_str())
    }

    /// The activations for a robot's readings.
    pub(super) fn activations(&self, readings: &[f64]) -> Vec<f32> {
        self.0
            .iter()
            .map(|sense| sense.law.activation(readings[sense.source]))
            .collect()
    }

    /// How near obstacles are by each activation: 0 for none, 1 for the nearest. Sensors that do not measure obstacles give 0.
    pub(super) fn obstacles(&self, activations: &[f32]) -> Vec<f64> {
        let near = |(sense, activation): (&Sense, &f32)| match sense.nearness {
            0.0 => 0.0,
            1.0.. => f64::from(*activation),
            _ => 1.0 - f64::from(*activation),
        };
        self.0.iter().zip(activations).map(near).collect()
    }
}

#[cfg(test)]
pub(super) mod tests {
    use oneiro::differential::Differential;
    use oneiro::world::Robot;

    use super::*;
    use oneiro_robots::guard::message::Sensors;

    fn sensors(kind: &str, names: &[&str], greatest: f64) -> Sensors {
        Sensors {
            kind: kind.into(),
            names: names.iter().map(|name| (*name).to_owned()).collect(),
            unit: String::new(),
            range: (0.0, greatest),
        }
    }

    /// A Khepera that only reads its proximity sensors.
    pub(in super::super) fn khepera() -> Profile {
        let names = SENSOR_NAMES.map(|name| format!("proximity_{name}"));
        Profile {
            robot: "Khepera".into(),
            firmware: "5.02".into(),
            sensors: vec![sensors("proximity", &names.each_ref().map(String::as_str), 1023.0)],
            greatest_mm_s: 200.0,
            unit_mm_s: 8.2,
            base_mm: 53.0,
            has_odometers: true,
        }
    }

    fn described(sensors: &[(&str, SensorKind)]) -> WorldSpec {
        let sensors = sensors.iter().map(|(name, kind)| Sensor {
            name: (*name).into(),
            kind: *kind,
            range: Some(500.0),
            ..Sensor::default()
        });
        WorldSpec {
            robot: Robot {
                build: Build::Differential(Differential {
                    sensors: sensors.collect(),
                    ..Differential::new(53.0, 100.0)
                }),
                ..Robot::khepera()
            },
            ..WorldSpec::miglino1995()
        }
    }

    /// The driver's names are those of the tables, in the same order, and every reading keeps its bits.
    #[test]
    fn a_kheperas_readings_are_those_of_the_tables() {
        let spec = WorldSpec::miglino1995();
        assert_eq!(kinds(&spec), Ok(vec![Kind::Proximity]));
        let senses = Senses::new(&spec, &khepera(), &[]).unwrap();
        assert!(senses.names().eq(SENSOR_NAMES));
        for raw in 0..=1023_u16 {
            let mut readings = [0.0; 8];
            readings[usize::from(raw % 8)] = f64::from(raw);
            let activations = senses.activations(&readings);
            let expected = (f32::from(raw) * spec.robot.sensors.reading_scale).min(1.0);
            assert_eq!(activations[usize::from(raw % 8)].to_bits(), expected.to_bits());
            assert_eq!(
                activations.iter().filter(|activation| **activation > 0.0).count(),
                usize::from(raw > 0)
            );
        }
    }

    #[test]
    fn described_sensors_are_found_by_kind_and_name() {
        let kinds_of = [
            ("prox_0", SensorKind::Proximity),
            ("left", SensorKind::Ground),
            ("ahead", SensorKind::Distance),
            ("lamp", SensorKind::Light),
        ];
        let spec = described(&kinds_of);
        let expected = [Kind::Proximity, Kind::Ground, Kind::Distance, Kind::Light];
        assert_eq!(kinds(&spec), Ok(expected.into()));
        let profile = Profile {
            robot: "e-puck2".into(),
            sensors: vec![
                sensors("light", &["prox_0", "light_0"], 4095.0),
                sensors("proximity", &["prox_7", "prox_0"], 4095.0),
                sensors("ground", &["ground_left"], 1000.0),
                sensors("distance", &["distance_front"], 65_535.0),
            ],
            ..khepera()
        };
        let renamed = [("ahead", "distance_front"), ("lamp", "light_0")].map(|(a, b)| (a.into(), b.into()));
        let senses = Senses::new(&spec, &profile, &renamed).unwrap();
        let activations = senses.activations(&[1.0, 1023.75, 9.0, 819.0, 250.0, 125.0]);
        assert_eq!(activations, [0.2, 0.25, 0.25, 0.75]);
        assert_eq!(senses.obstacles(&activations), [f64::from(0.2_f32), 0.0, 0.75, 0.0]);
        // Nothing is beyond 0 and 1.
        assert_eq!(
            senses.activations(&[0.0, -5.0, 0.0, 9999.0, -1.0, 501.0]),
            [1.0, 0.0, 1.0, 1.0]
        );
        for (renamed, words) in [
            (
                &renamed[..1],
                "sensor lamp: the e-puck2 has no sensor lamp of the kind light; allowed: lamp=prox_0, lamp=light_0",
            ),
            (
                &[("lamps".into(), "light_0".into())],
                "sensor lamps: is none of the experiment's; allowed: prox_0, left,",
            ),
        ] {
            let refusal = Senses::new(&spec, &profile, renamed).unwrap_err();
            assert!(refusal.contains(words), "{refusal}");
        }
        let refusal = Senses::new(&spec, &khepera(), &[]).unwrap_err();
        assert!(
            refusal
                .contains("the Khepera has no sensor prox_0 of the kind proximity; allowed: prox_0=proximity_left_90")
        );
        let refusal = kinds(&described(&[("bump", SensorKind::Bumper)])).unwrap_err();
        assert!(refusal.contains("sensor bump: is of the kind bumper"), "{refusal}");
    }
}
