use super::super::script::{Random, Scripted, Step, hear, say, say_after};
use super::*;

/// A block with counters; all other values are in range.
fn block(steps: [i16; 2]) -> [u8; 104] {
    let mut block = [0; 104];
    block[79..81].copy_from_slice(&steps[0].to_le_bytes());
    block[81..83].copy_from_slice(&steps[1].to_le_bytes());
    block
}

/// An answer with sensors.
pub(crate) fn answer(steps: [i16; 2]) -> Vec<u8> {
    [&[2], &block(steps)[..]].concat()
}

/// A command that only sets speeds.
fn command(left: i16, right: i16) -> Vec<u8> {
    let mut command = vec![0x80, 2, 0];
    command.extend(left.to_le_bytes());
    command.extend(right.to_le_bytes());
    command.resize(21, 0);
    command
}

/// Answers of a robot that stands, for as long as a stop takes.
fn standing(steps: [i16; 2]) -> Vec<Step> {
    (0..26).map(|_| say_after(20, answer(steps))).collect()
}

/// The dialogue until the robot is ready.
pub(crate) fn opening() -> Vec<Step> {
    [vec![hear(command(0, 0))], standing([0, 0])].concat()
}

fn connect(link: Scripted) -> EPuck2 {
    EPuck2::connect(Box::new(link)).unwrap().unwrap()
}

fn robot(steps: impl IntoIterator<Item = Step>) -> EPuck2 {
    connect(Scripted::new(opening().into_iter().chain(steps)))
}

/// The table of the block, with a different number at each place.
#[test]
fn every_sensor_is_read_from_its_place() {
    let mut bytes = block([-1000, 1500]);
    let put = |bytes: &mut [u8; 104], at: usize, words: &[u16]| {
        for (index, word) in words.iter().enumerate() {
            bytes[at + 2 * index..][..2].copy_from_slice(&word.to_le_bytes());
        }
    };
    put(&mut bytes, 0, &[1, (-2_i16) as u16, 800]);
    put(&mut bytes, 18, &[(-32_768_i16) as u16, 0, 32_767]);
    for (index, value) in [-1.5_f32, 20.25, 48.0].into_iter().enumerate() {
        bytes[24 + 4 * index..][..4].copy_from_slice(&value.to_le_bytes());
    }
    bytes[36] = (-5_i8) as u8;
    put(&mut bytes, 37, &[1, 2, 3, 4, 5, 6, 7, 4095]);
    put(&mut bytes, 53, &[11, 12, 13, 14, 15, 16, 17, 18]);
    put(&mut bytes, 69, &[2000]);
    put(&mut bytes, 71, &[21, 22, 23, 24]);
    put(&mut bytes, 83, &[3277]);
    put(&mut bytes, 90, &[31, 32, 1000]);
    bytes[102] = 1;
    let mut robot = robot([say([&[2], &bytes[..]].concat())]);
    robot.next().unwrap();
    let kinds: Vec<Kind> = robot.description().sensors.iter().map(|group| group.kind).collect();
    let names = robot
        .description()
        .sensors
        .iter()
        .map(|group| group.names.len())
        .sum::<usize>();
    let reading = robot.sense(&kinds).unwrap();
    let expected = [
        1., -2., 800., -32_768., 0., 32_767., -1.5, 20.25, 48., -5., 1., 2., 3., 4., 5., 6., 7., 4095., 11., 12., 13.,
        14., 15., 16., 17., 18., 2000., 21., 22., 23., 24., 31., 32., 1000., 1.,
    ];
    assert_eq!(reading.values, expected);
    assert_eq!(names, expected.len());
    // Gravity is along the third axis.
    assert_eq!(robot.lifted(), Ok(false));
    assert_eq!(robot.odometry().unwrap().counts, [-1000, 1500]);
    let battery = robot.battery().unwrap();
    assert_eq!(battery.volts, Some(3277.0 / 819.2));
    assert!(!battery.low);
}

