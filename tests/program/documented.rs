//! Whatever a page, an experiment or the program tells a user to type is typed here, in a fresh folder; and what pages name
//! and show is there. `docs/testing.md` says how a block is marked that can't run.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

mod messages;
mod pages;
#[path = "../scratch/mod.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod scratch;
mod shown;
mod typed;

use crate::fixtures::copy;
use crate::place::Place;
use crate::skips::skipped;
use typed::Block;

/// Why a block is parsed and not run: the word after its language.
const REASONS: [(&str, &str); 7] = [
    ("robot", "a robot"),
    ("computers", "other computers, by ssh"),
    ("cluster", "a cluster's scheduler"),
    ("system", "changes to the system"),
    ("nvidia", "an NVIDIA card and its makers' tools"),
    ("others", "files of others"),
    ("hours", "hours"),
];

/// Parts of pages, and what is typed instead unless `ONEIRO_LONG` is set.
const SHORTER: [(&str, &str, &str); 15] = [
    ("docs/swarms.md", "--generations 0,5,29", "--generations 0,1"),
    (
        "docs/classics/discrimination.md",
        "--seeds 1..10 --set evolution.generations=750",
        "--seeds 1..2 --set evolution.generations=2",
    ),
    (
        "docs/classics/discrimination.md",
        "--set evolution.generations=60",
        "--set evolution.generations=2",
    ),
    (
        "docs/extend.md",
        "oneiro run corridor.toml",
        "oneiro run corridor.toml --set evolution.generations=2",
    ),
    (
        "docs/measurements.md",
        "gather.toml --seeds 1..5",
        "gather.toml --seeds 1..2 --set evolution.generations=2",
    ),
    (
        "docs/measurements.md",
        "--set evolution.finalists=0",
        "--set evolution.finalists=0 --set evolution.generations=2",
    ),
    ("docs/optimisers-compared.md", "--trials 200", "--trials 2"),
    (
        "docs/swarms.md",
        "gather.toml --seed 1",
        "gather.toml --seed 1 --set evolution.generations=2",
    ),
    (
        "docs/evostick.md",
        "--set evolution.race.lives=2000",
        "--set evolution.race.lives=300",
    ),
    (
        "docs/evostick.md",
        "--set evolution.finalist_lives=30",
        "--set evolution.finalist_lives=2",
    ),
    ("docs/evostick.md", "--trials 40", "--trials 2"),
    ("docs/classics/aggregation.md", "--trials 100", "--trials 2"),
    (
        "docs/pucks.md",
        "puck-clustering.toml --seed 1",
        "puck-clustering.toml --seed 1 --set evolution.generations=2",
    ),
    (
        "docs/pucks.md",
        "puck-foraging.toml --seed 1",
        "puck-foraging.toml --seed 1 --set evolution.generations=2",
    ),
    (
        "docs/classics/predator-prey.md",
        "predator-prey.toml --seed 1",
        "predator-prey.toml --seed 1 --set evolution.generations=2",
    ),
];

