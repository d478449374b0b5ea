//! Pinned results of the program: runs, sweeps, swarms, stopped and resumed work, and both studies at their smallest
//! match `tests/goldens/program/`. There are two files of each kind: `NAME.rows` has computed results;
//! `NAME.identity.rows` has results that also depend on the names of values, columns and claims, and so may change when
//! nothing else does. [`pinned`] explains how these files are renewed.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::contents;
use crate::pinned::{self, Rows, digest};
use crate::place::Place;

/// Results of one kind.
#[derive(Default)]
struct Found {
    content: Rows,
    identity: Rows,
}

/// Kinds of results, each with a test that computes it.
const KINDS: [&str; 10] = [
    "runs",
    "optimisers",
    "described",
    "members",
    "sweeps",
    "swarms",
    "miglino1995",
    "miglino1995-whole",
    "odowd2014",
    "odowd2014-whole",
];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/goldens/program")
}

impl Found {
    #[track_caller]
    fn check(self, kind: &str) {
        assert!(KINDS.contains(&kind));
        let files = [
            (format!("{kind}.rows"), self.content),
            (format!("{kind}.identity.rows"), self.identity),
        ];
        let problems: Vec<String> = files
            .into_iter()
            .filter_map(|(file, rows)| pinned::problem(&folder().join(file), &rows.to_string()))
            .collect();
        assert!(problems.is_empty(), "{}", problems.join("\n"));
    }

    /// Adds a table without its first line, which is text.
    fn table(&mut self, place: &Place, directory: &str, file: &str) {
        let text = place.text(Path::new(directory).join(file));
        let (head, body) = text.split_once('\n').unwrap();
        self.identity.text("head", &format!("{directory}/{file}"), head);
        self.body("table", &format!("{directory}/{file}"), body);
    }

    /// Adds lines: their number, their digest, and the last of them.
    fn body(&mut self, stage: &str, subject: &str, body: &str) {
        let last = body.lines().last().unwrap_or_default();
        self.content.text(
            stage,
            subject,
            format_args!(
                "{} lines, {}, the last: {last}",
                body.lines().count(),
                digest(body.as_bytes())
            ),
        );
    }

    /// Adds a run's identity, and the hash of its results, which depends on it.
    fn done(&mut self, place: &Place, run: &str) {
        let done = place.json(run, "DONE");
        let hash = |key: &str| done[key].as_str().unwrap()[..16].to_owned();
        self.identity
            .bytes("config", run, &place.read(format!("{run}/config.toml")));
        self.identity.text("experiment", run, hash("experiment"));
        self.identity.text("result", run, hash("result"));
    }

    /// Adds a run of a single robot.
    fn run(&mut self, place: &Place, run: &str) {
        let (shape, individuals) = npy(&place.read(format!("{run}/individuals.npy")));
        let [_, population, columns] = shape[..] else {
            panic!("{run}: the individuals are of the shape {shape:?}");
        };
        let first = individuals[..population * columns].chunks(columns);
        let genes: Vec<f32> = first.clone().flat_map(|row| &row[..columns - 1]).copied().collect();
        let fitness: Vec<f32> = first.map(|row| row[columns - 1]).collect();
        self.content.numbers("first genes", run, &genes);
        self.content.numbers("first fitness", run, &fitness);
        self.content.numbers("individuals", run, &individuals);
        self.table(place, run, "generations.csv");
        for file in ["population", "fitness", "champion"] {
            let (_, numbers) = npy(&place.read(format!("{run}/{file}.npy")));
            self.content.numbers(file, run, &numbers);
        }
        let champion = place.json(run, "champion.json");
        let of = |key: &str| &champion[key];
        self.content.text(
            "end",
            run,
            format_args!(
                "fitness {} in generation {}, individual {}",
                of("fitness"),
                of("generation"),
                of("individual")
            ),
        );
        if !of("lives").is_null() {
            let (_, luckiest) = npy(&place.read(format!("{run}/luckiest.npy")));
            self.content.numbers("luckiest", run, &luckiest);
            self.content.text(
                "mean",
                run,
                format_args!("{} of {} lives, {}", of("mean"), of("lives"), of("interval")),
            );
        }
        self.table(place, run, "trace.csv");
        self.done(place, run);
    }

