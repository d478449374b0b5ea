//! Robots that are described rather than sampled: their motion and sensors against geometry in double precision, the same bits on
//! every device, and what is refused.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use oneiro::arena::{Arena, Light, Patch};
use oneiro::compose::{Kind, OwnPart, OwnParts, Part};
use oneiro::differential::{Differential, Law, Sensor, SensorKind};
use oneiro::surrogate::{Differences, Surrogate};
use oneiro::world::{Collision, Controller, Noise, Start, Task, World, WorldSpec};

use crate::composed::Subject;
use crate::described::{RADIUS, objects, ray, sensor, spec, subject, traces};

/// Each cycle is the arc on which wheels of those speeds roll.
#[test]
fn a_cycle_is_an_arc() {
    let mut seen = 0;
    for trace in traces(spec(|_, _| ()), 100) {
        for pair in trace.windows(2).filter(|pair| pair[0].collided == 0.0) {
            let [left, right] = [pair[0].left, pair[0].right].map(|output| 20.0 * (2.0 * f64::from(output) - 1.0));
            let (x, y, heading) = (pair[0].x, pair[0].y, f64::from(pair[0].heading) * TAU);
            let turn = (right - left) / 60.0;
            // By 1,000 small steps.
            let (mut x, mut y) = (f64::from(x), f64::from(y));
            for part in 0..1000 {
                let now = heading + turn * (f64::from(part) + 0.5) / 1000.0;
                x += 0.5 * (left + right) / 1000.0 * now.cos();
                y += 0.5 * (left + right) / 1000.0 * now.sin();
            }
            let found = [pair[1].x, pair[1].y].map(f64::from);
            assert!((found[0] - x).hypot(found[1] - y) < 1e-3, "{pair:?} {x} {y}");
            let off = f64::from(pair[1].heading) - (heading + turn) / TAU;
            assert!((off - off.round()).abs() < 1e-5, "{pair:?}");
            seen += u32::from(turn.abs() > 0.2);
        }
    }
    assert!(seen > 100, "{seen} sharp turns");
}

/// The speeds of a wheel that has few of them: evenly spaced, and exactly 0 in the middle and 1 at the ends.
#[test]
fn wheels_have_as_many_speeds_as_they_are_given() {
    for (count, least) in [(5, 5), (2, 2), (4, 4), (83, 60), (128, 90)] {
        let mut speeds: Vec<f32> = Vec::new();
        for trace in traces(spec(|_, robot| robot.speeds = count), 100) {
            for record in &trace {
                let steps = (count - 1) as f32;
                let wanted = 2.0 * (record.left * steps + 0.5).floor() / steps - 1.0;
                assert!((record.speed_left - wanted).abs() < 1e-6, "{record:?}");
                speeds.extend([record.speed_left, record.speed_right]);
            }
        }
        speeds.sort_by(f32::total_cmp);
        speeds.dedup();
        assert!(
            (least..=count as usize).contains(&speeds.len()),
            "{} of {count}",
            speeds.len()
        );
        assert_eq!((speeds[0], *speeds.last().unwrap()), (-1.0, 1.0));
        assert_eq!(speeds.contains(&0.0), count % 2 == 1);
    }
}

/// With nothing in range a reading is exactly 1 or 0, whatever the rounding of range and offset.
#[test]
fn nothing_in_range_is_exact() {
    for (range, offset) in [(47.0, None), (55.0, Some(35.5)), (110.0, Some(0.0)), (50.0, Some(36.7))] {
        let empty = spec(|spec, robot| {
            spec.arena = Arena {
                walls: Vec::new(),
                ..Arena::rectangle(600.0, 600.0)
            };
            robot.sensors = [SensorKind::Distance, SensorKind::Proximity]
                .map(|kind| Sensor {
                    offset,
                    ..sensor(["far", "near"][kind as usize], kind, 0.1, range)
                })
                .into();
        });
        for trace in traces(empty, 5) {
            for (_, details) in trace.lines() {
                assert_eq!(details[..2], [1.0_f32.to_bits(), 0], "{range} {offset:?}");
            }
        }
    }
}

