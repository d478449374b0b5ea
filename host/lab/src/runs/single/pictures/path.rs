//! The way of the champion's first episode.

use oneiro_evolve::Champion;
use oneiro_report::figures;

use super::super::trace::trace_every;
use super::Picture;

pub(super) const PICTURE: Picture = Picture {
    name: "path.svg",
    about: "a picture of that episode",
    caption: "The champion\u{2019}s first episode; of several robots, the path of the first.",
    is_of_champion: true,
    is_drawn: |single| !single.ends_outside(),
    draw: |run| {
        let world = run.experiment.world().of(run.first_key()).spec();
        let Champion {
            generation, individual, ..
        } = run.champion;
        let (name, seed) = (run.experiment.name(), run.seed);
        let title = format!("{name}, seed {seed}: individual {individual} of generation {generation}");
        let every = trace_every(run.experiment);
        let (arena, radius) = (&world.arena, world.robot.body_radius);
        Some(figures::life(arena, radius, &title, run.trace?, every))
    },
};
