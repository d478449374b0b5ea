//! The same tables, to the last byte.

use super::*;

/// So many runs that they are bred, packed and recorded in several parts, on one processor and on several.
#[test]
fn are_the_same_on_any_number_of_processors() {
    let place = Place::with_sweep("processors", &SWEEP.replacen("1..3", "1..20", 1));
    let on = |processors: &str, out: &str| {
        let mut command = place.command(&sweep(out, &[]));
        let ran = command.env("RAYON_NUM_THREADS", processors).output().unwrap();
        assert!(ran.status.success(), "{ran:?}");
        let report: Value = serde_json::from_slice(&ran.stdout).unwrap();
        assert_eq!(report["runs"], 80);
        report["hash"].clone()
    };
    let one = on("1", "one");
    assert_eq!(on("2", "two"), one);
    assert_eq!(on("7", "seven"), one);
}

#[test]
fn are_the_same_however_a_sweep_is_done() {
    let place = Place::with_sweep("same", SWEEP);
    let known = place.swept("known", &["--threads", "1", "--jobs", "1"]);
    let mut ways: Vec<&[&str]> = vec![
        &["--threads", "1"],
        &["--threads", "2", "--jobs", "3"],
        &["--threads", "8"],
        &["--threads", "8", "--jobs", "1", "--checkpoint-every", "0.001s"],
        &["--backend", "cpu:scalarx1", "--jobs", "3"],
        &["--backend", "pool"],
        &["--backend", "auto"],
    ];
    if cfg!(feature = "gpu") {
        ways.push(&["--backend", "gpu:llvmpipe", "--recheck", "0"]);
    }
    for (way, name) in ways.into_iter().zip('a'..) {
        let out = name.to_string();
        assert_eq!(place.swept(&out, way), known, "{way:?}");
        place.assert_same_tables("known", &out);
    }
    // The hash covers both tables, one after the other.
    let tables = TABLES.map(|table| place.read(Path::new("known").join(table)));
    assert_eq!(blake3::hash(&tables.concat()).to_hex().as_str(), known);
    // All runs are there, and the comparison can fail: other seeds and other values give other bytes.
    assert_eq!(place.rows("known/results.csv").len(), 1 + 12);
    assert_eq!(place.rows("known/generations.csv").len(), 1 + 12 * 12);
    for (from, to, out) in [
        ("1..3", "2..4", "seeds"),
        ("[0.0, 0.4]", "[0.0, 0.5]", "values"),
        ("signed", "unsigned", "set"),
    ] {
        place.write("sweep.toml", SWEEP.replacen(from, to, 1));
        assert_ne!(place.swept(out, &[]), known);
        for table in TABLES {
            assert!(place.read(format!("known/{table}")) != place.read(format!("{out}/{table}")));
        }
    }
    // And with the experiment's own values.
    place.write("sweep.toml", SWEEP);
    place.write("small.toml", EXPERIMENT.replace("parents = 4", "parents = 5"));
    assert_ne!(place.swept("experiment", &[]), known);
}

#[test]
fn are_the_same_from_any_number_of_shards_in_any_order() {
    let place = Place::with_sweep("shards", SWEEP);
    let known = place.swept("whole", &[]);
    let merged = |arguments: &[&str]| hash(&place.good(&[&["sweep", "merge", "--json"], arguments].concat()));
    for (shards, threads, jobs) in [(1, "2", "3"), (3, "1", "1"), (7, "8", "100")] {
        let out = format!("of-{shards}");
        // In reverse order.
        for shard in (1..=shards).rev() {
            let shard = format!("{shard}/{shards}");
            let more = ["--shard", &shard, "--threads", threads, "--jobs", jobs];
            place.good(&sweep(&out, &more));
        }
        assert_eq!(merged(&[&out]), known, "{shards} shards");
        place.assert_same_tables("whole", &out);
    }
    // As if on several machines: in separate directories, with different numbers of shards, some runs done twice.
    for (out, shard) in [("one", "1/2"), ("two", "2/3"), ("three", "3/3"), ("four", "1/3")] {
        place.good(&sweep(out, &["--shard", shard]));
    }
    let before = ["one", "two", "three", "four"].map(|out| files(&place.at(out)));
    assert_eq!(merged(&["one", "four", "two", "three", "--out", "all"]), known);
    place.assert_same_tables("whole", "all");
    assert_eq!(before, ["one", "two", "three", "four"].map(|out| files(&place.at(out))));
    // Without --out, the first directory gets the tables.
    assert_eq!(merged(&["four", "three", "two", "one"]), known);
    place.assert_same_tables("whole", "four");
    // The rest of a sweep that shards have begun can be done without them.
    place.good(&sweep("mixed", &["--shard", "2/7"]));
    place
        .run(&sweep("mixed", &[]))
        .exits(0)
        .says(&["2 of 12 runs are already done"]);
    place.assert_same_tables("whole", "mixed");
}

