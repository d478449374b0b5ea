//! What has been read of a file, and the experiment's text that it becomes.

use std::fmt::Write as _;
use std::ops::RangeInclusive;
use std::path::Path;

use oneiro::arena::{GREATEST_OBJECTS, GREATEST_SEEN};
use oneiro::differential::GREATEST_MEMBERS;
use oneiro_base::console::shown;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;

/// Maximum of robots in a swarm.
pub(super) const GREATEST_COUNT: usize = GREATEST_MEMBERS as usize;
/// What is said of a rectangle in which robots start.
const ZONE: &str = "the rectangle in which the robots start";
/// Places that an experiment may name, mm.
const PLACES: RangeInclusive<f64> = -100_000.0..=100_000.0;
/// Sides of an arena, a block or a patch, mm.
const SIDES: RangeInclusive<f64> = 1.0..=100_000.0;

/// Something in the file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Note {
    /// From 1.
    pub(super) line: usize,
    /// Such as `<box movable>`.
    pub(super) what: String,
    /// Why it is not taken, or the key that has it.
    pub(super) why: String,
    /// Other lines with the same.
    pub(super) more: Vec<usize>,
}

impl Note {
    pub(super) fn new(line: usize, what: impl Into<String>, why: impl Into<String>) -> Self {
        Self {
            line,
            what: what.into(),
            why: why.into(),
            more: Vec::new(),
        }
    }

    /// The note in one line that begins with its place.
    pub(super) fn line_of(&self, file: &str, verb: &str) -> String {
        /// Lines that are listed.
        const LISTED: usize = 8;
        let Self { line, what, why, more } = self;
        let listed: Vec<String> = more.iter().take(LISTED).map(ToString::to_string).collect();
        let rest = match more.len().saturating_sub(LISTED) {
            0 => String::new(),
            rest => format!(" and {rest} more"),
        };
        let also = match more.len() {
            0 => String::new(),
            1 => format!(" (also line {})", listed[0]),
            _ => format!(" (also lines {}{rest})", listed.join(", ")),
        };
        in_line(&format!("{file}:{line}: {what}: {verb}{why}{also}"))
    }
}

/// A text that is safe in a comment of one line.
fn in_line(text: &str) -> String {
    shown(text).replace(['\n', '\t'], " ")
}

/// A thing at a place, mm in the file's coordinates, angles in degrees counter-clockwise.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Thing {
    Wall {
        from: [f64; 2],
        to: [f64; 2],
    },
    Obstacle {
        at: [f64; 2],
        radius: f64,
    },
    Block {
        at: [f64; 2],
        sides: [f64; 2],
        degrees: f64,
    },
    Light {
        at: [f64; 2],
        /// Height in mm and intensity, for robots with a reference model.
        lamp: Option<[f64; 2]>,
    },
    Disc {
        at: [f64; 2],
        radius: f64,
        grey: f64,
    },
    Rectangle {
        at: [f64; 2],
        sides: [f64; 2],
        degrees: f64,
        grey: f64,
    },
}

