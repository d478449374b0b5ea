//! The robot's activity and its obstacles, as reported to the operator.

/// What the robot does, for the operator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Activity {
    /// It has heard no beacon yet.
    Waiting,
    /// Stopped by the operator, or by a missing beacon.
    Standing,
    /// It is to be switched on later.
    Off,
    /// It acts in the experiment.
    Living,
    /// Something is in the way: see the problems.
    Troubled,
    /// The experiment is over.
    Over,
}

impl Activity {
    const ALL: [Self; 6] = [
        Self::Waiting,
        Self::Standing,
        Self::Off,
        Self::Living,
        Self::Troubled,
        Self::Over,
    ];

    /// The one with a status's number, if there is one.
    pub(crate) fn of(number: u8) -> Option<Self> {
        Self::ALL.get(usize::from(number)).copied()
    }

    /// In a word, for logs and tables.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Waiting => "waiting",
            Self::Standing => "standing",
            Self::Off => "off",
            Self::Living => "living",
            Self::Troubled => "troubled",
            Self::Over => "over",
        }
    }
}

/// Problems, a bit each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Problems(u32);

impl Problems {
    /// The tracker does not see the robot.
    pub(crate) const TRACKER: u32 = 1;
    /// The operator's beacon has fallen silent.
    pub(crate) const BEACON: u32 = 2;
    /// The robot can't be read or driven.
    pub(crate) const ROBOT: u32 = 4;
    /// Nothing can be saved.
    pub(crate) const DISK: u32 = 8;

    /// Those of a status.
    pub(crate) fn of(bits: u32) -> Self {
        Self(bits)
    }

    /// For a status.
    pub(crate) fn bits(self) -> u32 {
        self.0
    }

    /// Notes whether a problem holds.
    pub(super) fn set(&mut self, problem: u32, holds: bool) {
        self.0 = self.0 & !problem | if holds { problem } else { 0 };
    }

    /// Whether a problem holds.
    pub(super) fn has(self, problem: u32) -> bool {
        self.0 & problem != 0
    }

    /// All others.
    pub(super) fn without(self, problem: u32) -> Self {
        Self(self.0 & !problem)
    }

    /// Whether the wheels must stand.
    pub(super) fn any(self) -> bool {
        self.0 != 0
    }

    /// Those that hold, in words.
    pub(crate) fn words(self) -> Vec<&'static str> {
        let all = [
            (Self::TRACKER, "tracker"),
            (Self::BEACON, "beacon"),
            (Self::ROBOT, "robot"),
            (Self::DISK, "disk"),
        ];
        all.into_iter()
            .filter(|(bit, _)| self.has(*bit))
            .map(|(_, word)| word)
            .collect()
    }
}