#[test]
fn are_the_same_when_time_runs_out_again_and_again() {
    let place = Place::with_sweep("budget", &long(150));
    let begun = Instant::now();
    let known = place.swept("whole", &["--threads", "1"]);
    let took = begun.elapsed().as_secs_f64();
    // If other processes slowed down that one, a fourth of its time may be enough for all runs.
    let stops = |share: f64| {
        let out = format!("stopped-{share}");
        let budget = format!("{:.3}s", took / share);
        let arguments = sweep(&out, &["--threads", "1", "--time-budget", &budget]);
        let mut stops = 0;
        let hash = loop {
            let ran = place.run(&arguments);
            if ran.code == Some(0) {
                break hash(&ran.stdout);
            }
            ran.exits(75).says(&["run the same command again to continue"]);
            assert!(!place.at(format!("{out}/results.csv")).exists());
            assert!(!place.checkpoints(journal(&out, "")).is_empty());
            stops += 1;
            assert!(stops < 50, "it does not come to an end");
        };
        assert_eq!(hash, known);
        place.assert_same_tables("whole", &out);
        stops
    };
    assert!([4.0, 8.0, 16.0, 32.0].into_iter().any(|share| stops(share) >= 2));
}

/// Sixty processes, 2,000 in `tests/long.sh`, are killed at any moment; each is followed by the same
/// command.
#[test]
fn are_the_same_after_kills() {
    const GENERATIONS: u32 = 300;
    let kills = if is_long() { 2000 } else { 60 };
    let place = Place::with_sweep("kill", &long(GENERATIONS));
    // One run at a time, and processes that live for less than a fourth of one: only from checkpoint to checkpoint can
    // a run reach its end.
    let pace = ["--threads", "1", "--jobs", "1"];
    let begun = Instant::now();
    let known = place.swept("known", &pace);
    let run = begun.elapsed().div_f64(LONG_RUNS as f64);
    let longest = run.div_f64(4.0).min(Duration::from_millis(80));
    let arguments = sweep("killed", &[&pace[..], &["--checkpoint-every", "0.005s"]].concat());
    let killed = place.killed(&arguments, kills, longest, "known");
    eprintln!("{killed:?} of {run:?}, processes of {longest:?} at most");
    assert!(killed.misses <= kills / 10, "{killed:?}");
    let of_one = u64::from(GENERATIONS / 4);
    let lived = killed.runs * u64::from(GENERATIONS) + generations_under_way(&place);
    assert!(
        lived > of_one,
        "{lived} generations have lived, which one process could do"
    );
    assert_eq!(place.swept("killed", &pace), known);
    place.assert_same_tables("known", "killed");
}

/// Finished generations of the runs in progress, by the newest checkpoint of the killed process.
fn generations_under_way(place: &Place) -> u64 {
    let Some(newest) = place
        .checkpoints(journal("killed", ""))
        .first()
        .map(|path| fs::read(path).unwrap())
    else {
        return 0;
    };
    let rows = place.rows("known/generations.csv");
    let is_there = |row: &Vec<String>| {
        let line = row[1..].join(",");
        newest.windows(line.len()).any(|here| here == line.as_bytes())
    };
    // Every tenth is sampled.
    10 * rows[1..]
        .iter()
        .filter(|row| row[1].ends_with('9') && is_there(row))
        .count() as u64
}
