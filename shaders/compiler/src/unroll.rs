//! Writes turns of loops one after another, so that the loops themselves turn less often. Mesa's software driver leaves all loops of an
//! invocation after a number of turns in total, and unrolled turns don't count.

use std::collections::{BTreeMap, BTreeSet};

use crate::assemble::{dissolve_all, leaves};
use crate::bounds::{OfLoop, WordOf};
use crate::tidy::rename;
use crate::tree::{Block, Label, Program, Statement, Value, visit};

/// The most statements that a kernel may have after its loops are unrolled. At this size drivers already take seconds to compile it.
const LONGEST: u64 = 60_000;

/// Turns of a loop.
#[derive(Clone, Copy)]
pub(crate) struct Turns {
    /// At most, each time that it is entered, in two cases.
    most: [u64; 2],
    /// Whether the last test also runs the loops in it.
    tests_by_loops: bool,
    /// Whether there may be more in another dispatch, so that it stays a loop.
    of_dispatch: bool,
}

/// The turns of loops in two cases, which are given by words of buffers.
pub(crate) fn turns(loops: &BTreeMap<Label, OfLoop>, cases: [&WordOf<'_>; 2]) -> BTreeMap<Label, Turns> {
    let turns = |of_loop: &OfLoop| Turns {
        most: cases.map(|word| of_loop.turns.value(word)),
        tests_by_loops: of_loop.tests_by_loops,
        of_dispatch: of_loop.of_dispatch,
    };
    loops.iter().map(|(label, of_loop)| (*label, turns(of_loop))).collect()
}

/// A program whose loops are unrolled.
pub(crate) struct Unrolled {
    pub(crate) program: Program,
    /// Most turns of all loops, in the two cases.
    pub(crate) turns: [u64; 2],
}

/// Unrolls loops, those first that gain the most for their length, until all of them turn at most `most` times in both cases. `None` if
/// the program would get too long.
pub(crate) fn unroll(program: &Program, loops: &BTreeMap<Label, Turns>, most: u64) -> Option<Unrolled> {
    let mut plan = Plan::new(program, loops);
    while plan.sizes().greatest() > most {
        plan.unroll_one()?;
    }
    let mut unrolled = program.clone();
    let mut body = std::mem::take(&mut unrolled.body);
    plan.apply(&mut unrolled, &mut body);
    unrolled.body = body;
    Some(Unrolled {
        program: unrolled,
        turns: plan.sizes().turns,
    })
}

/// A loop, or a block that becomes one which doesn't turn again.
struct Piece {
    label: Label,
    /// None of such a block.
    turns: Option<Turns>,
    /// Whether no loop is left if all turns are written out.
    can_vanish: bool,
    /// Turns to write one after another.
    written: u64,
    /// Statements, without those of inner pieces.
    statements: u64,
    inner: Vec<usize>,
}

impl Piece {
    /// Most turns that can be written out, if any can.
    fn most(&self) -> u64 {
        match self.turns {
            Some(turns) if !turns.of_dispatch => turns.most[0].max(turns.most[1]) + u64::from(!self.can_vanish),
            _ => 0,
        }
    }

    /// Values of one execution, given those of its inner pieces.
    fn sizes(&self, inner: Sizes) -> Sizes {
        let Some(turns) = self.turns else {
            return Sizes {
                turns: inner.turns.map(|turns| turns.saturating_add(1)),
                statements: self.statements + inner.statements,
            };
        };
        let has_vanished = self.can_vanish && self.written >= self.most();
        let of_case = |case: usize| {
            let most = turns.most[case];
            let turns_alone = if has_vanished { 0 } else { most / self.written + 1 };
            let entered = most.saturating_add(u64::from(turns.tests_by_loops));
            turns_alone.saturating_add(entered.saturating_mul(inner.turns[case]))
        };
        Sizes {
            turns: [of_case(0), of_case(1)],
            statements: self.written.saturating_mul(self.statements + inner.statements),
        }
    }
}

/// Turns of all loops, in both cases, and statements.
#[derive(Clone, Copy, Default)]
struct Sizes {
    turns: [u64; 2],
    statements: u64,
}

impl Sizes {
    fn plus(self, other: Self) -> Self {
        Self {
            turns: [0, 1].map(|case| self.turns[case].saturating_add(other.turns[case])),
            statements: self.statements.saturating_add(other.statements),
        }
    }

    fn greatest(self) -> u64 {
        self.turns[0].max(self.turns[1])
    }
}

#[derive(Default)]
struct Plan {
    /// Each after those within it.
    pieces: Vec<Piece>,
    outermost: Vec<usize>,
}

impl Plan {
    fn new(program: &Program, loops: &BTreeMap<Label, Turns>) -> Self {
        let mut vanishing = BTreeSet::new();
        visit(&program.body, &mut |statement| {
            if let Statement::Loop { label, body, .. } = statement
                && !loops[label].of_dispatch
                && turn_as_branch(*label, body).is_some()
            {
                vanishing.insert(*label);
            }
        });
        let mut body = program.body.clone();
        dissolve_all(&mut body);
        let mut plan = Self::default();
        (_, plan.outermost) = plan.gather(&body, loops, &vanishing);
        plan
    }

    /// Adds the pieces of a block. Returns the number of its other statements, and its pieces.
    fn gather(
        &mut self,
        block: &Block,
        loops: &BTreeMap<Label, Turns>,
        vanishing: &BTreeSet<Label>,
    ) -> (u64, Vec<usize>) {
        let (mut statements, mut pieces) = (0, Vec::new());
        for statement in block {
            let mut count = 1;
            let mut inner = Vec::new();
            for block in statement.blocks() {
                let (more, mut within) = self.gather(block, loops, vanishing);
                count += more;
                inner.append(&mut within);
            }
            let (label, turns) = match statement {
                Statement::Loop { label, .. } => (*label, Some(loops[label])),
                Statement::Labeled { label, body, .. } if leaves(body, *label) => (*label, None),
                _ => {
                    statements += count;
                    pieces.append(&mut inner);
                    continue;
                }
            };
            pieces.push(self.pieces.len());
            self.pieces.push(Piece {
                label,
                turns,
                can_vanish: vanishing.contains(&label),
                written: 1,
                statements: count,
                inner,
            });
        }
        (statements, pieces)
    }

    /// Those of the program, apart from its statements in no piece.
    fn sizes(&self) -> Sizes {
        let mut all: Vec<Sizes> = Vec::with_capacity(self.pieces.len());
        let sum = |all: &[Sizes], pieces: &[usize]| pieces.iter().fold(Sizes::default(), |sum, at| sum.plus(all[*at]));
        for piece in &self.pieces {
            all.push(piece.sizes(sum(&all, &piece.inner)));
        }
        sum(&all, &self.outermost)
    }

    /// Unrolls the loop further that then saves most turns for each statement more.
    fn unroll_one(&mut self) -> Option<()> {
        let before = self.sizes();
        let mut best: Option<(f64, usize, u64)> = None;
        for at in 0..self.pieces.len() {
            let (written, most) = (self.pieces[at].written, self.pieces[at].most());
            if written >= most {
                continue;
            }
            for next in [most.min(2 * written), most] {
                self.pieces[at].written = next;
                let after = self.sizes();
                let saved = before.greatest().saturating_sub(after.greatest());
                let gain = saved as f64 / (after.statements - before.statements).max(1) as f64;
                if saved > 0 && after.statements <= LONGEST && best.is_none_or(|(most, ..)| gain > most) {
                    best = Some((gain, at, next));
                }
            }
            self.pieces[at].written = written;
        }
        let (_, at, next) = best?;
        self.pieces[at].written = next;
        Some(())
    }

    /// Unrolls the loops of a block.
    fn apply(&self, program: &mut Program, block: &mut Block) {
        for mut statement in std::mem::take(block) {
            statement.blocks_mut().for_each(|inner| self.apply(program, inner));
            let Statement::Loop { label, body, span } = statement else {
                block.push(statement);
                continue;
            };
            let piece = self.pieces.iter().find(|piece| piece.label == label);
            let written = piece.map_or(1, |piece| piece.written);
            let vanishes = piece.is_some_and(|piece| piece.can_vanish && written >= piece.most());
            match turn_as_branch(label, &body) {
                Some(turn) if vanishes => {
                    for _ in 0..written {
                        block.append(&mut Copy::of(program, &turn));
                    }
                }
                _ => {
                    let copies: Vec<_> = (1..written).map(|_| Copy::of(program, &body)).collect();
                    let body = std::iter::once(body).chain(copies).flatten().collect();
                    block.push(Statement::Loop { label, body, span });
                }
            }
        }
    }
}

/// A turn of a loop that only its test ends, as a branch: `if test { turn }`. A test that has failed fails again, since it has no effects
/// and nothing happens between.
fn turn_as_branch(label: Label, body: &Block) -> Option<Block> {
    let [
        Statement::Labeled {
            label: next,
            body: tested,
            function: None,
        },
        counting @ ..,
    ] = body.as_slice()
    else {
        return None;
    };
    let at = tested
        .iter()
        .position(|statement| !matches!(statement, Statement::Let(_) | Statement::Load { .. }))?;
    let (test, rest) = (&tested[..at], &tested[at + 1..]);
    let Statement::If {
        condition,
        accept,
        reject,
    } = &tested[at]
    else {
        return None;
    };
    let tests = accept.is_empty() && matches!(reject.as_slice(), [Statement::Exit(left)] if *left == label);
    if !tests || leaves(rest, label) || leaves(counting, label) {
        return None;
    }
    let mut turn = vec![Statement::Labeled {
        label: *next,
        body: rest.to_vec(),
        function: None,
    }];
    turn.extend_from_slice(counting);
    let mut all = test.to_vec();
    all.push(Statement::If {
        condition: *condition,
        accept: turn,
        reject: Vec::new(),
    });
    Some(all)
}

/// A copy of statements, with new values and labels.
struct Copy<'a> {
    program: &'a mut Program,
    values: BTreeMap<Value, Value>,
    labels: BTreeMap<Label, Label>,
}

