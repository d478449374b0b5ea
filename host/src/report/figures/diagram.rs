//! Boxes and arrows: how a simulator and its controllers evolve on a robot, and what the controller is.

use super::svg::{Anchor, INK, SOFT_INK, Svg};

const ACCENT: &str = "#23528f";
const VIRTUAL: &str = "#e9eef7";
const REAL: &str = "#f7ecd6";
const PLAIN: &str = "#ffffff";
/// Height of a line of text, pixels.
const LINE: f64 = 18.0;

/// A box with a title and lines below it.
struct Box<'a> {
    at: (f64, f64),
    size: (f64, f64),
    fill: &'a str,
    title: &'a str,
    lines: &'a [&'a str],
}

impl Box<'_> {
    fn draw(&self, svg: &mut Svg) {
        let style = format!("rx=\"8\" fill=\"{}\" stroke=\"{INK}\" stroke-width=\"1.4\"", self.fill);
        svg.rectangle(self.at, self.size, &style);
        let x = self.at.0 + 0.5 * self.size.0;
        // The text as a whole stands in the middle.
        let first = self.at.1 + 0.5 * (self.size.1 - LINE * self.lines.len() as f64) + 5.0;
        let bold = format!("fill=\"{INK}\" font-weight=\"600\"");
        svg.words((x, first), 14.0, Anchor::Middle, &bold, self.title);
        for (i, words) in self.lines.iter().enumerate() {
            let y = first + LINE * (i + 1) as f64;
            svg.words((x, y), 12.0, Anchor::Middle, &format!("fill=\"{SOFT_INK}\""), words);
        }
    }
}

/// A line through points with a head at its end.
fn arrow(svg: &mut Svg, points: &[(f64, f64)], colour: &str) {
    const HEAD: (f64, f64) = (11.0, 5.0);
    let [.., before, end] = points else { return };
    let (dx, dy) = (end.0 - before.0, end.1 - before.1);
    let length = dx.hypot(dy).max(f64::MIN_POSITIVE);
    let (ux, uy) = (dx / length, dy / length);
    let back = (end.0 - HEAD.0 * ux, end.1 - HEAD.0 * uy);
    let shaft = points[..points.len() - 1].iter().copied().chain([back]);
    svg.polyline(
        shaft,
        &format!("stroke=\"{colour}\" stroke-width=\"2\" stroke-linejoin=\"round\""),
    );
    let beside = |side: f64| (back.0 - side * HEAD.1 * uy, back.1 + side * HEAD.1 * ux);
    svg.polygon([*end, beside(1.0), beside(-1.0)], &format!("fill=\"{colour}\""));
}

/// An arrow's points, its words and where they stand.
type Labelled<'a> = (&'a [(f64, f64)], &'a str, (f64, f64), Anchor);

/// A number in a disc.
fn badge(svg: &mut Svg, at: (f64, f64), number: u32) {
    svg.circle(at, 12.0, &format!("fill=\"{ACCENT}\""), "");
    let style = "fill=\"#ffffff\" font-weight=\"700\"";
    svg.words((at.0, at.1 + 4.5), 13.0, Anchor::Middle, style, &number.to_string());
}

