//! ARGoS: the file that a simulation is started with.

use oneiro::differential::GREATEST_SEEN_MEMBERS;
use oneiro_base::exit::Result;

use super::draft::{Draft, GREATEST_COUNT, Outline, Start, Thing, number, turned};
use super::outline::{self, Slab};
use super::xml::{Element, Unread, Xml};

/// mm in a metre.
const METRE: f64 = 1000.0;
/// Robots on wheels that Oneiro doesn't have, and for which e-pucks stand.
const ON_WHEELS: [&str; 10] = [
    "foot-bot",
    "pipuck",
    "pi-puck",
    "epuck2",
    "rvr",
    "mercator",
    "kheperaiv",
    "turtlebot",
    "turtlebot4",
    "bulbot",
];
/// Maximum of boxes and of cylinders that are read, and of places in a grid.
const MOST: usize = 10_000;
/// Lowest floor level, m, at which a thing is above robots.
const ABOVE: f64 = 0.05;

/// Why the rest is not taken.
const REASONS: [(&str, &str); 36] = [
    ("*@id", ""),
    ("*@implementation", ""),
    ("*@library", ""),
    ("*@medium", ""),
    ("*@show_rays", ""),
    ("epuck_range_and_bearing@data_size", "messages have a fixed content"),
    ("system", ""),
    ("profiling", ""),
    ("visualization", ""),
    ("physics_engines", ""),
    ("media", ""),
    ("configuration", ""),
    ("argos-configuration", ""),
    (
        "experiment@random_seed",
        "its random numbers are not Oneiro's; `oneiro run --seed` has a seed",
    ),
    ("experiment@visualization", ""),
    (
        "loop_functions@library",
        "loop functions are a program; Oneiro's task is a custom part: docs/extend.md",
    ),
    ("loop_functions@label", ""),
    (
        "params",
        "it is a value of a program; Oneiro's task is a custom part: docs/extend.md",
    ),
    ("spawnCircle", "params dist_radius says where robots start"),
    ("objective", "Oneiro's task is a custom part: docs/extend.md"),
    (
        "floor",
        "the floor's picture is not in this file; set arena.picture.file to a PNG, or arena.floor and arena.patches",
    ),
    ("box@mass", ""),
    ("cylinder@mass", ""),
    ("cylinder@height", "arena.wall_height_mm is the height of all things"),
    ("leds", "Oneiro's things have no lamps"),
    ("light@color", "Oneiro's lights have no colour"),
    ("light@orientation", ""),
    ("light@medium", ""),
    ("distribute@max_trials", ""),
    ("entity@max_trials", ""),
    ("entity@base_num", ""),
    ("controllers@library", ""),
    ("e-puck@battery", "set robot.battery_s"),
    (
        "e-puck@rab_range",
        "set robot.signal_range_mm, with a robot that has a model",
    ),
    ("e-puck@rab_data_size", "messages have a fixed content"),
    ("include", "it is another file; import that one, or put it in here"),
];

/// A robot or several alike.
struct Robots<'a> {
    line: usize,
    tag: &'a str,
    count: usize,
    /// Where each starts, if the file says so.
    starts: Vec<Start>,
    /// The line and the corners of the rectangle in which they start.
    zone: Option<(usize, [[f64; 2]; 2])>,
    /// What controls them.
    controller: Option<&'a str>,
    what: String,
}

/// How `<distribute>` places things.
enum Placing {
    At([f64; 2]),
    Grid(Vec<[f64; 2]>),
    /// In the rectangle between these corners.
    Uniform([[f64; 2]; 2]),
    Random,
}

/// Reads a file.
///
/// # Errors
/// Exit 3: the line, what is wrong, what is allowed.
pub(super) fn read(name: &str, text: &str) -> Result<Draft> {
    let file = Xml::parse(name, text)?;
    let root = file.root();
    let mut draft = Draft::new(name, "1 m there is 1000 mm here.");
    if let Some(framework) = root.child("framework") {
        for experiment in framework.children("experiment") {
            length(experiment, &mut draft)?;
        }
    }
    let controllers = controllers(root, &mut draft)?;
    let mut drawn = None;
    for functions in root.children("loop_functions") {
        drawn = loop_functions(functions, &mut draft)?.or(drawn);
    }
    let Some(arena) = root.child("arena") else {
        return Err(draft.failure(
            root.line(),
            "has no <arena>; allowed: one <arena> in <argos-configuration>",
        ));
    };
    read_arena(arena, &controllers, drawn, &mut draft)?;
    let rest = file.rest(&REASONS);
    draft.leave_all_out(rest);
    Ok(draft)
}