    /// Adds a swarm's run.
    fn swarm(&mut self, place: &Place, run: &str) {
        let food = place.text(format!("{run}/food.csv"));
        let brought: u32 = food
            .lines()
            .skip(1)
            .map(|line| line.split(',').nth(1).unwrap().parse::<u32>().unwrap())
            .sum();
        let intervals = place.text(format!("{run}/intervals.csv"));
        // Each robot has a line: those of the first interval, then all.
        let first: String = intervals
            .lines()
            .filter(|line| line.starts_with("0,"))
            .flat_map(|line| [line, "\n"])
            .collect();
        self.body("first interval", run, &first);
        self.table(place, run, "intervals.csv");
        self.table(place, run, "food.csv");
        self.content.text("end", run, format_args!("{brought} brought"));
        self.done(place, run);
    }

    /// Adds a sweep. The ids of runs and the hashes of their results aren't content.
    fn sweep(&mut self, place: &Place, sweep: &str) {
        let text = place.text(format!("{sweep}/results.csv"));
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let head = reader.headers().unwrap().clone();
        let mut content = String::new();
        let mut results = String::new();
        for row in reader.records() {
            let row = row.unwrap();
            // Runs without finalists have empty cells for a champion by its mean.
            for (name, value) in head.iter().zip(&row).filter(|(_, value)| !value.is_empty()) {
                let to = if ["id", "result"].contains(&name) {
                    &mut results
                } else {
                    &mut content
                };
                let _ = write!(to, "{value};");
            }
            content.push('\n');
            results.push('\n');
        }
        self.identity.text(
            "head",
            &format!("{sweep}/results.csv"),
            head.iter().collect::<Vec<_>>().join(","),
        );
        self.body("table", &format!("{sweep}/results.csv"), &content);
        self.identity.bytes("result", sweep, results.as_bytes());
        self.table(place, sweep, "generations.csv");
    }

    /// Adds a study: its results, claims, tables and figures.
    fn study(&mut self, place: &Place, study: &str) {
        self.identity
            .bytes("settings", study, &place.read(format!("{study}/study.json")));
        let results = place.json(study, "results.json");
        for (key, value) in results.as_object().unwrap() {
            let mut numbers = numbers_of(value);
            // In an order that doesn't depend on names.
            numbers.sort_unstable();
            self.content.text(
                "results",
                &format!("{study}/{key}"),
                format_args!("{} numbers, {}", numbers.len(), digest(numbers.concat().as_bytes())),
            );
        }
        self.identity
            .bytes("results", study, &place.read(format!("{study}/results.json")));
        let mut files: Vec<String> = fs::read_dir(place.at(study))
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .filter(|name| Path::new(name).extension().is_some_and(|extension| extension == "csv"))
            .collect();
        files.sort();
        for file in files {
            self.table(place, study, &file);
        }
        for claim in place.json(study, "claims.json").as_array().unwrap() {
            let id = claim["id"].as_str().unwrap();
            let numbers = [&claim["effects"], &claim["tests"]].map(numbers_of).concat().concat();
            let first = claim["effects"].as_array().and_then(|effects| effects.first());
            self.content.text(
                "claim",
                &format!("{study}/{id}"),
                format_args!(
                    "{}, {}: {}",
                    claim["verdict"].as_str().unwrap(),
                    digest(numbers.as_bytes()),
                    first.map_or("no effect".to_owned(), |effect| effect["value"].to_string())
                ),
            );
            self.identity
                .bytes("claim", &format!("{study}/{id}"), claim.to_string().as_bytes());
        }
        let report = place.text(format!("{study}/report.html"));
        let drawings = drawings(&report);
        self.content.text(
            "figures",
            study,
            format_args!("{}, {}", drawings.len(), digest(drawings.concat().as_bytes())),
        );
    }
}

/// All numbers of a value in the order of their keys, without the keys.
fn numbers_of(value: &Value) -> Vec<String> {
    match value {
        Value::Array(values) => values.iter().flat_map(numbers_of).collect(),
        Value::Object(values) => values.values().flat_map(numbers_of).collect(),
        Value::Number(number) => vec![format!("{number};")],
        _ => Vec::new(),
    }
}

