//! Packs a world for the kernels.

use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};

use glam::Vec2;
use oneiro_shaders::episode::{self, BLOCK, CELL, ROUND, WALL};

use crate::batch::Buffers;
use crate::cells::Cells;
use crate::exact::zero;
use crate::parameter::Invalid;
use crate::parts::compose::OwnParts;
use crate::world::arena::Field;
use crate::world::body::Collision;
use crate::world::described::{Drive, GRID_HEAD};
use crate::world::forager::Forager;
use crate::world::given;
use crate::world::near::{self, Grid, grid, squared_distance, touches};
use crate::world::physics::Physics;
use crate::world::spec::{Activation, Controller, Difference, Speed, Task, WorldSpec};
use crate::world::start::{Area, Start};
use crate::world::surrogate::{self, Object};
use crate::world::tables::{MotorTable, SENSORS, SensorTable};

/// Points per side of the grid that is searched for free space.
const GRID: usize = 64;

/// A world before it has positions in a batch's buffers: they are 0, and an object's table is the index of its class.
#[derive(Clone, Debug)]
pub(super) struct Packed {
    pub(super) world: episode::World,
    pub(super) shapes: Vec<episode::Shape>,
    pub(super) free_share: f32,
    /// Values of parts.
    values: Vec<[u32; 4]>,
    /// Genes of a controller.
    genes: usize,
    /// The grid of an arena of many objects.
    near: Vec<[u32; 4]>,
    /// The kernel's cells of the grid of patches.
    patches: Vec<[u32; 4]>,
}

impl Packed {
    /// Packs a specification whose numbers have been checked. `parts` are a user's, and a network; a controller has `genes` genes.
    pub(super) fn new(spec: &WorldSpec, physics: &Physics, parts: &OwnParts, genes: usize) -> Result<Self, Invalid> {
        if let Physics::Forager(robot) = physics {
            return Ok(Self {
                world: forager(spec, physics, robot)?,
                shapes: Vec::new(),
                free_share: robot.free_share(),
                values: values(spec, parts),
                genes,
                near: Vec::new(),
                patches: Vec::new(),
            });
        }
        let shapes = shapes(spec, physics);
        let near = match physics.described() {
            Some(robot) if robot.grids.objects => grid(spec, physics, &shapes).of_objects()?,
            _ => Vec::new(),
        };
        let patches = match physics.described() {
            Some(robot) if robot.grids.patches => Grid::over(&spec.arena.patches).of_patches(&spec.arena.patches)?,
            _ => Vec::new(),
        };
        let area = Area::of(&spec.start, &spec.arena)?;
        let free = Free::of(area, &shapes);
        let (random_start, start) = match spec.start {
            Start::Random => (1, random_start(&free, "arena", "its start field")?),
            Start::Zone(_) => (1, random_start(&free, "start", "that zone")?),
            Start::Poses(_) => (0, [0.0; 3]),
            Start::At { x, y, heading } => {
                if touches(&shapes, Vec2::new(x, y)) {
                    let problem = format!("({x}, {y}) mm touches an object; allowed: where the whole body is free");
                    return Err(Invalid::new("start", problem));
                }
                (0, [x, y, heading])
            }
        };
        if let Some([x, y]) = physics
            .start_places()
            .iter()
            .find(|[x, y]| touches(&shapes, Vec2::new(*x, *y)))
        {
            let problem = format!("has ({x}, {y}) mm, which touches an object; allowed: where the whole body is free");
            return Err(Invalid::new("robot.starts_mm", problem));
        }
        if let Some(pucks) = physics.pucks() {
            let wider = wider(&shapes, pucks.radius - spec.robot.body_radius);
            let taken = pucks.places().iter().find(|[x, y]| touches(&wider, Vec2::new(*x, *y)));
            if let Some([x, y]) = taken {
                let problem =
                    format!("has ({x}, {y}) mm, which touches an object; allowed: where the whole puck is free");
                return Err(Invalid::new("pucks.places_mm", problem));
            }
        }
        Ok(Self {
            world: world(spec, physics, random_start, start.map(zero), shapes.len() as u32)?,
            shapes,
            free_share: free.share_of_bounds,
            values: values(spec, parts),
            genes,
            near,
            patches,
        })
    }

