use super::super::script::{Random, Scripted, Step, hear, say, say_after};
use super::*;

const BOOT: &str =
    "\x0c\x07WELCOME to the SerCom protocol on e-Puck\r\nthe EPFL education robot type \"H\" for help\r\n";
pub(crate) const VERSION_1: &str = "v,Version 1.2.2 August 2008 GCtronic\r\nHW version: FFFF\r\n";
pub(crate) const VERSION_2: &str = "v,Version 2.0 January 2018 GCtronic\r\nHW version: FFFF\r\n";
pub(crate) const EIGHT: &str = "n,1,2,3,4,5,6,7,8\r\n";
const TEN: &str = "n,1,2,3,4,5,6,7,8,9,10\r\n";

/// Getting back in step while the wheels turn.
fn resynchronised_amid(version: &str) -> Vec<Step> {
    vec![hear([FLUSH, b"\r"].concat()), hear("V\r"), say(version)]
}

/// Getting back in step where the wheels should stand.
fn resynchronised(version: &str) -> Vec<Step> {
    vec![
        hear([FLUSH, b"\rD,0,0\r"].concat()),
        say("d\r\n"),
        hear("V\r"),
        say(version),
    ]
}

/// A stop, and the speeds then.
fn stopped(speeds: &str) -> Vec<Step> {
    vec![hear("D,0,0\r"), say("d\r\n"), hear("E\r"), say(speeds)]
}

/// What follows a chain and its answer: the question for the speeds, and these.
fn chain(commands: &[u8], answer: &[i16], speeds: [i16; 2]) -> Vec<Step> {
    let words = [answer, &speeds].concat();
    let bytes: Vec<u8> = words.into_iter().flat_map(i16::to_le_bytes).collect();
    // 0xbb is -'E'.
    vec![hear([commands, &[0xbb, 0]].concat()), say(bytes)]
}

/// The dialogue until the robot is ready.
pub(crate) fn opening(version: &str, infrared: &str, is_binary: bool) -> Vec<Step> {
    let text = vec![hear("N\r"), say(infrared)];
    // 0xaf is -'Q'.
    let probe = if is_binary {
        chain(&[0xaf], &[0, 0], [0, 0])
    } else {
        let unheard = [vec![hear([0xaf, 0xbb, 0])], resynchronised(version)].concat();
        vec![unheard; TRIES as usize].concat()
    };
    [resynchronised(version), stopped("e,0,0\r\n"), text, probe].concat()
}

/// An opening in which the robot never has the speeds 0.
pub(crate) fn opening_that_keeps(speeds: &str) -> Vec<Step> {
    let kept = [stopped(speeds), resynchronised(VERSION_1)].concat();
    [resynchronised(VERSION_1), vec![kept; TRIES as usize].concat()].concat()
}

fn start(opening: Vec<Step>, steps: Vec<Step>) -> EPuck {
    let mut robot = EPuck::new(Box::new(Scripted::new([opening, steps].concat())));
    robot.begin().unwrap();
    robot
}

fn binary(steps: Vec<Step>) -> EPuck {
    start(opening(VERSION_1, EIGHT, true), steps)
}

fn text(steps: Vec<Step>) -> EPuck {
    start(opening(VERSION_1, EIGHT, false), steps)
}

fn kinds(robot: &EPuck) -> Vec<Kind> {
    robot.description().sensors.iter().map(|group| group.kind).collect()
}

