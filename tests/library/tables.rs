//! Sampled tables: import, export, and refusals.

use std::path::{Path, PathBuf};

use oneiro::tables::{MotorSamples, MotorStates, MotorTable, SENSORS, SensorTable, SensorTables};
use oneiro::world::{Robot, World, WorldSpec};

use crate::skips::skipped;

/// An empty folder for one test.
fn scratch(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("tables").join(test);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn written(folder: &Path, name: &str, text: &str) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path
}

/// Recordings of a real Khepera, if this machine has them; they aren't part of this project.
fn recordings() -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/khepera");
    let folder = std::env::var_os("ONEIRO_RECORDINGS").map_or(beside, PathBuf::from);
    if folder.join("wall.sam").exists() {
        return Some(folder);
    }
    skipped("recordings", "files that others wrote");
    None
}

/// Writes a table in both formats and reads it again.
fn round_trip(table: &SensorTable, folder: &Path) {
    for extension in ["sam", "sample"] {
        let path = folder.join(&table.class).with_extension(extension);
        table.write(&path).unwrap();
        let again = SensorTable::read(&path).unwrap();
        assert_eq!(&again.table, table);
        assert_eq!(again.warnings, Vec::<String>::new());
    }
}

#[test]
fn built_in_tables_survive_a_round_trip() {
    let folder = scratch("built_in");
    let tables = SensorTables::khepera();
    assert_eq!(tables.classes.len(), 2);
    for table in &tables.classes {
        round_trip(table, &folder);
    }
}

#[test]
fn recordings_survive_a_round_trip() {
    let Some(recordings) = recordings() else { return };
    let folder = scratch("recordings");
    for (class, rows, warnings) in [("wall", 20, 0), ("round", 20, 0), ("small", 20, 0), ("light", 26, 1)] {
        let import = SensorTable::read(recordings.join(class).with_extension("sam")).unwrap();
        assert_eq!((import.table.rows, import.table.bearings), (rows, 180), "{class}");
        // One row of the light's recording has another row's number.
        assert_eq!(import.warnings.len(), warnings, "{class}: {:?}", import.warnings);
        round_trip(&import.table, &folder);
    }
    let motors = MotorSamples::read(recordings.join("motor.sam")).unwrap();
    motors.write(folder.join("motor.sam")).unwrap();
    assert_eq!(MotorSamples::read(folder.join("motor.sam")).unwrap(), motors);
}

#[test]
fn recorded_motors_are_like_the_built_in_ones() {
    let Some(recordings) = recordings() else { return };
    let recorded = MotorTable::read(recordings.join("motor.sam"), MotorStates::Symmetric20).unwrap();
    let built_in = MotorTable::khepera(MotorStates::Symmetric20);
    for (recorded, built_in) in recorded.cells.iter().zip(&built_in.cells) {
        assert!((recorded.displacement - built_in.displacement).abs() < 1e-5);
        assert!((recorded.turn - built_in.turn).abs() * 360.0 < 0.002);
        assert_eq!((recorded.left, recorded.right), (built_in.left, built_in.right));
    }
}

#[test]
fn built_in_motors_are_a_khepera() {
    let table = MotorTable::khepera(MotorStates::Symmetric20);
    assert_eq!((table.states, table.cells.len()), (20, 400));
    let cell = |left: usize, right: usize| table.cells[left * 20 + right];
    // Straight ahead at full speed: 8.2 mm in 100 ms. State 19 is the speed 10, state 10 the speed 1.
    assert!((cell(19, 19).displacement - 8.2).abs() < 1e-5);
    assert_eq!(
        (cell(19, 19).turn, cell(19, 19).left, cell(19, 19).right),
        (0.0, 1.0, 1.0)
    );
    assert!((cell(0, 0).displacement + 8.2).abs() < 1e-5);
    // The right wheel faster by one unit: 0.87 degrees counter-clockwise.
    assert!((cell(10, 11).turn * 360.0 - 0.87).abs() < 0.001);
    assert!((cell(11, 10).turn * 360.0 + 0.87).abs() < 0.001);
    assert_eq!((cell(9, 10).left, cell(9, 10).right), (-0.1, 0.1));

    let asymmetric = MotorTable::khepera(MotorStates::Asymmetric20);
    assert_eq!((asymmetric.states, asymmetric.cells[399].left), (20, 0.9));
    let evorobot = MotorTable::khepera(MotorStates::Evorobot21);
    assert_eq!(
        (
            evorobot.states,
            evorobot.cells[10 * 21 + 10].displacement,
            evorobot.offset
        ),
        (21, 0.0, 0.5)
    );
}

