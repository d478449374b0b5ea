//! Files of other simulators, as experiments. A file here reads each format and fills a [`Draft`]; Oneiro's own code checks the
//! experiment that comes of it.

use std::path::Path;

use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;
use serde_json::{Value, json};

use self::draft::{Draft, Note};
use crate::experiment::source::Parsed;
use crate::experiment::{Experiment, Files};

mod argos;
mod draft;
mod evorobotpy;
mod kheperax;
mod map;
mod maze;
mod outline;
mod playground;
#[cfg(all(test, feature = "compose"))]
mod tests;
mod traced;
mod xml;

/// The formats, as messages list them.
const FORMATS: &str = "ARGoS (.argos, .xml), Aseba's playgrounds (.playground), mazes of Kheperax (.py), mazes as texts (.txt), \
                       evorobotpy (.ini), maps of ROS (.yaml, .yml), maps as pictures (.png, .pgm)";

/// Formats by the extensions of their files; XML has its kind in its first element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Argos,
    Playground,
    Kheperax,
    Maze,
    Evorobotpy,
    RosMap,
    Picture,
}

impl Format {
    /// The simulator's name.
    fn name(self) -> &'static str {
        match self {
            Self::Argos => "ARGoS",
            Self::Playground => "an Aseba playground",
            Self::Kheperax => "Kheperax",
            Self::Maze => "a maze as text",
            Self::Evorobotpy => "evorobotpy",
            Self::RosMap => "a map of ROS",
            Self::Picture => "a map as picture",
        }
    }
}

/// An experiment made from another simulator's file.
#[derive(Debug)]
pub struct Imported {
    /// Name of the other simulator.
    pub format: &'static str,
    /// The experiment's file.
    pub text: String,
    /// The imported things.
    taken: Vec<Note>,
    /// The things that are not taken.
    left_out: Vec<Note>,
    /// The file's name.
    file: String,
}

impl Imported {
    /// A line for each thing that the experiment does not have: `FILE:LINE: <element attribute>: not taken: reason`.
    pub fn not_taken(&self) -> String {
        let lines = self
            .left_out
            .iter()
            .map(|note| note.line_of(&self.file, "not taken: ") + "\n");
        lines.collect()
    }

    /// Both lists, for programs. Lines count from 1.
    pub fn lists(&self) -> Value {
        let taken = |note: &Note| json!({ "line": note.line, "what": note.what, "key": note.why });
        let left_out = |note: &Note| {
            let lines: Vec<usize> = std::iter::once(note.line).chain(note.more.iter().copied()).collect();
            json!({ "lines": lines, "what": note.what, "why": note.why })
        };
        json!({
            "taken": self.taken.iter().map(taken).collect::<Value>(),
            "not_taken": self.left_out.iter().map(left_out).collect::<Value>(),
        })
    }

    /// Number of things in the experiment.
    pub fn taken(&self) -> usize {
        self.taken.len()
    }

    /// Number of things that it doesn't have.
    pub fn left_out(&self) -> usize {
        self.left_out.len()
    }
}

/// Sides of a map's pixel that are allowed, mm.
pub const PIXELS_MM: [f64; 2] = map::SIDES;
/// Tolerances of a map's walls that are allowed, mm.
pub const TOLERANCES_MM: [f64; 2] = map::TOLERANCES;

/// Options that only some formats have.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// The name of a maze, in a file of several.
    pub maze: Option<String>,
    /// Side of a pixel of a map, mm.
    pub mm_per_pixel: Option<f64>,
    /// How far a map's walls may be from where they are in the picture, mm.
    pub tolerance: Option<f64>,
    /// The grey from which on a pixel of a map is free, from 0 for black to 1 for white.
    pub threshold: Option<f64>,
}

impl Options {
    /// Refuses those that a format doesn't have.
    fn check(&self, name: &str, format: Format) -> Result {
        let is_map = [Format::RosMap, Format::Picture].contains(&format);
        let (maze, maps) = ("mazes of Kheperax (.py)", "maps as pictures (.png, .pgm)");
        for (flag, is_given, is_allowed, with) in [
            ("--maze", self.maze.is_some(), format == Format::Kheperax, maze),
            (
                "--mm-per-pixel",
                self.mm_per_pixel.is_some(),
                format == Format::Picture,
                maps,
            ),
            ("--threshold", self.threshold.is_some(), format == Format::Picture, maps),
            (
                "--tolerance",
                self.tolerance.is_some(),
                is_map,
                "maps (.yaml, .yml, .png, .pgm)",
            ),
        ] {
            if is_given && !is_allowed {
                let problem = format_args!("{flag}: {name} is {}; allowed: with {with}", format.name());
                return Err(Failure::input(problem));
            }
        }
        Ok(())
    }
}

