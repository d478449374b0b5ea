//! A self-contained HTML page that replays an episode of one robot or of a swarm: the arena, all robots with the states of
//! their machines, which robots each hears, and the followed robot's controller, sensors, readings, speeds and memory. Readings are
//! rounded to 1/65535 of their range in this episode.

mod diagram;

use std::collections::BTreeMap;

use oneiro::arena::{Arena, Block, Patch};
use oneiro::automode::Form;
use oneiro::batch::Trace;
use oneiro::compose::{Detail, DetailKind, Kind, Scalar};
use oneiro::differential::{BUMPER_WIDTH, Mark, Sensor};
use oneiro::picture::Picture;
use oneiro::surrogate::BEARINGS;
use oneiro::tables::SENSOR_NAMES;
use oneiro::world::World;
use oneiro_base::console::counted;
use serde::Serialize;
use serde_json::{Value, json};

use super::arena::DRAWN_CELLS;
use super::player::{self, Player, base64, packed, turns};
use super::svg::{number, ramp};

/// The panel next to the arena.
const PANEL: &str = include_str!("../components/episode.html");
const SWITCHES: &str = "<label class=\"switch\"><input type=\"checkbox\" id=\"trails\"/> trails</label>\n\
    <label class=\"switch\"><input type=\"checkbox\" id=\"sensors\" checked=\"\"/> sensors</label>\n\
    <label class=\"switch\"><input type=\"checkbox\" id=\"messages\" checked=\"\"/> messages</label>\n";
/// Buttons of the worlds, of which one is shown.
const WORLDS: &str = "<div id=\"worlds\" role=\"group\" aria-label=\"Generation\">Generation</div>\n";
/// Colours of a machine's states, and of teams.
pub(super) const COLOURS: [&str; 4] = ["#2a9d8f", "#b3263c", "#2b3a8f", "#f4a23b"];
/// Colour of a robot's front.
pub(super) const FRONT: &str = "#ffffff";
/// From the first generation shown to the last.
pub(super) const AGES: [[u8; 3]; 3] = [[0xe0, 0x8e, 0x1b], [0xc2, 0x3f, 0x6e], [0x4c, 0x5f, 0xd5]];
/// Length of the rays of a Khepera's sensors, mm: most of what they see is nearer.
const KHEPERA_RANGE: f32 = 40.0;
/// Seconds in a cycle.
const CYCLE: f64 = 0.1;

/// An episode, to be replayed.
pub struct EpisodeReplay<'a> {
    pub title: &'a str,
    /// Its world, a swarm's observed, and the cycles that it lasted.
    pub world: &'a World,
    pub cycles: u32,
    /// The trace of each robot, world after world, with a record each `every` cycles, which is 1 or more.
    pub robots: Vec<Trace>,
    pub compared: Compared<'a>,
    pub every: u32,
    /// Each robot's earnings up to each record; empty unless each robot has a score.
    pub earned: Vec<Vec<f32>>,
    /// The genes of each robot's controller.
    pub genes: Vec<&'a [f32]>,
}

/// The difference between the worlds of a page. They start alike and have the same number of robots.
#[derive(Clone, Copy)]
pub enum Compared<'a> {
    /// There is one world.
    Nothing,
    /// Whose best it is.
    Generations(&'a [u32]),
    /// What simulates the robot: such as `simulator` or `surrogate`.
    Realities(&'a [&'a str]),
}

impl Compared<'_> {
    /// The number of worlds.
    pub(super) fn worlds(self) -> usize {
        match self {
            Self::Nothing => 1,
            Self::Generations(own) => own.len(),
            Self::Realities(own) => own.len(),
        }
    }

    /// The name of a world.
    fn name(self, world: usize) -> Value {
        match self {
            Self::Nothing => json!(""),
            Self::Generations(own) => json!(own[world]),
            Self::Realities(own) => json!(own[world]),
        }
    }

    /// What precedes a world's name.
    fn who(self) -> &'static str {
        match self {
            Self::Nothing => "",
            Self::Generations(_) => "generation",
            Self::Realities(_) => "the",
        }
    }

    /// The colour of a world.
    fn colour(self, world: usize) -> String {
        match self {
            Self::Nothing => COLOURS[0].to_owned(),
            Self::Generations(_) | Self::Realities(_) => ramp(&AGES, world as f64 / (self.worlds() - 1).max(1) as f64),
        }
    }
}

