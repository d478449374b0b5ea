//! The hostile parts in this folder, and the worlds that they are tried in.

use std::fs;
use std::path::Path;

use oneiro::arena::Patch;
use oneiro::compose::Kind;
use oneiro::differential::{Build, Differential, Sensor, SensorKind};
use oneiro::foraging::Forager;
use oneiro::world::{Controller, Robot, Task, WorldSpec};

/// A part that tries something.
pub(crate) struct Hostile {
    /// Its file's name.
    pub(crate) name: String,
    pub(crate) text: String,
    /// The rule that it breaks.
    pub(crate) rule: String,
    /// Why the compiled form may pass: nothing of it is left there, or what is left is harmless.
    pub(crate) passes: Option<String>,
}

/// All of them. The first line of each is `// RULE: WHAT IT TRIES`, or `// RULE (WHY): WHAT IT TRIES` where the compiled form may pass.
pub(crate) fn all(folder: &Path) -> Vec<Hostile> {
    let mut files: Vec<_> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    files.sort();
    files.retain(|file| file.extension().is_some_and(|kind| kind == "wgsl"));
    let read = |file: &std::path::PathBuf| {
        let text = fs::read_to_string(file).unwrap();
        let (head, _) = text.trim_start_matches("// ").split_once(':').expect("it names a rule");
        let (rule, passes) = match head.split_once(' ') {
            Some((rule, why)) => (rule, Some(why.to_owned())),
            None => (head, None),
        };
        Hostile {
            name: file.file_stem().unwrap().to_string_lossy().into_owned(),
            rule: rule.to_owned(),
            passes,
            text,
        }
    };
    files.iter().map(read).collect()
}

/// Fails with all that is wrong.
pub(crate) fn each(folder: &Path, wrong: impl Fn(&Hostile) -> Option<String>) {
    let all = all(folder);
    let problems: Vec<String> = all
        .iter()
        .filter_map(|hostile| Some(format!("{} [{}]: {}", hostile.name, hostile.rule, wrong(hostile)?)))
        .collect();
    assert!(all.len() > 200, "{} parts", all.len());
    assert!(
        problems.is_empty(),
        "{} of {}:\n{}",
        problems.len(),
        all.len(),
        problems.join("\n")
    );
}

impl Hostile {
    /// The kind that it is, and the world that it is for: a swarm's, a forager's, a parametric robot's, or the 1995 paper's. The part
    /// is yet to be put there.
    pub(crate) fn world(&self) -> (Kind, WorldSpec) {
        let mut spec = match self.name.split('-').next() {
            Some("swarm") => described(Some(3)),
            Some("described") => described(None),
            Some("forager") => WorldSpec::foraging(Forager::ODOWD2014),
            _ => WorldSpec::miglino1995(),
        };
        let kind = if self.text.contains("fn controller_cycle") {
            spec.controller = Controller::Own;
            Kind::Controller
        } else if self.text.contains("fn sensor_cycle") {
            Kind::Sensor
        } else {
            spec.task = Task::Own;
            Kind::Task
        };
        (kind, spec)
    }
}

/// A parametric robot, alone or in a swarm.
pub(crate) fn described(count: Option<u32>) -> WorldSpec {
    let mut spec = WorldSpec::miglino1995();
    spec.robot = Robot {
        build: Build::Differential(Differential {
            count,
            sensors: vec![Sensor {
                name: "front".into(),
                kind: SensorKind::Proximity,
                range: Some(200.0),
                ..Sensor::default()
            }],
            ..Differential::new(51.0, 128.0)
        }),
        ..Robot::khepera()
    };
    spec.arena.patches.push(Patch {
        x: 300.0,
        y: 200.0,
        radius: Some(100.0),
        ..Patch::default()
    });
    spec
}
