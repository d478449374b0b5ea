//! Single runs of a sweep.

use super::*;

/// Values of each kind, in a grid, in rows and drawn, and lives in reality.
const ALL_KINDS: &str = r#"
    experiment = "small.toml"
    seeds = [7, 3]
    [set]
    task = { speed = "signed" }
    [grid]
    "noise.sensor" = [[0.0, 0.0], [0.0, 0.4]]
    [[list]]
    evolution.parents = 2
    evolution.elite = 1
    [[list]]
    evolution = { elite = 0, parents = 5 }
    [random]
    samples = 2
    seed = 5
    [random.ranges]
    evolution.mutation.rate = { from = 0.1, to = 0.5 }
    evolution.mutation.amount = { from = 0.01, to = 10.0, scale = "log" }
    cycles = { from = 20, to = 60 }
    [reality]
    robots = [1, 2]
    severity = 1.5
"#;

/// A run's lines in a sweep's table of generations, in the format of the run's own table.
fn generations(place: &Place, out: &str, run: u64) -> String {
    let text = place.text(Path::new(out).join("generations.csv"));
    let (head, rows) = text.split_once('\n').unwrap();
    let own = format!("{run},");
    let rows = rows.lines().filter_map(|row| row.strip_prefix(&own));
    let head = head.strip_prefix("run,").unwrap();
    std::iter::once(head).chain(rows).flat_map(|row| [row, "\n"]).collect()
}

/// Hash of a finished run's results.
fn result(place: &Place, run: &str) -> String {
    let done: Value = serde_json::from_slice(&place.read(Path::new(run).join("DONE"))).unwrap();
    done["result"].as_str().unwrap().to_owned()
}

#[test]
fn are_what_oneiro_run_makes_of_the_same_values() {
    let place = Place::with_sweep("values", ALL_KINDS);
    place.swept("out", &[]);
    let plan = place.data(&["sweep", "plan", "sweep.toml", "--no-estimate"]);
    let keys: Vec<&str> = plan["keys"]
        .as_array()
        .unwrap()
        .iter()
        .map(|key| key.as_str().unwrap())
        .collect();
    let runs = plan["runs"].as_array().unwrap();
    assert_eq!(runs.len(), 2 * 2 * 2 * 2);
    let results = place.column("out/results.csv", "result");
    // One for each seed, row and draw.
    for run in [0, 5, 11, 14] {
        let planned = &runs[run as usize];
        let mut set = vec!["task.speed=signed".to_owned()];
        for (key, value) in keys.iter().zip(planned["values"].as_array().unwrap()) {
            set.push(format!("{key}={}", value.as_str().unwrap()));
        }
        let (seed, out) = (planned["seed"].to_string(), format!("run-{run}"));
        let mut arguments = vec!["run", "small.toml", "--backend", "cpu", "--seed", &seed, "--out", &out];
        arguments.extend(set.iter().flat_map(|set| ["--set", set]));
        place.good(&arguments);
        assert_eq!(result(&place, &out), results[run as usize], "run {run}: {set:?}");
        let own = place.text(format!("{out}/generations.csv"));
        assert_eq!(own, generations(&place, "out", run), "run {run}");
    }
    // A control: another seed.
    place.good(&["run", "small.toml", "--backend", "cpu", "--seed", "4", "--out", "other"]);
    assert!(!results.contains(&result(&place, "other")));
    // Drawn values are within their range.
    let within = |name, [least, greatest]: [f64; 2]| {
        let values = place.column("out/results.csv", name);
        let values: Vec<f64> = values.iter().map(|value| value.parse().unwrap()).collect();
        assert!(
            values.iter().all(|value| (least..=greatest).contains(value)),
            "{name}: {values:?}"
        );
        assert!(
            values.iter().any(|value| *value != values[0]),
            "{name} is never another"
        );
    };
    within("evolution.mutation.rate", [0.1, 0.5]);
    within("evolution.mutation.amount", [0.01, 10.0]);
    within("cycles", [20.0, 60.0]);
    within("real", [f64::MIN, f64::MAX]);
}