/// Bytes of a page for each robot and record.
pub fn bytes_of_record(world: &World) -> usize {
    let count = |wanted: fn(DetailKind) -> bool| world.details().iter().filter(|detail| wanted(detail.kind)).count();
    let readings = count(|kind| matches!(kind, DetailKind::Perceived | DetailKind::Memory(_))) + SPEEDS.len();
    let (heard, earned) = (
        count(|kind| kind == DetailKind::Heard),
        count(|kind| kind == DetailKind::Earned),
    );
    // Pucks are written once for all robots, two words each.
    let pucks = count(|kind| kind == DetailKind::Puck).div_ceil(world.robots() as usize);
    // In words of 16 bits: the pose, the state, readings, senders, what was earned, and pucks; as Base64.
    (4 + readings + 2 * heard + 2 * earned + 2 * pucks) * 2 * 4 / 3
}

/// The speeds of the wheels, which come after the readings.
const SPEEDS: [&str; 2] = ["speed_left", "speed_right"];

/// Makes the page.
pub fn episode_page(replay: &EpisodeReplay<'_>) -> String {
    let EpisodeReplay { every, .. } = replay;
    let robots = counted(replay.each(), "robot", "robots in one world");
    let each = if replay.is_alone() {
        "each alone".to_owned()
    } else {
        format!("each with {robots},")
    };
    let who = match replay.compared {
        Compared::Nothing => robots,
        Compared::Generations(own) => {
            let bests = counted(own.len(), "generation", "generations");
            format!("The bests of {bests}, {each} from the same start,")
        }
        Compared::Realities(own) => format!(
            "The same controller in the {}, {each} from the same start,",
            own.join(" and the ")
        ),
    };
    let seconds = |cycles: u32| number(f64::from(cycles) * CYCLE);
    let lead = format!(
        "{who} for {} s, recorded every {} s.",
        seconds(replay.cycles),
        seconds(*every)
    );
    player::page(&Player {
        title: replay.title,
        lead: &lead,
        drawn: "The arena from above, with its floor, walls, objects, lamps and robots",
        switches: SWITCHES,
        strip: match replay.compared {
            Compared::Generations(_) if !replay.is_alone() => WORLDS,
            _ => "",
        },
        panel: PANEL,
        facts: &replay.facts(),
        script: "episode",
    })
}

/// A reading of all robots, in the order of lines and robots.
pub(super) struct Reading {
    name: String,
    values: Vec<f32>,
    /// Their minimum and maximum.
    low: f32,
    high: f32,
    /// Whether these are whole numbers by type.
    is_whole: bool,
}

impl Reading {
    fn new(name: &str, scalar: Scalar, values: impl Iterator<Item = f32>) -> Self {
        let values: Vec<_> = values.collect();
        Self {
            name: name.to_owned(),
            low: values.iter().copied().fold(f32::INFINITY, f32::min),
            high: values.iter().copied().fold(f32::NEG_INFINITY, f32::max),
            is_whole: scalar != Scalar::Float,
            values,
        }
    }

    /// The ends of its bar, which has room for 0 and 1, and for -1 if it may be negative.
    fn ends(&self) -> [f32; 2] {
        let to = self.high.max(1.0);
        if self.low < 0.0 || SPEEDS.contains(&&*self.name) {
            let most = to.max(-self.low);
            [-most, most]
        } else {
            [0.0, to]
        }
    }

    /// How strongly it is drawn, from 0 to 1.
    pub(super) fn strength(&self, index: usize) -> f32 {
        let [_, to] = self.ends();
        (self.values[index] / to).clamp(0.0, 1.0)
    }

    /// Its name, its span, and the ends of its bar.
    fn facts(&self) -> Value {
        let [from, to] = self.ends();
        json!({ "name": self.name, "low": self.low, "high": self.high, "from": from, "to": to, "whole": self.is_whole })
    }

    /// A value as a fraction of the span.
    fn share(&self, index: usize) -> u16 {
        let [low, high, value] = [self.low, self.high, self.values[index]].map(f64::from);
        (65_535.0 * (value - low) / (high - low).max(f64::MIN_POSITIVE)).round() as u16
    }
}