/// Pictures, the page whose blocks draw them, the file that they draw or draw into, and whether they do only at full length.
const DRAWN: [(&str, &str, &str, bool); 36] = [
    ("docs/champion.svg", "README.md", "runs/*/path.svg", false),
    (
        "docs/learning-curve.svg",
        "README.md",
        "runs/*/learning-curve.svg",
        false,
    ),
    (
        "docs/pictures/swarm.svg",
        "docs/tutorials/swarm-mission.md",
        "swarm.svg",
        false,
    ),
    ("docs/pictures/task-reach.svg", "docs/tasks.md", "reach/path.svg", true),
    ("docs/pictures/task-visit.svg", "docs/tasks.md", "visit/path.svg", true),
    (
        "docs/pictures/task-collect.svg",
        "docs/tasks.md",
        "collect/path.svg",
        true,
    ),
    ("docs/pictures/task-cover.svg", "docs/tasks.md", "cover/path.svg", true),
    (
        "docs/pictures/task-follow-wall.svg",
        "docs/tasks.md",
        "follow-wall/path.svg",
        true,
    ),
    (
        "docs/pictures/task-phototaxis.svg",
        "docs/tasks.md",
        "phototaxis/path.svg",
        true,
    ),
    (
        "docs/pictures/task-follow-line.svg",
        "docs/tasks.md",
        "line/path.svg",
        true,
    ),
    (
        "docs/pictures/task-stay-together.svg",
        "docs/tasks.md",
        "together/path.svg",
        true,
    ),
    (
        "docs/pictures/puck-clustering.svg",
        "docs/pucks.md",
        "clustering.svg",
        true,
    ),
    ("docs/pictures/puck-foraging.svg", "docs/pucks.md", "foraging.svg", true),
    ("docs/pictures/five-starts.svg", "docs/worlds.md", "five.svg", false),
    ("docs/pictures/line-follower.svg", "docs/worlds.md", "line.svg", false),
    ("docs/pictures/map-rooms.svg", "docs/import.md", "rooms.svg", false),
    (
        "docs/evostick-aggregation.svg",
        "docs/evostick.md",
        "aggregation.svg",
        false,
    ),
    ("docs/evostick-coverage.svg", "docs/evostick.md", "coverage.svg", false),
    ("docs/evostick-cues.svg", "docs/evostick.md", "cues.svg", false),
    ("docs/evostick-foraging.svg", "docs/evostick.md", "foraging.svg", false),
    ("docs/evostick-network.svg", "docs/evostick.md", "network.svg", false),
    ("docs/evostick-shelter.svg", "docs/evostick.md", "shelter.svg", false),
    (
        "docs/classics/predator-prey-recent.svg",
        "docs/classics/predator-prey.md",
        "recent/seed-1/tournament.svg",
        true,
    ),
    (
        "docs/classics/predator-prey-hall.svg",
        "docs/classics/predator-prey.md",
        "hall/seed-1/tournament.svg",
        true,
    ),
    (
        "docs/classics/discrimination.svg",
        "docs/classics/discrimination.md",
        "lstm/path.svg",
        true,
    ),
    (
        "docs/classics/kheperax.svg",
        "docs/classics/kheperax.md",
        "kheperax/path.svg",
        true,
    ),
    (
        "docs/classics/phototaxis.svg",
        "docs/classics/phototaxis.md",
        "phototaxis/path.svg",
        true,
    ),
    (
        "docs/classics/road-sign.svg",
        "docs/classics/road-sign.md",
        "road-sign/path.svg",
        true,
    ),
    (
        "docs/classics/light-switching.svg",
        "docs/classics/light-switching.md",
        "light-switching/path.svg",
        true,
    ),
    (
        "docs/classics/wall-following.svg",
        "docs/classics/wall-following.md",
        "wall-following/path.svg",
        true,
    ),
    (
        "docs/sweep-sensor-noise.svg",
        "docs/searches.md",
        "sensor-noise/report.html",
        true,
    ),
    (
        "docs/sweep-conservative-noise.svg",
        "docs/searches.md",
        "conservative-noise/report.html",
        true,
    ),
    (
        "docs/sweep-mutation-scale.svg",
        "docs/searches.md",
        "mutation/report.html",
        true,
    ),
    (
        "docs/sweep-mutation-pairs.svg",
        "docs/searches.md",
        "mutation/report.html",
        true,
    ),
    (
        "docs/sweep-density.svg",
        "docs/searches.md",
        "density/report.html",
        true,
    ),
    (
        "docs/sweep-density-right.svg",
        "docs/searches.md",
        "density-right/report.html",
        true,
    ),
];

/// Whether all is typed unchanged.
fn is_long() -> bool {
    std::env::var_os("ONEIRO_LONG").is_some()
}

/// The path of programs, with the Python that `tests/tools.sh` gives the packages that pages need.
fn with_python() -> String {
    let target = Path::new(env!("CARGO_BIN_EXE_oneiro")).ancestors().nth(2).unwrap();
    let own = target.join("python-sweeps/bin");
    format!("{}:{}", own.display(), std::env::var("PATH").unwrap_or_default())
}

/// A folder as a user has it: the repository's files that commands name, with shorter experiments, and the program.
struct Desk {
    place: Place,
}

impl Desk {
    fn new(name: &str, is_short: bool) -> Self {
        let place = Place::new(name);
        let root = typed::root();
        for folder in ["experiments", "docs", "benches", "studies"] {
            copy(&root.join(folder), &place.at(folder));
        }
        let programs = place.at("bin");
        fs::create_dir(&programs).unwrap();
        // A link would be slower to find its neighbours; the program needs none.
        #[cfg(unix)]
        std::os::unix::fs::symlink(env!("CARGO_BIN_EXE_oneiro"), programs.join("oneiro")).unwrap();
        if is_short {
            shorten(&place.at("experiments"));
            shorten(&place.at("studies"));
        }
        Self { place }
    }

    /// Types a script into a shell that stops at the first command that fails. Returns the processor time that its commands took, in
    /// the shell's words, or what it said.
    fn types(&self, folder: &str, script: &str) -> Result<String, String> {
        let script = format!("set -x\n{script}\n{{ set +x; }} 2>/dev/null; times >&2\n");
        let output = self.shell(folder, &script)?;
        let said = String::from_utf8_lossy(&output.stderr);
        Ok(said.lines().next_back().unwrap_or_default().to_owned())
    }

    /// As [`Desk::types`], and returns what its commands print, errors and data in their order.
    fn prints(&self, script: &str) -> Result<String, String> {
        let output = self.shell(".", &format!("exec 2>&1\n{script}"))?;
        // A busy machine says what takes long.
        let is_shown = |line: &&str| !line.trim_end().ends_with(" s so far");
        let text = String::from_utf8_lossy(&output.stdout);
        Ok(text.split_inclusive('\n').filter(is_shown).collect())
    }

