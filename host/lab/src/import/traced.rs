//! The boundary of a map's free pixels: traced along their edges, and simplified to a tolerance.

use std::cmp::Ordering;
use std::collections::{BTreeSet, BinaryHeap};

/// Most corners of all outlines before they are simplified.
const GREATEST_CORNERS: usize = 1 << 18;
/// Directions of edges, counter-clockwise: to the right, up, to the left, down.
const STEPS: [[i32; 2]; 4] = [[1, 0], [0, 1], [-1, 0], [0, -1]];

/// A corner between pixels, counted from the lower left corner of the picture.
pub(super) type Corner = [i32; 2];

/// Which pixels of a map are free, row after row from the lower left one.
pub(super) struct Free {
    width: usize,
    height: usize,
    pixels: Vec<bool>,
}

impl Free {
    /// # Panics
    /// With another number of pixels than `width` times `height`.
    pub(super) fn new(width: usize, height: usize, free: Vec<bool>) -> Self {
        assert_eq!(free.len(), width * height);
        Self {
            width,
            height,
            pixels: free,
        }
    }

    /// Whether a pixel is free; none beyond the picture is.
    fn is_free(&self, x: i32, y: i32) -> bool {
        let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y)) else {
            return false;
        };
        x < self.width && y < self.height && self.pixels[y * self.width + x]
    }

    /// The corners of each outline, with what is free to its left. Free pixels that only touch at a corner are apart.
    ///
    /// # Errors
    /// More corners than [`GREATEST_CORNERS`].
    pub(super) fn outlines(&self) -> Result<Vec<Vec<Corner>>, String> {
        let columns = self.width + 1;
        // A bit for each direction in which an edge leaves a corner.
        let mut edges = vec![0_u8; columns * (self.height + 1)];
        let place = |[x, y]: Corner| y as usize * columns + x as usize;
        for (y, row) in (0..).zip(self.pixels.chunks(self.width)) {
            for (x, _) in (0..).zip(row).filter(|(_, free)| **free) {
                for (direction, [beside, from]) in [
                    [[x, y - 1], [x, y]],
                    [[x + 1, y], [x + 1, y]],
                    [[x, y + 1], [x + 1, y + 1]],
                    [[x - 1, y], [x, y + 1]],
                ]
                .into_iter()
                .enumerate()
                {
                    if !self.is_free(beside[0], beside[1]) {
                        edges[place(from)] |= 1 << direction;
                    }
                }
            }
        }
        let mut outlines = Vec::new();
        let mut count = 0;
        for first in 0..edges.len() {
            while edges[first] != 0 {
                let mut at = [(first % columns) as i32, (first / columns) as i32];
                let mut direction = edges[first].trailing_zeros() as usize;
                let mut outline = vec![at];
                loop {
                    edges[place(at)] &= !(1 << direction);
                    at = [0, 1].map(|axis| at[axis] + STEPS[direction][axis]);
                    // Around the same pixel if others touch it here: to the left, straight on, or to the right.
                    let leaving = edges[place(at)];
                    let Some(next) = [1, 0, 3]
                        .map(|turn| (direction + turn) % 4)
                        .into_iter()
                        .find(|next| leaving & 1 << next != 0)
                    else {
                        break;
                    };
                    if next != direction {
                        outline.push(at);
                        count += 1;
                    }
                    direction = next;
                }
                outlines.push(outline);
                if count > GREATEST_CORNERS {
                    return Err(format!(
                        "has more than {GREATEST_CORNERS} corners between free and occupied pixels; allowed: fewer, without specks"
                    ));
                }
            }
        }
        Ok(outlines)
    }

    /// A free pixel with much room, and how many pixels around it are free on all sides; `None` if none is free.
    pub(super) fn roomiest(&self) -> Option<Corner> {
        let mut room: Vec<u32> = self
            .pixels
            .iter()
            .map(|free| if *free { u32::MAX } else { 0 })
            .collect();
        let (width, height) = (self.width, self.height);
        // Steps of a king to what is not free, first from the lower left and then from the upper right.
        for pass in 0..2 {
            for step in 0..room.len() {
                let index = if pass == 0 { step } else { room.len() - 1 - step };
                let (x, y) = (index % width, index / width);
                if room[index] == 0 {
                    continue;
                }
                let is_edge = x == 0 || y == 0 || x == width - 1 || y == height - 1;
                let mut least = if is_edge { 1 } else { room[index] };
                if !is_edge {
                    let around = [width + 1, width, width - 1, 1];
                    for away in around {
                        let other = if pass == 0 { index - away } else { index + away };
                        least = least.min(room[other].saturating_add(1));
                    }
                }
                room[index] = least;
            }
        }
        // The first of several.
        let best = (0..room.len()).rev().max_by_key(|index| room[*index])?;
        (room[best] > 0).then(|| [(best % width) as i32, (best / width) as i32])
    }
}

