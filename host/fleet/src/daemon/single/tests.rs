//! Robots on a virtual clock: a Khepera that is emulated byte by byte, whose body is a surrogate.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use oneiro_base::console::Output;
use oneiro_base::files;
use oneiro_lab::experiment::source::Parsed;
use oneiro_lab::reality::wired::emulated::{INSTANT, connected};
use oneiro_lab::reality::wired::logbook::COMPLETE;

use super::*;

const EXPERIMENT: &str =
    "cycles = 20\n[evolution]\npopulation = 8\nparents = 2\ngenerations = 7\n[noise]\nsensor = [-0.1, 0.1]\n";
const FILE: &str = r#"
experiment = "experiment.toml"
address = "serial:/dev/none"
seed = 5
directory = "state"
[transfers]
generations = 1
again_every = 3
least_lives = 4
final_lives = 2
[lives]
walk_s = 0.5
"#;

fn quiet() -> Console {
    Console::new(Output {
        json: false,
        quiet: true,
        verbose: false,
    })
}

/// A directory with the daemon's file and its experiment.
struct Place(PathBuf);

impl Place {
    fn new(name: &str, file: &str, experiment: &str) -> Self {
        let path = std::env::temp_dir().join(format!("oneiro-single-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        fs::write(path.join("robot.toml"), file).unwrap();
        fs::write(path.join("experiment.toml"), experiment).unwrap();
        Self(path)
    }

    fn settings(&self) -> Result<Settings> {
        let path = self.0.join("robot.toml");
        let text = files::text(&path)?;
        Settings::of(&path, &Parsed::new(path.display().to_string(), &text)?)
    }

    /// Runs the daemon with an emulated Khepera until everything is done, or until it is stopped after `looks` readings of its sensors.
    fn lives(&self, looks: usize) -> Result {
        let settings = self.settings()?;
        let mut khepera = connected(INSTANT);
        khepera.looks = looks;
        let bench = khepera.bench.clone();
        let daemon = Daemon::new(&settings, true)?;
        let outcome = daemon.live(Box::new(khepera), quiet(), &AtomicBool::new(false));
        assert_eq!(bench.line().robot.speeds(), [0; 2]);
        outcome
    }

    fn text(&self, name: &str) -> String {
        fs::read_to_string(self.0.join("state").join(name)).unwrap()
    }

    /// Some columns of a table.
    fn columns<const COUNT: usize>(&self, name: &str, columns: [&str; COUNT]) -> Vec<[String; COUNT]> {
        let text = self.text(name);
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let head = reader.headers().unwrap().clone();
        let at = columns.map(|column| head.iter().position(|name| name == column).unwrap());
        reader
            .records()
            .map(|row| {
                let row = row.unwrap();
                at.map(|at| row[at].to_owned())
            })
            .collect()
    }

    /// The table of transfers has the measured values of the complete recorded episodes, one each.
    fn is_recorded(&self) {
        let transfers = self.columns("transfers.csv", ["bits"]);
        let mut lives = self.columns("lives/lives.csv", ["bits", "status"]);
        lives.retain(|[_, status]| status == COMPLETE);
        let lives: Vec<_> = lives.into_iter().map(|[bits, _]| [bits]).collect();
        assert_eq!(transfers, lives);
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        // A leftover in the system's temporary directory does no harm.
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// From start to end, twice: the simulator proposes, the robot measures, and the best measured controller has the last
/// episodes.
#[test]
fn what_was_measured_decides() {
    let places = ["one", "other"].map(|name| Place::new(name, FILE, EXPERIMENT));
    for place in &places {
        place.lives(usize::MAX).unwrap();
        place.is_recorded();
    }
    let [place, other] = &places;
    let rows = place.columns("transfers.csv", ["why", "generation", "lives", "mean"]);
    let count = |why: &str| rows.iter().filter(|[reason, ..]| reason == why).count();
    // Of seven generations the best of the third and of the sixth had to wait, for ever.
    let news = rows.iter().filter(|[why, ..]| why == "new");
    let generations: Vec<&str> = news.map(|[_, generation, ..]| &**generation).collect();
    assert_eq!(generations, ["0", "1", "3", "4", "6"]);
    assert!(rows[2][0] == "again" && rows[5][0] == "again" && count("final") >= 2);
    // The last episode is of the controller with the highest mean, which has had enough of them.
    let [why, generation, lives, mean] = rows.last().unwrap();
    assert!(why == "final" && lives.parse::<u32>().unwrap() >= 6, "{rows:?}");
    let mut measured: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    let mut last = String::new();
    for [genome, fitness] in place.columns("lives/lives.csv", ["genome", "fitness"]) {
        measured
            .entry(genome.clone())
            .or_default()
            .push(fitness.parse().unwrap());
        last = genome;
    }
    let average = |values: &Vec<f64>| values.iter().sum::<f64>() / values.len() as f64;
    let best = measured.values().map(average).fold(f64::NAN, f64::max);
    assert_eq!(
        (average(&measured[&last]), measured[&last].len().to_string()),
        (best, lives.clone())
    );
    assert_eq!((best as f32).to_string(), *mean, "{generation}");
    for file in ["transfers.csv", "best.npy", "lives/life-1.csv", "lives/life-9.csv"] {
        let [one, two] = [place, other].map(|place| fs::read(place.0.join("state").join(file)).unwrap());
        assert!(one == two, "{file}");
    }
    let names = ["life", "genome", "key", "bits"];
    assert_eq!(
        place.columns("lives/lives.csv", names),
        other.columns("lives/lives.csv", names)
    );

    // All is done: no episode is repeated, and there is nothing to evolve.
    let before = place.text("transfers.csv");
    place.lives(0).unwrap();
    assert_eq!(place.text("transfers.csv"), before);
    // A robot with more transfers to do continues from there.
    fs::write(
        place.0.join("robot.toml"),
        FILE.replace("final_lives = 2", "final_lives = 3"),
    )
    .unwrap();
    place.lives(usize::MAX).unwrap();
    let more = place.text("transfers.csv");
    assert!(more.starts_with(&before) && more.lines().count() > before.lines().count());
    // Another experiment does not.
    fs::write(place.0.join("robot.toml"), FILE.replace("seed = 5", "seed = 6")).unwrap();
    let refused = place.lives(0).unwrap_err();
    assert_eq!(refused.code(), 5, "{refused}");
    let log = place.text("log.jsonl");
    let events = ["start", "connected", "transfer", "simulated", "end"];
    assert!(
        events
            .iter()
            .all(|event| log.contains(&format!("\"event\":\"{event}\""))),
        "{log}"
    );
}

/// Stopped again and again, at looks drawn from seeds: no episode is lost or taken for another, and the simulator's
/// part comes out as if there had been no interruption.
#[test]
fn a_robot_that_is_stopped_goes_on() {
    let whole = Place::new("whole", FILE, EXPERIMENT);
    whole.lives(usize::MAX).unwrap();
    let news = |place: &Place| {
        let mut rows = place.columns("transfers.csv", ["why", "generation", "individual", "simulated"]);
        rows.retain(|[why, ..]| why == "new");
        rows
    };
    let stopped = Place::new("stopped", FILE, EXPERIMENT);
    let mut stops = 0;
    for boot in 0_usize.. {
        // From the walk before an episode to beyond its end, which takes 26 looks.
        match stopped.lives(3 + 17 * boot % 41) {
            Ok(()) => break,
            Err(failure) => assert_eq!(failure.code(), 75, "{failure}"),
        }
        stops += 1;
        assert!(stops < 200);
    }
    assert!(stops > 10, "{stops}");
    stopped.is_recorded();
    assert_eq!(news(&stopped), news(&whole));
    let numbers = stopped.columns("transfers.csv", ["transfer"]);
    assert!(
        numbers
            .iter()
            .zip(0_u32..)
            .all(|([number_of_row], number)| *number_of_row == number.to_string())
    );
}

/// A robot that lacks what the experiment's has is refused by name, at its place.
#[test]
fn another_robot_is_refused() {
    let place = Place::new(
        "wrong",
        FILE,
        "[robot]\npreset = \"thymio2\"\n[arena]\nwidth_mm = 900\nheight_mm = 900\n",
    );
    let refused = place.lives(usize::MAX).unwrap_err();
    assert_eq!(refused.code(), 3, "{refused}");
    let words = refused.to_string();
    assert!(
        words.contains("robot.toml:3:11: address: ") && words.contains("Khepera"),
        "{words}"
    );
}

#[test]
fn what_is_not_allowed_is_refused_at_its_place() {
    for (name, replaced, by, experiment, expected) in [
        (
            "missing",
            "directory = \"state\"\n",
            "",
            EXPERIMENT,
            "robot.toml:1:1: lacks `directory`",
        ),
        (
            "again",
            "again_every = 3",
            "again_every = 1",
            EXPERIMENT,
            "robot.toml:8:15: transfers.again_every: is 1; allowed: 0 for never, or 2 to 100000",
        ),
        (
            "least",
            "least_lives = 4",
            "least_lives = 0",
            EXPERIMENT,
            "robot.toml:9:15: transfers.least_lives: is 0; allowed: 1 to 100000",
        ),
        (
            "generations",
            "generations = 1",
            "generations = 0",
            EXPERIMENT,
            "transfers.generations: is 0; allowed: 1 to 1000000",
        ),
        (
            "walk",
            "walk_s = 0.5",
            "walk_s = 601",
            EXPERIMENT,
            "robot.toml:12:10: lives.walk_s: is 601; allowed: 0 to 600",
        ),
        (
            "speed",
            "walk_s = 0.5",
            "speed_mm_s = 0",
            EXPERIMENT,
            "lives.speed_mm_s: is 0; allowed: 1 to 1100",
        ),
        (
            "tracker",
            "walk_s = 0.5",
            "tracker = \"5\"",
            EXPERIMENT,
            "lives.tracker: allowed: udp:HOST:PORT",
        ),
        (
            "starts",
            "walk_s = 0.5",
            "starts = \"hand\"",
            EXPERIMENT,
            "lives.starts: unknown key `starts`",
        ),
        (
            "address",
            "serial:/dev/none",
            "surrogate:1",
            EXPERIMENT,
            "robot.toml:3:11: address: robot surrogate:1: a surrogate has no link; allowed: serial:PATH",
        ),
        (
            "guard",
            "[lives]",
            "[guard]\nspeed = 1\n[lives]",
            EXPERIMENT,
            "guard speed: is no value of the guard",
        ),
        (
            "share",
            "[lives]",
            "[evolution]\nshare = 2\n[lives]",
            EXPERIMENT,
            "evolution.share: is 2; allowed: 0.01 to 1",
        ),
        ("none", "experiment.toml", "none.toml", EXPERIMENT, "none.toml: "),
        (
            "swarm",
            "",
            "",
            "[swarm]\n",
            "robot.toml:2:14: experiment: is experiment.toml, which has a swarm; allowed: an experiment of a single robot, or a member's file with robot, key and [radio]",
        ),
        (
            "crowd",
            "",
            "",
            "[robot]\npreset = \"epuck\"\ncount = 5\n[arena]\nwidth_mm = 900\nheight_mm = 900\n",
            "robot.toml:2:14: experiment: is experiment.toml, whose 5 robots share a world",
        ),
        (
            "forager",
            "",
            "",
            "[robot]\nkind = \"forager\"\n",
            "robot.toml:2:14: experiment: is experiment.toml, which can't run on a robot: robot.kind is `forager`",
        ),
        (
            "reality",
            "",
            "",
            "[reality]\nrobot = \"surrogate:1\"\n",
            "robot.toml:2:14: experiment: is experiment.toml, whose last generations run on reality.robot",
        ),
        (
            "value",
            "",
            "",
            "cycles = 0\n",
            "experiment.toml:1:10: cycles: is 0; allowed: 1 to 1000000",
        ),
    ] {
        let place = Place::new(name, &FILE.replace(replaced, by), experiment);
        let refused = place.settings().unwrap_err();
        assert_eq!(refused.code(), 3, "{name}: {refused}");
        assert!(refused.to_string().contains(expected), "{name}: {refused}");
    }
}

/// The documentation's file is read with the experiment that ships, and its table has the defaults.
#[test]
fn the_documented_file_is_allowed() {
    let page = include_str!("../../../../../docs/on-board.md");
    let (_, rest) = page.split_once("```toml\n# robot.toml\n").unwrap();
    let (file, _) = rest.split_once("```").unwrap();
    let place = Place::new("documented", file, "");
    let shipped = include_str!("../../../../../experiments/khepera-avoidance.toml");
    fs::write(place.0.join("khepera-avoidance.toml"), shipped).unwrap();
    let settings = place.settings().unwrap();
    assert_eq!((settings.seed, &settings.rules), (1, &transfers::Rules::default()));
    let transfers::Rules {
        generations,
        again_every,
        least_lives,
        final_lives,
    } = settings.rules;
    for (key, default) in [
        ("generations", generations),
        ("again_every", again_every),
        ("least_lives", least_lives),
        ("final_lives", final_lives),
    ] {
        assert!(page.contains(&format!("| `transfers.{key}` | {default} | ")), "{key}");
    }
    // 20 episodes of 50 s, each after 10 s, and one more.
    let time = settings.time();
    assert!(
        time.starts_with("at least 21 episodes on the robot: 21.0 robot-minutes"),
        "{time}"
    );
}
