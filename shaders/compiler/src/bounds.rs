//! How often a kernel's loops turn at the most, before it runs. A software driver may leave loops silently after so
//! many turns, so whoever dispatches a kernel must know.
//!
//! A loop counts a variable up to an end: `for (var i = start; i < end; i++)`, with any step. The end is built from
//! constants and from words that the host knows: of the uniform buffer, which it chooses for a dispatch, of the
//! rollout's element of `worlds`, and of other read-only buffers at places that are known so. It must have a greatest
//! value, so a word is written as `min(word, GREATEST)`. A loop that is anything else is refused.
//!
//! All branches of an `if` count together, since a vector of invocations takes all of them.

use std::collections::BTreeMap;

use crate::source::{Place, Refusal, Refusals};
use crate::tree::{Binary, Block, Label, Op, Program, Statement, Ty, Value, Variable, visit};

/// A number that is known before a kernel runs, or that no run exceeds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Bound {
    /// A constant.
    Constant(u64),
    /// A word of a buffer.
    Word {
        /// The buffer's name.
        buffer: String,
        /// Which element; none for the uniform buffer and for the world in which a rollout lives.
        element: Option<Box<Bound>>,
        /// Word within the element.
        word: u32,
    },
    /// The whole number below a float, of which the bits are given.
    Floor(Box<Bound>),
    /// `a + b`
    Sum(Box<Bound>, Box<Bound>),
    /// `a - b`, or 0
    Difference(Box<Bound>, Box<Bound>),
    /// `a * b`
    Product(Box<Bound>, Box<Bound>),
    /// `a / b`, rounded down
    Quotient(Box<Bound>, u64),
    /// The lesser one.
    Least(Box<Bound>, Box<Bound>),
    /// The greater one.
    Greatest(Box<Bound>, Box<Bound>),
}

impl Bound {
    fn sum(self, other: Self) -> Self {
        match (self, other) {
            (Self::Constant(a), Self::Constant(b)) => Self::Constant(a.saturating_add(b)),
            (Self::Constant(0), bound) | (bound, Self::Constant(0)) => bound,
            // Constants come last and together.
            (Self::Sum(a, b), Self::Constant(c)) if matches!(*b, Self::Constant(_)) => {
                Self::Sum(a, Box::new(b.sum(Self::Constant(c))))
            }
            (Self::Constant(c), other) => other.sum(Self::Constant(c)),
            (Self::Sum(a, b), other) if matches!(*b, Self::Constant(_)) => a.sum(other).sum(*b),
            (a, b) => Self::Sum(Box::new(a), Box::new(b)),
        }
    }

    fn product(self, other: Self) -> Self {
        match (self, other) {
            (Self::Constant(a), Self::Constant(b)) => Self::Constant(a.saturating_mul(b)),
            (Self::Constant(0), _) | (_, Self::Constant(0)) => Self::Constant(0),
            (Self::Constant(1), bound) | (bound, Self::Constant(1)) => bound,
            (a, b) => Self::Product(Box::new(a), Box::new(b)),
        }
    }

    fn less(self, other: Self) -> Self {
        match (self, other) {
            (Self::Constant(a), Self::Constant(b)) => Self::Constant(a.saturating_sub(b)),
            (bound, Self::Constant(0)) => bound,
            (a, b) => Self::Difference(Box::new(a), Box::new(b)),
        }
    }

    /// The quotient, rounded up.
    fn in_steps_of(self, step: u64) -> Self {
        match self {
            bound if step == 1 => bound,
            Self::Constant(a) => Self::Constant(a.div_ceil(step)),
            bound => Self::Quotient(Box::new(bound.sum(Self::Constant(step - 1))), step),
        }
    }

    /// Its value, given words of buffers by the buffer's name, the element and the word.
    pub fn value(&self, word: &dyn Fn(&str, Option<u64>, u32) -> u32) -> u64 {
        let of = |bound: &Self| bound.value(word);
        match self {
            Self::Constant(value) => *value,
            Self::Word {
                buffer,
                element,
                word: at,
            } => u64::from(word(buffer, element.as_deref().map(of), *at)),
            Self::Floor(bits) => f32::from_bits(of(bits) as u32) as u64,
            Self::Sum(a, b) => of(a).saturating_add(of(b)),
            Self::Difference(a, b) => of(a).saturating_sub(of(b)),
            Self::Product(a, b) => of(a).saturating_mul(of(b)),
            Self::Quotient(a, b) => of(a) / b,
            Self::Least(a, b) => of(a).min(of(b)),
            Self::Greatest(a, b) => of(a).max(of(b)),
        }
    }

