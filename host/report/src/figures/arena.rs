//! An arena drawn to scale, and an episode's path in it.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::fmt::Write;

use glam::DVec2;
use oneiro::arena::{Arena, Field};
use oneiro::batch::Record;
use oneiro::differential::{BUMPER_WIDTH, Mark, Sensor};
use oneiro::parameter::Choice;
use oneiro::picture::Picture;
use oneiro::world::Start;

use super::svg::{Anchor, BOLD, INK, SOFT, SOFT_INK, Svg, joined, number, ramp, tick_step};
use super::tables::HEAT;

/// Longer side of the arena in a picture, in pixels.
const SIDE: f64 = 880.0;
/// Room around the arena, above it for the title, and below it for the key.
const MARGIN: f64 = 28.0;
const HEAD: f64 = 28.0;
const FOOT: f64 = 34.0;
/// Most cells of a floor's picture along a side in a drawing.
pub(super) const DRAWN_CELLS: u32 = 200;
/// Colours of a path from its start to its end.
const TIME: [[u8; 3]; 4] = [
    [0x2b, 0x3a, 0x8f],
    [0x8a, 0x3f, 0xa0],
    [0xd9, 0x48, 0x5f],
    [0xf4, 0xa2, 0x3b],
];
/// Colour of the fittest individual's path.
const FITTEST: [u8; 3] = [0xd9, 0x48, 0x5f];
/// Room of a name next to the robot, in pixels.
const NAME: (f64, f64) = (60.0, 15.0);
/// Number of single-coloured pieces in which a path is drawn.
const PIECES: usize = 64;
/// Duration of a cycle in seconds.
const CYCLE: f64 = 0.1;

/// Draws an arena, with a robot at the common start of all episodes or else, for scale, where there is most room, and a
/// parametric robot's sensors. `body_radius` is in mm.
pub fn arena(arena: &Arena, body_radius: f32, sensors: &[Sensor], start: &Start) -> String {
    let sheet = Sheet::new(arena);
    let title = format!(
        "{}: {} x {} mm",
        arena.name,
        number_mm(arena.within_walls().width),
        number_mm(arena.within_walls().height)
    );
    let mut svg = sheet.start(arena, &title);
    let pose = |[x, y, heading]: [f32; 3]| ((f64::from(x), f64::from(y)), f64::from(heading));
    let poses = match start {
        Start::Random => vec![(roomiest(arena, arena.field), 0.0)],
        Start::Zone(zone) => vec![(roomiest(arena, zone.bounds(arena).unwrap_or(arena.field)), 0.0)],
        Start::At { x, y, heading } => vec![pose([*x, *y, *heading])],
        Start::Poses(poses) => poses.0.iter().copied().map(pose).collect(),
    };
    for (at, heading) in &poses {
        sheet.robot(&mut svg, *at, *heading, f64::from(body_radius), SOFT_INK, 0.06);
    }
    let (at, heading) = poses[0];
    for sensor in sensors {
        sheet.sensor(&mut svg, at, heading, body_radius, sensor);
    }
    sheet.foot(&mut svg);
    svg.finish()
}

