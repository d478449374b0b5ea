use super::super::script::Random;
use super::super::{Kind, Robot, recognise};
use super::khepera::surrogate::{self, Simulated};
use super::khepera::{Firmware, Rolling, resampled};
use super::*;

const RATES: [u32; 5] = [9600, 19_200, 38_400, 57_600, 115_200];

fn bench(firmware: Firmware, baud: u32) -> Bench<Rolling> {
    Bench::new(Khepera::new(Rolling::default(), firmware, baud))
}

/// A robot with turning wheels, and the driver that has found it.
fn connected(bench: &Bench<impl Body + 'static>) -> Box<dyn Robot> {
    bench.line().robot.receive(b"D,9,-9\n", Duration::from_secs(99));
    let robot = recognise(Box::new(bench.clone())).unwrap().unwrap();
    assert_eq!(bench.line().robot.speeds(), [0, 0], "it is stopped at once");
    robot
}

/// The usual robot.
fn usual() -> (Bench<Rolling>, Box<dyn Robot>) {
    let bench = bench(Firmware::ALL[0], 38_400);
    let robot = connected(&bench);
    (bench, robot)
}

/// Sets readings that no call has seen before, and returns them: proximity, then light.
fn fresh(bench: &Bench<Rolling>, random: &mut Random) -> Vec<f64> {
    let mut line = bench.line();
    let mut eight = || std::array::from_fn(|_| random.below(1024) as u16);
    (line.robot.body.proximity, line.robot.body.light) = (eight(), eight());
    let body = &line.robot.body;
    body.proximity
        .iter()
        .chain(&body.light)
        .copied()
        .map(f64::from)
        .collect()
}

const BOTH: [Kind; 2] = [Kind::Proximity, Kind::Light];

/// The emulator itself, by the table of commands.
#[test]
fn the_emulator_answers_as_the_protocol_says() {
    for firmware in Firmware::ALL {
        let mut robot = Khepera::new(Rolling::default(), firmware, 9600);
        robot.body.proximity = [0, 1023, 2, 3, 4, 5, 6, 7];
        robot.inputs = [0, 0, 0, 512, 0, 1023];
        let mut now = Duration::ZERO;
        let mut say = |robot: &mut Khepera<Rolling>, text: &str| {
            robot.receive(text.as_bytes(), now);
            now += Duration::from_secs(1);
            String::from_utf8(robot.send(now)).unwrap()
        };
        let unknown = firmware.unknown;
        for (command, answer) in [
            ("A,3800,800,100", "a"),
            ("A,3800,800", "z,Protocol error"),
            ("B", "b,5.01,5.00"),
            ("B,1", "z,Protocol error"),
            ("D,5,-200", "d"),
            ("E", "e,5,-127"),
            ("D,1", "z,Protocol error"),
            ("D,1,2,3", "z,Protocol error"),
            ("D,1,x", "z,Protocol error"),
            ("D,,0", "z,Protocol error"),
            ("D", "z,Protocol error"),
            ("E", "e,5,-127"),
            ("D,0,0", "d"),
            ("G,-5,2147483647", "g"),
            ("H", "h,-5,2147483647"),
            ("F,3000,20,4000", "f"),
            ("I,3", "i,512"),
            ("I,6", "z,Protocol error"),
            ("J,20,64,20,64", "j"),
            ("L,0,1", "l"),
            ("L,1,2", "l"),
            ("L,2,1", "z,This LED does not exist."),
            ("L,0,3", "z,This LED action is not possible."),
            ("K", "k,0,1,0,0,1,0"),
            ("N", "n,0,1023,2,3,4,5,6,7"),
            ("O", "o,500,500,500,500,500,500,500,500"),
            ("P,255,-300", "p"),
            ("E", "e,127,-127"),
            ("P,0,0", "p"),
            ("W,7,63", "w"),
            ("R,63", "r,7"),
            ("R,64", "z,Protocol error"),
            ("T,1,B", "t,1,B"),
            ("T,gripper", "z,Protocol error"),
            ("M", unknown),
            ("Q", unknown),
            ("n", unknown),
            ("NN", unknown),
            ("list", unknown),
        ] {
            for end in ["\n", "\r", "\r\n", "\n\r\n\n"] {
                let said = say(&mut robot, &format!("{command}{end}"));
                // Commands have the same effect twice as once, except these.
                if command != "L,1,2" {
                    assert_eq!(said, format!("{answer}{}", firmware.end), "{command}");
                }
            }
        }
        assert_eq!(robot.lights(), [true, false]);
        assert_eq!(say(&mut robot, "\n\r\r\n"), "");
    }
}