/// The length of an episode.
fn length(experiment: Element<'_>, draft: &mut Draft) -> Result {
    /// ms in a cycle.
    const CYCLES: f64 = 10.0;
    if let Some([ticks]) = experiment.numbers("ticks_per_second")?
        && ticks != CYCLES
    {
        let why = format!("it is {ticks}; a control cycle is 100 ms in Oneiro");
        draft.leave_out(experiment.line(), "<experiment ticks_per_second>", why);
    }
    let Some([seconds]) = experiment.numbers("length")? else {
        return Ok(());
    };
    let cycles = (seconds * CYCLES).round();
    if seconds == 0.0 {
        let why = "0 is no limit; Oneiro's episodes have one: cycles, 500 by default";
        draft.leave_out(experiment.line(), "<experiment length>", why);
    } else if !(1.0..=1e6).contains(&cycles) {
        return Err(experiment.failure("length", format_args!("is {seconds} s; allowed: 0, or 0.1 to 100000 s")));
    } else {
        draft.set(
            ("", "cycles"),
            format!("{cycles}"),
            experiment.line(),
            "<experiment length>, in cycles of 100 ms",
        );
    }
    Ok(())
}

/// The controllers of a file.
#[derive(Default)]
struct Controllers<'a> {
    /// Their names in this file, and their kinds.
    kinds: Vec<(&'a str, Kind)>,
    /// Whether one of them has an e-puck's sensors or wheels.
    are_of_epucks: bool,
    /// Values of the robots of the first one that has any: key, value, line, and name in the file.
    model: Vec<(&'static str, f64, usize, String)>,
}

/// Elements of sensors and actuators, their attributes, Oneiro's keys and maxima, and the factor from one to the other.
const MODEL: [(&str, &str, &str, f64, f64); 6] = [
    ("epuck_wheels", "noise_std_dev", "wheel_noise", 0.5, 1.0),
    ("epuck_range_and_bearing", "range", "signal_range_mm", 100_000.0, METRE),
    ("epuck_proximity", "noise_level", "proximity_noise", 1.0, 1.0),
    ("epuck_light", "noise_level", "light_noise", 1.0, 1.0),
    ("epuck_ground", "noise_level", "ground_noise", 1.0, 1.0),
    ("epuck_range_and_bearing", "loss_probability", "signal_loss", 1.0, 1.0),
];

/// Reads the values of a robot with a reference model.
fn model(controller: Element<'_>, draft: &mut Draft) -> Result<Vec<(&'static str, f64, usize, String)>> {
    let mut found: Vec<(&'static str, f64, usize, String)> = Vec::new();
    for list in ["actuators", "sensors"]
        .into_iter()
        .flat_map(|list| controller.children(list))
    {
        for device in list.unread() {
            for (tag, attribute, key, most, factor) in MODEL {
                if device.tag() != tag || found.iter().any(|(known, ..)| *known == key) {
                    continue;
                }
                let device = device.read();
                let Some([value]) = device.numbers(attribute)? else {
                    continue;
                };
                let (value, what) = (factor * value, format!("<{tag} {attribute}>"));
                let least = if key == "signal_range_mm" { 1.0 } else { 0.0 };
                if (least..=most).contains(&value) {
                    found.push((key, value, device.line(), what));
                } else {
                    draft.leave_out(
                        device.line(),
                        what,
                        format!("robot.{key} would be {value}; allowed: {least} to {most}"),
                    );
                }
            }
        }
    }
    Ok(found)
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    StateMachine,
    BehaviourTree,
    /// A network that reads an e-puck's reference model.
    Reference,
    Other,
}

fn controllers<'a>(root: Element<'a>, draft: &mut Draft) -> Result<Controllers<'a>> {
    let mut all = Controllers::default();
    for list in root.children("controllers") {
        for unread in list.unread() {
            all.are_of_epucks |= unread.has_within(|tag| tag.starts_with("epuck_"));
            let controller = unread.read();
            let tag = controller.tag();
            let is_tree = tag.contains("_bt") || tag.contains("bt_");
            let kind = match tag {
                _ if tag.starts_with("automode") && is_tree => Kind::BehaviourTree,
                _ if tag.starts_with("automode") => Kind::StateMachine,
                _ if tag.starts_with("nn_rm") => Kind::Reference,
                _ => Kind::Other,
            };
            for params in controller.children("params") {
                for option in ["fsm-config", "bt-config"] {
                    if params.word(option).is_some() {
                        let why = "put it into a text file, FILE.txt; `oneiro evaluate EXPERIMENT --genomes FILE.txt` reads it";
                        draft.leave_out(params.line(), format!("<params {option}>"), why);
                    }
                }
            }
            if let Some(id) = controller.word("id") {
                all.kinds.push((id, kind));
            }
            let why = match kind {
                Kind::Other => "a controller is a program; Oneiro evolves one: docs/controllers.md",
                Kind::Reference => "Oneiro evolves another network: docs/controllers.md",
                _ => "Oneiro evolves another machine or tree of the same modules",
            };
            draft.leave_out(controller.line(), format!("<{tag}>"), why);
            if all.model.is_empty() {
                all.model = model(controller, draft)?;
            }
            // All of it is that one thing, except the values of the robot's devices.
            for unread in controller.unread() {
                match unread.tag() {
                    "actuators" | "sensors" => unread.read().unread().for_each(|device| {
                        device.read();
                    }),
                    _ => unread.read().read_all(),
                }
            }
        }
    }
    Ok(all)
}

