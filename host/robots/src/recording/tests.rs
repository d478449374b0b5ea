use std::fs;

use super::super::Kind;
use super::super::Robot;
use super::super::error::Error;
use super::super::khepera::Khepera;
use super::super::script::{Scripted, Step, hear, say, say_after};
use super::replay::Replay;
use super::*;

fn file(name: &str) -> std::path::PathBuf {
    let path = std::env::temp_dir().join(format!("oneiro-recording-{name}-{}", std::process::id()));
    // Left by an earlier test of the same number.
    let _ = fs::remove_file(&path);
    path
}

/// A lost answer, noise, a refusal, a restart, and a link that is lost and opened again.
fn eventful() -> Vec<Step> {
    let resynchronised = [hear("\rD,0,0\r"), hear("B\r"), say("b,5.02,5.01\r\n")];
    let opening = [
        &resynchronised[..],
        &[hear("D,0,0\r"), say("d\r\n"), hear("E\r"), say("e,0,0\r\n")],
    ]
    .concat();
    let steps = [
        opening.clone(),
        vec![hear("N\r")],
        resynchronised.to_vec(),
        vec![hear("N\r"), say("n,1,\u{3}\r\n")],
        resynchronised.to_vec(),
        vec![hear("N\r"), say("n,1,2,3"), say_after(100, ",4,5,6,7,8\r\n")],
        vec![hear("D,5,5\r"), say("ROM of minirobot KHEPERA\r\n")],
        resynchronised.to_vec(),
        vec![hear("H\r"), Step::HangUp, Step::Reopen],
        opening,
    ];
    steps.concat()
}

/// What a program does with it.
fn used(link: Box<dyn Link>) -> String {
    let mut robot = Khepera::new(link);
    let outcomes = [
        format!("{:?}", robot.begin()),
        format!("{:?}", robot.sense(&[Kind::Proximity]).map(|reading| reading.values)),
        format!("{:?}", robot.drive(5, 5)),
        format!("{:?}", robot.odometry().map(|odometry| odometry.counts)),
        format!("{:?}", robot.reconnect()),
    ];
    outcomes.join("\n")
}

/// The only link of a recording.
fn replay(text: &str) -> Replay {
    let mut replays = Replay::parse(text).unwrap();
    assert_eq!(replays.len(), 1);
    replays.remove(0)
}

/// A link whose calls all fail.
struct Failing(Error);

impl Clock for Failing {
    fn now(&self) -> Duration {
        Duration::from_millis(1500)
    }
}

impl Link for Failing {
    fn name(&self) -> &'static str {
        "serial:/dev/x@9600"
    }

    fn read(&mut self, _: &mut [u8], _: Duration) -> Result<usize> {
        Err(self.0.clone())
    }

    fn waiting(&mut self, _: &mut [u8]) -> Result<usize> {
        Err(self.0.clone())
    }

    fn write(&mut self, _: &[u8], _: Duration) -> Result {
        Err(self.0.clone())
    }

    fn reopen(&mut self) -> Result {
        Err(self.0.clone())
    }
}

/// Every error that a link returns, over two links in one file.
#[test]
fn errors_play_back_as_they_were() {
    let link = || "serial:/dev/x@9600".to_owned();
    let cause = "no \"such\" device \u{fc} {1}".to_owned();
    let errors = [
        Error::Unsent {
            bytes: 21,
            limit: Duration::from_micros(199_999),
        },
        Error::Disconnected {
            link: link(),
            cause: cause.clone(),
        },
        Error::Unavailable {
            link: link(),
            cause,
            advice: "check the path".into(),
        },
    ];
    let path = file("errors");
    let recording = Recording::create(&path).unwrap();
    for error in &errors {
        let mut recorded = recording.of(Box::new(Failing(error.clone())));
        recorded.write(b"x", Duration::ZERO).unwrap_err();
        recorded.reopen().unwrap_err();
        recorded.waiting(&mut [0]).unwrap_err();
    }
    assert_eq!(recording.finish(), None);
    let text = fs::read_to_string(&path).unwrap();
    fs::remove_file(&path).unwrap();
    assert_eq!(text.matches("1.500000 = serial:/dev/x@9600\n").count(), 3, "{text}");
    let replays = Replay::parse(&text).unwrap();
    assert_eq!(replays.len(), errors.len());
    for (mut replay, error) in replays.into_iter().zip(errors) {
        assert_eq!(
            (replay.name(), replay.now()),
            ("serial:/dev/x@9600", Duration::from_millis(1500))
        );
        assert_eq!(replay.write(b"x", Duration::ZERO), Err(error.clone()));
        assert_eq!(replay.reopen(), Err(error.clone()));
        assert_eq!(replay.waiting(&mut [0]), Err(error));
    }
}

