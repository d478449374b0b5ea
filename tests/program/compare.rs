//! `oneiro compare`: scores of different experiments in one report.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::place::Place;

/// One of two optimisers, with one task and one budget.
const SMALL: &str = "
cycles = 40
[evolution]
population = 20
parents = 4
generations = 6
finalists = 2
finalist_lives = 5
";

impl Place {
    /// Runs of an experiment from three seeds, in a folder of its name.
    fn runs(&self, name: &str, more: &[&str]) {
        if !self.at("small.toml").exists() {
            self.write("small.toml", SMALL);
        }
        let fixed = [
            "run",
            "small.toml",
            "--seeds",
            "1..3",
            "--out",
            name,
            "--backend",
            "cpu",
            "--quiet",
        ];
        let name = format!("name={name}");
        self.good(&[&fixed[..], &["--set", name.as_str()], more].concat());
    }

    /// The rows of a table, each by the names of its columns.
    pub(crate) fn table_of(&self, path: &str) -> Vec<BTreeMap<String, String>> {
        let text = self.text(path);
        let mut rows = csv::Reader::from_reader(text.as_bytes());
        rows.deserialize().map(|row| row.unwrap()).collect()
    }

    #[track_caller]
    fn compared(&self, arguments: &[&str]) -> Value {
        let output = self.good(&[&["compare", "--backend", "cpu", "--json"][..], arguments].concat());
        serde_json::from_str(&output).unwrap()
    }
}

const RANDOM: [&str; 2] = ["--set", "evolution.kind=random"];