/// Draws an episode's path. `trace` is in the order of its cycles, `every` cycles apart.
pub fn life(arena: &Arena, body_radius: f32, title: &str, trace: &[Record], every: u32) -> String {
    let sheet = Sheet::new(arena);
    let mut svg = sheet.start(arena, title);
    sheet.path(&mut svg, trace);
    let body = f64::from(body_radius);
    let mut before = (f64::NEG_INFINITY, f64::NEG_INFINITY);
    for (record, colour, label) in [
        (trace.first(), TIME[0], "start"),
        (trace.last(), TIME[TIME.len() - 1], "end"),
    ] {
        let Some(record) = record else { continue };
        let at = (f64::from(record.x), f64::from(record.y));
        let colour = ramp(&[colour], 0.0);
        sheet.robot(&mut svg, at, f64::from(record.heading), body, &colour, 0.22);
        let (x, y) = sheet.place(at);
        let style =
            format!("fill=\"{INK}\" font-weight=\"600\" stroke=\"#ffffff\" stroke-width=\"3\" paint-order=\"stroke\"");
        let beside = body * sheet.scale + 6.0;
        // Where the robot ends near its start, the second name stands below the first.
        let is_near = (x - before.0).abs() < NAME.0 && (y - before.1).abs() < NAME.1;
        let y = if is_near { before.1 + NAME.1 } else { y };
        before = (x, y);
        // Towards the middle of the arena, where there is room.
        if x < 0.5 * sheet.width() {
            svg.words((x + beside, y + 4.0), 13.0, Anchor::Start, &style, label);
        } else {
            svg.words((x - beside, y + 4.0), 13.0, Anchor::End, &style, label);
        }
    }
    sheet.foot(&mut svg);
    let collisions = trace.iter().filter(|record| record.collided > 0.0).count();
    let seconds = trace.len().saturating_sub(1) as f64 * f64::from(every) * CYCLE;
    sheet.clock(&mut svg, seconds, collisions);
    svg.finish()
}

/// An individual's path: positions in mm, and its fitness.
pub struct Path {
    pub places: Vec<[f32; 2]>,
    pub fitness: f32,
}

/// Draws the paths of several individuals, each alone in the arena: the darker, the fitter. The fittest is drawn last, and bold.
pub fn paths(arena: &Arena, title: &str, paths: &[Path]) -> String {
    const ROOM: f64 = 6.0;
    let sheet = Sheet::within(arena, (ROOM, ROOM), SIDE);
    let (width, height) = sheet.extent();
    let mut svg = Svg::new(width + 2.0 * ROOM, height + 2.0 * ROOM, title);
    sheet.ground(&mut svg, arena, 5.0);
    let mut ranked: Vec<&Path> = paths.iter().collect();
    // NaN is below all numbers.
    ranked.sort_by(|a, b| {
        (!a.fitness.is_nan(), a.fitness)
            .partial_cmp(&(!b.fitness.is_nan(), b.fitness))
            .unwrap_or(Ordering::Equal)
    });
    let last = ranked.len().saturating_sub(1);
    for (rank, path) in ranked.iter().enumerate() {
        let places = path.places.iter().map(|place| sheet.place(place.map(f64::from).into()));
        let (colour, width) = if rank == last {
            (ramp(&[FITTEST], 0.0), 3.5)
        } else {
            (ramp(&HEAT, rank as f64 / last as f64), 1.4)
        };
        let style = format!("stroke=\"{colour}\" stroke-width=\"{width}\" stroke-linejoin=\"round\"");
        svg.polyline(places, &style);
    }
    svg.finish()
}

/// The point of a grid over the field that is farthest from all walls and obstacles, and from the field's edges; the first one if
/// several are equal.
fn roomiest(arena: &Arena, field: Field) -> (f64, f64) {
    const GRID: u32 = 24;
    let place =
        |i: u32, from: f32, size: f32| f64::from(from) + (f64::from(i) + 0.5) / f64::from(GRID) * f64::from(size);
    let points = (0..GRID * GRID).map(|i| {
        (
            place(i % GRID, field.x, field.width),
            place(i / GRID, field.y, field.height),
        )
    });
    let mut best = ((f64::from(field.x), f64::from(field.y)), f64::NEG_INFINITY);
    for point in points {
        let edges = [point.0 - f64::from(field.x), point.1 - f64::from(field.y)];
        let sizes = [field.width, field.height].map(f64::from);
        let within = [0, 1].map(|axis| edges[axis].min(sizes[axis] - edges[axis]));
        let room = clearance(arena, point).min(within[0]).min(within[1]);
        if room > best.1 {
            best = (point, room);
        }
    }
    best.0
}

