//! Tables 1 and 2: what genes stand for. Figures 1 to 4: the loop on a robot, the scenarios, the controller, and the arena with its robots.

use std::ops::RangeInclusive;

use oneiro::foraging::Light;
use oneiro_report::figures;
use oneiro_report::page::{Cell, Head, Row, figure, table};

use super::Report;

pub(super) fn html(study: &Report<'_>) -> String {
    let forager = &study.foragers.forager;
    let figures = [
        figure(
            "Figure 1",
            "The co-evolution on a robot. 1) Controllers evolve in the on-board simulator. 2) The best of them goes to \
             the real robot. 3) The fitness that it has there stands for that of the simulator. 4) Pairs of a simulator \
             and its real fitness are sent to the robots nearby, and received from them. 5) When the controllers' \
             generation is over, the simulator evolves against those of the robots met. Blue: simulated; yellow: real.",
            figures::COEVOLUTION,
        ),
        figure(
            "Figure 2",
            &format!(
                "The three scenarios to scale: an arena of {} mm across, the nest within {} mm of a point of the wall, {} \
                 items of food of radius {} mm, and a lamp {} mm behind the wall. The paper does not give the size of the food \
                 nor how far away the lamp is.",
                2.0 * forager.arena_radius,
                forager.nest_radius,
                forager.food_items,
                forager.food_radius,
                forager.lamp_behind_wall
            ),
            &figures::scenarios("Three scenarios", forager),
        ),
        figure(
            "Figure 3",
            "The controller of simulated and real robots, a subsumption architecture: obstacle avoidance goes before \
             phototaxis, phototaxis before random search. The gene of the food state selects one phototaxis, or none: \
             G0 with food, G1 without.",
            figures::SUBSUMPTION,
        ),
        figure(
            "Figure 4",
            &format!(
                "The arena with {} e-pucks to scale, at random places, and the range of their sensors and messages.",
                study.foragers.robots
            ),
            &figures::foragers("The arena and its robots", study.foragers),
        ),
    ];
    tables() + &figures.concat()
}

/// The three ranges of a gene in the paper, in hundredths.
const RANGES: [RangeInclusive<u32>; 3] = [0..=32, 33..=65, 66..=99];

/// The paper's tables of genes, next to what genes stand for here.
fn tables() -> String {
    let range = |range: &RangeInclusive<u32>| {
        format!(
            "[{:.2} : {:.2}]",
            f64::from(*range.start()) / 100.0,
            f64::from(*range.end()) / 100.0
        )
    };
    let behaviours = [
        ("negative phototaxis", "flee the light"),
        ("random search", "search at random"),
        ("positive phototaxis", "seek the light"),
    ];
    let rows = RANGES.iter().zip(behaviours).map(|(of, (paper, here))| {
        let cells = [range(of), paper.to_owned(), paper.to_owned(), here.to_owned()];
        Row::from(Vec::from(cells.map(|cell| Cell::text(&cell))))
    });
    let head = [
        "Value",
        "paper: G0 (Food = True)",
        "paper: G1 (Food = False)",
        "here, both",
    ]
    .map(Head::Text);
    let words = "Table 1 of the paper, and what the two genes of a controller stand for here. Phototaxis acts where the brightest light \
                 sensor reads at least the threshold of the assumptions; below it the robot searches at random.";
    let first = table("", words, &head, &rows.collect::<Vec<_>>());
    let rows = RANGES
        .iter()
        .zip(["Light Opposite Nest", "No Light", "Light Over Nest"])
        .map(|(of, paper)| {
            let cells = [range(of), paper.to_owned(), lights(of).join(", ")];
            Row::from(Vec::from(cells.map(|cell| Cell::text(&cell))))
        });
    let head = ["Value", "paper: S0", "here"].map(Head::Text);
    let words = "Table 2 of the paper, and what the gene of a simulator stands for here.";
    first + &table("", words, &head, &rows.collect::<Vec<_>>())
}

/// The lights that the genes of a range have here.
fn lights(range: &RangeInclusive<u32>) -> Vec<&'static str> {
    let mut all: Vec<Light> = range
        .clone()
        .map(|hundredths| Light::of_gene((f64::from(hundredths) / 100.0) as f32 + 0.001))
        .collect();
    all.dedup();
    let words = |light: &Light| match light {
        Light::OppositeNest => "light opposite the nest",
        Light::Nowhere => "no light",
        Light::OverNest => "light over the nest",
    };
    all.iter().map(words).collect()
}
