//! The site of reality: which robot it is, where it is, and how to reach it. Only this file names kinds of reality.

use std::sync::Arc;

use oneiro::parameter::Invalid;
use oneiro::surrogate::{Differences, Surrogate};
use oneiro::world::{Collision, Noise, Robot, World, WorldSpec};

use super::surrogate::SurrogateRobot;
use super::{Reality, Trouble};
use crate::engine::handle::Engine;
use crate::engine::job::Outside;
use crate::exit::Failure;

/// A robot in its surroundings. Today every robot is a surrogate.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Site {
    seed: u64,
    surrogate: Arc<Surrogate>,
}

impl Site {
    /// Forms of addresses.
    pub(crate) const ADDRESSES: &str = "surrogate:SEED";

    /// The robot at an address. Of a surrogate, all differences from its simulator are scaled by the severity.
    ///
    /// # Errors
    /// The problem of the address.
    pub(crate) fn at(address: &str, severity: f32) -> Result<Self, String> {
        Ok(Self::drawn(parsed(address)?, severity))
    }

    /// A surrogate with all differences from its simulator, scaled by the severity.
    pub(crate) fn drawn(seed: u64, severity: f32) -> Self {
        Self::surrogate(seed, Surrogate::drawn(seed, Differences::all(severity)))
    }

    /// A surrogate. The seed draws the randomness of sampling.
    pub(crate) fn surrogate(seed: u64, surrogate: Surrogate) -> Self {
        Self {
            seed,
            surrogate: Arc::new(surrogate),
        }
    }

    /// Whether the robot is outside of the device, where a life can't be lived again.
    pub(crate) fn is_outside(&self) -> bool {
        false
    }

    /// The robot as a place of jobs' lives, if it is outside of the device. `simulator` has everything else about the lives.
    pub(crate) fn outside(&self, _simulator: &World) -> Option<Result<Arc<dyn Outside>, Failure>> {
        None
    }

    /// Hash of everything that decides how controllers perform there, apart from the world's other values.
    pub(crate) fn hash(&self) -> blake3::Hash {
        blake3::hash(format!("{:?}", self.surrogate).as_bytes())
    }

    /// The world of its rollouts, for batches shared with others, if reality is a simulation. `spec` has everything
    /// except its noise and the effect of collisions.
    ///
    /// # Errors
    /// The first value that the world doesn't allow.
    pub(crate) fn world(&self, spec: &WorldSpec) -> Result<World, Invalid> {
        World::new(WorldSpec {
            surrogate: Some(Arc::clone(&self.surrogate)),
            noise: Noise::NONE,
            robot: Robot {
                collision: Collision::Undo,
                ..spec.robot.clone()
            },
            ..spec.clone()
        })
    }

    /// The robot, ready to be sampled and driven. `spec` says how it is evaluated, except for its noise and the effect
    /// of collisions.
    ///
    /// # Errors
    /// [`Trouble::Broken`] with the value that the world doesn't allow.
    pub(crate) fn open<'a>(&self, engine: &'a Engine, spec: &WorldSpec) -> Result<Box<dyn Reality + 'a>, Trouble> {
        let world = self
            .world(spec)
            .map_err(|invalid| Trouble::Broken(invalid.to_string()))?;
        Ok(Box::new(SurrogateRobot::new(
            engine,
            self.seed,
            Arc::clone(&self.surrogate),
            world,
        )))
    }
}

/// Parses the seed in a robot's address, `surrogate:SEED`, the value of `--robot`.
///
/// # Errors
/// Exit 3 with the problem of the address.
pub(crate) fn seed_of(address: &str) -> Result<u64, Failure> {
    parsed(address).map_err(|problem| Failure::input(format_args!("--robot {address}: {problem}")))
}

fn parsed(address: &str) -> Result<u64, String> {
    let seed = address.strip_prefix("surrogate:").and_then(|seed| seed.parse().ok());
    seed.ok_or_else(|| format!("no such robot; allowed: {}, such as surrogate:1", Site::ADDRESSES))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_parsed() {
        assert_eq!(seed_of("surrogate:17").unwrap(), 17);
        for bad in [
            "surrogate",
            "surrogate:",
            "surrogate:-1",
            "surrogate:1.0",
            "khepera:1",
            "",
        ] {
            assert!(
                seed_of(bad)
                    .unwrap_err()
                    .to_string()
                    .contains("allowed: surrogate:SEED"),
                "{bad}"
            );
        }
    }

    #[test]
    fn sites_differ_by_robot_and_severity() {
        let hash = |seed, severity| Site::drawn(seed, severity).hash();
        assert_eq!(hash(1, 1.0), hash(1, 1.0));
        assert_ne!(hash(1, 1.0), hash(2, 1.0));
        assert_ne!(hash(1, 1.0), hash(1, 1.5));
    }
}
