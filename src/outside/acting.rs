//! The behaviours of the 2014 study on a real robot, or in somebody else's simulation: its readings are reported cycle by cycle,
//! and the behaviours decide by the same code and with the same bits as those of a [swarm](crate::swarm).
//!
//! ```
//! use oneiro::acting::{Acting, Readings};
//! use oneiro::cpu::Cpu;
//! use oneiro::foraging::{Foraging, Light};
//! use oneiro::random::Key;
//! use oneiro::swarm::Behaviour;
//!
//! let robot = Foraging::odowd2014(Light::OverNest);
//! let acting = Acting::new(&robot)?;
//! let mut mind = Acting::begin(Key::rollout(1, 0, 0, 0));
//! let mut cpu = Cpu::new(Some(1))?;
//! // Nothing is near, and the light is straight ahead: a robot with food that seeks the light drives on.
//! let readings = Readings {
//!     near: [0.0; 4],
//!     light: [0.9, 0.4, 0.4, 0.9, 0.1, 0.1, 0.1, 0.1],
//! };
//! let deed = acting.cycle(&mut mind, &mut cpu, [0.99, 0.0], &readings, true)?;
//! assert_eq!(deed.behaviour, Behaviour::SeekLight);
//! assert_eq!(deed.drive().wheels(&robot), [80.0, 80.0]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use oneiro_shaders::{Kernel, acting as kernel, episode, forager};

use crate::batch::{Buffers, Rollout, TraceRequest, WorldKind, Worlds};
use crate::evaluator::{Control, Evaluator};
use crate::foragers::foraging::{Drive, Foraging, GENES};
use crate::foragers::swarm::Behaviour;
pub use crate::foragers::swarm::Readings;
pub use crate::outside::reported::Error;
use crate::parameter::{Invalid, integer};
use crate::random::Key;

/// Words that a mind remembers from cycle to cycle: `EpisodeState` of the kernel, `physics/acting.wgsl`.
pub const MEMORY: usize = 4;

/// What a robot does in a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deed {
    /// Commanded way of its centre, mm.
    pub forward: f32,
    /// Commanded turn, turns counter-clockwise.
    pub turn: f32,
    /// The behaviour that decided.
    pub behaviour: Behaviour,
}

impl Deed {
    /// The commanded way and turn.
    pub fn drive(&self) -> Drive {
        Drive {
            forward: self.forward,
            turn: self.turn,
        }
    }
}

/// What a robot's behaviours remember: plain data, so that it can be saved and restored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mind {
    key: Key,
    cycle: u32,
    memory: [u32; MEMORY],
}

impl Mind {
    /// Restores a mind from its key, its next cycle and its memory.
    ///
    /// # Errors
    /// A memory that no mind has.
    pub fn restored(key: Key, cycle: u32, memory: [u32; MEMORY]) -> Result<Self, Invalid> {
        let [escape, _, turn, _] = memory.map(f32::from_bits);
        if [-1.0, 0.0, 1.0].contains(&escape) && turn.abs() <= 0.25 {
            return Ok(Self { key, cycle, memory });
        }
        let problem = format!(
            "escapes to side {escape} and has {turn} turns left; allowed: -1, 0 or 1, and up to 0.25 turns either way"
        );
        Err(Invalid::new("memory", problem))
    }

    /// The key of its random numbers.
    pub fn key(&self) -> Key {
        self.key
    }

    /// Its next cycle, by whose number it draws random numbers.
    pub fn cycle(&self) -> u32 {
        self.cycle
    }

    /// What it remembers.
    pub fn memory(&self) -> [u32; MEMORY] {
        self.memory
    }

    /// Goes on with another cycle: a robot that is switched on late, or has missed cycles, keeps to the numbers of the others.
    pub fn skip_to(&mut self, cycle: u32) {
        self.cycle = cycle;
    }
}

/// A forager's behaviours.
#[derive(Clone, Debug)]
pub struct Acting {
    worlds: Worlds,
}