/// Drawings of a page, without their text.
fn drawings(page: &str) -> Vec<String> {
    let drawings = page
        .split("<svg")
        .skip(1)
        .map(|rest| rest.split("</svg>").next().unwrap_or(rest));
    drawings
        .map(|drawing| {
            drawing
                .split('<')
                .map(|element| element.split_once('>').map_or(element, |(tag, _)| tag))
                .filter(|tag| {
                    !["text", "tspan", "title", "desc"]
                        .iter()
                        .any(|word| tag.starts_with(word))
                })
                .flat_map(|tag| [tag, "\n"])
                .collect()
        })
        .collect()
}

/// Shape and numbers of an array file.
fn npy(bytes: &[u8]) -> (Vec<usize>, Vec<f32>) {
    let file = npyz::NpyFile::new(bytes).unwrap();
    let shape = file.shape().iter().map(|&length| length as usize).collect();
    (shape, file.into_vec().unwrap())
}

fn shipped(name: &str) -> String {
    let experiments = Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments");
    experiments.join(name).display().to_string()
}

/// A small evolution without any options.
const PLAIN: &str = "
    cycles = 60
    [evolution]
    population = 20
    parents = 4
    generations = 8
    finalists = 0
    [record]
    checkpoint_every = 3
";

/// Several lives, an elite, limits, mutation of whole individuals, all noises, a hidden layer.
const NOISY: &str = r#"
    cycles = 50
    trials = 3
    trial_score = "least"
    [noise]
    sensor = [-0.2, 0.2]
    walk_range_mm = 30
    motor = 0.1
    [controller]
    kind = "hidden"
    units = 3
    [task]
    speed = "signed"
    difference = "square"
    activation = "perceived"
    [evolution]
    population = 12
    parents = 3
    generations = 6
    finalists = 0
    elite = 2
    initial = [-3.0, 3.0]
    limits = [-2.5, 2.5]
    [evolution.mutation]
    kind = "add_normal"
    per = "individual"
    rate = 0.5
    amount = 0.7
"#;

/// Redrawn genes, the mean of several lives, another arena, a chosen start, and outputs fed back.
const REPLACED: &str = r#"
    cycles = 50
    trials = 2
    [robot]
    states = "evorobot"
    turn_before_move = 0.5
    [arena]
    width_mm = 500
    height_mm = 400
    obstacles = [{ x_mm = 250, y_mm = 200, radius_mm = 40 }]
    [controller]
    kind = "recurrent"
    [task]
    new_cell = 1.5
    [start]
    kind = "at"
    x_mm = 100
    y_mm = 100
    heading_turns = 0.125
    [evolution]
    population = 15
    parents = 5
    generations = 6
    finalists = 0
    [evolution.mutation]
    kind = "replace"
    rate = 0.3
"#;

/// A network of two kinds of layers with memory, one with time constants of its own range, and slopes.
const NETWORK: &str = r#"
    cycles = 50
    [noise]
    sensor = [-0.2, 0.2]
    [controller]
    kind = "network"
    activation = "tanh"
    slope = 0.5
    [[controller.layers]]
    kind = "ctrnn"
    units = 3
    time_constants_s = [0.2, 4.0]
    [[controller.layers]]
    kind = "lstm"
    units = 2
    biases = false
    [evolution]
    population = 12
    parents = 3
    generations = 6
    finalists = 0
    initial = [-3.0, 3.0]
"#;

/// A robot by name with wheels that accelerate and hear late, and a battery that a patch fills.
const BATTERY: &str = r#"
    cycles = 60
    trials = 2
    [robot]
    preset = "epuck"
    acceleration_mm_s2 = 400
    latency_cycles = 2
    battery_s = 2
    battery_ends_life = true
    [arena]
    width_mm = 500
    height_mm = 400
    obstacles = [{ x_mm = 250, y_mm = 200, radius_mm = 40 }]
    patches = [{ x_mm = 130, y_mm = 130, radius_mm = 125, charges = true }]
    [noise]
    sensor = [-0.05, 0.05]
    motor = 0.05
    [controller]
    kind = "recurrent"
    [evolution]
    population = 12
    parents = 3
    generations = 6
    finalists = 0
"#;

impl Place {
    fn evolve(&self, out: &str, experiment: &str, more: &[&str]) {
        let run = ["run", experiment, "--seed", "7", "--backend", "cpu", "--out", out];
        self.good(&[&run[..], more].concat());
    }