#[test]
fn commands_are_21_bytes_with_everything_in_its_place() {
    let mut expected = command(1000, -1000);
    let mut steps = vec![hear(&expected)];
    // LEDs 1 to 8, the body's and the front's.
    for (at, on) in [
        (7, 1),
        (8, 100),
        (7, 2),
        (11, 100),
        (7, 4),
        (14, 100),
        (7, 8),
        (17, 100),
        (7, 16),
        (7, 32),
    ] {
        if at == 7 {
            expected[7] |= on;
        } else {
            expected[at..at + 3].fill(on);
        }
        steps.push(hear(&expected));
    }
    expected[7] = 0x2f;
    steps.push(hear(&expected));
    let mut robot = robot(steps);
    robot.drive(5000, -5000).unwrap();
    for light in 0..LIGHTS.len() {
        robot.light(light, true).unwrap();
    }
    robot.light(8, false).unwrap();
    assert!(matches!(robot.light(10, true), Err(Error::Unsupported { .. })));
}

/// Answers in any chunks, with images and empty ones between them.
#[test]
fn answers_are_the_same_wherever_the_stream_is_cut() {
    let image = vec![2; Answers::IMAGE];
    let stream = [
        &[3, 1][..],
        &image,
        &answer([1, 2]),
        &[3],
        &answer([3, 4]),
        &answer([5, 6]),
        &[2, 0],
    ]
    .concat();
    let steps = |chunks: &[&[u8]]| {
        let mut answers = Answers::default();
        let mut all = Vec::new();
        for chunk in chunks {
            all.extend(answers.push(chunk).unwrap().iter().map(Block::steps));
            assert!(answers.bytes.len() <= Block::LENGTH);
        }
        all
    };
    let expected = [[1, 2], [3, 4], [5, 6]];
    assert_eq!(steps(&[&stream]), expected);
    for cut in (0..10).chain(Answers::IMAGE - 5..stream.len()) {
        assert_eq!(steps(&[&stream[..cut], &stream[cut..]]), expected, "cut at {cut}");
    }
    assert_eq!(steps(&stream.chunks(1).collect::<Vec<_>>()), expected);
    assert_eq!(steps(&stream.chunks(1448).collect::<Vec<_>>()), expected);
}

#[test]
fn random_streams_never_panic_and_memory_is_bounded() {
    let mut random = Random(5);
    for _ in 0..2000 {
        let mut answers = Answers::default();
        for _ in 0..20 {
            let stream = match random.below(3) {
                0 => random.bytes(300),
                _ => random.mutated(&[answer([1, 2]), answer([3, 4]), vec![3]].concat()),
            };
            match answers.push(&stream) {
                Ok(blocks) => assert!(blocks.iter().filter(|block| block.is_sane()).count() <= blocks.len()),
                Err(byte) => {
                    assert!(!(1..=3).contains(&byte));
                    assert_eq!(answers.push(&answer([1, 2])), Err(byte));
                    break;
                }
            }
            assert!(answers.bytes.len() <= Block::LENGTH);
        }
    }
}

#[test]
fn blocks_that_can_not_be_are_left_out() {
    let mut bad = answer([30_000, 30_000]);
    bad[1 + 38] = 0xff;
    let mut robot = robot([say(bad), say(answer([7, 8]))]);
    robot.next().unwrap();
    assert_eq!(robot.odometry().unwrap().counts, [7, 8]);
    let mut not_a_number = block([0, 0]);
    not_a_number[24..28].copy_from_slice(&f32::NAN.to_le_bytes());
    assert!(!Block(not_a_number).is_sane());
}

/// Data that came while nobody called are read before a command, and are not taken for new.
#[test]
fn the_stream_is_read_before_each_command_and_what_came_earlier_is_not_current() {
    let backlog = (1..50).map(|step| say_after(20, answer([step, step])));
    let then = [hear(command(5, 5)), say(answer([50, 50]))];
    let link = Scripted::new(opening().into_iter().chain(backlog).chain(then));
    let hand = link.hand();
    let mut robot = connect(link);
    hand.advance(49 * 20);
    robot.drive(5, 5).unwrap();
    assert_eq!(robot.steps.total, [49, 49]);
    // Though the last one may have come this moment, nobody knows when it came.
    assert_eq!(robot.odometry().unwrap().counts, [50, 50]);
}