impl Acting {
    /// Takes the behaviours of a forager: its speeds, its gains, its times and what is near to it. Its arena, its noise and its body don't
    /// count.
    ///
    /// # Errors
    /// The first invalid value.
    pub fn new(foraging: &Foraging) -> Result<Self, Invalid> {
        let behaviours = Behaviours {
            foraging: *foraging,
            cycles: u32::MAX,
        };
        behaviours.check()?;
        Ok(Self {
            worlds: Worlds::new(&[behaviours])?,
        })
    }

    /// A mind before cycle 0.
    pub fn begin(key: Key) -> Mind {
        Mind {
            key,
            cycle: 0,
            memory: [0; MEMORY],
        }
    }

    /// Decides what a robot does in a mind's next cycle, by its genes ([foragers](crate::foraging) say what they mean), its readings and
    /// whether it carries food.
    ///
    /// # Errors
    /// Genes or readings that aren't from 0 to 1; those of the device. The mind is then as before.
    pub fn cycle(
        &self,
        mind: &mut Mind,
        device: &mut dyn Evaluator,
        genes: [f32; GENES],
        readings: &Readings,
        carries: bool,
    ) -> Result<Deed, Error> {
        check("genes", &genes)?;
        check("readings.near", &readings.near)?;
        check("readings.light", &readings.light)?;
        let carries = f32::from(u8::from(carries));
        let inputs = [&genes[..], &readings.near, &readings.light, &[carries]].concat();
        let rollout = Rollout {
            world: 0,
            genes: &inputs,
            key: mind.key,
        };
        // An episode begins with cycle 0.
        let memory: &[_] = if mind.cycle == 0 { &[] } else { &[mind.memory.to_vec()] };
        let next = mind.cycle.saturating_add(1);
        let trace = TraceRequest { every: 1 };
        let batch = self.worlds.stretch(&[rollout], mind.cycle..next, memory, Some(trace))?;
        let outcome = device.evaluate(&batch, &Control::new())?;
        mind.cycle = next;
        mind.memory.copy_from_slice(&outcome.states[0]);
        let details: kernel::Details = outcome.traces[0].details_as(0);
        Ok(Deed {
            forward: details.forward,
            turn: details.turn,
            behaviour: Behaviour::of(details.behaviour),
        })
    }
}

fn check(field: &str, numbers: &[f32]) -> Result<(), Invalid> {
    match numbers.iter().position(|number| !(0.0..=1.0).contains(number)) {
        None => Ok(()),
        Some(index) => {
            let problem = format!("is {}; allowed: 0 to 1", numbers[index]);
            Err(Invalid::new(format!("{field}[{index}]"), problem))
        }
    }
}

/// Behaviours as a kind of world. An episode's readings are the same in all cycles of a stretch; it has a forager's genes, the
/// [`Readings`] in their order, and 1 if the robot carries food.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Behaviours {
    /// The robot.
    pub foraging: Foraging,
    /// Cycles of an episode.
    pub cycles: u32,
}

impl WorldKind for Behaviours {
    fn check(&self) -> Result<(), Invalid> {
        self.foraging.check()?;
        integer("cycles", self.cycles, 1..=u32::MAX)
    }

