use super::super::error::Error;
use super::super::script::{Random, Scripted, Step, hear, say, say_after};
use super::*;

const VERSION: (&str, &str) = ("B\r", "b,5.02,5.01\r\n");
/// A stop, and wheels that stand.
const STOP: [(&str, &str); 2] = [("D,0,0\r", "d\r\n"), ("E\r", "e,0,0\r\n")];
/// In the manner of the "Khepera II FAQ".
const BOOT: &str = "\r\nROM of minirobot KHEPERA, K-Team S.A., 1999\r\nRev. 5.01\r\nSerial Communication Protocol\r\n";

fn exchanges<'a>(pairs: impl IntoIterator<Item = (&'a str, &'a str)>) -> Vec<Step> {
    pairs
        .into_iter()
        .flat_map(|(command, answer)| [hear(command), say(answer)])
        .collect()
}

/// Getting back in step where the wheels should stand.
fn resynchronised() -> Vec<Step> {
    [vec![hear("\rD,0,0\r"), say("d\r\n")], exchanges([VERSION])].concat()
}

/// The dialogue until the robot is ready.
pub(crate) fn opening() -> Vec<Step> {
    [resynchronised(), exchanges(STOP)].concat()
}

/// A robot that has begun, and what it says then.
fn robot(steps: impl IntoIterator<Item = Step>) -> Khepera {
    let mut robot = Khepera::new(Box::new(Scripted::new(opening().into_iter().chain(steps))));
    robot.begin().unwrap();
    robot
}

#[test]
fn a_conversation_as_in_the_manual() {
    let mut robot = robot(exchanges([
        ("N\r", "n,0,12,1023,5,6,7,8,9\r\n"),
        ("O\r", "o,500,490,480,470,460,450,440,50\r\n"),
        ("E\r", "e,-3,4\r\n"),
        ("D,10,-10\r", "d\r\n"),
        ("H\r", "h,-120,2147483647\r\n"),
        ("L,1,1\r", "l\r\n"),
    ]));
    assert_eq!(robot.description().firmware, "5.02,5.01");
    let reading = robot.sense(&[Kind::Proximity, Kind::Light, Kind::WheelSpeed]).unwrap();
    let expected = [
        0., 12., 1023., 5., 6., 7., 8., 9., 500., 490., 480., 470., 460., 450., 440., 50., -3., 4.,
    ];
    assert_eq!(reading.values, expected);
    assert_eq!(reading.age, Duration::from_millis(30));
    robot.drive(10, -10).unwrap();
    assert_eq!(robot.odometry().unwrap().counts, [-120, 2_147_483_647]);
    robot.light(1, true).unwrap();
    assert!(matches!(robot.light(2, true), Err(Error::Unsupported { allowed, .. }) if allowed == "0 to 1"));
    assert!(matches!(robot.battery(), Err(Error::Unsupported { .. })));
    assert!(
        matches!(robot.sense(&[Kind::Ground]), Err(Error::Unsupported { allowed, .. })
        if allowed == "proximity, light, wheel_speed")
    );
}

#[test]
fn speeds_are_limited_and_rounded() {
    let mut robot = robot(exchanges([
        ("D,127,-127\r", "d\r\n"),
        ("D,10,-4\r", "d\r\n"),
        ("D,0,127\r", "d\r\n"),
    ]));
    robot.drive(i32::MAX, i32::MIN).unwrap();
    robot.drive_mm_s(82.1, -34.0).unwrap();
    robot.drive_mm_s(f64::NAN, f64::INFINITY).unwrap();
}

