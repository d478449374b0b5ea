//! Described robots with sampled sensors and motors: the same bits as the sampled Khepera, readings by tables of any number of sensors
//! against plain look-ups, and what is refused.

use std::collections::BTreeSet;
use std::f64::consts::TAU;
use std::sync::Arc;

use oneiro::batch::{Batch, Outcome};
use oneiro::cpu::Cpu;
use oneiro::differential::{Build, Differential, Sensor, SensorKind};
use oneiro::evaluator::{Control, Evaluator};
use oneiro::random::pcg4d;
use oneiro::tables::{MotorStates, MotorTable, SENSOR_NAMES, SensorTable, SensorTables};
use oneiro::world::{Collision, Controller, Noise, World, WorldSpec};

use crate::composed::check;
use crate::described::{RADIUS, objects, ray, sensor, spec, subject, traces};
use crate::lives;
use crate::lives::choices::beside_a_block;

fn sampled(name: &str, column: Option<u32>) -> Sensor {
    Sensor {
        name: name.into(),
        kind: SensorKind::Sampled,
        column,
        ..Sensor::default()
    }
}

/// A Khepera that is described sensor by sensor, each of its own column or of another.
fn described_khepera(spec: &WorldSpec, column: impl Fn(u32) -> Option<u32>) -> WorldSpec {
    let sensors = SENSOR_NAMES
        .iter()
        .zip(0..)
        .map(|(name, place)| sampled(name, column(place)));
    let mut spec = spec.clone();
    spec.robot.build = Build::Differential(Differential {
        sensors: sensors.collect(),
        turn_before_move: (spec.robot.turn_before_move > 0.0).then_some(spec.robot.turn_before_move),
        ..Differential::sampled()
    });
    spec
}

/// Fitness and poses of each life, as bits.
fn bits(outcome: &Outcome) -> Vec<u32> {
    let poses = outcome.traces.iter().flat_map(|trace| trace.iter());
    let poses = poses.flat_map(|record| [record.x, record.y, record.heading, record.reward].map(f32::to_bits));
    let fitness = outcome.fitness.iter().map(|fitness| fitness.to_bits());
    fitness.chain(poses).collect()
}

/// The same lives in each of two worlds, on the CPU and on a GPU.
fn both(one: &WorldSpec, other: &WorldSpec) -> [Vec<u32>; 2] {
    let batch = |spec: &WorldSpec| -> Batch {
        let moderate = |_, genes: &mut [f32]| genes.iter_mut().for_each(|gene| *gene *= 0.6);
        lives::batch_with(&[World::new(spec.clone()).unwrap()], 300, Some(1), moderate)
    };
    [one, other].map(|spec| {
        let batch = batch(spec);
        let found = bits(&Cpu::new(Some(2)).unwrap().evaluate(&batch, &Control::new()).unwrap());
        #[cfg(feature = "gpu")]
        {
            let mut gpu = oneiro::gpu::Gpu::open(&oneiro::gpu::Choice::Best).unwrap();
            assert!(bits(&gpu.evaluate(&batch, &Control::new()).unwrap()) == found, "a GPU");
        }
        found
    })
}

/// Worlds of a Khepera with each kind of noise, collision and controller, between walls, cylinders and a block with points of view.
fn kheperas() -> Vec<WorldSpec> {
    let noisy = Noise {
        sensor: (-0.2, 0.2),
        motor: 0.1,
        ..Noise::CONSERVATIVE
    };
    let world = |noise, change: &dyn Fn(&mut WorldSpec)| {
        let mut spec = WorldSpec {
            noise,
            cycles: 200,
            ..WorldSpec::miglino1995()
        };
        change(&mut spec);
        spec
    };
    vec![
        world(Noise::NONE, &|_| ()),
        world(noisy, &|_| ()),
        world(noisy, &|spec| {
            beside_a_block(spec);
            spec.robot.collision = Collision::Slide;
        }),
        world(noisy, &|spec| {
            beside_a_block(spec);
            spec.robot.collision = Collision::KeepTurn;
            spec.controller = Controller::Hidden { units: 3 };
            spec.robot.motors = MotorTable::khepera(MotorStates::Evorobot21);
            spec.robot.turn_before_move = 0.5;
        }),
        world(Noise::SENSOR, &|spec| {
            spec.controller = Controller::Recurrent;
            spec.robot.collision = Collision::Stick;
        }),
    ]
}