/// Distance from a point to the nearest object, mm; negative inside one.
fn clearance(arena: &Arena, (x, y): (f64, f64)) -> f64 {
    let walls = arena.walls.iter().map(|wall| {
        let [from_x, from_y] = wall.from.map(f64::from);
        let (along_x, along_y) = (f64::from(wall.to[0]) - from_x, f64::from(wall.to[1]) - from_y);
        let squared = along_x * along_x + along_y * along_y;
        let share = ((x - from_x) * along_x + (y - from_y) * along_y) / squared.max(f64::MIN_POSITIVE);
        let share = share.clamp(0.0, 1.0);
        let (dx, dy) = (from_x + share * along_x - x, from_y + share * along_y - y);
        (dx * dx + dy * dy).sqrt()
    });
    let obstacles = arena.obstacles.iter().map(|obstacle| {
        let (dx, dy) = (f64::from(obstacle.x) - x, f64::from(obstacle.y) - y);
        (dx * dx + dy * dy).sqrt() - f64::from(obstacle.radius)
    });
    let blocks = arena.blocks.iter().map(|block| {
        let axis = block.axis().as_dvec2();
        let from = DVec2::new(x - f64::from(block.x), y - f64::from(block.y));
        let beyond_x = from.dot(axis).abs() - 0.5 * f64::from(block.length);
        let beyond_y = from.perp_dot(axis).abs() - 0.5 * f64::from(block.width);
        // Inside, both are negative, and the greater one belongs to the nearer side.
        let outside = DVec2::new(beyond_x.max(0.0), beyond_y.max(0.0)).length();
        outside + beyond_x.max(beyond_y).min(0.0)
    });
    walls.chain(obstacles).chain(blocks).fold(f64::INFINITY, f64::min)
}

/// Mapping from millimetres to pixels: x to the right, y up in the arena and down in the picture.
pub(super) struct Sheet {
    /// The arena's upper left corner, in mm and in the picture.
    left: f64,
    top: f64,
    corner: (f64, f64),
    size: (f64, f64),
    pub(super) scale: f64,
}

impl Sheet {
    /// A mapping that fills a separate picture.
    fn new(arena: &Arena) -> Self {
        Self::within(arena, (MARGIN, MARGIN + HEAD), SIDE)
    }

    /// Maps the field and everything around it to a given upper left corner and longer side in pixels.
    pub(super) fn within(arena: &Arena, corner: (f64, f64), side: f64) -> Self {
        let bounds = arena.bounds();
        let size = (f64::from(bounds.width), f64::from(bounds.height));
        Self::of(
            (f64::from(bounds.x), f64::from(bounds.y + bounds.height)),
            size,
            corner,
            side,
        )
    }

    /// Maps an arena, given by its upper left corner and size in mm, to a given upper left corner and longer side in
    /// pixels.
    pub(super) fn of((left, top): (f64, f64), size: (f64, f64), corner: (f64, f64), side: f64) -> Self {
        let size = (size.0.max(1.0), size.1.max(1.0));
        Self {
            left,
            top,
            corner,
            size,
            scale: side / size.0.max(size.1),
        }
    }

    /// Width and height of the arena in the picture.
    pub(super) fn extent(&self) -> (f64, f64) {
        (self.size.0 * self.scale, self.size.1 * self.scale)
    }

    fn width(&self) -> f64 {
        // The text also needs room below narrow arenas.
        (self.size.0 * self.scale).max(0.6 * SIDE) + 2.0 * MARGIN
    }

    fn height(&self) -> f64 {
        self.size.1 * self.scale + 2.0 * MARGIN + HEAD + FOOT
    }

    /// Maps a point of the arena into the picture.
    pub(super) fn place(&self, at: (f64, f64)) -> (f64, f64) {
        (
            self.corner.0 + (at.0 - self.left) * self.scale,
            self.corner.1 + (self.top - at.1) * self.scale,
        )
    }

    /// Draws title, floor, obstacles and walls.
    fn start(&self, arena: &Arena, title: &str) -> Svg {
        let mut svg = Svg::new(self.width(), self.height(), title);
        svg.words((MARGIN, MARGIN + 4.0), 16.0, Anchor::Start, BOLD, title);
        self.ground(&mut svg, arena, 5.0);
        svg
    }

