//! A grid over an arena of many objects, which says what may matter at a place: `lib/near.wgsl` reads it.

use glam::Vec2;
use oneiro_shaders::episode;

use crate::parameter::Invalid;
use crate::world::pack::squared_distance;

/// Objects up to which every kernel looks at all of them.
pub(super) const FEW: usize = episode::GREATEST_SHAPES as usize;
/// Most objects of an arena, and of a square's list, as `lib/near.wgsl` has them.
pub(super) const GREATEST: usize = 4096;
const GREATEST_NEAR: usize = 512;
/// Most squares along a side.
const GREATEST_SIDE: f32 = 192.0;
/// Added to every distance, mm: more than any rounding.
const MARGIN: f32 = 1.0;

/// The kernel's cells of the grid. Each square lists the objects that a body in it touches or may be pushed against, and those that
/// a sensor notices.
///
/// # Errors
/// More objects near a place than a list has room for.
pub(super) fn cells(shapes: &[episode::Shape], body_radius: f32) -> Result<Vec<[u32; 4]>, Invalid> {
    // What a body gets near to while it is pushed and slides.
    let far = |shape: &episode::Shape| {
        let reach = shape.reach_squared.sqrt().max(shape.contact + 2.0 * body_radius);
        let around = if shape.kind == episode::ROUND {
            0.0
        } else {
            shape.half_length.hypot(shape.half_width)
        };
        (reach + MARGIN, around)
    };
    let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
    let mut greatest = 0.0_f32;
    for shape in shapes {
        let (reach, around) = far(shape);
        greatest = greatest.max(reach);
        let start = Vec2::new(shape.x, shape.y);
        let end = start + Vec2::new(shape.length_x, shape.length_y);
        low = low.min(start.min(end) - reach - around);
        high = high.max(start.max(end) + reach + around);
    }
    let extent = high - low;
    let side = (0.25 * greatest).max(extent.max_element() / GREATEST_SIDE);
    let [columns, rows] = [extent.x, extent.y].map(|extent| (extent / side).ceil().max(1.0) as usize);
    let mut lists: Vec<Vec<u32>> = vec![Vec::new(); columns * rows];
    // From the middle of a square to its corners.
    let half = side * std::f32::consts::FRAC_1_SQRT_2;
    for (index, shape) in shapes.iter().enumerate() {
        let (reach, around) = far(shape);
        let start = Vec2::new(shape.x, shape.y);
        let end = start + Vec2::new(shape.length_x, shape.length_y);
        let from = (start.min(end) - reach - around - low) / side;
        let to = (start.max(end) + reach + around - low) / side;
        let most = reach + half;
        for row in (from.y.max(0.0) as usize)..=(to.y as usize).min(rows - 1) {
            for column in (from.x.max(0.0) as usize)..=(to.x as usize).min(columns - 1) {
                let middle = low + side * Vec2::new(column as f32 + 0.5, row as f32 + 0.5);
                if squared_distance(shape, middle) <= most * most {
                    lists[row * columns + column].push(index as u32);
                }
            }
        }
    }
    let longest = lists.iter().map(Vec::len).max().unwrap_or(0);
    if longest > GREATEST_NEAR {
        let problem = format!(
            "has {longest} walls, obstacles and blocks near one place; allowed: {GREATEST_NEAR} that a robot's sensors reach at once"
        );
        return Err(Invalid::new("arena", problem));
    }
    Ok(written(low, side, [columns, rows], longest, &lists))
}

fn written(low: Vec2, side: f32, [columns, rows]: [usize; 2], longest: usize, lists: &[Vec<u32>]) -> Vec<[u32; 4]> {
    let heads = lists.len().div_ceil(2);
    let first_list = 2 + heads;
    let mut cells = vec![
        [low.x, low.y, 1.0 / side, first_list as f32].map(|number| crate::exact::zero(number).to_bits()),
        [columns as u32, rows as u32, longest as u32, 0],
    ];
    let mut first = 0;
    let mut words = Vec::with_capacity(2 * lists.len());
    for list in lists {
        words.extend([first, list.len() as u32]);
        first += list.len() as u32;
    }
    words.resize(4 * heads, 0);
    words.extend(lists.iter().flatten());
    words.resize(words.len().next_multiple_of(4).max(4 * heads + 4), 0);
    cells.extend(words.as_chunks().0);
    cells
}