/// Every command of the table, with an answer in its form.
#[test]
fn every_command_is_sent_and_understood() {
    use Command as C;
    let none = Answer::Numbers(vec![]);
    let table: [(C, &str, &str, Answer); 18] = [
        (C::SpeedGains([3800, 800, 100]), "A,3800,800,100\r", "a", none.clone()),
        (C::Version, "B\r", "b,5.01,5.00", Answer::Text("5.01,5.00".into())),
        (
            C::GoTo([-8_388_606, 8_388_606]),
            "C,-8388606,8388606\r",
            "c",
            none.clone(),
        ),
        (C::Drive([-127, 127]), "D,-127,127\r", "d", none.clone()),
        (C::Speeds, "E\r", "e,-127,127", Answer::Numbers(vec![-127, 127])),
        (
            C::PositionGains([3000, 20, 4000]),
            "F,3000,20,4000\r",
            "f",
            none.clone(),
        ),
        (C::SetPositions([0, -1]), "G,0,-1\r", "g", none.clone()),
        (
            C::Positions,
            "H\r",
            "h,-2147483648,0",
            Answer::Numbers(vec![-2_147_483_648, 0]),
        ),
        (C::Analogue(3), "I,3\r", "i,1023", Answer::Numbers(vec![1023])),
        (C::Profile([20, 64, 20, 64]), "J,20,64,20,64\r", "j", none.clone()),
        (
            C::Status,
            "K\r",
            "k,1,1,0,0,0,-12",
            Answer::Numbers(vec![1, 1, 0, 0, 0, -12]),
        ),
        (C::Light(0, 2), "L,0,2\r", "l", none.clone()),
        (
            C::Proximity,
            "N\r",
            "n,1,2,3,4,5,6,7,8",
            Answer::Numbers((1..=8).collect()),
        ),
        (
            C::Ambient,
            "O\r",
            "o,1,2,3,4,5,6,7,8",
            Answer::Numbers((1..=8).collect()),
        ),
        (C::PulseWidths([-255, 255]), "P,-255,255\r", "p", none.clone()),
        (C::ReadBus(63), "R,63\r", "r,255", Answer::Numbers(vec![255])),
        (C::Turret(1, "G".into()), "T,1,G\r", "t,1,g", Answer::Text("1,g".into())),
        (C::WriteBus { byte: 255, address: 63 }, "W,255,63\r", "w", none),
    ];
    for (command, sent, line, answer) in table {
        assert_eq!(command.line(), sent);
        assert_eq!(command.parse(line).unwrap(), answer);
        for refusal in ["z,Protocol error", "z,Protocol error.", "Command not found"] {
            assert!(matches!(command.parse(refusal), Err(Error::Refused { .. })));
        }
        // Another letter, more numbers, and less than the whole.
        let more = format!("{line},9");
        let text = matches!(answer, Answer::Text(_));
        for other in ["q", &line[1..], &line.to_uppercase(), &more] {
            let is_error = matches!(command.parse(other), Err(Error::Garbage { .. }));
            assert!(is_error || (text && other == more), "{sent} {other}");
        }
    }
}

#[test]
fn numbers_out_of_range_are_garbage() {
    for (command, line) in [
        (Command::Proximity, "n,1,2,3,4,5,6,7,1024"),
        (Command::Proximity, "n,1,2,3,4,5,6,7,-1"),
        (Command::Speeds, "e,256,0"),
        (Command::Positions, "h,0,2147483648"),
        (Command::ReadBus(0), "r,256"),
    ] {
        assert!(matches!(command.parse(line), Err(Error::Garbage { .. })), "{line}");
    }
}

/// The answer may come in any chunks, after an echo of the flush, and with any line end.
#[test]
fn partial_lines_are_joined() {
    for chunk in 1..20 {
        let steps = [opening(), exchanges([("N\r", "\r\nn,1,2,3,4,5,6,7,8\n")])].concat();
        let mut robot = Khepera::new(Box::new(Scripted::new(steps).in_chunks(chunk)));
        robot.begin().unwrap();
        assert_eq!(
            robot.sense(&[Kind::Proximity]).unwrap().values,
            [1., 2., 3., 4., 5., 6., 7., 8.]
        );
    }
}

#[test]
fn a_lost_answer_is_asked_for_again() {
    let steps = [
        vec![hear("N\r")],
        resynchronised(),
        exchanges([("N\r", "n,1,2,3,4,5,6,7,8\r\n")]),
    ]
    .concat();
    robot(steps).sense(&[Kind::Proximity]).unwrap();
}