    fn kernel(&self) -> &'static Kernel {
        &oneiro_shaders::ACTING
    }

    fn genes(&self) -> usize {
        kernel::REPORTED_INPUTS as usize
    }

    fn pack(&self, _: usize, buffers: &mut Buffers) -> episode::World {
        let cells = self.foraging.cells(forager::FORAGER_CELLS, 1, 0.0);
        episode::World {
            steps: self.cycles,
            numbers: buffers.add_table(cells.into_table()),
            ..self.foraging.world()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::devices::cpu::Cpu;
    use crate::foragers::foraging::Light;

    fn refused<T: std::fmt::Debug>(result: Result<T, Error>) -> String {
        match result {
            Err(Error::Invalid(invalid)) => invalid.to_string(),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn what_is_no_reading_is_refused_and_changes_nothing() {
        let acting = Acting::new(&Foraging::odowd2014(Light::Nowhere)).unwrap();
        let mut cpu = Cpu::new(Some(1)).unwrap();
        let mut mind = Acting::begin(Key::rollout(1, 2, 3, 4));
        let mut cycle = |genes, readings: &Readings| refused(acting.cycle(&mut mind, &mut cpu, genes, readings, false));
        let with = |change: fn(&mut Readings)| {
            let mut readings = Readings::default();
            change(&mut readings);
            readings
        };
        for (readings, problem) in [
            (
                with(|readings| readings.near[2] = f32::NAN),
                "readings.near[2]: is NaN; allowed: 0 to 1",
            ),
            (
                with(|readings| readings.near[0] = 1.0_f32.next_up()),
                "readings.near[0]: is 1.0000001; allowed: 0 to 1",
            ),
            (
                with(|readings| readings.light[7] = f32::INFINITY),
                "readings.light[7]: is inf; allowed: 0 to 1",
            ),
            (
                with(|readings| readings.light[1] = -0.5),
                "readings.light[1]: is -0.5; allowed: 0 to 1",
            ),
        ] {
            assert_eq!(cycle([0.5; 2], &readings), problem);
        }
        assert_eq!(
            cycle([0.5, -1.0], &Readings::default()),
            "genes[1]: is -1; allowed: 0 to 1"
        );
        assert_eq!(mind, Acting::begin(Key::rollout(1, 2, 3, 4)));
        let invalid = Acting::new(&Foraging {
            turn: f32::NAN,
            ..Foraging::odowd2014(Light::Nowhere)
        });
        assert_eq!(invalid.unwrap_err().field, "robot.turn_rad_s");
    }

    #[test]
    fn a_mind_is_restored_from_what_it_says() {
        assert_eq!(oneiro_shaders::ACTING.stride("state"), size_of::<[u32; MEMORY]>());
        let acting = Acting::new(&Foraging::odowd2014(Light::Nowhere)).unwrap();
        let mut cpu = Cpu::new(Some(1)).unwrap();
        let mut mind = Acting::begin(Key::rollout(1, 2, 3, 4));
        let mut turned = 0;
        for cycle in 0..200 {
            let mut again = Mind::restored(mind.key(), mind.cycle(), mind.memory()).unwrap();
            let readings = Readings {
                near: [if cycle % 50 < 2 { 0.5 } else { 0.0 }, 0.0, 0.0, 0.0],
                ..Readings::default()
            };
            let mut deed = |mind: &mut Mind| acting.cycle(mind, &mut cpu, [0.5; 2], &readings, false).unwrap();
            let deed_now = deed(&mut mind);
            assert_eq!(deed(&mut again), deed_now);
            assert_eq!(again, mind);
            // Away from what is near on the left.
            assert!(cycle % 50 >= 2 || deed_now.turn < 0.0 && deed_now.behaviour == Behaviour::Avoid);
            turned += u32::from(deed_now.behaviour == Behaviour::Search && deed_now.turn != 0.0);
        }
        assert!(turned > 3, "{turned} cycles of random turns");
        let with = |word: usize, number: f32| {
            let mut memory = mind.memory();
            memory[word] = number.to_bits();
            Mind::restored(mind.key(), 1, memory)
        };
        for wrong in [with(0, 0.5), with(0, f32::NAN), with(2, 0.3), with(2, f32::NAN)] {
            assert!(wrong.unwrap_err().problem.contains("; allowed"));
        }
    }

    /// A robot's cycles have no last one.
    #[test]
    fn minds_go_on_for_years() {
        let acting = Acting::new(&Foraging::odowd2014(Light::Nowhere)).unwrap();
        let mut cpu = Cpu::new(Some(1)).unwrap();
        let mut mind = Acting::begin(Key::default());
        mind.skip_to(u32::MAX - 1);
        let mut cycle = || acting.cycle(&mut mind, &mut cpu, [0.5; 2], &Readings::default(), false);
        assert_eq!(cycle().unwrap().behaviour, Behaviour::Search);
        assert!(refused(cycle()).contains("allowed"));
    }
}