/// The floor's patches, and how many robots loop functions place: their number and their disc's radius in m.
fn loop_functions(functions: Element<'_>, draft: &mut Draft) -> Result<Option<(usize, usize, Option<f64>)>> {
    let mut drawn = None;
    let mut open: Vec<Unread<'_>> = functions.unread().collect();
    open.reverse();
    while let Some(unread) = open.pop() {
        match unread.tag() {
            "params" => {
                let params = unread.read();
                let radius = params.numbers::<1>("dist_radius")?.map(|[radius]| radius);
                if let Some([count]) = params.numbers("number_robots")? {
                    if !(0.0..=1e6).contains(&count) || count.fract() != 0.0 {
                        let problem = format_args!("is {count}; allowed: a whole number from 0 to 1000000");
                        return Err(params.failure("number_robots", problem));
                    }
                    drawn = Some((params.line(), count as usize, radius));
                } else if radius.is_some() {
                    draft.leave_out(
                        params.line(),
                        "<params dist_radius>",
                        "there is no number_robots next to it",
                    );
                }
                let mut inner: Vec<Unread<'_>> = params.unread().collect();
                inner.reverse();
                open.append(&mut inner);
            }
            "circle" | "rectangle" => patch(unread.read(), draft)?,
            _ => (),
        }
    }
    Ok(drawn)
}

/// A patch of the floor.
fn patch(patch: Element<'_>, draft: &mut Draft) -> Result {
    let colour = patch.word("color").unwrap_or_default();
    let grey = match colour.to_ascii_lowercase().as_str() {
        "black" => 0.0,
        "white" => 1.0,
        "gray" | "grey" | "gray50" | "grey50" => 0.5,
        _ => {
            let why = format!("its colour is `{colour}`; allowed: black, gray, white");
            draft.leave_out(patch.line(), patch.what(), why);
            patch.read_all();
            return Ok(());
        }
    };
    let key = if patch.word("center").is_some() {
        "center"
    } else {
        "position"
    };
    let at = patch.needed::<2>(key)?.map(|value| METRE * value);
    let thing = if patch.tag() == "circle" {
        let radius = METRE * patch.length("radius")?;
        Thing::Disc { at, radius, grey }
    } else {
        let sides = match patch.numbers::<2>("size")? {
            Some(sides) => sides,
            None => [patch.length("width")?, patch.length("height")?],
        };
        let degrees = patch.numbers::<1>("angle")?.map_or(0.0, |[degrees]| turned(degrees));
        Thing::Rectangle {
            at,
            sides: sides.map(|side| METRE * side),
            degrees,
            grey,
        }
    };
    draft.add(thing, patch.line(), format!("{}, {colour}", patch.what()))
}

/// The place and the orientation of a thing, m and degrees, if the file gives a place.
fn pose(thing: Element<'_>, draft: &mut Draft) -> Result<Option<([f64; 3], f64)>> {
    // Older files have both in the element itself.
    let body = thing.child("body").unwrap_or(thing);
    let at = match body.numbers::<3>("position") {
        Ok(at) => at,
        Err(failure) => match body.numbers::<2>("position") {
            Ok(at) => at.map(|[x, y]| [x, y, 0.0]),
            Err(_) => return Err(failure),
        },
    };
    let degrees = match body.numbers::<3>("orientation") {
        Ok(None) => 0.0,
        Ok(Some([around, pitch, roll])) => {
            if pitch != 0.0 || roll != 0.0 {
                draft.leave_out(
                    body.line(),
                    format!("<{} orientation>", body.tag()),
                    "worlds are flat: its first angle is taken",
                );
            }
            turned(around)
        }
        Err(failure) => body
            .numbers::<1>("orientation")
            .map_err(|_| failure)?
            .map_or(0.0, |[around]| turned(around)),
    };
    Ok(at.map(|at| (at, degrees)))
}