impl<'a> Copy<'a> {
    fn of(program: &'a mut Program, block: &Block) -> Block {
        let mut copy = Self {
            program,
            values: BTreeMap::new(),
            labels: BTreeMap::new(),
        };
        copy.name(block);
        copy.block(block)
    }

    /// Names what the statements set.
    fn name(&mut self, block: &Block) {
        visit(block, &mut |statement| {
            for value in statement.results() {
                let node = self.program.values[value.0 as usize].clone();
                self.program.values.push(node);
                let new = Value(self.program.values.len() as u32 - 1);
                self.values.insert(*value, new);
            }
            if let Statement::Loop { label, .. } | Statement::Labeled { label, .. } = statement {
                self.labels.insert(*label, Label(self.program.labels));
                self.program.labels += 1;
            }
        });
    }

    fn block(&mut self, block: &Block) -> Block {
        block.iter().map(|statement| self.statement(statement)).collect()
    }

    fn statement(&mut self, statement: &Statement) -> Statement {
        let mut copy = statement.clone();
        match &mut copy {
            Statement::Let(value) => *value = self.values[value],
            Statement::Load { targets, .. } => targets.iter_mut().for_each(|target| *target = self.values[target]),
            Statement::Exit(label) | Statement::Loop { label, .. } | Statement::Labeled { label, .. } => {
                *label = self.label(*label);
            }
            _ => {}
        }
        let values = &self.values;
        rename(self.program, &mut copy, &|value| {
            values.get(&value).copied().unwrap_or(value)
        });
        for inner in copy.blocks_mut() {
            *inner = self.block(inner);
        }
        copy
    }

    fn label(&self, label: Label) -> Label {
        self.labels.get(&label).copied().unwrap_or(label)
    }
}
