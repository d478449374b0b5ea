use std::time::Duration;

use super::super::script::{Random, Scripted, Step, hear, say, say_after};
use super::*;

fn lines(chunks: &[&[u8]]) -> Vec<String> {
    let mut received = Received::default();
    let mut lines = Vec::new();
    for chunk in chunks {
        received.push(chunk);
        lines.extend(std::iter::from_fn(|| received.line()));
    }
    lines
}

/// Answers end with CR LF, and clients' echoes with CR or LF; a stream may be cut between any two bytes.
#[test]
fn lines_are_the_same_wherever_a_stream_is_cut() {
    let stream = b"\r\nn,1,2\r\ne,-3,4\rz,Protocol error\n\n\x0c\x07WELCOME\r\nrest";
    let whole = lines(&[stream]);
    assert_eq!(whole, ["n,1,2", "e,-3,4", "z,Protocol error", "\\x0c\\x07WELCOME"]);
    for first in 0..=stream.len() {
        for second in first..=stream.len() {
            let cut = [&stream[..first], &stream[first..second], &stream[second..]];
            assert_eq!(lines(&cut), whole, "cut at {first} and {second}");
        }
    }
    let bytes: Vec<&[u8]> = stream.chunks(1).collect();
    assert_eq!(lines(&bytes), whole);
}

#[test]
fn a_line_that_is_too_long_is_cut_and_memory_is_bounded() {
    let long = vec![b'x'; 3 * Received::LONGEST];
    let expected = [format!("{}..", "x".repeat(Received::LONGEST)), "ok".to_owned()];
    assert_eq!(lines(&[&long, b"\r\nok\r\n"]), expected);
    assert_eq!(lines(&[&long, &long, b"\n", b"ok\n"]), expected);
    let mut received = Received::default();
    for _ in 0..10_000 {
        received.push(&[b'x'; 512]);
        while received.line().is_some() {}
        assert!(received.bytes.len() <= Received::LONGEST + 512);
    }
}

#[test]
fn random_bytes_never_panic_and_lines_hold_printable_characters() {
    let mut random = Random(1);
    let mut received = Received::default();
    for _ in 0..20_000 {
        received.push(&random.bytes(40));
        while let Some(line) = received.line() {
            assert!(!line.is_empty() && line.len() <= 4 * Received::LONGEST + 2);
            assert!(line.bytes().all(|byte| (b' '..=b'~').contains(&byte)), "{line}");
        }
    }
}

#[test]
fn a_banner_is_found_wherever_it_is_cut() {
    let stream = b"ROM of miniROM of minirobot KHEPERA, Rev. 5.01";
    for first in 0..=stream.len() {
        let mut watch = Watch::new("ROM of minirobot KHEPERA");
        watch.push(&stream[..first]);
        let early = watch.take();
        watch.push(&stream[first..]);
        assert!(early ^ watch.take(), "cut at {first}");
        assert!(!watch.take());
    }
    let mut watch = Watch::new("ROM of minirobot KHEPERA");
    for byte in b"ROM of minirobot KHEPERAN" {
        watch.push(&[*byte]);
    }
    assert!(watch.take());
    assert!(watch.tail.len() < "ROM of minirobot KHEPERA".len());
}

#[test]
fn answers_are_taken_strictly() {
    assert_eq!(numbers("N\r", "n,1,2, 3", &[3], ANY), Ok(vec![1, 2, 3]));
    assert_eq!(numbers("D,5,5\r", "d", &[0], ANY), Ok(vec![]));
    assert_eq!(numbers("E", "e,-5,7", &[2], (-10, 10)), Ok(vec![-5, 7]));
    for line in [
        "n,1,2",
        "n,1,2,3,4",
        "n,1,2,",
        "n,1,2,x",
        "n,1,2,3x",
        "N,1,2,3",
        "xn,1,2,3",
        "n1,2,3",
        "n,1,2,11",
        "",
        "n",
    ] {
        assert!(
            matches!(numbers("N", line, &[3], (0, 10)), Err(Error::Garbage { .. })),
            "{line}"
        );
    }
    for line in [
        "z,Protocol error",
        "z,This LED does not exist.",
        "Command not found",
        "z",
    ] {
        assert!(
            matches!(numbers("N", line, &[3], ANY), Err(Error::Refused { .. })),
            "{line}"
        );
    }
    assert_eq!(
        numbers("N", "n,99999999999999999999", &[1], ANY).unwrap_err(),
        garbage("N", "n,99999999999999999999")
    );
}

fn talk(steps: impl IntoIterator<Item = Step>) -> Talk {
    Talk::new(Box::new(Scripted::new(steps)), "WELCOME", Duration::from_millis(100))
}