fn read_arena<'a>(
    arena: Element<'a>,
    controllers: &Controllers<'a>,
    drawn: Option<(usize, usize, Option<f64>)>,
    draft: &mut Draft,
) -> Result {
    let size = arena.needed::<2>("size")?;
    if let Some(side) = size.iter().find(|side| **side <= 0.0) {
        return Err(arena.failure("size", format_args!("is {side} m; allowed: more than 0")));
    }
    let middle = arena.numbers::<2>("center")?.unwrap_or([0.0; 2]);
    let (mut boxes, mut solids, mut robots) = (Vec::new(), Vec::new(), Vec::new());
    let mut lights = Vec::new();
    for unread in arena.unread() {
        match unread.tag() {
            "box" => {
                let read = unread.read();
                if let Some((at, degrees)) = pose(read, draft)? {
                    slab(read, at, degrees, draft, &mut boxes)?;
                } else {
                    return Err(read.failure("position", "is missing; allowed: a <body position=\"X,Y,Z\">"));
                }
            }
            "cylinder" => {
                let read = unread.read();
                let Some((at, _)) = pose(read, draft)? else {
                    return Err(read.failure("position", "is missing; allowed: a <body position=\"X,Y,Z\">"));
                };
                cylinder(read, at, draft, &mut solids)?;
            }
            "light" => lights.push(unread.read()),
            "distribute" => distribute(unread.read(), draft, &mut boxes, &mut solids, &mut robots)?,
            _ if is_robot(unread) => robots.push(robot(unread, draft)?),
            _ => (),
        }
    }
    let heights = heights(arena);
    let slabs: Vec<Slab> = boxes.iter().map(|(slab, ..)| *slab).collect();
    let size = size.map(|side| METRE * side);
    let middle = middle.map(|value| METRE * value);
    let (outline, walls) = if let Some((outline, mut walls)) = outline::around(&slabs, middle) {
        walls.sort_unstable();
        let lines: Vec<String> = walls.iter().map(|&index| boxes[index].1.to_string()).collect();
        let what = format!("the inner faces of the boxes of lines {}", lines.join(", "));
        draft.enclose(outline.clone(), boxes[walls[0]].1, what)?;
        (outline, walls)
    } else {
        let outline = Outline::Rectangle {
            low: [0, 1].map(|axis| middle[axis] - 0.5 * size[axis]),
            size,
        };
        let what = "<arena size>; its four sides are walls here";
        draft.enclose(outline.clone(), arena.line(), what)?;
        (outline, Vec::new())
    };
    let mut things: Vec<(Thing, usize, String)> = solids;
    for (index, (slab, line, what)) in boxes.into_iter().enumerate() {
        if !walls.contains(&index) {
            let Slab { at, sides, degrees } = slab;
            things.push((Thing::Block { at, sides, degrees }, line, what));
        }
    }
    things.sort_by_key(|(_, line, _)| *line);
    for (thing, line, what) in things {
        let (at, reach) = match &thing {
            Thing::Block { at, sides, .. } => (*at, 0.5 * sides[0].hypot(sides[1])),
            Thing::Obstacle { at, radius } => (*at, *radius),
            _ => continue,
        };
        if outline::contains(&outline, at, reach) {
            draft.add(thing, line, what)?;
        } else {
            draft.leave_out(line, what, "it is outside the arena's walls");
        }
    }
    let has_model = place_robots(arena.line(), &robots, controllers, drawn, &outline, draft);
    let mut has_lamps = false;
    for light in lights {
        has_lamps |= lamp(light, has_model, draft)?;
    }
    if let [(line, height), rest @ ..] = &heights[..]
        && has_model
        && has_lamps
        && (1.0..=100_000.0).contains(height)
    {
        draft.set(
            ("arena", "wall_height_mm"),
            number(*height),
            *line,
            "<box size>, its height",
        );
        if let Some((line, _)) = rest.iter().find(|(_, other)| other != height) {
            draft.leave_out(*line, "<box size>", "all things have one height, that of the first box");
        }
    }
    Ok(())
}

/// Lines and heights of the boxes on the floor, mm.
fn heights(arena: Element<'_>) -> Vec<(usize, f64)> {
    let mut heights = Vec::new();
    for thing in arena.unread().filter(|thing| thing.tag() == "box").map(Unread::read) {
        if let Ok(Some([_, _, height])) = thing.numbers::<3>("size") {
            heights.push((thing.line(), METRE * height));
        }
    }
    heights
}