#[test]
fn a_reading_says_how_old_it_is() {
    let steps = [
        say_after(30, answer([1, 1])),
        say_after(1000, answer([2, 2])),
        say(answer([3, 3])),
    ];
    let link = Scripted::new(opening().into_iter().chain(steps));
    let hand = link.hand();
    let mut robot = connect(link);
    let before = robot.sense(&[Kind::Button]).unwrap();
    hand.advance(29);
    assert_eq!(robot.sense(&[Kind::Button]).unwrap(), before, "while it is new");
    hand.advance(60);
    // One has come at an unknown time: after the last look, perhaps at once after it. The next comes after the radio's
    // pause, and its readings may be from before that.
    let late = robot.sense(&[Kind::Button]).unwrap();
    assert_eq!(late.at, before.at + Duration::from_millis(1030));
    assert_eq!(late.age, Duration::from_millis(1030 - 29));
    robot.next().unwrap();
}

/// Data held back by the network are older than the time since the block before.
#[test]
fn readings_that_come_together_are_as_old_as_the_first_may_be() {
    let late = [answer([1, 1]), answer([2, 2])].concat();
    let mut robot = robot([say_after(700, late)]);
    assert_eq!(robot.next().unwrap().age, Duration::from_millis(700));
    assert_eq!(robot.odometry().unwrap().counts, [2, 2]);
}

/// A command has no answer: only the counters show that the wheels stand.
#[test]
fn a_stop_is_proved_by_the_counters() {
    let braking = [10, 20, 25, 26].map(|step| say_after(20, answer([step, step])));
    let mut steps = vec![hear(command(0, 0))];
    steps.extend(braking);
    steps.extend((0..25).map(|_| say_after(20, answer([26, 26]))));
    let mut obedient = robot(steps);
    let start = obedient.link.now();
    obedient.stop().unwrap();
    assert_eq!(obedient.link.now(), start + Duration::from_millis(580));
}

/// The counters after an unconfirmed stop.
fn unstopped(answers: impl IntoIterator<Item = Step>) {
    let mut robot = robot([hear(command(0, 0))].into_iter().chain(answers));
    let start = robot.link.now();
    let error = robot.stop().unwrap_err();
    assert!(matches!(&error, Error::StillTurning { .. }), "{error}");
    assert_eq!(robot.link.now(), start + PATIENCE + STANDSTILL);
}

#[test]
fn wheels_that_turn_are_not_said_to_stand() {
    // 50 steps/s, and 2.5.
    unstopped((1..100).map(|step| say_after(20, answer([step, 0]))));
    unstopped((1..100).map(|step| say_after(20, answer([0, step / 20]))));
    // Two answers far from each other, and some that come late, all at once.
    unstopped([
        say(answer([5, 5])),
        say_after(1000, answer([5, 5])),
        say_after(980, answer([6, 6])),
    ]);
    let late = answer([5, 5]).repeat(EQUAL - 2);
    unstopped([
        say(answer([5, 5])),
        say_after(1000, late),
        say_after(20, answer([6, 6])),
    ]);
}

#[test]
fn answers_that_come_seldom_show_a_standstill_too() {
    let steps = (0..EQUAL).map(|_| say_after(100, answer([5, 5])));
    robot([hear(command(0, 0))].into_iter().chain(steps)).stop().unwrap();
}

#[test]
fn silence_is_borne_for_as_long_as_the_radio_pauses() {
    let mut robot = robot([say_after(1100, answer([1, 1]))]);
    robot.next().unwrap();
    let start = robot.link.now();
    assert!(matches!(robot.next(), Err(Error::TimedOut { .. })));
    assert_eq!(robot.link.now(), start + PATIENCE);
}

#[test]
fn counters_wrap_and_a_restart_is_noticed() {
    let at = |steps: [i16; 2]| say_after(60, answer(steps));
    let mut robot = robot([
        at([1500, -1500]),
        at([3000, -3000]),
        at([4500, -4500]),
        at([0, 0]),
        hear(command(0, 0)),
        at([1, 2]),
    ]);
    for total in [[1500, -1500], [3000, -3000], [4500, -4500]] {
        robot.next().unwrap();
        assert_eq!(robot.odometry().unwrap().counts, total);
    }
    assert_eq!(robot.next().map(|_| ()), Err(Error::Restarted));
    robot.next().unwrap();
    assert_eq!(robot.odometry().unwrap().counts, [1, 2]);
    let mut unwrapped = Unwrapped::<16>::default();
    assert_eq!(unwrapped.next([32_000_i16, -32_000]), [32_000, -32_000]);
    assert_eq!(unwrapped.next([-32_536_i16, 32_536]), [33_000, -33_000]);
}

