//! Where robots and objects are placed for sampling.

use oneiro::arena::{Arena, Block, Field, Obstacle, Wall};

use super::{Object, Shape};

/// An arena with one object, of which the nearest point lies at the heading 0 from a robot's centre, mm, and at a distance that is
/// the sum of these. A wall reaches as far as `half_wall` mm to both sides. `view` is as in
/// [`Sampled::turn_before`](super::Sampled::turn_before).
pub(super) fn arena(
    object: &Object,
    view: f64,
    [x, y]: [f32; 2],
    apart: &[f32],
    half_wall: f32,
    field: Field,
) -> Arena {
    // Both sums are rounded term by term: samples that ship depend on it.
    let rim = apart.iter().fold(x, |sum, part| sum + part);
    let distance = apart.iter().sum();
    let class = object.class.clone();
    let mut arena = Arena {
        name: class.clone(),
        field,
        ..Arena::default()
    };
    match object.shape {
        Shape::Wall => arena.walls.push(Wall {
            from: [rim, y - half_wall],
            to: [rim, y + half_wall],
            class,
        }),
        Shape::Round { radius } => arena.obstacles.push(Obstacle {
            x: rim + radius,
            y,
            radius,
            class,
        }),
        Shape::Block { length, width } => {
            let [ahead, left, heading] = seen_from(view, [length, width], distance);
            arena.blocks.push(Block {
                x: x + ahead,
                y: y + left,
                length,
                width,
                heading,
                class,
            });
        }
    }
    arena
}

/// Position of a block seen from a robot. The robot's direction from the block is `view` turns off the block's length,
/// and its centre is `distance` mm from the block's nearest point, which lies straight ahead. Returns the block's
/// centre, mm ahead and to the left, and the direction of its length, turns. `view` is from 0 to 1/2.
fn seen_from(view: f64, sides: [f32; 2], distance: f32) -> [f32; 3] {
    let [half_length, half_width] = sides.map(|side| 0.5 * f64::from(side));
    let distance = f64::from(distance);
    let [along, across] = direction(view);
    // From the centre to where the distance is as wanted: in front of the end, of the long side, or of a corner.
    let before_end = (half_length + distance) / along.abs();
    let before_side = (half_width + distance) / across.abs();
    let far = if before_end * across <= half_width {
        before_end
    } else if before_side * along.abs() <= half_length {
        before_side
    } else {
        let corner = half_length * along.abs() + half_width * across;
        let past = half_length * half_length + half_width * half_width - corner * corner;
        corner + (distance * distance - past).sqrt()
    };
    // The robot in the block's frame, and the direction from there to the nearest point.
    let (x, y) = (far * along, far * across);
    let to_x = (x.clamp(-half_length, half_length) - x) / distance;
    let to_y = (y.min(half_width) - y) / distance;
    // The turn that takes that direction straight ahead takes the block's length to (to_x, -to_y).
    let (mut low, mut high) = (0.0, 180.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if oneiro::exact::cosine(middle) > to_x {
            low = middle;
        } else {
            high = middle;
        }
    }
    [-(to_x * x + to_y * y), to_y * x - to_x * y, low / 360.0].map(|number| number as f32)
}

/// Turn from one heading to another, in turns counter-clockwise, -1/2 to 1/2.
pub(super) fn turned(from: f32, to: f32) -> f64 {
    let turn = f64::from(to) - f64::from(from);
    turn - (turn + 0.5).floor()
}

/// Cosine and sine of turns, exactly rounded operations only: the tables must be the same everywhere.
pub(super) fn direction(turns: f64) -> [f64; 2] {
    [
        oneiro::exact::cosine(360.0 * turns),
        oneiro::exact::cosine(360.0 * turns - 90.0),
    ]
}