/// Reads a box at a place.
fn slab(
    read: Element<'_>,
    [x, y, z]: [f64; 3],
    degrees: f64,
    draft: &mut Draft,
    boxes: &mut Vec<(Slab, usize, String)>,
) -> Result {
    let sides = read.needed::<2>("size")?;
    let [.., height] = read.numbers::<3>("size").ok().flatten().unwrap_or_default();
    if sides.iter().any(|side| *side < 0.0) || sides[0].max(sides[1]) <= 0.0 {
        return Err(read.failure(
            "size",
            format_args!("is {} x {} m; allowed: more than 0", sides[0], sides[1]),
        ));
    }
    if z >= ABOVE || height < 0.0 {
        draft.leave_out(read.line(), read.what(), "it is above the floor");
        read.read_all();
        return Ok(());
    }
    still(read, draft);
    let slab = Slab {
        at: [METRE * x, METRE * y],
        sides: sides.map(|side| METRE * side),
        degrees,
    };
    room(boxes.len(), read, draft)?;
    boxes.push((slab, read.line(), read.what()));
    Ok(())
}

/// Reads a cylinder at a place.
fn cylinder(
    read: Element<'_>,
    [x, y, z]: [f64; 3],
    draft: &mut Draft,
    solids: &mut Vec<(Thing, usize, String)>,
) -> Result {
    let radius = read.length("radius")?;
    if z >= ABOVE {
        draft.leave_out(read.line(), read.what(), "it is above the floor");
        read.read_all();
        return Ok(());
    }
    still(read, draft);
    let thing = Thing::Obstacle {
        at: [METRE * x, METRE * y],
        radius: METRE * radius,
    };
    room(solids.len(), read, draft)?;
    solids.push((thing, read.line(), read.what()));
    Ok(())
}

/// Refuses more things than are read.
fn room(count: usize, read: Element<'_>, draft: &Draft) -> Result {
    if count < MOST {
        return Ok(());
    }
    let problem = format_args!("{}: is one of more than {MOST}; allowed: up to {MOST}", read.what());
    Err(draft.failure(read.line(), problem))
}

/// Notes that a thing doesn't move.
fn still(read: Element<'_>, draft: &mut Draft) {
    if read.word("movable") == Some("true") {
        let why = match read.tag() {
            "cylinder" => "it stands there; a swarm's pucks move: docs/pucks.md",
            _ => "it stands there; of things only pucks, which are round, move: docs/pucks.md",
        };
        draft.leave_out(read.line(), format!("<{} movable>", read.tag()), why);
    }
}

/// Reads a lamp. Returns whether it is on.
fn lamp(read: Element<'_>, has_model: bool, draft: &mut Draft) -> Result<bool> {
    let Some(([x, y, z], _)) = pose(read, draft)? else {
        return Err(read.failure("position", "is missing; allowed: X,Y,Z in m"));
    };
    let [intensity] = read.numbers("intensity")?.unwrap_or([1.0]);
    if intensity <= 0.0 {
        draft.leave_out(
            read.line(),
            read.what(),
            format!("its intensity is {intensity}: it is off"),
        );
        return Ok(false);
    }
    if !has_model {
        let why =
            "only robots with a reference model sense it (docs/reference-models.md); set arena.lights[].brightness";
        draft.leave_out(read.line(), "<light intensity>", why);
    }
    let thing = Thing::Light {
        at: [METRE * x, METRE * y],
        lamp: has_model.then_some([METRE * z.max(0.0), intensity]),
    };
    draft.add(thing, read.line(), read.what())?;
    Ok(true)
}

/// Whether an element of the arena is a robot.
fn is_robot(unread: Unread<'_>) -> bool {
    unread.has("controller") || unread.tag() == "e-puck" || ON_WHEELS.contains(&unread.tag())
}

fn robot<'a>(unread: Unread<'a>, draft: &mut Draft) -> Result<Robots<'a>> {
    let read = unread.read();
    let pose = pose(read, draft)?;
    let start = |([x, y, _], degrees): ([f64; 3], f64)| Start {
        line: read.line(),
        at: [METRE * x, METRE * y],
        degrees: Some(degrees),
    };
    let controller = read.child("controller").and_then(|own| own.word("config"));
    Ok(Robots {
        line: read.line(),
        tag: read.tag(),
        count: 1,
        starts: pose.map(start).into_iter().collect(),
        zone: None,
        controller: controller.or_else(|| read.word("controller")),
        what: read.what(),
    })
}

