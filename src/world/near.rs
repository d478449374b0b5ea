//! Which objects and which patches of the floor are near a place; where there are many by a grid, which `lib/squares.wgsl` reads.

use glam::Vec2;
use oneiro_shaders::episode::{self, BLOCK};

use crate::exact::zero;
use crate::parameter::Invalid;
use crate::parts::compose::Grids;
use crate::world::arena::{GREATEST_SEEN, Patch};
use crate::world::described::GRID_HEAD;
use crate::world::physics::Physics;
use crate::world::spec::WorldSpec;

/// Most objects or patches of a square's list, as `lib/squares.wgsl` has it.
const GREATEST_NEAR: usize = 512;
/// Most patches that a robot looks at without a grid.
const GREATEST_PATCHES_SEEN: usize = 64;
/// The bit of a patch that charges, as `lib/patches.wgsl` has it.
const CHARGES: u32 = 1 << 31;
/// Up to so many objects, looking at all costs less than the grid.
const FEW: usize = 12;
/// How much more an object of a list costs than one of all, measured.
const COST_OF_LISTED: usize = 8;
/// Most squares along a side.
const GREATEST_SIDE: f32 = 192.0;
/// Added to every distance, mm: more than any rounding.
const MARGIN: f32 = 1.0;

/// Decides whether a robot's kernel looks at what is near by a grid, or at all objects, and the same for patches. As a vector, a loop over
/// all has the same object in each lane, and lists have different ones, which costs several times as much. Variants of a world look as the `first` one does. `shapes` are the
/// world's objects as the kernel has them.
pub(super) fn decide(
    physics: &mut Physics,
    spec: &WorldSpec,
    first: Option<&Physics>,
    shapes: impl Fn(&Physics) -> Vec<episode::Shape>,
) {
    let (objects, patches) = (spec.arena.objects(), &spec.arena.patches);
    let pays = |grid: Grid, all: usize| COST_OF_LISTED * grid.longest() < all;
    let grids = match first.and_then(Physics::described) {
        Some(first) => first.grids,
        None => Grids {
            objects: may_look_by_grid(physics)
                && objects > FEW
                && (objects > GREATEST_SEEN || pays(grid(spec, physics, &shapes(physics)), objects)),
            patches: patches.len() > FEW
                && (patches.len() > GREATEST_PATCHES_SEEN || pays(Grid::over(patches), patches.len())),
        },
    };
    if let Physics::Described(robot, _) = physics {
        robot.grids = grids;
    }
}

/// The grid of a world's objects.
pub(super) fn grid(spec: &WorldSpec, physics: &Physics, shapes: &[episode::Shape]) -> Grid {
    let body = spec.robot.body_radius;
    let larger = physics.pucks().map_or(0.0, |pucks| (pucks.radius - body).max(0.0));
    Grid::new(shapes, body, larger)
}

/// Whether a robot's kernel can be made to look at what is near: it sums up no samples, and counts no objects.
pub(super) fn may_look_by_grid(physics: &Physics) -> bool {
    match physics {
        Physics::Described(robot, surrogate) => {
            surrogate.is_none() && robot.model().is_none() && !robot.has_sampled_sensors()
        }
        Physics::Sampled | Physics::Individual(_) | Physics::Forager(_) => false,
    }
}

/// Squared distance from a robot's centre to the nearest point of a wall or a block, or to a round obstacle's centre,
/// mm², as the kernels compute it.
pub(super) fn squared_distance(shape: &episode::Shape, at: Vec2) -> f32 {
    let from = at - Vec2::new(shape.x, shape.y);
    if shape.kind == BLOCK {
        let along = from.x * shape.unit_x + from.y * shape.unit_y;
        let across = from.y * shape.unit_x - from.x * shape.unit_y;
        let beyond = Vec2::new(
            along - along.clamp(-shape.half_length, shape.half_length),
            across - across.clamp(-shape.half_width, shape.half_width),
        );
        let to = Vec2::new(
            beyond.y * shape.unit_y - beyond.x * shape.unit_x,
            -(beyond.x * shape.unit_y) - beyond.y * shape.unit_x,
        );
        return to.x * to.x + to.y * to.y;
    }
    let along = (from.x * shape.scaled_x + from.y * shape.scaled_y).clamp(0.0, 1.0);
    let to = along * Vec2::new(shape.length_x, shape.length_y) - from;
    to.x * to.x + to.y * to.y
}

/// Whether a body at a place touches an object.
pub(super) fn touches(shapes: &[episode::Shape], at: Vec2) -> bool {
    shapes
        .iter()
        .any(|shape| squared_distance(shape, at) < shape.contact_squared)
}

/// Squares over an arena's objects or patches. Each lists those that a body in it touches or may be pushed against, and those that a
/// sensor notices, in their order.
pub(super) struct Grid {
    low: Vec2,
    side: f32,
    columns: usize,
    rows: usize,
    lists: Vec<Vec<u32>>,
}

impl Grid {
    /// The grid for bodies of this radius, and for pucks that are larger by `larger`, mm.
    fn new(shapes: &[episode::Shape], body_radius: f32, larger: f32) -> Self {
        // A body may be pushed and slide.
        let far = |shape: &episode::Shape| {
            let pushed = shape.contact + 2.0 * body_radius + 3.0 * larger;
            shape.reach_squared.sqrt().max(pushed) + MARGIN
        };
        let greatest = shapes.iter().map(far).fold(0.0, f32::max);
        Self::of(shapes, far, |_| 0.25 * greatest)
    }