/// Counters count what the wheels turn, and wrap; positions are reached and kept.
#[test]
fn the_emulator_counts_and_goes_to_positions() {
    let mut robot = Khepera::new(Rolling::default(), Firmware::ALL[0], 115_200);
    let at = Duration::from_millis;
    robot.receive(b"G,2147483647,0\nD,3,-2\n", at(0));
    let first_counters = robot.counters();
    robot.live(at(2000));
    let [left, right] = robot.counters();
    // 2 s less the time on the line, a pulse to each 10 ms and unit.
    assert_eq!(first_counters[0], i32::MAX);
    assert!((598..=600).contains(&(left.wrapping_sub(i32::MAX))), "{left}");
    assert!((-400..=-398).contains(&right), "{right}");
    robot.receive(b"G,0,0\nC,100,-37\nK\n", at(2000));
    robot.live(at(2050));
    let said = String::from_utf8(robot.send(at(2050))).unwrap();
    assert!(said.contains("k,0,0,"), "{said}");
    robot.live(at(4000));
    assert_eq!((robot.counters(), robot.speeds()), ([100, -37], [0, 0]));
    robot.receive(b"K\n", at(4000));
    let said = String::from_utf8(robot.send(at(5000))).unwrap();
    assert!(said.ends_with("k,1,0,0,1,0,0\r\n"), "{said}");
    // It keeps its speed for ever.
    robot.receive(b"D,1,1\n", at(5000));
    robot.live(Duration::from_secs(100_000));
    assert_eq!(robot.speeds(), [1, 1]);
    robot.restart(Duration::from_secs(100_000));
    assert_eq!((robot.counters(), robot.speeds()), ([0, 0], [0, 0]));
}

/// 36 bytes at 9600 baud, of 11 bits each, and the 2 of the command.
#[test]
fn bytes_take_their_time_on_the_line() {
    let mut robot = Khepera::new(Rolling::default(), Firmware::ALL[0], 9600);
    robot.body.proximity = [1023; 8];
    robot.receive(b"N\n", Duration::ZERO);
    let timed = robot.timed();
    let last = timed.last().unwrap().0.as_secs_f64();
    assert_eq!(timed.len(), 43);
    assert!((last - 45.0 * 11.0 / 9600.0).abs() < 1e-6, "{last}");
}

/// A receiver at the sender's rate receives the same bytes, at another rate different ones.
#[test]
fn a_port_at_another_rate_hears_something_else() {
    let text = b"B\rD,0,0\rN\rb,5.01,5.00\r\n";
    for sent in RATES {
        for heard in RATES {
            let same = resampled(text, sent, heard) == text;
            assert_eq!(same, sent == heard, "{sent} {heard}");
        }
    }
}