/// Champions of different optimisers and of a sweep's cells are scored in the same new episodes, as `oneiro evaluate --best` scores them.
#[test]
fn champions_of_one_task_are_compared_in_new_episodes() {
    let place = Place::new("new");
    place.runs("genetic", &[]);
    place.runs("chance", &RANDOM);
    let sweep = "experiment = \"small.toml\"\nseeds = \"1..3\"\n[grid]\nevolution.mutation.rate = [0.05, 0.3]\n";
    place.write("sweep.toml", format!("name = \"rates\"\n{sweep}"));
    place.good(&["sweep", "run", "sweep.toml", "--out", "swept", "--backend", "cpu"]);
    let all = ["genetic", "chance", "swept", "--trials", "20", "--seed", "9"];
    let value = place.compared(&all);
    let names: Vec<&str> = value["conditions"]
        .as_array()
        .unwrap()
        .iter()
        .map(|own| own["name"].as_str().unwrap())
        .collect();
    assert_eq!(
        names,
        [
            "genetic",
            "chance",
            "rates: evolution.mutation.rate = 0.05",
            "rates: evolution.mutation.rate = 0.3"
        ]
    );
    assert_eq!(value["warnings"], Value::Array(Vec::new()));
    assert!(
        value["score"]
            .as_str()
            .unwrap()
            .contains("20 new episodes with the same random numbers for all (seed 9), ")
    );

    // The same scores as by the command for one experiment.
    let best = [
        "evaluate",
        "--best",
        "--genomes",
        "genetic",
        "chance",
        "swept",
        "--trials",
        "20",
        "--seed",
        "9",
        "--json",
    ];
    let known: Value = serde_json::from_str(&place.good(&[&best[..], &["--backend", "cpu"]].concat())).unwrap();
    let known: BTreeMap<&str, &Value> = known["genomes"]
        .as_array()
        .unwrap()
        .iter()
        .map(|own| (own["source"].as_str().unwrap(), own))
        .collect();
    let runs = place.table_of("compare/compare.csv");
    assert_eq!(runs.len(), 12);
    for run in runs.iter().filter(|run| run["source"].starts_with("genetic/")) {
        let known = known[format!("{}/champion.npy", run["source"]).as_str()];
        for (column, known) in [("score", &known["mean"]), ("score_low", &known["interval"][0])] {
            let (own, known) = (run[column].parse::<f64>().unwrap(), known.as_f64().unwrap());
            assert!(
                (own - known).abs() <= 1e-5 * known.abs(),
                "{}: {own}, {known}",
                run["source"]
            );
        }
    }
    // A sweep's champions are those of its table.
    let of_sweep: Vec<&BTreeMap<String, String>> = runs
        .iter()
        .filter(|run| run["source"].starts_with("swept, run "))
        .collect();
    assert_eq!(of_sweep.len(), 6);
    for (place_of, run) in of_sweep.iter().enumerate() {
        assert_eq!(run["source"], format!("swept, run {place_of}"));
        let known = known[format!("swept/champions.csv[{place_of}]").as_str()]["mean"]
            .as_f64()
            .unwrap();
        assert!((run["score"].parse::<f64>().unwrap() - known).abs() <= 1e-5 * known.abs());
    }

    // Medians are those of the table of runs, and all six pairs of four conditions are tested.
    let mut scores: Vec<f64> = runs[..3].iter().map(|run| run["score"].parse().unwrap()).collect();
    scores.sort_by(f64::total_cmp);
    let condition = &place.table_of("compare/conditions.csv")[0];
    assert_eq!(condition["median"].parse::<f64>().unwrap(), scores[1]);
    assert_eq!(
        (&*condition["runs"], &*condition["nan"], &*condition["episodes"]),
        ("3", "0", "120")
    );
    let tests = place.table_of("compare/effects.csv");
    assert_eq!(tests.len(), 6);
    assert_eq!(value["tests"].as_array().unwrap().len(), 6);
    // Two samples of three without overlap have the exact p of 0.1.
    assert!(
        tests.iter().all(|test| test["p"].parse::<f64>().unwrap() >= 0.1),
        "{tests:?}"
    );

    // Best scores never fall, and end where the budget does.
    let curves = place.table_of("compare/curves.csv");
    for pair in curves.windows(2).filter(|pair| pair[0]["run"] == pair[1]["run"]) {
        let number = |row: &BTreeMap<String, String>, name: &str| row[name].parse::<f64>().unwrap();
        assert!(number(&pair[0], "best") <= number(&pair[1], "best"));
        assert!(number(&pair[0], "episodes") < number(&pair[1], "episodes"));
    }
    assert_eq!(curves.last().unwrap()["episodes"], "120");
    let last = curves.iter().rfind(|row| row["run"] == "0").unwrap();
    let generations = place.table_of("genetic/seed-1/generations.csv");
    let best = generations
        .iter()
        .map(|row| row["best"].parse::<f64>().unwrap())
        .fold(f64::MIN, f64::max);
    assert!((last["best"].parse::<f64>().unwrap() - best).abs() <= 1e-5 * best.abs());

    // The page's figure is a file, and the same command writes the same bytes.
    let page = place.text("compare/compare.html");
    assert!(page.contains(&place.text("compare/figures/figure-1.svg")));
    let page = page.replace("<wbr/>", "");
    for words in names.iter().chain(&["episodes spent", "95 % of the median"]) {
        assert!(page.contains(words), "{words}");
    }
    place.compared(&[&all[..], &["--out", "again"]].concat());
    for file in [
        "compare.html",
        "compare.csv",
        "conditions.csv",
        "curves.csv",
        "effects.csv",
        "figures/figure-1.svg",
    ] {
        assert!(
            place.read(format!("compare/{file}")) == place.read(format!("again/{file}")),
            "{file}"
        );
    }
}