/// A late answer has the right letter, but is of the past.
#[test]
fn a_late_answer_does_not_pass_for_the_next() {
    let steps = [
        vec![
            hear("N\r"),
            hear("\rD,0,0\r"),
            say_after(20, "n,9,9,9,9,9,9,9,9\r\nd\r\n"),
        ],
        exchanges([VERSION, ("N\r", "n,1,2,3,4,5,6,7,8\r\n")]),
    ];
    let reading = robot(steps.concat()).sense(&[Kind::Proximity]).unwrap();
    assert_eq!(reading.values[0], 1.0);
}

#[test]
fn garbage_is_asked_again_and_ends_in_an_error() {
    let bad = || [exchanges([("N\r", "n,1,2,3,4,\u{7f}5,6,7,8\r\n")]), resynchronised()].concat();
    let good = exchanges([("N\r", "n,1,2,3,4,5,6,7,8\r\n")]);
    robot([bad(), bad(), good].concat()).sense(&[Kind::Proximity]).unwrap();
    let error = robot([bad(), bad(), bad()].concat())
        .sense(&[Kind::Proximity])
        .unwrap_err();
    assert!(matches!(error, Error::Garbage { command, received } if command == "N" && received.contains("\\x7f")));
}

#[test]
fn a_refusal_says_what_the_robot_said() {
    let refused = || [exchanges([("E\r", "z,Protocol error\r\n")]), resynchronised()].concat();
    let error = robot([refused(), refused(), refused()].concat())
        .sense(&[Kind::WheelSpeed])
        .unwrap_err();
    let words = error.to_string();
    assert!(
        words.starts_with("the robot refused E: \"z,Protocol error\""),
        "{words}"
    );
}

#[test]
fn what_must_not_be_done_twice_is_tried_once() {
    let steps = [vec![hear("G,0,0\r")], resynchronised()].concat();
    let error = robot(steps).command(&Command::SetPositions([0, 0])).unwrap_err();
    assert!(matches!(error, Error::TimedOut { .. }));
}

#[test]
fn silence_ends_within_half_a_second() {
    let mut robot = robot([hear("D,0,0\r"), hear("\rD,0,0\r"), hear("B\r")]);
    let start = robot.talk.now();
    assert!(matches!(robot.stop(), Err(Error::TimedOut { command, .. }) if command == "D,0,0"));
    assert_eq!(robot.talk.now(), start + 2 * PATIENCE + SILENCE);
    assert!(robot.talk.now() < start + Duration::from_millis(500));
}

/// A stop that was confirmed, and arrived as another speed: it is sent again until the wheels stand, and for no longer than they
/// need.
#[test]
fn a_stop_that_became_another_speed_is_not_confirmed() {
    let turning = [STOP[0], ("E\r", "e,0,7\r\n")];
    robot([exchanges(turning), exchanges(STOP)].concat()).stop().unwrap();
    let mut robot = robot(vec![exchanges(turning); 10].concat());
    let start = robot.talk.now();
    let error = robot.stop().unwrap_err();
    assert!(matches!(&error, Error::StillTurning { seen } if seen == "its speeds are [0, 7]"));
    assert!(robot.talk.now() <= start + STANDSTILL + PATIENCE);
}

/// Neither a command nor getting back in step after it is answered in time. The answer comes when the robot is ordered to
/// stop, and has the right letter; the stop itself is lost.
#[test]
fn a_late_answer_does_not_confirm_a_stop() {
    let steps = [
        vec![hear("D,9,9\r"), hear("\r"), hear("B\r")],
        vec![hear("\rD,0,0\r"), say("d\r\n"), say("b,5.02,5.01\r\n"), hear("B\r")],
    ];
    let mut robot = robot(steps.concat());
    assert!(matches!(robot.drive(9, 9), Err(Error::TimedOut { command, .. }) if command == "D,9,9"));
    assert!(matches!(robot.stop(), Err(Error::TimedOut { command, .. }) if command == "B"));
}

/// A robot whose answers take longer than the pause before it is asked for its version, but not longer than the driver waits.
#[test]
fn a_slow_robot_is_met_at_once() {
    let steps = [
        vec![hear("N\r"), hear("\rD,0,0\r"), hear("B\r")],
        vec![say("d\r\n"), say_after(50, "b,5.02,5.01\r\n")],
        exchanges([("N\r", "n,1,2,3,4,5,6,7,8\r\n")]),
    ];
    robot(steps.concat()).sense(&[Kind::Proximity]).unwrap();
}