#[test]
fn an_old_robot_is_asked_in_text() {
    let mut robot = text(vec![
        hear("N\r"),
        say("n,0,12,4095,3,4,5,6,7\r\n"),
        hear("A\r"),
        say("a,2048,-3,700\r\n"),
        hear("D,500,-500\r"),
        say("d\r\n"),
        hear("Q\r"),
        say("q,-32768,5\r\n"),
        hear("Q\r"),
        say("q,32767,6\r\n"),
        hear("L,3,1\r"),
        say("l\r\n"),
        hear("B,0\r"),
        say("b\r\n"),
        hear("F,1\r"),
        say("f\r\n"),
    ]);
    assert_eq!(robot.description().robot, "e-puck");
    assert_eq!(robot.description().firmware, "Version 1.2.2 August 2008 GCtronic");
    assert_eq!(
        kinds(&robot),
        [Kind::Proximity, Kind::Light, Kind::Acceleration, Kind::Sound]
    );
    let reading = robot.sense(&[Kind::Proximity, Kind::Acceleration]).unwrap();
    assert_eq!(reading.values, [0., 12., 4095., 3., 4., 5., 6., 7., 2048., -3., 700.]);
    robot.drive(500, -500).unwrap();
    assert_eq!(robot.odometry().unwrap().counts, [-32_768, 5]);
    assert_eq!(robot.odometry().unwrap().counts, [-32_769, 6], "counters wrap");
    robot.light(3, true).unwrap();
    robot.light(8, false).unwrap();
    robot.light(9, true).unwrap();
    assert!(matches!(robot.light(10, true), Err(Error::Unsupported { .. })));
}

/// Codes by hand: N is b2, O b1, a 9f, D bc, E bb, Q af, L b4.
#[test]
fn binary_chains_are_as_the_firmware_reads_them() {
    let sensors = [1, 2, 3, 4, 5, 6, 7, 4095, 10, 20, 30, 40, 50, 60, 70, 80, -5, 6, 700];
    let mut robot = binary(
        [
            chain(&[0xb2, 0xb1, 0x9f], &sensors, [0, 0]),
            chain(&[0xbc, 0xf4, 0x01, 0x0c, 0xfe], &[], [500, -500]),
            chain(&[0xaf], &[-300, 400], [500, -500]),
            chain(&[0xb4, 9, 1], &[], [500, -500]),
            stopped("e,0,0\r\n"),
        ]
        .concat(),
    );
    let reading = robot
        .sense(&[Kind::Proximity, Kind::Light, Kind::Acceleration])
        .unwrap();
    assert_eq!(reading.values, sensors.map(f64::from));
    robot.drive(500, -500).unwrap();
    assert_eq!(robot.odometry().unwrap().counts, [-300, 400]);
    robot.light(9, true).unwrap();
    robot.stop().unwrap();
}

/// -'g' is 99, -'M' b3 with 8 bytes, and f3 the distance, of two.
#[test]
fn an_e_puck2_has_more_sensors() {
    let answer = [-1, 2, 3, 1023, 500, 0, 77, -1];
    let opening = opening(VERSION_2, EIGHT, true);
    let mut robot = start(opening, chain(&[0x99, 0xb3, 0xf3], &answer, [0, 0]));
    assert_eq!(robot.description().robot, "e-puck2");
    let reading = robot.sense(&[Kind::Rotation, Kind::Ground, Kind::Distance]).unwrap();
    assert_eq!(reading.values, [-1., 2., 3., 1023., 500., 0., 65_535.]);
}

/// Over the UART of the extension board, N and O have ten values.
#[test]
fn ten_values_are_understood_in_both_dialects() {
    let words = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 9, 9, 9, 9, 9, 9, 9, 9, 0, 0, -1, -2, -3];
    let opening_in_binary = opening(VERSION_1, TEN, true);
    let mut robot = start(opening_in_binary, chain(&[0xb2, 0xb1, 0x9f], &words, [0, 0]));
    let values = robot
        .sense(&[Kind::Proximity, Kind::Light, Kind::Acceleration])
        .unwrap()
        .values;
    assert_eq!(values[..9], [1., 2., 3., 4., 5., 6., 7., 8., 9.]);
    assert_eq!(values[16..], [-1., -2., -3.]);
    let mut robot = start(opening(VERSION_1, TEN, false), vec![hear("N\r"), say(TEN)]);
    assert_eq!(
        robot.sense(&[Kind::Proximity]).unwrap().values,
        [1., 2., 3., 4., 5., 6., 7., 8.]
    );
    // Eight would be another robot's answer.
    let bad = [vec![hear("N\r"), say(EIGHT)], resynchronised(VERSION_1)].concat();
    let mut robot = start(opening(VERSION_1, TEN, false), [bad.clone(), bad.clone(), bad].concat());
    assert!(matches!(robot.sense(&[Kind::Proximity]), Err(Error::Garbage { .. })));
}