    /// The world with the positions of its objects and tables in a batch's buffers.
    pub(super) fn in_buffers(&self, spec: &WorldSpec, physics: &Physics, buffers: &mut Buffers) -> episode::World {
        let robot = &spec.robot;
        let mut shapes = self.shapes.clone();
        if robot.tables().is_some() {
            for shape in &mut shapes {
                let class = shape.table as usize;
                shape.table =
                    buffers.add_shared_table(&robot.sensors, class, || sensor_cells(&robot.sensors.classes[class]));
            }
        }
        let first_shape = buffers.add_shapes(shapes);
        let motor_table = buffers.add_shared_table(&robot.motors, 0, || motor_cells(&robot.motors));
        let radius = robot.body_radius;
        let picture = spec.arena.picture.as_ref();
        let greys = picture.map_or(0, |picture| {
            buffers.add_shared_table(picture.owner(), 0, || picture.cells())
        });
        let numbers = match physics {
            Physics::Described(described, surrogate) => {
                let mut cells = described.cells(&robot.body(), &spec.arena, surrogate.as_deref(), self.genes, greys);
                if let Some((head, rest)) = self.patches.split_at_checked(GRID_HEAD) {
                    let at = described.patches_cell(&spec.arena);
                    cells.splice(at..at, head.iter().copied());
                    cells.extend(&self.near);
                    let apart = cells.len() - at - GRID_HEAD;
                    near::set_apart(&mut cells[at..], apart);
                    cells.extend(rest);
                } else {
                    cells.extend(&self.near);
                }
                buffers.add_table(cells)
            }
            Physics::Individual(surrogate) => {
                buffers.add_shared_table(surrogate, radius.to_bits() as usize, || surrogate.cells(radius))
            }
            Physics::Forager(forager) => buffers.add_table(forager.table()),
            Physics::Sampled if spec.noise.is_varied() => buffers.add_table(vec![spec.noise.cell()]),
            Physics::Sampled => 0,
        };
        let own_values = if self.values.is_empty() {
            0
        } else {
            let mut values = self.values.clone();
            if let Some(head) = values.last_mut().filter(|_| picture.is_some()) {
                head[given::GREYS] = greys;
            }
            buffers.add_table(values)
        };
        episode::World {
            first_shape,
            motor_table,
            numbers,
            own_values,
            ..self.world
        }
    }
}

/// The values of a user's parts, and after them what `lib/given.wgsl` reads; nothing without such parts.
fn values(spec: &WorldSpec, parts: &OwnParts) -> Vec<[u32; 4]> {
    if parts.is_empty() {
        return Vec::new();
    }
    parts.cells().into_iter().chain(given::cells(spec)).collect()
}

/// Packs eight readings of a cell into four words, the even sensors in the low halves. Of tables of more sensors the cells with the
/// first eight of a point of view come before those with the next; places beyond the last sensor are 0.
fn sensor_cells(table: &SensorTable) -> Vec<[u32; 4]> {
    let (sensors, view) = (table.sensors as usize, table.cells() / table.views as usize);
    let mut cells = Vec::new();
    for first in (0..table.cells()).step_by(view) {
        for plane in (0..sensors).step_by(SENSORS) {
            cells.extend((first..first + view).map(|cell| {
                let readings = &table.cell(cell)[plane..];
                let reading = |sensor: usize| readings.get(sensor).map_or(0, |&reading| u32::from(reading));
                std::array::from_fn(|pair| reading(2 * pair) | reading(2 * pair + 1) << 16)
            }));
        }
    }
    cells
}

fn motor_cells(table: &MotorTable) -> Vec<[u32; 4]> {
    let mut cells = Cells::new(0);
    for cell in &table.cells {
        cells.push(episode::MotorCell {
            displacement: zero(cell.displacement),
            turn: zero(cell.turn),
            left: zero(cell.left),
            right: zero(cell.right),
        });
    }
    cells.into_table()
}

/// Start of an episode whose every random draw touches something.
fn random_start(free: &Free, key: &str, area: &str) -> Result<[f32; 3], Invalid> {
    match free.roomiest {
        // An episode draws 64 times: with a quarter free, one in 1e8 finds nothing.
        Some(at) if free.share >= 0.25 => Ok([at.x, at.y, 0.0]),
        _ => Err(Invalid::new(
            key,
            format!(
                "a robot's body is free in {:.0} % of {area}; allowed for random starts: at least 25 %",
                100.0 * free.share
            ),
        )),
    }
}