impl EpisodeReplay<'_> {
    /// The number of robots in each world.
    pub(super) fn each(&self) -> usize {
        self.robots.len() / self.compared.worlds()
    }

    /// Whether one picture shows all: one world, or robots that are alone in theirs.
    pub fn is_one_picture(&self) -> bool {
        self.is_alone() || matches!(self.compared, Compared::Nothing)
    }

    /// Whether robots of several worlds, each alone in one, are shown in one arena.
    pub(super) fn is_alone(&self) -> bool {
        self.each() == 1 && !matches!(self.compared, Compared::Nothing)
    }

    /// Every robot in every line, line after line.
    fn seen(&self) -> impl Iterator<Item = (&Trace, usize)> {
        (0..self.robots[0].len()).flat_map(|line| self.robots.iter().map(move |robot| (robot, line)))
    }

    /// Places of the details of one kind.
    fn places(&self, wanted: DetailKind) -> Vec<usize> {
        let all = self.world.details().iter().enumerate();
        all.filter(|(_, detail)| detail.kind == wanted)
            .map(|(place, _)| place)
            .collect()
    }

    /// What robots read, the speeds of their wheels, and what their parts remember.
    pub(super) fn readings(&self) -> Vec<Reading> {
        let details = |wanted: fn(DetailKind) -> bool| {
            let all = self.world.details().iter().enumerate();
            let own = all.filter(move |(_, detail)| wanted(detail.kind));
            own.map(|(place, detail)| {
                let word = |(trace, line): (&Trace, usize)| value(detail.scalar, trace.details(line)[place]);
                Reading::new(&shown_name(detail), detail.scalar, self.seen().map(word))
            })
        };
        let perceived = details(|kind| kind == DetailKind::Perceived);
        let remembered = details(|kind| matches!(kind, DetailKind::Memory(_)));
        let speeds = [0, 1].map(|side| {
            let speed = |(trace, line): (&Trace, usize)| [trace[line].speed_left, trace[line].speed_right][side];
            Reading::new(SPEEDS[side], Scalar::Float, self.seen().map(speed))
        });
        perceived.chain(speeds).chain(remembered).collect()
    }

    /// For each reading of a sensor that can be drawn: the sensor's place on the body and the direction in which it looks.
    pub(super) fn sensors(&self) -> Vec<DrawnSensor> {
        let robot = &self.world.spec().robot;
        let perceived = self.places(DetailKind::Perceived).into_iter().enumerate();
        let drawn = perceived.filter_map(|(reading, place)| {
            let detail = &self.world.details()[place];
            if let Some(sensor) = khepera_sensor(detail) {
                let turn = -BEARINGS[sensor] / 360.0;
                return Some(DrawnSensor {
                    reading,
                    bearing: turn,
                    heading: turn,
                    offset: robot.body_radius,
                    range: Some(KHEPERA_RANGE),
                    width: None,
                });
            }
            let sensor = robot
                .described_sensors()
                .iter()
                .find(|sensor| sensor.name == detail.name)?;
            drawn(sensor, robot.body_radius, reading)
        });
        drawn.collect()
    }

    /// What is drawn on each robot.
    fn names(&self) -> Vec<Value> {
        let name = |robot| {
            if self.is_alone() {
                self.compared.name(robot)
            } else {
                json!(robot % self.each())
            }
        };
        (0..self.robots.len()).map(name).collect()
    }

    /// The name and colour of each robot without a machine: those of its team, if there are several, or of its world.
    pub(super) fn plain(&self) -> Vec<(String, String)> {
        let each = self.each();
        let genes = self.world.genes_of(0).len().max(1);
        let team = |robot: usize| self.world.genes_of((robot % each) as u32).start / genes;
        let teams = (0..each).map(team).max().map_or(1, |last| last + 1);
        let named = |robot| {
            if (2..=COLOURS.len()).contains(&teams) {
                (format!("team {}", team(robot)), COLOURS[team(robot)].to_owned())
            } else {
                match self.compared {
                    Compared::Generations(own) if self.is_alone() => {
                        (format!("generation {}", own[robot]), self.compared.colour(robot))
                    }
                    Compared::Realities(own) if self.is_alone() => (own[robot].to_owned(), self.compared.colour(robot)),
                    // Opponents may have one genome between them.
                    Compared::Nothing if each == 2 => (format!("robot {robot}"), COLOURS[robot].to_owned()),
                    _ => (String::new(), self.compared.colour(robot / each)),
                }
            }
        };
        (0..self.robots.len()).map(named).collect()
    }

    /// What each robot does in each state of its machine, with the state's number; of others nothing.
    fn states(&self) -> Vec<Vec<String>> {
        let all = self.genes.iter();
        all.map(|genes| diagram::states(self.world, genes)).collect()
    }

    /// States of all machines, each once.
    fn acts(&self) -> Vec<String> {
        let mut acts = Vec::new();
        for act in self.states().into_iter().flatten() {
            if !acts.contains(&act) {
                acts.push(act);
            }
        }
        acts
    }

    /// The diagrams of all controllers, each once, and the number of each robot's; both empty if they aren't drawn.
    fn diagrams(&self, readings: &[Reading]) -> [Value; 2] {
        let names: Vec<&str> = readings.iter().map(|reading| &*reading.name).collect();
        let inputs = self
            .world
            .details()
            .iter()
            .filter(|detail| detail.kind == DetailKind::Perceived)
            .count();
        let mut each = Vec::new();
        for genes in &self.genes {
            if !each.contains(genes) {
                each.push(*genes);
            }
        }
        let number = |genes: &&[f32]| each.iter().position(|other| other == genes);
        let numbers: Vec<_> = self.genes.iter().map(number).collect();
        let drawn = each
            .iter()
            .map(|genes| diagram::diagram(self.world, genes, &names, inputs));
        drawn
            .collect::<Option<Vec<_>>>()
            .map_or([json!([]), json!([])], |drawn| [json!(drawn), json!(numbers)])
    }

    /// The state of each robot's machine after the cycle, by its place among those of all machines.
    pub(super) fn machine_states(&self) -> Vec<u16> {
        let acting = Form::of(self.world.gene_layout()).map(Form::acting);
        let is_state = |detail: &Detail| {
            detail.kind == DetailKind::Memory(Kind::Controller) && Some(detail.name.as_str()) == acting
        };
        let acts = self.acts();
        let place = self.world.details().iter().position(is_state);
        let place = place.filter(|_| !acts.is_empty());
        place.map_or_else(Vec::new, |place| {
            let shown = |((trace, line), states): ((&Trace, usize), &Vec<String>)| {
                let name = states.get(trace.details(line)[place] as usize)?;
                acts.iter().position(|act| act == name)
            };
            let states = self.states();
            let all = self.seen().zip(states.iter().cycle()).map(shown);
            all.map(|act| act.map_or(u16::MAX, |act| act as u16)).collect()
        })
    }

    /// Places of the pucks of a world in a line, mm.
    pub(super) fn pucks(&self, world: usize, line: usize) -> Vec<[f32; 2]> {
        let details = self.robots[world * self.each()].details(line);
        let places: Vec<f32> = self
            .places(DetailKind::Puck)
            .iter()
            .map(|place| f32::from_bits(details[*place]))
            .collect();
        places.as_chunks().0.to_vec()
    }

    /// All data for the script.
    fn facts(&self) -> BTreeMap<&'static str, Value> {
        let spec = self.world.spec();
        let poses = self.seen().map(|(trace, line)| &trace[line]);
        let poses = poses.map(|record| [record.x, record.y, record.heading]);
        let poses: Vec<[f32; 3]> = poses.collect();
        let readings = self.readings();
        let values = (0..poses.len()).flat_map(|index| readings.iter().map(move |reading| reading.share(index)));
        let heard = self.places(DetailKind::Heard);
        let senders = self.seen().flat_map(|(trace, line)| {
            let words = heard.iter().flat_map(move |place| halves(trace.details(line)[*place]));
            words.take(self.each().div_ceil(16))
        });
        let earned = (0..self.robots[0].len()).flat_map(|line| {
            let each = self.earned.iter().map(move |earned| earned[line]);
            each.flat_map(|earned| halves(earned.to_bits()))
        });
        let look = |name: &str, colour: &str| json!({ "name": name, "colour": colour, "front": FRONT });
        let [diagrams, diagram] = self.diagrams(&readings);
        let acts = self.acts().into_iter().enumerate();
        let acts = acts.map(|(state, name)| look(&name, COLOURS[state % COLOURS.len()]));
        let plain = self.plain().into_iter().map(|(name, colour)| look(&name, &colour));
        let first_of_each = self.robots.iter().step_by(self.each());
        let fitness =
            (0..self.robots[0].len()).flat_map(|line| first_of_each.clone().map(move |robot| robot[line].fitness));
        let world = |world| json!({ "name": self.compared.name(world), "colour": self.compared.colour(world) });
        let times = (0..self.robots[0].len() as u32).map(|line| line * self.every);
        let each_world =
            (0..self.robots[0].len()).flat_map(|line| (0..self.compared.worlds()).map(move |world| (world, line)));
        let pucks = each_world.flat_map(|(world, line)| self.pucks(world, line));
        let pucks = packed(pucks.flatten().flat_map(|place| halves(place.to_bits())));
        let radius = spec.pucks.radius.unwrap_or_default();
        let mut facts = pose_facts(&poses, spec.robot.body_radius);
        facts.extend([
            ("acts", acts.collect()),
            ("arena", arena(&spec.arena)),
            ("diagrams", diagrams),
            ("diagram", diagram),
            ("sensors", json!(self.sensors())),
            ("plain", plain.collect()),
            (
                "who",
                json!(if self.is_alone() { self.compared.who() } else { "robot" }),
            ),
            ("worlds", (0..self.compared.worlds()).map(world).collect()),
            ("names", json!(self.names())),
            ("times", times.collect()),
            ("view", json!(view(&spec.arena, spec.robot.body_radius, &poses))),
            // For each line, for each world, for each puck.
            (
                "pucks",
                json!({ "radius": radius, "count": self.world.pucks(), "places": pucks }),
            ),
            // For each line, for each world.
            (
                "fitness",
                json!(packed(fitness.flat_map(|fitness| halves(fitness.to_bits())))),
            ),
            // For each line, for each robot; of readings and senders several.
            ("state", json!(packed(self.machine_states().into_iter()))),
            ("senders", json!(packed(senders))),
            ("earned", json!(packed(earned))),
            ("values", json!(packed(values))),
            ("readings", readings.iter().map(Reading::facts).collect()),
        ]);
        facts
    }
}