#[test]
fn batteries_of_all_versions() {
    let asked = |line: &str| vec![hear("b\r"), say(line)];
    let charge = |mut robot: EPuck| robot.battery().unwrap();
    let flat = Battery { volts: None, low: true };
    let full = Battery {
        volts: None,
        low: false,
    };
    assert_eq!(charge(binary(asked("b,1\r\n"))), full);
    assert_eq!(charge(binary(asked("b,0\r\n"))), flat);
    assert_eq!(charge(text(asked("b,2100 (88%)\r\n"))), full);
    assert_eq!(charge(text(asked("b,1800 (9%)\r\n"))), flat);
    let on_2 = |line: &str| charge(start(opening(VERSION_2, EIGHT, true), asked(line)));
    assert_eq!(
        on_2("b,2900 (5%)\r\n"),
        Battery {
            volts: Some(2900.0 / 819.2),
            low: false
        }
    );
    assert!(on_2("b,2899 (5%)\r\n").low);
    for line in ["b", "b,2", "b,1,1", "b,x (5%)", "b,5 (5)", "b,5 5%", "b,-5 (5%)", "c,1"] {
        assert!(matches!(battery(line), Err(Error::Garbage { .. })), "{line}");
    }
}

/// Each byte of a chain's answer lost or doubled, or all of it late: none is accepted, and the next attempt is in step.
#[test]
fn answers_out_of_step_are_never_accepted() {
    let drive = chain(&[0xbc, 0x55, 0x01, 0xaa, 0x02], &[], [0x0155, 0x02aa]);
    answers_out_of_step([0x0155, 0x02aa], &drive, &resynchronised_amid(VERSION_1));
    answers_out_of_step([0; 2], &stopped("e,0,0\r\n"), &resynchronised(VERSION_1));
}

fn answers_out_of_step(speeds: [i16; 2], drive: &[Step], resynchronised: &[Step]) {
    let [asked, whole] = &chain(&[0xaf], &[1234, 5678], speeds)[..] else {
        unreachable!()
    };
    let Step::Say(_, whole) = whole else { unreachable!() };
    let good = chain(&[0xaf], &[10, 20], speeds);
    let spoilt: Vec<Vec<u8>> = (0..whole.len())
        .flat_map(|place| {
            let (mut less, mut more) = (whole.clone(), whole.clone());
            less.remove(place);
            more.insert(place, whole[place]);
            [less, more, whole[..place].to_vec()]
        })
        .collect();
    for bytes in spoilt {
        let answer = if bytes.is_empty() { vec![] } else { vec![say(&bytes)] };
        let steps = [
            drive.to_vec(),
            vec![asked.clone()],
            answer,
            resynchronised.to_vec(),
            good.clone(),
        ];
        let mut robot = binary(steps.concat());
        robot.drive(speeds[0].into(), speeds[1].into()).unwrap();
        assert_eq!(robot.odometry().unwrap().counts, [10, 20], "{bytes:?}");
    }
}

/// With nothing near, proximity sensors answer 0, and so does a stopped robot: the late part of such an answer must not
/// pass for the answer to a stop.
#[test]
fn zeros_of_sensors_do_not_confirm_a_stop() {
    let zeros = [vec![hear("D,0,0\r"), say([0; 4])], resynchronised(VERSION_1)].concat();
    let mut robot = binary([zeros.clone(), stopped("e,0,0\r\n")].concat());
    robot.stop().unwrap();
    let mut robot = binary([zeros.clone(), zeros.clone(), zeros].concat());
    assert!(matches!(robot.stop(), Err(Error::TimedOut { .. })));
    // Before the answer, and after it.
    let amid = [hear("D,0,0\r"), say([0, 0, 0, 0, b'd', b'\r', b'\n'])].to_vec();
    let after = [hear("D,0,0\r"), say("d\r\n"), hear("E\r"), say(b"\0\0\0\0e,0,0\r\n")].to_vec();
    for steps in [amid, after] {
        let steps = [steps, resynchronised(VERSION_1), stopped("e,0,0\r\n")];
        binary(steps.concat()).stop().unwrap();
    }
}

