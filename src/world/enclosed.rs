//! Whether a robot can leave its arena.

use glam::Vec2;

use super::pack::{shapes, touches};
use super::{Start, WorldSpec};
use crate::arena::Field;

/// Most points along a side of the grid: a hundredth of a second for some dozen objects.
const MOST: f32 = 400.0;

/// Whether walls and objects keep a robot near the arena's field, as far as a grid of half the body's radius shows: no way leads
/// from where it may start to twice its diameter beyond the field. `None` if the field is too large for such a grid.
pub(super) fn is_enclosed(spec: &WorldSpec) -> Option<bool> {
    let step = 0.5 * spec.robot.body_radius;
    let margin = 4.0 * spec.robot.body_radius;
    let field = spec.arena.field;
    let Field { x, y, width, height } = field;
    let middle = Vec2::new(x + 0.5 * width, y + 0.5 * height);
    let low = Vec2::new(x - margin, y - margin);
    let [columns, rows] = [width, height].map(|side| ((side + 2.0 * margin) / step).ceil() + 1.0);
    if columns > MOST || rows > MOST {
        return None;
    }
    let (columns, rows) = (columns as usize, rows as usize);
    let place = |point: usize| low + step * Vec2::new((point % columns) as f32, (point / columns) as f32);
    let shapes = shapes(spec);
    let may_start = |at: Vec2| match spec.start {
        Start::Random if spec.arena.is_field_round => at.distance(middle) <= 0.5 * width,
        Start::Random => field.contains(at.x, at.y),
        Start::At { x, y, .. } => at.distance(Vec2::new(x, y)) < step,
    };
    let mut is_free: Vec<bool> = (0..columns * rows)
        .map(|point| !touches(&shapes, place(point)))
        .collect();
    let mut reached: Vec<usize> = (0..columns * rows)
        .filter(|&point| is_free[point] && may_start(place(point)))
        .collect();
    for &point in &reached {
        is_free[point] = false;
    }
    while let Some(point) = reached.pop() {
        let (column, row) = (point % columns, point / columns);
        if column == 0 || row == 0 || column == columns - 1 || row == rows - 1 {
            return Some(false);
        }
        for next in [point - 1, point + 1, point - columns, point + columns] {
            if std::mem::take(&mut is_free[next]) {
                reached.push(next);
            }
        }
    }
    Some(true)
}
