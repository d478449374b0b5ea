use std::sync::Arc;

use oneiro::tables::SensorTables;
use oneiro_robots::guard::message::Sensors;

use super::mock::Mock;
use super::*;

static GOES_ON: AtomicBool = AtomicBool::new(false);

/// Measures how a mock turns, and takes all its rows.
fn rows(mock: &mut Mock, aside: usize) -> Turning {
    let speed = pace(mock).unwrap();
    let turning = measured(mock, speed, &GOES_ON).unwrap();
    for row in 0..20 {
        (mock.row, mock.heading) = (row, 0.0);
        let turn = turn_before(mock, turning, 1, &GOES_ON).unwrap();
        mock.assert_row(&turn.row().unwrap(), aside);
        assert_eq!(mock.speeds, [0.0; 2]);
        // It has its heading again.
        let off = mock.heading - mock.heading.round();
        assert!(off.abs() * 360.0 < 3.0, "{off}");
        match turn.overlap {
            Overlap::Late { drift, difference } => {
                assert!(
                    drift.abs() * 360.0 < 1.0 && difference < 25.0,
                    "row {row}: {:?}",
                    turn.overlap
                );
            }
            overlap => assert!(overlap == Overlap::Blank && row > 10, "row {row}: {overlap:?}"),
        }
    }
    turning
}

#[test]
fn readings_are_shares_of_each_sensor_s_range() {
    let sensors = |kind: &str, count, range| Sensors {
        kind: kind.into(),
        names: (0..count).map(|sensor| format!("{kind}_{sensor}")).collect(),
        unit: String::new(),
        range,
    };
    let mut profile = Mock::new().profile;
    profile.sensors = vec![
        sensors("proximity", 4, (0.0, 4095.0)),
        sensors("ground", 1, (-10.0, 10.0)),
    ];
    let moment = Moment {
        at: Duration::ZERO,
        age: Duration::ZERO,
        readings: vec![0.0, 4095.0, 2048.0, 5000.0, -5.0],
        travel: None,
    };
    assert_eq!(scaled(&profile, &moment), [0, 1023, 512, 1023, 256]);
}

#[test]
fn rows_are_those_of_the_table() {
    let turning = rows(&mut Mock::new(), 1);
    assert_eq!(turning.wheel_mm_s, 8.2);
    assert!((turning.apparent - 1.0).abs() < 1e-3, "{turning:?}");
}

/// The distance between its wheels differs from its profile.
#[test]
fn whole_turns_are_found_in_readings() {
    for wider in [0.9, 0.98, 1.02, 1.1, 1.15] {
        let mut mock = Mock { wider, ..Mock::new() };
        let turning = rows(&mut mock, 1);
        assert!((turning.apparent - wider).abs() < 2e-3, "{wider}: {turning:?}");
    }
}

#[test]
fn without_odometers_the_clock_tells_the_heading() {
    let mut mock = Mock {
        wider: 1.07,
        ..Mock::new()
    };
    mock.profile.has_odometers = false;
    // With a speed of 8.2 mm/s until it has stopped.
    let turning = rows(&mut mock, 1);
    assert!((turning.apparent - 1.07).abs() < 5e-3, "{turning:?}");
    let driven = drive(&mut mock, (1, 2), 82.0, 1.0, &GOES_ON);
    assert!(matches!(driven, Err(Trouble::Broken(problem)) if problem.contains("no odometers")));
}

#[test]
fn coarse_odometers_are_enough() {
    rows(
        &mut Mock {
            count_mm: 0.5,
            ..Mock::new()
        },
        1,
    );
}

/// A link with which one turn leaves bearings without a reading, and one that loses readings.
#[test]
fn bearings_without_a_reading_are_read_in_the_next_turn() {
    rows(
        &mut Mock {
            look: Duration::from_millis(137),
            ..Mock::new()
        },
        2,
    );
    rows(
        &mut Mock {
            slow: |look| look % 41 == 0,
            ..Mock::new()
        },
        1,
    );
    let mut slow = Mock {
        look: Duration::from_millis(900),
        ..Mock::new()
    };
    let turning = Turning {
        wheel_mm_s: 8.2,
        apparent: 1.0,
    };
    let trouble = turn_before(&mut slow, turning, 1, &GOES_ON).unwrap_err();
    assert!(
        trouble.to_string().contains("degrees after 3 turns at its slowest"),
        "{trouble}"
    );
    assert_eq!(slow.speeds, [0.0; 2]);
}

