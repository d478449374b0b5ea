//! Messages to users about a sweep.

use super::*;

#[test]
fn of_a_plan_are_what_comes_to_be() {
    let place = Place::with_sweep("plan", SWEEP);
    let plan = place.data(&["sweep", "plan", "sweep.toml", "--no-estimate"]);
    assert_eq!(
        (&plan["name"], &plan["cells"], &plan["seeds"]),
        (&"twelve".into(), &4.into(), &3.into())
    );
    assert_eq!(
        plan["keys"],
        Value::from(["noise.sensor", "evolution.population"].map(Value::from).to_vec())
    );
    assert!(!place.at("out").exists());
    place.swept("out", &[]);
    let planned = |key: &str| -> Vec<String> {
        let runs = plan["runs"].as_array().unwrap().iter();
        runs.map(|run| run[key].as_str().map_or_else(|| run[key].to_string(), str::to_owned))
            .collect()
    };
    for (planned, name) in [
        (planned("run"), "run"),
        (planned("id"), "id"),
        (planned("seed"), "seed"),
    ] {
        assert_eq!(place.column("out/results.csv", name), planned, "{name}");
    }
    let values = |run: &Value| {
        run["values"]
            .as_array()
            .unwrap()
            .iter()
            .map(|value| value.as_str().unwrap().to_owned())
            .collect()
    };
    let values: Vec<Vec<String>> = plan["runs"].as_array().unwrap().iter().map(values).collect();
    let columns = ["noise.sensor", "evolution.population"].map(|name| place.column("out/results.csv", name));
    for (run, values) in values.iter().enumerate() {
        assert_eq!(*values, columns.clone().map(|column| column[run].clone()));
    }
    // Robot-steps: individuals, generations and cycles of each run, plus episodes of three finalists and the luckiest, and of the champion's test.
    let steps = |run: usize| plan["runs"][run]["steps"].as_u64();
    let of = |population: u64| (population * 12 + 4 * 5 + 5) * 40;
    assert_eq!((steps(0), steps(11)), (Some(of(20)), Some(of(40))));
    assert_eq!(plan["steps"], (of(20) + of(40)) * 6);
    // A run appears the same everywhere: in `generations.csv` it has as many lines as generations.
    let of_run = place.column("out/generations.csv", "run");
    let all: Vec<String> = (0..12).flat_map(|run| vec![run.to_string(); 12]).collect();
    assert_eq!(of_run, all);

    // As text: the first runs, or all of them, and the speed of each device.
    let many = SWEEP.replace("1..3", "1..9");
    place.write("sweep.toml", many);
    let text = place.good(&["sweep", "plan", "sweep.toml", "--no-estimate"]);
    assert!(
        text.contains("36 runs, 4 cells from 9 seeds each") && text.contains("16 more"),
        "{text}"
    );
    let text = place.good(&["sweep", "plan", "sweep.toml", "--no-estimate", "--all"]);
    assert_eq!(text.matches("[0.0, 0.4]").count(), 18, "{text}");
    let plan = place.data(&["sweep", "plan", "sweep.toml"]);
    assert_eq!(plan["runs"].as_array().unwrap().len(), 36);
    let devices = plan["devices"].as_array().unwrap();
    assert!(devices[0]["name"].as_str().unwrap().starts_with("cpu"));
    assert!(devices.iter().all(|device| device["seconds"].as_f64().unwrap() > 0.0));
    // Software drivers are timed only when they are named, and cards that are not here are listed only on request.
    let is_software = |device: &Value| device["name"].as_str().unwrap().contains("llvmpipe");
    assert!(!devices.iter().any(is_software), "{devices:?}");
    assert_eq!(plan["cards_at_most"], Value::Array(Vec::new()));
    let scalar = [
        "sweep",
        "plan",
        "sweep.toml",
        "--backend",
        "cpu:scalarx1",
        "--threads",
        "1",
        "--cards",
    ];
    let plan = place.data(&scalar);
    let devices = plan["devices"].as_array().unwrap();
    assert_eq!(devices.len(), 1, "{devices:?}");
    assert!(
        devices[0]["name"].as_str().unwrap().contains("scalarx1, 1 thread)"),
        "{devices:?}"
    );
    assert_eq!(plan["cards_at_most"].as_array().unwrap().len(), 8);
    place
        .run(&["sweep", "plan", "sweep.toml", "--backend", "gpu:no such adapter"])
        .exits(4);
}

