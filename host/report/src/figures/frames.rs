//! Moments of an episode as drawings of one size: a picture, and the frames of a film.

use oneiro::batch::Record;

use super::arena::Sheet;
use super::episode::{COLOURS, DrawnSensor, EpisodeReplay, FRONT, Reading, View, view};
use super::svg::{Anchor, INK, SOFT, Svg, number};

/// Room around the visible area as a fraction of its longer side.
const MARGIN: f64 = 0.03;
/// Seconds of the trails of swarms, and of robots that are alone.
const TRAIL: f64 = 20.0;
const LONG_TRAIL: f64 = 60.0;
/// Pieces of a trail, each paler than the one before.
const PIECES: usize = 10;
/// Width of a wall as a fraction of the longer side.
const WALL: f64 = 0.005;
/// Colour of sensors.
const SENSOR: &str = "#b3263c";
/// Colour of pucks, and of their edges.
const PUCK: (&str, &str) = ("#93b94a", "#55741c");
/// Seconds in a cycle.
const CYCLE: f64 = 0.1;

/// Moments of one size, as SVG.
pub trait Film {
    /// Seconds from the beginning to the last record, and from one record to the next.
    fn seconds(&self) -> f64;
    fn step(&self) -> f64;
    /// The record that is nearest to a time.
    fn at(&self, seconds: f64) -> String;
}

/// Draws moments of an episode.
pub struct Frames<'a> {
    replay: &'a EpisodeReplay<'a>,
    sheet: Sheet,
    /// Width and height in pixels.
    size: (f64, f64),
    readings: Vec<Reading>,
    sensors: Vec<DrawnSensor>,
    /// Colours of robots without a machine, and for each line the states of those with one.
    plain: Vec<String>,
    states: Vec<u16>,
}

impl<'a> Frames<'a> {
    /// The longer side of the arena gets `side` pixels.
    pub fn new(replay: &'a EpisodeReplay<'a>, side: f64) -> Self {
        let spec = replay.world.spec();
        let poses = replay.robots.iter().flat_map(|trace| trace.iter());
        let poses: Vec<[f32; 3]> = poses.map(|record| [record.x, record.y, record.heading]).collect();
        let View {
            left,
            right,
            bottom,
            top,
        } = view(&spec.arena, spec.robot.body_radius, &poses);
        let [left, right, bottom, top] = [left, right, bottom, top].map(f64::from);
        let room = MARGIN * (right - left).max(top - bottom);
        let extent = (right - left + 2.0 * room, top - bottom + 2.0 * room);
        let sheet = Sheet::of((left - room, top + room), extent, (0.0, 0.0), side);
        let (width, height) = sheet.extent();
        Self {
            size: (width.round(), (height + FOOT).round()),
            sheet,
            readings: replay.readings(),
            sensors: if replay.robots.len() == 1 {
                replay.sensors()
            } else {
                Vec::new()
            },
            plain: replay.plain().into_iter().map(|(_, colour)| colour).collect(),
            states: replay.machine_states(),
            replay,
        }
    }

    fn draw(&self, line: usize) -> String {
        let (width, height) = self.size;
        let mut svg = Svg::new(width, height, self.replay.title);
        let spec = self.replay.world.spec();
        self.sheet.ground(&mut svg, &spec.arena, WALL * width.max(height));
        for robot in 0..self.replay.robots.len() {
            self.trail(&mut svg, robot, line);
        }
        for robot in 0..self.replay.robots.len() {
            self.robot(&mut svg, robot, line);
        }
        self.pucks(&mut svg, line);
        let share = line as f64 / self.last().max(1) as f64;
        let words = format!("{} s of {} s", number(self.time(line)), number(self.seconds()));
        foot(&mut svg, self.size, share, &words);
        svg.finish()
    }

    fn last(&self) -> usize {
        self.replay.robots[0].len().saturating_sub(1)
    }

    fn time(&self, line: usize) -> f64 {
        line as f64 * f64::from(self.replay.every) * CYCLE
    }

    fn colour(&self, robot: usize, line: usize) -> &str {
        let state = self.states.get(line * self.replay.robots.len() + robot);
        match state {
            Some(&state) if state != u16::MAX => COLOURS[usize::from(state) % COLOURS.len()],
            _ => &self.plain[robot],
        }
    }

    fn place(&self, record: &Record) -> (f64, f64) {
        self.sheet.place((record.x.into(), record.y.into()))
    }

    fn trail(&self, svg: &mut Svg, robot: usize, line: usize) {
        let is_alone = self.replay.robots.len() == 1 || self.replay.is_alone();
        let (seconds, colour, strength, width) = if is_alone {
            let width = (5.0 * self.sheet.scale).max(1.4);
            (LONG_TRAIL, &*self.plain[robot], 0.6, width)
        } else {
            (TRAIL, INK, 0.4, 1.2)
        };
        // Twice a second is enough for a line.
        let stride = (0.5 / self.step()).round().max(1.0) as usize;
        let lines = (seconds / self.step()).round() as usize;
        let piece = lines.div_ceil(PIECES).next_multiple_of(stride);
        let trace = &self.replay.robots[robot];
        let mut newer = line;
        for age in 0..PIECES {
            let older = newer.saturating_sub(piece);
            if older == newer {
                break;
            }
            let places = (older..=newer).rev().step_by(stride);
            let places = places.map(|line| self.place(&trace[line]));
            let opacity = number(strength * (1.0 - age as f64 / PIECES as f64));
            let style = format!(
                "stroke=\"{colour}\" stroke-width=\"{}\" stroke-linejoin=\"round\" stroke-opacity=\"{opacity}\"",
                number(width)
            );
            svg.polyline(places, &style);
            newer = older;
        }
    }