#[test]
fn sensors_read_what_geometry_says() {
    let mut seen = [0; 5];
    for trace in traces(spec(|_, _| ()), 60) {
        for (record, details) in trace.lines().step_by(7) {
            let readings: Vec<f64> = details[5..10]
                .iter()
                .map(|word| f64::from(f32::from_bits(*word)))
                .collect();
            let (at, heading) = (
                [f64::from(record.x), f64::from(record.y)],
                f64::from(record.heading) * TAU,
            );
            let measured = |turns: f64, offset: f64, range: f64| {
                let angle = heading + turns * TAU;
                let start = [at[0] + offset * angle.cos(), at[1] + offset * angle.sin()];
                ray(start, angle, range) / range
            };
            let expected = [
                1.0 - measured(0.0, RADIUS, 100.0),
                measured(0.2, RADIUS, 150.0),
                measured(-0.45, 0.0, 90.0),
                f64::from(u8::from(objects(at).iter().any(|(distance, direction)| {
                    let off = (direction - heading + PI).rem_euclid(TAU) - PI;
                    distance - RADIUS < 5.0 && off.abs() <= 0.15 * TAU
                }))),
                1.0 - measured(-0.2, RADIUS, 80.0),
            ];
            for (sensor, (found, expected)) in readings.iter().zip(expected).enumerate() {
                // At an edge a ray hits or misses, and a bumper is pressed or not.
                if (found - expected).abs() > 2e-3 {
                    seen[sensor] -= 20;
                }
                seen[sensor] += i32::from(*found > 0.0 && *found < 1.0 || sensor == 3 && *found == 1.0);
            }
        }
    }
    // Thousands of readings that aren't at an end of the scale, and few that differ.
    assert!(seen.iter().all(|seen| *seen > 50), "{seen:?}");
}

/// Light by each law, hidden by objects, and the floor's grey, against the formulas in double precision.
#[test]
fn light_and_ground_are_read() {
    let laws = [Law::Linear, Law::Exponential, Law::InverseSquare];
    let eye = |index: usize, offset| Sensor {
        law: Some(laws[index]),
        offset,
        ..sensor(
            ["one", "two", "three"][index],
            SensorKind::Light,
            0.1 * index as f32,
            300.0,
        )
    };
    let spec = spec(|spec, robot| {
        robot.sensors = vec![
            eye(0, None),
            eye(1, Some(0.0)),
            eye(2, Some(10.0)),
            Sensor {
                range: None,
                ..sensor("floor", SensorKind::Ground, 0.25, 0.0)
            },
        ];
        let light = |x, y, brightness| Light {
            x,
            y,
            brightness,
            ..Light::default()
        };
        spec.arena.lights = vec![light(300.0, 590.0, 0.9), light(60.0, 80.0, 0.5)];
        spec.arena.floor = Some(0.75);
        let patch = Patch {
            x: 300.0,
            y: 200.0,
            ..Patch::default()
        };
        spec.arena.patches = vec![
            Patch {
                radius: Some(150.0),
                grey: 0.5,
                ..patch.clone()
            },
            Patch {
                sides: Some([300.0, 80.0]),
                heading: 0.15,
                grey: 0.25,
                ..patch
            },
        ];
    });
    let (mut lit, mut hidden, mut wrong, mut greys) = ([0; 3], 0, 0, Vec::new());
    for trace in traces(spec, 100) {
        for (record, details) in trace.lines().step_by(5) {
            let readings: Vec<f64> = details[4..8]
                .iter()
                .map(|word| f64::from(f32::from_bits(*word)))
                .collect();
            let (at, heading) = (
                [f64::from(record.x), f64::from(record.y)],
                f64::from(record.heading) * TAU,
            );
            let place = |turns: f64, offset: f64| {
                let angle = heading + turns * TAU;
                [at[0] + offset * angle.cos(), at[1] + offset * angle.sin()]
            };
            for (index, offset) in [RADIUS, 0.0, 10.0].into_iter().enumerate() {
                let turns = 0.1 * index as f64;
                let own = place(turns, offset);
                let mut sum = 0.0;
                for [x, y, brightness] in [[300.0, 590.0, 0.9], [60.0, 80.0, 0.5]] {
                    let (distance, direction) = ((x - own[0]).hypot(y - own[1]), (y - own[1]).atan2(x - own[0]));
                    let off = ((direction - heading - turns * TAU + PI).rem_euclid(TAU) - PI).abs();
                    let facing = (1.0 - off / (PI / 2.0)).max(0.0);
                    if ray(own, direction, distance) < distance - 1.0 {
                        hidden += u32::from(facing > 0.1);
                        continue;
                    }
                    let d = distance / 300.0;
                    let falloff = [(1.0 - d).max(0.0), (-d).exp(), 1.0 / (1.0 + d * d)][index];
                    sum += brightness * facing * falloff;
                }
                if (readings[index] - sum.min(1.0)).abs() > 1e-3 {
                    // A ray that grazes an object.
                    wrong += 1;
                }
                lit[index] += u32::from(sum > 0.05);
            }
            let [x, y] = place(0.25, RADIUS);
            let (sine, cosine) = (0.15 * TAU).sin_cos();
            let (along, across) = (
                (x - 300.0) * cosine + (y - 200.0) * sine,
                (y - 200.0) * cosine - (x - 300.0) * sine,
            );
            let edges = [
                along.abs() - 150.0,
                across.abs() - 40.0,
                (x - 300.0).hypot(y - 200.0) - 150.0,
            ];
            if edges.iter().all(|edge| edge.abs() > 0.1) {
                let expected = if edges[0] < 0.0 && edges[1] < 0.0 {
                    0.25
                } else if edges[2] < 0.0 {
                    0.5
                } else {
                    0.75
                };
                assert_eq!(readings[3], expected, "{record:?}");
                greys.push(expected);
            }
        }
    }
    assert!(lit.iter().all(|count| *count > 100) && hidden > 20, "{lit:?} {hidden}");
    assert!(wrong <= 20, "{wrong} of {lit:?}");
    greys.sort_by(f64::total_cmp);
    greys.dedup();
    assert_eq!(greys, [0.25, 0.5, 0.75]);
}

