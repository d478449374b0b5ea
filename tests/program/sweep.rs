//! Sweeps through the program: the same bytes however they are done and whatever interrupts them, and clear messages
//! for what can't be done.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Child;
use std::thread;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::fixtures::copy;
use crate::place::{Place, Ran, wait_for};

mod answers;
mod bytes;
mod damages;
#[cfg(all(target_os = "linux", target_env = "gnu"))]
mod disks;
mod lives;
mod partial;
#[cfg(unix)]
mod processes;
mod refusals;
mod runs;

const EXPERIMENT: &str = "
    cycles = 40
    [evolution]
    population = 20
    parents = 4
    generations = 12
    finalists = 3
    finalist_lives = 5
";

/// Twelve runs in four cells.
const SWEEP: &str = r#"
    name = "twelve"
    experiment = "small.toml"
    seeds = "1..3"
    [set]
    task.speed = "signed"
    [grid]
    noise.sensor = [[0.0, 0.0], [0.0, 0.4]]
    evolution.population = [20, 40]
"#;

/// Eight equally long runs; with three hundred generations, one processor takes a second or two for all.
fn long(generations: u32) -> String {
    format!(
        r#"
        experiment = "small.toml"
        seeds = "1..4"
        [set]
        cycles = 500
        evolution.population = 40
        evolution.generations = {generations}
        [grid]
        noise.motor = [0.0, 0.1]
        "#
    )
}
const LONG_RUNS: u64 = 8;

/// Tables of a sweep.
const TABLES: [&str; 2] = ["results.csv", "generations.csv"];

/// Contents of a directory: each file's path in it, and its bytes.
type Files = BTreeMap<PathBuf, Vec<u8>>;

fn files(directory: &Path) -> Files {
    let mut found = Files::new();
    let mut left = vec![directory.to_owned()];
    while let Some(next) = left.pop() {
        for entry in fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                left.push(path);
            } else {
                let name = path.strip_prefix(directory).unwrap().to_owned();
                found.insert(name, fs::read(path).unwrap());
            }
        }
    }
    found
}

/// A file of a shard's journal in a sweep's directory.
fn journal(out: &str, file: &str) -> PathBuf {
    Path::new(out).join("shard-1-of-1").join(file)
}

/// Command that does a sweep.
fn sweep<'a>(out: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let run = ["sweep", "run", "sweep.toml", "--out", out, "--json"];
    let cpu = ["--backend", "cpu"];
    let backend = if more.contains(&"--backend") { &[][..] } else { &cpu };
    [&run[..], backend, more].concat()
}

fn hash(output: &str) -> String {
    let output: Value = serde_json::from_str(output).unwrap();
    output["hash"].as_str().unwrap().to_owned()
}

impl Place {
    /// A place with an experiment and a sweep of it.
    fn with_sweep(name: &str, sweep: &str) -> Self {
        let place = Self::new(name);
        place.write("small.toml", EXPERIMENT);
        place.write("sweep.toml", sweep);
        place
    }

    /// Does a sweep to its end, and returns the hash of its tables.
    #[track_caller]
    fn swept(&self, out: &str, more: &[&str]) -> String {
        hash(&self.good(&sweep(out, more)))
    }

    /// JSON output of a command that must succeed.
    #[track_caller]
    fn data(&self, arguments: &[&str]) -> Value {
        let output = self.good(&[arguments, &["--json"]].concat());
        serde_json::from_str(&output).unwrap()
    }

    /// Number of runs that a sweep has done.
    fn done(&self, out: &str) -> u64 {
        if self.at(out).join("sweep.json").exists() {
            self.data(&["sweep", "status", out])["done"].as_u64().unwrap()
        } else {
            0
        }
    }

    #[track_caller]
    fn assert_same_tables(&self, one: &str, other: &str) {
        for table in TABLES {
            let of = |sweep: &str| self.read(Path::new(sweep).join(table));
            assert!(of(one) == of(other), "{table} of {one} and {other} differ");
        }
    }

    /// Rows of a table, with its header first.
    fn rows(&self, table: impl AsRef<Path>) -> Vec<Vec<String>> {
        let text = self.text(table);
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .from_reader(text.as_bytes());
        reader
            .records()
            .map(|row| row.unwrap().iter().map(str::to_owned).collect())
            .collect()
    }

    /// A column of a table, by name.
    fn column(&self, table: impl AsRef<Path>, name: &str) -> Vec<String> {
        let rows = self.rows(table);
        let column = rows[0].iter().position(|head| head == name).unwrap();
        rows[1..].iter().map(|row| row[column].clone()).collect()
    }
}