/// As sampled from a robot whose wheels hardly differ.
#[test]
fn motion_below_what_kernels_take_is_none() {
    let mut samples = MotorSamples::khepera();
    let place = |speed| samples.speeds.iter().position(|own| *own == speed).unwrap();
    let [ahead, back] = [1, -1].map(|speed| place(speed) * (samples.speeds.len() + 1));
    (samples.degrees[ahead], samples.centimetres[back]) = (3e-4, -9e-8);
    let table = MotorTable::new(&samples, MotorStates::Symmetric20).unwrap();
    let spec = WorldSpec {
        robot: Robot {
            motors: table.into(),
            ..Robot::khepera()
        },
        ..WorldSpec::miglino1995()
    };
    World::new(spec).unwrap();
}

#[test]
fn motors_survive_a_round_trip() {
    let folder = scratch("motors");
    let samples = MotorSamples::khepera();
    let path = folder.join("motor.sam");
    samples.write(&path).unwrap();
    assert_eq!(MotorSamples::read(&path).unwrap(), samples);
    for states in [
        MotorStates::Symmetric20,
        MotorStates::Asymmetric20,
        MotorStates::Evorobot21,
    ] {
        assert_eq!(MotorTable::read(&path, states).unwrap(), *MotorTable::khepera(states));
    }

    // An even number of speeds leaves out 0.
    let even = written(&folder, "even.sam", "0 -1\n1 0\n-2 0\n0 2\n");
    let samples = MotorSamples::read(&even).unwrap();
    assert_eq!(samples.speeds, [-1, 1]);
    assert_eq!(samples.centimetres, [-2.0, 0.0, 0.0, 2.0]);
    let error = MotorTable::read(&even, MotorStates::Symmetric20).unwrap_err();
    assert!(
        error.problem.contains("has no speed -10") && error.problem.contains("allowed:"),
        "{error}"
    );
}

#[test]
fn equal_tables_are_noticed() {
    let folder = scratch("equal");
    let wall = &SensorTables::khepera().classes[0];
    let paths = [folder.join("wall.sam"), folder.join("round.sample")];
    for path in &paths {
        wall.write(path).unwrap();
    }
    let import = SensorTables::read(&paths).unwrap();
    assert_eq!(import.table.class("round"), Some(1));
    assert_eq!(import.warnings.len(), 1);
    assert!(
        import.warnings[0].contains("hold the same readings"),
        "{:?}",
        import.warnings
    );

    let error = SensorTables::read(&[&paths[0], &paths[0]]).unwrap_err();
    assert!(error.problem.contains("a second table of the class wall"), "{error}");
    let other = SensorTable {
        class: "small".into(),
        rows: 19,
        readings: wall.readings[8 * 180..].to_vec(),
        ..wall.clone()
    };
    other.write(folder.join("small.sam")).unwrap();
    let error = SensorTables::read(&[folder.join("wall.sam"), folder.join("small.sam")]).unwrap_err();
    assert!(error.problem.contains("allowed: tables of one shape"), "{error}");
}

