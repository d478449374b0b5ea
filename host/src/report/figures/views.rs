//! Why an object that is not round needs a sample for each point of view: robots around it at one distance, and how
//! near it is along what each of them sees.

use super::svg::{Anchor, INK, SOFT_INK, Svg, number, ramp};

const WIDTH: f64 = 940.0;
const HEIGHT: f64 = 350.0;
/// Width of a half, and where its object's centre is.
const HALF: f64 = 470.0;
const MIDDLE: (f64, f64) = (160.0, 185.0);
/// The object's radius, half the sides of the rectangle, and the gap to each robot, in pixels.
const ROUND: f64 = 44.0;
const BOX: (f64, f64) = (58.0, 28.0);
const AWAY: f64 = 52.0;
const ROBOT: f64 = 15.0;
/// Rays of a view, from one slope to the other beside straight ahead.
const RAYS: usize = 61;
const SLOPE: f64 = 1.35;
/// A view's strip.
const STRIP: (f64, f64) = (150.0, 26.0);
/// From far to near.
const NEARNESS: [[u8; 3]; 3] = [[0xc5, 0xdc, 0xdc], [0x4f, 0x9a, 0xa5], [0x1c, 0x2f, 0x5f]];
/// Directions from the object to the robots: unit vectors, y down.
const SIDES: [(f64, f64); 3] = [(-1.0, 0.0), (0.0, 1.0), (0.8, -0.6)];

#[derive(Clone, Copy)]
enum Shape {
    Round,
    Box,
}

/// Both kinds of object side by side.
pub(crate) fn points_of_view(title: &str) -> String {
    let mut svg = Svg::new(WIDTH, HEIGHT, title);
    half(&mut svg, 0.0, Shape::Round, "A round object: one sample is enough");
    half(
        &mut svg,
        HALF,
        Shape::Box,
        "A rectangular one: each point of view differs",
    );
    svg.finish()
}

fn half(svg: &mut Svg, left: f64, shape: Shape, words: &str) {
    let bold = format!("fill=\"{INK}\" font-weight=\"600\"");
    let soft = format!("fill=\"{SOFT_INK}\"");
    svg.words((left + 20.0, 28.0), 14.0, Anchor::Start, &bold, words);
    let centre = (left + MIDDLE.0, MIDDLE.1);
    for (i, &side) in SIDES.iter().enumerate() {
        cone(svg, centre, shape, side);
        let top = 106.0 + 70.0 * i as f64;
        let left = left + 306.0;
        let number = (i + 1).to_string();
        svg.words(
            (left - 12.0, top + 0.5 * STRIP.1 + 5.0),
            14.0,
            Anchor::End,
            &bold,
            &number,
        );
        strip(svg, (left, top), shape, side);
    }
    let style = format!("fill=\"#c9ccd3\" stroke=\"{INK}\" stroke-width=\"1.6\"");
    match shape {
        Shape::Round => svg.circle(centre, ROUND, &style, ""),
        Shape::Box => {
            let corner = (centre.0 - BOX.0, centre.1 - BOX.1);
            svg.rectangle(corner, (2.0 * BOX.0, 2.0 * BOX.1), &style);
        }
    }
    for (i, &side) in SIDES.iter().enumerate() {
        robot(svg, centre, shape, side, i + 1);
    }
    svg.words(
        (left + 306.0, 84.0),
        12.0,
        Anchor::Start,
        &soft,
        "what it sees, dark: near",
    );
}

/// Where a robot's front is: at the gap from the object's surface, facing its centre.
fn front(shape: Shape, side: (f64, f64)) -> (f64, f64) {
    let surface = match shape {
        Shape::Round => ROUND,
        // As far as the side that is met first.
        Shape::Box => (BOX.0 / side.0.abs()).min(BOX.1 / side.1.abs()),
    };
    let away = surface + AWAY;
    (side.0 * away, side.1 * away)
}

fn robot(svg: &mut Svg, centre: (f64, f64), shape: Shape, side: (f64, f64), number: usize) {
    let front = front(shape, side);
    let at = (centre.0 + front.0 + side.0 * ROBOT, centre.1 + front.1 + side.1 * ROBOT);
    let style = format!("fill=\"#ffffff\" stroke=\"{INK}\" stroke-width=\"1.8\"");
    svg.circle(at, ROBOT, &style, "");
    let nose = |far: f64| (at.0 - far * side.0, at.1 - far * side.1);
    svg.line(
        nose(ROBOT - 4.0),
        nose(ROBOT + 5.0),
        &format!("stroke=\"{INK}\" stroke-width=\"3\""),
    );
    let bold = format!("fill=\"{INK}\" font-weight=\"600\"");
    svg.words((at.0, at.1 + 4.5), 13.0, Anchor::Middle, &bold, &number.to_string());
}

