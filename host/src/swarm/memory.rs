//! Messages between robots of a simulated arena: who heard whom is the arena's, what was said is looked up.

use std::collections::VecDeque;
use std::ops::Range;

use super::lived::Credit;
use super::mind::Mind;
use super::settings::Says;
use crate::exchange::{Exchange, Message};

/// What was heard and said in one second.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Second {
    /// Of each robot, whom it heard, a bit each.
    pub(crate) heard: Vec<u128>,
    /// Of each robot, what it had earned in its interval when the second began.
    pub(crate) earned: Vec<f32>,
    /// And when it ended.
    pub(crate) earned_after: Vec<f32>,
}

/// The last seconds of a world.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Seconds {
    kept: usize,
    first: u32,
    last: VecDeque<Second>,
}

impl Seconds {
    /// Keeps so many seconds. When the last robot has ended an interval, the first asks for what was heard since it began
    /// its own: an interval and the time in which robots are switched on.
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

    /// One of those that are kept.
    pub(crate) fn get(&self, second: u32) -> Option<&Second> {
        self.last.get(second.checked_sub(self.first)? as usize)
    }
}

/// The messages of one world.
pub(crate) struct Memory<'a> {
    /// What was heard.
    pub(crate) seconds: &'a Seconds,
    /// Who spoke.
    pub(crate) minds: &'a [Mind],
    /// What robots say.
    pub(crate) says: Says,
    /// What they credit their fitness to.
    pub(crate) credit: Credit,
    /// Whose fitness each robot says: its own but in a control.
    pub(crate) whose: &'a [usize],
}

impl Memory<'_> {
    /// What a robot says in a second; nothing before it is switched on.
    fn said(&self, sender: usize, at: u32, second: &Second) -> Option<Message> {
        let mind = &self.minds[sender];
        let now = mind.clock.interval_at(at)?;
        let controller = mind.acts(at);
        let whose = self.whose[sender];
        Some(match self.says {
            Says::SoFar => Message {
                sender,
                interval: now,
                simulator: mind.credited(now, self.credit),
                fitness: second.earned[whose],
                controller,
            },
            Says::LastWhole => {
                let last = now.checked_sub(1)?;
                Message {
                    sender,
                    interval: last,
                    simulator: mind.credited(last, self.credit),
                    fitness: *self.minds[whose].earned.get(last as usize)?,
                    controller,
                }
            }
        })
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
