//! Names and not positions: genes by every way in which genomes enter the program, columns of files, and the columns of a sweep of all
//! kinds of evolution.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;

use serde_json::{Value, json};

use crate::place::Place;

/// A robot with four sensors, in one order or in another.
fn robot(sensors: &[(&str, f64)]) -> String {
    let mut text = "cycles = 200\ntrials = 2\n\n[robot]\npreset = \"khepera\"\n".to_owned();
    for (name, heading) in sensors {
        let _ = write!(
            text,
            "\n[[robot.sensors]]\nname = \"{name}\"\nkind = \"proximity\"\nheading_turns = {heading}\nrange_mm = 60.0\n"
        );
    }
    text + "\n[evolution]\npopulation = 12\nparents = 3\ngenerations = 3\nfinalist_lives = 5\n"
}

const SENSORS: [(&str, f64); 4] = [("p0", 0.2), ("p1", 0.05), ("p2", -0.05), ("p3", -0.2)];

/// Few weights, whose sum has no order: the same bits in both experiments, if each gene is found.
const GENOME: [(&str, f64); 10] = [
    ("p0_to_left", 0.0),
    ("p1_to_left", 2.5),
    ("p2_to_left", 0.0),
    ("p3_to_left", 0.0),
    ("bias_left", 0.5),
    ("p0_to_right", 0.0),
    ("p1_to_right", 0.0),
    ("p2_to_right", -1.5),
    ("p3_to_right", 0.0),
    ("bias_right", 0.25),
];

/// An experiment, the same with its sensors in reverse, and runs of both: `own` and `other`.
fn two_orders(name: &str) -> Place {
    let place = Place::new(name);
    place.write("own.toml", robot(&SENSORS));
    let mut reversed = SENSORS;
    reversed.reverse();
    place.write("reversed.toml", robot(&reversed));
    let renamed: Vec<(&str, f64)> = SENSORS
        .iter()
        .map(|&(name, at)| (if name == "p3" { "q3" } else { name }, at))
        .collect();
    place.write("renamed.toml", robot(&renamed));
    for (experiment, out) in [("own.toml", "own"), ("reversed.toml", "other")] {
        place.evolved(experiment, "1", out, &[]);
    }
    place
}

/// A file of genomes, by the names of their genes in some order.
fn csv(order: &[usize], genomes: &[Vec<f64>], name: impl Fn(&str) -> String) -> String {
    let line =
        |cell: &dyn Fn(usize) -> String| order.iter().map(|&gene| cell(gene)).collect::<Vec<_>>().join(",") + "\n";
    let mut text = line(&|gene| name(GENOME[gene].0));
    for genome in genomes {
        text += &line(&|gene| genome[gene].to_string());
    }
    text
}

fn numbers(value: &Value) -> Vec<f64> {
    value
        .as_array()
        .unwrap()
        .iter()
        .map(|number| number.as_f64().unwrap())
        .collect()
}

/// The bits of genomes' fitness, and what was said.
fn evaluated(place: &Place, experiment: &str, genomes: &[&str]) -> (Vec<String>, String) {
    let all = [
        &["evaluate", experiment, "--json", "--backend", "cpu", "--genomes"],
        genomes,
    ]
    .concat();
    let ran = place.run(&all).exits(0);
    let rows: Vec<Value> = serde_json::from_str(&ran.stdout).unwrap();
    let bits = rows.iter().map(|row| row["bits"].as_str().unwrap().to_owned());
    let said = ran.stderr.lines().filter(|line| !line.starts_with("next: "));
    (bits.collect(), said.collect::<Vec<_>>().join("\n"))
}

fn population(place: &Place, file: &str) -> Vec<Vec<f64>> {
    let bytes = place.read(file);
    let genes: Vec<f32> = npyz::NpyFile::new(&bytes[..]).unwrap().into_vec().unwrap();
    genes
        .chunks(GENOME.len())
        .map(|genome| genome.iter().map(|&gene| gene.into()).collect())
        .collect()
}

const IN_ORDER: [usize; 10] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9];
const SHUFFLED: [usize; 10] = [9, 2, 7, 0, 4, 1, 8, 5, 3, 6];

