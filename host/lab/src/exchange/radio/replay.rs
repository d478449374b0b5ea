//! Which datagrams have been taken: a window of 64 numbers for each sender, in which they may come in any order (the anti-replay
//! window of `IPsec`, RFC 4303, section 3.4.3).

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// The windows of all senders whose datagrams were taken.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Windows(BTreeMap<u16, Window>);

/// The newest number of a sender, and a bit for each of the 64 up to it, set if it was taken; the newest is the lowest bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Window {
    newest: u64,
    taken: u64,
}

impl Windows {
    /// Whether a sender's number is a new one. Numbers that are older than 64 others count as taken.
    pub(super) fn would_take(&self, sender: u16, sequence: u64) -> bool {
        let Some(window) = self.0.get(&sender) else {
            return true;
        };
        match window.newest.checked_sub(sequence) {
            None => true,
            Some(age) => age < u64::BITS.into() && window.taken >> age & 1 == 0,
        }
    }

    /// Takes a number.
    pub(super) fn take(&mut self, sender: u16, sequence: u64) {
        let window = self.0.entry(sender).or_insert(Window {
            newest: sequence,
            taken: 0,
        });
        if let Some(ahead) = sequence.checked_sub(window.newest) {
            window.taken = if ahead < u64::BITS.into() {
                window.taken << ahead
            } else {
                0
            };
            window.newest = sequence;
        }
        let age = window.newest - sequence;
        if age < u64::BITS.into() {
            window.taken |= 1 << age;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use oneiro_robots::script::Random;

    /// Compared with a set of all numbers taken so far.
    #[test]
    fn each_of_the_last_64_numbers_is_taken_once_in_any_order() {
        let mut random = Random(1);
        let (mut windows, mut all) = (Windows::default(), BTreeSet::new());
        let (mut top, mut old, mut again, mut late) = (u64::from(u32::MAX) - 500, 0, 0, 0);
        for _ in 0..20_000 {
            let back = random.below(90) as u64;
            let sequence = top + random.below(4) as u64 - back;
            top = top.max(sequence);
            let newest = all.last().copied();
            let expected = match newest {
                Some(newest) if newest >= sequence + 64 => {
                    old += 1;
                    false
                }
                _ => !all.contains(&sequence),
            };
            again += u32::from(all.contains(&sequence));
            late += u32::from(expected && newest > Some(sequence));
            assert_eq!(windows.would_take(7, sequence), expected, "{sequence} after {newest:?}");
            if expected {
                windows.take(7, sequence);
                all.insert(sequence);
            }
            if random.below(100) == 0 {
                top += random.below(200) as u64;
            }
        }
        assert!(old > 1000 && again > 1000 && late > 1000, "{old} {again} {late}");
        assert!(windows.would_take(8, 0), "another sender has numbers of its own");
    }

    #[test]
    fn numbers_at_both_ends() {
        let mut windows = Windows::default();
        windows.take(0, 0);
        assert!(!windows.would_take(0, 0) && windows.would_take(0, u64::MAX));
        windows.take(0, u64::MAX);
        assert!(!windows.would_take(0, u64::MAX) && windows.would_take(0, u64::MAX - 63));
        assert!(!windows.would_take(0, u64::MAX - 64) && !windows.would_take(0, 0));
    }
}