    /// The grid of the patches at a place.
    pub(super) fn over(patches: &[Patch]) -> Self {
        let shape = |patch: &Patch| episode::Shape {
            radius: patch.radius.unwrap_or(0.0),
            ..patch.shape()
        };
        let shapes: Vec<_> = patches.iter().map(shape).collect();
        // About four squares for each.
        let side = |extent: Vec2| 0.5 * (extent.x * extent.y / patches.len() as f32).sqrt();
        Self::of(&shapes, |shape| shape.radius + MARGIN, side)
    }

    /// The grid of shapes that matter so `far` from their lines, with squares of the `least` side or more, given the extent of all.
    fn of(shapes: &[episode::Shape], far: impl Fn(&episode::Shape) -> f32, least: impl Fn(Vec2) -> f32) -> Self {
        let around = |shape: &episode::Shape| {
            let start = Vec2::new(shape.x, shape.y);
            let end = start + Vec2::new(shape.length_x, shape.length_y);
            // Corners are so far from the middle.
            let room = Vec2::splat(far(shape) + shape.half_length.hypot(shape.half_width));
            (start.min(end) - room, start.max(end) + room)
        };
        let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        for shape in shapes {
            let (from, to) = around(shape);
            (low, high) = (low.min(from), high.max(to));
        }
        let extent = high - low;
        let side = least(extent).max(extent.max_element() / GREATEST_SIDE);
        let [columns, rows] = [extent.x, extent.y].map(|extent| (extent / side).ceil().max(1.0) as usize);
        let mut lists: Vec<Vec<u32>> = vec![Vec::new(); columns * rows];
        // From the middle of a square to its corners.
        let half = side * std::f32::consts::FRAC_1_SQRT_2;
        for (index, shape) in (0..).zip(shapes) {
            let (from, to) = around(shape);
            let (from, to) = ((from - low) / side, (to - low) / side);
            let most = far(shape) + half;
            for row in (from.y as usize)..=(to.y as usize).min(rows - 1) {
                for column in (from.x as usize)..=(to.x as usize).min(columns - 1) {
                    let middle = low + side * Vec2::new(column as f32 + 0.5, row as f32 + 0.5);
                    if squared_distance(shape, middle) <= most * most {
                        lists[row * columns + column].push(index);
                    }
                }
            }
        }
        Self {
            low,
            side,
            columns,
            rows,
            lists,
        }
    }

    /// Length of the longest list.
    fn longest(&self) -> usize {
        self.lists.iter().map(Vec::len).max().unwrap_or(0)
    }

    /// Whether a body at a place touches one of these objects.
    pub(super) fn touches(&self, shapes: &[episode::Shape], at: Vec2) -> bool {
        let place = (at - self.low) / self.side;
        if place.min_element() < 0.0 || place.x >= self.columns as f32 || place.y >= self.rows as f32 {
            return false;
        }
        let list = &self.lists[place.y as usize * self.columns + place.x as usize];
        list.iter().any(|index| {
            let shape = &shapes[*index as usize];
            squared_distance(shape, at) < shape.contact_squared
        })
    }

    /// The kernel's cells of objects.
    ///
    /// # Errors
    /// More objects near a place than a list has room for.
    pub(super) fn of_objects(&self) -> Result<Vec<[u32; 4]>, Invalid> {
        let longest = self.longest();
        if longest > GREATEST_NEAR {
            let problem = format!(
                "has {longest} walls, obstacles and blocks near one place; allowed: {GREATEST_NEAR} that a robot's sensors reach at once"
            );
            return Err(Invalid::new("arena", problem));
        }
        Ok(self.cells(|index| index))
    }

    /// The kernel's cells of patches.
    ///
    /// # Errors
    /// More patches at a place than a list has room for.
    pub(super) fn of_patches(&self, patches: &[Patch]) -> Result<Vec<[u32; 4]>, Invalid> {
        let longest = self.longest();
        if longest > GREATEST_NEAR {
            let problem = format!("has {longest} patches near one place; allowed: {GREATEST_NEAR}");
            return Err(Invalid::new("arena.patches", problem));
        }
        let charges = |index: u32| patches[index as usize].charges == Some(true);
        Ok(self.cells(|index| if charges(index) { index | CHARGES } else { index }))
    }

    /// The kernel's cells of the grid, with an entry for each index in a list.
    fn cells(&self, entry: impl Fn(u32) -> u32) -> Vec<[u32; 4]> {
        let heads = self.lists.len().div_ceil(2);
        let first_list = (GRID_HEAD + heads) as f32;
        let mut cells = vec![
            [self.low.x, self.low.y, 1.0 / self.side, first_list].map(|number| zero(number).to_bits()),
            [
                self.columns as u32,
                self.rows as u32,
                self.longest() as u32,
                GRID_HEAD as u32,
            ],
        ];
        let mut first = 0;
        let mut words = Vec::with_capacity(4 * heads);
        for list in &self.lists {
            words.extend([first, list.len() as u32]);
            first += list.len() as u32;
        }
        words.resize(4 * heads, 0);
        words.extend(self.lists.iter().flatten().map(|index| entry(*index)));
        words.resize(words.len().next_multiple_of(4), 0);
        cells.extend(words.as_chunks().0);
        cells
    }
}

/// Changes a grid's head where as many other cells follow it before its squares.
pub(super) fn set_apart(head: &mut [[u32; 4]], apart: usize) {
    head[0][3] = (f32::from_bits(head[0][3]) + apart as f32).to_bits();
    head[1][3] += apart as u32;
}
