//! Where robots can get in an arena, and the objects out of their reach.

use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};

use glam::Vec2;
use oneiro_shaders::episode;

use crate::world::arena::{Field, GREATEST_SEEN};
use crate::world::check::farthest;
use crate::world::near::{grid, squared_distance, touches};
use crate::world::pack::{objects, shapes};
use crate::world::physics::Physics;
use crate::world::sensors::Feature;
use crate::world::spec::WorldSpec;
use crate::world::start::{Area, Start};

/// Points along the longest side of the grid: a hundredth of a second for a few dozen objects.
const MOST: f32 = 400.0;

/// Points that robots get to, on a grid around the arena's field and its walls, of half the body's radius where that is possible.
struct Reached {
    points: Vec<Vec2>,
    /// Whether a way leads from there to twice a robot's diameter beyond that.
    is_open: bool,
    step: f32,
}

impl Reached {
    /// Follows all ways from where robots may start, given an area or the poses. `None` if the arena is too large for such a grid.
    fn from(spec: &WorldSpec, physics: &Physics, area: Option<Area>) -> Option<Self> {
        let radius = spec.robot.body_radius;
        let margin = 4.0 * radius;
        let field = spec.arena.field;
        // With all walls, unless one is too far away.
        let (around, step) = [spec.arena.within_walls(), field].into_iter().find_map(|around| {
            let longest = around.width.max(around.height) + 2.0 * margin;
            let step = (longest / MOST).max(0.5 * radius);
            // Longer ones would lead across walls.
            (step <= 1.5 * radius).then_some((around, step))
        })?;
        let low = Vec2::new(around.x - margin, around.y - margin);
        let [columns, rows] =
            [around.width, around.height].map(|side| ((side + 2.0 * margin) / step).ceil() as usize + 1);
        let place = |point: usize| low + step * Vec2::new((point % columns) as f32, (point / columns) as f32);
        let shapes = shapes(spec, physics);
        let places = places(spec);
        let may_start = |at: Vec2| match area {
            Some(area) => area.contains(at),
            None => places.iter().any(|place| at.distance(*place) < step),
        };
        let grid = (shapes.len() > GREATEST_SEEN).then(|| grid(spec, physics, &shapes));
        let touches = |at: Vec2| match &grid {
            Some(grid) => grid.touches(&shapes, at),
            None => touches(&shapes, at),
        };
        let mut is_free: Vec<bool> = (0..columns * rows).map(|point| !touches(place(point))).collect();
        let mut next: Vec<usize> = (0..columns * rows)
            .filter(|&point| is_free[point] && may_start(place(point)))
            .collect();
        for &point in &next {
            is_free[point] = false;
        }
        let (mut points, mut is_open) = (Vec::new(), false);
        while let Some(point) = next.pop() {
            points.push(place(point));
            let (column, row) = (point % columns, point / columns);
            if column == 0 || row == 0 || column == columns - 1 || row == rows - 1 {
                is_open = true;
                continue;
            }
            for other in [point - 1, point + 1, point - columns, point + columns] {
                if std::mem::take(&mut is_free[other]) {
                    next.push(other);
                }
            }
        }
        Some(Self { points, is_open, step })
    }

    /// Whether one of the points is within a distance of a shape.
    fn is_within(&self, shape: &episode::Shape, distance: f32) -> bool {
        let most = distance + self.step;
        self.points.iter().any(|at| squared_distance(shape, *at) <= most * most)
    }
}

/// Where a world's starts are drawn from; `None` if it says where they are.
fn area(spec: &WorldSpec) -> Option<Area> {
    spec.start
        .is_drawn()
        .then(|| Area::of(&spec.start, &spec.arena).ok())
        .flatten()
}

/// Where its starts are.
fn places(spec: &WorldSpec) -> Vec<Vec2> {
    match &spec.start {
        Start::At { x, y, .. } => vec![Vec2::new(*x, *y)],
        Start::Poses(poses) => poses.0.iter().map(|[x, y, _]| Vec2::new(*x, *y)).collect(),
        Start::Random | Start::Zone(_) => Vec::new(),
    }
}

/// Whether walls and objects keep a robot in the arena. `None` if it is too large for the grid.
pub(super) fn is_enclosed(spec: &WorldSpec, physics: &Physics) -> Option<bool> {
    Reached::from(spec, physics, area(spec)).map(|reached| !reached.is_open)
}

