//! A fuse: a small program on the robot itself that stops its wheels unless commands keep arriving.
//!
//! The computer sets two wanted speeds and a count. At each event the program counts down and makes the wanted speeds the motors'
//! targets; at 0 it makes the targets 0. So the wheels stop when the computer or the link is gone. The program is in the bytecode
//! of Aseba's virtual machine: a table of events and their places, then words of four bits of operation and twelve of operand.

use std::ops::Range;

/// The event that counts: 20 times a second on a Thymio II.
pub(super) const EVENT: &str = "buttons";
/// Events after which the wheels stop: 0.5 s.
const COUNT: i16 = 10;

/// Where the program's variables are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Fuse {
    /// Address of the left wheel's wanted speed; the right wheel's and the count follow.
    first: u16,
}

impl Fuse {
    /// Words of its variables.
    const WORDS: u16 = 3;

    /// The fuse of a node and its program, given the words of its memory that are free, the addresses of the motors' targets and the
    /// names of its events; none for a node that has not what it needs.
    pub(super) fn of(free: &Range<u16>, targets: [u16; 2], events: &[String]) -> Option<(Self, Vec<u16>)> {
        let event = events.iter().position(|name| name == EVENT)? as u16;
        let first = free.start;
        if free.len() < usize::from(Self::WORDS) || first + Self::WORDS > OPERAND {
            return None;
        }
        Some((Self { first }, program(targets, first, event)))
    }

    /// The words that keep the wheels at these speeds until the fuse has burnt down. The first two can be read back.
    pub(super) fn lit(self, [left, right]: [i16; 2]) -> [(u16, i16); 3] {
        [(self.first, left), (self.first + 1, right), (self.first + 2, COUNT)]
    }

    /// The words that let it burn out.
    pub(super) fn out(self) -> [(u16, i16); 3] {
        [(self.first, 0), (self.first + 1, 0), (self.first + 2, 0)]
    }
}

/// Smallest word that is too large for an operand.
const OPERAND: u16 = 1 << 12;
const STOP: u16 = 0;
const CONSTANT: u16 = 1 << 12;
const LOAD: u16 = 3 << 12;
const STORE: u16 = 4 << 12;
const SUBTRACT: u16 = 0x8003;
/// Goes on after the next word if the last value but one is greater than the last, else to the place that is the next word farther.
const BRANCH_GREATER: u16 = 0xa00c;
/// The event at the start of a program; those of the node count down from the one before.
const INIT: u16 = 0xffff;

fn program([left, right]: [u16; 2], first: u16, event: u16) -> Vec<u16> {
    let [want_left, want_right, count] = [first, first + 1, first + 2];
    let clear = |address: u16| [CONSTANT, STORE | address];
    let copy = |from: u16, to: u16| [LOAD | from, STORE | to];
    let init = [clear(count), clear(left), clear(right)].concat();
    let burning = [
        &[LOAD | count, CONSTANT | 1, SUBTRACT, STORE | count][..],
        &copy(want_left, left),
        &copy(want_right, right),
        &[STOP],
    ]
    .concat();
    let burnt = [clear(left), clear(right)].concat();
    let head = 5;
    let at_event = head + init.len() as u16 + 1;
    // From the branch, over its own two words.
    let otherwise = burning.len() as u16 + 2;
    [
        &[head, INIT, head, INIT - 1 - event, at_event][..],
        &init,
        &[STOP],
        &[LOAD | count, CONSTANT, BRANCH_GREATER, otherwise],
        &burning,
        &burnt,
        &[STOP],
    ]
    .concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A small machine for the words that are used.
    fn run(program: &[u16], event: u16, memory: &mut [i16]) {
        let table = &program[1..usize::from(program[0])];
        let place = table.chunks(2).find(|pair| pair[0] == event).unwrap()[1];
        let (mut at, mut stack) = (usize::from(place), Vec::new());
        loop {
            let (word, operand) = (program[at], program[at] & (OPERAND - 1));
            match word >> 12 {
                0 => return,
                1 => stack.push(operand as i16),
                3 => stack.push(memory[usize::from(operand)]),
                4 => memory[usize::from(operand)] = stack.pop().unwrap(),
                8 => {
                    let (last, before) = (stack.pop().unwrap(), stack.pop().unwrap());
                    assert_eq!(operand, 3);
                    stack.push(before - last);
                }
                10 => {
                    let (last, before) = (stack.pop().unwrap(), stack.pop().unwrap());
                    assert_eq!(operand, 12);
                    at += if before > last {
                        1
                    } else {
                        usize::from(program[at + 1]) - 1
                    };
                }
                other => panic!("operation {other}"),
            }
            at += 1;
        }
    }

    #[test]
    fn wheels_turn_for_ten_events_and_then_stand() {
        let program = program([2, 3], 5, 7);
        let mut memory = [9_i16; 8];
        run(&program, INIT, &mut memory);
        assert_eq!((&memory[2..4], memory[7]), (&[0, 0][..], 0));
        let fuse = Fuse { first: 5 };
        for (address, value) in fuse.lit([100, -50]) {
            memory[usize::from(address)] = value;
        }
        for event in 0..15 {
            run(&program, INIT - 1 - 7, &mut memory);
            let expected = if event < 10 { [100, -50] } else { [0, 0] };
            assert_eq!(memory[2..4], expected, "event {event}");
        }
        for (address, value) in [fuse.lit([7, 7]), fuse.out()].concat() {
            memory[usize::from(address)] = value;
        }
        run(&program, INIT - 1 - 7, &mut memory);
        assert_eq!(memory[2..4], [0, 0]);
    }
}
