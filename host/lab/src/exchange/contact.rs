//! Pairs that a robot receives by radio: from robots in contact with it, one a second from each.

use std::collections::BTreeMap;
use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::{Exchange, Message};

/// Who can receive messages from whom.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Contact {
    /// Robots in contact by the tracker or the infra-red receivers: see [`Heard::meet`].
    #[default]
    Tracker,
    /// Everybody whose datagrams arrive: the radio's range decides.
    Range,
}

/// Recent messages to a robot. Which pairs it takes depends on who sent what in which second, and on its contacts in that second, not
/// on the order in which datagrams and sightings arrive.
#[derive(Clone, Debug)]
pub struct Heard {
    contact: Contact,
    /// The seconds that are kept. Messages of other seconds are dropped.
    kept: Range<u32>,
    /// By second and sender.
    said: BTreeMap<(u32, usize), Message>,
    /// The robots in contact in a second, one bit each.
    met: BTreeMap<u32, u128>,
}

impl Heard {
    /// An empty record. It keeps `seconds` seconds from the experiment's first on: a few more than an interval has.
    pub fn new(contact: Contact, seconds: u32) -> Self {
        Self {
            contact,
            kept: 0..seconds,
            said: BTreeMap::new(),
            met: BTreeMap::new(),
        }
    }

    /// Receives a robot's message in a second. Returns whether it is stored: the second is kept, and it is the robot's first in it.
    pub fn hear(&mut self, second: u32, message: Message) -> bool {
        let key = (second, message.sender);
        let is_first = self.kept.contains(&second) && !self.said.contains_key(&key);
        if is_first {
            self.said.insert(key, message);
        }
        is_first
    }

    /// Adds contacts in a second, one bit for each robot, from a sighting in that second.
    pub fn meet(&mut self, second: u32, robots: u128) {
        if self.kept.contains(&second) {
            *self.met.entry(second).or_default() |= robots;
        }
    }

    /// Drops the seconds before `second`, in which an interval has begun.
    pub fn forget_before(&mut self, second: u32) {
        let seconds = self.kept.len() as u32;
        self.kept = second..second.saturating_add(seconds);
        self.said = self.said.split_off(&(second, 0));
        self.met = self.met.split_off(&second);
    }

    fn has_met(&self, second: u32, sender: usize) -> bool {
        let mask = match self.contact {
            Contact::Range => u128::MAX,
            Contact::Tracker => self.met.get(&second).copied().unwrap_or(0),
        };
        mask.checked_shr(sender as u32).is_some_and(|bits| bits & 1 == 1)
    }
}

/// The messages that this robot received, whichever robot is asked for: by second, then by sender, as in the batched study.
impl Exchange for Heard {
    fn heard(&self, _: usize, seconds: Range<u32>) -> Vec<Message> {
        let end = seconds.end.max(seconds.start);
        let said = self.said.range((seconds.start, 0)..(end, 0));
        let taken = said.filter(|((second, sender), _)| self.has_met(*second, *sender));
        taken.map(|(_, message)| *message).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(sender: usize, fitness: f32) -> Message {
        Message {
            sender,
            interval: 0,
            simulator: 0.5,
            fitness,
            controller: [0.25, 0.75],
        }
    }

    /// One message a second from each sender, by second, then by sender.
    #[test]
    fn one_message_a_second_is_taken_of_each_robot() {
        let mut heard = Heard::new(Contact::Range, 10);
        for (second, sender, is_first) in [
            (3, 7, true),
            (3, 2, true),
            (2, 7, true),
            (3, 7, false),
            (9, 1, true),
            (10, 1, false),
        ] {
            assert_eq!(
                heard.hear(second, said(sender, f32::from(is_first))),
                is_first,
                "{second} {sender}"
            );
        }
        let senders = |heard: &Heard, seconds| -> Vec<usize> {
            let messages = heard.heard(0, seconds);
            assert!(messages.iter().all(|message| message.fitness == 1.0));
            messages.iter().map(|message| message.sender).collect()
        };
        assert_eq!(senders(&heard, 0..10), [7, 2, 7, 1]);
        assert_eq!(senders(&heard, 3..4), [2, 7]);
        heard.forget_before(3);
        assert_eq!(senders(&heard, 0..20), [2, 7, 1]);
        assert!(!heard.hear(2, said(4, 1.0)) && heard.hear(12, said(4, 1.0)) && !heard.hear(13, said(4, 1.0)));
    }

    /// Contact counts in the second of the message, whether the sighting comes before or after it.
    #[test]
    fn only_robots_in_contact_are_heard() {
        let mut heard = Heard::new(Contact::Tracker, 10);
        heard.meet(1, 0b100);
        for second in 0..4 {
            heard.hear(second, said(2, 1.0));
            heard.hear(second, said(127, 1.0));
            heard.hear(second, said(500, 1.0));
        }
        heard.meet(3, 0b010);
        heard.meet(3, 1 << 127);
        heard.meet(10, u128::MAX);
        let senders: Vec<usize> = heard.heard(0, 0..10).iter().map(|message| message.sender).collect();
        assert_eq!(senders, [2, 127]);
    }
}