/// At each rate and of each firmware, with bytes that come one by one or all at once.
#[test]
fn the_driver_does_all_that_a_robot_can() {
    for (firmware, baud) in Firmware::ALL
        .into_iter()
        .flat_map(|firmware| RATES.map(|baud| (firmware, baud)))
    {
        for chunk in [1, usize::MAX] {
            let bench = bench(firmware, baud);
            bench.line().chunk = chunk;
            let mut robot = connected(&bench);
            let description = robot.description().clone();
            assert_eq!(
                (&description.robot[..], &description.firmware[..]),
                ("Khepera", "5.01,5.00")
            );
            let mut random = Random(baud.into());

            let seen = fresh(&bench, &mut random);
            let reading = robot.sense(&BOTH).unwrap();
            assert_eq!(reading.values, seen);
            assert_eq!(reading.at, bench.now());
            let reversed = [&seen[8..], &seen[..8]].concat();
            assert_eq!(robot.sense(&[Kind::Light, Kind::Proximity]).unwrap().values, reversed);
            assert_eq!(robot.sense(&[]).unwrap().values, [0.0; 0]);
            assert!(matches!(robot.sense(&[Kind::Ground]), Err(Error::Unsupported { .. })));

            robot.drive(12, -7).unwrap();
            assert_eq!(bench.line().robot.speeds(), [12, -7]);
            assert_eq!(robot.sense(&[Kind::WheelSpeed]).unwrap().values, [12.0, -7.0]);
            robot.drive(9999, -9999).unwrap();
            let greatest = description.wheels.greatest;
            assert_eq!(bench.line().robot.speeds(), [greatest, -greatest]);
            robot.drive(i32::MIN, i32::MAX).unwrap();
            assert_eq!(bench.line().robot.speeds(), [-greatest, greatest]);
            let unit = description.wheels.mm_s;
            robot.drive_mm_s(10.4 * unit, -9.6 * unit).unwrap();
            assert_eq!(bench.line().robot.speeds(), [10, -10]);
            robot.drive_mm_s(f64::NAN, f64::INFINITY).unwrap();
            assert_eq!(bench.line().robot.speeds(), [0, greatest]);
            robot.stop().unwrap();
            assert_eq!(bench.line().robot.speeds(), [0, 0]);
            robot.drive(3, 4).unwrap();
            robot.stop_briefly().unwrap();
            assert_eq!(bench.line().robot.speeds(), [0, 0]);

            for (light, on) in [(0, true), (1, true), (0, true), (0, false), (0, false)] {
                robot.light(light, on).unwrap();
                assert_eq!(bench.line().robot.lights()[light], on);
            }
            assert_eq!(description.lights.len(), 2);
            assert!(matches!(robot.light(2, true), Err(Error::Unsupported { .. })));
            assert!(matches!(robot.battery(), Err(Error::Unsupported { .. })));
            assert!(matches!(robot.lifted(), Err(Error::Unsupported { .. })));

            robot.drive(5, 5).unwrap();
            robot.close().unwrap();
            assert_eq!(bench.line().robot.speeds(), [0, 0]);
        }
    }
}

/// The age of a reading is at least the time since the robot took it.
#[test]
fn the_age_of_a_reading_is_an_upper_bound() {
    for baud in RATES {
        let bench = bench(Firmware::ALL[0], baud);
        let mut robot = connected(&bench);
        bench.line().robot.body.proximity = [1023; 8];
        let before = bench.now();
        let reading = robot.sense(&[Kind::Proximity]).unwrap();
        // It was taken when the command had arrived.
        let taken = before + 2 * bench.line().robot.byte_time();
        assert!(
            reading.age >= reading.at.saturating_sub(taken),
            "{baud}: {:?}",
            reading.age
        );
        assert!(reading.age <= Duration::from_millis(200), "{baud}: {:?}", reading.age);
    }
}

/// Counters of 32 bits are continued where they wrap, both ways, and start at 0 after a restart.
#[test]
fn odometers_go_on_where_counters_wrap() {
    let (bench, mut robot) = usual();
    for start in [0, i32::MAX - 20, i32::MIN + 20] {
        bench.line().robot.set_counters([start; 2]);
        robot.reconnect().unwrap();
        let first = robot.odometry().unwrap();
        assert_eq!(first.counts, [i64::from(start); 2]);
        robot.drive(30, -30).unwrap();
        bench.pass(1000);
        robot.stop().unwrap();
        let odometry = robot.odometry().unwrap();
        let [left, right] = [0, 1].map(|wheel| odometry.counts[wheel] - first.counts[wheel]);
        assert!(
            (3000..3300).contains(&left) && (-3300..-2990).contains(&right),
            "{left} {right}"
        );
        assert_eq!(odometry.at, bench.now());
        let low = odometry.counts.map(|count| count as i32);
        assert_eq!(low, bench.line().robot.counters());
    }
    bench.line().restart();
    bench.pass(100);
    assert_eq!(robot.odometry(), Err(Error::Restarted));
    assert_eq!(robot.odometry().unwrap().counts, [0, 0]);
}

/// A call of a robot, and whether what it has returned or brought about is right.
type Call = fn(&mut dyn Robot, &Bench<Rolling>, &[f64]) -> Result<bool>;