    /// Draws floor, obstacles and walls of the given width.
    pub(super) fn ground(&self, svg: &mut Svg, arena: &Arena, wall_width: f64) {
        let ground = arena.ground().into_iter();
        let ground = joined(ground.map(|corner| self.place(corner.map(f64::from).into())));
        let grey = |share: f32| filled(drawn(share));
        let floor = arena.floor.map_or_else(|| "fill=\"#f5f3ee\"".into(), grey);
        svg.raw(&format!("<polygon points=\"{ground}\" {floor}/>"));
        // Beyond the walls there is no floor. A page may have many pictures: equal names are equal shapes.
        let clip = format!("ground-{}", &blake3::hash(ground.as_bytes()).to_hex()[..8]);
        let has_greys = !arena.patches.is_empty() || arena.picture.is_some();
        if has_greys {
            svg.raw(&format!(
                "<clipPath id=\"{clip}\"><polygon points=\"{ground}\"/></clipPath>\n<g clip-path=\"url(#{clip})\">"
            ));
        }
        if let Some(picture) = &arena.picture {
            self.picture(svg, picture);
        }
        for patch in &arena.patches {
            let style = grey(patch.grey);
            let at = self.place((f64::from(patch.x), f64::from(patch.y)));
            match patch.corners() {
                Some(corners) => svg.polygon(corners.map(|corner| self.place(corner.as_dvec2().into())), &style),
                None => svg.circle(at, f64::from(patch.radius.unwrap_or(0.0)) * self.scale, &style, ""),
            }
        }
        if has_greys {
            svg.raw("</g>");
        }
        for light in &arena.lights {
            let at = self.place((f64::from(light.x), f64::from(light.y)));
            svg.circle(
                at,
                6.0,
                "fill=\"#f4c430\" stroke=\"#a67c00\" stroke-width=\"1.5\"",
                "a light",
            );
        }
        for obstacle in &arena.obstacles {
            let at = self.place((f64::from(obstacle.x), f64::from(obstacle.y)));
            let radius = f64::from(obstacle.radius) * self.scale;
            let hint = format!("{}, radius {} mm", obstacle.class, number_mm(obstacle.radius));
            svg.circle(
                at,
                radius,
                "fill=\"#c9ccd3\" stroke=\"#7c818c\" stroke-width=\"2\"",
                &hint,
            );
        }
        for block in &arena.blocks {
            let corners = block.corners().map(|corner| self.place(corner.as_dvec2().into()));
            svg.polygon(corners, "fill=\"#c9ccd3\" stroke=\"#7c818c\" stroke-width=\"2\"");
        }
        for wall in &arena.walls {
            let from = self.place((f64::from(wall.from[0]), f64::from(wall.from[1])));
            let to = self.place((f64::from(wall.to[0]), f64::from(wall.to[1])));
            svg.line(
                from,
                to,
                &format!(
                    "stroke=\"{INK}\" stroke-width=\"{}\" stroke-linecap=\"round\"",
                    number(wall_width)
                ),
            );
        }
    }

    /// Draws the picture on a floor: a path for each grey, of rectangles along rows of cells. Lengths in it are in cells.
    fn picture(&self, svg: &mut Svg, picture: &Picture) {
        let [width, height] = picture.sides().map(f64::from);
        let (x, y) = self.place(picture.low().map(f64::from).into());
        let picture = picture.coarser(DRAWN_CELLS);
        let mut paths: BTreeMap<u8, String> = BTreeMap::new();
        for (row, greys) in picture.greys().chunks(picture.columns() as usize).enumerate() {
            let shades: Vec<u8> = greys.iter().map(|grey| drawn(f32::from(*grey) / 255.0)).collect();
            let mut column = 0;
            for run in shades.chunk_by(|one, next| one == next) {
                let _ = write!(
                    paths.entry(run[0]).or_default(),
                    "M{column} {row}h{0}v1h-{0}z",
                    run.len()
                );
                column += run.len();
            }
        }
        svg.raw(&format!(
            "<g transform=\"translate({} {}) scale({:.6} {:.6})\" shape-rendering=\"crispEdges\">",
            number(x),
            number(y),
            width * self.scale / f64::from(picture.columns()),
            -height * self.scale / f64::from(picture.rows()),
        ));
        for (shade, path) in paths {
            svg.raw(&format!("<path d=\"{path}\" {}/>", filled(shade)));
        }
        svg.raw("</g>");
    }