/// Places of `<distribute>`.
fn placing(read: Element<'_>, draft: &mut Draft) -> Result<Placing> {
    let Some(position) = read.child("position") else {
        return Ok(Placing::Random);
    };
    match position.word("method") {
        Some("constant") => {
            let [x, y] = position.needed("values")?;
            Ok(Placing::At([METRE * x, METRE * y]))
        }
        Some("grid") => {
            let middle = position.numbers::<2>("center")?.unwrap_or_default();
            let gaps = position.needed::<2>("distances")?;
            let counts = position.needed::<2>("layout")?;
            if counts
                .iter()
                .any(|count| !(1.0..=1000.0).contains(count) || count.fract() != 0.0)
            {
                let problem = format_args!("is {}, {}; allowed: whole numbers from 1 to 1000", counts[0], counts[1]);
                return Err(position.failure("layout", problem));
            }
            if counts[0] * counts[1] > MOST as f64 {
                let why = format!(
                    "it has {} x {} places; allowed: {MOST}; these are random",
                    counts[0], counts[1]
                );
                draft.leave_out(position.line(), "<position layout>", why);
                return Ok(Placing::Random);
            }
            let layers = position.word("layout").and_then(|layout| layout.split(',').nth(2));
            if layers.is_some_and(|layers| layers.trim().parse::<f64>().is_ok_and(|layers| layers > 1.0)) {
                let why = "it has several layers, and worlds are flat: places of the first are taken";
                draft.leave_out(position.line(), "<position layout>", why);
            }
            let mut places = Vec::new();
            // ARGoS begins at the maximum x and y.
            for row in 0..counts[1] as usize {
                for column in 0..counts[0] as usize {
                    let at = |axis: usize, step: usize| {
                        METRE * (middle[axis] + gaps[axis] * (0.5 * (counts[axis] - 1.0) - step as f64))
                    };
                    places.push([at(0, column), at(1, row)]);
                }
            }
            Ok(Placing::Grid(places))
        }
        Some("uniform") => {
            let corners = [position.needed::<2>("min")?, position.needed::<2>("max")?];
            Ok(Placing::Uniform(
                corners.map(|corner| corner.map(|value| METRE * value)),
            ))
        }
        method => {
            let why = "Oneiro draws places uniformly";
            draft.leave_out(
                position.line(),
                format!("<position method=\"{}\">", method.unwrap_or_default()),
                why,
            );
            position.read_all();
            Ok(Placing::Random)
        }
    }
}

fn distribute<'a>(
    read: Element<'a>,
    draft: &mut Draft,
    boxes: &mut Vec<(Slab, usize, String)>,
    solids: &mut Vec<(Thing, usize, String)>,
    robots: &mut Vec<Robots<'a>>,
) -> Result {
    let placing = placing(read, draft)?;
    let degrees = match read.child("orientation") {
        None => Some(0.0),
        Some(orientation) if orientation.word("method") == Some("constant") => {
            let [degrees] = orientation.numbers("values")?.unwrap_or_default();
            Some(turned(degrees))
        }
        Some(orientation) => {
            let ends = [
                orientation.numbers::<1>("min").ok(),
                orientation.numbers::<1>("max").ok(),
            ];
            let is_any = match ends {
                [Some(Some([least])), Some(Some([greatest]))] => greatest - least >= 360.0,
                _ => false,
            };
            if orientation.word("method") != Some("uniform") || !is_any {
                let why = "headings are constant, or uniform in all directions";
                draft.leave_out(orientation.line(), "<orientation>", why);
            }
            orientation.read_all();
            None
        }
    };
    let turns = read.child("orientation").filter(|_| degrees.is_some());
    for entity in read.children("entity") {
        let [quantity] = entity.numbers("quantity")?.unwrap_or([1.0]);
        if !(0.0..=1e6).contains(&quantity) || quantity.fract() != 0.0 {
            let problem = format_args!("is {quantity}; allowed: a whole number from 0 to 1000000");
            return Err(entity.failure("quantity", problem));
        }
        let count = quantity as usize;
        let places: Vec<[f64; 2]> = match &placing {
            Placing::At(at) if count == 1 => vec![*at],
            Placing::Grid(places) if places.len() >= count => places[..count].to_vec(),
            _ => Vec::new(),
        };
        for unread in entity.unread() {
            let is_thing = ["box", "cylinder"].contains(&unread.tag());
            if is_thing && (places.len() < count || degrees.is_none() && unread.tag() == "box") {
                let read = unread.read();
                read.read_all();
                let why =
                    format!("{count} at random places; Oneiro's things have fixed ones: arena.blocks, arena.obstacles");
                draft.leave_out(read.line(), read.what(), why);
            } else if is_thing {
                let read = unread.read();
                for [x, y] in &places {
                    let at = [x / METRE, y / METRE, 0.0];
                    if read.tag() == "box" {
                        slab(read, at, degrees.unwrap_or_default(), draft, boxes)?;
                    } else {
                        cylinder(read, at, draft, solids)?;
                    }
                }
            } else if is_robot(unread) {
                let mut robot = robot(unread, draft)?;
                robot.count = count;
                if let (Placing::Uniform(corners), Some(position)) = (&placing, read.child("position")) {
                    robot.zone = Some((position.line(), *corners));
                } else if places.len() < count && !matches!(placing, Placing::Random) {
                    let why = format!("there are {count} for fewer places; they are random");
                    draft.leave_out(robot.line, "the robots' starts", why);
                }
                if let Some(turns) = turns.filter(|_| places.len() < count) {
                    draft.leave_out(
                        turns.line(),
                        "<orientation>",
                        "robots at random places have random headings",
                    );
                }
                robot.what = format!("{}, quantity {count}", robot.what);
                let start = |at: &[f64; 2]| Start {
                    line: robot.line,
                    at: *at,
                    degrees,
                };
                robot.starts = places.iter().take(GREATEST_COUNT).map(start).collect();
                robots.push(robot);
            }
        }
    }
    Ok(())
}

