//! What a call needs of its thread's stack: local arrays, and the values that no register holds.

use oneiro_shader_compiler::tree::{Op, Program, visit};
use oneiro_shader_compiler::{GREATEST_LOCAL, Trees};

use crate::share::shared;
use crate::{Error, narrow};

/// Most bytes that the local arrays of all lanes may take.
pub(crate) const ARRAYS: u64 = 1 << 18;
/// Most bytes of its thread's stack that a call may use: arrays, and as much for what no register holds.
pub(crate) const FRAME: u64 = 2 * ARRAYS;

// With the fewest lanes, whatever the compiler accepts has room.
const _: () = assert!(narrow::NUMBERS[0] as u64 * GREATEST_LOCAL as u64 <= ARRAYS);

/// Values of the longest program of which nobody counts what no register holds.
const LONG: usize = 10_000;
/// Vectors that registers hold, at most.
const REGISTERS: u64 = 32;
/// The most values that differ between lanes and are yet to be used, at any one place of a long program, besides those that registers
/// hold; 0 for a short one.
pub(crate) fn most_at_once(trees: &Trees) -> u64 {
    if trees.tidied.values.len() <= LONG {
        return 0;
    }
    let program: &Program = &shared(trees);
    let mut last = vec![0; program.values.len()];
    let mut at = 0;
    visit(&program.body, &mut |statement| {
        at += 1;
        for value in statement.operands(program) {
            last[value.0 as usize] = at;
        }
    });
    // How many there are one fewer of after each statement.
    let mut ends = vec![0; at + 1];
    let (mut at, mut now, mut most) = (0, 0_u64, 0);
    visit(&program.body, &mut |statement| {
        at += 1;
        for value in statement.results() {
            let end = last[value.0 as usize];
            let is_constant = matches!(program.op(*value), Op::Constant(_));
            if end > at && !is_constant && !trees.shapes.is_uniform(*value) {
                now += 1;
                ends[end] += 1;
            }
        }
        most = most.max(now);
        now -= ends[at];
    });
    u64::saturating_sub(most, REGISTERS)
}

/// Refuses local arrays that a stack doesn't hold.
pub(crate) fn check_arrays(trees: &Trees, lanes: u32) -> Result<(), Error> {
    let bytes = trees.array_bytes() * u64::from(lanes);
    if bytes > ARRAYS {
        Err(Error::Arrays(bytes))
    } else {
        Ok(())
    }
}
