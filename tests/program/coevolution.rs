//! Two populations that live against each other, through the program: what their records and their tournament say beside the same
//! numbers computed here from every contest, kills, other devices, and refusals.

use std::fs;
use std::path::Path;
use std::thread;
use std::time::Duration;

use serde_json::Value;

use crate::place::Place;

/// Genes of both and of the predator alone, generations, individuals of each, and contests of each.
const GENES: usize = 54;
const SPLIT: usize = 32;
const GENERATIONS: usize = 7;
const POPULATION: usize = 10;
const CONTESTS: usize = 3;

/// A short evolution of the experiment that ships, in which every contest is recorded.
const SHORT: [&str; 9] = [
    "cycles=60",
    "evolution.generations=7",
    "evolution.population=10",
    "evolution.parents=5",
    "evolution.opponents.contests=3",
    "evolution.finalist_lives=4",
    "record.individuals=true",
    "record.checkpoint_every=1",
    "evolution.mutation.rate=0.1",
];

/// With the opponents of the last generations.
const RECENT: [&str; 2] = ["--set", "evolution.opponents.generations=2"];

fn shipped() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments/predator-prey.toml");
    path.display().to_string()
}

/// Arguments that run it.
fn arguments<'a>(experiment: &'a str, out: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let run = ["run", experiment, "--seed", "3", "--backend", "cpu", "--out", out];
    let set = SHORT.iter().flat_map(|value| ["--set", value]);
    run.into_iter().chain(set).chain(more.iter().copied()).collect()
}

fn run(place: &Place, out: &str, more: &[&str]) {
    place.good(&arguments(&shipped(), out, more));
}

fn numbers(place: &Place, file: &str) -> Vec<f32> {
    npyz::NpyFile::new(&place.read(file)[..]).unwrap().into_vec().unwrap()
}

/// Best, mean and index of the best of each generation.
fn rows(place: &Place, file: &str) -> Vec<[f64; 3]> {
    let text = place.text(file);
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let columns = ["best", "mean", "individual"].map(|name| head.iter().position(|own| *own == name).unwrap());
    lines
        .map(|line| {
            let fields: Vec<&str> = line.split(',').collect();
            columns.map(|column| fields[column].parse().unwrap())
        })
        .collect()
}

/// A contest: its genes, and the predator's score.
type Contest<'a> = (&'a [f32], f64);

