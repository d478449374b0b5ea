//! Several processes on one sweep, and signals to them.

use super::*;

fn signal(child: &Child, name: &str) {
    let kill = std::process::Command::new("kill");
    let sent = { kill }.args([name, &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
}

/// Starts a sweep and returns once it works.
fn working(place: &Place, arguments: &[&str], out: &str) -> Child {
    let child = place.start(arguments);
    wait_for(|| place.at(out).join("sessions.json").exists());
    // From then on it handles signals.
    thread::sleep(Duration::from_millis(100));
    child
}

#[test]
fn never_share_a_shard() {
    let place = Place::with_sweep("writer", &long(300));
    let arguments = sweep("out", &["--threads", "1"]);
    let first = working(&place, &arguments, "out/shard-1-of-1");
    signal(&first, "-STOP");
    thread::sleep(Duration::from_millis(50));
    let before = files(&place.at("out"));
    for second in [&arguments[..], &sweep("out", &["--shard", "1/1", "--jobs", "1"])] {
        let ran = place
            .run(second)
            .exits(75)
            .says(&["out/shard-1-of-1", "another process is working on this shard"]);
        assert!(ran.stdout.is_empty());
    }
    assert!(
        files(&place.at("out")) == before,
        "the second process has changed something"
    );
    signal(&first, "-CONT");
    let known = hash(&ended(&arguments, first).exits(0).stdout);
    assert_eq!(place.swept("alone", &[]), known);
    place.assert_same_tables("alone", "out");
}

#[test]
fn work_on_two_shards_at_once() {
    let place = Place::with_sweep("two", &long(300));
    let known = place.swept("whole", &["--threads", "1"]);
    let [one, two] = ["1/2", "2/2"].map(|shard| sweep("out", &["--shard", shard, "--threads", "1"]));
    let children = [&one, &two].map(|arguments| place.start(arguments));
    let state = || place.data(&["sweep", "status", "out"]);
    let is_running = |shard: &Value| shard["state"] == "running";
    wait_for(|| {
        place.at("out/sweep.json").exists()
            && state()["shards"]
                .as_array()
                .unwrap()
                .iter()
                .filter(|shard| is_running(shard))
                .count()
                == 2
    });
    for (arguments, child) in [&one, &two].into_iter().zip(children) {
        ended(arguments, child).exits(0);
    }
    let state = state();
    assert_eq!(state["done"], LONG_RUNS);
    assert_eq!(state["tables"], false);
    let merged = place.data(&["sweep", "merge", "out"]);
    assert_eq!(merged["hash"], known);
    place.assert_same_tables("whole", "out");
}

#[test]
fn that_are_signalled_leave_a_checkpoint_for_the_next() {
    let place = Place::with_sweep("term", &long(300));
    place.swept("known", &["--threads", "1"]);
    for (name, out) in [("-TERM", "term"), ("-INT", "int")] {
        // No checkpoint before the signal.
        let arguments = sweep(out, &["--threads", "1", "--checkpoint-every", "1h"]);
        // A busy machine may not get to the end of a generation before the signal.
        let mut longer = Duration::ZERO;
        loop {
            let child = working(&place, &arguments, &format!("{out}/shard-1-of-1"));
            thread::sleep(longer);
            signal(&child, name);
            let ran = ended(&arguments, child)
                .exits(75)
                .says(&["run the same command again to continue"]);
            assert!(ran.stdout.is_empty(), "{}", ran.stdout);
            let checkpoints = place.checkpoints(journal(out, ""));
            assert_eq!(checkpoints.len(), 1);
            if place.has_generations(out, &checkpoints[0]) {
                break;
            }
            fs::remove_dir_all(place.at(out)).unwrap();
            longer = 2 * longer + Duration::from_millis(100);
        }
        place.assert_goes_on(out, &["--threads", "1"]);
    }
}