    fn shell(&self, folder: &str, script: &str) -> Result<Output, String> {
        let script = script.replace("cargo run --release -- ", "oneiro ");
        let path = with_python();
        let output = Command::new("bash")
            .args(["-euo", "pipefail", "-c", &script])
            .current_dir(self.place.at(folder))
            .env("PATH", format!("{}:{path}", self.place.at("bin").display()))
            .env("XDG_CACHE_HOME", cache())
            .env_remove("SLURM_ARRAY_TASK_ID")
            .stdin(Stdio::null())
            .output()
            .map_err(|error| format!("there is no bash: {error}"))?;
        if output.status.success() {
            return Ok(output);
        }
        let said = [&output.stdout[..], &output.stderr[..]].concat();
        let said = String::from_utf8_lossy(&said);
        let last: Vec<&str> = said.lines().rev().take(12).collect();
        let last: Vec<&str> = last.into_iter().rev().collect();
        Err(format!("{:?}\n{}", output.status.code(), last.join("\n")))
    }
}

/// One for all kernels that are compiled here.
fn cache() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("documented-cache")
}

/// Makes all experiments and sweeps of a folder short: fewer generations, cycles, lives and seeds, and nothing else is changed.
fn shorten(folder: &Path) {
    for entry in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if entry.is_dir() {
            shorten(&entry);
        } else if entry.extension().is_some_and(|extension| extension == "toml") && !is_quick(&entry) {
            let text = fs::read_to_string(&entry).unwrap();
            let lines = text
                .lines()
                .map(|line| first_seed(line).unwrap_or_else(|| shorter(line)));
            fs::write(&entry, lines.collect::<Vec<_>>().join("\n") + "\n").unwrap();
        }
    }
}

/// Whether an experiment or a sweep takes no time unchanged.
fn is_quick(path: &Path) -> bool {
    path.ends_with("sweeps/small.toml") || path.ends_with("khepera-avoidance.toml")
}

/// A sweep's line of seeds with the first alone.
fn first_seed(line: &str) -> Option<String> {
    let first = line.strip_prefix("seeds = \"")?.split("..").next()?;
    Some(format!("seeds = [{first}]"))
}

/// A line of an experiment or a sweep, with at most so many of what takes time.
fn shorter(line: &str) -> String {
    const MOST: [(&str, u64); 9] = [
        ("generations", 2),
        ("evolution.generations", 2),
        ("finalist_lives", 2),
        ("evolution.finalist_lives", 2),
        ("lives", 300),
        ("evolution.race.lives", 300),
        ("reality.generations", 1),
        ("cycles", 300),
        ("trials", 2),
    ];
    let Some((key, value)) = line.split_once('=') else {
        return line.to_owned();
    };
    let Some((_, most)) = MOST.iter().find(|(own, _)| *own == key.trim()) else {
        return line.to_owned();
    };
    // One, or the only one of a list.
    let value = value.split('#').next().unwrap_or_default();
    let number = value
        .trim()
        .trim_start_matches('[')
        .trim_end_matches(']')
        .replace('_', "");
    match number.parse::<u64>() {
        Ok(number) if number > *most => line.replace(value.trim().trim_matches(['[', ']']), &most.to_string()),
        _ => line.to_owned(),
    }
}

/// How the test uses a block.
enum Use {
    Run,
    /// By `tests/long.sh` alone.
    Long,
    /// Not at all, since it needs something else.
    Needs,
    /// By another test, in this file.
    Elsewhere(String),
    /// If Python has these modules.
    Modules(String),
}

impl Use {
    fn of(block: &Block) -> Result<Self, String> {
        match block.info.get(1).map(String::as_str) {
            None => Ok(Self::Run),
            Some("long") => Ok(Self::Long),
            Some(word) => {
                if REASONS.iter().any(|(reason, _)| *reason == word) {
                    return Ok(Self::Needs);
                }
                match word.split_once('=') {
                    Some(("tested", file)) => Ok(Self::Elsewhere(file.to_owned())),
                    Some(("needs", modules)) => Ok(Self::Modules(modules.to_owned())),
                    _ => Err(format!(
                        "`{word}` is no reason; allowed: {REASONS:?}, long, tested=FILE, needs=MODULES"
                    )),
                }
            }
        }
    }
}

/// A page that connects to a robot: it is typed among the tests in real time.
const WITH_ROBOT: &str = "docs/tutorials/first-drive.md";

