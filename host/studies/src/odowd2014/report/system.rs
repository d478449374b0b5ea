//! Figures 1 to 4: the loop on a robot, the scenarios, the controller, and the arena with its robots.

use oneiro_report::figures;
use oneiro_report::page::figure;

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
    figures.concat()
}