    /// Draws a robot from above: body, wheels, and a line to its front. Heading in turns, counter-clockwise.
    pub(super) fn robot(&self, svg: &mut Svg, at: (f64, f64), heading: f64, radius: f64, colour: &str, filled: f64) {
        let (x, y) = self.place(at);
        let r = radius * self.scale;
        svg.raw(&format!(
            "<g transform=\"translate({} {}) rotate({})\" stroke=\"{colour}\" stroke-width=\"2\">",
            number(x),
            number(y),
            number(-360.0 * heading),
        ));
        let body = format!("fill=\"{colour}\" fill-opacity=\"{}\"", number(filled));
        svg.circle((0.0, 0.0), r, &body, "");
        for side in [-0.86, 0.68] {
            svg.rectangle(
                (-0.28 * r, side * r),
                (0.56 * r, 0.18 * r),
                &format!("fill=\"{colour}\" stroke=\"none\""),
            );
        }
        svg.line((0.0, 0.0), (r, 0.0), "stroke-linecap=\"round\"");
        svg.raw("</g>");
    }

    /// Draws a sensor of a robot: a dot where it is, and a line along its ray or in the direction in
    /// which it looks. A bumper is its arc of the body. Where a sampled sensor is, its tables don't say.
    fn sensor(&self, svg: &mut Svg, at: (f64, f64), heading: f64, body_radius: f32, sensor: &Sensor) {
        const COLOUR: &str = "#c1121f";
        let mark = sensor.kind.entry().mark;
        if mark == Mark::None {
            return;
        }
        let (x, y) = self.place(at);
        let [body, offset] = [body_radius, sensor.offset.unwrap_or(body_radius)].map(|mm| f64::from(mm) * self.scale);
        let width = match mark {
            Mark::Arc => f64::from(sensor.width.unwrap_or(BUMPER_WIDTH)),
            _ => 0.0,
        };
        // Half of a bumper's arc is on either side of its heading.
        let turn = -360.0 * (heading + f64::from(sensor.heading) + 0.5 * width);
        svg.raw(&format!(
            "<g transform=\"translate({} {}) rotate({})\" stroke=\"{COLOUR}\">",
            number(x),
            number(y),
            number(turn)
        ));
        let hint = format!("{}: {}", sensor.name, sensor.kind.word());
        let dot = format!("fill=\"{COLOUR}\"");
        match mark {
            Mark::Arc => {
                let arc = format!(
                    "fill=\"none\" stroke-width=\"5\" pathLength=\"1\" stroke-dasharray=\"{} 1\"",
                    number(width)
                );
                svg.circle((0.0, 0.0), body, &arc, &hint);
            }
            Mark::Dot => svg.circle((offset, 0.0), 2.5, &dot, &hint),
            _ => {
                let range = f64::from(sensor.range.unwrap_or(0.0)) * self.scale;
                let (length, style) = match mark {
                    Mark::Direction => (0.5 * body, "stroke-width=\"1.2\" stroke-dasharray=\"3 2\""),
                    // Beyond the picture there is nothing to see.
                    _ => (range.min(2.0 * SIDE), "stroke-width=\"1.2\" stroke-opacity=\"0.5\""),
                };
                svg.line((offset, 0.0), (offset + length, 0.0), style);
                svg.circle((offset, 0.0), 2.5, &dot, &hint);
            }
        }
        svg.raw("</g>");
    }