/// Keys of what no robot gets near enough to notice, and of starts outside of the arena.
pub(super) fn unreached(spec: &WorldSpec, physics: &Physics) -> Vec<String> {
    const REMEMBERED: usize = 16;
    type Known = VecDeque<(Vec<u32>, Vec<String>)>;
    static KNOWN: Mutex<Known> = Mutex::new(Known::new());
    if matches!(physics, Physics::Forager(_)) {
        return Vec::new();
    }
    let things = things(spec, physics);
    // The same for all worlds of an arena: a sweep has thousands of them.
    let Field { x, y, width, height } = spec.arena.field;
    let zone = area(spec).map_or([f32::NAN; 4], |area| area.numbers());
    let starts: Vec<f32> = places(spec).into_iter().flat_map(|place| place.to_array()).collect();
    let of_robot = [spec.robot.body_radius, travel(spec, physics)];
    let numbers = [
        &[x, y, width, height][..],
        &zone,
        &starts,
        &of_robot,
        physics.start_places().as_flattened(),
    ]
    .concat();
    let mut key: Vec<u32> = numbers.into_iter().map(f32::to_bits).collect();
    key.push(spec.arena.is_field_round.into());
    for (_, shape, distance) in &things {
        key.push(distance.to_bits());
        key.extend_from_slice(bytemuck::cast_slice(std::slice::from_ref(shape)));
    }
    let known = || KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, keys)) = known().iter().find(|(other, _)| *other == key) {
        return keys.clone();
    }
    let found = find(spec, physics, &things);
    let mut known = known();
    known.push_front((key, found.clone()));
    known.truncate(REMEMBERED);
    found
}

/// A thing's key, its shape, and the distance of a robot's centre from it at which the robot notices it.
type Thing = (String, episode::Shape, f32);

fn things(spec: &WorldSpec, physics: &Physics) -> Vec<Thing> {
    let arena = &spec.arena;
    let lists = [
        ("walls", arena.walls.len()),
        ("obstacles", arena.obstacles.len()),
        ("blocks", arena.blocks.len()),
    ];
    let keys = lists
        .into_iter()
        .flat_map(|(list, count)| (0..count).map(move |index| format!("arena.{list}[{index}]")));
    let mut things: Vec<Thing> = keys
        .zip(objects(spec, physics))
        .map(|(key, shape)| (key, shape, shape.reach_squared.sqrt()))
        .collect();
    let sensors = physics.described().map_or(&[][..], |robot| &robot.sensors).iter();
    let ground = sensors.filter(|sensor| sensor.kind.entry().has(Feature::ReadsFloor));
    let offset = ground.map(|sensor| sensor.offset.unwrap_or(spec.robot.body_radius));
    let offset = offset.fold(0.0, f32::max);
    things.extend(arena.patches.iter().enumerate().map(|(index, patch_of_floor)| {
        let distance = patch_of_floor.radius.unwrap_or(0.0) + offset;
        (format!("arena.patches[{index}]"), patch_of_floor.shape(), distance)
    }));
    if let Some(picture) = &arena.picture {
        let ([x, y], [width, height]) = (picture.low(), picture.sides());
        let shape = episode::Shape {
            x: x + 0.5 * width,
            y: y + 0.5 * height,
            unit_x: 1.0,
            half_length: 0.5 * width,
            half_width: 0.5 * height,
            kind: episode::BLOCK,
            ..episode::Shape::default()
        };
        things.push(("arena.picture".to_owned(), shape, offset));
    }
    things
}

/// The longest way of a robot in an episode, mm.
fn travel(spec: &WorldSpec, physics: &Physics) -> f32 {
    spec.cycles as f32 * farthest(spec, physics)
}

fn find(spec: &WorldSpec, physics: &Physics, things: &[Thing]) -> Vec<String> {
    let Some(reached) = Reached::from(spec, physics, area(spec)) else {
        return Vec::new();
    };
    let mut keys = Vec::new();
    let beyond = if reached.is_open { travel(spec, physics) } else { 0.0 };
    let unnoticed = things
        .iter()
        .filter(|(_, shape, distance)| !reached.is_within(shape, distance + beyond));
    keys.extend(unnoticed.map(|(key, ..)| key.clone()));
    // Random starts fill the field. If robots can't leave it, a place that they can't reach is outside.
    let Some(inside) = Reached::from(spec, physics, Some(Area::of_field(&spec.arena))).filter(|inside| !inside.is_open)
    else {
        return keys;
    };
    let is_outside = |[x, y]: [f32; 2]| {
        let point = episode::Shape {
            x,
            y,
            ..episode::Shape::default()
        };
        !inside.is_within(&point, 0.0)
    };
    if places(spec).iter().any(|place| is_outside(place.to_array())) {
        keys.push("start".to_owned());
    }
    if physics.start_places().iter().any(|place| is_outside(*place)) {
        keys.push("robot.starts_mm".to_owned());
    }
    keys
}