/// Poses as x and y in mm and the heading in turns, and the robots' radius.
pub(super) fn pose_facts(poses: &[[f32; 3]], body_radius: f32) -> BTreeMap<&'static str, Value> {
    let farthest = poses
        .iter()
        .fold(0.0, |most: f32, [x, y, _]| most.max(x.abs()).max(y.abs()));
    // Positions have 16 bits.
    let unit = [0.1, 1.0, 10.0, 100.0]
        .into_iter()
        .find(|unit| f64::from(farthest) < 32_767.0 * unit);
    let unit = unit.unwrap_or(1000.0);
    let along = |axis: usize| {
        let length = |pose: &[f32; 3]| (f64::from(pose[axis]) / unit).round() as i16 as u16;
        json!(packed(poses.iter().map(length)))
    };
    BTreeMap::from([
        ("body", json!(body_radius)),
        ("unit", json!(unit)),
        ("x", along(0)),
        ("y", along(1)),
        ("heading", json!(packed(poses.iter().map(|pose| turns(pose[2]))))),
    ])
}

/// The visible area, in mm.
#[derive(Clone, Copy, Serialize)]
pub(super) struct View {
    pub(super) left: f32,
    pub(super) right: f32,
    pub(super) bottom: f32,
    pub(super) top: f32,
}

