//! Maps as pictures, with a file of ROS's map server or without. Free pixels are the floor; their boundary becomes walls.

use std::path::Path;

use oneiro::arena::GREATEST_OBJECTS;
use oneiro_base::console::shown;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;

use super::Options;
use super::draft::{Draft, Outline, Thing, failure, number};
use super::traced::{self, Corner, Free, Many};
use crate::pixels::{self, Pixels};

/// Sides of a pixel, and tolerances, mm.
pub(super) const SIDES: [f64; 2] = [0.01, 10_000.0];
pub(super) const TOLERANCES: [f64; 2] = [0.0, 10_000.0];
/// The radius of the robot's body that stands in a map, mm: an e-puck's.
const BODY: f64 = 35.0;

/// The class of a pixel.
#[derive(Clone, Copy, PartialEq)]
enum Pixel {
    Free,
    Occupied,
    Unknown,
}

/// How a picture is read.
struct Reading<'a> {
    /// The picture's name in messages and comments.
    picture: &'a str,
    /// The line of the file that names it; `None` if it is the file.
    line: Option<usize>,
    /// Side of a pixel, mm.
    side: f64,
    /// mm, unless it is the side of a pixel.
    tolerance: Option<f64>,
    /// The rest of the first comment.
    words: String,
}

/// Reads a picture.
///
/// # Errors
/// Exit 3: what is wrong, what is allowed; exit 6 if reading fails.
pub(super) fn of_picture(path: &Path, name: &str, options: &Options) -> Result<Draft> {
    let Some(side) = options.mm_per_pixel else {
        return Err(Failure::input(format_args!(
            "{name}: lacks the size of its pixels; allowed: with --mm-per-pixel MM, or the .yaml file of a map of ROS"
        )));
    };
    flag("--mm-per-pixel", side, SIDES, " mm")?;
    let threshold = options.threshold.unwrap_or(0.5);
    flag("--threshold", threshold, [0.0, 1.0], "")?;
    let pixels = opened(path)?;
    let reading = Reading {
        picture: name,
        line: None,
        side,
        tolerance: options.tolerance,
        words: format!("Pixels are free from a grey of {threshold} on, if 0 is black and 1 is white"),
    };
    let class = |grey: f64| {
        if grey >= threshold {
            Pixel::Free
        } else {
            Pixel::Occupied
        }
    };
    drafted(name, &reading, &pixels, class)
}

/// Reads the file of a map of ROS, and the picture that it names.
///
/// # Errors
/// Exit 3: the line, what is wrong, what is allowed; exit 6 if reading fails.
pub(super) fn of_ros(path: &Path, name: &str, text: &str, options: &Options) -> Result<Draft> {
    let keys = Keys::read(name, text)?;
    let (line, picture) = keys.needed("image")?;
    let picture = plain(picture);
    let side = 1000.0 * keys.number("resolution", None, [SIDES[0] / 1000.0, SIDES[1] / 1000.0])?;
    let occupied = keys.number("occupied_thresh", Some(0.65), [0.0, 1.0])?;
    let free = keys.number("free_thresh", Some(0.196), [0.0, 1.0])?;
    let is_negated = match keys.value("negate").map(|(line, value)| (line, plain(value))) {
        None | Some((_, "0" | "false")) => false,
        Some((_, "1" | "true")) => true,
        Some((line, other)) => {
            return Err(failure(
                name,
                line,
                format_args!("negate: is {}; allowed: 0 and 1", shown(other)),
            ));
        }
    };
    if let Some((line, mode)) = keys.value("mode")
        && !["trinary", "scale"].contains(&plain(mode))
    {
        let problem = format_args!("mode: is {}; allowed: trinary and scale", shown(plain(mode)));
        return Err(failure(name, line, problem));
    }
    let (origin_line, origin) = keys.origin()?;
    let file = path.parent().unwrap_or(Path::new("")).join(picture);
    let pixels = opened(&file).map_err(|problem| failure(name, line, format_args!("image: {problem}")))?;
    let frame = [0, 1].map(|axis| number(1000.0 * origin[axis]));
    let reading = Reading {
        picture,
        line: Some(line),
        side,
        tolerance: options.tolerance,
        words: format!(
            "Pixels are free where they are occupied by less than {free}, and unknown from there to {occupied}; unknown ones count as \
             occupied. The place (0, 0) here is ({}, {}) mm in the map's frame",
            frame[0], frame[1]
        ),
    };
    let class = |grey: f64| {
        let share = if is_negated { grey } else { 1.0 - grey };
        match share {
            _ if share > occupied => Pixel::Occupied,
            _ if share < free => Pixel::Free,
            _ => Pixel::Unknown,
        }
    };
    let mut draft = drafted(name, &reading, &pixels, class)?;
    if origin[2] != 0.0 {
        let why = format!(
            "the map is not turned by {} rad: walls are as in the picture",
            number(origin[2])
        );
        draft.leave_out(origin_line, "the angle of the origin", why);
    }
    for (line, key) in keys.unknown() {
        draft.leave_out(
            line,
            format!("`{}`", shown(key)),
            "it is no key of a map that this reads",
        );
    }
    Ok(draft)
}