impl Thing {
    fn table(&self) -> &'static str {
        match self {
            Self::Wall { .. } => "arena.walls",
            Self::Obstacle { .. } => "arena.obstacles",
            Self::Block { .. } => "arena.blocks",
            Self::Light { .. } => "arena.lights",
            Self::Disc { .. } | Self::Rectangle { .. } => "arena.patches",
        }
    }

    /// Whether robots bump into it.
    fn is_solid(&self) -> bool {
        matches!(self, Self::Wall { .. } | Self::Obstacle { .. } | Self::Block { .. })
    }

    /// Its keys and values; `place` moves a point into the experiment's coordinates.
    fn values(&self, place: impl Fn([f64; 2]) -> [f64; 2]) -> Vec<(&'static str, String)> {
        let centred = |at: [f64; 2]| {
            let [x, y] = place(at);
            vec![("x_mm", number(x)), ("y_mm", number(y))]
        };
        let heading = |degrees: f64| (degrees != 0.0).then(|| ("heading_deg", number(degrees)));
        match *self {
            Self::Wall { from, to } => vec![("from_mm", pair(place(from))), ("to_mm", pair(place(to)))],
            Self::Obstacle { at, radius } => [centred(at), vec![("radius_mm", number(radius))]].concat(),
            Self::Block { at, sides, degrees } => {
                let mut values = centred(at);
                values.extend([("length_mm", number(sides[0])), ("width_mm", number(sides[1]))]);
                values.extend(heading(degrees));
                values
            }
            Self::Light { at, lamp } => {
                let mut values = centred(at);
                if let Some([height, intensity]) = lamp {
                    values.extend([("height_mm", number(height)), ("intensity", number(intensity))]);
                }
                values
            }
            Self::Disc { at, radius, grey } => {
                [centred(at), vec![("radius_mm", number(radius)), ("grey", number(grey))]].concat()
            }
            Self::Rectangle {
                at,
                sides,
                degrees,
                grey,
            } => {
                let mut values = centred(at);
                values.push(("sides_mm", pair(sides)));
                values.extend(heading(degrees));
                values.push(("grey", number(grey)));
                values
            }
        }
    }

    /// A part of it that is out of range, with the allowed range.
    fn problem(&self) -> Option<String> {
        let outside = |word: &str, value: f64, range: &RangeInclusive<f64>| {
            (!range.contains(&value)).then(|| {
                format!(
                    "its {word} is {} mm; allowed: {} to {} mm",
                    number(value),
                    range.start(),
                    range.end()
                )
            })
        };
        let place = |at: &[f64; 2]| at.iter().find_map(|value| outside("place", *value, &PLACES));
        let both = |sides: &[f64; 2]| sides.iter().find_map(|side| outside("side", *side, &SIDES));
        match self {
            Self::Wall { from, to } => place(from).or_else(|| place(to)),
            Self::Obstacle { at, radius } => place(at).or_else(|| outside("radius", *radius, &(0.0..=100_000.0))),
            Self::Block { at, sides, .. } | Self::Rectangle { at, sides, .. } => place(at).or_else(|| both(sides)),
            Self::Light { at, lamp } => place(at).or_else(|| {
                let [height, intensity] = (*lamp)?;
                let is_bright = (0.01..=1000.0).contains(&intensity);
                outside("height", height, &(0.0..=100_000.0))
                    .or_else(|| (!is_bright).then(|| format!("its intensity is {intensity}; allowed: 0.01 to 1000")))
            }),
            Self::Disc { at, radius, .. } => place(at).or_else(|| outside("radius", *radius, &SIDES)),
        }
    }
}

/// What encloses the arena, mm in the file's coordinates.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Outline {
    Rectangle {
        low: [f64; 2],
        size: [f64; 2],
    },
    /// A rectangle whose walls are among the things.
    Walled {
        low: [f64; 2],
        size: [f64; 2],
    },
    /// Corners counter-clockwise.
    Polygon(Vec<[f64; 2]>),
}

impl Outline {
    /// Walls that it adds.
    fn count(&self) -> usize {
        match self {
            Self::Rectangle { .. } => 4,
            Self::Walled { .. } => 0,
            Self::Polygon(corners) => corners.len(),
        }
    }

    /// The point that is at (0, 0) in the experiment.
    fn origin(&self) -> [f64; 2] {
        match self {
            Self::Rectangle { low, .. } | Self::Walled { low, .. } => *low,
            Self::Polygon(_) => [0.0; 2],
        }
    }
}

/// Where a robot starts, mm in the file's coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Start {
    pub(super) line: usize,
    pub(super) at: [f64; 2],
    /// Its heading, or none for a random one.
    pub(super) degrees: Option<f64>,
}

/// A value of a table.
#[derive(Debug)]
struct Entry {
    table: &'static str,
    key: &'static str,
    /// As TOML.
    value: String,
    /// The file's line, unless the value is Oneiro's.
    line: Option<usize>,
    what: String,
}