/// The arena, and wherever a robot is.
pub(super) fn view(arena: &Arena, body: f32, poses: &[[f32; 3]]) -> View {
    let bounds = arena.bounds();
    let mut view = View {
        left: bounds.x,
        right: bounds.x + bounds.width,
        bottom: bounds.y,
        top: bounds.y + bounds.height,
    };
    for [x, y, _] in poses {
        (view.left, view.right) = (view.left.min(x - body), view.right.max(x + body));
        (view.bottom, view.top) = (view.bottom.min(y - body), view.top.max(y + body));
    }
    view
}

/// The name of a detail for readers: a Khepera's sensors have numbers in the kernel.
fn shown_name(detail: &Detail) -> String {
    match detail.kind {
        DetailKind::Memory(part) => format!("{}.{}", part.word(), detail.name),
        _ => khepera_sensor(detail).map_or_else(|| detail.name.clone(), |sensor| SENSOR_NAMES[sensor].to_owned()),
    }
}

/// The number of a Khepera's sensor, by which the kernel calls it.
fn khepera_sensor(detail: &Detail) -> Option<usize> {
    let number = detail.name.parse().ok();
    number.filter(|sensor| *sensor < SENSOR_NAMES.len())
}

/// A drawn sensor: its place on the body, in turns and mm from the centre, and its direction.
#[derive(Serialize)]
pub(super) struct DrawnSensor {
    /// The number of its reading.
    pub(super) reading: usize,
    pub(super) bearing: f64,
    pub(super) heading: f64,
    pub(super) offset: f32,
    /// Length of its ray, if it has one, in mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) range: Option<f32>,
    /// Turns of a bumper.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) width: Option<f32>,
}