/// Calls that find out.
const CALLS: [(&str, Call); 5] = [
    ("sense", |robot, _, seen| Ok(robot.sense(&BOTH)?.values == seen)),
    ("drive", |robot, bench, _| {
        robot.drive(17, -23)?;
        Ok(bench.line().robot.speeds() == [17, -23])
    }),
    ("stop", |robot, bench, _| {
        robot.stop()?;
        Ok(bench.line().robot.speeds() == [0, 0])
    }),
    ("light", |robot, bench, _| {
        robot.light(1, true)?;
        Ok(bench.line().robot.lights() == [false, true])
    }),
    ("odometry", |robot, bench, _| {
        let odometry = robot.odometry()?;
        let counters = bench.line().robot.counters().map(i64::from);
        // The wheels turn at 40 pulses / 10 ms at most.
        let most = 4 * (odometry.age.as_millis() as i64 + 1);
        Ok([0, 1]
            .iter()
            .all(|&wheel| (odometry.counts[wheel] - counters[wheel]).abs() <= most))
    }),
];

/// Whatever it interrupts, a restart is reported once.
#[test]
fn a_restart_is_reported_once() {
    for (name, call) in CALLS {
        // Between two calls, or after this number of bytes of the answer.
        for after in [None].into_iter().chain((0..=44).map(Some)) {
            let (bench, mut robot) = usual();
            robot.drive(40, 40).unwrap();
            match after {
                None => {
                    bench.line().restart();
                    bench.pass(500);
                }
                Some(_) => bench.line().robot.restarts_after = after,
            }
            let seen = fresh(&bench, &mut Random(1));
            let mut restarts = 0;
            for attempt in 0..20 {
                if attempt == 17 {
                    // By now the banner has arrived.
                    bench.pass(500);
                }
                // It may restart after its answer, which makes its later actions meaningless.
                match call(&mut *robot, &bench, &seen) {
                    Ok(_) => {}
                    Err(Error::Restarted) => restarts += 1,
                    Err(error) => panic!("{name} {after:?}: {error}"),
                }
            }
            assert_eq!(restarts, 1, "{name} {after:?}");
        }
    }
}

/// Uses a robot whose line is spoilt by `spoil` from now on. Each call must be right or fail in time, and be right once the
/// line is. Returns the number of calls that were right.
fn used(what: &str, spoil: impl Fn(&mut Line<Rolling>)) -> usize {
    let mut right = 0;
    for (name, call) in CALLS {
        let (bench, mut robot) = usual();
        let mut random = Random(7);
        robot.drive(40, 40).unwrap();
        spoil(&mut bench.line());
        for _ in 0..3 {
            let (seen, start) = (fresh(&bench, &mut random), bench.now());
            match call(&mut *robot, &bench, &seen) {
                Ok(is_right) => {
                    assert!(is_right, "{what}, {name}");
                    right += 1;
                }
                Err(error) => assert!(error.may_pass(), "{what}, {name}: {error}"),
            }
            let took = bench.now().saturating_sub(start);
            assert!(took < Duration::from_secs(2), "{what}, {name}: {took:?}");
        }
        {
            let mut line = bench.line();
            line.inwards = Box::new(|said| said);
            line.outwards = Box::new(|sent| sent);
            line.echoes = false;
            line.robot.delay = Duration::ZERO;
        }
        bench.pass(2000);
        let seen = fresh(&bench, &mut random);
        assert_eq!(call(&mut *robot, &bench, &seen), Ok(true), "after {what}, {name}");
        robot.stop().unwrap();
        assert_eq!(bench.line().robot.speeds(), [0, 0], "after {what}");
    }
    right
}

/// All calls with a spoilt line.
const ALL: usize = 3 * CALLS.len();

/// An answer is the same wherever it is cut, if it comes in time.
#[test]
fn answers_may_come_in_parts() {
    for cut in 0..45 {
        for pause in [0, 1, 10, 40, 70] {
            let right = used(&format!("a pause of {pause} ms after byte {cut}"), |line| {
                line.inwards = Box::new(move |mut said| {
                    for (at, _) in said.iter_mut().skip(cut) {
                        *at += Duration::from_millis(pause);
                    }
                    said
                });
            });
            assert_eq!(right, ALL, "a pause of {pause} ms after byte {cut}");
        }
    }
    // Cut twice, or all at once at the end.
    for seed in 0..200 {
        let right = used(&format!("parts {seed}"), |line| {
            let mut random = Random(seed);
            line.inwards = Box::new(move |said| {
                let mut whole = said.clone();
                for index in (0..said.len()).rev() {
                    let next = whole.get(index + 1).map(|(at, _)| *at);
                    if let Some(next) = next.filter(|_| random.below(3) > 0) {
                        whole[index].0 = next;
                    }
                }
                whole
            });
        });
        assert_eq!(right, ALL);
    }
}