/// Opens a picture.
fn opened(path: &Path) -> Result<Pixels> {
    let bytes = files::bytes(path)?;
    pixels::read(&bytes).map_err(|problem| Failure::input(format_args!("{} {problem}", path.display())))
}

/// Checks a number of the command line.
fn flag(flag: &str, value: f64, [least, most]: [f64; 2], unit: &str) -> Result {
    if (least..=most).contains(&value) {
        return Ok(());
    }
    Err(Failure::input(format_args!(
        "{flag}: is {value}; allowed: {least} to {most}{unit}"
    )))
}

/// Traces a map, and fills a draft with its walls.
fn drafted(name: &str, reading: &Reading<'_>, pixels: &Pixels, class: impl Fn(f64) -> Pixel) -> Result<Draft> {
    let Reading { picture, side, .. } = *reading;
    let tolerance = reading.tolerance.unwrap_or(side);
    flag("--tolerance", tolerance, TOLERANCES, " mm")?;
    let line = reading.line.unwrap_or(1);
    let refused = |problem: &dyn std::fmt::Display| match reading.line {
        Some(line) => failure(name, line, format_args!("image: {picture} {problem}")),
        None => Failure::input(format_args!("{name} {problem}")),
    };
    let (width, height) = (pixels.width as usize, pixels.height as usize);
    let classes: Vec<Pixel> = pixels
        .greys
        .iter()
        .map(|grey| class(f64::from(*grey) / f64::from(u16::MAX)))
        .collect();
    let count = |wanted: Pixel| classes.iter().filter(|class| **class == wanted).count();
    let counts = format!(
        "{width} x {height} pixels: {} free, {} occupied, {} unknown",
        count(Pixel::Free),
        count(Pixel::Occupied),
        count(Pixel::Unknown)
    );
    let from_below = classes.chunks(width).rev().flatten();
    let free = Free::new(width, height, from_below.map(|class| *class == Pixel::Free).collect());
    let Some(roomiest) = free.roomiest() else {
        return Err(refused(&format_args!(
            "has no free pixel: {counts}; allowed: a map with free pixels"
        )));
    };
    let outlines = free.outlines().map_err(|problem| refused(&problem))?;
    let walls = traced::walls(&outlines, tolerance / side, GREATEST_OBJECTS).map_err(|many| match many {
        Many::Outlines(outlines) => refused(&format_args!(
            "has {outlines} separate outlines; allowed: up to {GREATEST_OBJECTS} walls; remove specks from the picture"
        )),
        Many::Tolerance(pixels) => {
            // In tenths of a mm, upwards.
            let enough = (10.0 * pixels * side).ceil() / 10.0;
            refused(&format_args!(
                "has more than {GREATEST_OBJECTS} walls at a tolerance of {tolerance} mm; allowed: --tolerance of {enough} mm or more"
            ))
        }
    })?;
    let mut draft = Draft::new(
        name,
        format!(
            "A pixel is {} mm wide. Walls are within {} mm of the edges of free pixels. {}.",
            number(side),
            number(tolerance),
            reading.words
        ),
    );
    let size = [width as f64 * side, height as f64 * side];
    draft.enclose(Outline::Walled { low: [0.0; 2], size }, line, counts)?;
    for (outline, ends) in &walls {
        let [x, y] = outlines[*outline][0];
        // The first pixel of an outline is above its lowest corner.
        let row = height - (y as usize).min(height - 1);
        let what = format!(
            "a wall of outline {}, which begins at pixel {} of row {row}",
            outline + 1,
            x + 1
        );
        let [from, to] = ends.map(|corner| placed(corner, side));
        draft.add(Thing::Wall { from, to }, reading.line.unwrap_or(row), what)?;
    }
    draft.choose(
        ("robot", "preset"),
        "\"epuck\"",
        "A map names no robot: an e-puck stands here.",
    );
    draft.leave_out(
        line,
        "the robot",
        "a map has none; an e-puck stands there: set robot.preset",
    );
    start(
        &mut draft,
        placed(roomiest, side).map(|place| place + 0.5 * side),
        &walls,
        side,
    );
    Ok(draft)
}

