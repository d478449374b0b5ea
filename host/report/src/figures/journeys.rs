//! Pairs of paths from the same start, in simulation and in reality, each pair in its arena.

use oneiro::arena::Arena;

use super::arena::Sheet;
use super::svg::{Anchor, BOLD, INK, PLAIN, Svg};

/// Longer side of an arena, in pixels.
const SIDE: f64 = 320.0;
const COLUMNS: usize = 3;
const MARGIN: f64 = 20.0;
const GAP: (f64, f64) = (28.0, 44.0);
const TOP: f64 = 34.0;
const BOTTOM: f64 = 14.0;
/// Dash pattern of simulated paths.
const DASH: &str = "5 3.5";

/// Two paths of one controller, in mm.
pub struct Journey<'a> {
    pub label: String,
    pub simulated: &'a [[f32; 2]],
    pub real: &'a [[f32; 2]],
}

/// Draws a panel for each journey and one with the key. `body_radius` is in mm.
pub fn journeys(arena: &Arena, body_radius: f32, title: &str, colour: &str, journeys: &[Journey<'_>]) -> String {
    let extent = Sheet::within(arena, (0.0, 0.0), SIDE).extent();
    let corner = |panel: usize| {
        (
            MARGIN + (panel % COLUMNS) as f64 * (SIDE + GAP.0),
            TOP + (panel / COLUMNS) as f64 * (extent.1 + GAP.1),
        )
    };
    let rows = (journeys.len() + 1).div_ceil(COLUMNS);
    let width = 2.0 * MARGIN + COLUMNS as f64 * SIDE + (COLUMNS - 1) as f64 * GAP.0;
    // The key also needs room next to narrow arenas.
    let height = (TOP + rows as f64 * (extent.1 + GAP.1) - GAP.1 + BOTTOM).max(TOP + 130.0);
    let mut svg = Svg::new(width, height, title);
    for (panel, journey) in journeys.iter().enumerate() {
        let sheet = Sheet::within(arena, corner(panel), SIDE);
        draw(&mut svg, &sheet, arena, f64::from(body_radius), colour, journey);
    }
    key(&mut svg, corner(journeys.len()), colour);
    svg.finish()
}

fn draw(svg: &mut Svg, sheet: &Sheet, arena: &Arena, body_radius: f64, colour: &str, journey: &Journey<'_>) {
    sheet.ground(svg, arena, 3.0);
    let place = |at: &[f32; 2]| sheet.place((f64::from(at[0]), f64::from(at[1])));
    let line = "stroke-linejoin=\"round\" stroke-linecap=\"butt\"";
    svg.polyline(
        journey.real.iter().map(place),
        &format!("stroke=\"{colour}\" stroke-width=\"1.7\" stroke-opacity=\"0.85\" {line}"),
    );
    svg.polyline(
        journey.simulated.iter().map(place),
        &format!("stroke=\"{INK}\" stroke-width=\"1.3\" stroke-dasharray=\"{DASH}\" {line}"),
    );
    if let Some(first) = journey.simulated.first().or(journey.real.first()) {
        let at = place(first);
        let scale = sheet.extent().0 / f64::from(arena.bounds().width).max(1.0);
        let style = format!("fill=\"{INK}\" fill-opacity=\"0.08\" stroke=\"{INK}\" stroke-width=\"1.2\"");
        svg.circle(at, body_radius * scale, &style, "start");
        svg.circle(at, 2.2, PLAIN, "");
    }
    for (path, fill, edge) in [(journey.real, colour, colour), (journey.simulated, "#ffffff", INK)] {
        if let Some(last) = path.last() {
            let style = format!("fill=\"{fill}\" stroke=\"{edge}\" stroke-width=\"1.6\"");
            svg.circle(place(last), 4.0, &style, "end");
        }
    }
    let corner = sheet.place((
        f64::from(arena.bounds().x),
        f64::from(arena.bounds().y + arena.bounds().height),
    ));
    svg.words((corner.0, corner.1 - 9.0), 13.0, Anchor::Start, BOLD, &journey.label);
}

/// Draws the key to lines and circles.
fn key(svg: &mut Svg, (left, top): (f64, f64), colour: &str) {
    let (left, end) = (left + 12.0, left + 62.0);
    let row = |i: u32| top + 22.0 + 28.0 * f64::from(i);
    let words = |svg: &mut Svg, i: u32, words: &str| {
        svg.words((end + 12.0, row(i) + 4.5), 13.0, Anchor::Start, PLAIN, words);
    };
    svg.line(
        (left, row(0)),
        (end, row(0)),
        &format!("stroke=\"{INK}\" stroke-width=\"1.5\" stroke-dasharray=\"{DASH}\""),
    );
    svg.circle(
        (end, row(0)),
        4.0,
        &format!("fill=\"#ffffff\" stroke=\"{INK}\" stroke-width=\"1.6\""),
        "",
    );
    words(svg, 0, "simulated, to its end");
    svg.line(
        (left, row(1)),
        (end, row(1)),
        &format!("stroke=\"{colour}\" stroke-width=\"2\""),
    );
    svg.circle((end, row(1)), 4.0, &format!("fill=\"{colour}\""), "");
    words(svg, 1, "real, to its end");
    let middle = 0.5 * (left + end);
    svg.circle(
        (middle, row(2) + 4.0),
        11.0,
        &format!("fill=\"{INK}\" fill-opacity=\"0.08\" stroke=\"{INK}\" stroke-width=\"1.2\""),
        "",
    );
    svg.circle((middle, row(2) + 4.0), 2.2, PLAIN, "");
    words(svg, 2, "the robot at the start that all share");
}

#[cfg(test)]
mod tests {
    use super::super::svg::number;
    use super::*;

    type Path<'a> = &'a [[f32; 2]];

    fn drawn(pairs: &[(Path<'_>, Path<'_>)]) -> String {
        let pairs: Vec<Journey<'_>> = pairs
            .iter()
            .map(|&(simulated, real)| Journey {
                label: "<a>".into(),
                simulated,
                real,
            })
            .collect();
        journeys(&Arena::miglino1995(), 27.5, "t", "#123456", &pairs)
    }

    #[test]
    fn simulated_paths_are_dashed_and_real_ones_full() {
        let text = drawn(&[(
            &[[100.0, 50.0], [200.0, 50.0]],
            &[[100.0, 50.0], [100.0, 300.0], [50.0, 50.0]],
        )]);
        let lines: Vec<&str> = text.lines().filter(|line| line.starts_with("<polyline")).collect();
        assert_eq!(lines.len(), 2);
        let points = |line: &str| line.split('"').nth(1).map_or(0, |points| points.split(' ').count());
        let dashed: Vec<(bool, usize)> = lines
            .iter()
            .map(|line| (line.contains("dasharray"), points(line)))
            .collect();
        assert_eq!(dashed, [(false, 3), (true, 2)]);
        assert!(text.contains("&lt;a&gt;"));
    }

    #[test]
    fn each_journey_has_an_arena_of_its_own() {
        let path: &[[f32; 2]] = &[[100.0, 50.0], [200.0, 50.0]];
        let obstacle = "radius 27.5 mm";
        assert_eq!(drawn(&[(path, path); 5]).matches(obstacle).count(), 15);
        assert_eq!(drawn(&[]).matches(obstacle).count(), 0);
    }

    #[test]
    fn the_start_is_as_large_as_the_robot() {
        let text = drawn(&[(&[[300.0, 100.0]], &[])]);
        let radius = number(27.5 / 600.0 * SIDE);
        assert!(text.contains(&format!("r=\"{radius}\"")), "{text}");
    }
}