/// Why an outline can't be simplified.
#[derive(Debug, PartialEq)]
pub(super) enum Many {
    /// There are more outlines than walls are allowed.
    Outlines(usize),
    /// With this tolerance in pixels there would be few enough walls.
    Tolerance(f64),
}

/// A part of an outline between two of its corners that a wall stands for.
struct Chain {
    outline: usize,
    from: usize,
    to: usize,
    /// The corner that is farthest from the wall, and its squared distance.
    farthest: usize,
    squared: f64,
}

impl PartialEq for Chain {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Chain {}

impl PartialOrd for Chain {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// By distance, then by place, so that results don't depend on the order in which chains are found.
impl Ord for Chain {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_distance = self.squared.total_cmp(&other.squared);
        by_distance.then_with(|| (other.outline, other.from).cmp(&(self.outline, self.from)))
    }
}

/// The squared distance of a corner from a segment.
fn squared_distance(at: Corner, from: Corner, to: Corner) -> f64 {
    let difference = |a: Corner, b: Corner| [0, 1].map(|axis| f64::from(a[axis]) - f64::from(b[axis]));
    let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
    let (along, away) = (difference(to, from), difference(at, from));
    let (length, part) = (dot(along, along), dot(along, away));
    if part <= 0.0 {
        return dot(away, away);
    }
    if part >= length {
        let beyond = difference(at, to);
        return dot(beyond, beyond);
    }
    let across = along[0] * away[1] - along[1] * away[0];
    across * across / length
}

/// Makes walls of outlines, each with the number of its outline: no point of an outline is farther than `tolerance` pixels from the
/// walls. Chains are divided at the corner that is farthest from their wall, as by Douglas and Peucker, the worst chain first.
///
/// # Errors
/// More than `most` walls.
pub(super) fn walls(outlines: &[Vec<Corner>], tolerance: f64, most: usize) -> Result<Vec<(usize, [Corner; 2])>, Many> {
    let chain = |outline: usize, from: usize, to: usize| {
        let corners = &outlines[outline];
        let at = |index: usize| corners[index % corners.len()];
        let mut found = Chain {
            outline,
            from,
            to,
            farthest: from,
            squared: 0.0,
        };
        for index in from + 1..to {
            let squared = squared_distance(at(index), at(from), at(to));
            if squared > found.squared {
                (found.farthest, found.squared) = (index, squared);
            }
        }
        found
    };
    if outlines.len() > most {
        return Err(Many::Outlines(outlines.len()));
    }
    let mut chains = BinaryHeap::new();
    // An outline of two chains that are not divided is one wall, there and back.
    let mut undivided = outlines.len();
    let mut is_divided = vec![false; outlines.len()];
    for (outline, corners) in outlines.iter().enumerate() {
        let squared = |index: &usize| squared_distance(corners[*index], corners[0], corners[0]);
        let far = (0..corners.len())
            .max_by(|a, b| squared(a).total_cmp(&squared(b)))
            .unwrap_or(0);
        chains.push(chain(outline, 0, far));
        chains.push(chain(outline, far, corners.len()));
    }
    while let Some(worst) = chains.peek().filter(|worst| worst.squared > tolerance * tolerance) {
        let (outline, from, to, farthest) = (worst.outline, worst.from, worst.to, worst.farthest);
        let rest = undivided - usize::from(!is_divided[outline]);
        if chains.len() + 1 - rest > most {
            // A little more, whatever the root is rounded to.
            return Err(Many::Tolerance(worst.squared.sqrt() * (1.0 + 1e-9)));
        }
        undivided = rest;
        is_divided[outline] = true;
        chains.pop();
        chains.push(chain(outline, from, farthest));
        chains.push(chain(outline, farthest, to));
    }
    let mut chains = chains.into_vec();
    chains.sort_by_key(|chain| (chain.outline, chain.from));
    let mut known = BTreeSet::new();
    let ends = chains.iter().map(|chain| {
        let corners = &outlines[chain.outline];
        (
            chain.outline,
            [chain.from, chain.to].map(|index| corners[index % corners.len()]),
        )
    });
    Ok(ends
        .filter(|(_, [from, to])| known.insert([*from.min(to), *from.max(to)]))
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `.` is free; the first row is the upper one.
    fn map(rows: &[&str]) -> Free {
        let free = rows.iter().rev().flat_map(|row| row.bytes().map(|byte| byte == b'.'));
        Free::new(rows[0].len(), rows.len(), free.collect())
    }

    /// Free pixels by chance.
    fn noise(width: usize, height: usize, seed: u32, share: u32) -> Free {
        let mut state = seed;
        let free = (0..width * height).map(|_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) < share
        });
        Free::new(width, height, free.collect())
    }