    /// The same, but the last file can't be written, and the run is then resumed.
    #[cfg(unix)]
    fn evolve_and_resume(&self, out: &str, experiment: &str, more: &[&str]) {
        self.evolve_without_end(out, experiment, more);
        self.good(&["resume", out, "--backend", "cpu"]);
    }

    /// The same, and it is resumed from the checkpoint before the last.
    #[cfg(unix)]
    fn evolve_and_resume_earlier(&self, out: &str, experiment: &str, more: &[&str]) {
        self.evolve_without_end(out, experiment, more);
        let files = fs::read_dir(self.at(out)).unwrap().map(|file| file.unwrap().path());
        let number =
            |path: &PathBuf| -> Option<u32> { path.file_name()?.to_str()?.strip_prefix("checkpoint-")?.parse().ok() };
        let mut checkpoints: Vec<PathBuf> = files.filter(|path| number(path).is_some()).collect();
        checkpoints.sort_by_key(number);
        assert_eq!(checkpoints.len(), 2, "{checkpoints:?}");
        fs::remove_file(&checkpoints[1]).unwrap();
        self.good(&["resume", out, "--backend", "cpu"]);
    }

    /// A run before its last file is written.
    #[cfg(unix)]
    fn evolve_without_end(&self, out: &str, experiment: &str, more: &[&str]) {
        let run = ["run", experiment, "--seed", "7", "--backend", "cpu", "--out", out];
        self.good(&[&run[..], more].concat());
        fs::remove_file(self.at(format!("{out}/DONE"))).unwrap();
    }

    /// All tables, arrays and champions of a run, by their names.
    #[cfg(unix)]
    fn results(&self, run: &str) -> Vec<(String, Vec<u8>)> {
        let files = fs::read_dir(self.at(run))
            .unwrap()
            .map(|file| file.unwrap().file_name());
        let mut names: Vec<String> = files.map(|name| name.into_string().unwrap()).collect();
        names.retain(|name| name != "meta.json" && [".csv", ".npy", ".json"].iter().any(|end| name.ends_with(end)));
        names.sort();
        let read = |name: String| (name.clone(), self.read(Path::new(run).join(name)));
        names.into_iter().map(read).collect()
    }
}

#[test]
fn runs_are_as_pinned() {
    let place = Place::new("runs");
    let mut found = Found::default();
    for (name, experiment) in [("plain", PLAIN), ("noisy", NOISY), ("replaced", REPLACED)] {
        let file = format!("{name}.toml");
        place.write(&file, experiment);
        place.evolve(name, &file, &[]);
        found.run(&place, name);
    }
    fs::copy(place.at("plain/population.npy"), place.at("init.npy")).unwrap();
    let init = ["--set", "evolution.init=init.npy", "--set", "noise.sensor=[0.0, 0.4]"];
    place.evolve("init", "plain.toml", &init);
    found.run(&place, "init");
    let short = [
        "--set",
        "evolution.generations=3",
        "--set",
        "cycles=100",
        "--set",
        "evolution.finalists=0",
    ];
    for name in ["block", "conservative-noise"] {
        place.evolve(name, &shipped(&format!("khepera-{name}.toml")), &short);
        found.run(&place, name);
    }
    #[cfg(unix)]
    {
        place.evolve_and_resume("resumed", "plain.toml", &["--set", "cycles=61"]);
        found.run(&place, "resumed");
    }
    let finalists = ["--set", "evolution.finalists=5", "--set", "evolution.finalist_lives=12"];
    place.evolve("finalists", "noisy.toml", &finalists);
    found.run(&place, "finalists");
    #[cfg(unix)]
    {
        place.evolve_and_resume("resumed-finalists", "plain.toml", &finalists);
        found.run(&place, "resumed-finalists");
    }
    let robot = [
        "--set",
        "reality.robot=\"surrogate:3\"",
        "--set",
        "reality.generations=2",
    ];
    let transferred = [&finalists[..], &robot].concat();
    place.evolve("transferred", "noisy.toml", &transferred);
    found.run(&place, "transferred");
    found.check("runs");
}