#[test]
fn files_of_genomes_are_read_by_name() {
    let place = two_orders("files");
    let genome: Vec<f64> = GENOME.iter().map(|(_, value)| *value).collect();
    let of = |order: &[usize]| {
        let names: Vec<&str> = order.iter().map(|&gene| GENOME[gene].0).collect();
        let genes: Vec<f64> = order.iter().map(|&gene| genome[gene]).collect();
        json!({"genome": genes, "gene_names": names}).to_string()
    };
    let genomes = std::slice::from_ref(&genome);
    for (file, text) in [
        ("own.json", of(&IN_ORDER)),
        ("shuffled.json", of(&SHUFFLED)),
        ("own.csv", csv(&IN_ORDER, genomes, str::to_owned)),
        ("shuffled.csv", csv(&SHUFFLED, genomes, str::to_uppercase)),
    ] {
        place.write(file, text);
    }
    let (expected, _) = evaluated(&place, "own.toml", &["own.json"]);
    for file in ["own.json", "shuffled.json", "own.csv", "shuffled.csv"] {
        for experiment in ["own.toml", "reversed.toml"] {
            let (bits, said) = evaluated(&place, experiment, &[file]);
            assert_eq!(bits, expected, "{experiment}, {file}");
            assert!(!said.contains(file), "{said}");
        }
        let renamed = ["evaluate", "renamed.toml", "--genomes", file];
        place.run(&renamed).exits(3).says(&[file, "`q3_to_left`", "allowed"]);
    }
    // Other columns are ignored, with a word.
    let with_notes: String = csv(&SHUFFLED, genomes, str::to_owned)
        .lines()
        .zip(["note", "7"])
        .flat_map(|(line, note)| [line, ",", note, "\n"])
        .collect();
    place.write("notes.csv", with_notes);
    let (bits, said) = evaluated(&place, "reversed.toml", &["notes.csv"]);
    assert_eq!(bits, expected);
    assert!(
        said.contains("notes.csv: has other columns, which are ignored: `note`"),
        "{said}"
    );

    // Without names genes are in the controller's order, which is said.
    let cells: Vec<String> = genome.iter().map(f64::to_string).collect();
    place.write("plain.csv", cells.join(",") + "\n");
    place.write("plain.json", json!({ "genome": genome }).to_string());
    for (file, words) in [("plain.csv", "names no columns"), ("plain.json", "names no genes")] {
        let (bits, said) = evaluated(&place, "own.toml", &[file]);
        assert_eq!(bits, expected);
        assert!(said.contains(&format!("{file}: {words}")), "{said}");
        assert!(said.contains("order: `p0_to_left`, `p1_to_left`"), "{said}");
    }
    let (bits, said) = evaluated(&place, "reversed.toml", &["plain.csv"]);
    assert_ne!(bits, expected);
    assert!(said.contains("plain.csv: names no columns"), "{said}");
}