#[test]
fn what_came_before_a_command_is_no_answer_to_it() {
    let mut talk = talk([say_after(0, "n,1\r\n"), hear("N\r"), say("n,2\r\n")]);
    talk.send(b"N\r").unwrap();
    assert_eq!(talk.line("N").unwrap(), "n,2");
}

#[test]
fn an_answer_that_does_not_come_ends_in_time() {
    let mut talk = talk([hear("N\r"), say_after(101, "n,1\r\n")]);
    talk.send(b"N\r").unwrap();
    let start = talk.now();
    assert!(matches!(talk.line("N\r"), Err(Error::TimedOut { command, .. }) if command == "N"));
    assert_eq!(talk.now(), start + Duration::from_millis(100));
    talk.silence(Duration::from_millis(50)).unwrap();
}

/// Over a network or Bluetooth answers may come later, whether the link is recorded or not.
#[test]
fn a_slow_link_is_waited_for() {
    let link = || Box::new(Scripted::new([hear("N\r"), say_after(1099, "n,1\r\n")]).delayed(1000));
    let path = std::env::temp_dir().join(format!("oneiro-slow-{}", std::process::id()));
    let recording = super::super::recording::Recording::create(&path).unwrap();
    for link in [link() as Box<dyn Link>, recording.of(link())] {
        let mut talk = Talk::new(link, "WELCOME", Duration::from_millis(100));
        talk.send(b"N\r").unwrap();
        assert_eq!(talk.line("N\r").unwrap(), "n,1");
    }
    drop(recording);
    std::fs::remove_file(&path).unwrap();
}

#[test]
fn silence_ends_what_babbles_on() {
    let babble = (0..90).map(|_| say("x"));
    let mut talk = talk(babble);
    assert!(matches!(
        talk.silence(Duration::from_millis(50)),
        Err(Error::Garbage { .. })
    ));
    // The rest of the script.
    talk.silence(Duration::from_millis(50)).unwrap();
}

#[test]
fn a_number_of_bytes_is_taken_and_no_more() {
    let mut talk = talk([hear("a"), say("123"), say("4"), hear("b"), say("12345")]);
    talk.send(b"a").unwrap();
    assert_eq!(talk.bytes("a", 4).unwrap(), b"1234");
    talk.send(b"b").unwrap();
    assert_eq!(talk.bytes("b", 4), Err(garbage("b", "more than 4 bytes")));
}

/// Counts what is done to it.
struct Counted {
    in_step: bool,
    restored: Result,
    attempts: usize,
    restorations: usize,
}

impl Stepped for Counted {
    fn in_step(&mut self) -> &mut bool {
        &mut self.in_step
    }

    fn resynchronise(&mut self) -> Result {
        self.restorations += 1;
        self.restored.clone()
    }
}

/// The order of events of `persistently`: an attempt, order restored, another attempt, as often as allowed.
#[test]
fn attempts_are_counted_and_order_is_restored_after_each() {
    let run = |in_step, tries, outcomes: &[Result<u8>], restored: Result| {
        let mut robot = Counted {
            in_step,
            restored,
            attempts: 0,
            restorations: 0,
        };
        let outcome = persistently(&mut robot, tries, |robot| {
            robot.attempts += 1;
            outcomes[robot.attempts - 1].clone()
        });
        (outcome, robot.attempts, robot.restorations, robot.in_step)
    };
    let late = || Error::TimedOut {
        command: "N".into(),
        limit: Duration::ZERO,
    };
    let bad = || garbage("B", "x");
    let restart = || Error::Restarted;
    assert_eq!(run(true, 3, &[Ok(7)], Ok(())), (Ok(7), 1, 0, true));
    let late_twice = [Err(late()), Err(late()), Ok(7)];
    assert_eq!(run(true, 3, &late_twice, Ok(())), (Ok(7), 3, 2, true));
    assert_eq!(run(true, 2, &late_twice, Ok(())), (Err(late()), 2, 2, true));
    assert_eq!(run(true, 1, &late_twice, Ok(())), (Err(late()), 1, 1, true));
    assert_eq!(run(true, 3, &[Err(restart())], Ok(())), (Err(restart()), 1, 0, false));
    assert_eq!(run(true, 3, &late_twice, Err(bad())), (Err(late()), 1, 1, false));
    assert_eq!(run(true, 3, &late_twice, Err(restart())), (Err(restart()), 1, 1, false));
    // Out of step, nothing is tried before order is restored.
    assert_eq!(run(false, 3, &[Ok(7)], Ok(())), (Ok(7), 1, 1, true));
    assert_eq!(run(false, 3, &[Ok(7)], Err(bad())), (Err(bad()), 0, 1, false));
}