#[test]
fn points_of_view_survive_a_round_trip() {
    let folder = scratch("views");
    let mut table = SensorTables::khepera().classes[0].clone();
    table.class = "block".into();
    table.views = 3;
    let view = |view: u16| table.readings.iter().map(move |reading| reading / view);
    table.readings = (1..=3).flat_map(view).collect();
    for name in ["block.sam", "block.sample"] {
        let path = folder.join(name);
        table.write(&path).unwrap();
        let import = SensorTable::read(&path).unwrap();
        assert_eq!((import.table, import.warnings.len()), (table.clone(), 0), "{name}");
        std::fs::remove_file(path).unwrap();
    }
    // The last view lacks a row, or the number of views is wrong.
    let text = table.text();
    let short = text.replace("TURN 59\n", "END\n");
    let error = SensorTable::read(written(&folder, "short.sam", &short)).unwrap_err();
    assert!(error.problem.contains("row 59 begins here"), "{error}");
    let none = text.replacen("5 2 3\n", "5 2 0\n", 1);
    let error = SensorTable::read(written(&folder, "none.sam", &none)).unwrap_err();
    assert!(error.line == Some(1) && error.problem.contains("2 to 64"), "{error}");
}

#[test]
fn shares_that_are_no_readings_are_rounded_with_a_warning() {
    let folder = scratch("rounded");
    let mut text = String::from("8 4 1 5 2\nTURN 0\n");
    text.push_str("0.0 1.0 0.5 0.25 0.000978 0.1 0 1\n");
    text.push_str(&"0 0 0 0 0 0 0 0\n".repeat(3));
    text.push_str("END");
    let import = SensorTable::read(written(&folder, "mean.sample", &text)).unwrap();
    assert_eq!(import.table.cell(0), [0, 1023, 512, 256, 1, 102, 0, 1023]);
    assert!(
        import.warnings[0].contains("3 readings are no multiples"),
        "{:?}",
        import.warnings
    );
}

#[test]
fn no_file_is_overwritten() {
    let folder = scratch("overwritten");
    let path = written(&folder, "wall.sam", "mine");
    assert!(SensorTables::khepera().classes[0].write(&path).is_err());
    assert!(MotorSamples::khepera().write(&path).is_err());
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "mine");
}

/// Text of a small table with one replacement.
fn broken(from: &str, to: &str) -> String {
    let row = |row: u32| {
        let bearing = |bearing: u32| format!("{row} {bearing} 2 3 4 5 6 7 \r\n");
        format!("TURN {row} \r\n") + &(0..4).map(bearing).collect::<String>()
    };
    let text = format!("8 4 2 5 2\r\n{}{}END", row(0), row(1));
    assert!(from.is_empty() || text.contains(from), "{from}");
    text.replacen(from, to, 1)
}

