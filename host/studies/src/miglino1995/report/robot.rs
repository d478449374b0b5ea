//! Figures 1 to 5: the robot, the arena, the samples, why points of view matter, and a controller.

use oneiro::tables::{SENSORS, SensorTable};
use oneiro::world::Start;
use oneiro_report::figures::{self, Eye};
use oneiro_report::page::figure;

use super::{Report, paper, run_name};
use crate::file::Edition;
use crate::miglino1995::judge::half_gaps;

/// Bearings of a Khepera's sensors in recordings, degrees clockwise.
const BEARINGS: [f64; SENSORS] = [-72.0, -43.0, -11.0, 11.0, 43.0, 72.0, 167.5, -167.5];

/// Where each sensor of a table looks, and how far.
fn eyes(table: &SensorTable) -> Vec<Eye> {
    let bearings = table.bearings as usize;
    let middle = |sensor: usize| {
        let (mut x, mut y) = (0.0, 0.0);
        for bearing in 0..bearings {
            let angle = std::f64::consts::TAU * bearing as f64 / bearings as f64;
            let reading = f64::from(table.cell(bearing)[sensor]);
            (x, y) = (x + reading * angle.cos(), y + reading * angle.sin());
        }
        y.atan2(x).to_degrees()
    };
    let halves = half_gaps(table).into_iter().enumerate();
    halves
        .map(|(sensor, half)| Eye {
            bearing: middle(sensor),
            half,
        })
        .collect()
}

/// Figure 1: the robot with its sensors. The first edition's report has the figures that it was published with.
fn robot(study: &Report<'_>) -> String {
    let wall = study.sensors.class("wall");
    let Some(wall) = wall.filter(|_| study.edition != Edition::First) else {
        return String::new();
    };
    let eyes = eyes(&study.sensors.classes[wall]);
    let printed = [
        "30 mm high, 70 g, two wheels",
        "six infra-red sensors in front, two at the back",
    ];
    let svg = figures::khepera(
        0.5 * paper::DIAMETER,
        &BEARINGS,
        &printed,
        f64::from(study.body_radius),
        &eyes,
    );
    let words = "The Khepera and its eight sensors, from above and to scale. Left: diameter, height, weight, wheels and sensors are the \
                 paper's; it shows a photograph and prints no directions, which are those of recordings here, and no distance between the \
                 wheels. Right: the robot of this study, each sensor in the direction in which it sees a wall most, with the distance at \
                 which it reads one half.";
    figure("Figure 1", words, &svg)
}

/// Figures 1, 2, 4 and 5.
pub(super) fn methods(study: &Report<'_>) -> String {
    let first = study.results.runs.first();
    let (weights, whose) = first.map_or((&[][..], "no run was recorded".to_owned()), |run| {
        let whose = format!(
            "drawn with the weights of the best individual of generation {}, run {} of the condition with {}",
            study.results.simulated_generations,
            run_name(run.number),
            run.condition.title()
        );
        (run.champion.genome.as_slice(), whose)
    });
    let figures = [
        robot(study),
        figure(
            "Figure 2",
            &format!(
                "The arena: {} by {} mm, {} round obstacles, and the robot to scale. The paper gives the arena's size \
                 and the obstacles' diameter (600 by 350 mm and 55 mm), but not where they stand.",
                study.arena.field.width,
                study.arena.field.height,
                study.arena.obstacles.len()
            ),
            &figures::arena(study.arena, study.body_radius, &[], &Start::Random),
        ),
        figure(
            "Figure 4",
            "Perception of a symmetrical object depends on distance and orientation alone; that of a non-symmetrical one \
             also on the point of view, so that it has to be sampled from several. Three robots with the object equally \
             far ahead, what they see of it (yellow), and how near it is from left to right of their view.",
            figures::POINTS_OF_VIEW,
        ),
        figure(
            "Figure 5",
            &format!("The network: eight sensors and a bias on two motors, 16 weights and 2 biases; {whose}."),
            &figures::network("The network", weights),
        ),
    ];
    figures.concat()
}

/// Figure 3: one for each class of object that was sampled.
pub(super) fn sensors(study: &Report<'_>) -> String {
    let mut body = String::new();
    for (place, table) in study.sensors.classes.iter().enumerate() {
        // The paper shows only the wall; other samples follow with the same wording.
        let (name, says) = if place == 0 {
            let says = " In the paper the sixth sensor's range is nearly twice the fifth's.";
            ("Figure 3".to_owned(), says)
        } else {
            (format!("Figure 3, {}", table.class), "")
        };
        body.push_str(&figure(
            &name,
            &format!(
                "What each sensor of the sampled robot reads for an object of class \u{201c}{}\u{201d}, over the \
                 object's bearing (clockwise, 0\u{b0} straight ahead) and its distance: {} orientations at {} \
                 distances.{says}",
                table.class, table.bearings, table.rows
            ),
            &figures::sensor_table(table),
        ));
    }
    body
}