/// An experiment that is being read.
#[derive(Debug)]
pub(super) struct Draft {
    /// The file's path, for errors.
    name: String,
    /// Sentences on the file's unit of length.
    unit: String,
    entries: Vec<Entry>,
    outline: Option<(Outline, usize, String)>,
    things: Vec<(Thing, Note)>,
    /// Classes of walls and of obstacles, where tables have others than Oneiro's.
    pub(super) classes: Option<[&'static str; 2]>,
    /// One robot's start, or those of all robots of a swarm.
    starts: Vec<Start>,
    /// The line, and the corners of the rectangle in which all start.
    zone: Option<(usize, [[f64; 2]; 2])>,
    is_swarm: bool,
    left_out: Vec<Note>,
}

impl Draft {
    /// An empty one for a file's path. `unit` says what a unit of its lengths is.
    pub(super) fn new(name: &str, unit: impl Into<String>) -> Self {
        Self {
            name: name.to_owned(),
            unit: unit.into(),
            entries: Vec::new(),
            outline: None,
            things: Vec::new(),
            classes: None,
            starts: Vec::new(),
            zone: None,
            is_swarm: false,
            left_out: Vec::new(),
        }
    }

    /// An error at a line of the file.
    pub(super) fn failure(&self, line: usize, problem: impl std::fmt::Display) -> Failure {
        failure(&self.name, line, problem)
    }

    /// Sets a key to a TOML value; `what` names it in the file.
    pub(super) fn set(
        &mut self,
        (table, key): (&'static str, &'static str),
        value: impl Into<String>,
        line: usize,
        what: impl Into<String>,
    ) {
        self.entries.push(Entry {
            table,
            key,
            value: value.into(),
            line: Some(line),
            what: what.into(),
        });
    }

    /// Sets a key to Oneiro's value, for a reason.
    pub(super) fn choose(
        &mut self,
        (table, key): (&'static str, &'static str),
        value: impl Into<String>,
        why: impl Into<String>,
    ) {
        self.entries.push(Entry {
            table,
            key,
            value: value.into(),
            line: None,
            what: why.into(),
        });
    }

    /// Notes that something is not taken.
    pub(super) fn leave_out(&mut self, line: usize, what: impl Into<String>, why: impl Into<String>) {
        self.left_out.push(Note::new(line, what, why));
    }

    pub(super) fn leave_all_out(&mut self, notes: Vec<Note>) {
        self.left_out.extend(notes);
    }

    /// Sets what encloses the arena.
    ///
    /// # Errors
    /// Exit 3 if it is too small or too large.
    pub(super) fn enclose(&mut self, outline: Outline, line: usize, what: impl Into<String>) -> Result {
        let what = what.into();
        if let Outline::Rectangle { size, .. } | Outline::Walled { size, .. } = &outline
            && let Some(side) = size.iter().find(|side| !SIDES.contains(side))
        {
            return Err(self.failure(
                line,
                format_args!(
                    "{what}: is {} mm; allowed: {} to {} mm",
                    number(*side),
                    SIDES.start(),
                    SIDES.end()
                ),
            ));
        }
        self.outline = Some((outline, line, what));
        Ok(())
    }

    /// Adds a thing.
    ///
    /// # Errors
    /// Exit 3 if its place or its size is out of range.
    pub(super) fn add(&mut self, thing: Thing, line: usize, what: impl Into<String>) -> Result {
        let what = what.into();
        // The thinnest boxes are walls.
        let thing = match thing {
            Thing::Block { at, sides, degrees } if sides[0].min(sides[1]) < 1.0 && sides[0].max(sides[1]) >= 1.0 => {
                let is_across = sides[1] > sides[0];
                let angle = (degrees + if is_across { 90.0 } else { 0.0 }).to_radians();
                let half = 0.5 * sides[0].max(sides[1]);
                let along = [half * angle.cos(), half * angle.sin()];
                Thing::Wall {
                    from: [at[0] - along[0], at[1] - along[1]],
                    to: [at[0] + along[0], at[1] + along[1]],
                }
            }
            thing => thing,
        };
        if let Some(problem) = thing.problem() {
            return Err(self.failure(line, format_args!("{what}: {problem}")));
        }
        let table = thing.table();
        self.things.push((thing, Note::new(line, what, table)));
        Ok(())
    }