/// Each optimiser, and a genetic algorithm with each selection.
#[test]
fn optimisers_are_as_pinned() {
    const HEAD: &str = "
        cycles = 40
        trials = 2
        [record]
        checkpoint_every = 1
        [evolution]
        population = 12
        generations = 7
        finalists = 3
        finalist_lives = 4
    ";
    const DESCRIPTORS: &str = "descriptors = [\n\
        { measure = \"end_x_mm\", least = 0, greatest = 600 },\n\
        { measure = \"mean_turning_turns_s\", least = 0, greatest = 1 },\n]\n";
    const GRID: &str = "descriptors = [\n\
        { measure = \"end_x_mm\", least = 0, greatest = 600, cells = 6 },\n\
        { measure = \"mean_turning_turns_s\", least = 0, greatest = 1, cells = 5 },\n]\n";
    const OPTIMISERS: [(&str, &str); 9] = [
        ("cma-es", "kind = \"cma-es\"\ncommon_random_numbers = true"),
        (
            "sep-cma-es",
            "kind = \"sep-cma-es\"\n[evolution.strategy]\nactive = false",
        ),
        (
            "open-es",
            "kind = \"open-es\"\n[evolution.strategy]\nsigma = 0.02\nlearning_rate = 0.05",
        ),
        ("random", "kind = \"random\""),
        (
            "differential-evolution",
            "kind = \"differential-evolution\"\n[evolution.differential]\nstrategy = \"best/1/bin\"\nweight = 0.7",
        ),
        (
            "uniform",
            "parents = 5\nelite = 2\nlimits = [-1, 1]\n[evolution.selection]\nkind = \"uniform\"\n\
             [evolution.mutation]\nkind = \"evostick\"\nrate = 0.5",
        ),
        (
            "rank",
            "[evolution.selection]\nkind = \"rank\"\npressure = 1.1\n[evolution.crossover]\nkind = \"uniform\"\n\
             [evolution.mutation]\nkind = \"add_vector\"\nrate = 1.0\namount = 0.3",
        ),
        (
            "roulette",
            "[evolution.selection]\nkind = \"roulette\"\n[evolution.crossover]\nkind = \"one_point\"\nrate = 0.3",
        ),
        (
            "tournament",
            "elite = 1\n[evolution.selection]\nkind = \"tournament\"\nsize = 3\n[evolution.crossover]\nkind = \"two_point\"",
        ),
    ];
    let behaving = |kind: &str, descriptors: &str, more: &str| format!("kind = \"{kind}\"\n{descriptors}{more}");
    let place = Place::new("optimisers");
    let mut found = Found::default();
    let archives = [
        (
            "map-elites",
            behaving("map-elites", GRID, "[evolution.archive]\niso = 0.1\noffset = -5"),
        ),
        (
            "map-elites-again",
            behaving(
                "map-elites",
                DESCRIPTORS,
                "common_random_numbers = true\n[evolution.archive]\ncells = \"centroidal\"\ncentroids = 9\nreevaluated = 4\n\
                 acceptance = \"mean\"",
            ),
        ),
        (
            "novelty",
            behaving(
                "novelty",
                DESCRIPTORS,
                "parents = 4\n[evolution.novelty]\nneighbours = 3\nadded = 2",
            ),
        ),
    ];
    let archives = archives.iter().map(|(name, text)| (*name, text.as_str()));
    for (name, optimiser) in OPTIMISERS.into_iter().chain(archives) {
        let file = format!("{name}.toml");
        place.write(&file, format!("{HEAD}{optimiser}\n"));
        place.evolve(name, &file, &[]);
        found.run(&place, name);
        if name.starts_with("map-elites") {
            for table in ["archive.csv", "coverage.csv"] {
                found.table(&place, name, table);
            }
            let (_, genes) = npy(&place.read(format!("{name}/archive.npy")));
            found.content.numbers("archive", name, &genes);
            // Every elite lives as it did.
            let table = place.text(Path::new(name).join("archive.csv"));
            for line in table.lines().skip(1) {
                let cell = line.split(',').next().unwrap();
                place.good(&["replay", name, "--elite", cell, "--backend", "cpu"]);
            }
            let said = place.good(&["replay", name, "--elites", "--trial", "1", "--backend", "cpu"]);
            let elites = table.lines().count() - 1;
            assert!(
                said.starts_with(&format!("{elites} elite")) && said.contains(", as recorded"),
                "{said}"
            );
            let page = place.text(Path::new(name).join("archive.html"));
            assert_eq!(page.matches("data-elite=\"").count(), elites, "{name}");
        }
        #[cfg(unix)]
        {
            // From generation 3 of 7.
            let resumed = format!("{name}-resumed");
            let seldom = ["--set", "record.checkpoint_every=3"];
            place.evolve_and_resume_earlier(&resumed, &file, &seldom);
            let (whole, resumed) = (place.results(name), place.results(&resumed));
            let names = |all: &[(String, Vec<u8>)]| all.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
            // The replays above are not the run's.
            let whole: Vec<_> = whole
                .into_iter()
                .filter(|(own, _)| !own.starts_with("replay"))
                .collect();
            assert_eq!(names(&whole), names(&resumed), "{name}");
            for (whole, resumed) in whole.iter().zip(&resumed) {
                assert!(whole.1 == resumed.1, "{name}: {} differs", whole.0);
            }
        }
        place.good(&["verify", name]);
        place.good(&["verify", "--recompute", name, "--fraction", "1", "--backend", "cpu"]);
    }
    found.check("optimisers");
}