/// A described robot with a Khepera's sensors and motors is the Khepera.
#[test]
fn a_khepera_lives_the_same_lives_when_it_is_described() {
    for khepera in kheperas() {
        let [own, described] = both(&khepera, &described_khepera(&khepera, |_| None));
        assert!(own == described, "{:?}", khepera.noise);
        let apart: BTreeSet<u32> = own[..300].iter().copied().collect();
        assert!(apart.len() > 150, "{} different lives", apart.len());
        // Two sensors of another order are another robot.
        let [_, other] = both(
            &khepera,
            &described_khepera(&khepera, |place| Some([0, 1, 3, 2, 4, 5, 6, 7][place as usize])),
        );
        assert!(own != other, "{:?}", khepera.noise);
    }
}

/// So is one whose sensors are spread over the columns of larger tables, with points of view and displaced perception.
#[test]
fn sensors_read_the_columns_that_they_name() {
    const COUNT: u32 = 20;
    let spread = |place: u32| (7 * place + 3) % COUNT;
    let wider = |table: &SensorTable| {
        let reading = |cell: usize, column: u32| match (0..8).find(|place| spread(*place) == column) {
            Some(place) => table.cell(cell)[place as usize],
            None => (pcg4d([cell as u32, column, 0, 0])[0] >> 22) as u16,
        };
        let cells = (0..table.cells()).flat_map(|cell| (0..COUNT).map(move |column| (cell, column)));
        SensorTable {
            sensors: COUNT,
            readings: cells.map(|(cell, column)| reading(cell, column)).collect(),
            ..table.clone()
        }
    };
    for khepera in kheperas() {
        let mut described = described_khepera(&khepera, |place| Some(spread(place)));
        let classes = khepera.robot.sensors.classes.iter().map(wider).collect();
        described.robot.sensors = Arc::new(SensorTables::new(classes));
        let [own, described] = both(&khepera, &described);
        assert!(own == described, "{:?}", khepera.noise);
    }
}

/// Late commands are the same ones, later; wheels that accelerate at once obey at once.
#[test]
fn sampled_motors_hear_late_to_the_bit() {
    let khepera = &kheperas()[1];
    let drive = |acceleration, latency| {
        let mut described = described_khepera(khepera, |_| None);
        if let Build::Differential(own) = &mut described.robot.build {
            (own.acceleration, own.latency) = (acceleration, latency);
        }
        described
    };
    let [own, at_once] = both(khepera, &drive(Some(0.0), Some(0)));
    assert!(own == at_once);
    let trace = &traces(drive(None, Some(4)), 20)[3];
    let table = &khepera.robot.motors;
    for (cycle, record) in trace.iter().enumerate() {
        let due = cycle.checked_sub(4).map(|then| {
            let [left, right] = [trace[then].left, trace[then].right].map(|output| (20.0 * output) as u32);
            table.cells[(left.min(19) * table.states + right.min(19)) as usize]
        });
        let due = due.unwrap_or_default();
        assert_eq!(
            (record.speed_left, record.speed_right),
            (due.left, due.right),
            "{cycle}"
        );
    }
    assert!(trace[4].x != trace[5].x && trace[0].x == trace[4].x);
    // At 10^6 mm/s^2 a wheel has its speed within a hundredth of a cycle.
    let [late, quick] = [None, Some(1e6)].map(|acceleration| traces(drive(acceleration, Some(4)), 20));
    for (late, quick) in late.iter().zip(&quick) {
        let [late, quick] = [late, quick].map(|trace| [trace[4].speed_left, trace[4].speed_right]);
        assert!(
            (late[0] - quick[0]).abs() < 1e-3 && (late[1] - quick[1]).abs() < 1e-3,
            "{late:?} {quick:?}"
        );
    }
}

/// A battery that no sensor reads changes nothing.
#[test]
fn sampled_motors_go_with_a_battery() {
    let khepera = &kheperas()[1];
    let mut described = described_khepera(khepera, |_| None);
    if let Build::Differential(own) = &mut described.robot.build {
        own.battery = Some(5.0);
    }
    let [own, with_battery] = both(khepera, &described);
    assert!(own == with_battery);
    if let Build::Differential(own) = &mut described.robot.build {
        own.battery_ends_life = Some(true);
    }
    assert!(
        both(khepera, &described)[1].len() < own.len(),
        "lives end after 50 cycles"
    );
}