/// Figure 1 of the 2014 study: the loop on a robot, numbered as in the paper's caption.
pub(crate) fn coevolution(title: &str) -> String {
    let mut svg = Svg::new(1060.0, 480.0, title);
    let frame =
        format!("rx=\"14\" fill=\"#fbfbf9\" stroke=\"{SOFT_INK}\" stroke-width=\"1.2\" stroke-dasharray=\"7 5\"");
    svg.rectangle((20.0, 20.0), (755.0, 440.0), &frame);
    let soft = format!("fill=\"{SOFT_INK}\" font-weight=\"600\"");
    svg.words((40.0, 46.0), 13.0, Anchor::Start, &soft, "one robot");
    let boxes = [
        Box {
            at: (50.0, 70.0),
            size: (290.0, 150.0),
            fill: VIRTUAL,
            title: "On-board simulator",
            lines: &[
                "environment model: gene S0",
                "ten controllers, genes G0 and G1,",
                "live 60 s each; the best four",
                "are kept and seed the other six",
            ],
        },
        Box {
            at: (480.0, 70.0),
            size: (270.0, 150.0),
            fill: VIRTUAL,
            title: "Evolution of the simulator",
            lines: &[
                "own and received pairs S0 : F_R",
                "are ranked; the best S0 is kept",
                "and mutated, the others are lost",
            ],
        },
        Box {
            at: (50.0, 310.0),
            size: (290.0, 110.0),
            fill: REAL,
            title: "Real robot",
            lines: &["acts for 60 s by the best controller", "and forages"],
        },
        Box {
            at: (480.0, 310.0),
            size: (270.0, 110.0),
            fill: REAL,
            title: "Real fitness F_R",
            lines: &["of the food brought, and when;", "stands for the simulator's fitness"],
        },
        Box {
            at: (880.0, 70.0),
            size: (160.0, 350.0),
            fill: PLAIN,
            title: "Robots met",
            lines: &["within 25 cm,", "each with its own", "simulator and", "real fitness"],
        },
    ];
    for one in &boxes {
        one.draw(&mut svg);
    }
    let arrows: [Labelled<'_>; 6] = [
        (
            &[(195.0, 220.0), (195.0, 310.0)],
            "best controller",
            (213.0, 263.0),
            Anchor::Start,
        ),
        (
            &[(340.0, 365.0), (480.0, 365.0)],
            "behaviour",
            (410.0, 355.0),
            Anchor::Middle,
        ),
        (
            &[(615.0, 310.0), (615.0, 220.0)],
            "own S0 : F_R",
            (630.0, 270.0),
            Anchor::Start,
        ),
        (
            &[(480.0, 145.0), (340.0, 145.0)],
            "next S0",
            (410.0, 135.0),
            Anchor::Middle,
        ),
        (
            &[(750.0, 365.0), (880.0, 365.0)],
            "S0 : F_R sent",
            (827.0, 395.0),
            Anchor::Middle,
        ),
        (
            &[(880.0, 145.0), (750.0, 145.0)],
            "S0 : F_R heard",
            (827.0, 175.0),
            Anchor::Middle,
        ),
    ];
    for (points, words, at, anchor) in arrows {
        arrow(&mut svg, points, ACCENT);
        svg.words(at, 12.0, anchor, &format!("fill=\"{INK}\""), words);
    }
    for (number, at) in [
        (1, (50.0, 70.0)),
        (2, (195.0, 258.0)),
        (3, (480.0, 310.0)),
        (4, (827.0, 365.0)),
        (4, (827.0, 145.0)),
        (5, (480.0, 70.0)),
    ] {
        badge(&mut svg, at, number);
    }
    svg.finish()
}

/// Figure 3 of the 2014 study: layers of behaviours, of which higher ones take over from lower ones.
pub(crate) fn subsumption(title: &str) -> String {
    let mut svg = Svg::new(1060.0, 470.0, title);
    let ys = [40.0, 130.0, 220.0, 330.0];
    let (layer, height) = ((470.0, 230.0), 60.0);
    let layers: [(&str, &[&str]); 4] = [
        ("Obstacle avoidance", &["turns away from what is near"]),
        ("Positive phototaxis", &["turns to the light"]),
        ("Negative phototaxis", &["turns from the light"]),
        ("Random search", &["always active"]),
    ];
    for ((name, lines), y) in layers.into_iter().zip(ys) {
        Box {
            at: (layer.0, y),
            size: (layer.1, height),
            fill: VIRTUAL,
            title: name,
            lines,
        }
        .draw(&mut svg);
    }
    let senses = [
        (ys[0], 60.0, "Proximity sensors", &["a wall or a robot is near"][..]),
        (ys[1], 60.0, "Light sensors", &["eight, around the body"][..]),
        (ys[2], 60.0, "Food state", &["carries food, or not"][..]),
    ];
    for (y, height, name, lines) in senses {
        Box {
            at: (30.0, y),
            size: (200.0, height),
            fill: REAL,
            title: name,
            lines,
        }
        .draw(&mut svg);
    }
    let right = layer.0;
    let middle = |y: f64| y + 0.5 * height;
    arrow(&mut svg, &[(230.0, middle(ys[0])), (right, middle(ys[0]))], INK);
    arrow(
        &mut svg,
        &[(230.0, middle(ys[1]) - 12.0), (right, middle(ys[1]) - 12.0)],
        INK,
    );
    arrow(
        &mut svg,
        &[
            (350.0, middle(ys[1]) - 12.0),
            (350.0, middle(ys[2]) - 18.0),
            (right, middle(ys[2]) - 18.0),
        ],
        INK,
    );
    genes(&mut svg, ys[2], ys[1], right);
    // A higher layer's line ends on a disc in the line of those below.
    let bottom = middle(ys[3]);
    let (end, discs) = (layer.0 + layer.1, [770.0, 850.0]);
    arrow(&mut svg, &[(end, bottom), (discs[0] - 15.0, bottom)], INK);
    arrow(&mut svg, &[(discs[0] + 15.0, bottom), (discs[1] - 15.0, bottom)], INK);
    arrow(&mut svg, &[(discs[1] + 15.0, bottom), (930.0, bottom)], INK);
    svg.line(
        (end, middle(ys[2])),
        (discs[0], middle(ys[2])),
        &format!("stroke=\"{INK}\" stroke-width=\"2\""),
    );
    arrow(
        &mut svg,
        &[
            (end, middle(ys[1])),
            (discs[0], middle(ys[1])),
            (discs[0], bottom - 15.0),
        ],
        INK,
    );
    arrow(
        &mut svg,
        &[
            (end, middle(ys[0])),
            (discs[1], middle(ys[0])),
            (discs[1], bottom - 15.0),
        ],
        INK,
    );
    for x in discs {
        svg.circle(
            (x, bottom),
            15.0,
            &format!("fill=\"{PLAIN}\" stroke=\"{INK}\" stroke-width=\"1.6\""),
            "",
        );
        svg.words(
            (x, bottom + 5.0),
            14.0,
            Anchor::Middle,
            &format!("fill=\"{INK}\" font-weight=\"600\""),
            "S",
        );
    }
    Box {
        at: (930.0, ys[3]),
        size: (105.0, height),
        fill: REAL,
        title: "Wheels",
        lines: &[],
    }
    .draw(&mut svg);
    let soft = format!("fill=\"{SOFT_INK}\"");
    let words = "S: while the line from above is active, it takes the place of the one from the left.";
    svg.words((1035.0, 430.0), 12.0, Anchor::End, &soft, words);
    svg.finish()
}