#[test]
fn are_done_again_with_a_directory_that_can_be_verified() {
    let place = Place::with_sweep("extract", "");
    // The sweep has the name of its file.
    place.write("kinds.toml", ALL_KINDS);
    let run = ["sweep", "run", "kinds.toml", "--out", "out", "--backend", "cpu"];
    place.good(&run);
    let column = |name| place.column("out/results.csv", name);
    let (ids, results) = (column("id"), column("result"));
    let extract = |run: &str, more: &[&str]| {
        let extract = ["sweep", "extract", "out", run, "--backend", "cpu"];
        place.data(&[&extract, more].concat())
    };
    for (run, more) in [(0, &[][..]), (9, &["--out", "nine"])] {
        let extracted = extract(&run.to_string(), more);
        assert_eq!(extracted["result"], results[run]);
        assert_eq!(extracted["id"], ids[run]);
        let directory = extracted["directory"].as_str().unwrap();
        assert_eq!(result(&place, directory), results[run]);
        let own = place.text(Path::new(directory).join("generations.csv"));
        assert_eq!(own, generations(&place, "out", run as u64));
        let verified = place.good(&["verify", directory]);
        assert!(verified.contains(&results[run][..12]), "{verified}");
        place.good(&["verify", "--recompute", directory, "--backend", "cpu"]);
    }
    assert!(place.at("out/runs/run-0").is_dir());
    // By its id, and once more: it is done, and nothing is written.
    for _ in 0..2 {
        assert_eq!(extract(&ids[3][..8], &["--out", "three"])["result"], results[3]);
    }
    place
        .run(&["sweep", "extract", "out", "0", "--out", "three"])
        .exits(3)
        .says(&["three: holds the run of another experiment or seed"]);
    // By an unknown id.
    for (run, words) in [("16", "has no run 16"), ("-1", ""), ("xyzzyx", "has no run xyzzyx")] {
        let ran = place.run(&["sweep", "extract", "out", run, "--backend", "cpu"]);
        let code = if run == "-1" { 2 } else { 3 };
        ran.exits(code).says(&[words]);
    }
    // A sweep continues beside them, and keeps its name when its shards are joined.
    place.good(&run);
    place.good(&["sweep", "merge", "out", "--out", "joined"]);
    assert_eq!(place.data(&["sweep", "status", "joined"])["name"], "kinds");
}

/// Files are looked for from the folder of the file that names them, and copied, also those above it: the directory doesn't
/// depend on where it was made.
#[test]
fn do_not_depend_on_where_their_sweep_was_made() {
    let place = Place::new("above");
    place.good(&["robot", "sample", "--robot", "surrogate:1", "--out", "tables"]);
    fs::create_dir(place.at("deep")).unwrap();
    place.write(
        "deep/small.toml",
        format!("robot.motors = \"../tables/motor.sam\"\n{EXPERIMENT}"),
    );
    let sweep = r#"
        experiment = "deep/small.toml"
        seeds = "1..2"
        [set]
        robot = { tables = ["tables/wall.sam", "tables/round.sam"] }
        [grid]
        robot.states = ["symmetric", "asymmetric"]
    "#;
    place.write("sweep.toml", sweep);
    let whole = place.swept("whole", &[]);
    // The same from a folder beside, and with files as values that are swept.
    let beside = sweep
        .replace("deep/small", "../deep/small")
        .replace("robot = {", "trials = 1 #")
        .replace(
            "[grid]",
            "[grid]\nrobot.tables = [[\"../tables/wall.sam\", \"../tables/round.sam\"]]",
        );
    place.write("deep/sweep.toml", &beside);
    let from = ["sweep", "run", "deep/sweep.toml", "--out", "beside", "--backend", "cpu"];
    place.good(&from);
    assert_eq!(
        place.column("beside/results.csv", "result"),
        place.column("whole/results.csv", "result")
    );
    place.good(&super::sweep("parts", &["--shard", "1/2"]));
    place.good(&super::sweep("parts", &["--shard", "2/2"]));
    fs::rename(place.at("tables"), place.at("elsewhere")).unwrap();
    place.good(&["sweep", "extract", "beside", "1", "--out", "other", "--backend", "cpu"]);
    assert_eq!(hash(&place.good(&["sweep", "merge", "parts", "--json"])), whole);
    place.good(&["sweep", "extract", "parts", "1", "--out", "run", "--backend", "cpu"]);
    assert_eq!(result(&place, "run"), place.column("parts/results.csv", "result")[1]);
    assert_eq!(result(&place, "other"), result(&place, "run"));
}
