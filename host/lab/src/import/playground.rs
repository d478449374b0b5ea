//! Playgrounds of Aseba, which simulates with Enki.

use oneiro_base::exit::Result;

use super::draft::{Draft, GREATEST_COUNT, Outline, Start, Thing, turned};
use super::xml::{Element, Xml};

/// mm in a centimetre.
const CM: f64 = 10.0;
/// Their robots that Oneiro has, and its names for them.
const ROBOTS: [(&str, &str); 2] = [("thymio2", "\"thymio2\""), ("e-puck", "\"epuck\"")];

/// Why the rest is not taken.
const REASONS: [(&str, &str); 24] = [
    ("author", ""),
    ("thanks", ""),
    ("externalLink", ""),
    ("description", ""),
    ("camera", ""),
    ("color", ""),
    ("wall@color", "Oneiro's things have no colour"),
    ("cylinder@color", "Oneiro's things have no colour"),
    ("world@color", "Oneiro's walls have no colour"),
    ("world@groundTexture", "it is a picture: set arena.picture"),
    (
        "world@energyScoringSystemEnabled",
        "Oneiro's task is a custom part: docs/extend.md",
    ),
    ("wall@h", "arena.wall_height_mm is the height of all things"),
    ("cylinder@h", "arena.wall_height_mm is the height of all things"),
    ("*@port", ""),
    ("*@name", ""),
    ("*@nodeId", ""),
    ("process", "Oneiro starts no other program"),
    ("area", "only doors use it"),
    ("door", "Oneiro has no doors"),
    ("activation", "Oneiro has no doors"),
    (
        "feeder",
        "Oneiro has no feeders; a patch with charges = true charges batteries",
    ),
    ("aseba-playground", ""),
    ("point", ""),
    ("*@comment", ""),
];

/// Reads a file.
///
/// # Errors
/// Exit 3: the line, what is wrong, what is allowed.
pub(super) fn read(name: &str, text: &str) -> Result<Draft> {
    let file = Xml::parse(name, text)?;
    let root = file.root();
    let mut draft = Draft::new(name, "1 cm there is 10 mm here.");
    let Some(world) = root.child("world") else {
        return Err(draft.failure(
            root.line(),
            "has no <world>; allowed: one <world> in <aseba-playground>",
        ));
    };
    let size = [world.length("w")?, world.length("h")?].map(|side| CM * side);
    let low = [0.0; 2];
    draft.enclose(Outline::Rectangle { low, size }, world.line(), "<world w h>")?;
    for wall in root.children("wall") {
        let sides = [wall.length("l1")?, wall.length("l2")?].map(|side| CM * side);
        let degrees = angle(wall)?;
        still(wall, &mut draft)?;
        let at = place(wall)?;
        draft.add(Thing::Block { at, sides, degrees }, wall.line(), wall.what())?;
    }
    for cylinder in root.children("cylinder") {
        let radius = CM * cylinder.length("r")?;
        still(cylinder, &mut draft)?;
        let at = place(cylinder)?;
        draft.add(Thing::Obstacle { at, radius }, cylinder.line(), cylinder.what())?;
    }
    robots(root, &mut draft)?;
    let rest = file.rest(&REASONS);
    draft.leave_all_out(rest);
    Ok(draft)
}

/// A place in mm; 0 where the file gives none.
fn place(of: Element<'_>) -> Result<[f64; 2]> {
    let axis = |name| of.numbers(name).map(|found| found.map_or(0.0, |[value]| CM * value));
    Ok([axis("x")?, axis("y")?])
}

/// An angle in degrees; the file's are in radians.
fn angle(of: Element<'_>) -> Result<f64> {
    Ok(of
        .numbers("angle")?
        .map_or(0.0, |[radians]: [f64; 1]| turned(radians.to_degrees())))
}

/// Notes that a thing doesn't move.
fn still(thing: Element<'_>, draft: &mut Draft) -> Result {
    if let Some([mass]) = thing.numbers("mass")?
        && mass >= 0.0
    {
        let what = format!("<{} mass>", thing.tag());
        let why = match thing.tag() {
            "cylinder" => "it stands there; a swarm's pucks move: docs/pucks.md",
            _ => "it stands there; of things only pucks, which are round, move: docs/pucks.md",
        };
        draft.leave_out(thing.line(), what, why);
    }
    Ok(())
}

fn robots(root: Element<'_>, draft: &mut Draft) -> Result {
    let mut taken: Option<&str> = None;
    let mut starts = Vec::new();
    // Older files have an element for each kind.
    let kinds = ROBOTS.map(|(kind, _)| (kind, kind));
    let robots = std::iter::once(("robot", "thymio2")).chain(kinds);
    let robots = robots.flat_map(|(tag, kind)| root.children(tag).map(move |robot| (robot, kind)));
    for (robot, kind) in robots {
        let kind = robot.word("type").unwrap_or(kind);
        let start = Start {
            line: robot.line(),
            at: place(robot)?,
            degrees: Some(angle(robot)?),
        };
        let Some((_, preset)) = ROBOTS.iter().find(|(known, _)| *known == kind) else {
            let why = format!("Oneiro has no `{kind}`; allowed: thymio2, e-puck");
            draft.leave_out(robot.line(), "<robot type>", why);
            continue;
        };
        match taken {
            None => {
                draft.set(
                    ("robot", "preset"),
                    *preset,
                    robot.line(),
                    format!("<robot type=\"{kind}\">"),
                );
                taken = Some(kind);
                starts.push(start);
            }
            Some(first) if first == kind => starts.push(start),
            Some(first) => {
                let why = format!("all robots of an experiment are alike; those of the type {first} are taken");
                draft.leave_out(robot.line(), format!("<robot type=\"{kind}\">"), why);
            }
        }
    }
    match starts.len() {
        0 => {
            let why = "No robot that Oneiro has is in the file: a Thymio II stands here.";
            draft.choose(("robot", "preset"), "\"thymio2\"", why);
            draft.leave_out(
                root.line(),
                "robots",
                "none that Oneiro has is in the file; a Thymio II stands there: set robot.preset",
            );
        }
        1 => draft.start_at(starts, false),
        count => {
            let kept = count.min(GREATEST_COUNT);
            for start in starts.drain(kept..) {
                let why = format!("there are {count}; allowed: 1 to {GREATEST_COUNT}");
                draft.leave_out(start.line, "<robot>", why);
            }
            let line = starts[0].line;
            draft.set(("robot", "count"), kept.to_string(), line, "<robot>, their number");
            draft.start_at(starts, true);
        }
    }
    Ok(())
}