/// An answer that comes late is that of an older question, and never taken for a newer one's.
#[test]
fn late_answers_are_no_answers_to_what_is_asked_later() {
    for ms in (0..600).step_by(10) {
        let right = used(&format!("answers {ms} ms late"), |line| {
            line.robot.delay = Duration::from_millis(ms);
        });
        if ms <= 100 {
            assert_eq!(right, ALL, "{ms} ms");
        }
        // Only one of two comes late.
        used(&format!("each second answer {ms} ms late"), |line| {
            let mut is_late = false;
            line.inwards = Box::new(move |mut said| {
                is_late = !is_late;
                for (at, _) in said.iter_mut().filter(|_| is_late) {
                    *at += Duration::from_millis(ms);
                }
                said
            });
        });
    }
}

#[test]
fn silence_is_noticed_in_time() {
    assert_eq!(used("silence", |line| line.inwards = Box::new(|_| Vec::new())), 0);
    assert_eq!(used("deafness", |line| line.outwards = Box::new(|_| Vec::new())), 0);
    // The limit that docs/robots-on-the-wire.md names.
    let (bench, mut robot) = usual();
    bench.line().inwards = Box::new(|_| Vec::new());
    for call in [
        |robot: &mut dyn Robot| robot.drive(1, 1),
        |robot: &mut dyn Robot| robot.stop(),
    ] {
        let start = bench.now();
        assert!(matches!(call(&mut *robot), Err(Error::TimedOut { .. })));
        let took = bench.now().saturating_sub(start);
        assert!(took <= Duration::from_millis(350), "{took:?}");
    }
}

/// An echo of the command is no answer.
#[test]
fn an_echo_is_no_answer() {
    used("an echo", |line| line.echoes = true);
    let bench = bench(Firmware::ALL[0], 38_400);
    bench.line().echoes = true;
    bench.line().outwards = Box::new(|_| Vec::new());
    assert!(recognise(Box::new(bench.clone())).is_ok_and(|robot| robot.is_none()));
}

/// Nonsense, parts of answers, and unrequested whole answers, before an answer or where none was due.
#[test]
fn what_was_not_asked_for_is_no_answer() {
    let lines: [&[u8]; 12] = [
        b"\0\xff\x80",
        b"\r\n",
        b"n,1,2,3",
        b"d",
        b"n,1,2,3,4,5,6,7,8\r\n",
        b"o,1,2,3,4,5,6,7,8\r\nn,9,9,9,9,9,9,9,9\r\n",
        b"h,5,5\r\n",
        b"d\r\n",
        b"z,Protocol error\r\n",
        b"Command not found\r\n",
        b"n,1,2,3,4,5,6,7\r\n\xffn,1,2,3,4,5,6,7,1024\r\n",
        b"b,5.01,5.00\r\nb,5.01,5.00\r\n",
    ];
    for bytes in lines {
        let shown = String::from_utf8_lossy(bytes);
        // Before the call.
        for (name, call) in CALLS {
            let (bench, mut robot) = usual();
            for seed in 0..5 {
                let seen = fresh(&bench, &mut Random(seed));
                bench.line().inject(bytes);
                bench.pass(1);
                assert_eq!(call(&mut *robot, &bench, &seen), Ok(true), "{name} after {shown:?}");
            }
        }
    }
    // Nonsense that comes with the first answer, before it, in its middle or after it.
    for seed in 0..500 {
        let mut random = Random(seed);
        let bytes: Vec<u8> = random.bytes(30).into_iter().map(|byte| byte | 0x80).collect();
        let share = random.below(101);
        used(&format!("nonsense {seed}"), move |line| {
            let (bytes, mut is_over) = (bytes.clone(), false);
            line.inwards = Box::new(move |mut said| {
                if !std::mem::replace(&mut is_over, true) {
                    let place = said.len() * share / 100;
                    let at = said[place.min(said.len() - 1)].0;
                    said.splice(place..place, bytes.iter().map(|byte| (at, *byte)));
                }
                said
            });
        });
    }
}