/// A version that comes when it is asked for again would put all later answers one command behind.
#[test]
fn a_late_version_is_waited_for() {
    let steps = [
        vec![hear("N\r"), hear("\rD,0,0\r"), hear("B\r")],
        vec![hear("\rD,0,0\r"), say_after(140, "b,5.02,5.01\r\nd\r\n")],
        exchanges([VERSION, ("N\r", "n,1,2,3,4,5,6,7,8\r\n")]),
    ];
    let mut robot = robot(steps.concat());
    assert!(matches!(robot.sense(&[Kind::Proximity]), Err(Error::TimedOut { command, .. }) if command == "N"));
    assert_eq!(robot.sense(&[Kind::Proximity]).unwrap().values[0], 1.0);
}

/// Where wheels turn, getting back in step leaves their speeds alone.
#[test]
fn a_lost_answer_does_not_stop_the_wheels() {
    let steps = [
        exchanges([("D,9,9\r", "d\r\n")]),
        vec![hear("N\r"), hear("\r")],
        exchanges([VERSION, ("N\r", "n,1,2,3,4,5,6,7,8\r\n")]),
    ];
    let mut robot = robot(steps.concat());
    robot.drive(9, 9).unwrap();
    robot.sense(&[Kind::Proximity]).unwrap();
}

/// The robot restarts before, in the middle of and after an answer. Then its wheels stand and its counters are 0.
#[test]
fn a_restart_is_reported_once() {
    let before = vec![say_after(0, BOOT)];
    let instead = vec![hear("D,5,5\r"), say(BOOT)];
    let amid = vec![hear("D,5,5\r"), say("d"), say(BOOT)];
    let late = vec![hear("D,5,5\r"), say(&BOOT[..20]), say_after(120, &BOOT[20..])];
    for restart in [before, instead, amid, late] {
        let after = [resynchronised(), exchanges([("H\r", "h,0,0\r\n")])];
        let mut robot = robot([restart, after.concat()].concat());
        assert_eq!(robot.drive(5, 5), Err(Error::Restarted));
        assert_eq!(robot.odometry().unwrap().counts, [0, 0]);
    }
}

#[test]
fn a_robot_that_has_just_started_is_recognised() {
    let steps = [vec![say_after(0, BOOT)], opening()].concat();
    let mut khepera = Khepera::new(Box::new(Scripted::new(steps)));
    khepera.begin().unwrap();
    // The banner comes while the version is asked for.
    let steps = [vec![hear("\rD,0,0\r"), hear("B\r"), say(BOOT)], opening()].concat();
    let mut khepera = Khepera::new(Box::new(Scripted::new(steps)));
    khepera.begin().unwrap();
}

#[test]
fn a_lost_link_is_opened_again() {
    let mut robot = robot([vec![hear("D,5,5\r"), Step::HangUp, Step::Reopen], opening()].concat());
    assert!(matches!(robot.drive(5, 5), Err(Error::Disconnected { .. })));
    assert!(matches!(robot.stop(), Err(Error::Disconnected { .. })));
    robot.reconnect().unwrap();
}

/// Whatever comes instead of answers, calls end and speeds are not misread: an answer that is accepted is one.
#[test]
fn random_answers_never_panic_and_are_never_accepted() {
    let mut random = Random(7);
    for _ in 0..3000 {
        let noise = random.bytes(60);
        if let Some(line) = {
            let mut received = talk::Received::default();
            received.push(&noise);
            received.line()
        } {
            for command in [
                Command::Proximity,
                Command::Speeds,
                Command::Version,
                Command::Positions,
            ] {
                command.parse(&line).unwrap_err();
            }
        }
        let mutated = random.mutated(b"n,10,20,30,40,50,60,70,80");
        let line = talk::shown(&mutated);
        if let Ok(Answer::Numbers(values)) = Command::Proximity.parse(&line) {
            assert_eq!(values.len(), 8);
            assert!(values.iter().all(|value| (0..=1023).contains(value)), "{line}");
        }
    }
}
