//! The study with an emulated Khepera, byte by byte on a virtual clock, whose body is a surrogate in the paper's arena.

use std::fs;
use std::path::{Path, PathBuf};

use oneiro_lab::reality::wired::emulated::{INSTANT, SEED, Watched, connected};
use oneiro_report::page::check::unbalanced;
use oneiro_robots::link::Clock;

use super::*;
use crate::claims::Claim;
use crate::directory::{Directory, Reproduction};
use crate::miglino1995::Whole;
use crate::miglino1995::results::Results;
use crate::verdict::Verdict;

const POPULATION: usize = 6;
const CYCLES: u32 = 60;
/// All episodes: two of the transferred generation, two more generations, and the champions.
const LIVES: usize = 3 * (4 * POPULATION + 1);

/// A study in a directory that is removed at the end.
struct Place(PathBuf);

impl Place {
    /// Writes a study that is small.
    fn new() -> Self {
        let scratch = Self(std::env::temp_dir().join(format!("oneiro-study-on-wire-{}", std::process::id())));
        let _ = fs::remove_dir_all(&scratch.0);
        fs::create_dir_all(scratch.at("")).unwrap();
        let small = format!(
            "[set]\ncycles = {CYCLES}\nevolution = {{ generations = 4, population = {POPULATION}, parents = 2 }}\n"
        );
        let mut text = MIGLINO1995.text.to_owned();
        for (from, to) in [
            ("experiment = \"../khepera-avoidance.toml\"\n", ""),
            ("[set]\n", &small),
            ("generations = 20\n", "generations = 3\n"),
            ("walk_s = 10.0\n", "walk_s = 1.0\n"),
        ] {
            assert_eq!(text.matches(from).count(), 1, "{from}");
            text = text.replace(from, to);
        }
        fs::write(scratch.at("own.toml"), text).unwrap();
        scratch
    }