/// Sets the robots of the arena of this line. Returns whether they have a reference model.
fn place_robots(
    arena: usize,
    robots: &[Robots<'_>],
    controllers: &Controllers<'_>,
    drawn: Option<(usize, usize, Option<f64>)>,
    outline: &Outline,
    draft: &mut Draft,
) -> bool {
    let mut taken: Vec<&Robots<'_>> = robots.iter().filter(|own| own.tag == "e-puck").collect();
    let others: Vec<&Robots<'_>> = robots.iter().filter(|own| own.tag != "e-puck").collect();
    for other in &others {
        let stands_in = taken.is_empty() && ON_WHEELS.contains(&other.tag);
        let why = match (stands_in, ON_WHEELS.contains(&other.tag)) {
            (true, _) => "Oneiro has no such robot; e-pucks stand for them: set robot.preset",
            (_, true) => "Oneiro has no such robot",
            _ => "it is no robot on two wheels",
        };
        let number = if other.count == 1 {
            String::new()
        } else {
            format!(", quantity {}", other.count)
        };
        draft.leave_out(other.line, format!("<{}>{number}", other.tag), why);
    }
    let is_replaced = taken.is_empty();
    if is_replaced {
        taken = others.into_iter().filter(|own| ON_WHEELS.contains(&own.tag)).collect();
    }
    let in_arena: usize = taken.iter().map(|own| own.count).sum();
    let kind = |id: Option<&str>| {
        let found = controllers.kinds.iter().find(|(known, _)| Some(*known) == id);
        found.map_or(Kind::Other, |(_, kind)| *kind)
    };
    let (count, line, what, kind) = match (taken.first(), drawn) {
        (None, Some((line, count, _))) => {
            let kind = controllers.kinds.first().map_or(Kind::Other, |(_, kind)| *kind);
            let what = if controllers.are_of_epucks {
                "<params number_robots>: loop functions place them, with an e-puck's sensors"
            } else {
                let why = "the file doesn't say which robots they are; e-pucks stand for them: set robot.preset";
                draft.leave_out(line, "<params number_robots>", why);
                "<params number_robots>"
            };
            (count, line, what.to_owned(), kind)
        }
        (Some(first), _) => (in_arena, first.line, first.what.clone(), kind(first.controller)),
        (None, None) => (0, 0, String::new(), Kind::Other),
    };
    if let (Some(_), Some((line, placed, _))) = (taken.first(), drawn)
        && placed != count
    {
        let why = format!("the arena has {count}, which are here");
        draft.leave_out(line, format!("<params number_robots>, {placed}"), why);
    }
    for (key, _, line, what) in controllers.model.iter().filter(|_| kind == Kind::Other) {
        let why = match *key {
            "wheel_noise" => "set robot.wheel_noise",
            _ => {
                "a plain e-puck has no such value; noise.sensor is for all its sensors, and robot.model has all of these"
            }
        };
        draft.leave_out(*line, &**what, why);
    }
    if count == 0 {
        let why = "No robot on two wheels is in the file: an e-puck stands here.";
        draft.choose(("robot", "preset"), "\"epuck\"", why);
        draft.leave_out(
            arena,
            "robots",
            "no robot on two wheels is in the file; an e-puck stands there: set robot.preset",
        );
        return false;
    }
    let has_model = kind != Kind::Other;
    let preset = if has_model { "\"epuck-rm1.1\"" } else { "\"epuck\"" };
    draft.set(("robot", "preset"), preset, line, what);
    if has_model {
        for (key, value, line, what) in &controllers.model {
            draft.set(("robot", key), number(*value), *line, &**what);
        }
    }
    if matches!(kind, Kind::StateMachine | Kind::BehaviourTree) {
        draft.choose(("robot", "model"), "\"rm1.1-vectors\"", "What AutoMoDe's modules read.");
        let [name, text] = match kind {
            Kind::StateMachine => ["\"state-machine\"", "AutoMoDe's state machines."],
            _ => ["\"behaviour-tree\"", "AutoMoDe's behaviour trees."],
        };
        draft.choose(("controller", "kind"), name, text);
    }
    start_zone(&taken, drawn.is_some(), outline, draft);
    if count == 1 && !has_model {
        let starts = taken.first().map_or(Vec::new(), |own| own.starts.clone());
        for start in starts.iter().filter(|start| start.degrees.is_none()) {
            let why = "a single robot at a given place has a given heading, here 0";
            draft.leave_out(start.line, "the robot's random heading", why);
        }
        draft.start_at(starts, false);
        return has_model;
    }
    let most = if has_model {
        GREATEST_SEEN_MEMBERS as usize
    } else {
        GREATEST_COUNT
    };
    let kept = count.min(most);
    if kept < count {
        let why = format!("there are {count}; allowed: 1 to {most}, so {most} are here");
        draft.leave_out(line, "robots", why);
    }
    draft.set(("robot", "count"), kept.to_string(), line, "their number");
    let starts: Vec<Start> = taken
        .iter()
        .flat_map(|own| own.starts.iter().copied())
        .take(kept)
        .collect();
    if matches!(drawn, Some((.., Some(_)))) {
        for start in &starts {
            draft.leave_out(
                start.line,
                "the robot's start",
                "loop functions move it: <params dist_radius>",
            );
        }
    }
    match drawn {
        // Loop functions move robots to random places in a disc when an episode begins.
        Some((line, _, Some(radius))) => {
            let centre = match outline {
                Outline::Rectangle { low, size } | Outline::Walled { low, size } => {
                    [0, 1].map(|axis| low[axis] + 0.5 * size[axis])
                }
                Outline::Polygon(corners) => [0, 1].map(|axis| {
                    let values = || corners.iter().map(|corner| corner[axis]);
                    0.5 * (values().fold(f64::INFINITY, f64::min) + values().fold(f64::NEG_INFINITY, f64::max))
                }),
            };
            let radius = METRE * radius;
            let is_middle = centre.iter().all(|value| value.abs() < 5.0);
            if is_middle && (1.0..=100_000.0).contains(&radius) {
                let what = "<params dist_radius>: robots start in this disc";
                draft.set(("arena", "start_radius_mm"), number(radius), line, what);
            } else {
                let why = "it is a disc around (0, 0), which is not the arena's middle; robots start anywhere";
                draft.leave_out(line, "<params dist_radius>", why);
            }
        }
        _ if starts.len() == kept => {
            if starts.iter().any(|start| start.degrees.is_none()) {
                for start in starts.iter().filter(|start| start.degrees.is_some()) {
                    let why = "others' are random, and then all are";
                    draft.leave_out(start.line, "the robot's heading", why);
                }
            }
            draft.start_at(starts, true);
        }
        _ => {
            for start in starts {
                draft.leave_out(
                    start.line,
                    "the robot's start",
                    "not all robots of the file have one; they are random",
                );
            }
        }
    }
    has_model
}

/// Robots that all start in one rectangle start in that zone; other rectangles are noted.
fn start_zone(robots: &[&Robots<'_>], is_moved: bool, outline: &Outline, draft: &mut Draft) {
    let zones: Vec<_> = robots.iter().map(|own| own.zone).collect();
    let first = zones.first().copied().flatten();
    let is_one = first.is_some_and(|(_, corners)| zones.iter().all(|zone| zone.is_some_and(|(_, own)| own == corners)));
    if let (Some((line, [low, high])), true, false) = (first, is_one, is_moved) {
        let within = |corner: [f64; 2]| outline::contains(outline, corner, 0.0);
        let sides = [0, 1].map(|axis| high[axis] - low[axis]);
        if sides.iter().all(|side| *side >= 1.0) && within(low) && within(high) {
            return draft.start_within(line, [low, high]);
        }
    }
    for (line, _) in zones.into_iter().flatten() {
        let why = if is_moved {
            "loop functions move the robots"
        } else if is_one {
            "the rectangle is not within the arena; robots start anywhere"
        } else {
            "robots start in one zone, start.kind = \"zone\"; here they start anywhere"
        };
        draft.leave_out(line, "<position method=\"uniform\">", why);
    }
}