    fn robot(&self, svg: &mut Svg, robot: usize, line: usize) {
        let record = &self.replay.robots[robot][line];
        let radius = f64::from(self.replay.world.spec().robot.body_radius) * self.sheet.scale;
        let colours = (self.colour(robot, line), FRONT);
        begin_robot(svg, self.place(record), record.heading.into(), radius, colours);
        for sensor in &self.sensors {
            self.sensor(svg, sensor, line, radius);
        }
        svg.raw("</g>");
    }

    /// Draws pucks, after the robots that may carry them.
    fn pucks(&self, svg: &mut Svg, line: usize) {
        let radius = f64::from(self.replay.world.spec().pucks.radius.unwrap_or_default()) * self.sheet.scale;
        for [x, y] in (0..self.replay.compared.worlds()).flat_map(|world| self.replay.pucks(world, line)) {
            let style = format!("fill=\"{}\" stroke=\"{}\" stroke-width=\"1.2\"", PUCK.0, PUCK.1);
            svg.circle(self.sheet.place((x.into(), y.into())), radius, &style, "");
        }
    }

    /// Draws a sensor of the only robot, from its centre.
    fn sensor(&self, svg: &mut Svg, sensor: &DrawnSensor, line: usize, radius: f64) {
        let share = f64::from(self.readings[sensor.reading].strength(line));
        let opacity = number(0.25 + 0.75 * share);
        let at = |turns: f64, length: f64| {
            let angle = std::f64::consts::TAU * turns;
            (length * angle.cos(), -length * angle.sin())
        };
        if let Some(width) = sensor.width {
            let points = (0..=8).map(|i| {
                at(
                    sensor.heading + f64::from(width) * (f64::from(i) / 8.0 - 0.5),
                    radius + 2.0,
                )
            });
            let width = number(2.0 + 3.0 * share);
            svg.polyline(
                points,
                &format!("stroke=\"{SENSOR}\" stroke-width=\"{width}\" stroke-opacity=\"{opacity}\""),
            );
            return;
        }
        let from = at(sensor.bearing, f64::from(sensor.offset) * self.sheet.scale);
        if let Some(range) = sensor.range {
            let (ahead, aside) = at(sensor.heading, f64::from(range) * self.sheet.scale);
            let width = number(1.0 + 2.5 * share);
            let style = format!("stroke=\"{SENSOR}\" stroke-width=\"{width}\" stroke-opacity=\"{opacity}\"");
            svg.line(from, (from.0 + ahead, from.1 + aside), &style);
        }
        svg.circle(
            from,
            2.0 + 2.0 * share,
            &format!("fill=\"{SENSOR}\" fill-opacity=\"{opacity}\""),
            "",
        );
    }
}

impl Film for Frames<'_> {
    fn seconds(&self) -> f64 {
        self.time(self.last())
    }

    fn step(&self) -> f64 {
        self.time(1)
    }

    fn at(&self, seconds: f64) -> String {
        self.draw(((seconds / self.step()).round() as usize).min(self.last()))
    }
}

/// Draws a robot from above with an arrow to its front, and leaves its group open. Heading in turns, the rest in pixels.
pub(super) fn begin_robot(svg: &mut Svg, (x, y): (f64, f64), heading: f64, radius: f64, (colour, front): (&str, &str)) {
    let [x, y, turn] = [x, y, -360.0 * heading].map(number);
    svg.raw(&format!("<g transform=\"translate({x} {y}) rotate({turn})\">"));
    let style = format!("fill=\"{colour}\" stroke=\"{front}\" stroke-width=\"1.2\"");
    svg.circle((0.0, 0.0), radius, &style, "");
    let arrow = [(0.98, 0.0), (0.5, 0.5), (0.5, -0.5)].map(|(x, y)| (x * radius, y * radius));
    svg.polygon(arrow, &format!("fill=\"{front}\""));
}

/// Room for the time below a drawing, in pixels.
pub(super) const FOOT: f64 = 26.0;

/// The time as a bar below the arena, which pixels show too, and in words.
pub(super) fn foot(svg: &mut Svg, (width, height): (f64, f64), share: f64, words: &str) {
    let top = height - FOOT + 4.0;
    svg.rectangle((0.0, top), (width, 4.0), "fill=\"#e3e5e8\"");
    svg.rectangle((0.0, top), (share * width, 4.0), "fill=\"#5b6770\"");
    svg.words((4.0, height - 5.0), 12.0, Anchor::Start, SOFT, words);
}