#[test]
fn of_its_state_are_there_while_it_runs_and_after() {
    let place = Place::with_sweep("state", &long(150));
    let arguments = sweep("out", &["--threads", "1", "--jobs", "1"]);
    let mut child = place.start(&arguments);
    let status = || place.data(&["sweep", "status", "out"]);
    wait_for(|| place.at("out/shard-1-of-1/sessions.json").exists());
    let mut seen = Vec::new();
    while child.try_wait().unwrap().is_none() {
        let state = status();
        let shard = &state["shards"][0];
        assert_eq!((&shard["shard"], &shard["runs"]), (&"1/1".into(), &LONG_RUNS.into()));
        assert_eq!(shard["done"], state["done"]);
        if shard["state"] == "running" {
            seen.push(state["done"].as_u64().unwrap());
        }
    }
    let output = ended(&arguments, child).exits(0).stdout;
    assert!(
        seen.is_sorted() && seen.iter().any(|done| (1..LONG_RUNS).contains(done)),
        "{seen:?}"
    );
    let state = status();
    assert_eq!(state["done"], LONG_RUNS);
    assert_eq!(state["runs"], LONG_RUNS);
    assert_eq!(state["tables"], true);
    assert_eq!(state["shards"][0]["state"], "done");
    let text = place.good(&["sweep", "status", "out"]);
    assert!(text.contains("8 of 8 runs are done") && text.contains("1/1"), "{text}");
    // A finished sweep gives the same answers again, but for what the work was done by.
    let mut output: Value = serde_json::from_str(&output).unwrap();
    assert_eq!(output["specialised"], 0.0);
    output["specialised"] = Value::Null;
    let again: Value = serde_json::from_str(&place.good(&arguments)).unwrap();
    assert_eq!(again, output);
    assert_eq!(place.data(&["sweep", "merge", "out"]), output);
    assert_eq!(output["runs"], LONG_RUNS);
}

#[test]
fn of_stopped_shards_say_what_is_left() {
    let place = Place::with_sweep("left", SWEEP);
    let shard = place.data(&[
        "sweep",
        "run",
        "sweep.toml",
        "--out",
        "out",
        "--backend",
        "cpu",
        "--shard",
        "2/3",
    ]);
    assert_eq!(
        shard,
        serde_json::json!({"shard": "2/3", "runs": 4, "specialised": 0.0})
    );
    let state = place.data(&["sweep", "status", "out"]);
    let shard = serde_json::json!({
        "shard": "2/3", "done": 4, "runs": 4, "under_way": 0, "generations": 0, "state": "done",
    });
    let all = serde_json::json!({"name": "twelve", "runs": 12, "done": 4, "tables": false, "shards": [shard]});
    assert_eq!(state, all);
    let said = place.run(&[
        "sweep",
        "run",
        "sweep.toml",
        "--out",
        "out",
        "--backend",
        "cpu",
        "--shard",
        "2/3",
    ]);
    assert!(
        said.stdout.contains(
            "`oneiro sweep merge out` joins all shards; name the directories of shards that are elsewhere after it"
        ),
        "{}",
        said.stdout
    );
    // A sweep that has lost a run counts as stopped.
    let log = place.text("out/shard-2-of-3/results.log");
    place.write("out/shard-2-of-3/results.log", &log[..log.len() - 9]);
    let state = place.data(&["sweep", "status", "out"]);
    assert_eq!(
        (&state["shards"][0]["done"], &state["shards"][0]["state"]),
        (&3.into(), &"stopped".into())
    );
}

/// The page names the best cell, and is written again with the same bytes.
#[test]
fn of_a_report_are_drawn_from_the_tables() {
    let place = Place::with_sweep("report", SWEEP);
    place.swept("out", &[]);
    let report = place.data(&["sweep", "report", "out"]);
    assert_eq!(report["runs"], 12);
    let page = place.text("out/report.html");
    for factor in ["noise.sensor", "evolution.population"] {
        assert!(page.contains(factor), "{factor}");
    }
    assert_eq!(place.rows("out/cells.csv").len(), 1 + 4);
    place.good(&["sweep", "report", "out", "--out", "again"]);
    for file in ["report.html", "cells.csv", "effects.csv"] {
        let of = |sweep: &str| place.read(Path::new(sweep).join(file));
        assert!(of("out") == of("again"), "{file}");
    }
    let refused = place.run(&["sweep", "report", "out", "--outcome", "weight"]).exits(3);
    assert!(
        refused
            .stderr
            .contains("--outcome weight: is no outcome in results.csv; allowed: best, "),
        "{}",
        refused.stderr
    );
    place
        .run(&["sweep", "report", "out", "--outcome", "end_task_food"])
        .exits(3)
        .says(&[
            "allowed: best, ",
            "`oneiro evaluate --genomes out --measures --summary`",
        ]);
}

