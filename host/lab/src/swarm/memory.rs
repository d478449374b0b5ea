//! Exchange of messages within one process: the arena says which robots received a message from which, and the contents are
//! looked up.

use std::collections::VecDeque;
use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::on_board::OnBoard;
use super::record::{Credit, Kind};
use super::settings::Says;
use crate::exchange::{Exchange, Message};

/// Messages received in one second, and the fitness that they reported.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Second {
    /// The robots that each robot received a message from, a bit each.
    pub heard: Vec<u128>,
    /// Each robot's fitness in its interval so far, when the second began.
    pub earned: Vec<f32>,
    /// The same when the second ended.
    pub(crate) earned_after: Vec<f32>,
}

/// The last seconds of a world.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Seconds {
    kept: usize,
    first: u32,
    last: VecDeque<Second>,
}

impl Seconds {
    /// Keeps the last `kept` seconds: an interval and the time within which robots are switched on, since the first robot's
    /// interval is looked up when the last robot's has ended.
    pub(crate) fn new(kept: u32) -> Self {
        Self {
            kept: kept as usize,
            first: 0,
            last: VecDeque::new(),
        }
    }

    /// Adds the next second.
    pub(crate) fn push(&mut self, second: Second) {
        if self.last.len() == self.kept {
            self.last.pop_front();
            self.first += 1;
        }
        self.last.push_back(second);
    }

    /// A second, if it is still kept.
    pub(crate) fn get(&self, second: u32) -> Option<&Second> {
        self.last.get(second.checked_sub(self.first)? as usize)
    }
}

/// The messages of one world.
pub(crate) struct Memory<'a> {
    /// The last seconds of the world.
    pub seconds: &'a Seconds,
    /// The robots that sent messages.
    pub robots: &'a [OnBoard],
    /// The fitness that robots report.
    pub says: Says,
    /// The simulator that they credit it to.
    pub credit: Credit,
    /// Robot whose fitness each robot reports: itself, except under the null.
    pub whose: &'a [usize],
    pub kind: Kind,
}

impl Memory<'_> {
    /// The message of a robot in a second; none before it is switched on.
    fn said(&self, sender: usize, at: u32, second: &Second) -> Option<Message> {
        let whose = self.whose[sender];
        let whole = |last: usize| {
            let real = *self.robots[whose].real.get(last)?;
            if self.kind == Kind::Disparity {
                return self.robots[sender].agreement(last as u32, real);
            }
            Some(real)
        };
        let rules = match self.kind {
            // A prediction can be compared once its interval is over.
            Kind::Disparity => (Says::LastWhole, Credit::Matched),
            _ => (self.says, self.credit),
        };
        self.robots[sender].message(sender, at, rules, second.earned[whose], whole)
    }
}

impl Exchange for Memory<'_> {
    fn heard(&self, robot: usize, seconds: Range<u32>) -> Vec<Message> {
        let mut messages = Vec::new();
        for at in seconds {
            let Some(second) = self.seconds.get(at) else { continue };
            let mut mask = second.heard[robot];
            while mask != 0 {
                let sender = mask.trailing_zeros() as usize;
                mask &= mask - 1;
                messages.extend(self.said(sender, at, second));
            }
        }
        messages
    }
}