    /// Sets where robots start: one robot, or all of a swarm. None: at random places.
    pub(super) fn start_at(&mut self, starts: Vec<Start>, is_swarm: bool) {
        self.starts = starts;
        self.is_swarm = is_swarm;
    }

    /// Lets all robots start in the rectangle between these corners.
    pub(super) fn start_within(&mut self, line: usize, corners: [[f64; 2]; 2]) {
        self.zone = Some((line, corners));
    }

    /// Removes the starts that an experiment is refused for. Returns whether there were any.
    pub(super) fn forget_starts(&mut self, problem: &str) -> bool {
        let count = self.entries.len();
        let is_radius = |entry: &Entry| entry.key == "start_radius_mm";
        let radius = self.entries.iter().find(|entry| is_radius(entry));
        let radius = radius.map(|entry| (entry.line.unwrap_or(1), entry.what.clone()));
        let zone = self.zone.take().map(|(line, _)| (line, ZONE.to_owned()));
        let why = format!("starts are random, since Oneiro refuses these: {problem}");
        for (line, what) in radius.into_iter().chain(zone) {
            self.leave_out(line, what, why.clone());
        }
        self.entries.retain(|entry| !is_radius(entry));
        for start in std::mem::take(&mut self.starts) {
            self.leave_out(start.line, "the robot's start", why.clone());
        }
        self.left_out.last().is_some_and(|note| note.why == why) || self.entries.len() < count
    }

    /// Leaves out the solid things for which Oneiro has no room.
    fn shorten(&mut self) {
        let looks_at_all = |entry: &Entry| {
            entry.table == "robot" && (["model", "tables"].contains(&entry.key) || entry.value.contains("rm1."))
        };
        let most = if self.entries.iter().any(looks_at_all) {
            GREATEST_SEEN
        } else {
            GREATEST_OBJECTS
        };
        let sides = self.outline.as_ref().map_or(0, |(outline, ..)| outline.count());
        let room = most.saturating_sub(sides);
        let count = self.things.iter().filter(|(thing, _)| thing.is_solid()).count();
        let mut kept = 0;
        let (name, left_out) = (count, &mut self.left_out);
        self.things.retain(|(thing, note)| {
            kept += usize::from(thing.is_solid());
            let is_kept = !thing.is_solid() || kept <= room;
            if !is_kept {
                let why = format!(
                    "{name} walls, obstacles and blocks; allowed: {most} together, the arena's sides included; those of the \
                     first lines are taken"
                );
                left_out.push(Note::new(note.line, note.what.clone(), why));
            }
            is_kept
        });
    }

