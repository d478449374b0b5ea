//! What a world tells the parts of its kernel about its robot.

use crate::parameter::Invalid;
use crate::parts::compose::{Lives, Make, Owner};
use crate::world::robot::Build;
use crate::world::spec::WorldSpec;

impl WorldSpec {
    /// The owner of this world's parts. A robot lives so in its kernel.
    ///
    /// # Errors
    /// A robot that needs what this program can't compose, or names that WGSL doesn't allow.
    pub(crate) fn owner(&self, lives: Lives) -> Result<Owner, Invalid> {
        Ok(Owner {
            make: make(self, lives)?,
            fields: self.robot.build.fields(),
            lives,
            is_varied: self.noise.is_varied(),
        })
    }
}

#[cfg(feature = "compose")]
fn make(spec: &WorldSpec, lives: Lives) -> Result<Make, Invalid> {
    use crate::parameter::Choice;
    use crate::parts::compose::{Described, Hearing, Together};
    use crate::world::spec::{Controller, Task};
    use crate::world::wgsl;

    Ok(match &spec.robot.build {
        Build::Sampled => Make::Sampled,
        Build::Forager(_) => Make::Forager {
            behaves: spec.controller == Controller::Behaviours,
            brings: spec.task == Task::Foraging,
        },
        Build::Differential(own) => Make::Described(Described {
            text: wgsl::of(own, spec, lives == Lives::Individual)?,
            sensors: own.sensors.len(),
            has_sampled_sensors: own.has_sampled_sensors(),
            has_sampled_motors: own.sampled_motors,
            together: own.count.map(|count| Together {
                count,
                hearing: own.model.map(|model| Hearing {
                    model: model.word(),
                    part: model.part(),
                    cycles: own.reference.cycles(),
                }),
            }),
        }),
    })
}

#[cfg(not(feature = "compose"))]
fn make(spec: &WorldSpec, _: Lives) -> Result<Make, Invalid> {
    use crate::parameter::Choice;

    match &spec.robot.build {
        Build::Sampled => Ok(Make::Sampled),
        other => {
            let kind = other.word();
            let problem = format!("is `{kind}`, but this program can't compose kernels; allowed: `sampled`");
            Err(Invalid::new("robot.kind", problem))
        }
    }
}
