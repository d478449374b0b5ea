//! Mistakes that people make, each with the exit code and the words that decide: what is wrong, and what to do instead. No message may
//! have the words of a library, which its reader doesn't know.

use std::fs;

use super::typed;
use crate::place::Place;

/// A mistake for each line.
const MISTAKES: &str = include_str!("mistakes.txt");

/// Words that no answer has: those of parsers, of the system's numbers, and of a tip that no command takes.
const RIDDLES: [&str; 16] = [
    "tip: a similar subcommand",
    "tip: a similar argument",
    "tip: some similar",
    "string values must be quoted",
    "os error",
    "panicked",
    "invalid key-value pair",
    "utf-8 sequence",
    "expected nothing",
    "expected `nan`",
    "Not a typewriter",
    "use '-- --",
    "Some(",
    "None",
    "allowed: ;",
    "allowed: \n",
];

const SMALL: &str = "cycles = 60
trials = 2
noise.sensor = [0.0, 0.4]

[evolution]
population = 20
parents = 4
generations = 3
";

/// A folder with one of everything.
fn furnished() -> Place {
    let place = Place::new("messages");
    place.write("small.toml", SMALL);
    place.write(
        "sweep.toml",
        "experiment = \"small.toml\"\nseeds = \"1..2\"\n[grid]\nnoise.motor = [0.0, 0.1]\n",
    );
    for words in [
        &["part", "--task", "own"][..],
        &["--example", "gather"],
        &["--example", "predator-prey"],
        &["--example", "kheperax"],
        &["--example", "automode-cues"],
    ] {
        place.good(&[&["new", "--quiet"], words].concat());
    }
    // A swarm of the foraging study.
    place.write("swarm.toml", "[swarm]\n");
    fs::create_dir(place.at("empty")).unwrap();
    let run = |experiment: &str, out: &str, set: &[&str]| {
        let set: Vec<&str> = set.iter().flat_map(|set| ["--set", set]).collect();
        place.evolved(experiment, "1", out, &set);
    };
    run("small.toml", "run", &[]);
    let short = [
        "cycles=20",
        "evolution.population=6",
        "evolution.generations=2",
        "evolution.finalists=0",
    ];
    run("gather.toml", "gather-run", &short);
    run(
        "predator-prey.toml",
        "hunt",
        &[
            &short[..],
            &["evolution.parents=2", "evolution.opponents.generations=1"],
        ]
        .concat(),
    );
    let archive = [
        "evolution.kind=map-elites",
        "evolution.descriptors=[{measure=\"end_x_mm\", least=0, greatest=600, cells=4}]",
    ];
    run("small.toml", "elites", &archive);
    run(
        "swarm.toml",
        "foragers",
        &["swarm.minutes=2", "swarm.light_moves_minute=1"],
    );
    place.good(&[
        "sweep",
        "run",
        "sweep.toml",
        "--out",
        "swept",
        "--backend",
        "cpu",
        "--quiet",
    ]);
    files(&place);
    place
}