/// Noise is added to each reading by itself, and clipped; the readings before it stay.
#[test]
fn noise_is_each_sensors_own() {
    let noisy = spec(|spec, _| {
        spec.noise = Noise {
            sensor: (-0.2, 0.3),
            motor: 0.1,
            ..Noise::CONSERVATIVE
        };
    });
    let (mut above, mut count) = ([0.0; 5], [0.0; 5]);
    for trace in traces(noisy, 60) {
        for (record, details) in trace.lines() {
            let numbers: Vec<f32> = details.iter().map(|word| f32::from_bits(*word)).collect();
            let (perceived, real) = numbers.split_at(5);
            for sensor in 0..5 {
                let added = perceived[sensor] - real[sensor];
                assert!((0.0..=1.0).contains(&perceived[sensor]));
                assert!((-0.2 - 1e-6..0.3 + 1e-6).contains(&added), "{added}");
                if (0.3..0.7).contains(&real[sensor]) {
                    // Nothing is clipped, and 0.3 of 0.5 are above 0.
                    above[sensor] += f64::from(u8::from(added > 0.0));
                    count[sensor] += 1.0;
                }
            }
            assert_ne!((record.seen_x, record.seen_y), (record.x, record.y));
        }
    }
    // The bumper is 0 or 1.
    for sensor in [0, 1, 2, 4] {
        let share = above[sensor] / count[sensor];
        let enough = count[sensor] > 300.0 && (share - 0.6).abs() < 0.1;
        assert!(enough, "{sensor}: {share} of {}", count[sensor]);
    }
}

#[test]
fn genes_are_named_by_the_sensors() {
    for (controller, genes, name) in [
        (Controller::Perceptron, 12, "back_to_left"),
        (Controller::Hidden { units: 3 }, 26, "back_to_unit_0"),
        (Controller::Recurrent, 16, "back_to_left"),
    ] {
        let world = World::new(spec(|spec, _| spec.controller = controller)).unwrap();
        assert_eq!(world.genes(), genes);
        assert_eq!(world.gene_layout().names().len(), genes);
        assert_eq!(world.gene_layout().names()[2], name);
        assert!(world.kernel().name.contains("+5-sensors-"), "{}", world.kernel().name);
    }
    let bare = World::new(spec(|_, robot| robot.sensors.clear())).unwrap();
    assert_eq!(bare.gene_layout().names(), ["bias_left", "bias_right"]);
}