/// Genomes of run directories and sweeps, of other experiments whose controllers have the same genes in another order.
#[test]
fn directories_are_read_by_name() {
    let place = two_orders("directories");
    let everyone = population(&place, "own/population.npy");
    place.write("everyone.csv", csv(&SHUFFLED, &everyone, str::to_owned));
    let (by_file, _) = evaluated(&place, "reversed.toml", &["everyone.csv"]);
    let (by_run, _) = evaluated(&place, "reversed.toml", &["own", "--population"]);
    assert_eq!(by_run, by_file);
    let (by_position, said) = evaluated(&place, "reversed.toml", &["own/population.npy"]);
    assert_ne!(by_position, by_file);
    assert!(said.contains("own/population.npy: names no genes"), "{said}");

    let champion: Value = serde_json::from_str(&place.text("own/champion.json")).unwrap();
    place.write(
        "champion.csv",
        csv(&IN_ORDER, &[numbers(&champion["genome"])], str::to_owned),
    );
    let (expected, _) = evaluated(&place, "reversed.toml", &["champion.csv"]);
    for genomes in ["own", "own/champion.json"] {
        assert_eq!(evaluated(&place, "reversed.toml", &[genomes]).0, expected, "{genomes}");
    }
    place
        .run(&["evaluate", "renamed.toml", "--genomes", "own"])
        .exits(3)
        .says(&[
            "own: has genomes of 10 genes",
            "it lacks `q3_to_left`",
            "the controller has no `p3_to_left`",
        ]);

    let best = |genomes: &str| {
        let all = [
            "evaluate",
            "reversed.toml",
            "--best",
            "--genomes",
            genomes,
            "--trials",
            "5",
            "--backend",
            "cpu",
            "--json",
            "--quiet",
        ];
        serde_json::from_str::<Value>(&place.good(&all)).unwrap()["best"].clone()
    };
    let found = best("own/champion.json");
    let names: Vec<&str> = found["gene_names"]
        .as_array()
        .unwrap()
        .iter()
        .map(|name| name.as_str().unwrap())
        .collect();
    assert_eq!(names[0], "p3_to_left");
    let by_name: BTreeMap<&str, f64> = names.into_iter().zip(numbers(&found["genome"])).collect();
    let own = GENOME.iter().map(|(name, _)| *name).zip(numbers(&champion["genome"]));
    assert_eq!(by_name, own.collect());
    let all = [
        "evaluate",
        "reversed.toml",
        "--best",
        "--genomes",
        "own",
        "--trials",
        "5",
        "--all",
        "--backend",
        "cpu",
        "--json",
        "--quiet",
    ];
    let all: Value = serde_json::from_str(&place.good(&all)).unwrap();
    let of_run = all["genomes"]
        .as_array()
        .unwrap()
        .iter()
        .find(|row| row["source"] == "own/champion.npy")
        .unwrap();
    assert_eq!(of_run["mean"], found["mean"]);

    let replayed = |genome: &str| {
        let all = [
            "replay",
            "other",
            "--genome",
            genome,
            "--out",
            "again",
            "--json",
            "--quiet",
            "--backend",
            "cpu",
        ];
        serde_json::from_str::<Value>(&place.good(&all)).unwrap()["bits"].clone()
    };
    assert_eq!(replayed("own/champion.json"), replayed("champion.csv"));
    assert_ne!(replayed("own/champion.npy"), replayed("champion.csv"));

    place.write(
        "sweep.toml",
        "experiment = \"own.toml\"\nseeds = [1, 2]\n[grid]\nevolution.elite = [0, 1]\n",
    );
    place.good(&[
        "sweep",
        "run",
        "sweep.toml",
        "--out",
        "sweep",
        "--yes",
        "--backend",
        "cpu",
        "--quiet",
    ]);
    let (champions, _) = evaluated(&place, "reversed.toml", &["sweep"]);
    assert_eq!(
        champions,
        evaluated(&place, "reversed.toml", &["sweep/champions.csv"]).0
    );
    place
        .run(&["evaluate", "renamed.toml", "--genomes", "sweep"])
        .exits(3)
        .says(&["sweep/champions.csv: has genomes of 10 genes", "it lacks `q3_to_left`"]);
}

/// An evolution begins with the genes that a file names.
#[test]
fn first_genomes_are_read_by_name() {
    let place = two_orders("init");
    let everyone = population(&place, "own/population.npy");
    place.write("own-order.csv", csv(&IN_ORDER, &everyone, str::to_owned));
    place.write("shuffled.csv", csv(&SHUFFLED, &everyone, str::to_uppercase));
    let run = |init: &str, out: &str| {
        let init = format!("evolution.init=\"{init}\"");
        let all = [
            "run",
            "reversed.toml",
            "--set",
            &init,
            "--seed",
            "3",
            "--out",
            out,
            "--backend",
            "cpu",
        ];
        let said = place.run(&all).exits(0).stderr;
        (place.text(format!("{out}/generations.csv")), said)
    };
    let (expected, said) = run("own-order.csv", "a");
    assert!(!said.contains("own-order.csv"), "{said}");
    assert_eq!(run("shuffled.csv", "b").0, expected);
    // A file without names that lies in no run is read by position, with a word; that of a run has the run's names.
    fs::copy(place.at("own/population.npy"), place.at("plain.npy")).unwrap();
    let (other, said) = run("plain.npy", "c");
    assert_ne!(other, expected);
    assert!(said.contains("warning: evolution.init: "), "{said}");
    assert!(
        said.contains("plain.npy: names no genes; they are taken in the controller's order: `p3_to_left`"),
        "{said}"
    );
    place
        .run(&[
            "check",
            "reversed.toml",
            "--set",
            "evolution.init=\"own/population.npy\"",
        ])
        .exits(3)
        .says(&["evolution.init", "own/population.npy"]);
    place
        .run(&["check", "renamed.toml", "--set", "evolution.init=\"shuffled.csv\""])
        .exits(3)
        .says(&["evolution.init", "shuffled.csv: line 1", "`q3_to_left`"]);
}