/// Only the places where lives end describe behaviour, and some lives end early: the archive is the one that a run has in which all
/// cycles are traced, for a third measure with a single cell.
#[test]
fn lives_that_end_early_have_all_of_their_behaviour() {
    let place = Place::new("early");
    let ends =
        "{measure=\"end_x_mm\",least=0,greatest=400,cells=9},{measure=\"end_y_mm\",least=0,greatest=400,cells=9}";
    let third = "{measure=\"distance_mm\",least=0,greatest=4000,cells=1}";
    let archive = |out: &str, descriptors: &str| {
        let set = [
            "evolution.kind=map-elites".to_owned(),
            format!("evolution.descriptors=[{descriptors}]"),
            "evolution.population=40".to_owned(),
            "evolution.generations=4".to_owned(),
            "evolution.finalists=0".to_owned(),
            "trials=1".to_owned(),
        ];
        let set: Vec<&str> = set.iter().flat_map(|value| ["--set", value]).collect();
        place.evolve(out, &shipped("discrimination.toml"), &set);
        let table = place.text(Path::new(out).join("archive.csv"));
        let eight = |line: &str| line.split(',').take(8).collect::<Vec<_>>().join(",");
        table.lines().skip(1).map(eight).collect::<Vec<_>>()
    };
    let (some, all) = (archive("some", ends), archive("all", &format!("{ends},{third}")));
    assert!(some.len() > 10, "{some:?}");
    assert_eq!(some, all);
    let measured = place.good(&[
        "evaluate",
        &shipped("discrimination.toml"),
        "--genomes",
        "some/archive.npy",
        "--trials",
        "1",
        "--seed",
        "1",
        "--measures",
        "--json",
        "--quiet",
    ]);
    assert!(measured.contains("collisions\": 1"), "some lives end early: {measured}");
}

#[test]
fn described_robots_and_networks_are_as_pinned() {
    let place = Place::new("described");
    let mut found = Found::default();
    for (name, experiment) in [("network", NETWORK), ("battery", BATTERY)] {
        let file = format!("{name}.toml");
        place.write(&file, experiment);
        place.evolve(name, &file, &[]);
        found.run(&place, name);
    }
    // The last generations live as an individual.
    let robot = [
        "reality.robot=\"surrogate:3\"",
        "reality.generations=2",
        "noise.motor=0",
    ];
    let robot = robot.map(|value| ["--set", value]).concat();
    place.evolve("transferred", "battery.toml", &robot);
    found.run(&place, "transferred");
    #[cfg(unix)]
    {
        place.evolve_and_resume("resumed", "battery.toml", &robot);
        found.run(&place, "resumed");
        let same = |file: &str| {
            fs::read(place.at(format!("transferred/{file}"))).unwrap()
                == fs::read(place.at(format!("resumed/{file}"))).unwrap()
        };
        assert!(same("population.npy") && same("generations.csv"));
    }
    found.check("described");
}