#[test]
fn what_cannot_be_is_refused() {
    let refused = |change: &dyn Fn(&mut WorldSpec, &mut Differential)| {
        World::new(spec(|spec, robot| change(spec, robot)))
            .unwrap_err()
            .to_string()
    };
    for name in ["", "2nd", "Left", "a-b", "a b"] {
        let text = refused(&|_, robot| robot.sensors[1].name = name.into());
        assert!(text.starts_with("robot.sensors[1].name: is `"), "{text}");
    }
    let text = refused(&|_, robot| robot.sensors[3].name = "ahead".into());
    assert!(
        text.contains("robot.sensors[3].name: is `ahead`; allowed: a name that no other"),
        "{text}"
    );
    let text = refused(&|_, robot| robot.speeds = 1);
    assert!(text.starts_with("robot.speeds: is 1"), "{text}");
    let text = refused(&|_, robot| robot.sensors[3].offset = Some(1.0));
    assert!(text.starts_with("robot.sensors[3].offset_mm: is given"), "{text}");
    for name in ["fn", "loop", "own", "target", "new", "struct"] {
        let text = refused(&|_, robot| robot.sensors[2].name = name.into());
        let expected =
            format!("robot.sensors[2].name: is `{name}`; allowed: a name that is neither `own` nor a reserved");
        assert!(text.starts_with(&expected), "{text}");
    }
    let text = refused(&|_, robot| robot.greatest_speed = Some(900.0));
    assert!(
        text.starts_with("robot.greatest_speed_mm_s: the maximum displacement"),
        "{text}"
    );
    let text = refused(&|_, robot| robot.wheel_base = Some(f32::NAN));
    assert!(text.starts_with("robot.wheel_base_mm"), "{text}");
    let text = refused(&|_, robot| robot.sensors[2].range = Some(0.0));
    assert!(text.starts_with("robot.sensors[2].range_mm"), "{text}");
    let text = refused(&|_, robot| robot.sensors[2].range = None);
    assert!(
        text.starts_with("robot.sensors[2]: lacks `range_mm`; allowed: the range"),
        "{text}"
    );
    let text = refused(&|_, robot| robot.sensors[2].width = Some(0.5));
    assert!(text.starts_with("robot.sensors[2].width_turns: is given"), "{text}");
    let text = refused(&|_, robot| robot.sensors[2].law = Some(Law::Linear));
    assert!(text.starts_with("robot.sensors[2].law: is given"), "{text}");
    let text = refused(&|spec, _| {
        spec.arena.patches = vec![Patch {
            x: 0.0,
            y: 0.0,
            ..Patch::default()
        }];
    });
    assert!(
        text.starts_with("arena.patches[0]: lacks `radius_mm` or `sides_mm`"),
        "{text}"
    );
    let text = refused(&|spec, _| {
        spec.arena.patches = vec![Patch {
            x: 0.0,
            y: 0.0,
            radius: Some(10.0),
            sides: Some([10.0; 2]),
            ..Patch::default()
        }];
    });
    assert!(
        text.starts_with("arena.patches[0]: has both `radius_mm` and `sides_mm`"),
        "{text}"
    );
    let light = Light {
        x: 1.0,
        y: 1.0,
        brightness: 1.0,
        ..Light::default()
    };
    let sampled = World::new(WorldSpec {
        arena: Arena {
            lights: vec![light],
            ..Arena::miglino1995()
        },
        ..WorldSpec::miglino1995()
    });
    assert!(sampled.unwrap_err().to_string().starts_with("arena.lights"));
    let text = refused(&|spec, _| spec.surrogate = Some(Surrogate::drawn(1, Differences::all(2.5)).into()));
    assert!(
        text.starts_with("surrogate.severity: is 2.5; allowed: 0 to 2"),
        "{text}"
    );
}

/// A described robot's readings by their index, those of its own sensors first.
#[test]
fn readings_have_an_index() {
    let fitness = |earned: &str| {
        let sensor_text = "struct SensorReadings { east: f32 }
            fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
                return Sensed(SensorReadings(cosine_sine(pose.z).x), before);
            }";
        let task = format!(
            "fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {{
                return Reward({earned}, before);
            }}"
        );
        let own = |kind, text: &str| {
            let part = Part::new(kind, "own.wgsl", text).unwrap();
            OwnPart::new(Arc::new(part), &[]).unwrap()
        };
        let traces = traces(
            spec(|spec, _| {
                spec.task = Task::Own;
                spec.own = OwnParts::from([own(Kind::Sensor, sensor_text), own(Kind::Task, &task)]);
            }),
            40,
        );
        traces
            .iter()
            .map(|trace| trace[trace.len() - 1].fitness.to_bits())
            .collect::<Vec<_>>()
    };
    for (index, name) in ["ahead", "left", "back", "bump", "right", "own.east", "own.east"]
        .iter()
        .enumerate()
    {
        let by_name = fitness(&format!("now.real.{name}"));
        assert_eq!(fitness(&format!("reading(now.real, {index}u)")), by_name, "{name}");
        assert!(by_name.iter().any(|bits| *bits != by_name[0]), "{name} shows");
    }
}

