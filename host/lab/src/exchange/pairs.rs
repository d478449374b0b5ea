//! Pairs of simulator and fitness that a robot received in an interval, and the choice among them (section 4.3 of O'Dowd,
//! Studley and Winfield, 2014).

use serde::{Deserialize, Serialize};

use super::Message;

/// The rule by which a message updates a pair that is already stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Key {
    /// It is of the same robot and interval.
    RobotAndInterval,
    /// It is of the same robot: when the sender's next interval begins, a fitness near 0 replaces that of a whole interval.
    Robot,
}

/// The pair that is dropped from a full store.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Leaves {
    /// The one with the lowest fitness, if the new one's is higher.
    Lowest,
    /// The one that was received first.
    Oldest,
}

/// Rules for the store of pairs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Rules {
    /// The most pairs: 10 in the paper.
    pub(crate) room: usize,
    /// When a message updates a pair.
    pub(crate) key: Key,
    /// The pair that is dropped.
    pub(crate) leaves: Leaves,
}

/// A robot's store of pairs in one interval.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pairs {
    rules: Rules,
    kept: Vec<Message>,
}

impl Pairs {
    /// An empty store.
    pub(crate) fn new(rules: Rules) -> Self {
        Self {
            rules,
            kept: Vec::new(),
        }
    }

    /// Stores a message.
    pub(crate) fn hear(&mut self, message: Message) {
        let same = |kept: &Message| {
            kept.sender == message.sender && (self.rules.key == Key::Robot || kept.interval == message.interval)
        };
        if let Some(known) = self.kept.iter_mut().find(|kept| same(kept)) {
            *known = message;
        } else if self.kept.len() < self.rules.room {
            self.kept.push(message);
        } else {
            match self.rules.leaves {
                Leaves::Oldest => {
                    self.kept.remove(0);
                    self.kept.push(message);
                }
                Leaves::Lowest => {
                    let lowest = (0..self.kept.len()).reduce(|low, index| {
                        if self.kept[index].fitness < self.kept[low].fitness {
                            index
                        } else {
                            low
                        }
                    });
                    if let Some(lowest) = lowest.filter(|&low| self.kept[low].fitness < message.fitness) {
                        self.kept[lowest] = message;
                    }
                }
            }
        }
    }

    /// The pair with the highest fitness, if that is above `own`, the robot's fitness; of equals the first received.
    pub(crate) fn better_than(&self, own: f32) -> Option<&Message> {
        self.kept
            .iter()
            .filter(|pair| pair.fitness > own)
            .reduce(|best, pair| if pair.fitness > best.fitness { pair } else { best })
    }

    /// All pairs, the best first.
    pub(crate) fn ranked(&self) -> Vec<Message> {
        let mut all = self.kept.clone();
        // Stable: of equals the first received.
        all.sort_by(|a, b| b.fitness.total_cmp(&a.fitness));
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rules(room: usize, key: Key, leaves: Leaves) -> Rules {
        Rules { room, key, leaves }
    }

    fn said(sender: usize, interval: u32, fitness: f32) -> Message {
        Message {
            sender,
            interval,
            simulator: sender as f32 / 100.0,
            fitness,
            controller: [0.0; 2],
        }
    }

    fn fitness(pairs: &Pairs) -> Vec<f32> {
        pairs.ranked().iter().map(|pair| pair.fitness).collect()
    }

    #[test]
    fn a_robots_later_message_replaces_the_earlier() {
        let mut pairs = Pairs::new(rules(10, Key::RobotAndInterval, Leaves::Lowest));
        for (interval, fitness) in [(4, 10.0), (4, 55.0), (5, 0.0), (5, 30.0)] {
            pairs.hear(said(3, interval, fitness));
        }
        assert_eq!(fitness(&pairs), [55.0, 30.0]);
        // With the robot alone as the key, its fitness in the ended interval is lost.
        let mut pairs = Pairs::new(rules(10, Key::Robot, Leaves::Lowest));
        for (interval, fitness) in [(4, 10.0), (4, 55.0), (5, 0.0)] {
            pairs.hear(said(3, interval, fitness));
        }
        assert_eq!(fitness(&pairs), [0.0]);
    }

    #[test]
    fn a_full_store_keeps_the_best_or_the_latest() {
        let mut lowest = Pairs::new(rules(2, Key::RobotAndInterval, Leaves::Lowest));
        let mut oldest = Pairs::new(rules(2, Key::RobotAndInterval, Leaves::Oldest));
        for (sender, fitness) in [(1, 5.0), (2, 9.0), (3, 1.0), (4, 7.0)] {
            lowest.hear(said(sender, 0, fitness));
            oldest.hear(said(sender, 0, fitness));
        }
        assert_eq!(fitness(&lowest), [9.0, 7.0]);
        assert_eq!(fitness(&oldest), [7.0, 1.0]);
    }

    #[test]
    fn ties_keep_one_s_own() {
        let mut pairs = Pairs::new(rules(10, Key::RobotAndInterval, Leaves::Lowest));
        assert_eq!(pairs.better_than(0.0), None);
        pairs.hear(said(1, 0, 20.0));
        pairs.hear(said(2, 0, 20.0));
        assert_eq!(pairs.better_than(20.0), None);
        assert_eq!(pairs.better_than(19.0).map(|pair| pair.sender), Some(1));
    }
}