#[test]
fn silence_ends_in_time() {
    let mut robot = binary(vec![hear("D,0,0\r"), hear([FLUSH, b"\rD,0,0\r"].concat()), hear("V\r")]);
    let start = robot.talk.now();
    assert!(matches!(robot.stop(), Err(Error::TimedOut { command, .. }) if command == "D,0,0"));
    assert_eq!(robot.talk.now(), start + 2 * PATIENCE + SILENCE);
}

/// It obeys a remote control, for example.
#[test]
fn a_robot_that_keeps_its_speeds_has_not_stopped() {
    let kept = [stopped("e,0,300\r\n"), resynchronised(VERSION_1)].concat();
    for opening in [opening(VERSION_1, EIGHT, true), opening(VERSION_1, EIGHT, false)] {
        let mut robot = start(opening, vec![kept.clone(); TRIES as usize].concat());
        assert!(matches!(robot.stop(), Err(Error::StillTurning { seen }) if seen == "its speeds are [0, 300]"));
    }
}

/// One byte lost must not cost an e-puck2 its sensors that have no letter.
#[test]
fn the_question_for_binary_is_repeated() {
    let opening = opening(VERSION_2, EIGHT, true);
    let (before, probe) = opening.split_at(opening.len() - 2);
    let lost = vec![probe[0].clone(), say([0; 7])];
    let robot = start([before, &lost, &resynchronised(VERSION_2), probe].concat(), vec![]);
    assert_eq!(robot.dialect, Dialect::Binary);
    // No answer even in text is no sign of old firmware.
    let silent = vec![probe[0].clone(), hear([FLUSH, b"\rD,0,0\r"].concat()), hear("V\r")];
    let mut robot = EPuck::new(Box::new(Scripted::new([before, &silent].concat())));
    assert!(matches!(robot.begin(), Err(Error::TimedOut { .. })));
}

/// The remote control's key 5 stops an e-puck 1.x.
#[test]
fn another_s_speeds_are_noticed() {
    let stopped = || [chain(&[0xaf], &[0, 0], [0, 0]), resynchronised_amid(VERSION_1)].concat();
    let drive = chain(&[0xbc, 100, 0, 100, 0], &[], [100, 100]);
    let mut robot = binary([drive, stopped(), stopped(), stopped()].concat());
    robot.drive(100, 100).unwrap();
    let words = robot.odometry().unwrap_err().to_string();
    assert!(words.contains("speeds [0, 0] and not [100, 100]"), "{words}");
}

#[test]
fn readings_out_of_range_are_asked_again() {
    let bad = || {
        [
            chain(&[0xb2], &[4096, 0, 0, 0, 0, 0, 0, 0], [0, 0]),
            resynchronised(VERSION_1),
        ]
        .concat()
    };
    let good = chain(&[0xb2], &[1; 8], [0, 0]);
    let reading = binary([bad(), bad(), good].concat()).sense(&[Kind::Proximity]).unwrap();
    assert_eq!(reading.values, [1.0; 8]);
    let error = binary([bad(), bad(), bad()].concat())
        .sense(&[Kind::Proximity])
        .unwrap_err();
    assert!(matches!(error, Error::Garbage { command, .. } if command == "proximity sensors"));
}