/// Starts of lives, in capitals and another order.
#[test]
fn starts_are_read_by_name() {
    let place = two_orders("starts");
    place.write("starts.csv", "x_mm,y_mm,heading_turns\n100,90,0.25\n120,80,0.5\n");
    place.write("capitals.csv", "HEADING_TURNS,Y_mm,X_mm\n0.25,90,100\n0.5,80,120\n");
    place.write("plain.csv", "100,90,0.25\n120,80,0.5\n");
    place.write("units.csv", "x_m,y_m,heading_turns\n100,90,0.25\n");
    let bits = |starts: &str| evaluated(&place, "own.toml", &["own", "--starts", starts]);
    let (expected, said) = bits("starts.csv");
    assert!(!said.contains("starts.csv"), "{said}");
    assert_eq!(bits("capitals.csv").0, expected);
    let (plain, said) = bits("plain.csv");
    assert_eq!(plain, expected);
    let words = "plain.csv: names no columns; they are read in this order: `x_mm`, `y_mm`, `heading_turns`";
    assert!(said.contains(words), "{said}");
    place
        .run(&["evaluate", "own.toml", "--genomes", "own", "--starts", "units.csv"])
        .exits(3)
        .says(&["units.csv: line 1", "none is called `x_mm`, `y_mm`", "allowed"]);
}

/// An experiment that is valid with every kind of evolution.
const KINDS: &str = "cycles = 20

[robot]
preset = \"khepera\"

[controller]
kind = \"own\"
part = \"four.wgsl\"

[evolution]
population = 16
parents = 4
generations = 2
finalists = 2
finalist_lives = 2
initial = [-1.0, 1.0]
descriptors = [{ measure = \"end_x_mm\", least = 0.0, greatest = 200.0, cells = 7 }]

[evolution.grid]
levels = 2

[evolution.race]
lives = 1000

[evolution.opponents]
first_gene = \"gene_2\"
contests = 2
";

const FOUR_GENES: &str = "
const CONTROLLER_GENES: u32 = 4u;
struct ControllerState {
    last: f32,
}
fn controller_begin(episode: Episode) -> ControllerState {
    return ControllerState(gene(episode, 3u));
}
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    let near = reading(readings, 0u) + before.last;
    let outputs = vec2<f32>(logistic(gene(episode, 0u) + near * gene(episode, 2u)), logistic(gene(episode, 1u) - near));
    return Command(outputs, ControllerState(0.5f * near));
}
";

/// Rows of a table, by the names of its columns.
fn rows(text: &str) -> Vec<BTreeMap<&str, &str>> {
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let head = lines.next().unwrap();
    lines
        .map(|cells| {
            assert_eq!(cells.len(), head.len());
            head.iter().copied().zip(cells).collect()
        })
        .collect()
}

/// The outcome of a run by the files of its directory.
fn given_by(place: &Place, run: &str) -> BTreeMap<&'static str, String> {
    let mut given = BTreeMap::new();
    let of = |file: &str| {
        place
            .at(format!("{run}/{file}"))
            .is_file()
            .then(|| place.text(format!("{run}/{file}")))
    };
    let generations = of("generations.csv").unwrap();
    let generations = rows(&generations);
    let last = generations.last().unwrap();
    given.insert("peak", last["peak"].to_owned());
    given.insert("mean", last["mean"].to_owned());
    let nan: u64 = generations.iter().map(|row| row["nan"].parse::<u64>().unwrap()).sum();
    given.insert("nan", nan.to_string());
    if let Some(second) = of("second.csv") {
        let second = rows(&second);
        given.insert("second_peak", second.last().unwrap()["peak"].to_owned());
        given.insert("second_mean", second.last().unwrap()["mean"].to_owned());
    }
    if let Some(behaviour) = of("behaviour.csv") {
        let behaviour = rows(&behaviour);
        let nan: u64 = behaviour.iter().map(|row| row["nan"].parse::<u64>().unwrap()).sum();
        given.insert("nan_measures", nan.to_string());
    }
    if let Some(coverage) = of("coverage.csv") {
        let coverage = rows(&coverage);
        given.insert("coverage", coverage.last().unwrap()["coverage"].to_owned());
        given.insert("qd_score", coverage.last().unwrap()["qd_score"].to_owned());
    }
    let json = |file: &str| serde_json::from_str::<Value>(&of(file).unwrap()).unwrap();
    let (champion, luckiest) = (json("champion.json"), json("luckiest.json"));
    given.insert("champion_mean", format!("{:.6}", champion["mean"].as_f64().unwrap()));
    given.insert(
        "champion_low",
        format!("{:.6}", champion["interval"][0].as_f64().unwrap()),
    );
    given.insert(
        "champion_high",
        format!("{:.6}", champion["interval"][1].as_f64().unwrap()),
    );
    given.insert("champion_generation", champion["generation"].to_string());
    given.insert("champion_individual", champion["individual"].to_string());
    given.insert("best", (luckiest["fitness"].as_f64().unwrap() as f32).to_string());
    given.insert("best_generation", luckiest["generation"].to_string());
    given.insert("best_individual", luckiest["individual"].to_string());
    given
}

