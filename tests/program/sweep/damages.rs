//! Damaged files.

use super::*;

/// A sweep that was killed with runs in progress, and its two newest checkpoints, which hold generations.
fn killed(place: &Place, out: &str) -> [PathBuf; 2] {
    let arguments = sweep(out, &["--threads", "1", "--checkpoint-every", "0.001s"]);
    for _ in 0..50 {
        let mut child = place.start(&arguments);
        wait_for(|| place.checkpoints(journal(out, "")).len() > 1);
        thread::sleep(Duration::from_millis(20));
        child.kill().unwrap();
        assert_eq!(
            child.wait().unwrap().code(),
            None,
            "the sweep was too short to be killed"
        );
        if let [newest, before, ..] = &place.checkpoints(journal(out, ""))[..] {
            let name = |path: &Path| journal(out, "").join(path.file_name().unwrap());
            let checkpoints = [name(newest), name(before)];
            let is_good = checkpoints
                .iter()
                .all(|checkpoint| place.has_generations(out, checkpoint));
            if is_good {
                return checkpoints;
            }
        }
    }
    panic!("never two checkpoints");
}

type Damage = fn(&Place, &Path);

fn flip(place: &Place, file: &Path, at: usize) {
    let mut bytes = place.read(file);
    bytes[at] ^= 1;
    place.write(file, bytes);
}

#[test]
fn of_checkpoints_are_reported_and_the_previous_one_is_used() {
    let place = Place::with_sweep("damaged", &long(100));
    place.swept("known", &["--threads", "1"]);
    let names = killed(&place, "killed");
    let cut = |place: &Place, file: &Path| {
        let whole = place.read(file);
        place.write(file, &whole[..whole.len() - 1]);
    };
    // An intact one of another sweep: its hash follows the format's name, with its length, and a version.
    let foreign = |place: &Place, file: &Path| {
        flip(place, file, 1 + "oneiro checkpoint".len() + 1);
        let bytes = place.read(file);
        let (content, _) = bytes.split_last_chunk::<32>().unwrap();
        place.write(file, [content, blake3::hash(content).as_bytes()].concat());
    };
    let damaged = "is cut off or damaged";
    let ways: [(&str, &str, Damage); 4] = [
        ("flipped", damaged, |place, file| {
            flip(place, file, place.read(file).len() / 2);
        }),
        ("cut", damaged, cut),
        ("empty", damaged, |place, file| place.write(file, "")),
        ("foreign", "belongs to another sweep", foreign),
    ];
    for (out, problem, damage) in ways {
        copy(&place.at("killed"), &place.at(out));
        let [newest, before] = names
            .clone()
            .map(|name| Path::new(out).join(name.strip_prefix("killed").unwrap()));
        let warning = |checkpoint: &Path| {
            let name = checkpoint.file_name().unwrap().to_str().unwrap();
            format!("warning: {out}/shard-1-of-1/{name}: {problem}; it is not used")
        };
        // Only a run resumed from the previous checkpoint has this line.
        let line = place.forge(&before, "known").unwrap();
        damage(&place, &newest);
        let again = sweep(out, &["--threads", "1"]);
        place.run(&again).exits(0).says(&[&warning(&newest)]);
        assert!(place.text(format!("{out}/generations.csv")).contains(&line), "{out}");
        fs::remove_dir_all(place.at(out)).unwrap();

        // Without an intact one the runs start over.
        copy(&place.at("killed"), &place.at(out));
        damage(&place, &newest);
        damage(&place, &before);
        place.run(&again).exits(0).says(&[&warning(&newest), &warning(&before)]);
        place.assert_same_tables("known", out);
    }
}

/// A finished sweep as it is before its tables are written.
fn finished(place: &Place, out: &str) {
    copy(&place.at("known"), &place.at(out));
    for table in TABLES {
        fs::remove_file(place.at(out).join(table)).unwrap();
    }
}

#[test]
fn of_records_cost_the_runs_that_they_are_of() {
    let place = Place::with_sweep("logs", SWEEP);
    let known = place.swept("known", &[]);
    let text = place.text(journal("known", "results.log"));
    let lines: Vec<&str> = text.split_inclusive('\n').collect();
    // Start of a line in its log, and end of its run's generations in theirs.
    let start_of = |line: usize| lines[..line].concat().len();
    let end_of = |line: usize| {
        let (_, json) = lines[line].split_once(' ').unwrap();
        let line: Value = serde_json::from_str(json).unwrap();
        (line["from"].as_u64().unwrap() + line["bytes"].as_u64().unwrap()) as usize
    };
    let result = |out: &str| journal(out, "results.log");
    let cut = |file: PathBuf, length: usize| place.write(&file, &place.read(&file)[..length]);

    finished(&place, "tag");
    flip(&place, &result("tag"), start_of(2));
    finished(&place, "json");
    flip(&place, &result("json"), start_of(5) + 40);
    finished(&place, "break");
    flip(&place, &result("break"), start_of(8) - 1);
    finished(&place, "torn");
    cut(result("torn"), start_of(11) + 70);
    finished(&place, "none");
    cut(result("none"), 0);
    finished(&place, "short");
    cut(journal("short", "generations.log"), end_of(11) - 1);
    finished(&place, "half");
    cut(journal("half", "generations.log"), end_of(5));
    finished(&place, "lost");
    fs::remove_file(place.at(journal("lost", "generations.log"))).unwrap();
    for (out, runs, words) in [
        ("tag", 1, "results.log:3: is damaged; its run is done again"),
        ("json", 1, "results.log:6: is damaged; its run is done again"),
        // Two lines joined into one.
        ("break", 2, "results.log:8: is damaged; its run is done again"),
        // Left by a power cut, and harmless.
        ("torn", 1, ""),
        ("none", 12, ""),
        ("short", 1, "results.log:12: generations.log is shorter than it was"),
        ("half", 6, "generations.log is shorter than it was"),
        ("lost", 12, "generations.log is shorter than it was"),
    ] {
        let says = format!("twelve: {runs} run{} on cpu", if runs == 1 { "" } else { "s" });
        let ran = place.run(&sweep(out, &[])).exits(0).says(&[&says, words]);
        assert_eq!(ran.stderr.contains("warning"), !words.is_empty(), "{}", ran.stderr);
        assert_eq!(hash(&ran.stdout), known, "{out}");
        // After the repair, there is no warning and no work.
        let ran = place
            .run(&sweep(out, &[]))
            .exits(0)
            .says(&["12 of 12 runs are already done"]);
        assert!(!ran.stderr.contains("warning"), "{}", ran.stderr);
    }
    // Changed generations are detected when they are joined.
    finished(&place, "changed");
    flip(&place, &journal("changed", "generations.log"), end_of(5) - 100);
    place
        .run(&["sweep", "merge", "changed"])
        .exits(5)
        .says(&["changed/shard-1-of-1/generations.log: the generations of run"]);
    assert!(!place.at("changed/generations.csv").exists());
}