/// Files with a mistake each.
fn files(place: &Place) {
    let npy = |shape: &str, kind: &str, bytes: usize| {
        let mut header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
        while (10 + header.len() + 1) % 64 != 0 {
            header.push(' ');
        }
        header.push('\n');
        let length = (header.len() as u16).to_le_bytes();
        [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), &vec![0; bytes]].concat()
    };
    place.write("cube.npy", npy("(3, 1, 18)", "<f4", 216));
    place.write("narrow.npy", npy("(3, 17)", "<f4", 204));
    place.write("flat.npy", npy("(17,)", "<f4", 68));
    place.write("scalar.npy", npy("()", "<f4", 4));
    place.write("whole.npy", npy("(3, 18)", "<i4", 216));
    place.write("cut.npy", npy("(3, 18)", "<f4", 80));
    place.write("none.npy", npy("(0, 18)", "<f4", 0));
    place.write("three.npy", npy("(3, 18)", "<f4", 216));
    place.write("words.npy", "hello");
    let row = vec!["0.5"; 18].join(",");
    place.write("narrow.csv", vec!["0.5"; 17].join(",") + "\n");
    place.write("word.csv", row.replacen("0.5", "abc", 1) + "\n" + &row + "\n");
    place.write("nan.csv", row.replacen("0.5", "nan", 1) + "\n");
    place.write("far.csv", row.replacen("0.5", "1e30", 1) + "\n");
    place.write("ragged.csv", format!("{row}\n{row},1\n"));
    place.write("nothing.csv", "");
    place.write("semicolons.csv", row.replace(',', ";"));
    place.write("decimals.csv", row.replace(',', ";").replace('.', ","));
    place.write("tabs.csv", row.replace(',', "\t"));
    place.write("cut.json", "{\"genome\": [1,2,");
    place.write("other.json", "{\"a\": 1}");
    place.write("words.txt", "hello\n");
    for (name, text) in [
        ("json", "{\"cycles\": 5}"),
        ("yaml", "cycles: 5\nnoise:\n  sensor: 3\n"),
        ("ini", "[noise]\nmotor 0.1\n"),
        ("true", "record.individuals = True\n"),
        ("none", "seed = None\n"),
        ("comma", "cycles = 5,\n"),
        ("list", "noise.sensor = [0.0, 0.4\ncycles = 5\n"),
        ("version", "cycles = 1.0.0\n"),
        ("word", "name = mine\n"),
        ("twice", "[noise]\nmotor = 0.1\n[noise]\nsensor = [0, 0.1]\n"),
        ("semicolon", "cycles = 5;\n"),
        ("no-seeds", "experiment = \"small.toml\"\n"),
        ("no-experiment", "seeds = \"1..2\"\n[grid]\nnoise.motor = [0.1]\n"),
        ("missing-experiment", "experiment = \"smal.toml\"\nseeds = \"1..2\"\n"),
        ("nested", "experiment = \"sweep.toml\"\nseeds = \"1..2\"\n"),
        (
            "one-value",
            "experiment = \"small.toml\"\nseeds = \"1..2\"\n[grid]\nnoise.motor = 0.1\n",
        ),
        (
            "no-values",
            "experiment = \"small.toml\"\nseeds = \"1..2\"\n[grid]\nnoise.motor = []\n",
        ),
        (
            "swept-seed",
            "experiment = \"small.toml\"\nseeds = \"1..2\"\n[grid]\nseed = [1, 2]\n",
        ),
        ("backwards", "experiment = \"small.toml\"\nseeds = \"5..1\"\n"),
        (
            "contradiction",
            "experiment = \"small.toml\"\nseeds = \"1..2\"\n[[list]]\nevolution.episodes = 900\nevolution.generations = 5\n",
        ),
        (
            "fleet",
            "experiment = \"swarm.toml\"\nseed = 1\nkey = \"k\"\noperator = \"10.0.0.1:5000\"\nbinary = \"oneiro\"\n[[robots]]\nnumber = 0\nhost = \"pi@10.0.0.10\"\naddress = \"surrogate:1\"\n",
        ),
        (
            "robot",
            "experiment = \"small.toml\"\naddress = \"/dev/ttyUSB9\"\nseed = 1\ndirectory = \"state\"\n",
        ),
        (
            "robot-swarm",
            "experiment = \"swarm.toml\"\naddress = \"serial:/dev/ttyUSB9\"\nseed = 1\ndirectory = \"state\"\n",
        ),
        (
            "robot-sweep",
            "experiment = \"sweep.toml\"\naddress = \"serial:/dev/ttyUSB9\"\nseed = 1\ndirectory = \"state\"\n",
        ),
        (
            "robot-nowhere",
            "experiment = \"small.toml\"\naddress = \"serial:/dev/ttyUSB9\"\nseed = 1\n",
        ),
        ("study", "[set]\ncycles = 5\n"),
    ] {
        place.write(format!("{name}.toml"), text);
    }
    place.write("latin.toml", b"# a caf\xe9\ncycles = 5\n");
    let wide: Vec<u8> = "\u{feff}cycles = 5\n"
        .encode_utf16()
        .flat_map(u16::to_le_bytes)
        .collect();
    place.write("wide.toml", wide);
    let head = "struct TaskState {\n    heat: f32,\n}\nfn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {\n    return TaskState(0.0f);\n}\n";
    for (name, body) in [
        ("constant", "return Reward(cos(0.5), before);"),
        ("suffix", "return Reward(quantizeToF16(0.5), before);"),
        ("misspelt", "return Reward(hihgest(episode), before);"),
        ("glsl", "float x = 1.0f;\n    return Reward(x, before);"),
        ("no-field", "return Reward(now.speed, before);"),
        ("no-end", "let x = 1.0f;"),
    ] {
        let part = format!(
            "{head}fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {{\n    {body}\n}}\n"
        );
        place.write(format!("{name}.wgsl"), part);
        place.write(
            format!("part-{name}.toml"),
            format!("cycles = 50\n[task]\nkind = \"own\"\npart = \"{name}.wgsl\"\n"),
        );
    }
    place.write("hello.sam", "hello\n");
    place.write("cut.sam", "8 4 2 5 2\nTURN 0\n1 2 3\n");
    place.write("drive.txt", "1.0 50 -50\n-1 5 5\n");
    place.write("no-start.csv", "100,200\n");
    place.write("far-start.csv", "9000,9000,0.5\n");
    place.write("degrees.csv", "100,200,90\n");
}

