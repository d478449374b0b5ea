//! What the study can be asked for: scales and rules of credit side by side, and one assumption made otherwise.

use clap::builder::PossibleValue;
use oneiro::swarm::Differences;

use crate::evolve::encapsulated::Boundary;
use crate::exchange::pairs::{Key, Leaves};
use crate::swarm::record::Credit;
use crate::swarm::settings::{Says, Settings};

/// The mutation scales that stand side by side.
pub(crate) const SCALES: [f64; 3] = [2.0, 0.2, 0.02];
/// The rules of credit that stand side by side.
pub(crate) const CREDITS: [Credit; 2] = [Credit::Lagged, Credit::Matched];

/// One assumption that is made otherwise.
pub(crate) struct Arm {
    /// What it goes by on the command line and in files.
    pub(crate) name: &'static str,
    /// What readers see.
    pub(crate) words: &'static str,
    /// What it changes.
    pub(crate) change: fn(&mut Settings),
}

/// The name of the study as preregistered.
pub(crate) const MAIN: &str = "main";

/// All arms, the study as preregistered first.
pub(crate) const ARMS: [Arm; 26] = [
    arm(MAIN, "As preregistered", |_| ()),
    arm("reflect", "Genes are thrown back from their bounds", |own| {
        bounded(own, Boundary::Reflect);
    }),
    arm("wrap", "Genes come in again at the other bound", |own| {
        bounded(own, Boundary::Wrap);
    }),
    arm(
        "resample",
        "Genes are drawn until they are within their bounds",
        |own| {
            bounded(own, Boundary::Resample);
        },
    ),
    arm("cruise-40", "Robots drive at 40 mm/s", |own| {
        own.world.forager.cruise = 40.0;
    }),
    arm("cruise-128", "Robots drive at 128 mm/s", |own| {
        own.world.forager.cruise = 128.0;
    }),
    arm("escape-0", "No way straight on once an obstacle is clear", |own| {
        own.world.forager.escape = 0.0;
    }),
    arm("escape-2", "2 s straight on once an obstacle is clear", |own| {
        own.world.forager.escape = 2.0;
    }),
    arm("escape-4", "4 s straight on once an obstacle is clear", |own| {
        own.world.forager.escape = 4.0;
    }),
    arm("decay-1", "Light fades as exp(-1 d), d in metres", |own| {
        own.world.forager.light_decay = 1.0;
    }),
    arm("decay-4", "Light fades as exp(-4 d)", |own| {
        own.world.forager.light_decay = 4.0;
    }),
    arm("light-noise-0", "Light sensors without noise", |own| {
        own.world.forager.light_noise = 0.0;
    }),
    arm("light-noise-0.2", "Light sensors with noise of 0.2", |own| {
        own.world.forager.light_noise = 0.2;
    }),
    arm("pairs-1", "A robot remembers 1 pair", |own| own.simulators.pairs = 1),
    arm("pairs-5", "A robot remembers 5 pairs", |own| own.simulators.pairs = 5),
    arm("pairs-50", "A robot remembers 50 pairs", |own| {
        own.simulators.pairs = 50;
    }),
    arm("oldest-leaves", "The pair that was heard first makes room", |own| {
        own.simulators.leaves = Leaves::Oldest;
    }),
    arm("keyed-by-robot", "A robot's new interval overwrites its last", |own| {
        own.simulators.key = Key::Robot;
    }),
    arm(
        "last-whole",
        "Robots say the fitness of their last whole interval",
        |own| {
            own.simulators.says = Says::LastWhole;
        },
    ),
    arm("in-step", "All robots are switched on at once", |own| {
        own.clock.offset_s = 0;
    }),
    arm(
        "out-of-step",
        "Robots are switched on within 60 s (49 intervals)",
        |own| {
            own.clock.offset_s = 60;
        },
    ),
    arm(
        "installed-34",
        "The best simulated controller takes over after 34 s",
        |own| {
            own.clock.installed_s = 34;
        },
    ),
    arm(
        "guests-1",
        "One received controller is tried in one's own simulator",
        |own| {
            own.controllers.guests = 1;
        },
    ),
    arm(
        "guests-6",
        "Six received controllers are tried in one's own simulator",
        |own| {
            own.controllers.guests = 6;
        },
    ),
    arm(
        "no-differences",
        "The arena differs from simulators by its bodies alone",
        |own| {
            own.world.differences = Differences::NONE;
        },
    ),
    arm("always-heard", "Whoever is in range is heard", |own| {
        own.world.heard = 1.0;
        own.world.line_of_sight = false;
    }),
];

const fn arm(name: &'static str, words: &'static str, change: fn(&mut Settings)) -> Arm {
    Arm { name, words, change }
}

fn bounded(settings: &mut Settings, boundary: Boundary) {
    settings.controllers.boundary = boundary;
    settings.simulators.boundary = boundary;
}

/// Their names, with what they change.
pub(crate) fn names() -> Vec<PossibleValue> {
    let value = |arm: &Arm| PossibleValue::new(arm.name).help(arm.words);
    ARMS.iter().map(value).collect()
}

/// An arm by its name.
pub(crate) fn named(name: &str) -> Option<&'static Arm> {
    ARMS.iter().find(|arm| arm.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_arm_changes_something_and_has_a_name_of_its_own() {
        let mut seen = Vec::new();
        for arm in &ARMS {
            let mut settings = Settings::default();
            (arm.change)(&mut settings);
            assert!(!seen.contains(&(arm.name, settings.clone())));
            assert!(
                seen.iter().all(|(name, known)| *name != arm.name && *known != settings),
                "{}",
                arm.name
            );
            seen.push((arm.name, settings));
        }
        assert_eq!(seen[0].1, Settings::default());
    }
}