    /// Draws the path of the robot's centre, coloured by time, and its collisions.
    fn path(&self, svg: &mut Svg, trace: &[Record]) {
        let points: Vec<(f64, f64)> = trace
            .iter()
            .map(|record| self.place((f64::from(record.x), f64::from(record.y))))
            .collect();
        let piece = points.len().div_ceil(PIECES).max(2);
        svg.raw("<g stroke-width=\"2.4\" stroke-linecap=\"round\" stroke-linejoin=\"round\">");
        let mut first = 0;
        while first + 1 < points.len() {
            let last = (first + piece).min(points.len() - 1);
            let share = 0.5 * (first + last) as f64 / (points.len() - 1) as f64;
            let colour = ramp(&TIME, share);
            svg.polyline(points[first..=last].iter().copied(), &format!("stroke=\"{colour}\""));
            first = last;
        }
        svg.raw("</g>");
        for (record, &(x, y)) in trace.iter().zip(&points) {
            if record.collided > 0.0 {
                svg.raw(&cross(x, y));
            }
        }
    }

    /// Draws a scale bar.
    fn foot(&self, svg: &mut Svg) {
        let line = self.height() - 24.0;
        let length = tick_step(self.size.0.max(self.size.1), 8);
        let right = self.width() - MARGIN;
        let left = right - length * self.scale;
        let style = format!("stroke=\"{INK}\" stroke-width=\"2\"");
        svg.line((left, line - 8.0), (right, line - 8.0), &style);
        for x in [left, right] {
            svg.line((x, line - 12.0), (x, line - 4.0), &style);
        }
        let words = format!("{} mm", number(length));
        let middle = 0.5 * (left + right);
        svg.words((middle, line + 10.0), 12.0, Anchor::Middle, SOFT, &words);
    }

    /// Draws the key to the colours and marks of a path.
    fn clock(&self, svg: &mut Svg, seconds: f64, collisions: usize) {
        const WIDTH: f64 = 110.0;
        let line = self.height() - 24.0;
        svg.raw("<defs><linearGradient id=\"time\">");
        for (i, &stop) in TIME.iter().enumerate() {
            let share = i as f64 / (TIME.len() - 1) as f64;
            let colour = ramp(&[stop], 0.0);
            svg.raw(&format!("<stop offset=\"{}\" stop-color=\"{colour}\"/>", number(share)));
        }
        svg.raw("</linearGradient></defs>");
        svg.rectangle((MARGIN, line - 11.0), (WIDTH, 6.0), "fill=\"url(#time)\" rx=\"3\"");
        svg.words((MARGIN, line + 10.0), 12.0, Anchor::Start, SOFT, "0 s");
        let end = format!("{} s", number(seconds));
        svg.words((MARGIN + WIDTH, line + 10.0), 12.0, Anchor::End, SOFT, &end);
        if collisions > 0 {
            let left = MARGIN + WIDTH + 40.0;
            svg.raw(&cross(left, line - 2.0));
            let words = format!("collision ({collisions})");
            svg.words((left + 10.0, line + 2.0), 12.0, Anchor::Start, SOFT, &words);
        }
    }
}

/// The shade of a grey of the floor from 0 to 1: black is a dark grey, so that paths are visible.
fn drawn(grey: f32) -> u8 {
    (70.0 + 185.0 * grey) as u8
}

/// Fills with a shade.
fn filled(shade: u8) -> String {
    format!("fill=\"rgb({shade} {shade} {shade})\"")
}

/// Mark of a collision.
fn cross(x: f64, y: f64) -> String {
    let (left, top) = (number(x - 3.0), number(y - 3.0));
    format!("<path d=\"M{left} {top}l6 6m0 -6l-6 6\" stroke=\"#c1121f\" stroke-width=\"1.6\"/>")
}

/// Formats millimetres without needless decimals.
fn number_mm(x: f32) -> String {
    number(f64::from(x))
}

#[cfg(test)]
mod tests {
    use oneiro::arena::Patch;
    use oneiro::differential::SensorKind;

    use super::*;

