//! Parts written from knowledge of WGSL alone, in `tests/ordinary`: each compiles unchanged, and has the same bits on every device.

use std::path::Path;
use std::sync::Arc;

use oneiro::compose::{Kind, OwnPart, OwnParts, Part};
use oneiro::world::{Controller, Task, World, WorldSpec};

use crate::composed::Subject;
use crate::lives::{batch, world};

/// Cycles of an episode.
const CYCLES: u32 = 60;
/// A software driver takes seconds to compile each.
const FOR_GPU: usize = 6;

/// The worlds of all parts, by their files' names.
fn worlds() -> Vec<(String, World)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("ordinary");
    let mut files: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    files.sort();
    let with = |file: &std::path::PathBuf| {
        let name = file.file_stem().unwrap().to_string_lossy().into_owned();
        let text = std::fs::read_to_string(file).unwrap();
        let kind = match name.trim_end_matches(|c: char| c.is_ascii_digit()) {
            "task" => Kind::Task,
            "controller" => Kind::Controller,
            _ => Kind::Sensor,
        };
        let part = Part::new(kind, &format!("{name}.wgsl"), &text).unwrap_or_else(|refused| panic!("{refused}"));
        let part = OwnPart::new(Arc::new(part), &[]).unwrap();
        let change = |spec: &mut WorldSpec| {
            match kind {
                Kind::Task => spec.task = Task::Own,
                Kind::Controller => spec.controller = Controller::Own,
                Kind::Sensor => {}
            }
            spec.own = OwnParts::from([part.clone()]);
        };
        (name, world(CYCLES, change))
    };
    files.iter().map(with).collect()
}

pub(crate) fn subjects() -> Vec<Subject> {
    let worlds = worlds();
    assert!(worlds.len() >= 60, "{} parts", worlds.len());
    let subject = |(at, (name, world)): (usize, (String, World))| {
        let worlds = [world];
        let subject = Subject::new(name, 64, 2, |count| batch(&worlds, count, Some(1))).without_specialising();
        if at % FOR_GPU == 0 {
            subject
        } else {
            subject.without_gpu()
        }
    };
    worlds.into_iter().enumerate().map(subject).collect()
}
