//! The world as the owner of its kernel's parts.

use crate::parameter::Invalid;
use crate::parts::compose::{EpisodeKind, Grids, Make, Owner};
use crate::world::physics::Physics;
use crate::world::spec::WorldSpec;

impl WorldSpec {
    /// Describes this world and its robot to the parts of a kernel for these episodes.
    ///
    /// # Errors
    /// A robot that needs what this program can't compose, or names that WGSL doesn't allow.
    pub(crate) fn owner(&self, physics: &Physics, episodes: EpisodeKind) -> Result<Owner, Invalid> {
        Ok(Owner {
            make: make(self, physics, episodes)?,
            fields: self.robot.build.fields(),
            episodes,
            grids: physics.described().map_or(Grids::default(), |robot| robot.grids),
            has_picture: self.arena.picture.is_some(),
            is_varied: self.noise.is_varied(),
        })
    }

    /// The same without checks, except those of the robot.
    #[cfg(all(test, feature = "compose"))]
    pub(crate) fn unchecked_owner(&self) -> Owner {
        let physics = super::check::physics(self).expect("a robot");
        self.owner(&physics, EpisodeKind::Simulated)
            .expect("names that WGSL allows")
    }
}

#[cfg(feature = "compose")]
fn make(spec: &WorldSpec, physics: &Physics, episodes: EpisodeKind) -> Result<Make, Invalid> {
    use crate::parameter::Choice;
    use crate::parts::compose::{Described, Hearing, Together};
    use crate::world::described::Drive;
    use crate::world::spec::{Controller, Task};
    use crate::world::wgsl;

    Ok(match physics {
        Physics::Sampled | Physics::Individual(_) => Make::Sampled,
        Physics::Forager(forager) => Make::Forager {
            behaves: spec.controller == Controller::Behaviours,
            brings: spec.task == Task::Foraging,
            has_many_items: forager.foraging.has_many_items(),
        },
        Physics::Described(robot, _) => Make::Described(Described {
            text: wgsl::of(robot, spec, episodes == EpisodeKind::Individual)?,
            sensors: robot.sensors.len(),
            has_sampled_sensors: robot.has_sampled_sensors(),
            has_sampled_motors: matches!(robot.drive, Drive::Motors { .. }),
            together: robot.together.as_ref().map(|swarm| Together {
                count: swarm.count,
                pucks: swarm.pucks.as_ref().map_or(0, |pucks| pucks.count),
                squares: swarm.squares(),
                rows: swarm.rows(),
                hearing: swarm.model.as_ref().map(|(model, values)| Hearing {
                    model: model.word(),
                    part: model.part(),
                    cycles: values.cycles(),
                }),
            }),
        }),
    })
}

#[cfg(not(feature = "compose"))]
fn make(spec: &WorldSpec, physics: &Physics, _: EpisodeKind) -> Result<Make, Invalid> {
    use crate::parameter::Choice;

    match physics {
        Physics::Sampled | Physics::Individual(_) => Ok(Make::Sampled),
        Physics::Described(..) | Physics::Forager(_) => {
            let kind = spec.robot.build.word();
            let problem = format!("is `{kind}`, but this program can't compose kernels; allowed: `sampled`");
            Err(Invalid::new("robot.kind", problem))
        }
    }
}