/// Types all blocks of a page, one after another, into one folder.
fn type_page(page: &str) -> Result<(), String> {
    let text = typed::text(Path::new(page));
    let (blocks, _) = typed::blocks(&text);
    let is_whole = is_long() || shown::shows(page);
    let desk = Desk::new(&page.replace(['/', '.'], "-"), !is_whole);
    for block in &blocks {
        for word in &block.info {
            if let Some(name) = word.strip_prefix("file=") {
                let lines = block
                    .text
                    .lines()
                    .map(|line| if is_whole { line.to_owned() } else { shorter(line) });
                desk.place.write(name, lines.collect::<Vec<_>>().join("\n") + "\n");
            }
        }
    }
    let mut printed = Vec::new();
    for (index, block) in blocks.iter().enumerate() {
        let Some(script) = block.script() else { continue };
        let at = |problem: String| format!("{page}:{}: {problem}", block.line);
        match Use::of(block).map_err(at)? {
            Use::Run => {}
            Use::Long if is_long() => {}
            Use::Long | Use::Needs => continue,
            Use::Elsewhere(file) => {
                if !typed::root().join(&file).exists() {
                    return Err(at(format!("there is no {file}")));
                }
                continue;
            }
            Use::Modules(modules) => {
                let has = Command::new("python3")
                    .args(["-c", &format!("import {modules}")])
                    .env("PATH", with_python())
                    .output();
                if !has.is_ok_and(|output| output.status.success()) {
                    skipped("python", &format!("{page}:{}, which needs {modules}", block.line));
                    continue;
                }
            }
        }
        if let (true, Some(text)) = (shown::shows(page), shown::of(&text, &blocks, index)) {
            printed.push((text, desk.prints(&script).map_err(at)?));
            continue;
        }
        let took = desk.types(".", &short(page, &script)).map_err(at)?;
        eprintln!("{page}:{}: {took}", block.line);
    }
    scratch::holds(&typed::root().join(page), &shown::renewed(&text, &printed))?;
    drawn(page, &desk)
}

/// A page's script with what is shorter.
fn short(page: &str, script: &str) -> String {
    let mut script = script.to_owned();
    if !is_long() {
        for (_, long, short) in SHORTER.iter().filter(|(own, _, _)| *own == page) {
            script = script.replace(long, short);
        }
    }
    script
}

/// Compares the pictures that a page's blocks have drawn with those that are shown.
fn drawn(page: &str, desk: &Desk) -> Result<(), String> {
    for (picture, _, file, _) in DRAWN
        .iter()
        .filter(|(_, own, _, long)| *own == page && (is_long() || !long))
    {
        let shown = typed::text(Path::new(picture));
        let mut path = desk.place.at(file);
        if let Some((folder, name)) = file.split_once("/*/") {
            let mut folders = fs::read_dir(desk.place.at(folder)).map_err(|error| format!("{folder}: {error}"))?;
            let (only, next) = (folders.next(), folders.next());
            let (Some(only), None) = (only, next) else {
                return Err(format!("{page}: {folder} has not one run"));
            };
            path = only.unwrap().path().join(name);
        }
        let drawn = fs::read_to_string(&path).map_err(|error| format!("{page}: {}: {error}", path.display()))?;
        // A report has its pictures in it.
        if !drawn.contains(shown.trim_end()) {
            let new = Path::new(env!("CARGO_TARGET_TMPDIR")).join(path.file_name().unwrap());
            fs::write(&new, drawn).unwrap();
            return Err(format!(
                "{picture} is not what the blocks of {page} draw; that is now {}",
                new.display()
            ));
        }
    }
    Ok(())
}

/// The pages with something to type.
fn typed_pages() -> Vec<String> {
    let pages = typed::files(&["md"]).into_iter().map(|path| path.display().to_string());
    let has = |page: &String| {
        typed::blocks(&typed::text(Path::new(page)))
            .0
            .iter()
            .any(|block| block.script().is_some())
    };
    pages.filter(|page| page != "CHANGELOG.md" && has(page)).collect()
}