/// Tables have the runs of shards elsewhere too, and runs that two shards have done are both shards'.
#[test]
fn of_merged_shards_count_all_runs() {
    let place = Place::with_sweep("merged", SWEEP);
    place.good(&sweep("here", &["--shard", "1/2"]));
    place.good(&sweep("there", &["--shard", "2/2"]));
    assert_eq!(place.data(&["sweep", "status", "here"])["done"], 6);
    place.good(&["sweep", "merge", "here", "there"]);
    let text = place.good(&["sweep", "status", "here"]);
    assert!(
        text.contains("12 of 12 runs are done, and their tables are there"),
        "{text}"
    );
    assert_eq!(place.data(&["sweep", "status", "there"])["done"], 6);
    // The third of these has none left that the first two have not done.
    place.good(&sweep("there", &["--shard", "1/2"]));
    place.good(&sweep("there", &["--shard", "1/1"]));
    let state = place.data(&["sweep", "status", "there"]);
    let states: Vec<&str> = state["shards"]
        .as_array()
        .unwrap()
        .iter()
        .map(|shard| shard["state"].as_str().unwrap())
        .collect();
    assert!(states.iter().all(|state| *state == "done"), "{state}");
}

/// A changed table is neither verified nor reported on.
#[test]
fn of_changed_tables_say_which() {
    let place = Place::with_sweep("changed", SWEEP);
    let hash = place.swept("out", &[]);
    assert_eq!(place.data(&["verify", "out"])[0]["result"], hash);
    assert_eq!(place.good(&["verify", "out"]), format!("{}  out\n", &hash[..12]));
    place.good(&["sweep", "report", "out"]);
    for table in ["results.csv", "generations.csv", "champions.csv"] {
        let path = Path::new("out").join(table);
        let text = place.text(&path);
        let at = text.rfind(|c: char| c.is_ascii_digit()).unwrap();
        let other = if &text[at..=at] == "1" { "2" } else { "1" };
        place.write(&path, format!("{}{other}{}", &text[..at], &text[at + 1..]));
        let words = format!("out: {table} is not what was written; `oneiro sweep merge`");
        place.run(&["verify", "out"]).exits(5).says(&[&words]);
        place.run(&["sweep", "report", "out"]).exits(5).says(&[&words]);
        place.run(&["sweep", "status", "out"]).exits(0).says(&[&words]);
        fs::remove_file(place.at(&path)).unwrap();
        place
            .run(&["verify", "out"])
            .exits(5)
            .says(&[&format!("{table} is missing")]);
        place.good(&["sweep", "merge", "out"]);
        place.good(&["verify", "out"]);
    }
    place.good(&sweep("part", &["--shard", "1/2"]));
    place
        .run(&["verify", "part"])
        .exits(1)
        .says(&["part: has no tables.json"]);
    for command in [&["verify", "--recompute"][..], &["list"], &["resume"]] {
        place.run(&[command, &["out"]].concat()).exits(3).says(&[
            "out: is a sweep, not a run;",
            "`oneiro verify out`",
            "`oneiro sweep extract out RUN`",
        ]);
    }
}

#[test]
fn of_slurm_have_no_more_tasks_than_runs() {
    let place = Place::with_sweep("tasks", SWEEP);
    let script = |shards: &str| {
        place
            .run(&sweep("out", &["--print-slurm", "--shards", shards]))
            .exits(0)
    };
    let many = script("50").says(&["--shards 50: the sweep has 12 runs"]);
    assert!(many.stdout.contains("#SBATCH --array=1-12\n"), "{}", many.stdout);
    let few = script("4");
    assert!(
        few.stdout.contains("#SBATCH --array=1-4\n") && few.stderr.is_empty(),
        "{}{}",
        few.stdout,
        few.stderr
    );
    place
        .run(&sweep("out", &["--shards", "4"]))
        .exits(2)
        .says(&["--shards: counts the tasks of --print-slurm", "`--shard 1/4`"]);
    assert!(!place.at("out").exists());
}

/// Cells whose runs have different numbers of episodes are warned of, and one budget ends that.
#[test]
fn of_a_plan_warn_of_unequal_budgets() {
    let place = Place::with_sweep("budgets", SWEEP);
    let warning = || {
        place
            .run(&["sweep", "plan", "sweep.toml", "--no-estimate"])
            .exits(0)
            .stderr
    };
    let unequal = "the cells have unequal budgets: 260 (";
    assert!(warning().contains(unequal), "{}", warning());
    place.write("sweep.toml", SWEEP.replace("[set]", "[set]\nevolution.episodes = 500"));
    assert!(!warning().contains("unequal"), "{}", warning());
}
