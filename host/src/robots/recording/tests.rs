use std::fs;

use super::super::Kind;
use super::super::Robot;
use super::super::khepera::Khepera;
use super::super::script::{Scripted, Step, hear, say, say_after};
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
    let opening = [&resynchronised[..], &[hear("D,0,0\r"), say("d\r\n")]].concat();
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
        format!("{:?}", robot.odometry().is_err()),
        format!("{:?}", robot.reconnect()),
    ];
    outcomes.join("\n")
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
    assert_eq!(used(Box::new(Replay::parse(&text).unwrap())), outcomes);
    // Nothing is left over, and nothing is overwritten.
    let mut replay = Replay::parse(&text).unwrap();
    while replay.next("anything").is_ok() || !replay.is_over() {}
    assert!(Recording::create(&path).is_err());
    fs::remove_file(&path).unwrap();
}

/// A driver that does something else than it did is found out.
#[test]
fn another_driver_s_recording_does_not_play() {
    let text = "oneiro link recording 1\n0.5 < \n0.6 > 5a\n";
    let words = used(Box::new(Replay::parse(text).unwrap()));
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
    ] {
        let text = format!("oneiro link recording 1\n0.1 > 00\n{bad}\n");
        let refusal = Replay::parse(&text).unwrap_err();
        assert!(refusal.starts_with("line 3:"), "{refusal}");
    }
}

/// `/dev/full` takes nothing. The robot is driven all the same.
#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_does_not_hold_the_robot() {
    let file = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let recording = Recording::to(file, Path::new("/dev/full"));
    let outcomes = used(recording.of(Box::new(Scripted::new(eventful()))));
    assert!(outcomes.contains("Ok([1.0"));
    let problem = recording.finish().unwrap();
    assert!(
        problem.starts_with("/dev/full: ") && problem.ends_with("the recording ends here"),
        "{problem}"
    );
}