/// A run and a sweep of robots that live together.
#[test]
fn robots_that_live_together_are_as_pinned() {
    let place = Place::new("members");
    let mut found = Found::default();
    let experiment = shipped("aggregation.toml");
    let short = [
        "cycles=300",
        "evolution.generations=4",
        "evolution.finalists=2",
        "evolution.finalist_lives=3",
    ];
    let short = short.map(|value| ["--set", value]).concat();
    place.evolve("aggregation", &experiment, &short);
    found.run(&place, "aggregation");
    let grid = [
        "cycles=60",
        "evolution.kind=grid",
        "evolution.grid.levels=3",
        "evolution.population=27",
        "evolution.common_random_numbers=true",
        "evolution.finalists=4",
        "evolution.finalist_lives=3",
    ];
    place.evolve("grid", &experiment, &grid.map(|value| ["--set", value]).concat());
    found.run(&place, "grid");
    for (name, genomes, kind) in [
        ("heterogeneous", "heterogeneous", "sep-cma-es"),
        ("teams", "[0,1,1,0,2,2,0,1,2,0]", "open-es"),
    ] {
        let (genomes, kind) = (format!("robot.genomes={genomes}"), format!("evolution.kind={kind}"));
        let set = [
            "cycles=60",
            "evolution.generations=3",
            "evolution.finalist_lives=3",
            &genomes,
            &kind,
        ];
        let strategy = ["evolution.strategy.sigma=0.02", "evolution.strategy.learning_rate=0.01"];
        let strategy = strategy.into_iter().filter(|_| name == "teams");
        let set = set.into_iter().chain(strategy).flat_map(|value| ["--set", value]);
        place.evolve(name, &shipped("gather.toml"), &set.collect::<Vec<_>>());
        found.run(&place, name);
    }
    let pair = [
        "cycles=100",
        "evolution.generations=4",
        "evolution.population=10",
        "evolution.parents=5",
        "evolution.opponents.contests=3",
        "evolution.finalist_lives=3",
        "record.individuals=true",
    ];
    for (name, kind) in [("predator-prey", "recent"), ("predator-prey, hall", "hall-of-fame")] {
        let kind = format!("evolution.opponents.kind={kind}");
        let set: Vec<&str> = pair
            .iter()
            .copied()
            .chain([&*kind])
            .flat_map(|value| ["--set", value])
            .collect();
        place.evolve(name, &shipped("predator-prey.toml"), &set);
        found.run(&place, name);
        found.table(&place, name, "second.csv");
    }
    let sweep = format!(
        "experiment = {experiment:?}
        seeds = \"1..2\"
        [set]
        cycles = 200
        evolution.generations = 2
        evolution.finalists = 0
        [grid]
        robot.count = [3, 8]
        robot.contact = [\"push\", \"stop\"]"
    );
    place.write("sweep.toml", sweep);
    place.good(&["sweep", "run", "sweep.toml", "--backend", "cpu", "--out", "sweep"]);
    found.sweep(&place, "sweep");
    found.check("members");
}

#[test]
fn sweeps_are_as_pinned() {
    let place = Place::new("sweeps");
    place.write("small.toml", PLAIN);
    place.write("swarm.toml", fs::read(shipped("odowd2014-over.toml")).unwrap());
    place.write(
        "reality.toml",
        r#"
        experiment = "small.toml"
        seeds = "3..4"
        [grid]
        noise.sensor = [[0.0, 0.0], [0.0, 0.4]]
        [[list]]
        controller = { kind = "perceptron" }
        evolution.elite = 0
        [[list]]
        controller = { kind = "recurrent" }
        evolution.elite = 1
        [random]
        samples = 2
        [random.ranges]
        trials = { from = 1, to = 3 }
        evolution.mutation.amount = { from = 0.01, to = 10.0, scale = "log" }
        [reality]
        robots = [1, 2]
        "#,
    );
    place.write(
        "swarms.toml",
        r#"
        experiment = "swarm.toml"
        seeds = "1..2"
        [set]
        swarm.minutes = 3
        [grid]
        swarm.robots = [4, 5]
        [[list]]
        swarm.simulators.credit = "lagged"
        [[list]]
        swarm.simulators.credit = "matched"
        "#,
    );
    place.write(
        "finalists.toml",
        r#"
        experiment = "small.toml"
        seeds = "3..4"
        [set]
        evolution.finalist_lives = 10
        [grid]
        evolution.finalists = [0, 4]
        "#,
    );
    place.write(
        "own.toml",
        r#"
        experiment = "small.toml"
        seeds = "3..4"
        seeds_by = "reality.robot"
        [set]
        robot.tables = "reality"
        robot.motors = "reality"
        reality.generations = 2
        reality.motion_severity = 0.5
        [grid]
        reality.robot = ["surrogate:1", "surrogate:2"]
        robot.collision = ["undo", "slide"]
        noise.sensor = [[0.0, 0.0], [0.0, 0.4]]
        [reality]
        robots = "own"
        "#,
    );
    let mut found = Found::default();
    for name in ["reality", "swarms", "finalists", "own"] {
        let file = format!("{name}.toml");
        place.good(&["sweep", "run", &file, "--backend", "cpu", "--out", name]);
        found.sweep(&place, name);
    }
    found.check("sweeps");
}

#[test]
fn swarms_are_as_pinned() {
    let place = Place::new("swarms");
    let mut found = Found::default();
    let short = ["--set", "swarm.minutes=3", "--set", "swarm.light_moves_minute=1"];
    for case in ["over-then-opposite", "random"] {
        place.evolve(case, &shipped(&format!("odowd2014-{case}.toml")), &short);
        found.swarm(&place, case);
    }
    let choices = [
        "swarm.robots=6",
        "swarm.controllers.guests=1",
        "swarm.controllers.boundary=wrap",
        "swarm.simulators.credit=matched",
        "swarm.simulators.says=last_whole",
        "swarm.simulators.pairs=3",
        "swarm.clock.installed_s=34",
        "swarm.robot.individuals=2",
    ];
    let set: Vec<&str> = choices.iter().flat_map(|choice| ["--set", choice]).collect();
    let over = shipped("odowd2014-over.toml");
    place.evolve("choices", &over, &[&short[..], &set].concat());
    found.swarm(&place, "choices");
    #[cfg(unix)]
    {
        place.evolve_and_resume("resumed", &over, &short);
        found.swarm(&place, "resumed");
    }
    found.check("swarms");
}

/// Results of a study with each of these options.
fn study(kind: &str, paper: &str, options: &[(&str, &[&str])]) {
    let place = Place::new(kind);
    let mut found = Found::default();
    for (name, more) in options {
        let study = [
            "reproduce",
            paper,
            "--runs",
            "2",
            "--backend",
            "cpu",
            "--quiet",
            "--out",
            name,
        ];
        place.good(&[&study[..], more].concat());
        contents::check(&place.at(name));
        found.study(&place, name);
    }
    found.check(kind);
}

#[test]
fn the_study_of_1995_is_as_pinned() {
    study(
        "miglino1995",
        "miglino1995",
        &[("main", &["--edition", "first"]), ("second", &[])],
    );
}

#[test]
fn the_study_of_2014_is_as_pinned() {
    let one = ["--scale", "0.2", "--credit", "matched"];
    study("odowd2014", "odowd2014", &[("main", &one)]);
}

/// With all of its parts, and under other assumptions.
#[test]
#[ignore = "takes minutes: tests/long.sh runs it"]
fn the_whole_study_of_1995_is_as_pinned() {
    let options: [(&str, &[&str]); 3] = [
        ("full", &["--edition", "first", "--full"]),
        ("square", &["--edition", "first", "--arm", "square"]),
        (
            "ten-readings",
            &["--edition", "first", "--arm", "ten-readings", "--seed", "2"],
        ),
    ];
    study("miglino1995-whole", "miglino1995", &options);
}

/// With all of its parts, and under other assumptions.
#[test]
#[ignore = "takes minutes: tests/long.sh runs it"]
fn the_whole_study_of_2014_is_as_pinned() {
    let all = ["--scale", "0.2,2", "--credit", "lagged,matched", "--questions"];
    let other = ["--scale", "0.2", "--only-cases", "--arm", "last-whole", "--seed", "2"];
    study("odowd2014-whole", "odowd2014", &[("all", &all), ("last-whole", &other)]);
}

#[test]
fn nothing_is_pinned_that_no_test_computes() {
    let files = KINDS.map(|kind| [format!("{kind}.rows"), format!("{kind}.identity.rows")]);
    pinned::check_folder(&folder(), &files.concat());
}