    fn at(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Runs the study with a robot, until all is done or the robot is stopped.
    fn study(&self, robot: Watched) -> Result<Found, String> {
        let asked = Asked {
            seed: 1,
            runs: Some(1),
            robot: "serial:/dev/none".parse().unwrap(),
            severity: None,
            full: false,
            tables: vec!["own".into()],
        };
        let file = StudyFile::open(&MIGLINO1995, Some(&self.at("own.toml"))).unwrap();
        let settings = Settings::new(&file, "main", asked).unwrap();
        let engine = evaluations();
        let whole = Whole {
            recordings: Some(samples(&settings, &engine)),
            settings,
            evaluations: &engine,
        };
        let directory = Directory::open(&self.at("out"), &whole).unwrap();
        let console = Console::new(Output {
            quiet: true,
            ..Output::default()
        });
        let site = whole.settings.site().recorded(self.at("out/lives"), console);
        let found = whole.at(site.connected(robot), &directory, console);
        let found = found.map_err(|failure| failure.to_string())?;
        let claims = whole.judge(&found);
        Ok(Found {
            page: whole.html(&found, &claims, None),
            tables: whole.csv(&found),
            json: String::from_utf8(whole.json(&found).unwrap()).unwrap(),
            results: found.1,
            claims,
        })
    }

    /// A column of the index of episodes.
    fn column(&self, name: &str) -> Vec<String> {
        let mut index = csv::Reader::from_path(self.at("out/lives/lives.csv")).unwrap();
        let at = index
            .headers()
            .unwrap()
            .iter()
            .position(|header| header == name)
            .unwrap();
        index.records().map(|row| row.unwrap()[at].to_owned()).collect()
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

struct Found {
    results: Results,
    claims: Vec<Claim>,
    page: String,
    tables: Vec<(&'static str, String)>,
    json: String,
}

/// The robot of a simulator made from the emulated robot's samples.
fn samples(settings: &Settings, engine: &Engine) -> Robot {
    let mut robot = Site::drawn(SEED, 1.0).sampled(engine, &settings.world()).unwrap();
    let samples = sample_unkept(&mut *robot, &Object::of_the_paper()).unwrap();
    simulated_robot(settings, samples.sensors, &samples.motors)
}

/// A robot that somebody puts where all champions start, when asked to.
fn robot() -> Watched {
    let mut robot = connected(INSTANT);
    robot.next.0 = [100.0, 90.0, 0.125];
    robot
}

/// Transfer, evolution and champions' episodes; stopped in the middle of an episode, and continued. Measured values are
/// judged, the others are reported as not measured, and no episode is repeated.
#[test]
fn a_study_of_a_connected_robot_goes_end_to_end() {
    let place = Place::new();
    let mut stopped = robot();
    // An episode with its walk takes 72 looks.
    stopped.looks = 30 * 72 + 20;
    assert!(
        place
            .study(stopped)
            .err()
            .unwrap()
            .contains("run the same command again")
    );
    let status = place.column("status");
    assert_eq!((status.len(), &*status[30]), (31, "stopped"));
    assert!(status[..30].iter().all(|status| status == "complete"));

    let Found {
        results,
        claims,
        page,
        tables,
        json,
    } = place.study(robot()).unwrap();
    let (status, keys) = (place.column("status"), place.column("key"));
    assert_eq!(status.len(), LIVES + 1);
    assert_eq!((&*status[30], &keys[30]), ("stopped", &keys[31]));
    let fitness = place
        .column("fitness")
        .into_iter()
        .filter(|fitness| !fitness.is_empty());
    let fitness: Vec<f32> = fitness.map(|fitness| fitness.parse().unwrap()).collect();
    assert_eq!(fitness.len(), LIVES);
    let mut other: Vec<&String> = keys.iter().collect();
    other.sort();
    other.dedup();
    // Those of a run number share their random numbers.
    assert_eq!(other.len(), LIVES / results.runs.len());
    // Conditions take turns, a generation each.
    for (condition, run) in results.runs.iter().enumerate() {
        let lived = |turn: usize| &fitness[(3 * turn + condition) * POPULATION..][..POPULATION];
        assert_eq!(run.condition as usize, condition);
        let turns = [&run.transferred.real, &run.transferred.real_again, &run.last];
        assert_eq!(turns.map(|turn| &turn[..]), [lived(0), lived(1), lived(3)]);
        assert_eq!((run.simulated.len(), run.real.len()), (5, 3));
        assert_eq!(run.champion.real.fitness, fitness[12 * POPULATION + condition]);
        assert_eq!(run.champion.real.path[0], [100.0, 90.0]);
        assert_eq!(run.champion.real.path.len(), CYCLES as usize + 1);
        assert_eq!(run.champion.discrepancy.paper.len(), CYCLES as usize / 5);
        assert!(run.champion.real.collided.is_nan() && run.transferred.other_robot.is_empty());
    }
    let mean = |episodes: &[f32]| episodes.iter().sum::<f32>() / episodes.len() as f32;
    assert!(mean(&fitness) > 0.0);

    for claim in &claims {
        let is_missing = ["C1", "C9", "C11"].contains(&&*claim.id);
        let says_so = claim.reasons.iter().any(|reason| reason.starts_with("Not measured"));
        assert_eq!(
            says_so && claim.verdict == Verdict::Undecided,
            is_missing,
            "{}",
            claim.id
        );
        assert_eq!(claim.remark.contains("Not measured: "), is_missing, "{}", claim.remark);
    }
    assert_eq!(unbalanced(&page), None);
    assert!(page.contains("Not measured: collisions in reality"));
    assert!(page.contains("serial:/dev/none, connected") && page.contains("<code>reality.walk_s</code>"));
    let claims = serde_json::to_string(&claims).unwrap();
    assert!(claims.contains("\"Not measured: collisions in reality") && json.contains("\"is_wired\":true"));
    let texts = [&page, &json, &claims]
        .into_iter()
        .chain(tables.iter().map(|(_, text)| text));
    for text in texts {
        assert!(!text.contains("NaN") && !text.contains("inf,"), "{text}");
    }

    // All is on record: no time passes.
    fs::remove_dir_all(place.at("out/cohorts")).unwrap();
    let idle = robot();
    let (bench, files) = (idle.bench.clone(), files(&place.at("out/lives")));
    let since = bench.now();
    assert_eq!(place.study(idle).unwrap().json, json);
    assert_eq!((bench.now(), self::files(&place.at("out/lives"))), (since, files));
}

/// Names and contents of a directory's files.
fn files(directory: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let paths = fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<_> = paths.map(|path| (path.clone(), fs::read(path).unwrap())).collect();
    files.sort();
    files
}