    fn trace(points: &[(f32, f32, f32)]) -> Vec<Record> {
        points
            .iter()
            .map(|&(x, y, collided)| Record {
                x,
                y,
                collided,
                ..Record::default()
            })
            .collect()
    }

    #[test]
    fn everything_in_an_arena_is_drawn() {
        let miglino = Arena::miglino1995();
        let text = arena(&miglino, 27.5, &[], &Start::Random);
        assert_eq!(
            text.matches("<line").count(),
            miglino.walls.len() + 1 + 3,
            "walls, front, scale"
        );
        assert_eq!(
            text.matches("<circle").count(),
            miglino.obstacles.len() + 1,
            "obstacles, body"
        );
    }

    #[test]
    fn a_block_is_drawn_where_it_stands() {
        let miglino = Arena::miglino1995_block();
        let text = arena(&miglino, 27.5, &[], &Start::Random);
        assert_eq!(text.matches("<polygon").count(), 1 + 1, "the floor and the block");
        // The block's long axis is tilted by 30 degrees and passes through (300, 175).
        let along = |mm: f64| (300.0 + mm * 0.75_f64.sqrt(), 175.0 + 0.5 * mm);
        for (mm, expected) in [(75.0, 20.0), (-75.0, 20.0), (0.0, -27.5), (50.0, -5.0)] {
            let room = clearance(&miglino, along(mm));
            assert!((room - expected).abs() < 1e-4, "{room} at {mm} mm along it");
        }
    }

    /// A polygon's field is the square around the disc in which robots start: its corners lie beyond the walls.
    #[test]
    fn the_floor_ends_at_the_walls() {
        let corners = [[440.0, 0.0], [880.0, 440.0], [440.0, 880.0], [0.0, 440.0]];
        let diamond = Arena::polygon(&corners, None);
        // A pixel is a millimetre.
        let walls = "468,936 908,496 468,56 28,496";
        let text = arena(&diamond, 40.0, &[], &Start::Random);
        assert!(
            text.contains(&format!("<polygon points=\"{walls}\" fill=\"#f5f3ee\"/>")),
            "{text}"
        );
        // The sheet and the wheels.
        assert_eq!(text.matches("<rect").count(), 1 + 2, "{text}");
        let patch = Patch {
            x: 0.0,
            y: 0.0,
            radius: Some(500.0),
            ..Patch::default()
        };
        let patched = |arena: Arena| Arena {
            patches: vec![patch.clone()],
            ..arena
        };
        let text = arena(&patched(diamond), 40.0, &[], &Start::Random);
        assert!(
            text.contains("<clipPath id=\"ground-")
                && text.contains(&format!("\"><polygon points=\"{walls}\"/></clipPath>"))
        );
        let clipped = text.split("<g clip-path=\"url(#ground-").nth(1).unwrap();
        assert!(clipped.split("</g>").next().unwrap().contains("r=\"500\""), "{text}");
        // On a page with several pictures equal names are equal shapes.
        let name = |text: &str| {
            text.split("<clipPath id=\"")
                .nth(1)
                .unwrap()
                .split('"')
                .next()
                .unwrap()
                .to_owned()
        };
        let other = arena(&patched(Arena::rectangle(880.0, 880.0)), 40.0, &[], &Start::Random);
        assert_ne!(name(&text), name(&other));
    }

