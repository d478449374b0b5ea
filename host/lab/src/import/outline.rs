//! Finds the boxes that are the walls around an arena.

use std::f64::consts::{PI, TAU};

use super::draft::Outline;

/// A box seen from above, mm and degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Slab {
    pub(super) at: [f64; 2],
    pub(super) sides: [f64; 2],
    pub(super) degrees: f64,
}

/// Boxes that stand along one side.
struct Side {
    /// Inward.
    normal: [f64; 2],
    angle: f64,
    /// Distance of the inner face from the origin, along the normal.
    distance: f64,
    boxes: Vec<usize>,
}

/// Minimum of a wall's length, in widths.
const SLENDER: f64 = 4.0;
/// Lengths that make no difference, mm.
const NEARLY: f64 = 2.0;
/// Widest gap between walls, mm: no robot gets through.
const GAP: f64 = 20.0;
/// Angles that make no difference.
const ALIKE: f64 = 0.01;

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// The convex polygon of the inner faces of long, thin boxes around a middle, if they close it, and the boxes' numbers.
pub(super) fn around(boxes: &[Slab], middle: [f64; 2]) -> Option<(Outline, Vec<usize>)> {
    let slender = |slab: &Slab| {
        let [short, long] = [slab.sides[0].min(slab.sides[1]), slab.sides[0].max(slab.sides[1])];
        long >= SLENDER * short
    };
    let candidates: Vec<usize> = (0..boxes.len()).filter(|&index| slender(&boxes[index])).collect();
    let mut sides: Vec<Side> = Vec::new();
    for &index in &candidates {
        let slab = boxes[index];
        let is_across = slab.sides[1] > slab.sides[0];
        let angle = slab.degrees.to_radians() + if is_across { 0.0 } else { 0.5 * PI };
        let out = [angle.cos(), angle.sin()];
        let to_middle = dot(out, [middle[0] - slab.at[0], middle[1] - slab.at[1]]);
        let sign = if to_middle < 0.0 { -1.0 } else { 1.0 };
        let normal = [sign * out[0], sign * out[1]];
        let width = slab.sides[0].min(slab.sides[1]);
        let centre = dot(normal, slab.at);
        // Nothing that may be a wall stands behind it.
        let is_edge = candidates
            .iter()
            .all(|&other| dot(normal, boxes[other].at) >= centre - 0.5 * width - NEARLY);
        if !is_edge {
            continue;
        }
        let distance = centre + 0.5 * width;
        let known = sides
            .iter_mut()
            .find(|side| dot(side.normal, normal) > ALIKE.cos() && (side.distance - distance).abs() < NEARLY);
        match known {
            Some(side) => side.boxes.push(index),
            None => sides.push(Side {
                normal,
                angle: normal[1].atan2(normal[0]),
                distance,
                boxes: vec![index],
            }),
        }
    }
    sides.sort_by(|a, b| a.angle.total_cmp(&b.angle));
    let corners = corners(&sides)?;
    let is_closed = (0..sides.len()).all(|index| {
        let before = corners[(index + sides.len() - 1) % sides.len()];
        is_covered(&sides[index], boxes, [before, corners[index]])
    });
    if !is_closed {
        return None;
    }
    let used = sides.iter().flat_map(|side| side.boxes.iter().copied()).collect();
    let is_straight = |side: &Side| side.normal[0].abs().min(side.normal[1].abs()) < 1e-6;
    let outline = if sides.len() == 4 && sides.iter().all(is_straight) {
        let [low, high] = [f64::min, f64::max].map(|pick| {
            [0, 1].map(|axis| {
                corners
                    .iter()
                    .map(|corner| corner[axis])
                    .reduce(pick)
                    .unwrap_or_default()
            })
        });
        Outline::Rectangle {
            low,
            size: [high[0] - low[0], high[1] - low[1]],
        }
    } else {
        Outline::Polygon(corners)
    };
    Some((outline, used))
}

/// The corner after each side, if they are those of a convex polygon.
fn corners(sides: &[Side]) -> Option<Vec<[f64; 2]>> {
    if sides.len() < 3 {
        return None;
    }
    let mut corners = Vec::new();
    for (index, side) in sides.iter().enumerate() {
        let next = &sides[(index + 1) % sides.len()];
        let turn = (next.angle - side.angle).rem_euclid(TAU);
        if !(ALIKE..PI - ALIKE).contains(&turn) {
            return None;
        }
        let ([a, b], [c, d]) = (side.normal, next.normal);
        let area = a * d - b * c;
        corners.push([
            (side.distance * d - b * next.distance) / area,
            (a * next.distance - side.distance * c) / area,
        ]);
    }
    let is_inside = |corner: &[f64; 2]| {
        sides
            .iter()
            .all(|side| dot(side.normal, *corner) >= side.distance - NEARLY)
    };
    (corners.iter().all(is_inside)).then_some(corners)
}

/// Whether boxes stand along a whole side.
fn is_covered(side: &Side, boxes: &[Slab], ends: [[f64; 2]; 2]) -> bool {
    let along = [side.normal[1], -side.normal[0]];
    let [from, to] = ends.map(|end| dot(along, end));
    let mut spans: Vec<[f64; 2]> = side
        .boxes
        .iter()
        .map(|&index| {
            let slab = boxes[index];
            let (at, half) = (dot(along, slab.at), 0.5 * slab.sides[0].max(slab.sides[1]));
            [at - half, at + half]
        })
        .collect();
    spans.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut reached = from;
    for [begin, end] in spans {
        if begin > reached + GAP {
            return false;
        }
        reached = reached.max(end);
    }
    reached >= to - GAP
}

/// Whether a point is inside, or at most `room` outside.
pub(super) fn contains(outline: &Outline, at: [f64; 2], room: f64) -> bool {
    match outline {
        Outline::Rectangle { low, size } | Outline::Walled { low, size } => [0, 1]
            .iter()
            .all(|&axis| (low[axis] - room..=low[axis] + size[axis] + room).contains(&at[axis])),
        Outline::Polygon(corners) => (0..corners.len()).all(|index| {
            let from = corners[index];
            let next = corners[(index + 1) % corners.len()];
            let along = [next[0] - from[0], next[1] - from[1]];
            let inside = dot([-along[1], along[0]], [at[0] - from[0], at[1] - from[1]]);
            inside >= -room * along[0].hypot(along[1])
        }),
    }
}