/// Runs work of several kinds on two threads, and fails with all that went wrong.
fn each(all: &[String], work: impl Fn(&str) -> Result<(), String> + Sync) {
    use rayon::prelude::*;
    let wrong: Vec<String> = all.par_iter().filter_map(|one| work(one).err()).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

#[test]
fn pages() {
    let pages = typed_pages();
    assert!(pages.len() > 15, "{pages:?}");
    for (page, long, _) in SHORTER {
        let (blocks, _) = typed::blocks(&typed::text(Path::new(page)));
        assert!(
            blocks
                .iter()
                .any(|block| block.script().is_some_and(|script| script.contains(long))),
            "{page}: {long}"
        );
    }
    let others: Vec<String> = pages.iter().filter(|page| *page != WITH_ROBOT).cloned().collect();
    assert!(others.len() < pages.len());
    each(&others, type_page);
}

/// The page that connects to a robot.
pub(crate) fn type_page_with_robot() {
    type_page(WITH_ROBOT).unwrap_or_else(|problem| panic!("{problem}"));
}

/// The commands in the comments at the head of each experiment and sweep, from the folder that they name files from.
#[test]
fn heads_of_experiments() {
    let files = typed::files(&["toml"])
        .into_iter()
        .map(|path| path.display().to_string());
    let files: Vec<String> = files
        .filter(|path| path.starts_with("experiments/") || path.starts_with("studies/"))
        .collect();
    let commands = |path: &str| -> Vec<String> {
        let text = typed::text(Path::new(path));
        let comments = text.lines().filter_map(|line| line.strip_prefix("#     "));
        comments
            .filter(|line| line.starts_with("oneiro "))
            .map(str::to_owned)
            .collect()
    };
    let mut with_commands: Vec<String> = files
        .iter()
        .filter(|path| !commands(path).is_empty())
        .cloned()
        .collect();
    assert!(with_commands.len() > 30, "{with_commands:?}");
    with_commands.retain(|path| is_long() || !COSTLY.iter().any(|costly| path.contains(costly)));
    each(&with_commands, |path| {
        let is_short = !is_long() || HOURS.iter().any(|hours| path.contains(hours));
        let desk = Desk::new(&path.replace(['/', '.'], "-"), is_short);
        let folder = Path::new(path).parent().unwrap().display().to_string();
        let mut typed = commands(path);
        if is_short {
            // A sweep is checked, cell by cell.
            if typed.iter().any(|command| command.starts_with("oneiro sweep")) && !path.ends_with("small.toml") {
                typed.retain(|command| command.starts_with("oneiro sweep run"));
                for command in &mut typed {
                    let words: Vec<&str> = command.split(' ').collect();
                    *command = format!("oneiro sweep plan {} --no-estimate", words[3]);
                }
            }
        }
        let script = typed.join("\n");
        let folder = if script.contains("experiments/") || script.contains("studies/") {
            "."
        } else {
            &folder
        };
        let took = desk
            .types(folder, &script)
            .map_err(|problem| format!("{path}: {problem}"))?;
        eprintln!("{path}: {took}");
        Ok(())
    });
}

/// Parts of the paths of files whose commands take hours: `tests/long.sh` also shortens them.
const HOURS: [&str; 5] = [
    "/evostick",
    "/automode",
    "/pseudo-reality",
    "/miglino1995/",
    "/odowd2014/",
];

/// Parts of the paths of files left out unless `ONEIRO_LONG` is set: checking one takes seconds, and pages run others like them. Their
/// commands are parsed all the same (`host/src/cli/documented.rs`).
const COSTLY: [&str; 3] = ["/evostick-", "/automode-", "/miglino1995/"];

/// Robots that ship.
const ROBOTS: [&str; 6] = ["khepera", "epuck", "thymio2", "kheperax", "epuck-rm1.1", "epuck-rm1.2"];

/// What `oneiro new` writes fits a screen, and is the same experiment as with all keys: it has the same results.
#[test]
fn short_experiments_are_the_whole_ones() {
    let [short, whole] = ["new-short", "new-whole"].map(|name| Desk::new(name, false));
    let parts = ["--sensor", "eyes", "--controller", "brain", "--task", "goal"];
    let mut variants: Vec<Vec<&str>> = vec![
        vec![],
        vec!["--swarm"],
        vec!["--forager"],
        parts[..2].to_vec(),
        parts[2..4].to_vec(),
        parts[4..].to_vec(),
        parts.to_vec(),
        [&["--swarm"], &parts[..]].concat(),
        [&["--forager"], &parts[2..]].concat(),
        [&["--robot", "epuck"], &parts[..]].concat(),
    ];
    for robot in ROBOTS {
        variants.push(vec!["--robot", robot]);
        if robot != "kheperax" {
            variants.push(vec!["--swarm", "--robot", robot]);
        }
    }
    let mut results = BTreeSet::new();
    for (number, words) in variants.iter().enumerate() {
        let folder = format!("variant-{number}");
        let result = |desk: &Desk, more: &[&str]| {
            let place = &desk.place;
            place.good(&[&["new", "mine", "--out", &folder], &words[..], more].concat());
            let path = format!("{folder}/mine.toml");
            let checked = place.run(&["check", &path]).exits(0);
            assert!(!checked.stderr.contains("warning"), "{words:?}: {}", checked.stderr);
            let out = format!("{folder}/run");
            let set = [
                "cycles=60",
                "evolution.generations=2",
                "evolution.finalists=0",
                "trials=1",
            ];
            let set = set.iter().flat_map(|set| ["--set", set]);
            let run: Vec<&str> = ["run", &path, "--seed", "1", "--out", &out, "--backend", "cpu"]
                .into_iter()
                .chain(set)
                .collect();
            place.good(&run);
            let verified = place.good(&["verify", &out]);
            verified.split_whitespace().next().unwrap().to_owned()
        };
        let [one, other] = [result(&short, &[]), result(&whole, &["--all-keys"])];
        assert_eq!(one, other, "{words:?}");
        results.insert(one);
        let [short, whole] = [&short, &whole].map(|desk| desk.place.text(format!("{folder}/mine.toml")));
        assert!(short.lines().count() <= 30, "{words:?}: {short}");
        assert!(short.lines().all(|line| line.len() <= 118), "{words:?}: {short}");
        assert!(
            short.contains("`oneiro new --keys`") && short.contains("--all-keys"),
            "{short}"
        );
        for key in ["name", "generations", "population"] {
            assert!(short.contains(&format!("\n{key} = ")), "{words:?} {key}: {short}");
        }
        for table in ["robot", "arena", "controller", "task", "evolution"] {
            assert!(short.contains(&format!("\n[{table}]\n")), "{words:?} {table}: {short}");
        }
        assert!(whole.lines().count() > 300, "{words:?}");
    }
    short
        .place
        .run(&["new", "fast", "--swarm", "--robot", "kheperax"])
        .exits(3)
        .says(&["--robot kheperax: is too fast for a swarm"]);
    // `--swarm` has the robot epuck-rm1.1, and `--robot epuck-rm1.1` and `epuck-rm1.2` are swarms.
    assert_eq!(results.len(), variants.len() - 3, "{results:?}");
}

/// What `oneiro new` writes and prints can be typed.
#[test]
fn new_experiments() {
    let desk = Desk::new("new", false);
    let place = &desk.place;
    let mut variants: Vec<Vec<&str>> = vec![
        vec!["plain"],
        vec!["swarm", "--swarm"],
        vec!["forager", "--forager"],
        vec!["sensor", "--sensor", "own-sensor"],
        vec!["controller", "--controller", "own-controller"],
        vec!["task", "--task", "own-task"],
        vec!["whole", "--all-keys"],
        vec!["whole-swarm", "--swarm", "--all-keys"],
    ];
    variants.extend(ROBOTS.map(|robot| vec![robot, "--robot", robot]));
    for words in variants {
        let ran = place.run(&[&["new"], &words[..]].concat()).exits(0);
        let name = format!("{}.toml", words[0]);
        let (_, next) = ran.stderr.split_once("next: ").unwrap();
        let next: Vec<&str> = next.trim().split(", then ").collect();
        assert_eq!(next, [format!("oneiro check {name}"), format!("oneiro run {name}")]);
        let text = place.text(&name);
        let head: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("#     ")).collect();
        assert_eq!(head, [format!("oneiro run {name} --seed 1")], "{name}");
        if !is_long() {
            let lines: Vec<String> = text.lines().map(shorter).collect();
            place.write(&name, lines.join("\n") + "\n");
        }
        for command in [next, head].concat() {
            desk.types(".", command)
                .unwrap_or_else(|problem| panic!("{command}: {problem}"));
        }
        // A second time, as long as nothing was changed; afterwards it is refused.
        place.write(&name, &text);
        place
            .run(&[&["new"], &words[..]].concat())
            .exits(0)
            .says(&["is already there"]);
        place.write(&name, text + "# changed\n");
        place
            .run(&[&["new"], &words[..]].concat())
            .exits(3)
            .says(&["nothing is overwritten"]);
    }
}