    /// What it never exceeds whatever the buffers hold; none if it may be anything. The host chooses what stands in
    /// the uniform buffer.
    fn most(&self, uniforms: &[String]) -> Option<u64> {
        let of = |bound: &Self| bound.most(uniforms);
        match self {
            Self::Constant(value) => Some(*value),
            Self::Word { buffer, .. } => uniforms.contains(buffer).then_some(u64::from(u32::MAX)),
            Self::Floor(_) => None,
            Self::Sum(a, b) => Some(of(a)?.saturating_add(of(b)?)),
            Self::Difference(a, _) => of(a),
            Self::Product(a, b) => Some(of(a)?.saturating_mul(of(b)?)),
            Self::Quotient(a, b) => Some(of(a)? / b),
            Self::Least(a, b) => match (of(a), of(b)) {
                (Some(a), Some(b)) => Some(a.min(b)),
                (a, b) => a.or(b),
            },
            Self::Greatest(a, b) => Some(of(a)?.max(of(b)?)),
        }
    }

    /// As a Rust expression of type `u64`, in which `word` is what [`Bound::value`] takes.
    pub(crate) fn as_rust(&self) -> String {
        let call = |a: &Self, name: &str, b: &Self| format!("{}.{name}({})", a.as_rust(), b.as_rust());
        match self {
            Self::Constant(value) => format!("{value}_u64"),
            Self::Word { buffer, element, word } => {
                let element = match element {
                    Some(element) => format!("Some({})", element.as_rust()),
                    None => "None".to_owned(),
                };
                format!("u64::from(word(\"{buffer}\", {element}, {word}))")
            }
            Self::Floor(bits) => format!("(f32::from_bits({} as u32) as u64)", bits.as_rust()),
            Self::Sum(a, b) => call(a, "saturating_add", b),
            Self::Difference(a, b) => call(a, "saturating_sub", b),
            Self::Product(a, b) => call(a, "saturating_mul", b),
            Self::Quotient(a, b) => format!("({} / {b})", a.as_rust()),
            Self::Least(a, b) => call(a, "min", b),
            Self::Greatest(a, b) => call(a, "max", b),
        }
    }
}

/// What the host can know of a buffer.
#[derive(Clone, Debug)]
pub(crate) struct Buffer {
    pub(crate) name: String,
    /// It never changes while a kernel runs.
    pub(crate) is_constant: bool,
    pub(crate) is_uniform: bool,
}

/// The most turns of all loops of an invocation together. A loop's last look at its condition is a turn.
///
/// # Errors
/// Each loop without a bound.
pub(crate) fn turns(
    program: &Program,
    buffers: &[Buffer],
    place: &dyn Fn(naga::Span) -> Place,
) -> Result<Bound, Refusals> {
    let mut loaded = BTreeMap::new();
    visit(&program.body, &mut |statement| {
        if let Statement::Load { targets, address } = statement {
            for (word, target) in (0..).zip(targets) {
                loaded.insert(*target, (address.buffer, address.element, address.offset + word));
            }
        }
    });
    let mut analysis = Analysis {
        program,
        buffers,
        uniforms: buffers
            .iter()
            .filter(|buffer| buffer.is_uniform)
            .map(|buffer| buffer.name.clone())
            .collect(),
        place,
        loaded,
        counters: BTreeMap::new(),
        functions: Vec::new(),
        refusals: Vec::new(),
    };
    let bound = analysis.block(&program.body);
    if analysis.refusals.is_empty() {
        Ok(bound)
    } else {
        Err(analysis.refusals)
    }
}

struct Analysis<'a> {
    program: &'a Program,
    buffers: &'a [Buffer],
    uniforms: Vec<String>,
    place: &'a dyn Fn(naga::Span) -> Place,
    /// Where values were loaded from: buffer, element, word.
    loaded: BTreeMap<Value, (u32, Option<Value>, u32)>,
    /// What the counters of the enclosing loops don't exceed.
    counters: BTreeMap<Variable, Bound>,
    /// The inlined functions that enclose what is looked at.
    functions: Vec<String>,
    refusals: Refusals,
}

/// A loop that counts: its counter, the counter's step, the value that it stays below or (`or_equal`) does not exceed,
/// and how many statements of its body come before the test.
struct Counted {
    counter: Variable,
    step: u64,
    end: Value,
    or_equal: bool,
    before_test: usize,
}

