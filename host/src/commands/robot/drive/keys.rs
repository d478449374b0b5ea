//! Keys of a terminal, which says when one is pressed and, while it is held, that it repeats. Nothing says that it is
//! released: a key counts as held until it has not repeated for a while.

use std::time::Duration;

/// What a key does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Action {
    /// Turns the left and the right wheel at these shares of the speed, while it is held.
    Turn([f64; 2]),
    /// Changes the speed by this share of the greatest.
    Faster(f64),
    /// Stops, until a resume.
    Stop,
    /// Allows to move again.
    Resume,
    /// Ends the program.
    Quit,
}

/// What the keys want.
#[derive(Clone, Debug, Default)]
pub(super) struct Keys {
    /// The beginning of an escape sequence.
    rest: Vec<u8>,
    /// Wheels' shares by the key that is held, when it came last, and when it counts as released.
    held: Option<([f64; 2], Duration, Duration)>,
}

impl Keys {
    /// How long a key counts as held after it is pressed: most terminals repeat it after 250 to 500 ms. Where they take
    /// longer, the wheels stop in between.
    const FIRST: Duration = Duration::from_millis(500);
    /// The same after it has repeated: terminals do so every 25 to 50 ms, and a network delays some.
    const AGAIN: Duration = Duration::from_millis(200);
    /// The same key within this time is a repetition. The longest delay that is usual is 660 ms (X11).
    const REPEATS: Duration = Duration::from_millis(700);

    /// Takes bytes of the terminal. Returns what they do at once.
    pub(super) fn press(&mut self, bytes: &[u8], now: Duration) -> Vec<Action> {
        self.rest.extend_from_slice(bytes);
        let mut actions = Vec::new();
        while let Some((action, length)) = next(&self.rest) {
            self.rest.drain(..length);
            match action {
                Some(Action::Turn(shares)) => self.hold(shares, now),
                Some(action) => {
                    // Whatever else is pressed, the one before is held no more: a terminal repeats the last one only.
                    if !matches!(action, Action::Faster(_)) {
                        self.held = None;
                    }
                    actions.push(action);
                }
                None => {}
            }
        }
        actions
    }

    fn hold(&mut self, shares: [f64; 2], now: Duration) {
        let repeats = self
            .held
            .is_some_and(|(held, last, _)| held == shares && now < last + Self::REPEATS);
        let until = now + if repeats { Self::AGAIN } else { Self::FIRST };
        self.held = Some((shares, now, until));
    }

    /// Wheels' shares of the speed by the key that is held.
    pub(super) fn shares(&self, now: Duration) -> [f64; 2] {
        match self.held {
            Some((shares, _, until)) if now < until => shares,
            _ => [0.0; 2],
        }
    }
}

/// What the first key of some bytes does, if anything, and how many bytes it has; none if it is not whole.
fn next(bytes: &[u8]) -> Option<(Option<Action>, usize)> {
    const ESCAPE: u8 = 0x1b;
    let (forwards, backwards) = (Action::Turn([1.0, 1.0]), Action::Turn([-1.0, -1.0]));
    // On the spot, half as fast: a turn is quick.
    let (left, right) = (Action::Turn([-0.5, 0.5]), Action::Turn([0.5, -0.5]));
    match bytes {
        [] | [ESCAPE] | [ESCAPE, b'[' | b'O'] => None,
        [ESCAPE, b'[' | b'O', sequence @ ..] => {
            let end = sequence.iter().position(|byte| (0x40..0x7f).contains(byte))?;
            let action = match sequence[end] {
                b'A' => Some(forwards),
                b'B' => Some(backwards),
                b'C' => Some(right),
                b'D' => Some(left),
                _ => None,
            };
            Some((action, end + 3))
        }
        [key, ..] => {
            let action = match key.to_ascii_lowercase() {
                b'w' => Some(forwards),
                b's' => Some(backwards),
                b'a' => Some(left),
                b'd' => Some(right),
                b'+' | b'=' => Some(Action::Faster(0.1)),
                b'-' | b'_' => Some(Action::Faster(-0.1)),
                b' ' => Some(Action::Stop),
                b'r' => Some(Action::Resume),
                b'q' => Some(Action::Quit),
                _ => None,
            };
            Some((action, 1))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FORWARDS: [f64; 2] = [1.0, 1.0];

    fn ms(ms: u64) -> Duration {
        Duration::from_millis(ms)
    }

    #[test]
    fn arrows_and_letters_turn_the_wheels() {
        for (keys, shares) in [
            (["w", "\x1b[A", "\x1bOA"], FORWARDS),
            (["s", "\x1b[B", "S"], [-1.0, -1.0]),
            (["a", "\x1b[D", "\x1b[1;2D"], [-0.5, 0.5]),
            (["d", "\x1b[C", "x\x1bd"], [0.5, -0.5]),
        ] {
            for bytes in keys {
                let mut keys = Keys::default();
                assert_eq!(keys.press(bytes.as_bytes(), ms(0)), []);
                assert_eq!(keys.shares(ms(1)), shares, "{bytes:?}");
            }
        }
        let mut keys = Keys::default();
        assert_eq!(keys.press(b"q r+-", ms(0)).len(), 5);
        // Home, F5 and text that somebody pastes.
        assert_eq!(keys.press(b"\x1b[H\x1b[15~xyz\xc3\xa4", ms(0)), []);
        assert_eq!(keys.shares(ms(0)), [0.0; 2]);
    }

    /// However the bytes are cut.
    #[test]
    fn sequences_may_come_in_parts() {
        let mut keys = Keys::default();
        for part in [&b"\x1b"[..], b"[", b"1;5", b"A"] {
            assert_eq!(keys.shares(ms(0)), [0.0; 2]);
            keys.press(part, ms(0));
        }
        assert_eq!(keys.shares(ms(0)), FORWARDS);
    }

    #[test]
    fn a_key_that_repeats_is_held_and_one_that_does_not_is_released() {
        let mut keys = Keys::default();
        keys.press(b"w", ms(1000));
        assert_eq!(keys.shares(ms(1499)), FORWARDS);
        assert_eq!(keys.shares(ms(1500)), [0.0; 2]);
        // A terminal with a long delay: the wheels stop until it repeats.
        for at in (1660..3000).step_by(40) {
            keys.press(b"w", ms(at));
            assert_eq!(keys.shares(ms(at + 39)), FORWARDS);
        }
        // The last one was at 2980.
        assert_eq!(keys.shares(ms(3179)), FORWARDS);
        assert_eq!(keys.shares(ms(3180)), [0.0; 2]);
        // Pressed again later, it is a first one.
        keys.press(b"w", ms(4000));
        assert_eq!(keys.shares(ms(4499)), FORWARDS);
    }

    #[test]
    fn another_key_takes_over_at_once() {
        let mut keys = Keys::default();
        keys.press(b"w", ms(0));
        keys.press(b"a", ms(100));
        assert_eq!(keys.shares(ms(100)), [-0.5, 0.5]);
        assert_eq!(keys.press(b" ", ms(150)), [Action::Stop]);
        assert_eq!(keys.shares(ms(150)), [0.0; 2]);
        keys.press(b"w", ms(200));
        assert_eq!(keys.press(b"+", ms(210)), [Action::Faster(0.1)]);
        assert_eq!(keys.shares(ms(210)), FORWARDS);
    }
}