const ROWS: u32 = 9;
const BEARINGS: u32 = 24;
const NEAREST: f32 = 3.0;
const SPACING: f32 = 7.0;
const VIEWS: u32 = 3;

/// Tables of this many sensors for walls and for the two objects of the described robots' arena.
fn tables(sensors: u32) -> SensorTables {
    let table = |(class, views): (&str, u32)| SensorTable {
        class: class.into(),
        sensors,
        rows: ROWS,
        bearings: BEARINGS,
        nearest: NEAREST,
        spacing: SPACING,
        views,
        readings: (0..views * ROWS * BEARINGS * sensors)
            .map(|at| (pcg4d([at, sensors, class.len() as u32, 1])[2] % 700) as u16)
            .collect(),
    };
    SensorTables::new([("wall", 1), ("anything", 1), ("whatever", VIEWS)].map(table).into())
}

/// What sensors read of tables at a place with a heading in radians, clipped to 0 to 1; `None` where rounding decides.
fn looked_up(tables: &SensorTables, at: [f64; 2], heading: f64) -> Option<Vec<f64>> {
    let mut sums = vec![0_u32; tables.sensors() as usize];
    let cell = |share: f64| ((share - share.round()).abs() > 1e-3).then_some(share.floor() as usize);
    for ((distance, direction), class) in objects(at).into_iter().zip([0, 0, 0, 0, 1, 2]) {
        let table = &tables.classes[class];
        let share = ((distance - RADIUS - f64::from(NEAREST)) / f64::from(SPACING)).max(0.5);
        let row = cell(share)?;
        if row >= ROWS as usize {
            continue;
        }
        let bearing = cell(((heading - direction) / TAU).rem_euclid(1.0) * f64::from(BEARINGS))?;
        let view = if class == 2 {
            let angle = (at[1] - 420.0).atan2(at[0] - 420.0) / TAU - 0.07;
            cell((2.0 * angle).rem_euclid(1.0) * f64::from(VIEWS))?
        } else {
            0
        };
        let place = (view * ROWS as usize + row) * BEARINGS as usize + bearing;
        for (sum, reading) in sums.iter_mut().zip(table.cell(place)) {
            *sum += u32::from(*reading);
        }
    }
    Some(sums.iter().map(|sum| (f64::from(*sum) / 1023.0).min(1.0)).collect())
}

/// A reading before noise, of a sensor among `count`.
fn real(details: &[u32], sensor: usize, count: usize) -> f64 {
    f64::from(f32::from_bits(details[count + sensor]))
}

/// Tables of one to 64 sensors, among sensors of other kinds.
#[test]
fn any_number_of_sensors_is_read() {
    for count in [1, 3, 7, 8, 13, 62, 64] {
        let others = if count > 62 { 0 } else { 2 };
        let spec = spec(|spec, robot| {
            spec.robot.sensors = Arc::new(tables(count));
            spec.controller = Controller::Perceptron;
            robot.sensors = (0..count).map(|column| sampled(&format!("s{column}"), None)).collect();
            if others > 0 {
                robot
                    .sensors
                    .insert(0, sensor("ahead", SensorKind::Proximity, 0.0, 100.0));
                robot.sensors.push(sensor("left", SensorKind::Distance, 0.2, 150.0));
            }
        });
        let all = count as usize + others;
        let (mut compared, mut felt, mut clipped, mut hits) = (0, 0, 0, 0);
        for trace in traces(spec, 60) {
            for (record, details) in trace.lines().step_by(3) {
                let at = [f64::from(record.x), f64::from(record.y)];
                let heading = f64::from(record.heading) * TAU;
                if others > 0 {
                    let expected = 1.0
                        - ray(
                            [at[0] + RADIUS * heading.cos(), at[1] + RADIUS * heading.sin()],
                            heading,
                            100.0,
                        ) / 100.0;
                    hits += u32::from(expected > 0.0 && (real(details, 0, all) - expected).abs() < 2e-3);
                }
                let Some(expected) = looked_up(&tables(count), at, heading) else {
                    continue;
                };
                compared += 1;
                for (column, expected) in expected.into_iter().enumerate() {
                    let found = real(details, column + usize::from(others > 0), all);
                    assert!(
                        (found - expected).abs() < 1e-6,
                        "{count} {column}: {found} {expected} {record:?}"
                    );
                    felt += u32::from(expected > 0.0);
                    clipped += u32::from(expected == 1.0);
                }
            }
        }
        assert!(
            compared > 2000 && felt > 400 && clipped > 0,
            "{count}: {compared} {felt} {clipped}"
        );
        assert!(others == 0 || hits > 200, "{count}: {hits}");
    }
}