fn world(
    spec: &WorldSpec,
    physics: &Physics,
    random_start: u32,
    start: [f32; 3],
    shapes: u32,
) -> Result<episode::World, Invalid> {
    let Field { x, y, width, height } = spec.arena.field;
    let area = Area::of(&spec.start, &spec.arena)?;
    let [zone_x, zone_y, zone_width, zone_height] = area.numbers().map(zero);
    let (low, high) = spec.noise.sensor;
    let (task_choices, new_cell) = task(spec.task);
    let motors = &spec.robot.motors;
    // Without classes there are no objects, and the tables aren't used.
    let (nearest, spacing, rows, bearings) = match spec.robot.sensors.classes.first() {
        Some(table) => (table.nearest, table.spacing, table.rows, table.bearings),
        None => (0.0, 1.0, 1, 1),
    };
    Ok(episode::World {
        steps: spec.cycles,
        first_shape: 0,
        shapes,
        field_x: zero(x),
        field_y: zero(y),
        field_width: width,
        field_height: height,
        zone_is_round: u32::from(matches!(area, Area::Ring { .. })),
        zone_x,
        zone_y,
        zone_width,
        zone_height,
        random_start,
        start_x: start[0],
        start_y: start[1],
        start_heading: start[2],
        nearest: zero(nearest),
        rows_per_mm: 1.0 / spacing,
        rows,
        bearings,
        bearings_per_turn: bearings as f32,
        reading_scale: spec.robot.sensors.reading_scale,
        sensor_noise_low: zero(low),
        sensor_noise_span: high - low,
        walk_range: zero(spec.noise.walk_range),
        walk_step: zero(spec.noise.walk_step),
        motor_table: 0,
        motor_states: motors.states,
        motor_scale: zero(motors.scale),
        motor_offset: zero(motors.offset),
        motor_noise: zero(spec.noise.motor),
        turn_before_move: zero(match physics {
            Physics::Sampled | Physics::Individual(_) => spec.robot.turn_before_move,
            Physics::Described(robot, surrogate) => {
                let turn_before_move = match robot.drive {
                    Drive::Motors { turn_before_move } => turn_before_move,
                    Drive::Wheels(_) => 0.0,
                };
                surrogate.as_ref().map_or(turn_before_move, |surrogate| {
                    surrogate.turn_before_move(turn_before_move)
                })
            }
            Physics::Forager(_) => 0.0,
        }),
        hidden: match spec.controller {
            Controller::Hidden { units } => units,
            _ => 0,
        },
        task_choices,
        new_cell: zero(new_cell),
        cell_columns: cells(width) as u32,
        numbers: 0,
        collision: match spec.robot.collision {
            Collision::Undo => episode::UNDO,
            Collision::KeepTurn => episode::KEEP_TURN,
            Collision::Slide => episode::SLIDE,
            Collision::Stick => episode::STICK,
        },
        own_values: 0,
    })
}

/// A forager's world: values for its physics, and for shipped controllers and tasks.
fn forager(spec: &WorldSpec, physics: &Physics, forager: &Forager) -> Result<episode::World, Invalid> {
    let shipped = world(spec, physics, 0, [0.0; 3], 0)?;
    Ok(episode::World {
        hidden: shipped.hidden,
        task_choices: shipped.task_choices,
        new_cell: shipped.new_cell,
        cell_columns: shipped.cell_columns,
        ..forager.foraging.world()
    })
}

/// Fraction of the rectangle around an area where a body is free that is larger than a robot by `larger`, mm, and in the area.
pub(super) fn free_share(spec: &WorldSpec, physics: &Physics, area: Area, larger: f32) -> f32 {
    Free::of(area, &wider(&shapes(spec, physics), larger)).share_of_bounds
}

/// Objects as a body finds them that is larger than a robot, mm.
fn wider(shapes: &[episode::Shape], larger: f32) -> Vec<episode::Shape> {
    let wider = |shape: &episode::Shape| {
        let contact = shape.contact + larger;
        episode::Shape {
            contact,
            contact_squared: contact * contact,
            ..*shape
        }
    };
    shapes.iter().map(wider).collect()
}

/// Number of cells along a side of the field.
pub(super) fn cells(side: f32) -> usize {
    (side / CELL).ceil() as usize
}

/// The choices of a task, and the value of a new cell.
fn task(task: Task) -> (u32, f32) {
    let Task::Avoidance {
        speed,
        difference,
        activation,
        new_cell,
    } = task
    else {
        return (0, 0.0);
    };
    let speed = match speed {
        Speed::Unsigned => 0,
        Speed::Signed => episode::SIGNED_SPEED,
    };
    let difference = match difference {
        Difference::Root => 0,
        Difference::Square => episode::SQUARED_DIFFERENCE,
    };
    let activation = match activation {
        Activation::Real => 0,
        Activation::Perceived => episode::PERCEIVED_ACTIVATION,
        Activation::None => episode::NO_ACTIVATION_TERM,
    };
    (speed | difference | activation, new_cell)
}