    /// The experiment's text.
    pub(super) fn text(&mut self, file: &str, format: &str, out: &Path) -> String {
        self.shorten();
        let origin = self.outline.as_ref().map_or([0.0; 2], |(outline, ..)| outline.origin());
        let place = |at: [f64; 2]| [at[0] - origin[0], at[1] - origin[1]];
        let moved = match origin.map(|value| value + 0.0) {
            [0.0, 0.0] => String::new(),
            [x, y] => format!(
                " Places are moved by {} mm in x and {} mm in y.",
                number(-x),
                number(-y)
            ),
        };
        let mut text = format!(
            "# Imported from {} ({format}) by `oneiro import`. {}{moved}\n# Comments name the lines that things are from.\n#\n#     oneiro run {} \
             --seed 1\n",
            in_line(file),
            self.unit,
            in_line(&files::for_shell(
                &out.file_name().unwrap_or_default().to_string_lossy()
            ))
        );
        let left_out = self.left_out();
        if !left_out.is_empty() {
            text += "#\n# Not taken:\n";
        }
        for note in &left_out {
            let _ = writeln!(text, "# {}", note.line_of(file, ""));
        }
        let values = |text: &mut String, values: &[(&str, String)]| {
            for (key, value) in values {
                let _ = writeln!(text, "{key} = {value}");
            }
        };
        let entries = |text: &mut String, table: &str| {
            for entry in self.entries.iter().filter(|entry| entry.table == table) {
                let _ = match entry.line {
                    Some(line) => writeln!(text, "# {}", in_line(&format!("{file}:{line}: {}", entry.what))),
                    None => writeln!(text, "# {}", in_line(&entry.what)),
                };
                let _ = writeln!(text, "{} = {}", entry.key, entry.value);
            }
        };
        let has = |table: &str| self.entries.iter().any(|entry| entry.table == table);
        let mut lines: Vec<String> = self.starts.iter().map(|start| start.line.to_string()).collect();
        lines.dedup();
        let lines = lines.join(", ");
        let headings: Option<Vec<f64>> = self.starts.iter().map(|start| start.degrees).collect();
        if has("") {
            text.push('\n');
            entries(&mut text, "");
        }
        if has("robot") {
            text += "\n[robot]\n";
            entries(&mut text, "robot");
            if self.is_swarm && !self.starts.is_empty() && headings.is_none() {
                let _ = writeln!(text, "# {}:{lines}: starts, with random headings", in_line(file));
                let starts: Vec<String> = self.starts.iter().map(|start| pair(place(start.at))).collect();
                let _ = writeln!(text, "starts_mm = [{}]", starts.join(", "));
            }
        }
        if has("arena") || self.outline.is_some() {
            text += "\n[arena]\n";
            if let Some((outline, line, what)) = &self.outline {
                let _ = writeln!(text, "# {}", in_line(&format!("{file}:{line}: {what}")));
                match outline {
                    Outline::Rectangle { size, .. } | Outline::Walled { size, .. } => {
                        values(
                            &mut text,
                            &[("width_mm", number(size[0])), ("height_mm", number(size[1]))],
                        );
                    }
                    Outline::Polygon(corners) => {
                        let corners: Vec<String> = corners.iter().map(|corner| pair(*corner)).collect();
                        let _ = writeln!(text, "corners_mm = [\n    {},\n]", corners.join(",\n    "));
                    }
                }
            }
            entries(&mut text, "arena");
        }
        let class = |index: usize| self.classes.map(|classes| ("class", format!("{:?}", classes[index])));
        if let Some((Outline::Rectangle { size, .. }, line, _)) = &self.outline
            && (self.classes.is_some() || self.things.iter().any(|(thing, _)| matches!(thing, Thing::Wall { .. })))
        {
            let [x, y] = *size;
            let corners = [[0.0, 0.0], [x, 0.0], [x, y], [0.0, y]];
            for (index, from) in corners.iter().enumerate() {
                let to = corners[(index + 1) % 4];
                let _ = writeln!(
                    text,
                    "\n# {}:{line}: a side of the arena\n[[arena.walls]]",
                    in_line(file)
                );
                values(&mut text, &[("from_mm", pair(*from)), ("to_mm", pair(to))]);
                values(&mut text, class(0).as_slice());
            }
        }
        for (thing, note) in &self.things {
            let comment = in_line(&format!("{file}:{}: {}", note.line, note.what));
            let _ = writeln!(text, "\n# {comment}\n[[{}]]", thing.table());
            values(&mut text, &thing.values(place));
            match thing {
                Thing::Wall { .. } => values(&mut text, class(0).as_slice()),
                Thing::Obstacle { .. } => values(&mut text, class(1).as_slice()),
                _ => (),
            }
        }
        if let Some(headings) = headings.filter(|headings| self.is_swarm && !headings.is_empty()) {
            let _ = writeln!(
                text,
                "\n# {}:{lines}: the robots' starts, headings in turns\n[start]\nkind = \"poses\"",
                in_line(file)
            );
            let poses = self.starts.iter().zip(headings).map(|(start, degrees)| {
                let [x, y] = place(start.at);
                format!("[{}, {}, {}]", number(x), number(y), turns(degrees))
            });
            let poses: Vec<String> = poses.collect();
            let _ = writeln!(text, "poses = [{}]", poses.join(", "));
        } else if let Some((line, [low, high])) = self.zone {
            let [[x, y], sides] = [
                place([0, 1].map(|axis| 0.5 * (low[axis] + high[axis]))),
                [0, 1].map(|axis| high[axis] - low[axis]),
            ];
            let _ = writeln!(text, "\n# {}:{line}: {ZONE}\n[start]\nkind = \"zone\"", in_line(file));
            let zone = [("x_mm", number(x)), ("y_mm", number(y)), ("sides_mm", pair(sides))];
            values(&mut text, &zone);
        } else if !self.is_swarm
            && let [start] = self.starts[..]
        {
            let [x, y] = place(start.at);
            let _ = writeln!(
                text,
                "\n# {}:{lines}: the robot's start\n[start]\nkind = \"at\"",
                in_line(file)
            );
            let at = [
                ("x_mm", number(x)),
                ("y_mm", number(y)),
                ("heading_deg", number(start.degrees.unwrap_or_default())),
            ];
            values(&mut text, &at);
        }
        for table in ["start", "controller", "noise", "evolution"] {
            if has(table) {
                let _ = writeln!(text, "\n[{table}]");
                entries(&mut text, table);
            }
        }
        text
    }