impl Place {
    /// A stopped sweep resumes from its newest checkpoint without a warning, and ends like the one in `known`.
    fn assert_goes_on(&self, out: &str, more: &[&str]) {
        let newest = self.checkpoints(journal(out, "")).remove(0);
        let name = newest.file_name().unwrap();
        copy(&self.at(out), &self.at("forged"));
        let line = self
            .forge(&journal("forged", "").join(name), "known")
            .expect("runs are in progress");
        self.swept("forged", more);
        let rows = self.text("forged/generations.csv");
        assert!(
            rows.contains(&line),
            "what {} of {out} holds is done again",
            name.display()
        );
        fs::remove_dir_all(self.at("forged")).unwrap();

        let ran = self.run(&sweep(out, more)).exits(0);
        assert!(!ran.stderr.contains("warning"), "{}", ran.stderr);
        self.assert_same_tables("known", out);
    }

    /// Whether a checkpoint of a sweep, whose results are in `known`, holds a finished generation.
    fn has_generations(&self, out: &str, checkpoint: &Path) -> bool {
        copy(&self.at(out), &self.at("copy"));
        let copied = journal("copy", "").join(checkpoint.file_name().unwrap());
        let has_some = self.forge(&copied, "known").is_some();
        fs::remove_dir_all(self.at("copy")).unwrap();
        has_some
    }

    /// Changes the first line of a run's generations in a checkpoint, and the checkpoint's hash with it: the line can
    /// only reach the results from this checkpoint. `None` if no generation has finished yet.
    fn forge(&self, checkpoint: &Path, known: &str) -> Option<String> {
        let bytes = self.read(checkpoint);
        let (content, hash) = bytes.split_last_chunk::<32>().unwrap();
        assert!(blake3::hash(content) == *hash, "{}", checkpoint.display());
        let rows = self.rows(Path::new(known).join("generations.csv"));
        let mut first = rows
            .iter()
            .filter(|row| row[1] == "0")
            .map(|row| row[1..].join(",") + "\n");
        let (at, line) = first.find_map(|line| {
            let at = content.windows(line.len()).position(|here| here == line.as_bytes())?;
            Some((at, line))
        })?;
        // The last digit of the best score's bits.
        let last = line.len() - 2;
        let other = if line.as_bytes()[last] == b'0' { "1" } else { "0" };
        let line = format!("{}{other}\n", &line[..last]);
        let mut content = content.to_vec();
        content[at..at + line.len()].copy_from_slice(line.as_bytes());
        let hash = blake3::hash(&content);
        self.write(checkpoint, [&content, &hash.as_bytes()[..]].concat());
        Some(line)
    }
}

/// Outcome of repeated kills.
#[derive(Debug, Default)]
struct Killed {
    /// Processes that finished before they were killed.
    misses: u32,
    /// Processes that resumed runs.
    resumed: u32,
    /// Total runs done.
    runs: u64,
}

impl Place {
    /// Kills a sweep in `killed` again and again, at moments up to the longest, at least so often and until a process
    /// has resumed it. Whenever it finishes, it must equal the known one, and starts over; the processes after it get
    /// less time, since the machine has become faster. While none has resumed it after so many kills, they get more.
    fn killed(&self, arguments: &[&str], kills: u32, mut longest: Duration, known: &str) -> Killed {
        let mut killed = Killed::default();
        // Multiples of the golden section cover all parts of an interval evenly.
        let mut moments = std::iter::successors(Some(0.0), |moment| Some((moment + 0.618_034) % 1.0));
        let mut done = 0;
        while done < kills || (killed.resumed == 0 && done < 10 * kills) {
            let mut child = self.start(arguments);
            thread::sleep(longest.mul_f64(moments.next().unwrap()));
            child.kill().unwrap();
            let ran = ended(arguments, child);
            killed.resumed += u32::from(ran.stderr.contains("already done"));
            if ran.code.is_none() {
                done += 1;
                if done >= kills {
                    longest = longest.mul_f64(1.1);
                }
            } else {
                ran.exits(0);
                killed.misses += 1;
                longest = longest.mul_f64(0.9);
            }
            if self.at("killed/generations.csv").exists() {
                self.assert_same_tables(known, "killed");
                killed.runs += self.done("killed");
                fs::remove_dir_all(self.at("killed")).unwrap();
            }
        }
        killed.runs += self.done("killed");
        killed
    }
}

/// Whether more than a few seconds are available: in `tests/long.sh`.
fn is_long() -> bool {
    std::env::var_os("ONEIRO_LONG").is_some()
}

/// Outcome of a process that was started with pipes.
fn ended(arguments: &[&str], child: Child) -> Ran {
    Ran::ended(arguments, child)
}