/// An answer that makes no sense is also asked for again in text.
#[test]
fn lines_out_of_range_are_asked_again() {
    let bad = [
        vec![hear("N\r"), say("n,4096,0,0,0,0,0,0,0\r\n")],
        resynchronised(VERSION_1),
    ]
    .concat();
    let mut robot = text([bad, vec![hear("N\r"), say(EIGHT)]].concat());
    assert_eq!(robot.sense(&[Kind::Proximity]).unwrap().values[7], 8.0);
    let bad = [vec![hear("b\r"), say("b,2\r\n")], resynchronised(VERSION_1)].concat();
    let mut robot = text([bad, vec![hear("b\r"), say("b,1\r\n")]].concat());
    assert!(!robot.battery().unwrap().low);
}

/// After a restart the step counters and the speeds are 0.
#[test]
fn a_restart_is_reported_and_counters_begin_anew() {
    let before = vec![say_after(0, BOOT)];
    let instead = vec![hear([0xaf, 0xbb, 0]), say(BOOT)];
    let amid = vec![hear([0xaf, 0xbb, 0]), say([1, 0, 2]), say(BOOT)];
    for restart in [before, instead, amid] {
        let drive = chain(&[0xbc, 100, 0, 100, 0], &[], [100, 100]);
        let then = [chain(&[0xaf], &[900, 900], [100, 100]), restart];
        let after = [resynchronised(VERSION_1), chain(&[0xaf], &[5, 6], [0, 0])];
        let mut robot = binary([drive, then.concat(), after.concat()].concat());
        robot.drive(100, 100).unwrap();
        assert_eq!(robot.odometry().unwrap().counts, [900, 900]);
        assert_eq!(robot.odometry(), Err(Error::Restarted));
        assert_eq!(robot.odometry().unwrap().counts, [5, 6]);
    }
}

/// After `R`, and on a line with noise, one or two lines of "Command not found" wait.
#[test]
fn stray_lines_before_the_version_do_no_harm() {
    let stray = vec![say_after(0, "z,Command not found\r\nz,Command not found\r\n")];
    let flushed = vec![hear([FLUSH, b"\rD,0,0\r"].concat()), say("z,Command not found\r\n")];
    let begin = [stray, flushed, opening(VERSION_1, EIGHT, true)[1..].to_vec()];
    let mut robot = EPuck::new(Box::new(Scripted::new(begin.concat())));
    robot.begin().unwrap();
}

#[test]
fn what_is_no_e_puck_is_not_taken_for_one() {
    let khepera = || {
        vec![
            hear([FLUSH, b"\rD,0,0\r"].concat()),
            hear("V\r"),
            say("z,Protocol error\r\n"),
        ]
    };
    let mut robot = EPuck::new(Box::new(Scripted::new([khepera(), khepera()].concat())));
    assert!(robot.begin().unwrap_err().may_pass());
    let silent = || vec![hear([FLUSH, b"\rD,0,0\r"].concat()), hear("V\r")];
    let mut robot = EPuck::new(Box::new(Scripted::new([silent(), silent()].concat())));
    assert!(matches!(robot.begin(), Err(Error::TimedOut { .. })));
}

#[test]
fn a_lost_link_is_opened_again() {
    let steps = [
        vec![hear([0xbc, 1, 0, 1, 0, 0xbb, 0]), Step::HangUp, Step::Reopen],
        opening(VERSION_1, EIGHT, true),
    ];
    let mut robot = binary(steps.concat());
    assert!(matches!(robot.drive(1, 1), Err(Error::Disconnected { .. })));
    robot.reconnect().unwrap();
}

#[test]
fn another_kind_of_robot_is_not_taken_for_the_one_before() {
    let steps = [vec![Step::Reopen], opening(VERSION_2, EIGHT, true)].concat();
    let words = binary(steps).reconnect().unwrap_err().to_string();
    assert!(words.contains("e-puck was there, and now e-puck2 answers"), "{words}");
}

#[test]
fn random_lines_about_the_battery_never_panic() {
    let mut random = Random(3);
    for _ in 0..20_000 {
        let line = talk::shown(&random.mutated(b"b,2100 (88%)"));
        if let Ok(Charge::Raw { percent, .. }) = battery(&line) {
            assert!(line.contains(&format!("{percent}%")), "{line}");
        }
    }
}