/// Shapes of the walls, the obstacles and the blocks, in this order.
pub(super) fn objects(spec: &WorldSpec, physics: &Physics) -> Vec<episode::Shape> {
    let arena = &spec.arena;
    let walls = arena.walls.iter().enumerate().map(|(index, wall)| {
        let from = Vec2::from(wall.from);
        let length = Vec2::from(wall.to) - from;
        let squared = length.x * length.x + length.y * length.y;
        let (scaled, unit) = (length / squared, length / squared.sqrt());
        episode::Shape {
            length_x: zero(length.x),
            length_y: zero(length.y),
            scaled_x: zero(scaled.x),
            scaled_y: zero(scaled.y),
            unit_x: zero(unit.x),
            unit_y: zero(unit.y),
            kind: WALL,
            ..shape(spec, physics, from, 0.0, &wall.class, Object::Wall, index)
        }
    });
    let obstacles = arena.obstacles.iter().enumerate().map(|(index, obstacle)| {
        let at = Vec2::new(obstacle.x, obstacle.y);
        episode::Shape {
            kind: ROUND,
            ..shape(
                spec,
                physics,
                at,
                obstacle.radius,
                &obstacle.class,
                Object::Obstacle,
                index,
            )
        }
    });
    let blocks = arena.blocks.iter().enumerate().map(|(index, block)| {
        let axis = block.axis();
        episode::Shape {
            unit_x: axis.x,
            unit_y: axis.y,
            half_length: 0.5 * block.length,
            half_width: 0.5 * block.width,
            kind: BLOCK,
            ..shape(
                spec,
                physics,
                Vec2::new(block.x, block.y),
                0.0,
                &block.class,
                Object::Block,
                index,
            )
        }
    });
    walls.chain(obstacles).chain(blocks).collect()
}

/// The same in the order of the kernel.
pub(super) fn shapes(spec: &WorldSpec, physics: &Physics) -> Vec<episode::Shape> {
    let arena = &spec.arena;
    let mut objects = objects(spec, physics);
    // In swarms the sides of the polygon come last and are known by their place.
    let sides = if physics.together().is_some() {
        arena.polygon_sides().len()
    } else {
        0
    };
    let walls = arena.walls.len();
    let sides: Vec<_> = objects.drain(walls - sides..walls).collect();
    let by_rays = matches!(physics, Physics::Individual(_));
    let mut all = layered(objects, by_rays);
    all.extend(sides);
    all
}

/// Properties that all shapes have.
fn shape(
    spec: &WorldSpec,
    physics: &Physics,
    at: Vec2,
    radius: f32,
    class: &str,
    kind: Object,
    index: usize,
) -> episode::Shape {
    let sensors = &spec.robot.sensors;
    let class = sensors.class(class).unwrap_or_default();
    let views = spec.robot.tables().map_or(1, |tables| tables.classes[class].views);
    let contact = spec.robot.body_radius + radius;
    let reach = match physics {
        Physics::Individual(_) => contact + surrogate::SIGHT,
        Physics::Sampled => contact + sensors.classes[class].reach(),
        Physics::Described(robot, surrogate) => {
            radius + robot.reach(spec.robot.body_radius, sensors, surrogate.is_some())
        }
        Physics::Forager(_) => contact,
    };
    let reflectivity = match physics {
        Physics::Individual(surrogate) => surrogate.reflectivity(kind, index),
        // The fraction of its distance at which it seems to be.
        Physics::Described(_, Some(surrogate)) => surrogate.seeming(kind, index),
        Physics::Described(_, None) | Physics::Sampled | Physics::Forager(_) => 1.0,
    };
    episode::Shape {
        x: zero(at.x),
        y: zero(at.y),
        contact,
        contact_squared: contact * contact,
        reach_squared: reach * reach,
        table: class as u32,
        views,
        radius: zero(radius),
        reflectivity,
        ..episode::Shape::default()
    }
}

/// Sorts shapes into layers within which no two are in a robot's reach at once, so that a kernel looks up only one per
/// layer. Readings are summed as integers, so the order changes no bit. If rays meet them instead, a layer also ends where the
/// next shape is of another kind, so that all lanes do the same for a layer.
fn layered(shapes: Vec<episode::Shape>, by_rays: bool) -> Vec<episode::Shape> {
    let mut layers: Vec<Vec<episode::Shape>> = Vec::new();
    for shape in shapes {
        match layers
            .iter_mut()
            .find(|layer| layer.iter().all(|other| never_both_in_reach(&shape, other)))
        {
            Some(layer) => layer.push(shape),
            None => layers.push(vec![shape]),
        }
    }
    for layer in &mut layers {
        for index in 0..layer.len() {
            let next = layer.get(index + 1);
            let ends = next.is_none_or(|next| by_rays && next.kind != layer[index].kind);
            layer[index].ends_layer = u32::from(ends);
        }
    }
    layers.concat()
}