/// A byte of an answer that is lost. In a number of several digits that goes unnoticed; here each has one.
#[test]
fn a_lost_byte_is_noticed() {
    for lost in 0..45 {
        for (name, call) in CALLS {
            let (bench, mut robot) = usual();
            bench.line().robot.set_counters([0; 2]);
            bench.line().robot.body.proximity = [0; 8];
            bench.line().robot.body.light = [0; 8];
            let mut is_over = false;
            bench.line().inwards = Box::new(move |mut said| {
                if said.len() > lost && !std::mem::replace(&mut is_over, true) {
                    said.remove(lost);
                }
                said
            });
            let start = bench.now();
            let outcome = call(&mut *robot, &bench, &[0.0; 16]);
            assert_eq!(outcome, Ok(true), "{name} without byte {lost}");
            assert!(bench.now().saturating_sub(start) < Duration::from_secs(1));
        }
    }
}

/// Each byte of a stop may be lost or changed, even a digit, for which the protocol has no check: if the driver
/// confirms the stop, the wheels stand still.
#[test]
fn a_stop_that_was_not_heard_is_not_confirmed() {
    for damaged in 0..6 {
        for new in (0..=255_u8).map(Some).chain([None]) {
            let (bench, mut robot) = usual();
            robot.drive(40, 40).unwrap();
            let mut is_over = false;
            bench.line().outwards = Box::new(move |mut sent| {
                if sent.len() > damaged && !std::mem::replace(&mut is_over, true) {
                    match new {
                        Some(byte) => sent[damaged] = byte,
                        None => drop(sent.remove(damaged)),
                    }
                }
                sent
            });
            let stopped = robot.stop();
            let speeds = bench.line().robot.speeds();
            assert!(stopped.is_err() || speeds == [0, 0], "{damaged} {new:?}: {speeds:?}");
        }
    }
}

#[test]
fn a_link_that_was_lost_is_opened_again() {
    let (bench, mut robot) = usual();
    robot.drive(40, 40).unwrap();
    bench.line().is_open = false;
    assert!(matches!(robot.sense(&BOTH), Err(Error::Disconnected { .. })));
    assert!(matches!(robot.stop(), Err(Error::Disconnected { .. })));
    assert_eq!(bench.line().robot.speeds(), [40, 40]);
    bench.line().can_open = false;
    assert!(matches!(robot.reconnect(), Err(Error::Unavailable { .. })));
    assert!(matches!(robot.odometry(), Err(Error::Disconnected { .. })));
    bench.line().can_open = true;
    bench.pass(1000);
    robot.reconnect().unwrap();
    assert_eq!(bench.line().robot.speeds(), [0, 0]);
    let seen = fresh(&bench, &mut Random(3));
    assert_eq!(robot.sense(&BOTH).unwrap().values, seen);

    // The robot has restarted, and its banner is gone: after opening the link that is no news.
    robot.drive(40, 40).unwrap();
    bench.line().is_open = false;
    bench.line().restart();
    bench.pass(1000);
    robot.reconnect().unwrap();
    assert_eq!(robot.odometry().unwrap().counts, [0, 0]);
}

fn walled() -> oneiro::arena::Arena {
    oneiro::arena::Arena::miglino1995()
}