#[test]
fn several_turns_are_averaged() {
    let mut mock = Mock::new();
    let turning = Turning {
        wheel_mm_s: 8.2,
        apparent: 1.0,
    };
    let turn = turn_before(&mut mock, turning, 3, &GOES_ON).unwrap();
    // At each bearing the mean of readings in neighbouring intervals.
    let table = &mock.tables.classes[0];
    for (bearing, cell) in turn.row().unwrap().into_iter().enumerate() {
        for (sensor, reading) in cell.into_iter().enumerate() {
            let near = [179, 0, 1].map(|aside| table.cell((bearing + aside) % 180)[sensor]);
            let (low, high) = (near.iter().min().unwrap(), near.iter().max().unwrap());
            assert!(
                (low..=high).contains(&&reading),
                "{bearing} {sensor}: {reading} {near:?}"
            );
        }
    }
    assert!(turn.turned().len() > 3 * 400);
}

/// Readings are enough to detect wheels that slip.
#[test]
fn a_robot_that_slips_has_not_turned_once() {
    let turning = Turning {
        wheel_mm_s: 8.2,
        apparent: 1.0,
    };
    for (degrees, slippery) in [(0.0, [0.0; 2]), (8.0, [0.5, 0.5 + 2.0 / 360.0]), (-8.0, [0.0; 2])] {
        let mut mock = Mock {
            slippery,
            ..Mock::new()
        };
        if degrees < 0.0 {
            mock.wider = 360.0 / 368.0;
        }
        let turn = turn_before(&mut mock, turning, 1, &GOES_ON).unwrap();
        let Overlap::Late { drift, .. } = turn.overlap else {
            panic!("{:?}", turn.overlap)
        };
        assert!((360.0 * drift - degrees).abs() < 0.7, "{degrees}: {}", 360.0 * drift);
    }
    let mut mock = Mock {
        slippery: [0.5, 0.51],
        ..Mock::new()
    };
    let turn = turn_before(&mut mock, turning, 1, &GOES_ON).unwrap();
    assert_eq!(turn.overlap, Overlap::Unlike);
}

#[test]
fn troubles_end_a_turn() {
    let turning = Turning {
        wheel_mm_s: 8.2,
        apparent: 1.0,
    };
    let mut mock = Mock {
        failing: |look| look == 200,
        ..Mock::new()
    };
    let trouble = turn_before(&mut mock, turning, 1, &GOES_ON).unwrap_err();
    assert!(matches!(trouble, Trouble::Unreadable(_)));
    // Repeated from its place, it is a whole row.
    mock.heading = 0.0;
    mock.recover().unwrap();
    let turn = turn_before(&mut mock, turning, 1, &GOES_ON).unwrap();
    mock.assert_row(&turn.row().unwrap(), 1);

    let mut stuck = Mock {
        is_stuck: true,
        ..Mock::new()
    };
    let trouble = turn_before(&mut stuck, turning, 1, &GOES_ON).unwrap_err();
    assert!(
        matches!(&trouble, Trouble::Displaced(problem) if problem.contains("is it stuck")),
        "{trouble}"
    );
    assert_eq!(stuck.speeds, [0.0; 2]);

    let mut mock = Mock::new();
    let trouble = turn_before(&mut mock, turning, 1, &AtomicBool::new(true)).unwrap_err();
    assert!(matches!(trouble, Trouble::Stopped));
    assert_eq!(mock.speeds, [0.0; 2]);

    // Nothing before it.
    let mut alone = Mock::new();
    alone.tables = Arc::new(SensorTables::new(vec![oneiro::tables::SensorTable {
        readings: vec![7; 20 * 180 * 8],
        ..alone.tables.classes[0].clone()
    }]));
    let trouble = measured(&mut alone, 8.2, &GOES_ON).unwrap_err();
    assert!(
        trouble.to_string().contains("no whole turn can be recognised"),
        "{trouble}"
    );
}

#[test]
fn motors_are_measured_by_odometers_near_its_place() {
    let mut mock = Mock {
        wider: 1.02,
        ..Mock::new()
    };
    for left in -10..=10 {
        for right in -10..=10 {
            let driven = drive(&mut mock, (left, right), 82.0, 1.02, &GOES_ON).unwrap();
            let way = f64::from(left + right) * 0.41;
            let turn = f64::from(right - left) * 0.82 / (TAU * 53.0 * 1.02);
            // A count in a second, of each wheel.
            assert!(
                (driven.displacement - way).abs() < 0.1 / 12.0 + 1e-9,
                "{left} {right}: {driven:?}"
            );
            assert!(
                (driven.turn - turn).abs() < 0.2 / 12.0 / (TAU * 53.0),
                "{left} {right}: {driven:?}"
            );
        }
    }
    assert_eq!(mock.speeds, [0.0; 2]);
    assert!(mock.farthest < reach_mm(82.0) + 40.0, "{}", mock.farthest);
    let (x, y) = (mock.place[0], mock.place[1]);
    assert!(x.hypot(y) < 30.0, "{x} {y}");
}