/// The place of a corner, mm.
fn placed(corner: Corner, side: f64) -> [f64; 2] {
    corner.map(|value| f64::from(value) * side)
}

/// Chooses where robots start: within walls it would also be free inside of what is solid.
fn start(draft: &mut Draft, at: [f64; 2], walls: &[(usize, [Corner; 2])], side: f64) {
    let distance = |ends: &[Corner; 2]| {
        let [from, to] = ends.map(|corner| placed(corner, side));
        let (along, away) = ([to[0] - from[0], to[1] - from[1]], [at[0] - from[0], at[1] - from[1]]);
        let part = (along[0] * away[0] + along[1] * away[1]) / (along[0] * along[0] + along[1] * along[1]);
        let part = part.clamp(0.0, 1.0);
        (away[0] - part * along[0]).hypot(away[1] - part * along[1])
    };
    let room = walls
        .iter()
        .map(|(_, ends)| distance(ends))
        .fold(f64::INFINITY, f64::min);
    let why = "Where there is most room: places within solid things are not free, which random starts don't know.";
    let mut set = |key, value: String, why: &str| draft.choose(("start", key), value, why);
    let place = [number(at[0]), number(at[1])];
    if room >= 3.0 * BODY {
        set("kind", "\"zone\"".to_owned(), why);
        set("radius_mm", number(room), "As far as to the nearest wall.");
    } else {
        set("kind", "\"at\"".to_owned(), why);
        set("heading_turns", "0.0".to_owned(), "To the right.");
    }
    let [x, y] = place;
    set("x_mm", x, "The middle.");
    set("y_mm", y, "The middle.");
}

/// A text without the quotation marks around it.
fn plain(value: &str) -> &str {
    let quoted = ['"', '\'']
        .iter()
        .find_map(|mark| value.strip_prefix(*mark)?.strip_suffix(*mark));
    quoted.unwrap_or(value)
}

/// The keys of a map's file. It is YAML, of which map servers write only a list of keys with plain values; what else YAML has is
/// refused.
struct Keys<'a> {
    name: &'a str,
    /// Lines, keys, and values; the elements of a list have spaces between.
    values: Vec<(usize, &'a str, String)>,
    lines: usize,
}

impl<'a> Keys<'a> {
    const KNOWN: [&'static str; 7] = [
        "image",
        "resolution",
        "origin",
        "negate",
        "occupied_thresh",
        "free_thresh",
        "mode",
    ];

