//! Figures 2 to 5: the arena, the samples, why points of view matter, and a controller.

use oneiro::world::Start;
use oneiro_report::figures;
use oneiro_report::page::figure;

use super::{Report, run_name};

/// Figures 2, 4 and 5.
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