/// Sensors in any order, some of a table's alone, and with displaced perception: the same bits on every device.
#[test]
fn all_devices_have_the_same_bits() {
    let columns = |columns: &'static [u32], noise: Noise| {
        spec(move |spec, robot| {
            spec.robot.sensors = Arc::new(tables(13));
            spec.noise = noise;
            robot.sensors.truncate(2);
            let own = columns
                .iter()
                .map(|column| sampled(&format!("s{column}"), Some(*column)));
            robot.sensors.splice(1..1, own);
        })
    };
    let displaced = Noise {
        motor: 0.1,
        sensor: (0.0, 0.3),
        ..Noise::CONSERVATIVE
    };
    let subjects = [
        subject("3 columns, noise", columns(&[12, 0, 5], displaced)),
        subject("a column", columns(&[9], Noise::NONE)),
    ];
    check(
        concat!(env!("CARGO_MANIFEST_DIR"), "/tests/goldens/composed/sampled.rows"),
        &subjects,
    );
}

/// The task takes the highest reading of the sampled sensors for the nearness of objects, too.
#[test]
fn sampled_sensors_are_near_objects() {
    let world = spec(|spec, robot| {
        spec.robot.sensors = Arc::new(tables(3));
        robot.sensors = (0..3).map(|column| sampled(&format!("s{column}"), None)).collect();
    });
    let mut near = 0;
    for trace in traces(world, 40) {
        for (record, details) in trace.lines().filter(|(record, _)| record.collided == 0.0) {
            let highest = (0..3).map(|sensor| real(details, sensor, 3)).fold(0.0, f64::max);
            let [left, right] = [record.speed_left, record.speed_right].map(f64::from);
            let free = 0.5 * (left.abs() + right.abs()) * (1.0 - (0.5 * (left - right).abs()).sqrt());
            assert!(
                (f64::from(record.reward) - free * (1.0 - highest)).abs() < 1e-5,
                "{record:?}"
            );
            near += u32::from(highest > 0.0);
        }
    }
    assert!(near > 500, "{near}");
}

#[test]
fn what_cannot_be_is_refused() {
    let refused = |change: &dyn Fn(&mut WorldSpec, &mut Differential)| {
        let own = spec(|spec, robot| {
            spec.robot.sensors = Arc::new(tables(7));
            robot.sensors = (0..3).map(|column| sampled(&format!("s{column}"), None)).collect();
            change(spec, robot);
        });
        World::new(own).unwrap_err().to_string()
    };
    for (expected, change) in [
        (
            "robot.sensors[1].column: is 7; allowed: 0 to 6, since the tables have 7 sensors",
            &(|_: &mut WorldSpec, robot: &mut Differential| robot.sensors[1].column = Some(7))
                as &dyn Fn(&mut WorldSpec, &mut Differential),
        ),
        ("robot.sensors[1].column: is 64; allowed: 0 to 63", &|_, robot| {
            robot.sensors[1].column = Some(64);
        }),
        (
            "robot.sensors[2].column: is 2, the column of `s0`; allowed: one that no other sensor has",
            &|_, robot| robot.sensors[0].column = Some(2),
        ),
        ("robot.sensors[2].column: is 2; allowed: 0 to 1, since", &|spec, _| {
            spec.robot.sensors = Arc::new(tables(2));
        }),
        ("robot.sensors[0].column: is 0, and there are no tables", &|spec, _| {
            spec.robot.sensors = Arc::new(SensorTables::new(Vec::new()));
        }),
        (
            "robot.sensors[0].range_mm: is given; allowed: not with kind = \"sampled\"",
            &|_, robot| robot.sensors[0].range = Some(50.0),
        ),
        (
            "robot.sensors[0].heading_turns: is given; allowed: not with kind = \"sampled\"",
            &|_, robot| robot.sensors[0].heading = 0.5,
        ),
        (
            "robot.sensors[3].column: is given; allowed: not with kind = \"proximity\"",
            &|_, robot| {
                let near = sensor("near", SensorKind::Proximity, 0.0, 50.0);
                robot.sensors.push(Sensor {
                    column: Some(3),
                    ..near
                });
            },
        ),
        ("arena.obstacles[0].class: no sensor table for `lamp`", &|spec, _| {
            spec.arena.obstacles[0].class = "lamp".into();
        }),
        (
            "arena.walls[0].class: `whatever` was sampled from 3 points of view",
            &|spec, _| spec.arena.walls[0].class = "whatever".into(),
        ),
        ("robot.sensors.classes[1]: has another shape", &|spec, _| {
            let mut own = tables(7);
            own.classes[1] = tables(6).classes[1].clone();
            spec.robot.sensors = Arc::new(own);
        }),
        (
            "robot.wheel_base_mm: is given; allowed: not with robot.motors",
            &|_, robot| {
                robot.sampled_motors = true;
            },
        ),
        (
            "robot.motors: have no speeds between states; allowed with acceleration or latency: at least 2 states",
            &|spec, robot| {
                let mut motors = (*spec.robot.motors).clone();
                motors.cells[3].left = 0.5;
                spec.robot.motors = Arc::new(motors);
                *robot = Differential {
                    latency: Some(1),
                    ..Differential::sampled()
                };
            },
        ),
        (
            "robot: lacks `greatest_speed_mm_s`; allowed: `wheel_base_mm` and",
            &|_, robot| {
                robot.greatest_speed = None;
            },
        ),
        (
            "robot.turn_before_move: is given; allowed: only with robot.motors",
            &|_, robot| {
                robot.turn_before_move = Some(0.5);
            },
        ),
    ] {
        let text = refused(change);
        assert!(text.starts_with(expected), "{text}\n{expected}");
    }
    let mut khepera = WorldSpec::miglino1995();
    khepera.robot.sensors = Arc::new(tables(7));
    let text = World::new(khepera).unwrap_err().to_string();
    let expected =
        "robot.sensors.classes[0].sensors: is 7; allowed: 8, a Khepera's, or robot.kind = \"differential\" with 7";
    assert!(text.starts_with(expected), "{text}");
}