/// Scores of individuals: the means of their contests, which lie one after the other, by this number of a contest.
fn scores(contests: &[Contest<'_>], own: fn(f64) -> f64) -> Vec<f64> {
    let mean = |all: &[Contest<'_>]| all.iter().map(|(_, score)| own(*score)).sum::<f64>() / all.len() as f64;
    contests.chunks_exact(CONTESTS).map(mean).collect()
}

/// Index of the best, the first of equals, as in 32 bits.
fn best(scores: &[f64]) -> usize {
    let better = |best, own| {
        if scores[own] as f32 > scores[best] as f32 {
            own
        } else {
            best
        }
    };
    (0..scores.len()).fold(0, better)
}

/// Tables and the hall of fame are what every contest, evaluated again, says; opponents are those that the experiment names.
fn check_record(place: &Place, run: &str, is_recent: bool) {
    let individuals = numbers(place, &format!("{run}/individuals.npy"));
    let hall = numbers(place, &format!("{run}/hall-of-fame.npy"));
    let hall: Vec<&[f32]> = hall.chunks_exact(GENES).collect();
    let tables = ["generations", "second"].map(|file| rows(place, &format!("{run}/{file}.csv")));
    let lived = 2 * POPULATION * CONTESTS;
    assert_eq!(
        (individuals.len(), hall.len()),
        (GENERATIONS * lived * (GENES + 1), GENERATIONS)
    );
    let all: Vec<Contest<'_>> = individuals
        .chunks_exact(GENES + 1)
        .map(|own| (&own[..GENES], f64::from(own[GENES])))
        .collect();
    let mut met_in_all = std::collections::BTreeSet::new();
    for (generation, contests) in all.chunks_exact(lived).enumerate() {
        let (first, second) = contests.split_at(lived / 2);
        let both = [scores(first, |score| score), scores(second, |score| 1.0 - score)];
        for (side, own) in both.iter().enumerate() {
            let [most, mean, individual] = tables[side][generation];
            let found = best(own);
            assert_eq!(found as f64, individual, "{run}, {generation}, {side}");
            assert!((own[found] - most).abs() < 1e-6 && (own.iter().sum::<f64>() / 10.0 - mean).abs() < 2e-6);
            let (genes, contests) = [(0..SPLIT, first), (SPLIT..GENES, second)][side].clone();
            assert_eq!(contests[found * CONTESTS].0[genes.clone()], hall[generation][genes]);
        }
        if generation == 0 {
            continue;
        }
        for (genes, contests) in [(SPLIT..GENES, first), (0..SPLIT, second)] {
            for own in contests.chunks_exact(CONTESTS) {
                let met = own.iter().map(|(genome, _)| {
                    let is_met = |generation: &usize| hall[*generation][genes.clone()] == genome[genes.clone()];
                    // Of two that are equal the later one.
                    (0..generation)
                        .rev()
                        .find(is_met)
                        .expect("a champion of an earlier generation")
                });
                let met: Vec<usize> = met.collect();
                if is_recent {
                    let last = generation.min(2);
                    let expected = (0..CONTESTS).map(|contest| generation - 1 - contest % last);
                    for (met, expected) in met.iter().zip(expected) {
                        assert_eq!(hall[*met][genes.clone()], hall[expected][genes.clone()]);
                    }
                }
                met_in_all.extend(met.iter().map(|met| generation - met));
            }
        }
    }
    // Only a hall of fame has older ones.
    assert_eq!(met_in_all.iter().any(|age| *age > 2), !is_recent, "{met_in_all:?}");
}

#[test]
fn records_are_what_the_contests_say() {
    let place = Place::new("record");
    run(&place, "recent", &RECENT);
    check_record(&place, "recent", true);
    run(&place, "hall", &["--set", "evolution.opponents.kind=hall-of-fame"]);
    check_record(&place, "hall", false);
    assert_ne!(
        numbers(&place, "recent/hall-of-fame.npy"),
        numbers(&place, "hall/hall-of-fame.npy")
    );
    // The champion is the last pair, and its recorded life can be lived again.
    let champion = numbers(&place, "recent/champion.npy");
    let hall = numbers(&place, "recent/hall-of-fame.npy");
    assert_eq!(champion, hall[hall.len() - GENES..]);
    assert_eq!(place.json("recent", "champion.json")["generation"], GENERATIONS - 1);
    for command in ["verify", "replay"] {
        place.good(&[command, "recent"]);
    }
    for option in ["--generation", "--generations"] {
        place
            .run(&["replay", "recent", option, "1"])
            .exits(3)
            .says(&[&format!("{option}: is given, and this run's individuals")]);
    }
    let audit = [
        "verify",
        "--recompute",
        "recent",
        "--fraction",
        "1",
        "--json",
        "--backend",
        "cpu:interpretedx1",
    ];
    let audit: Value = serde_json::from_str(&place.good(&audit)).unwrap();
    let run = &audit["runs"][0];
    assert_eq!(run["audited"], GENERATIONS * 2 * POPULATION * CONTESTS);
    assert_eq!(run["different"], 0);
}

/// Results have the same bytes on other devices, and if the program is killed time and again.
#[test]
fn a_run_is_the_same_however_it_is_computed() {
    let place = Place::new("same");
    let result = |run: &str| place.json(run, "DONE")["result"].as_str().unwrap().to_owned();
    run(&place, "one", &RECENT);
    let others = [("two", "cpu:interpretedx1"), ("gpu", "gpu:llvmpipe")];
    for (out, device) in others.into_iter().take(if cfg!(feature = "gpu") { 2 } else { 1 }) {
        // The last of two options counts.
        let experiment = shipped();
        let mut other = arguments(&experiment, out, &RECENT);
        let place_of_device = other.iter().position(|word| *word == "cpu").unwrap();
        other[place_of_device] = device;
        place.good(&other);
        assert_eq!(result(out), result("one"), "{device}");
    }
    run(&place, "other", &["--set", "evolution.opponents.generations=3"]);
    assert_ne!(result("other"), result("one"));
    let experiment = shipped();
    let killed = arguments(&experiment, "killed", &RECENT);
    let mut kills = 0;
    for wait in (0..).map(|turn| 20 + 15 * turn) {
        let resume = ["resume", "killed", "--backend", "cpu"];
        let has_begun = place.at("killed/config.toml").exists();
        let mut child = place.start(if has_begun { &resume } else { &killed });
        thread::sleep(Duration::from_millis(wait));
        if place.at("killed/DONE").exists() {
            child.wait().unwrap();
            break;
        }
        child.kill().unwrap();
        child.wait().unwrap();
        kills += 1;
        if !has_begun && !place.at("killed/config.toml").exists() && place.at("killed").exists() {
            fs::remove_dir_all(place.at("killed")).unwrap();
        }
    }
    assert!(kills > 0);
    assert_eq!(result("killed"), result("one"), "after {kills} kills");
}

/// A pair's score in the tournament is that of `oneiro evaluate`, and the summary is that of the table.
#[test]
fn a_tournament_plays_all_pairs() {
    let place = Place::new("tournament");
    run(&place, "run", &[]);
    let said = place.good(&[
        "evaluate",
        "--tournament",
        "--genomes",
        "run",
        "--trials",
        "4",
        "--seed",
        "6",
        "--json",
        "--backend",
        "cpu",
    ]);
    let said: Value = serde_json::from_str(&said).unwrap();
    let table = place.text("run/tournament.csv");
    let scores: Vec<Vec<f64>> = table
        .lines()
        .skip(1)
        .map(|line| line.split(',').skip(1).map(|score| score.parse().unwrap()).collect())
        .collect();
    assert!(table.starts_with("generation,second_0,second_1,"));
    assert_eq!((scores.len(), scores[0].len()), (GENERATIONS, GENERATIONS));
    let hall = numbers(&place, "run/hall-of-fame.npy");
    let mut pairs = String::new();
    for first in 0..GENERATIONS {
        for second in 0..GENERATIONS {
            let own = hall[first * GENES..].iter().take(SPLIT);
            let genes = own.chain(&hall[second * GENES + SPLIT..(second + 1) * GENES]);
            pairs += &genes.map(ToString::to_string).collect::<Vec<_>>().join(",");
            pairs += "\n";
        }
    }
    place.write("pairs.csv", pairs);
    let evaluate = [
        "evaluate",
        "run/config.toml",
        "--genomes",
        "pairs.csv",
        "--trials",
        "4",
        "--seed",
        "6",
    ];
    let summary = ["--common-starts", "--summary", "--backend", "cpu:interpretedx1"];
    let evaluated = place.good(&[&evaluate[..], &summary].concat());
    let mut seen = Vec::new();
    for (pair, line) in evaluated.lines().skip(1).enumerate() {
        let mean: f64 = line.split(',').nth(2).unwrap().parse().unwrap();
        let own = scores[pair / GENERATIONS][pair % GENERATIONS];
        assert!((mean - own).abs() <= 1e-5, "{line}: {own}");
        seen.push(own);
    }
    assert_eq!(seen.len(), GENERATIONS * GENERATIONS);
    assert!(seen.iter().any(|own| *own != seen[0]), "all are alike");
    let mean = seen.iter().sum::<f64>() / seen.len() as f64;
    let summary = &said["runs"][0];
    for (side, expected) in [("first", mean), ("second", 1.0 - mean)] {
        assert!(
            (summary[side]["mean"].as_f64().unwrap() - expected).abs() < 1e-5,
            "{summary}"
        );
    }
    for picture in ["tournament.svg", "tournament-progress.svg"] {
        assert!(place.text(format!("run/{picture}")).starts_with("<svg"));
    }
    // Files that are added afterwards are none of the run's results.
    place.good(&["verify", "run"]);
}

#[test]
fn wrong_input_is_refused() {
    let place = Place::new("refusals");
    let experiment = shipped();
    for (value, words) in [
        (
            "evolution.opponents.first_gene=moon",
            "is \"moon\"; allowed: a gene except the first: ",
        ),
        (
            "evolution.opponents.first_gene=predator_to_left_left_90",
            "allowed: a gene except the first: ",
        ),
        ("evolution.opponents.kind=all", "allowed: "),
        ("evolution.opponents.contests=0", "is 0; allowed: 1 to 10000"),
        ("evolution.mutation.bits=17", "is 17; allowed: 1 to 16"),
        (
            "robot.starts_mm=[[117.5, 235.0]]",
            "has 1 places; allowed: one for each robot, 2",
        ),
        (
            "robot.starts_mm=[[117.5, 235.0], [150.0, 235.0]]",
            "has overlapping places 0 and 1; allowed: at least 57 mm",
        ),
        (
            "robot.starts_mm=[[117.5, 235.0], [460.0, 235.0]]",
            "touches an object; allowed: ",
        ),
        (
            "robot.starts_mm=[[117.5, 235.0], [900.0, 235.0]]",
            "outside of the arena; allowed: ",
        ),
    ] {
        let key = value.split('=').next().unwrap();
        place
            .run(&["check", &experiment, "--set", value])
            .exits(3)
            .says(&[key, words]);
    }
    let text = fs::read_to_string(&experiment)
        .unwrap()
        .replace("\"predator-prey/", "\"parts/");
    fs::create_dir(place.at("parts")).unwrap();
    for part in ["sensors", "controller", "mission"] {
        let path = Path::new(&experiment).with_file_name(format!("predator-prey/{part}.wgsl"));
        fs::copy(path, place.at(format!("parts/{part}.wgsl"))).unwrap();
    }
    let (line, wrong) = (
        text.lines().position(|line| line.starts_with("first_gene")),
        text.replace("prey_to_left_0", "moon"),
    );
    place.write("wrong.toml", wrong);
    let at = format!(
        "wrong.toml:{}:14: evolution.opponents.first_gene: is \"moon\"",
        line.unwrap() + 1
    );
    place.run(&["check", "wrong.toml"]).exits(3).says(&[&at]);
    place.write(
        "plain.toml",
        "cycles = 20\n[evolution]\npopulation = 4\nparents = 2\ngenerations = 2\nfinalists = 0\n",
    );
    place.good(&["run", "plain.toml", "--seed", "1", "--out", "plain", "--backend", "cpu"]);
    place
        .run(&["evaluate", "--tournament", "--genomes", "plain"])
        .exits(3)
        .says(&["is the run of one population"]);
    place
        .run(&["evaluate", "--tournament", "--genomes", "nowhere"])
        .exits(3);
}