/// Makes an experiment for the path `out` from another simulator's file, or from a map.
///
/// # Errors
/// Exit 3: the file, the line, what is wrong and what is allowed; exit 6 if reading fails.
pub fn import(path: &Path, options: &Options, out: &Path) -> Result<Imported> {
    let name = path.display().to_string();
    if extension(path).is_some_and(|extension| ["png", "pgm"].contains(&&*extension)) {
        options.check(&name, Format::Picture)?;
        let draft = map::of_picture(path, &name, options)?;
        return finished(draft, Format::Picture, &name, path, out);
    }
    let text = files::text(path)?;
    of_text(path, &text, options, out)
}

/// The extension of a file, in small letters.
fn extension(path: &Path) -> Option<String> {
    Some(path.extension()?.to_ascii_lowercase().to_str()?.to_owned())
}

fn of_text(path: &Path, text: &str, options: &Options, out: &Path) -> Result<Imported> {
    // Editors on Windows begin a file with it.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let is_xml = text.trim_start().starts_with('<');
    let text = &*if is_xml { xml::plain(text) } else { text.into() };
    let name = path.display().to_string();
    let format = format(path, &name, text)?;
    options.check(&name, format)?;
    let draft = match format {
        Format::Argos => argos::read(&name, text)?,
        Format::Playground => playground::read(&name, text)?,
        Format::Kheperax => kheperax::read(&name, text, options.maze.as_deref())?,
        Format::Maze => maze::read(&name, text)?,
        Format::Evorobotpy => evorobotpy::read(path, &name, text, out)?,
        Format::RosMap | Format::Picture => map::of_ros(path, &name, text, options)?,
    };
    finished(draft, format, &name, path, out)
}

/// Which format a file has.
fn format(path: &Path, name: &str, text: &str) -> Result<Format> {
    let start = text.trim_start();
    if start.starts_with('<') {
        return xml::root(name, text);
    }
    if ["--nstates", "--fsm-config", "--bt-config", "--nroot"]
        .iter()
        .any(|word| start.starts_with(word))
    {
        return Err(Failure::input(format_args!(
            "{name}:1: is a controller of AutoMoDe; allowed: {FORMATS}; \
             `oneiro evaluate EXPERIMENT --genomes FILE.txt` reads such texts"
        )));
    }
    match extension(path).as_deref() {
        Some("py") => Ok(Format::Kheperax),
        Some("txt") => Ok(Format::Maze),
        Some("ini") => Ok(Format::Evorobotpy),
        Some("yaml" | "yml") => Ok(Format::RosMap),
        Some("argos" | "xml" | "playground") => Err(Failure::input(format_args!(
            "{name}:1: is not XML; allowed: a file that begins with `<`"
        ))),
        _ => Err(Failure::input(format_args!(
            "{name}: is of no known format; allowed: {FORMATS}"
        ))),
    }
}

/// Writes a draft down if Oneiro accepts it as an experiment. Starts that it refuses become random ones.
fn finished(mut draft: Draft, format: Format, name: &str, path: &Path, out: &Path) -> Result<Imported> {
    let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mut text = draft.text(&file, format.name(), out);
    if let Err(problem) = checked(&text, out) {
        if !draft.forget_starts(&problem) {
            return Err(refused(name, &problem));
        }
        text = draft.text(&file, format.name(), out);
        checked(&text, out).map_err(|problem| refused(name, &problem))?;
    }
    Ok(Imported {
        format: format.name(),
        text,
        taken: draft.taken(),
        left_out: draft.left_out(),
        file: name.to_owned(),
    })
}

fn refused(name: &str, problem: &str) -> Failure {
    Failure::input(format_args!(
        "{name}: would be an experiment that Oneiro refuses: {problem}"
    ))
}

/// Reads an experiment's text as `oneiro check` does. A problem comes without its place, in a file that is not written yet.
fn checked(text: &str, out: &Path) -> std::result::Result<(), String> {
    let name = out.display().to_string();
    let values = Parsed::new(name.clone(), text);
    let read = values.and_then(|values| Experiment::of(out, &values, &[], &Files::default()));
    read.map(drop).map_err(|failure| {
        let problem = failure.to_string();
        let is_place = |c: char| c.is_ascii_digit() || c == ':' || c == ' ';
        let problem = problem
            .strip_prefix(&name)
            .map_or(&*problem, |rest| rest.trim_start_matches(is_place));
        problem.to_owned()
    })
}
