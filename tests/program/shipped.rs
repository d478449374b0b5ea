//! All experiments and sweeps that ship begin on a GPU, and the CPU repeats and compares everything that it computes. These tests need
//! Mesa's software driver.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::place::Place;

/// Files that are no experiments and no sweeps.
const OTHERS: [&str; 4] = ["Cargo.toml", "claims.toml", "planned.toml", "study.toml"];

/// Where not all files are tried, every tenth from this one on and [`ALWAYS`], which takes half a minute: users' parts, surrogates, two
/// populations and the foraging study are among them.
const EVERY: usize = 10;
const FIRST: usize = 4;
/// Seconds for the first generations, and runs in the first batches, of which some have unequal worlds. Sweeps of surrogates have a world for each
/// run, and code for each world takes seconds: with fewer runs, the first generation comes earlier.
const ATTEMPTS: [(u32, &str); 5] = [(3, "24"), (10, "24"), (30, "24"), (256, "2"), (1800, "1")];
/// Its batches have worlds of 2 to 40 robots.
const UNEQUAL: &str = "odowd2014-density.toml";
const ALWAYS: [&str; 2] = [UNEQUAL, "predator-prey.toml"];

/// All experiments and sweeps, in order.
fn files() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut folders = vec![root.join("experiments"), root.join("studies")];
    let mut files = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "toml") {
                files.push(path.canonicalize().unwrap());
            }
        }
    }
    files.retain(|path| !OTHERS.iter().any(|other| path.ends_with(other)));
    files.sort();
    files
}

/// Lets a sweep run until its first generations have been compared. Returns how many were.
fn compared(place: &Place, sweep: &str, out: &str) -> u64 {
    for (seconds, jobs) in ATTEMPTS {
        let budget = format!("{seconds}s");
        let ran = place.run(
            &[
                &[
                    "sweep",
                    "run",
                    sweep,
                    "--out",
                    out,
                    "--yes",
                    "--jobs",
                    jobs,
                    "--time-budget",
                    &budget,
                ][..],
                &["--backend", "gpu:llvmpipe", "--recheck", "1"],
            ]
            .concat(),
        );
        let ran = if ran.code == Some(75) {
            ran.says(&["stopped"])
        } else {
            ran.exits(0)
        };
        assert!(
            !ran.stderr.contains("results of this device"),
            "{sweep}: {}",
            ran.stderr
        );
        let status = place.good(&["sweep", "status", out, "--json"]);
        let status: serde_json::Value = serde_json::from_str(&status).unwrap();
        let generations = status["shards"][0]["generations"].as_u64().unwrap();
        let generations = generations + status["done"].as_u64().unwrap();
        if generations > 0 {
            return generations;
        }
    }
    panic!("{sweep}: nothing was compared in half an hour");
}

#[test]
fn all_that_ships_begins_on_a_gpu_as_on_the_cpu() {
    let is_long = std::env::var_os("ONEIRO_LONG").is_some();
    let place = Place::new("gpu");
    let began = Instant::now();
    let (all, mut tried) = (files(), 0);
    // All take an hour and a half: a file's name begins with it.
    let first = std::env::var("ONEIRO_FROM").unwrap_or_default();
    let skipped = all.iter().take_while(|path| !path.ends_with(&first)).count();
    let skipped = if first.is_empty() { 0 } else { skipped };
    for (number, path) in all.iter().enumerate() {
        let name = path.file_name().unwrap().to_str().unwrap();
        if number < skipped || !is_long && number % EVERY != FIRST && !ALWAYS.contains(&name) {
            continue;
        }
        let shown = path.display().to_string();
        let is_sweep = fs::read_to_string(path)
            .unwrap()
            .lines()
            .any(|line| line.starts_with("experiment = "));
        let sweep = if is_sweep {
            shown
        } else {
            let sweep = format!("sweep-{number}.toml");
            // Shorter, as a swarm's generation takes minutes; a race's first generation is a third of its budget.
            let text = fs::read_to_string(path).unwrap();
            let has = |table: &str| text.lines().any(|line| line.starts_with(table));
            let mut set = String::from("[set]\n");
            if !has("[swarm") {
                set += "cycles = 100\n";
            }
            if has("[evolution.race]") {
                set += "evolution.race.lives = 2_000\n";
            }
            place.write(&sweep, format!("experiment = {shown:?}\nseeds = \"1..2\"\n{set}"));
            sweep
        };
        let began = Instant::now();
        let generations = compared(&place, &sweep, &format!("out-{number}"));
        println!("{name}: {generations} generations compared, {:.1?}", began.elapsed());
        tried += 1;
    }
    println!("{tried} of {} files, {:.0?}", all.len(), began.elapsed());
    assert!(all.len() > 50 && tried > 6, "{tried} of {}", all.len());
}

/// A sweep of unequal swarms has the CPU's tables, by everything that a GPU computes.
#[test]
fn unequal_swarms_have_the_same_tables() {
    let is_long = std::env::var_os("ONEIRO_LONG").is_some();
    let place = Place::new("unequal");
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../experiments/sweeps")
        .join(UNEQUAL);
    let text = fs::read_to_string(&path).unwrap();
    let folder = path.parent().unwrap().parent().unwrap().canonicalize().unwrap();
    let minutes = if is_long { 12 } else { 1 };
    let mut shortened = text.clone();
    for (before, after) in [
        ("\"../", format!("\"{}/", folder.display())),
        // With fewer, the batches leave no larger world's words behind.
        ("\"1..10\"", "\"1..3\"".to_owned()),
        ("[set]", format!("[set]\nswarm.minutes = {minutes}")),
    ] {
        assert!(shortened.contains(before), "{text}");
        shortened = shortened.replacen(before, &after, 1);
    }
    place.write("density.toml", shortened);
    let swept = |out: &str, device: &[&str]| {
        let began = Instant::now();
        place.good(&[&["sweep", "run", "density.toml", "--out", out], device].concat());
        println!("{out}: {:.1?}", began.elapsed());
        ["results.csv", "generations.csv"].map(|file| place.read(Path::new(out).join(file)))
    };
    let here = swept("cpu", &["--backend", "cpu"]);
    let there = swept("gpu", &["--backend", "gpu:llvmpipe", "--recheck", "1"]);
    assert!(here == there, "the tables differ");
    assert!(place.text("gpu/results.csv").lines().count() > 45);
}