    #[test]
    fn sensors_are_drawn_where_they_are_and_where_they_look() {
        let sensor = |name: &str, kind, heading| Sensor {
            name: name.into(),
            kind,
            heading,
            range: Some(50.0),
            ..Sensor::default()
        };
        let sensors = [
            sensor("eye", SensorKind::Proximity, 0.25),
            Sensor {
                offset: Some(10.0),
                ..sensor("floor", SensorKind::Ground, -0.125)
            },
            Sensor {
                width: Some(0.2),
                ..sensor("bump", SensorKind::Bumper, 0.0)
            },
        ];
        // A pixel is a millimetre.
        let text = arena(&Arena::rectangle(880.0, 440.0), 40.0, &sensors, &Start::Random);
        for part in [
            "rotate(-90)\" stroke=\"#c1121f\"",
            "x1=\"40\" y1=\"0\" x2=\"90\" y2=\"0\"",
            "eye: proximity",
            "rotate(45)\" stroke",
            "cx=\"10\" cy=\"0\" r=\"2.5\" fill=\"#c1121f\"><title>floor: ground",
            "rotate(-36)\" stroke",
            "r=\"40\" fill=\"none\" stroke-width=\"5\" pathLength=\"1\" stroke-dasharray=\"0.2 1\"><title>bump: bumper",
        ] {
            assert!(text.contains(part), "{part} in {text}");
        }
    }

    #[test]
    fn a_robot_is_drawn_at_its_start_and_looks_where_it_does_then() {
        let sensor = Sensor {
            name: "eye".into(),
            kind: SensorKind::Proximity,
            heading: 0.25,
            range: Some(50.0),
            ..Sensor::default()
        };
        let start = Start::At {
            x: 250.0,
            y: 150.0,
            heading: 0.125,
        };
        // A pixel is a millimetre.
        let text = arena(
            &Arena::rectangle(880.0, 440.0),
            40.0,
            std::slice::from_ref(&sensor),
            &start,
        );
        let (x, y) = (MARGIN + 250.0, MARGIN + HEAD + 440.0 - 150.0);
        for turn in [-45, -135] {
            let place = format!("translate({x} {y}) rotate({turn})");
            assert!(text.contains(&place), "{place} in {text}");
        }
        // Without a start, and without walls, it stands inside of the field.
        let open = Arena {
            walls: Vec::new(),
            ..Arena::rectangle(880.0, 440.0)
        };
        let (x, y) = roomiest(&open, open.field);
        assert!((200.0..680.0).contains(&x) && (200.0..240.0).contains(&y), "{x}, {y}");
    }

    #[test]
    fn y_points_up() {
        let sheet = Sheet::new(&Arena::rectangle(600.0, 300.0));
        assert!(sheet.place((0.0, 300.0)).1 < sheet.place((0.0, 0.0)).1);
        assert_eq!(sheet.place((0.0, 300.0)), (MARGIN, MARGIN + HEAD));
        let corner = sheet.place((600.0, 0.0));
        assert!((corner.0 - MARGIN - SIDE).abs() < 1e-9 && (corner.1 - MARGIN - HEAD - 0.5 * SIDE).abs() < 1e-9);
    }

    #[test]
    fn the_robot_stands_where_there_is_room() {
        let arena = Arena::miglino1995();
        assert!(clearance(&arena, roomiest(&arena, arena.field)) > 60.0);
        assert_eq!(clearance(&arena, (300.0, 175.0)), -27.5);
        assert_eq!(clearance(&arena, (30.0, 40.0)), 30.0);
    }

    #[test]
    fn a_path_joins_all_its_points_and_marks_collisions() {
        let trace = trace(&[
            (100.0, 100.0, 0.0),
            (200.0, 100.0, 1.0),
            (200.0, 200.0, 0.0),
            (100.0, 200.0, 1.0),
        ]);
        let text = life(&Arena::rectangle(600.0, 300.0), 27.5, "a < b", &trace, 1);
        assert_eq!(text.matches("l6 6m0 -6l-6 6").count(), 2 + 1, "and what it means");
        assert!(text.contains("a &lt; b"));
        assert!(text.contains(">0.3 s<"));
    }

    #[test]
    fn short_traces_draw_what_there_is() {
        let arena = Arena::rectangle(600.0, 300.0);
        assert_eq!(life(&arena, 27.5, "", &[], 1).matches("<g transform").count(), 0);
        let one = life(&arena, 27.5, "", &trace(&[(100.0, 100.0, 0.0)]), 1);
        assert_eq!(one.matches("<polyline").count(), 0);
        assert_eq!(one.matches("<g transform").count(), 2);
    }
}
