//! What the world tells custom parts: `lib/given.wgsl` reads it.

use crate::exact::zero;
use crate::world::arena::{self, Block, Light, Obstacle, Patch, Wall};
use crate::world::spec::WorldSpec;

/// Cells before those of the lists' elements: the body, the floor and the episode, the field, and a cell for each list.
const HEAD: usize = 2 + 5;
/// Where the last cell says which cell of the tables has the first greys of a picture.
pub(super) const GREYS: usize = 2;

/// Cells for custom parts: the body's radius, the floor's grey, where the head of the picture on it is, and the episode's cycles, which
/// are exact as a float; the corners of the rectangle around the floor; for each list the number of its elements, its first cell and the cells of an element; and the elements, of which an empty list has one
/// of zeros. The head comes last; [`GREYS`] is not in it yet.
pub(super) fn cells(spec: &WorldSpec) -> impl Iterator<Item = [u32; 4]> {
    let arena = &spec.arena;
    let field = arena.within_walls();
    let lists: [(usize, Vec<[f32; 4]>); 5] = [
        (2, arena.lights.iter().flat_map(light).collect()),
        (2, arena.patches.iter().flat_map(patch).collect()),
        (1, arena.walls.iter().map(wall).collect()),
        (1, arena.obstacles.iter().map(obstacle).collect()),
        (2, arena.blocks.iter().flat_map(block).collect()),
    ];
    let mut cells = vec![
        [
            spec.robot.body_radius,
            arena.floor.unwrap_or(1.0),
            0.0,
            (spec.cycles - spec.cycles_after) as f32,
        ],
        [field.x, field.y, field.x + field.width, field.y + field.height],
    ];
    let mut first = HEAD;
    for (size, elements) in &lists {
        cells.push([(elements.len() / size) as f32, first as f32, *size as f32, 0.0]);
        first += elements.len().max(*size);
    }
    for (size, mut elements) in lists {
        elements.resize(elements.len().max(size), [0.0; 4]);
        cells.extend(elements);
    }
    if arena.picture.is_some() {
        cells[0][2] = cells.len() as f32;
    }
    let head = arena.picture.as_ref().map(|picture| picture.head(0, 1.0));
    let head = head.into_iter().flatten();
    cells
        .into_iter()
        .map(|cell| cell.map(|number| zero(number).to_bits()))
        .chain(head)
}

fn light(light: &Light) -> [[f32; 4]; 2] {
    let (height, intensity) = (light.height.unwrap_or(0.0), light.intensity.unwrap_or(1.0));
    [[light.x, light.y, height, light.brightness], [intensity, 0.0, 0.0, 0.0]]
}

fn patch(patch: &Patch) -> [[f32; 4]; 2] {
    let shape = patch.shape();
    [
        [shape.x, shape.y, shape.unit_x, shape.unit_y],
        [
            shape.half_length,
            shape.half_width,
            patch.radius.unwrap_or(0.0),
            patch.grey,
        ],
    ]
}

fn wall(wall: &Wall) -> [f32; 4] {
    let ([x, y], [to_x, to_y]) = (wall.from, wall.to);
    [x, y, to_x, to_y]
}

fn obstacle(obstacle: &Obstacle) -> [f32; 4] {
    [obstacle.x, obstacle.y, obstacle.radius, 0.0]
}

fn block(block: &Block) -> [[f32; 4]; 2] {
    let along = arena::axis(block.heading);
    [
        [block.x, block.y, along.x, along.y],
        [0.5 * block.length, 0.5 * block.width, 0.0, 0.0],
    ]
}