/// Loops that turn too often are those of the robot's own sensors, or of a user's part.
#[test]
fn too_many_turns_name_what_makes_them() {
    let refused = |sensors: usize, turns: u32| {
        let text = format!(
            "fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {{
                var sum = 0.0f;
                for (var i = 0u; i < {turns}u; i++) {{ sum = 0.5f * sum + now.moved.left; }}
                return Reward(sum, before);
            }}"
        );
        let task = OwnPart::new(Arc::new(Part::new(Kind::Task, "own.wgsl", &text).unwrap()), &[]).unwrap();
        let world = World::new(spec(|spec, robot| {
            let lamp = |index: usize| sensor(&format!("lamp_{index}"), SensorKind::Light, 0.0, 500.0);
            robot.sensors = (0..sensors).map(lamp).collect();
            spec.arena.lights = vec![
                Light {
                    x: 300.0,
                    y: 300.0,
                    brightness: 1.0,
                    ..Light::default()
                };
                64
            ];
            spec.arena.obstacles = vec![spec.arena.obstacles[0].clone(); 40];
            (spec.task, spec.own) = (Task::Own, OwnParts::from([task]));
        }));
        world.map_or_else(|invalid| invalid.to_string(), |_| "none".to_owned())
    };
    assert_eq!(refused(4, 10), "none");
    assert!(
        refused(4, 100_000).starts_with("task.part: loops up to 11"),
        "{}",
        refused(4, 100_000)
    );
    for turns in [10, 100_000] {
        let problem = refused(64, turns);
        assert!(problem.starts_with("robot.sensors: loops up to"), "{problem}");
    }
}

#[test]
fn a_robot_that_sticks_stays_for_good() {
    let sticking = spec(|spec, _| {
        spec.robot.collision = Collision::Stick;
        spec.start = Start::At {
            x: 300.0,
            y: 100.0,
            heading: 0.1,
        };
    });
    let mut stuck = 0;
    for trace in traces(sticking, 60) {
        let Some(first) = trace.iter().position(|record| record.collided > 0.0) else {
            continue;
        };
        // The cycle of the collision is made, and is the last that is.
        assert_ne!(
            (trace[first].x, trace[first].y),
            (trace[first + 1].x, trace[first + 1].y)
        );
        for record in &trace[first + 1..] {
            assert_eq!((record.x, record.y), (trace[first + 1].x, trace[first + 1].y));
            assert_eq!((record.heading, record.collided), (trace[first + 1].heading, 1.0));
            assert_eq!(record.reward, 0.0);
        }
        stuck += 1;
    }
    assert!(stuck > 10, "{stuck}");
}

/// Episodes that are pinned ([`crate::composed`]).
pub(crate) fn subjects() -> Vec<Subject> {
    let noisy = |spec: &mut WorldSpec| {
        spec.noise = Noise {
            motor: 0.1,
            ..Noise::SENSOR
        };
    };
    let lit = |spec: &mut WorldSpec, robot: &mut Differential| {
        let law = Some(Law::Exponential);
        for (name, range) in [("eye", 5.0), ("other", 200.0)] {
            robot.sensors.push(Sensor {
                law,
                ..sensor(name, SensorKind::Light, 0.1, range)
            });
        }
        robot.sensors.push(Sensor {
            range: None,
            ..sensor("floor", SensorKind::Ground, 0.0, 0.0)
        });
        robot.speeds = 83;
        spec.arena.lights = vec![Light {
            x: 300.0,
            y: 300.0,
            brightness: 0.7,
            ..Light::default()
        }];
        spec.arena.patches = vec![Patch {
            x: 300.0,
            y: 300.0,
            radius: Some(200.0),
            ..Patch::default()
        }];
    };
    vec![
        subject("noise", spec(|spec, _| noisy(spec))),
        subject("sticking", spec(|spec, _| spec.robot.collision = Collision::Stick)),
        subject("lamps and patches", spec(|spec, robot| lit(spec, robot))),
    ]
}