/// A sweep over all kinds of evolution, in both orders, so that each kind comes before and after each other: every cell has the value
/// of its name, that of the run by itself, and is empty where the run has none.
#[test]
fn a_sweep_of_all_kinds_has_each_value_under_its_name() {
    let place = Place::new("kinds");
    place.write("base.toml", KINDS);
    place.write("four.wgsl", FOUR_GENES);
    let keys: Value = serde_json::from_str(&place.good(&["new", "--keys", "evolution.kind", "--json"])).unwrap();
    let row = keys["single"]
        .as_array()
        .unwrap()
        .iter()
        .find(|row| row["key"] == "evolution.kind")
        .unwrap();
    let mut kinds: Vec<&str> = row["choices"]
        .as_array()
        .unwrap()
        .iter()
        .map(|choice| choice[0].as_str().unwrap())
        .collect();
    assert!(kinds.len() >= 10);
    let mut known = BTreeMap::new();
    for kind in &kinds {
        let set = format!("evolution.kind=\"{kind}\"");
        place.evolved("base.toml", "7", kind, &["--set", &set]);
        known.insert(*kind, given_by(&place, kind));
    }
    let names: std::collections::BTreeSet<&str> = known.values().flat_map(BTreeMap::keys).copied().collect();
    for sweep in ["forwards", "backwards"] {
        let list: Vec<String> = kinds.iter().map(|kind| format!("\"{kind}\"")).collect();
        let text = format!(
            "experiment = \"base.toml\"\nseeds = [7]\n[grid]\nevolution.kind = [{}]\n",
            list.join(", ")
        );
        place.write(format!("{sweep}.toml"), text);
        place.good(&[
            "sweep",
            "run",
            &format!("{sweep}.toml"),
            "--out",
            sweep,
            "--yes",
            "--backend",
            "cpu",
            "--quiet",
        ]);
        let text = place.text(format!("{sweep}/results.csv"));
        let rows = rows(&text);
        assert_eq!(rows.len(), kinds.len());
        for row in rows {
            let kind = row["evolution.kind"];
            for name in &names {
                let expected = known[kind].get(name).map_or("", String::as_str);
                assert_eq!(row[name], expected, "{sweep}, {kind}: {name}");
            }
            let others: Vec<&str> = row.keys().copied().filter(|name| !names.contains(name)).collect();
            assert_eq!(
                others,
                ["evolution.kind", "id", "result", "run", "seed"],
                "the test knows all columns"
            );
            let done: Value = serde_json::from_str(&place.text(format!("{kind}/DONE"))).unwrap();
            assert_eq!(row["result"], done["result"], "{kind}");
        }
        kinds.reverse();
        // A report can be made of these tables.
        place.good(&["sweep", "report", sweep]);
    }
}