#[test]
fn mistakes_are_answered_with_what_is_wrong_and_what_to_do() {
    let place = furnished();
    let before = names(&place);
    let mut wrong = Vec::new();
    let cases: Vec<&str> = MISTAKES.lines().filter(|line| !line.starts_with('#')).collect();
    for line in &cases {
        let mut cells = line.splitn(3, " | ");
        let mut cell = || cells.next().unwrap_or_else(|| panic!("{line}: three cells"));
        let (typed, code, words) = (cell(), cell().parse().unwrap(), cell().split(" && "));

        let command = typed::of_program(&format!("oneiro {typed}")).remove(0);
        let arguments: Vec<&str> = command[1..].iter().map(String::as_str).collect();
        let ran = place.run(&arguments);
        let said = ran.stderr + &ran.stdout;
        if ran.code != Some(code) {
            wrong.push(format!("oneiro {typed}: exit code {:?}, not {code}\n{said}", ran.code));
        }
        let lacking = words.filter(|word| !said.contains(*word));
        wrong.extend(lacking.map(|word| format!("oneiro {typed}: no `{word}` in\n{said}")));
        let riddles = RIDDLES
            .iter()
            .filter(|riddle| said.contains(**riddle) && !typed.contains(**riddle));
        wrong.extend(riddles.map(|riddle| format!("oneiro {typed}: says `{riddle}`\n{said}")));
    }
    assert!(
        wrong.is_empty(),
        "{} of {}\n{}",
        wrong.len(),
        cases.len(),
        wrong.join("\n")
    );
    assert!(cases.len() >= 200, "{}", cases.len());
    // A mistake leaves nothing behind, except for the run whose robot isn't there: it goes on once it is.
    let after: Vec<String> = names(&place).into_iter().filter(|name| name != "left").collect();
    assert_eq!(after, before);
}

fn names(place: &Place) -> Vec<String> {
    let entries = fs::read_dir(place.at(".")).unwrap();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

/// Each command that takes a robot's address offers, in its help and in its errors, only what it takes.
#[test]
fn surrogates_are_offered_where_they_are_taken() {
    let place = Place::new("addresses");
    place.write("small.toml", SMALL);
    let evaluate = ["evaluate", "small.toml", "--random", "1", "--backend", "cpu", "--robot"];
    let sample = ["robot", "sample", "--out", "samples", "--robot"];
    for (command, takes) in [
        (&["robot", "ping"][..], false),
        (&["robot", "watch"], false),
        (&["robot", "drive"], false),
        (&["robot", "stop"], false),
        (&evaluate, true),
        (&sample, true),
        (&["replay", "--robot"], true),
        (&["reproduce", "miglino1995", "--robot"], true),
    ] {
        let answers = ["nowhere", "usb:x", "/dev/ttyUSB0", "surrogate"].map(|address| {
            let ran = place.run(&[command, &[address]].concat()).exits(3);
            assert!(ran.stderr.contains("allowed: serial:PATH"), "{}", ran.stderr);
            ran.stderr
        });
        for answer in &answers {
            assert_eq!(answer.contains("surrogate:SEED"), takes, "{command:?}: {answer}");
        }
        let words = command
            .iter()
            .take_while(|word| !word.starts_with('-') && !word.contains('.'));
        let help = place.good(&[words.copied().collect(), vec!["--help"]].concat());
        assert!(!help.contains("surrogate:") || takes, "{command:?}: {help}");
        let code = place.run(&[command, &["surrogate:x"]].concat()).exits(3).stderr;
        assert_eq!(code.contains("`x` is no seed"), takes, "{command:?}: {code}");
    }
    // All commands with an address are in the table above: those whose help names one.
    let mut with_address = Vec::new();
    let mut commands = vec![Vec::new()];
    while let Some(words) = commands.pop() {
        let help = place.good(&[&words[..], &["--help"]].concat());
        let names = help
            .lines()
            .take_while(|line| *line != "Options:")
            .filter(|line| line.starts_with("  ") && line[2..].starts_with(|c: char| c.is_ascii_lowercase()));
        let names = names.filter_map(|line| line.split_whitespace().next());
        for name in names.filter(|name| *name != "help") {
            let name: &'static str = name.to_owned().leak();
            commands.push([&words[..], &[name]].concat());
        }
        if help.contains("ADDRESS>") || help.contains("--robot <") {
            with_address.push(words.join(" "));
        }
    }
    with_address.sort();
    assert_eq!(
        with_address,
        [
            "evaluate",
            "new",
            "replay",
            "reproduce miglino1995",
            "robot drive",
            "robot light",
            "robot ping",
            "robot sample",
            "robot stop",
            "robot watch"
        ]
    );
    let light = |address: &str| place.run(&["robot", "light", address, "body", "on"]).exits(3).stderr;
    assert!(!light("nowhere").contains("surrogate"), "{}", light("nowhere"));
}