/// What a robot sees of an object, from its front to the surface.
fn cone(svg: &mut Svg, centre: (f64, f64), shape: Shape, side: (f64, f64)) {
    let from = front(shape, side);
    let hits = (0..RAYS).filter_map(|ray| {
        let (dx, dy) = direction(side, slope(ray));
        let far = distance(shape, from, (dx, dy))?;
        Some((centre.0 + from.0 + far * dx, centre.1 + from.1 + far * dy))
    });
    let eye = (centre.0 + from.0, centre.1 + from.1);
    svg.polygon(
        std::iter::once(eye).chain(hits),
        "fill=\"#e9c46a\" fill-opacity=\"0.35\" stroke=\"#c79a2b\" stroke-width=\"0.8\"",
    );
}

/// The object along a view, from left to right.
fn strip(svg: &mut Svg, (left, top): (f64, f64), shape: Shape, side: (f64, f64)) {
    svg.rectangle((left, top), STRIP, "fill=\"#f5f3ee\"");
    let width = STRIP.0 / RAYS as f64;
    for ray in 0..RAYS {
        let Some(far) = distance(shape, front(shape, side), direction(side, slope(ray))) else {
            continue;
        };
        // Depth ahead, not along the ray: a flat side is everywhere as near.
        let near = 1.0 - (far - AWAY) / 60.0;
        let style = format!("fill=\"{}\" shape-rendering=\"crispEdges\"", ramp(&NEARNESS, near));
        svg.rectangle((left + width * ray as f64, top), (width + 0.4, STRIP.1), &style);
    }
    svg.rectangle((left, top), STRIP, "fill=\"none\" stroke=\"#a9acb3\"");
    let middle = number(left + 0.5 * STRIP.0);
    svg.raw(&format!(
        "<path d=\"M{middle} {}v6\" stroke=\"{SOFT_INK}\"/>",
        number(top + STRIP.1)
    ));
}

/// The slope of a ray against straight ahead: positive to the right.
fn slope(ray: usize) -> f64 {
    SLOPE * (2.0 * ray as f64 / (RAYS - 1) as f64 - 1.0)
}

/// One unit ahead, towards the object, and the slope to the right.
fn direction(side: (f64, f64), slope: f64) -> (f64, f64) {
    (-side.0 + slope * side.1, -side.1 - slope * side.0)
}

/// How many directions' lengths an object is away.
fn distance(shape: Shape, from: (f64, f64), direction: (f64, f64)) -> Option<f64> {
    let ((x, y), (dx, dy)) = (from, direction);
    match shape {
        Shape::Round => {
            let squared = dx * dx + dy * dy;
            let along = -(x * dx + y * dy) / squared;
            let beside = x * x + y * y - along * along * squared;
            (beside <= ROUND * ROUND).then(|| along - ((ROUND * ROUND - beside) / squared).sqrt())
        }
        Shape::Box => {
            let slab = |at: f64, step: f64, half: f64| {
                if step == 0.0 {
                    let within = at.abs() <= half;
                    return if within {
                        (f64::NEG_INFINITY, f64::INFINITY)
                    } else {
                        (f64::INFINITY, f64::NEG_INFINITY)
                    };
                }
                let (a, b) = ((-half - at) / step, (half - at) / step);
                (a.min(b), a.max(b))
            };
            let (across, up) = (slab(x, dx, BOX.0), slab(y, dy, BOX.1));
            let (enter, leave) = (across.0.max(up.0), across.1.min(up.1));
            (enter <= leave && enter >= 0.0).then_some(enter)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view(shape: Shape, side: (f64, f64)) -> Vec<Option<f64>> {
        let from = front(shape, side);
        let depth = |ray| distance(shape, from, direction(side, slope(ray)));
        (0..RAYS).map(depth).collect()
    }

    #[test]
    fn a_round_object_looks_the_same_from_everywhere() {
        let [first, rest @ ..] = SIDES.map(|side| view(Shape::Round, side));
        assert!(first.iter().any(Option::is_some) && first.iter().any(Option::is_none));
        for other in rest {
            for (a, b) in first.iter().zip(&other) {
                match (a, b) {
                    (Some(a), Some(b)) => assert!((a - b).abs() < 1e-9, "{a} {b}"),
                    (a, b) => assert_eq!(a, b),
                }
            }
        }
    }

    #[test]
    fn a_rectangle_does_not() {
        let seen = SIDES.map(|side| view(Shape::Box, side).iter().flatten().count());
        assert!(seen[0] < seen[1], "{seen:?}: the short side is the narrower");
        let from_corner = view(Shape::Box, SIDES[2]);
        let mirrored: Vec<_> = from_corner.iter().rev().copied().collect();
        assert_ne!(from_corner, mirrored, "askew");
    }

    #[test]
    fn all_robots_stand_at_the_same_gap() {
        for shape in [Shape::Round, Shape::Box] {
            for side in SIDES {
                let ahead = distance(shape, front(shape, side), direction(side, 0.0)).expect("it is ahead");
                assert!((ahead - AWAY).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn what_is_beside_or_behind_is_not_seen() {
        assert_eq!(distance(Shape::Box, (-100.0, 50.0), (1.0, 0.0)), None);
        assert_eq!(distance(Shape::Box, (100.0, 0.0), (1.0, 0.0)), None);
        assert_eq!(distance(Shape::Round, (0.0, 100.0), (1.0, 0.0)), None);
    }
}
