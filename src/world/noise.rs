//! Noise of a simulated episode.

use crate::exact::zero;
use crate::parameter::{Choice, Choices, Invalid, LEAST};
use crate::world::robot::Build;

/// Noise of a simulated episode. All zeros is the paper's "no noise".
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Noise {
    /// Range of a uniform number that is added to each activation, which is then clipped to `0..=1`. The paper's sensor
    /// noise is `(0.0, 0.4)`; a symmetric one is `(-0.2, 0.2)`.
    pub sensor: (f32, f32),
    /// Conservative noise: perceived positions are displaced by a random walk within plus and minus this, mm. Paper:
    /// 30.
    pub walk_range: f32,
    /// Maximum step of that walk in one cycle, mm, in x and y each.
    pub walk_step: f32,
    /// Relative uniform noise on each cycle's displacement and turn, 0 to 1.
    pub motor: f32,
    /// Relative uniform noise of each activation, 0 to 1. `None`: 0.
    pub gain: Option<f32>,
    /// Maximum turn for each metre of the way, turns. `None`: 0.
    pub veer: Option<f32>,
    /// Maximum share of a cycle by which commands act late. `None`: 0.
    pub delay: Option<f32>,
    /// How often all noise but conservative noise is drawn. `None`: in each cycle.
    pub drawn: Option<Drawn>,
}

impl Noise {
    /// Whether a number of a world, by its key in files, is noise that a world may have or not.
    pub fn is_key(key: &str) -> bool {
        key.starts_with("noise.") || key.ends_with("_noise")
    }

    /// The paper's condition without noise.
    pub const NONE: Self = Self {
        sensor: (0.0, 0.0),
        walk_range: 0.0,
        walk_step: 0.0,
        motor: 0.0,
        gain: None,
        veer: None,
        delay: None,
        drawn: None,
    };
    /// The paper's sensor noise.
    pub const SENSOR: Self = Self {
        sensor: (0.0, 0.4),
        ..Self::NONE
    };
    /// The paper's conservative noise; it gives no size for the walk's step, so that is ours.
    pub const CONSERVATIVE: Self = Self {
        walk_range: 30.0,
        walk_step: 1.5,
        ..Self::NONE
    };

    /// Whether it has what only the part `robot/varied.wgsl` has.
    pub(crate) fn is_varied(&self) -> bool {
        self.drawn == Some(Drawn::Life)
            || [self.gain, self.veer, self.delay]
                .iter()
                .flatten()
                .any(|value| *value > 0.0)
    }

    /// The cell of numbers that this part reads.
    pub(super) fn cell(&self) -> [u32; 4] {
        let per_episode = f32::from(u8::from(self.drawn == Some(Drawn::Life)));
        let [gain, veer, delay] = [self.gain, self.veer, self.delay].map(Option::unwrap_or_default);
        [gain, veer * 1e-3, delay, per_episode].map(|number| zero(number).to_bits())
    }

    pub(super) fn check(&self, robot: &Build) -> Result<(), Invalid> {
        let (low, high) = self.sensor;
        let span = high - low;
        if span < 0.0 || (span < LEAST && (low, high) != (0.0, 0.0)) {
            let problem = format!("is [{low:?}, {high:?}]; allowed: [0, 0] or [minimum, maximum]");
            return Err(Invalid::new("noise.sensor", problem));
        }
        // A longer step could leave the range on the other side after it is reflected.
        if self.walk_step > 2.0 * self.walk_range {
            let problem = format!(
                "is {}; allowed: at most twice noise.walk_range_mm, {}",
                self.walk_step,
                2.0 * self.walk_range
            );
            return Err(Invalid::new("noise.walk_step_mm", problem));
        }
        if *robot == Build::Sampled || !self.is_varied() {
            return Ok(());
        }
        let numbers = [
            ("noise.gain", self.gain),
            ("noise.veer_turns_per_m", self.veer),
            ("noise.delay_cycles", self.delay),
        ];
        let given = numbers.iter().find(|(_, value)| value.is_some_and(|value| value > 0.0));
        let (key, is, allowed) = given.map_or(("noise.drawn", "`life`", "`cycle`"), |(key, _)| (*key, "not 0", "0"));
        let problem = format!("is {is}; allowed: {allowed}, or robot.kind = \"sampled\"");
        Err(Invalid::new(key, problem))
    }
}

/// How often noise is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Drawn {
    /// Anew in each cycle.
    #[default]
    Cycle,
    /// Once for a whole episode. Hashes that identify recorded worlds contain the name `Life`.
    Life,
}

impl Choice for Drawn {
    const CHOICES: Choices<Self> = &[
        ("cycle", Self::Cycle, "anew in each cycle"),
        ("life", Self::Life, "once for a whole episode"),
    ];
}