    #[test]
    fn outlines_have_what_is_free_to_their_left() {
        let outlines = map(&["#####", "#...#", "#.#.#", "#...#", "#####"]).outlines().unwrap();
        let room = vec![[1, 1], [4, 1], [4, 4], [1, 4]];
        let pillar = vec![[2, 2], [2, 3], [3, 3], [3, 2]];
        assert_eq!(outlines, [room, pillar]);
    }

    #[test]
    fn the_edge_of_the_picture_is_a_boundary() {
        assert_eq!(
            map(&["..", ".."]).outlines().unwrap(),
            [[[0, 0], [2, 0], [2, 2], [0, 2]]]
        );
    }

    #[test]
    fn pixels_that_touch_at_a_corner_are_apart() {
        assert_eq!(map(&[".#", "#."]).outlines().unwrap().len(), 2);
        let ring = map(&["#.#", ".#.", "#.#"]);
        assert_eq!(ring.outlines().unwrap().len(), 4);
    }

    /// Every edge between free and other pixels is on exactly one outline.
    #[test]
    fn outlines_have_all_edges() {
        for seed in 0..20 {
            let map = noise(17, 11, seed, 40 + 8 * seed);
            let mut edges = 0;
            for y in -1..12 {
                for x in -1..18 {
                    edges += i32::from(map.is_free(x, y) != map.is_free(x + 1, y));
                    edges += i32::from(map.is_free(x, y) != map.is_free(x, y + 1));
                }
            }
            let length = |outline: &Vec<Corner>| -> i32 {
                let next = outline.iter().cycle().skip(1);
                outline
                    .iter()
                    .zip(next)
                    .map(|(a, b)| (a[0] - b[0]).abs() + (a[1] - b[1]).abs())
                    .sum()
            };
            assert_eq!(map.outlines().unwrap().iter().map(length).sum::<i32>(), edges);
        }
    }

    /// Points along all outlines lie within the tolerance of a wall.
    #[test]
    fn walls_are_within_the_tolerance() {
        for seed in 0..12 {
            let map = noise(40, 30, seed, 60 + 14 * seed);
            let outlines = map.outlines().unwrap();
            let mut before = usize::MAX;
            for tolerance in [0.0, 0.6, 1.0, 2.5, 10.0] {
                let walls = walls(&outlines, tolerance, 100_000).unwrap();
                assert!(walls.len() <= before);
                before = walls.len();
                for corners in &outlines {
                    for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
                        // In halves of pixels.
                        let steps = 2 * (a[0] - b[0]).abs().max((a[1] - b[1]).abs());
                        for step in 0..steps {
                            let at = [0, 1].map(|axis| 2 * a[axis] + (b[axis] - a[axis]).signum() * step);
                            let double = |corner: Corner| corner.map(|value| 2 * value);
                            let nearest = walls
                                .iter()
                                .map(|(_, [from, to])| squared_distance(at, double(*from), double(*to)))
                                .fold(f64::INFINITY, f64::min);
                            assert!(
                                nearest <= 4.0 * tolerance * tolerance + 1e-9,
                                "{nearest} at {tolerance}"
                            );
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn slopes_of_steps_become_one_wall() {
        let rows: Vec<String> = (0..20).map(|row| ".".repeat(row + 1) + &"#".repeat(20 - row)).collect();
        let outlines = map(&rows.iter().map(String::as_str).collect::<Vec<_>>())
            .outlines()
            .unwrap();
        assert_eq!(outlines[0].len(), 42);
        // A triangle.
        assert_eq!(walls(&outlines, 1.0, 10).unwrap().len(), 3);
        assert_eq!(walls(&outlines, 0.0, 100).unwrap().len(), 42);
    }

    #[test]
    fn a_tolerance_that_fits_is_named() {
        let outlines = noise(60, 60, 3, 128).outlines().unwrap();
        let most = outlines.len() + 50;
        let Err(Many::Tolerance(enough)) = walls(&outlines, 0.0, most) else {
            panic!("too many walls");
        };
        assert!(walls(&outlines, enough, most).unwrap().len() <= most);
        assert_eq!(walls(&outlines, 1.0, 3), Err(Many::Outlines(outlines.len())));
    }

    #[test]
    fn the_roomiest_pixel_is_far_from_all_others() {
        assert_eq!(
            map(&["#######", "#.....#", "#.....#", "#.....#", "#######"]).roomiest(),
            Some([2, 2])
        );
        assert_eq!(
            map(&[".....", ".....", ".....", ".....", "....."]).roomiest(),
            Some([2, 2])
        );
        assert_eq!(map(&["##"]).roomiest(), None);
    }

    #[test]
    fn too_many_corners_are_refused() {
        let free = (0..1024 * 1024).map(|at| (at / 1024 + at) % 2 == 0);
        let message = Free::new(1024, 1024, free.collect()).outlines().unwrap_err();
        assert!(message.starts_with("has more than 262144 corners"), "{message}");
    }
}
