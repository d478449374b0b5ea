//! Failing disks: at every call once, or out of space.

use super::*;
use crate::disk::Disk;
use crate::faults::{Fault, Faults};
use crate::skips::skipped;
use std::collections::BTreeSet;
use std::process::Command;

/// Two runs of some generations, with a checkpoint after each.
const TINY: &str = r#"
    experiment = "small.toml"
    seeds = "1..2"
    [set]
    cycles = 10
    evolution.population = 4
    evolution.parents = 2
    evolution.generations = 2
"#;
const OFTEN: [&str; 6] = ["--threads", "1", "--jobs", "1", "--checkpoint-every", "0.000001s"];

fn output(arguments: &[&str], mut command: Command) -> Ran {
    Ran::new(arguments, &command.output().unwrap())
}

/// Starts a sweep again and again, from `before` or from nothing, each time with a different call that fails: in one way, or in
/// `tests/long.sh` in each. Returns the names of these calls.
fn each_call_fails(place: &Place, pace: &[&str], before: Option<&str>) -> BTreeSet<String> {
    let known = place.swept("known", pace);
    let place_path = fs::canonicalize(place.at(".")).unwrap();
    let out = place_path.join("out");
    let faults = Faults::below(place, &out);
    let arguments = sweep(out.to_str().unwrap(), pace);
    let mut calls = BTreeSet::new();
    for number in 1.. {
        // Where it is not a write, a short one is a full disk.
        let kinds = [Fault::Broken, Fault::Full, Fault::Kill, Fault::Short];
        let one = number as usize % kinds.len();
        for &fault in if is_long() { &kinds[..] } else { &kinds[one..=one] } {
            if out.exists() {
                fs::remove_dir_all(&out).unwrap();
            }
            if let Some(before) = before {
                copy(&place.at(before), &out);
            }
            let mut command = faults.at(place.command(&arguments), number, fault);
            let result = command.output().unwrap();
            let Some(failed) = faults.failed() else {
                assert_eq!(hash(&Ran::new(&arguments, &result).exits(0).stdout), known);
                return calls;
            };
            let what = format!("{fault:?} of call {number}, {failed:?}");
            if fault == Fault::Kill {
                assert_eq!(result.status.code(), None, "{what}");
                calls.insert(failed.call);
            } else {
                let path = failed.path.to_str().unwrap();
                Ran::new(&arguments, &result)
                    .exits(6)
                    .says(&[path.strip_suffix(".tmp").unwrap_or(path)]);
                calls.insert(failed.call);
            }
            // Begun work isn't damaged: the results are the same.
            let ran = output(&arguments, faults.none(place.command(&arguments))).exits(0);
            assert_eq!(hash(&ran.stdout), known, "after {what}");
            assert!(before.is_some() || !ran.stderr.contains("warning"), "{}", ran.stderr);
        }
    }
    unreachable!("numbers of calls end before those of u32")
}

#[test]
fn may_fail_at_any_call() {
    let place = Place::with_sweep("faults", TINY);
    let calls = each_call_fails(&place, &OFTEN, None);
    let all = ["fdatasync", "fsync", "mkdir", "open", "rename", "unlink", "write"];
    assert_eq!(calls.iter().map(String::as_str).collect::<Vec<_>>(), all);
}

/// Also while it repairs the effects of a power cut: a damaged line, and generations that never reached the disk.
#[test]
fn may_fail_at_any_call_while_logs_are_repaired() {
    let sweep = TINY.replace("1..2", "1..4");
    let place = Place::with_sweep("mended", &sweep);
    let pace = ["--threads", "1"];
    place.swept("torn", &pace);
    fs::remove_file(place.at("torn/results.csv")).unwrap();
    fs::remove_file(place.at("torn/generations.csv")).unwrap();
    let lines = place.text(journal("torn", "results.log"));
    let mut lines: Vec<String> = lines.split_inclusive('\n').map(str::to_owned).collect();
    lines[0] = lines[0].replace("\"run\"", "\"ran\"");
    lines[3].truncate(50);
    place.write(journal("torn", "results.log"), lines.concat());
    let generations = place.read(journal("torn", "generations.log"));
    place.write(
        journal("torn", "generations.log"),
        &generations[..generations.len() / 2 + 10],
    );
    let calls = each_call_fails(&place, &pace, Some("torn"));
    assert!(calls.contains("ftruncate"), "{calls:?}");
}

/// A sweep whose checkpoints soon fill a disk.
const PLENTY: [&str; 4] = ["--threads", "1", "--checkpoint-every", "0.000001s"];

/// Asserts that the sweep has stopped for lack of space, and says so.
fn says_that_the_disk_is_full(ran: Ran) {
    let ran = ran
        .exits(6)
        .says(&["/shard-1-of-1/", "No space left on device", "free some space"]);
    assert!(ran.stdout.is_empty(), "{}", ran.stdout);
}

#[test]
fn may_be_full() {
    let place = Place::with_sweep("full", &long(100));
    place.swept("known", &["--threads", "1"]);
    let out = fs::canonicalize(place.at(".")).unwrap().join("out");
    let faults = Faults::below(&place, &out);
    let arguments = sweep(out.to_str().unwrap(), &PLENTY);
    let command = faults.space(place.command(&arguments), 1 << 20);
    says_that_the_disk_is_full(output(&arguments, command));
    place.assert_goes_on("out", &["--threads", "1"]);
}

#[test]
fn may_be_full_in_truth() {
    let place = Place::with_sweep("small", &long(100));
    let Some(disk) = Disk::mounted(place.at("disk"), 1) else {
        // A disk that fails as if it were full is tested in any case.
        skipped("disk", "a disk that is full: only root may mount a small one");
        return;
    };
    place.swept("known", &["--threads", "1"]);
    let arguments = sweep("disk/out", &PLENTY);
    let mut child = place.start(&arguments);
    wait_for(|| place.checkpoints(journal("disk/out", "")).len() > 1);
    wait_for(|| {
        disk.fill();
        child.try_wait().unwrap().is_some()
    });
    says_that_the_disk_is_full(ended(&arguments, child));
    // Its contents stay, and there is space again.
    disk.free();
    place.assert_goes_on("disk/out", &["--threads", "1"]);
}