/// How a parametric robot's sensor is drawn. `None`: it isn't.
fn drawn(sensor: &Sensor, body_radius: f32, reading: usize) -> Option<DrawnSensor> {
    let (range, width) = match sensor.kind.entry().mark {
        Mark::None => return None,
        Mark::Arc => (None, Some(sensor.width.unwrap_or(BUMPER_WIDTH))),
        Mark::Ray => (sensor.range, None),
        Mark::Direction => (Some(0.5 * body_radius), None),
        Mark::Dot => (None, None),
    };
    Some(DrawnSensor {
        reading,
        bearing: sensor.bearing.unwrap_or(sensor.heading).into(),
        heading: sensor.heading.into(),
        offset: sensor.offset.unwrap_or(body_radius),
        range,
        width,
    })
}

/// A word of a trace as a number.
fn value(scalar: Scalar, word: u32) -> f32 {
    match scalar {
        Scalar::Float => f32::from_bits(word),
        Scalar::Unsigned => word as f32,
        Scalar::Signed => word.cast_signed() as f32,
    }
}

/// A word as two of 16 bits, the lower first.
pub(super) fn halves(word: u32) -> [u16; 2] {
    [word as u16, (word >> 16) as u16]
}

/// The arena's shapes: each has corners, or a middle and a radius.
pub(super) fn arena(arena: &Arena) -> Value {
    let round = |x: f32, y: f32, radius: f32| json!({ "middle": [x, y], "radius": radius });
    let patch = |patch: &Patch| {
        let mut shape = match patch.corners() {
            Some(corners) => json!({ "corners": corners.map(<[f32; 2]>::from) }),
            None => round(patch.x, patch.y, patch.radius.unwrap_or(0.0)),
        };
        shape["grey"] = json!(patch.grey);
        shape
    };
    let block = |block: &Block| json!({ "corners": block.corners().map(<[f32; 2]>::from) });
    let obstacles = arena
        .obstacles
        .iter()
        .map(|obstacle| round(obstacle.x, obstacle.y, obstacle.radius));
    let picture = |picture: &Picture| {
        let ([left, bottom], [width, height]) = (picture.low(), picture.sides());
        let cells = picture.coarser(DRAWN_CELLS);
        json!({
            "left": left,
            "bottom": bottom,
            "width": width,
            "height": height,
            "columns": cells.columns(),
            "rows": cells.rows(),
            "greys": base64(cells.greys()),
        })
    };
    json!({
        "ground": { "corners": arena.ground() },
        "open": arena.walls.is_empty(),
        "floor": arena.floor,
        "picture": arena.picture.as_ref().map(picture),
        "patches": arena.patches.iter().map(patch).collect::<Vec<_>>(),
        "objects": obstacles.chain(arena.blocks.iter().map(block)).collect::<Vec<_>>(),
        "walls": arena.walls.iter().map(|wall| [wall.from, wall.to]).collect::<Vec<_>>(),
        "lamps": arena.lights.iter().map(|lamp| [lamp.x, lamp.y]).collect::<Vec<_>>(),
    })
}

#[cfg(test)]
mod tests;