#[test]
fn a_recording_plays_back_to_the_same_outcomes() {
    let path = file("plays");
    let recording = Recording::create(&path).unwrap();
    let outcomes = used(recording.of(Box::new(Scripted::new(eventful()))));
    assert_eq!(recording.finish(), None);
    assert!(outcomes.contains("Ok([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0])") && outcomes.contains("Restarted"));
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.starts_with("oneiro link recording 1\n"));
    assert!(text.contains(" > 4e0d\n") && text.contains(" < 622c352e30322c352e30310d0a\n"));
    assert!(outcomes.contains("Disconnected { link: \"script\", cause: \"hung up\" }"));
    assert_eq!(used(Box::new(replay(&text))), outcomes);
    // Nothing is left over, and nothing is overwritten.
    let mut replay = replay(&text);
    while replay.next("anything").is_ok() || !replay.is_over() {}
    assert!(Recording::create(&path).is_err());
    fs::remove_file(&path).unwrap();
}

/// A driver that does something else than it did is found out.
#[test]
fn another_driver_s_recording_does_not_play() {
    let text = "oneiro link recording 1\n0.4 = script\n0.5 < \n0.6 > 5a\n";
    let words = used(Box::new(replay(text)));
    assert!(
        words.contains("the recording has Sent([90]) and not Sent([13, 68, 44, 48, 44, 48, 13])"),
        "{words}"
    );
}

#[test]
fn what_is_no_recording_is_refused_with_its_line() {
    assert!(Replay::parse("").unwrap_err().starts_with("line 1:"));
    assert!(
        Replay::parse("oneiro link recording 2\n")
            .unwrap_err()
            .starts_with("line 1:")
    );
    for bad in [
        "x",
        "1 <",
        "1.0 ? 00",
        "1 < 0",
        "1 < 0g",
        "-1 < 00",
        "nan < 00",
        "1 > \u{e9}",
        "1e99 < 00",
        "1 x lost",
        "1 x {\"lost\":{}}",
    ] {
        let text = format!("oneiro link recording 1\n0.1 = script\n{bad}\n");
        let refusal = Replay::parse(&text).unwrap_err();
        assert!(refusal.starts_with("line 3:"), "{refusal}");
    }
}

#[test]
fn an_event_before_the_first_link_is_refused() {
    let refusal = Replay::parse("oneiro link recording 1\n0.1 > 00\n").unwrap_err();
    assert!(refusal.starts_with("line 2:"), "{refusal}");
}

/// A robot that sends without end fills no disk.
#[test]
fn a_recording_has_an_end() {
    let path = std::env::temp_dir().join(format!("oneiro-recording-end-{}", std::process::id()));
    let recording = Recording::to(File::create(&path).unwrap(), &path, 300);
    let outcomes = used(recording.of(Box::new(Scripted::new(eventful()))));
    assert!(outcomes.contains("Ok([1.0"));
    let problem = recording.finish().unwrap();
    assert!(
        problem.ends_with("has 300 bytes, as many as are recorded; the recording ends here"),
        "{problem}"
    );
    let length = fs::metadata(&path).unwrap().len();
    assert!((200..=300).contains(&length), "{length}");
    fs::remove_file(&path).unwrap();
}

/// `/dev/full` takes nothing. The robot is still driven.
#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_does_not_hold_the_robot() {
    let file = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let recording = Recording::to(file, Path::new("/dev/full"), 1 << 20);
    let outcomes = used(recording.of(Box::new(Scripted::new(eventful()))));
    assert!(outcomes.contains("Ok([1.0"));
    let problem = recording.finish().unwrap();
    assert!(
        problem.starts_with("/dev/full: ") && problem.ends_with("the recording ends here"),
        "{problem}"
    );
}