/// Whether the areas from which two shapes are in reach are at least a millimetre apart, more than any rounding.
fn never_both_in_reach(a: &episode::Shape, b: &episode::Shape) -> bool {
    let ([a0, a1], [b0, b1]) = (axis(a), axis(b));
    let side = |from: Vec2, to: Vec2, at: Vec2| (to - from).perp_dot(at - from);
    let crossing = side(a0, a1, b0) * side(a0, a1, b1) < 0.0 && side(b0, b1, a0) * side(b0, b1, a1) < 0.0;
    // Segments that don't cross are closest at an end of one of them.
    let apart = [(a0, a1, b0), (a0, a1, b1), (b0, b1, a0), (b0, b1, a1)]
        .into_iter()
        .fold(f32::MAX, |least, (from, to, end)| {
            least.min(from_segment(from, to, end))
        });
    // No point of a block is farther from its axis than half its width.
    let reach = |shape: &episode::Shape| shape.reach_squared.sqrt() + shape.half_width;
    !crossing && apart > reach(a) + reach(b) + 1.0
}

/// Ends of a shape's centre line.
fn axis(shape: &episode::Shape) -> [Vec2; 2] {
    let at = Vec2::new(shape.x, shape.y);
    let along = shape.half_length * Vec2::new(shape.unit_x, shape.unit_y);
    match shape.kind {
        BLOCK => [at - along, at + along],
        _ => [at, at + Vec2::new(shape.length_x, shape.length_y)],
    }
}

/// Distance of a point from a segment, which may have length 0.
fn from_segment(from: Vec2, to: Vec2, at: Vec2) -> f32 {
    let length = to - from;
    let along = (at - from).dot(length) / length.length_squared().max(f32::MIN_POSITIVE);
    at.distance(from + along.clamp(0.0, 1.0) * length)
}

/// Gap between a robot and the nearest object, mm.
fn room(shapes: &[episode::Shape], at: Vec2) -> f32 {
    shapes.iter().fold(f32::MAX, |least, shape| {
        least.min(squared_distance(shape, at).sqrt() - shape.contact)
    })
}

/// Free space found on a grid over an area that robots start in.
#[derive(Clone, Copy)]
struct Free {
    /// Share of its points where a robot is free, and of those of the rectangle around it.
    share: f32,
    share_of_bounds: f32,
    /// Free point farthest from all objects; the first one if several are equal.
    roomiest: Option<Vec2>,
}

impl Free {
    /// Searched only once for all worlds of an arena: a sweep has thousands of them.
    fn of(area: Area, shapes: &[episode::Shape]) -> Self {
        const REMEMBERED: usize = 16;
        static KNOWN: Mutex<VecDeque<(Vec<u32>, Free)>> = Mutex::new(VecDeque::new());
        let mut key = area.numbers().map(f32::to_bits).to_vec();
        key.push(matches!(area, Area::Ring { .. }).into());
        key.extend_from_slice(bytemuck::cast_slice(shapes));
        let known = || KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, free)) = known().iter().find(|(other, _)| *other == key) {
            return *free;
        }
        let free = Self::find(area, shapes);
        let mut known = known();
        known.push_front((key, free));
        known.truncate(REMEMBERED);
        free
    }

    fn find(area: Area, shapes: &[episode::Shape]) -> Self {
        let field = area.bounds();
        let along = |index: usize| (index as f32 + 0.5) / GRID as f32;
        let (mut free, mut points) = (0_usize, 0_usize);
        let mut roomiest = None;
        let mut most = f32::MIN;
        for point in 0..GRID * GRID {
            let share = Vec2::new(along(point % GRID), along(point / GRID));
            let at = Vec2::new(field.x, field.y) + share * Vec2::new(field.width, field.height);
            if matches!(area, Area::Ring { .. }) && !area.contains(at) {
                continue;
            }
            points += 1;
            if !touches(shapes, at) {
                free += 1;
                let room = room(shapes, at);
                if room > most {
                    (roomiest, most) = (Some(at), room);
                }
            }
        }
        Self {
            share: free as f32 / points.max(1) as f32,
            share_of_bounds: free as f32 / (GRID * GRID) as f32,
            roomiest,
        }
    }
}