#[test]
fn tables_are_well_formed() {
    let mut wrong = Vec::new();
    let mut tables = 0;
    for path in typed::files(&["md"]) {
        let (count, problems) = pages::tables(&typed::text(&path));
        tables += count;
        wrong.extend(
            problems
                .into_iter()
                .map(|problem| format!("{}:{problem}", path.display())),
        );
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(tables > 150, "{tables}");
}

#[test]
fn links_lead_somewhere() {
    let texts: BTreeMap<PathBuf, String> = typed::files(&["md"])
        .into_iter()
        .map(|path| (path.clone(), typed::text(&path)))
        .collect();
    let mut wrong = Vec::new();
    let mut links = 0;
    for (path, text) in &texts {
        for (line, target) in pages::links(text) {
            links += 1;
            if let Err(problem) = pages::resolves(&texts, path, &target) {
                wrong.push(format!("{}:{line}: {target}: {problem}", path.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(links > 300, "{links}");
}

/// Paths, and sources by their names alone, that pages name in code.
#[test]
fn named_files_are_there() {
    let sources: Vec<String> = typed::files(&["rs", "wgsl", "sh", "py", "js"])
        .iter()
        .map(|path| format!("/{}", path.display()))
        .collect();
    let mut wrong = Vec::new();
    let mut named = 0;
    for (place, span) in typed::spans() {
        for name in span.split_whitespace() {
            let Some(is_there) = pages::is_there(&sources, name) else {
                continue;
            };
            named += 1;
            if !is_there {
                wrong.push(format!("{place}: {name}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(named > 300, "{named}");
}

/// Traits that pages tell to implement are defined, and where they say.
#[test]
fn named_traits_are_there() {
    let sources: Vec<(String, String)> = typed::files(&["rs"])
        .iter()
        .map(|path| (path.display().to_string(), typed::text(path)))
        .collect();
    let mut wrong = Vec::new();
    let mut named = BTreeSet::new();
    for path in typed::files(&["md"])
        .into_iter()
        .filter(|path| !path.ends_with("CHANGELOG.md"))
    {
        for (name, place) in pages::traits(&typed::text(&path)) {
            let is_here = |(own, text): &&(String, String)| {
                own.starts_with(place.as_deref().unwrap_or_default()) && text.contains(&format!("trait {name}"))
            };
            if !sources.iter().any(|source| is_here(&source)) {
                wrong.push(format!("{}: trait {name} of {place:?}", path.display()));
            }
            named.insert(name);
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    for name in ["Robot", "Exchange", "WorldKind", "Optimizer"] {
        assert!(named.contains(name), "{name} in {named:?}");
    }
}

/// Each picture of the documents is shown somewhere, and is drawn by a block that is run, or is listed with the reason.
#[test]
fn pictures_are_drawn_by_what_is_typed() {
    let mut pictures: BTreeSet<String> = BTreeSet::new();
    for extension in ["svg", "png"] {
        let found = typed::files(&[extension])
            .into_iter()
            .map(|path| path.display().to_string());
        pictures.extend(found.filter(|path| path.starts_with("docs/")));
    }
    let mut shown = BTreeSet::new();
    for path in typed::files(&["md"]) {
        let folder = path.parent().unwrap();
        let text = typed::text(&path);
        let own = pages::links(&text)
            .into_iter()
            .map(|(_, target)| pages::joined(folder, &target).display().to_string());
        shown.extend(own.filter(|target| pictures.contains(target)));
    }
    assert_eq!(pictures, shown, "pictures of docs/, and those that pages show");
    let drawn: BTreeSet<String> = DRAWN.iter().map(|(picture, ..)| (*picture).to_owned()).collect();
    let others: BTreeSet<String> = NOT_DRAWN.iter().map(|(picture, _)| (*picture).to_owned()).collect();
    assert!(drawn.is_disjoint(&others));
    assert_eq!(
        pictures,
        drawn.union(&others).cloned().collect(),
        "pictures of docs/, and those of the lists here"
    );
    let typed: BTreeSet<String> = typed_pages().into_iter().collect();
    for (picture, page, ..) in DRAWN {
        assert!(typed.contains(page), "{picture}: {page}");
    }
}

/// Pictures that no block draws, and what they are.
const NOT_DRAWN: [(&str, &str); 7] = [
    ("docs/collision-keep-turn.svg", "drawn by hand"),
    ("docs/collision-slide.svg", "drawn by hand"),
    ("docs/collision-stick.svg", "drawn by hand"),
    ("docs/collision-undo.svg", "drawn by hand"),
    (
        "docs/learning-page.png",
        "a browser's picture of a page: docs/pictures.sh",
    ),
    ("docs/swarms-page.png", "the same"),
    ("docs/watch-page.png", "the same"),
];

/// The package for Python is in no registry: each example says where it is built, and to install what the page of examples lists.
#[test]
fn examples_in_python_say_what_they_need() {
    let page = typed::text(Path::new("docs/python.md"));
    let mut examples = 0;
    for path in typed::files(&["md", "py", "ipynb", "toml"]) {
        let text = typed::text(&path).replace("\\\"", "\"");
        assert!(!text.contains("pip install oneiro"), "{}", path.display());
        if !path.starts_with("python/examples") {
            continue;
        }
        let name = path.file_stem().unwrap().to_string_lossy();
        let (_, needs) = text
            .split_once("`pip install ")
            .unwrap_or_else(|| panic!("{}", path.display()));
        let needs: Vec<&str> = needs
            .split('`')
            .next()
            .unwrap()
            .split(' ')
            .map(|own| own.trim_matches('"'))
            .collect();
        let needs: Vec<&str> = needs.iter().map(|own| own.split(">=").next().unwrap()).collect();
        let row = page
            .lines()
            .find(|line| line.starts_with(&format!("| `{name}` |")))
            .unwrap();
        assert!(
            row.ends_with(&format!("| {} |", needs.join(", "))),
            "{}: {needs:?}, and {row}",
            path.display()
        );
        assert!(text.contains("docs/python.md says"), "{}", path.display());
        examples += 1;
    }
    assert!(examples >= 16, "{examples}");
}

/// Controls: each kind of mistake is found.
#[test]
fn mistakes_in_pages_are_found() {
    let head = "| a | b |\n|---|---|\n| 1 | 2 |\n";
    assert_eq!(pages::tables(&format!("A.\n\n{head}\nB.\n")), (1, Vec::new()));
    for wrong in [
        format!("{head}| 1 |\n"),
        format!("{head}\n| 3 | 4 |\n"),
        format!("{head}| 1 | 2 | 3 |\n"),
        "| a | b |\n| 1 | 2 |\n".to_owned(),
    ] {
        assert_eq!(pages::tables(&wrong).1.len(), 1, "{wrong}");
    }
    assert_eq!(
        pages::tables(&format!("{head}| `a \\| b` | 2 |\n")).1,
        Vec::<String>::new()
    );

    let texts: BTreeMap<PathBuf, String> = [
        ("README.md", "# One\n"),
        ("docs/a.md", "# A page\n\n## What is `this`?\n\n## Twice\n\n## Twice\n"),
    ]
    .map(|(path, text)| (PathBuf::from(path), text.to_owned()))
    .into();
    let from = |page: &str, target: &str| pages::resolves(&texts, Path::new(page), target);
    for right in [
        "a.md",
        "#a-page",
        "a.md#what-is-this",
        "#twice-1",
        "../README.md#one",
        "https://example.org/x",
    ] {
        assert_eq!(from("docs/a.md", right), Ok(()), "{right}");
    }
    for wrong in [
        "b.md",
        "#nothing",
        "a.md#what-is-that",
        "#twice-2",
        "README.md",
        "../docs/none.svg",
    ] {
        assert!(from("docs/a.md", wrong).is_err(), "{wrong}");
    }

    let sources = ["/host/robots/src/lib.rs".to_owned(), "/src/arena.rs".to_owned()];
    for (name, expected) in [
        ("tests/all.sh", Some(true)),
        ("tests/none.sh", Some(false)),
        ("host/src/none/", Some(false)),
        ("host/robots/src/", Some(true)),
        ("host/robots/src/NAME.rs", None),
        ("tests/goldens/kernels/*.rows", None),
        ("robots/src/lib.rs", Some(true)),
        ("arena.rs", Some(true)),
        ("moon.rs", Some(false)),
        ("mine.toml", None),
        ("a/b", None),
    ] {
        assert_eq!(pages::is_there(&sources, name), expected, "{name}");
    }

    let found = pages::traits(
        "the trait `Robot`\n(`host/robots/src/lib.rs`), and an implementation of `Exchange` (`host/lab/src/exchange/`); the trait `Far`.",
    );
    let named = |name: &str, place: Option<&str>| (name.to_owned(), place.map(str::to_owned));
    assert_eq!(
        found,
        [
            named("Robot", Some("host/robots/src/lib.rs")),
            named("Exchange", Some("host/lab/src/exchange/")),
            named("Far", None)
        ]
    );
}

/// Controls: another output than the shown one is noticed, wherever it differs, and nothing else is.
#[test]
fn another_output_is_noticed() {
    const SCRIPT: &str = "oneiro list runs || echo failed\necho 'took 12.5 s at 3.1 M steps/s' >&2\necho best 7\n";
    let desk = Desk::new("shown", false);
    let page = |output: &str| {
        format!("# A page\n\n```sh\n{SCRIPT}```\n\n```text\n{output}```\n\nNow:\n\n```text\nno output\n```\n")
    };
    let renewed = |output: &str| {
        let page = page(output);
        let (blocks, _) = typed::blocks(&page);
        let shown: Vec<Option<usize>> = (0..3).map(|index| shown::of(&page, &blocks, index)).collect();
        assert_eq!(shown, [Some(1), None, None]);
        let printed = desk.prints(&blocks[0].script().unwrap()).unwrap();
        let renewed = shown::renewed(&page, &[(1, printed)]);
        (page, renewed)
    };
    let printed = desk.prints(SCRIPT).unwrap();
    assert!(
        printed.starts_with("oneiro: runs") && printed.ends_with("best 7\n"),
        "{printed}"
    );
    for right in [printed.clone(), printed.replace("12.5 s at 3.1 M", "1.5 min at 700 k")] {
        let (page, renewed) = renewed(&right);
        assert_eq!(page, renewed);
    }
    for wrong in [
        printed.replace("best 7", "best 8"),
        printed.replace("failed\n", ""),
        printed.replace("took", "in"),
        printed.clone() + "more\n",
        String::new(),
    ] {
        let (_, renewed) = renewed(&wrong);
        assert_eq!(renewed, page(&printed), "{wrong}");
    }
    assert_eq!(
        shown::masked("a on cpu (native512x64, 2 threads)\nat 2026-11-28 in 3 ms,  4 runs "),
        shown::masked("a on cpu (neon, 8 threads) \nat 2025-01-02 in 12.5 s, 4 runs")
    );
}

/// Controls: a command that fails in the middle of a block is noticed, and its exit code is said.
#[test]
fn a_command_that_fails_is_noticed() {
    let desk = Desk::new("fails", true);
    desk.types(".", "oneiro check experiments/khepera-avoidance.toml")
        .unwrap();
    for (script, code) in [
        (
            "oneiro check none.toml\noneiro check experiments/khepera-avoidance.toml",
            "Some(3)",
        ),
        ("oneiro check experiments/khepera-avoidance.toml --nothing", "Some(2)"),
        ("oneiro check none.toml | cat", "Some(3)"),
        ("for name in none; do oneiro check $name.toml; done; true", "Some(3)"),
    ] {
        let said = desk.types(".", script).unwrap_err();
        assert!(said.starts_with(code), "{script}: {said}");
    }
    assert_eq!(shorter("generations = 200"), "generations = 2");
    assert_eq!(shorter("lives = 200_000"), "lives = 300");
    assert_eq!(shorter("evolution.race.lives = [1200]"), "evolution.race.lives = [300]");
    assert_eq!(first_seed("seeds = \"21..40\""), Some("seeds = [21]".to_owned()));
    for same in [
        "# generations = 200",
        "generations = 1",
        "trials = [1, 5]",
        "[evolution]",
    ] {
        assert_eq!(shorter(same), same);
    }
}