/// What makes a comparison doubtful is said; what makes it senseless is refused.
#[test]
fn doubtful_comparisons_say_so() {
    let place = Place::new("doubts");
    place.runs("genetic", &[]);
    place.runs("longer", &["--set", "evolution.generations=9"]);
    let all = ["genetic", "longer", "--trials", "3"];
    place.run(&[&["compare"][..], &all].concat()).exits(0).says(&[
        "warning: budgets are unequal: from 135 (genetic) to 195 (longer) episodes a run",
        "3 new episodes of each champion, seed 1",
    ]);
    let page = place.text("compare/compare.html");
    assert!(page.contains("budgets are unequal"), "{page}");

    // Tasks that differ in more than what is scored have recorded scores only.
    place.runs("cycles", &["--set", "cycles=30"]);
    place.run(&["compare", "genetic", "cycles"]).exits(0).says(&[
        "warning: tasks differ in cycles: 40 (genetic), 30 (cycles)",
        "6 runs; recorded scores",
    ]);
    let recorded: Value = serde_json::from_slice(&place.read("genetic/seed-2/champion.json")).unwrap();
    let own: f64 = place.table_of("compare/compare.csv")[1]["score"].parse().unwrap();
    let known = recorded["mean"].as_f64().unwrap();
    assert!((own - known).abs() <= 1e-5 * known.abs(), "{own}, {known}");
    // Given the same value, they share it.
    place
        .run(&["compare", "genetic", "cycles", "--set", "cycles=30", "--trials", "3"])
        .exits(0)
        .says(&["3 new episodes of each champion"]);

    // Scores by which selection went are too high, and those of several episodes must be combined alike.
    let none = ["--set", "evolution.finalists=0", "--set", "trials=2"];
    place.runs("mean", &none);
    place.runs("least", &[&none[..], &["--set", "trial_score=least"]].concat());
    place
        .run(&["compare", "mean", "genetic", "--recorded"])
        .exits(0)
        .says(&["some runs have no finalists", "trials = 2 (mean), 1 (genetic)"]);
    place.run(&["compare", "mean", "least", "--recorded"]).exits(3).says(&[
        "scores are not comparable: trial_score: \"mean\" (mean), \"least\" (least); allowed: experiments whose scores count the same",
    ]);
    place.run(&["compare", "mean", "least", "--trials", "3"]).exits(0);

    // Not two conditions.
    place
        .run(&["compare", "genetic", "genetic/seed-1"])
        .exits(3)
        .says(&["all finished runs are of one experiment, genetic; allowed: "]);
    place
        .run(&["compare", "genetic", "nothing"])
        .exits(3)
        .says(&["nothing"]);
    place.run(&["compare", "genetic", "longer", "--trials", "1"]).exits(3);
    place
        .run(&["compare", "genetic", "longer", "--recorded", "--trials", "9"])
        .exits(2);
}

/// Scores that count different things are not compared, however alike they look.
#[cfg(feature = "compose")]
#[test]
fn scores_of_different_tasks_are_refused() {
    let place = Place::new("tasks");
    place.runs("genetic", &[]);
    place.good(&["new", "corridor", "--task", "corridor-task"]);
    let short = [
        "cycles=40",
        "evolution.population=20",
        "evolution.parents=4",
        "evolution.generations=2",
    ];
    let short: Vec<&str> = short.iter().flat_map(|set| ["--set", set]).collect();
    place.evolved("corridor.toml", "1", "corridor", &short);
    place
        .run(&["compare", "genetic", "corridor"])
        .exits(3)
        .says(&["scores are not comparable: task.kind: \"avoidance\" (genetic), \"own\" (corridor)"]);
    assert!(!place.at("compare/compare.html").exists());
}

/// A sweep that has not ended is compared as far as it goes; runs that have not ended are left out.
#[test]
fn unfinished_work_is_compared_as_far_as_it_goes() {
    let place = Place::new("unfinished");
    place.runs("genetic", &[]);
    let sweep = "experiment = \"small.toml\"\nseeds = \"1..4\"\n[set]\nevolution.kind = \"random\"\n[grid]\nevolution.population = [20]\n";
    place.write("sweep.toml", sweep);
    let run = [
        "sweep",
        "run",
        "sweep.toml",
        "--out",
        "half",
        "--shard",
        "1/2",
        "--backend",
        "cpu",
    ];
    place.good(&run);
    let said = place
        .run(&["compare", "genetic", "half", "--trials", "3", "--out", "out"])
        .exits(0);
    let said = said.says(&["warning: half: is unfinished: 2 runs are missing of 4"]);
    assert!(said.stdout.contains("sweep "), "{}", said.stdout);
    let runs = place.table_of("out/compare.csv");
    let seeds: Vec<&str> = runs[3..].iter().map(|run| run["seed"].as_str()).collect();
    assert_eq!(seeds, ["1", "3"]);
    // Two runs are too few for a test, and nothing temporary is left.
    assert!(place.text("out/compare.html").contains("too few to test"));
    assert_eq!(place.table_of("out/effects.csv").len(), 0);
    let left = std::fs::read_dir(place.at("out")).unwrap();
    let left: Vec<String> = left
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    assert!(left.iter().all(|name| !name.starts_with('.')), "{left:?}");
}