/// The emulated robot's body is an episode of the library, with the same bits.
#[test]
fn a_simulated_body_lives_as_in_the_library() {
    use std::sync::Arc;

    use oneiro::batch::{Batch, Rollout, TraceRequest};
    use oneiro::cpu::Cpu;
    use oneiro::evaluator::{Control, Evaluator};
    use oneiro::random::Key;
    use oneiro::surrogate::{Differences, Surrogate};
    use oneiro::world::{Start, World, WorldSpec};

    const CYCLES: u32 = 40;
    let pose = [100.0, 100.0, 0.125];
    let [x, y, heading] = pose;
    for speeds in [[0, 0], [10, 10], [-10, 10], [7, -3], [-5, -4]] {
        let mut spec = WorldSpec {
            surrogate: Some(Arc::new(Surrogate::drawn(5, Differences::all(1.0)))),
            arena: walled(),
            start: Start::At { x, y, heading },
            cycles: CYCLES,
            ..WorldSpec::miglino1995()
        };
        spec.robot.motors = Arc::new(surrogate::motors());
        let genes = surrogate::genes(speeds.map(|speed| 10 * i64::from(speed)));
        let rollout = Rollout {
            world: 0,
            genes: &genes,
            key: Key::rollout(5, 0, 0, 0),
        };
        let trace = Some(TraceRequest { every: 1 });
        let batch = Batch::new(&[World::new(spec).unwrap()], &[rollout], trace).unwrap();
        let mut cpu = Cpu::new(Some(1)).unwrap();
        let life = cpu.evaluate(&batch, &Control::new()).unwrap().traces.remove(0);
        let mut body = Simulated::new(5, walled(), pose);
        for (cycle, record) in life.iter().enumerate() {
            let greatest = Simulated::GREATEST as f32;
            assert_eq!(
                [record.speed_left, record.speed_right],
                speeds.map(|speed| speed as f32 / greatest)
            );
            assert_eq!(body.pose, [record.x, record.y, record.heading], "{speeds:?} {cycle}");
            let readings = life
                .activations(cycle)
                .map(|activation| (1023.0 * activation).round() as u16);
            assert_eq!(body.proximity(), readings);
            // In unequal parts of a cycle.
            for ms in [3, 57, 40] {
                body.advance(Duration::from_millis(ms), speeds);
            }
        }
        assert_eq!(speeds == [0, 0], body.pose == pose, "{speeds:?}");
    }
}

/// The driver drives a simulated robot until it senses a wall; a person picks it up and puts it before an obstacle.
#[test]
fn a_simulated_robot_is_driven_over_the_wire() {
    let pose = [300.0, 80.0, 0.75];
    let body = Simulated::new(3, walled(), pose);
    let bench = Bench::new(Khepera::new(body, Firmware::ALL[0], 38_400));
    let mut robot = connected(&bench);
    bench.line().robot.body.place(pose);
    let sensed = |robot: &mut dyn Robot| robot.sense(&[Kind::Proximity]).unwrap().values;
    let before = sensed(&mut *robot);
    assert_eq!(before, bench.line().robot.body.proximity().map(f64::from));
    let start = robot.odometry().unwrap().counts;
    robot.drive(5, 5).unwrap();
    let mut seen = before.clone();
    for _ in 0..40 {
        bench.pass(100);
        seen = sensed(&mut *robot);
        if seen[2] > 700.0 {
            break;
        }
    }
    robot.stop().unwrap();
    assert!(
        before[2] < 100.0 && seen[2] > 700.0 && seen[3] > 300.0,
        "{before:?} {seen:?}"
    );
    let [x, y, heading] = bench.line().robot.body.pose;
    assert!(
        (x - 300.0).abs() < 5.0 && (27.5..60.0).contains(&y),
        "{x} {y} {heading}"
    );
    let end = robot.odometry().unwrap().counts;
    let counts = [0, 1].map(|wheel| end[wheel] - start[wheel]);
    // 5 pulses / 10 ms for at most 4 s.
    assert!(counts.iter().all(|count| (50..2100).contains(count)), "{counts:?}");

    bench.line().robot.body.place([240.0, 175.0, 0.5]);
    let beside = sensed(&mut *robot);
    bench.line().robot.body.place([240.0, 90.0, 0.5]);
    let afar = sensed(&mut *robot);
    assert!(beside[2] > 300.0 && afar[2] < 150.0, "{beside:?} {afar:?}");
    bench.pass(1000);
    let stood = bench.line().robot.body.pose;
    assert_eq!(stood, [240.0, 90.0, 0.5], "its wheels stand");
    let empty = oneiro::arena::Arena::rectangle(600.0, 600.0);
    bench.line().robot.body.bring(empty, [300.0, 300.0, 0.0]);
    let nothing = sensed(&mut *robot);
    assert!(nothing.iter().all(|reading| *reading < 50.0), "{nothing:?}");
}