#[test]
fn bad_sensor_tables_are_refused_with_the_line() {
    let folder = scratch("bad_sensors");
    let good = SensorTable::read(written(&folder, "good.sam", &broken("", ""))).unwrap();
    assert_eq!(
        (good.table.class.as_str(), good.table.cell(7)),
        ("good", &[1, 3, 2, 3, 4, 5, 6, 7][..])
    );

    let cases: [(&str, &str, Option<usize>, &str); 18] = [
        ("8 4 2 5 2", "0 4 2 5 2", Some(1), "sensors 1 to 64"),
        ("8 4 2 5 2", "65 4 2 5 2", Some(1), "sensors 1 to 64"),
        ("8 4 2 5 2", "7.5 4 2 5 2", Some(1), "sensors 1 to 64"),
        ("8 4 2 5 2", "7 4 2 5 2", Some(3), "8 numbers; allowed: 7 integers"),
        ("8 4 2 5 2", "8 4 2 5", Some(1), "4 numbers"),
        ("8 4 2 5 2", "8 4 two 5 2", Some(1), "`two`"),
        ("8 4 2 5 2", "8 4.5 2 5 2", Some(1), "bearings 4 to 3600"),
        ("8 4 2 5 2", "8 4 2 NaN 2", Some(1), "`NaN`"),
        ("8 4 2 5 2", "8 4 2 5 0", Some(1), "spacing 0.01 to 1000"),
        ("8 4 2 5 2", "8 4 3 5 2", Some(12), "`TURN 2`"),
        ("8 4 2 5 2", "8 4 1 5 2", Some(7), "allowed: END"),
        ("TURN 1", "1 1 2 3 4 5 6 7", Some(7), "row 1 begins here"),
        (
            "1 0 2 3",
            "1 0 2 1024",
            Some(8),
            "`1024`; allowed: 8 integers from 0 to 1023",
        ),
        ("1 0 2 3", "1 0 2 -3", Some(8), "`-3`"),
        ("1 0 2 3", "1 0 2 0.5", Some(8), "`0.5`"),
        ("1 0 2 3 4", "1 0 2 3", Some(8), "7 numbers"),
        ("END", "", None, "missing: END"),
        ("END", "END\n5", Some(13), "after END"),
    ];
    for (from, to, line, message) in cases {
        let error = SensorTable::read(written(&folder, "bad.sam", &broken(from, to))).unwrap_err();
        assert_eq!(error.line, line, "{error}");
        assert!(error.problem.contains(message), "{error}, not {message}");
        assert!(error.to_string().contains("bad.sam"), "{error}");
    }

    let whole = broken("", "");
    let cut = written(&folder, "bad.sam", &whole[..whole.len() / 2]);
    assert!(SensorTable::read(cut).is_err());
    let error = SensorTable::read(written(&folder, "bad.sam", &whole[..whole.find("1 2 2").unwrap()])).unwrap_err();
    assert!(
        error
            .problem
            .contains("ends early; missing: bearing 2 of 4 in row 1 of 2"),
        "{error}"
    );

    let share = SensorTable::read(written(&folder, "bad.sample", &whole)).unwrap_err();
    assert_eq!(
        (share.line, share.problem.as_str()),
        (Some(3), "`2`; allowed: 8 numbers from 0 to 1")
    );
    let extension = SensorTable::read(written(&folder, "bad.txt", &whole)).unwrap_err();
    assert!(extension.problem.contains("allowed: .sam, .sample"), "{extension}");
    let missing = SensorTable::read(folder.join("none.sam")).unwrap_err();
    assert!(missing.problem.contains("can't be read"), "{missing}");
}

#[test]
fn bad_motor_tables_are_refused_with_the_line() {
    let folder = scratch("bad_motors");
    let cases = [
        ("", None, "ends early"),
        ("1\n", Some(1), "1 numbers"),
        (
            "0 -1\n1 0\n-2 0\n",
            None,
            "missing: the displacements for the left wheel's speed 1, of 2 speeds",
        ),
        ("0 -1\n1\n-2 0\n0 2\n", Some(2), "1 numbers where the first line has 2"),
        ("0 -1\n1 0\n-2 0\n0 2\n3 3\n", Some(5), "a line after the 4"),
        ("0 -1\n1 181\n-2 0\n0 2\n", Some(2), "`181`"),
        ("0 -1\n1 inf\n-2 0\n0 2\n", Some(2), "`inf`"),
        ("0 -1\n1 x\n-2 0\n0 2\n", Some(2), "`x`"),
    ];
    for (text, line, message) in cases {
        let error = MotorSamples::read(written(&folder, "bad.sam", text)).unwrap_err();
        assert_eq!(error.line, line, "{error}");
        assert!(error.problem.contains(message), "{error}, not {message}");
    }
    let speeds = MotorSamples {
        speeds: vec![-1, 0, 2],
        degrees: vec![0.0; 9],
        centimetres: vec![0.0; 9],
    };
    let error = speeds.write(folder.join("speeds.sam")).unwrap_err();
    assert!(error.problem.contains("allowed: every integer"), "{error}");
}

#[test]
fn built_in_sensors_see_what_they_look_at() {
    // A wall at 15 mm straight ahead: the front sensors read it, the back ones don't.
    let wall = &SensorTables::khepera().classes[0];
    let ahead = wall.cell(5 * 180);
    assert_eq!(ahead.len(), SENSORS);
    assert!(
        ahead[2] > 800 && ahead[3] > 800 && ahead[6] < 14 && ahead[7] < 14,
        "{ahead:?}"
    );
    // And to the right (clockwise).
    let right = wall.cell(5 * 180 + 45);
    assert!(right[5] > 800 && right[0] < 14, "{right:?}");
}