/// Its counters were too small to show it by their change.
#[test]
fn counters_at_0_after_a_silence_are_a_restart() {
    let mut restarted = robot([
        say_after(20, answer([300, -20])),
        say_after(1000, answer([0, 0])),
        hear(command(0, 0)),
        say_after(20, answer([4, 4])),
    ]);
    restarted.next().unwrap();
    assert_eq!(restarted.next().map(|_| ()), Err(Error::Restarted));
    restarted.next().unwrap();
    assert_eq!(restarted.odometry().unwrap().counts, [4, 4]);
    // Without a silence the wheels have turned back; and the radio also pauses by itself.
    let mut back = robot([
        say_after(20, answer([8, 8])),
        say_after(20, answer([0, 0])),
        say_after(1000, answer([0, 0])),
        say_after(1000, answer([0, 300])),
        say_after(1000, answer([0, 10])),
    ]);
    for _ in 0..5 {
        back.next().unwrap();
    }
}

/// The radio drives the robot with its last command again, whether the restart is noticed before a command or amid
/// readings; and no later command brings the old speeds back.
#[test]
fn after_a_restart_the_speeds_are_0() {
    let driven = || [hear(command(500, 500)), say(answer([9000, 9000]))];
    let mut lit = command(0, 0);
    lit[7] = 1;
    let restarted = [say(answer([3, 3])), hear(command(0, 0))];
    for is_sensing in [true, false] {
        let link = Scripted::new([&opening()[..], &driven(), &restarted, &[hear(&lit)]].concat());
        let hand = link.hand();
        let mut robot = connect(link);
        robot.steps = Unwrapped::default();
        robot.drive(500, 500).unwrap();
        robot.next().unwrap();
        hand.advance(10);
        if is_sensing {
            assert_eq!(robot.sense(&[Kind::Button]), Err(Error::Restarted));
        } else {
            assert_eq!(robot.drive(700, 700), Err(Error::Restarted));
        }
        robot.light(0, true).unwrap();
    }
}

#[test]
fn a_loud_clap_is_no_reason_to_leave_a_block_out() {
    let mut loud = block([7, 8]);
    loud[71..79].fill(0xff);
    let mut robot = robot([say([&[2], &loud[..]].concat())]);
    robot.next().unwrap();
    assert_eq!(robot.sense(&[Kind::Sound]).unwrap().values, [65_535.0; 4]);
}

#[test]
fn a_stream_out_of_step_ends_in_an_error_and_connects_again() {
    let steps = [
        vec![say_after(60, [9, 9, 9])],
        vec![Step::Reopen],
        opening(),
        vec![Step::HangUp, Step::Reopen],
        opening(),
    ];
    let mut robot = robot(steps.concat());
    let words = robot.next().unwrap_err().to_string();
    assert!(words.contains("the unknown header 0x09"), "{words}");
    robot.reconnect().unwrap();
    assert!(matches!(robot.next(), Err(Error::Disconnected { .. })));
    robot.reconnect().unwrap();
    assert_eq!(robot.odometry().unwrap().counts, [0, 0]);
}

/// Nonsense that waits does not hold a stop back.
#[test]
fn a_stop_is_sent_even_out_of_step() {
    let link = Scripted::new([opening(), vec![say([9, 9]), hear(command(0, 0))]].concat());
    let hand = link.hand();
    let mut robot = connect(link);
    hand.advance(10);
    assert!(matches!(robot.stop(), Err(Error::Garbage { .. })));
}

#[test]
fn what_does_not_answer_is_no_e_puck2() {
    let connected = |steps: &[Step]| EPuck2::connect(Box::new(Scripted::new(steps.to_vec())));
    assert!(connected(&[hear(command(0, 0))]).unwrap().is_none());
    let talks = [hear(command(0, 0)), say("z,Command not found\r\n")];
    assert!(connected(&talks).unwrap().is_none());
    // A robot that has answered is one, even if it then falls silent.
    let falls_silent = [hear(command(0, 0)), say(answer([0, 0]))];
    assert!(matches!(connected(&falls_silent), Err(Error::StillTurning { .. })));
    let nonsense = [hear(command(0, 0)), say(answer([0, 0])), say([9])];
    assert!(matches!(connected(&nonsense), Err(Error::Garbage { .. })));
}