    /// The imported things, in the file's order.
    pub(super) fn taken(&self) -> Vec<Note> {
        let key = |entry: &Entry| match entry.table {
            "" => entry.key.to_owned(),
            table => format!("{table}.{}", entry.key),
        };
        let entries = self.entries.iter();
        let mut all: Vec<Note> = entries
            .filter_map(|entry| Some(Note::new(entry.line?, &*entry.what, key(entry))))
            .collect();
        all.extend(self.things.iter().map(|(_, note)| note.clone()));
        all.extend(
            self.outline
                .iter()
                .map(|(_, line, what)| Note::new(*line, &**what, "arena")),
        );
        all.extend(
            self.starts
                .iter()
                .map(|start| Note::new(start.line, "the robot's start", "start")),
        );
        all.extend(self.zone.map(|(line, _)| Note::new(line, ZONE, "start")));
        all.sort_by_key(|note| note.line);
        all
    }

    /// The things that are not taken, in the file's order; equal notes of several lines are one.
    pub(super) fn left_out(&self) -> Vec<Note> {
        let mut all = self.left_out.clone();
        all.sort_by_key(|note| note.line);
        let mut merged: Vec<Note> = Vec::new();
        let mut known = std::collections::BTreeMap::new();
        for note in all {
            let at = *known
                .entry((note.what.clone(), note.why.clone()))
                .or_insert(merged.len());
            match merged.get_mut(at) {
                Some(same) if same.line == note.line || same.more.last() == Some(&note.line) => (),
                Some(same) => same.more.push(note.line),
                None => merged.push(note),
            }
        }
        merged
    }
}

/// An error at a line of a file.
pub(super) fn failure(name: &str, line: usize, problem: impl std::fmt::Display) -> Failure {
    Failure::input(format_args!("{name}:{line}: {problem}"))
}

/// A number as TOML, to a thousandth.
pub(super) fn number(value: f64) -> String {
    let rounded = (value * 1000.0).round() / 1000.0;
    // Zero has one sign.
    format!("{:?}", rounded + 0.0)
}

/// An angle in degrees as turns in TOML, to a millionth.
fn turns(degrees: f64) -> String {
    format!("{:?}", (degrees / 360.0 * 1e6).round() / 1e6 + 0.0)
}

/// Two numbers as TOML.
pub(super) fn pair([x, y]: [f64; 2]) -> String {
    format!("[{}, {}]", number(x), number(y))
}

/// An angle in degrees from -180 to 180.
pub(super) fn turned(degrees: f64) -> f64 {
    let rest = degrees.rem_euclid(360.0);
    if rest > 180.0 { rest - 360.0 } else { rest }
}