/// Tables of any number of sensors are read, written, and refused by their lines.
#[test]
fn tables_of_any_number_of_sensors_survive_a_round_trip() {
    let folder = std::env::temp_dir().join(format!("oneiro-sampled-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    for count in [1, 3, 7, 13, 64] {
        for (table, name) in tables(count)
            .classes
            .iter()
            .zip(["wall.sam", "anything.sample", "whatever.sample"])
        {
            let path = folder.join(name);
            table.write(&path).unwrap();
            let import = SensorTable::read(&path).unwrap();
            assert_eq!((&import.table, import.warnings.len()), (table, 0), "{count} {name}");
            std::fs::remove_file(path).unwrap();
        }
    }
    let paths = ["wall.sam", "anything.sam"].map(|name| folder.join(name));
    tables(7).classes[0].write(&paths[0]).unwrap();
    tables(6).classes[1].write(&paths[1]).unwrap();
    let error = SensorTables::read(&paths).unwrap_err().to_string();
    let text = std::fs::read_to_string(&paths[0]).unwrap();
    let longer = text.replacen("TURN 1\n", "TURN 1\n5 ", 1);
    std::fs::write(&paths[0], longer).unwrap();
    let line = SensorTable::read(&paths[0]).unwrap_err();
    std::fs::remove_dir_all(&folder).unwrap();
    assert!(
        error.contains("anything.sam: 6 sensors, 9 rows") && error.contains("wall.sam has 7 sensors, 9 rows"),
        "{error}"
    );
    // The header, a line that begins row 0 and 24 bearings, and one that begins row 1.
    assert_eq!(line.line, Some(28));
    assert_eq!(line.problem, "8 numbers; allowed: 7 integers from 0 to 1023");
}

/// Traces name sampled sensors as they name others.
#[test]
fn genes_and_traces_are_named_by_the_sensors() {
    let world = World::new(spec(|spec, robot| {
        spec.robot.sensors = Arc::new(tables(3));
        robot.sensors.truncate(1);
        robot.sensors.extend(["nose", "tail"].map(|name| sampled(name, None)));
    }))
    .unwrap();
    let names = ["ahead", "nose", "tail"];
    let genes: Vec<String> = names.iter().map(|name| format!("{name}_to_left")).collect();
    assert_eq!(world.gene_layout().names()[..3], genes);
    let details: Vec<&str> = world.details().iter().map(|detail| detail.name.as_str()).collect();
    assert_eq!(details, [names, names].concat());
}