    fn read(name: &'a str, text: &'a str) -> Result<Self> {
        let mut values: Vec<(usize, &str, String)> = Vec::new();
        for (line, written) in (1..).zip(text.lines()) {
            let written = without_comment(written);
            if written.is_empty() || ["---", "..."].contains(&written) {
                continue;
            }
            let element = written.trim_start().strip_prefix("- ");
            if let (Some(element), Some((_, _, list))) = (element, values.last_mut()) {
                *list += " ";
                *list += element;
                continue;
            }
            let is_key =
                |key: &&str| !key.is_empty() && key.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_');
            let found = written
                .split_once(':')
                .map(|(key, value)| (key.trim_end(), value.trim()));
            let Some((key, value)) = found.filter(|(key, _)| is_key(key)) else {
                let problem = format_args!("is no line of a map's file; allowed: a key, `:` and its value");
                return Err(failure(name, line, problem));
            };
            if let Some((before, ..)) = values.iter().find(|(_, other, _)| *other == key) {
                return Err(failure(
                    name,
                    line,
                    format_args!("{key}: is given at line {before} too; allowed: once"),
                ));
            }
            let list = value.strip_prefix('[').and_then(|rest| rest.strip_suffix(']'));
            values.push((
                line,
                key,
                list.map_or_else(|| value.to_owned(), |list| list.replace(',', " ")),
            ));
        }
        Ok(Self {
            name,
            values,
            lines: text.lines().count().max(1),
        })
    }

    fn value(&self, key: &str) -> Option<(usize, &str)> {
        let found = self.values.iter().find(|(_, other, _)| *other == key);
        found.map(|(line, _, value)| (*line, value.as_str()))
    }

    fn needed(&self, key: &str) -> Result<(usize, &str)> {
        self.value(key)
            .filter(|(_, value)| !plain(value).is_empty())
            .ok_or_else(|| {
                let problem = format_args!("lacks `{key}`; allowed: a map's file has image and resolution");
                failure(self.name, self.lines, problem)
            })
    }

    /// A number, or else a default if there is one.
    fn number(&self, key: &str, default: Option<f64>, [least, most]: [f64; 2]) -> Result<f64> {
        let (line, value) = match (self.value(key), default) {
            (None, Some(default)) => return Ok(default),
            _ => self.needed(key)?,
        };
        let number = plain(value)
            .parse()
            .ok()
            .filter(|number| (least..=most).contains(number));
        number.ok_or_else(|| {
            let problem = format_args!("{key}: is {}; allowed: {least} to {most}", shown(value));
            failure(self.name, line, problem)
        })
    }

    /// The place of the picture's lower left corner in m, and its angle.
    fn origin(&self) -> Result<(usize, [f64; 3])> {
        const FARTHEST: f64 = 1e6;
        let Some((line, value)) = self.value("origin") else {
            return Ok((1, [0.0; 3]));
        };
        let numbers: Option<Vec<f64>> = value.split_whitespace().map(|word| word.parse().ok()).collect();
        let numbers = numbers.and_then(|numbers| <[f64; 3]>::try_from(numbers).ok());
        let numbers = numbers.filter(|numbers| numbers.iter().all(|number| number.abs() <= FARTHEST));
        numbers.map(|numbers| (line, numbers)).ok_or_else(|| {
            let problem = format_args!(
                "origin: is {}; allowed: three numbers, x and y in m and an angle",
                shown(value)
            );
            failure(self.name, line, problem)
        })
    }

    /// Keys that are not known, with their lines.
    fn unknown(&self) -> impl Iterator<Item = (usize, &str)> {
        let unknown = self.values.iter().filter(|(_, key, _)| !Self::KNOWN.contains(key));
        unknown.map(|(line, key, _)| (*line, *key))
    }
}

/// A line without its comment, which begins with `#` after a blank, outside of quotation marks.
fn without_comment(line: &str) -> &str {
    let mut quoted = None;
    let mut before = ' ';
    for (at, character) in line.char_indices() {
        match (quoted, character) {
            (None, '#') if before.is_whitespace() => return line[..at].trim_end(),
            (None, '"' | '\'') => quoted = Some(character),
            (Some(mark), _) if mark == character => quoted = None,
            _ => (),
        }
        before = character;
    }
    line.trim_end()
}