/// The genes that enable phototaxis: which one the food state asks, and what it says.
fn genes(svg: &mut Svg, food: f64, upper: f64, right: f64) {
    let top = food + 110.0;
    Box {
        at: (30.0, top),
        size: (200.0, 60.0),
        fill: VIRTUAL,
        title: "Genes",
        lines: &["with food G0, without it G1"],
    }
    .draw(svg);
    arrow(svg, &[(130.0, food + 60.0), (130.0, top)], INK);
    let colour = ACCENT;
    svg.polyline(
        [(230.0, top + 30.0), (380.0, top + 30.0), (380.0, food + 48.0)],
        &format!("stroke=\"{colour}\" stroke-width=\"2\""),
    );
    arrow(svg, &[(380.0, food + 48.0), (right, food + 48.0)], colour);
    arrow(
        svg,
        &[(380.0, food + 48.0), (380.0, upper + 46.0), (right, upper + 46.0)],
        colour,
    );
    let enables = format!("fill=\"{colour}\"");
    svg.words(
        (390.0, upper + 64.0),
        11.0,
        Anchor::Start,
        &enables,
        "0.66 \u{2013} 0.99",
    );
    svg.words((390.0, food + 66.0), 11.0, Anchor::Start, &enables, "0 \u{2013} 0.32");
    let soft = format!("fill=\"{SOFT_INK}\"");
    svg.words((244.0, top + 22.0), 11.0, Anchor::Start, &enables, "enables");
    svg.words(
        (244.0, top + 48.0),
        11.0,
        Anchor::Start,
        &soft,
        "0.33 \u{2013} 0.65: neither,",
    );
    svg.words((244.0, top + 63.0), 11.0, Anchor::Start, &soft, "it searches at random");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_loop_has_the_numbers_of_its_caption() {
        let text = coevolution("t");
        for number in 1..=5 {
            assert!(text.contains(&format!("font-weight=\"700\">{number}<")), "{number}");
        }
    }

    #[test]
    fn an_arrow_ends_where_it_points() {
        let mut svg = Svg::new(10.0, 10.0, "t");
        arrow(&mut svg, &[(0.0, 5.0), (100.0, 5.0)], INK);
        let text = svg.finish();
        assert!(
            text.contains("points=\"0,5 89,5\"") && text.contains("points=\"100,5 89,10 89,0\""),
            "{text}"
        );
    }

    #[test]
    fn every_layer_of_the_controller_is_there() {
        let text = subsumption("t");
        for layer in [
            "Obstacle avoidance",
            "Positive phototaxis",
            "Negative phototaxis",
            "Random search",
        ] {
            assert!(text.contains(layer), "{layer}");
        }
        assert_eq!(text.matches(">S<").count(), 2);
    }
}