impl Analysis<'_> {
    fn block(&mut self, block: &Block) -> Bound {
        let mut all = Bound::Constant(0);
        for (at, statement) in block.iter().enumerate() {
            let turns = match statement {
                Statement::Loop { label, body, span } => match self.repeated(*label, body, &block[..at]) {
                    Some(turns) => turns,
                    None => self.refuse(*span),
                },
                Statement::Labeled { body, function, .. } => {
                    self.functions.extend(function.clone());
                    let turns = self.block(body);
                    if function.is_some() {
                        self.functions.pop();
                    }
                    turns
                }
                Statement::If { accept, reject, .. } => self.block(accept).sum(self.block(reject)),
                _ => Bound::Constant(0),
            };
            all = all.sum(turns);
        }
        all
    }

    fn refuse(&mut self, span: naga::Span) -> Bound {
        self.refusals.push(Refusal {
            place: (self.place)(span),
            function: self.functions.last().cloned(),
            message:
                "nothing known beforehand bounds this loop; write `for (var i = 0u; i < end; i++)`, where `end` is a \
                      constant or `min(value, GREATEST)` of a value of the world and a constant"
                    .into(),
        });
        Bound::Constant(0)
    }

    /// The turns of a loop and of all loops in it; none if nothing bounds it. `before` is what comes before it in its
    /// block.
    fn repeated(&mut self, label: Label, body: &Block, before: &[Statement]) -> Option<Bound> {
        let found = self.counted(label, body)?;
        let mut end = self.upper(found.end)?;
        if found.or_equal {
            end = end.sum(Bound::Constant(1));
        }
        let ways = self.way(found.counter, &found, end.clone(), before);
        ways.most(&self.uniforms)?;
        // Else the counter might start again from 0.
        let is_safe = |most: u64| u32::try_from(most + found.step).is_ok();
        if (found.step > 1 || found.or_equal) && !end.most(&self.uniforms).is_some_and(is_safe) {
            return None;
        }
        let turns = ways.in_steps_of(found.step);
        self.counters.insert(found.counter, end);
        let (test, rest) = split(body, found.before_test);
        let [test, rest] = [test, rest].map(|block| self.block(&block));
        self.counters.remove(&found.counter);
        let looks = turns.clone().sum(Bound::Constant(1));
        Some(looks.clone().sum(looks.product(test)).sum(turns.product(rest)))
    }

    /// How far a counter goes: from what it is set to just before the loop, or from 0, to its end.
    fn way(&self, counter: Variable, found: &Counted, end: Bound, before: &[Statement]) -> Bound {
        let set = before
            .iter()
            .rev()
            .find(|statement| changes(std::slice::from_ref(statement), counter));
        let start = match set {
            Some(Statement::Write(_, start)) => self.exact(*start),
            Some(Statement::Declare(_)) => {
                let init = self.program.variables[counter.0 as usize].init;
                Some(Bound::Constant(u64::from(init)))
            }
            _ => None,
        };
        let Some(known) = start else { return end };
        // From `start` to `start + count`.
        if let Op::Binary(Binary::Add, a, b) = self.program.op(found.end)
            && !found.or_equal
        {
            for (one, other) in [(a, b), (b, a)] {
                if self.exact(one).as_ref() == Some(&known)
                    && let Some(count) = self.upper(other)
                {
                    return count;
                }
            }
        }
        match known {
            Bound::Constant(_) | Bound::Word { .. } => end.less(known),
            // A sum may be too large for a word.
            _ => end,
        }
    }

    /// Finds how a loop counts.
    fn counted(&self, label: Label, body: &Block) -> Option<Counted> {
        // A `for` tests first, in the block that `continue` leaves, and counts after that block.
        let [
            Statement::Labeled {
                body: tested,
                label: next,
                function: None,
            },
            counting @ ..,
        ] = body.as_slice()
        else {
            return None;
        };
        let before_test = tested.iter().position(|statement| {
            let Statement::If { accept, reject, .. } = statement else {
                return false;
            };
            accept.is_empty() && matches!(reject.as_slice(), [Statement::Exit(left)] if *left == label)
        })?;
        let mut skips = false;
        visit(&tested[..before_test], &mut |statement| {
            skips |= matches!(statement, Statement::Exit(left) if left == next);
        });
        let Statement::If { condition, .. } = &tested[before_test] else {
            return None;
        };
        if skips {
            return None;
        }
        let mut tests = vec![*condition];
        while let Some(test) = tests.pop() {
            let (small, large, or_equal) = match self.program.op(test) {
                Op::Binary(Binary::And, a, b) => {
                    tests.extend([b, a]);
                    continue;
                }
                Op::Binary(Binary::Less, a, b) | Op::Binary(Binary::Greater, b, a) => (a, b, false),
                Op::Binary(Binary::LessEqual, a, b) | Op::Binary(Binary::GreaterEqual, b, a) => (a, b, true),
                _ => continue,
            };
            let Op::Read(counter) = self.program.op(small) else {
                continue;
            };
            let step = self.step(counter, counting);
            if let Some(step) = step
                && self.program.ty(small) == Ty::U32
                && !changes(tested, counter)
            {
                return Some(Counted {
                    counter,
                    step,
                    end: large,
                    or_equal,
                    before_test,
                });
            }
        }
        None
    }

    /// By how much a variable grows at the end of each turn, if that is all that happens to it there.
    fn step(&self, counter: Variable, counting: &[Statement]) -> Option<u64> {
        let mut step = None;
        for statement in counting {
            match statement {
                Statement::Write(variable, value) if *variable == counter => {
                    let Op::Binary(Binary::Add, old, added) = self.program.op(*value) else {
                        return None;
                    };
                    let (Op::Read(read), Op::Constant(bits)) = (self.program.op(old), self.program.op(added)) else {
                        return None;
                    };
                    if read != counter || bits == 0 || step.is_some() {
                        return None;
                    }
                    step = Some(u64::from(bits));
                }
                statement if changes(std::slice::from_ref(statement), counter) => return None,
                _ => {}
            }
        }
        step
    }

    /// What a value is, if that is known before the kernel runs.
    fn exact(&self, value: Value) -> Option<Bound> {
        match self.program.op(value) {
            Op::Constant(bits) => Some(Bound::Constant(u64::from(bits))),
            Op::Loaded => {
                let (buffer, element, word) = *self.loaded.get(&value)?;
                let buffer = &self.buffers[buffer as usize];
                if !buffer.is_constant {
                    return None;
                }
                let element = match element {
                    Some(element) if buffer.name != "worlds" => Some(Box::new(self.exact(element)?)),
                    _ => None,
                };
                Some(Bound::Word {
                    buffer: buffer.name.clone(),
                    element,
                    word,
                })
            }
            Op::Bitcast(inner) => self.exact(inner),
            Op::Convert(inner) if self.program.ty(inner) == Ty::F32 && self.program.ty(value) == Ty::U32 => {
                Some(Bound::Floor(Box::new(self.exact(inner)?)))
            }
            Op::Binary(Binary::Add, a, b) if self.program.ty(value) == Ty::U32 => {
                Some(self.exact(a)?.sum(self.exact(b)?))
            }
            _ => None,
        }
    }

    /// What a value does not exceed.
    fn upper(&self, value: Value) -> Option<Bound> {
        if self.program.ty(value) != Ty::U32 {
            return None;
        }
        match self.program.op(value) {
            Op::Read(variable) => self.counters.get(&variable).cloned(),
            Op::Binary(op, a, b) => {
                let (known_a, known_b) = (self.upper(a), self.upper(b));
                match op {
                    Binary::Min => match (known_a, known_b) {
                        (Some(a), Some(b)) => Some(Bound::Least(Box::new(a), Box::new(b))),
                        (a, b) => a.or(b),
                    },
                    Binary::Max => Some(Bound::Greatest(Box::new(known_a?), Box::new(known_b?))),
                    Binary::And => match (self.program.op(a), self.program.op(b)) {
                        (Op::Constant(mask), _) | (_, Op::Constant(mask)) => Some(Bound::Constant(u64::from(mask))),
                        _ => None,
                    },
                    Binary::Remainder => match self.program.op(b) {
                        Op::Constant(by) if by > 0 => Some(Bound::Constant(u64::from(by) - 1)),
                        _ => None,
                    },
                    Binary::Divide => match self.program.op(b) {
                        Op::Constant(by) if by > 0 => Some(Bound::Quotient(Box::new(known_a?), u64::from(by))),
                        _ => None,
                    },
                    // Those that are too large for a word come out less.
                    Binary::Add => Some(known_a?.sum(known_b?)),
                    Binary::Multiply => Some(known_a?.product(known_b?)),
                    _ => None,
                }
            }
            Op::Select { accept, reject, .. } => Some(Bound::Greatest(
                Box::new(self.upper(accept)?),
                Box::new(self.upper(reject)?),
            )),
            _ => self.exact(value),
        }
    }
}

/// Whether statements write a variable or begin it anew.
fn changes(statements: &[Statement], variable: Variable) -> bool {
    let mut changes = false;
    visit(statements, &mut |statement| {
        changes |= match statement {
            Statement::Write(written, _) | Statement::Declare(written) => *written == variable,
            _ => false,
        };
    });
    changes
}

/// A loop's body in two: what is done at each look at its condition, and the rest.
fn split(body: &Block, before_test: usize) -> (Block, Block) {
    let [
        Statement::Labeled {
            label,
            body: tested,
            function,
        },
        rest @ ..,
    ] = body.as_slice()
    else {
        return (body.clone(), Vec::new());
    };
    let after = Statement::Labeled {
        label: *label,
        body: tested[before_test..].to_vec(),
        function: function.clone(),
    };
    let rest = std::iter::once(after).chain(rest.iter().cloned()).collect();
    (tested[..before_test].to_vec(), rest)
}
