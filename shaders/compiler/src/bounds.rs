//! Upper bounds of the turns of a kernel's loops, known before it runs. A software driver may leave loops silently after a number
//! of turns, so whoever dispatches a kernel must know them.
//!
//! A loop counts a variable from a constant to another one, or up to an end: `for (var i = start; i < end; i++)`, with any constant
//! step. The end is computed from
//! constants and from words that the host knows: those of the uniform buffer, which it sets for each dispatch, of the
//! episode's element of `worlds`, and of other read-only buffers at indices with such a bound. It must have an upper
//! limit, so a word is written as `min(word, GREATEST)`. Any other loop is refused.
//!
//! All branches of an `if` count together, since a vector of invocations takes all of them.

use std::cell::Cell;
use std::collections::BTreeMap;

use crate::rules::Rule;
use crate::source::{Refusal, Refusals, Source};
use crate::tree::{Binary, Label, Op, Program, Statement, Ty, Value, Variable, visit};
use crate::words::blank_comments;

/// Words of buffers, by the buffer's name, the element and the word.
pub type WordOf<'a> = dyn Fn(&str, Option<u64>, u32) -> u32 + 'a;

/// A number known before a kernel runs, or one that no run exceeds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Bound {
    /// A constant.
    Constant(u64),
    /// A word of a buffer.
    Word {
        /// The buffer's name.
        buffer: String,
        /// Index of the element; `None` for the uniform buffer and for the world of the episode.
        element: Option<Box<Bound>>,
        /// Word within the element.
        word: u32,
    },
    /// The integer part of a float, given by its bits.
    Floor(Box<Bound>),
    /// `a + b`
    Sum(Box<Bound>, Box<Bound>),
    /// `a - b`, or 0
    Difference(Box<Bound>, Box<Bound>),
    /// `a * b`
    Product(Box<Bound>, Box<Bound>),
    /// `a / b`, rounded down
    Quotient(Box<Bound>, u64),
    /// `min(a, b)`
    Least(Box<Bound>, Box<Bound>),
    /// `max(a, b)`
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

    /// Its value, given words of buffers.
    pub fn value(&self, word: &WordOf<'_>) -> u64 {
        let of = |bound: &Self| bound.value(word);
        match self {
            Self::Constant(value) => *value,
            Self::Word {
                buffer,
                element,
                word: at,
            } => {
                // Kernels compute indices in 32 bits.
                let element = element.as_deref().map(|element| u64::from(of(element) as u32));
                u64::from(word(buffer, element, *at))
            }
            Self::Floor(bits) => u64::from(f32::from_bits(of(bits) as u32) as u32),
            Self::Sum(a, b) => of(a).saturating_add(of(b)),
            Self::Difference(a, b) => of(a).saturating_sub(of(b)),
            Self::Product(a, b) => of(a).saturating_mul(of(b)),
            Self::Quotient(a, b) => of(a) / b,
            Self::Least(a, b) => of(a).min(of(b)),
            Self::Greatest(a, b) => of(a).max(of(b)),
        }
    }

    /// Number of its terms.
    fn terms(&self) -> u32 {
        let of = |bound: &Self| bound.terms();
        1_u32.saturating_add(match self {
            Self::Constant(_) => 0,
            Self::Word { element, .. } => element.as_deref().map_or(0, of),
            Self::Floor(a) | Self::Quotient(a, _) => of(a),
            Self::Sum(a, b)
            | Self::Difference(a, b)
            | Self::Product(a, b)
            | Self::Least(a, b)
            | Self::Greatest(a, b) => of(a).saturating_add(of(b)),
        })
    }

    /// Whether it has a word of one of these buffers.
    fn has_word_of(&self, buffers: &[String]) -> bool {
        let of = |bound: &Self| bound.has_word_of(buffers);
        match self {
            Self::Constant(_) => false,
            Self::Word { buffer, element, .. } => buffers.contains(buffer) || element.as_deref().is_some_and(of),
            Self::Floor(a) | Self::Quotient(a, _) => of(a),
            Self::Sum(a, b)
            | Self::Difference(a, b)
            | Self::Product(a, b)
            | Self::Least(a, b)
            | Self::Greatest(a, b) => of(a) || of(b),
        }
    }

    /// An upper limit for any content of the buffers; `None` if there is none. The host sets the uniform buffer, so its words
    /// are limited.
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

    /// A Rust expression of type `u64`, in which `word` is the argument of [`Bound::value`].
    pub(crate) fn as_rust(&self) -> String {
        let call = |a: &Self, name: &str, b: &Self| format!("{}.{name}({})", a.as_rust(), b.as_rust());
        match self {
            Self::Constant(value) => format!("{value}_u64"),
            Self::Word { buffer, element, word } => {
                let element = match element {
                    Some(element) => format!("Some(u64::from({} as u32))", element.as_rust()),
                    None => "None".to_owned(),
                };
                format!("u64::from(word(\"{buffer}\", {element}, {word}))")
            }
            Self::Floor(bits) => format!("u64::from(f32::from_bits({} as u32) as u32)", bits.as_rust()),
            Self::Sum(a, b) => call(a, "saturating_add", b),
            Self::Difference(a, b) => call(a, "saturating_sub", b),
            Self::Product(a, b) => call(a, "saturating_mul", b),
            Self::Quotient(a, b) => format!("({} / {b})", a.as_rust()),
            Self::Least(a, b) => call(a, "min", b),
            Self::Greatest(a, b) => call(a, "max", b),
        }
    }
}

/// A buffer, as the host knows it.
#[derive(Clone, Debug)]
pub(crate) struct Buffer {
    pub(crate) name: String,
    /// It never changes while a kernel runs.
    pub(crate) is_constant: bool,
    pub(crate) is_uniform: bool,
}

/// An upper bound of the turns of all loops of an invocation together. The last test of a loop counts as a turn.
///
/// # Errors
/// Each loop without a bound.
pub(crate) fn turns(program: &Program, buffers: &[Buffer], source: &Source) -> Result<Bound, Refusals> {
    Ok(bounds(program, buffers, source)?.0)
}

/// The same, and of each loop by itself.
///
/// # Errors
/// Each loop without a bound.
pub(crate) fn bounds(
    program: &Program,
    buffers: &[Buffer],
    source: &Source,
) -> Result<(Bound, BTreeMap<Label, OfLoop>), Refusals> {
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
        source,
        loaded,
        counts: BTreeMap::new(),
        visits: Cell::new(MOST_VISITS),
        depth: Cell::new(0),
        functions: Vec::new(),
        loops: BTreeMap::new(),
        refusals: Vec::new(),
    };
    let bound = analysis.block(&program.body);
    if analysis.refusals.is_empty() {
        Ok((bound, analysis.loops))
    } else {
        Err(analysis.refusals)
    }
}

/// Bounds of a loop by itself, each time that it is entered.
#[derive(Clone, Debug)]
pub(crate) struct OfLoop {
    /// How often its body runs, without the last test.
    pub(crate) turns: Bound,
    /// Whether loops lie before its test: the last test also runs these.
    pub(crate) tests_by_loops: bool,
    /// Whether they differ between dispatches of one world.
    pub(crate) of_dispatch: bool,
}

/// Most visits to values in a kernel, and the longest chain of operands: far more than kernels that ship need.
const MOST_VISITS: u32 = 100_000;
const DEEPEST: u32 = 200;

struct Analysis<'a> {
    program: &'a Program,
    buffers: &'a [Buffer],
    uniforms: Vec<String>,
    source: &'a Source,
    /// Where values were loaded from: buffer, element, word.
    loaded: BTreeMap<Value, (u32, Option<Value>, u32)>,
    /// Upper bounds of the reads of counters within their loops. A read from before a loop is not among them: the counter may
    /// have held any number then.
    counts: BTreeMap<Value, Bound>,
    /// Number of values and terms of bounds that may still be visited.
    visits: Cell<u32>,
    /// Number of values that the visited one is an operand of, in a chain.
    depth: Cell<u32>,
    /// The inlined functions that enclose the current statement.
    functions: Vec<String>,
    loops: BTreeMap<Label, OfLoop>,
    refusals: Refusals,
}

/// The value of a counter before its loop.
#[derive(Clone, Copy)]
enum Start {
    /// A computed one.
    Value(Value),
    /// The initial value of its variable.
    Constant(u64),
}

/// A loop that counts up.
struct Counted {
    counter: Variable,
    /// What is added to the counter at the end of each turn.
    step: u64,
    /// The value that the counter stays below or (`or_equal`) doesn't exceed.
    end: Value,
    or_equal: bool,
}

/// How long a loop turns.
struct Limits {
    counter: Variable,
    turns: Bound,
    /// Upper bounds of the counter before the test, between the test and the counting, and in the counting.
    most: [Option<Bound>; 3],
}

/// The parts of a `for`: statements before its test, the test with those that follow it, and those that count.
struct Form<'a> {
    before_test: &'a [Statement],
    tested: &'a [Statement],
    counting: &'a [Statement],
    /// Whether it goes on.
    condition: Value,
}

impl<'a> Form<'a> {
    fn of(label: Label, body: &'a [Statement]) -> Option<Self> {
        // A `for` tests first, in the block that `continue` leaves, and counts after that block.
        let [
            Statement::Labeled {
                body: tested,
                label: next,
                function: None,
            },
            counting @ ..,
        ] = body
        else {
            return None;
        };
        let position = tested.iter().position(|statement| {
            let Statement::If { accept, reject, .. } = statement else {
                return false;
            };
            accept.is_empty() && matches!(reject.as_slice(), [Statement::Exit(left)] if *left == label)
        })?;
        let mut skips = false;
        let (before_test, tested) = tested.split_at(position);
        visit(before_test, &mut |statement| {
            skips |= matches!(statement, Statement::Exit(left) if left == next);
        });
        let Statement::If { condition, .. } = tested[0] else {
            return None;
        };
        (!skips).then_some(Self {
            before_test,
            tested,
            counting,
            condition,
        })
    }

    /// The tests that all hold if it goes on.
    fn tests(&self, program: &Program) -> Vec<Value> {
        let mut all = Vec::new();
        let mut rest = vec![self.condition];
        while let Some(test) = rest.pop() {
            match program.op(test) {
                Op::Binary(Binary::And, a, b) => rest.extend([b, a]),
                _ => all.push(test),
            }
        }
        all
    }

    /// Whether a variable is read anew for each test, and changed only where the loop counts.
    fn leaves(&self, counter: Variable, read: Value) -> bool {
        sets(self.before_test, read) && !changes(self.before_test, counter) && !changes(self.tested, counter)
    }
}

/// A comparison with its operands in the other order.
fn flipped(op: Binary) -> Binary {
    match op {
        Binary::Less => Binary::Greater,
        Binary::LessEqual => Binary::GreaterEqual,
        Binary::Greater => Binary::Less,
        Binary::GreaterEqual => Binary::LessEqual,
        other => other,
    }
}

/// What to write instead of a loop that nothing bounds, given its text.
fn instead(text: &str) -> &'static str {
    let text = blank_comments(text);
    let Some(head) = text.strip_prefix("for") else {
        return "bound it by a number, and test inside: `for (var i = 0u; i < 40u; i++) { if (condition) { .. } }`";
    };
    let head = head.split('{').next().unwrap_or_default();
    if head.contains("--") || head.contains("-=") {
        "count down from a constant to a constant, or upwards: `for (var i = 0u; i < 3u; i++)`, and use `2u - i`"
    } else {
        "write `for (var i = start; i < end; i += step)`, where `start` and `end` are constants, or `i` is a u32 and `end` has a \
         visible maximum, such as `min(x, 8u)`"
    }
}

impl Analysis<'_> {
    fn block(&mut self, block: &[Statement]) -> Bound {
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
            place: self.source.place_of(span),
            function: self.functions.last().cloned(),
            rule: Rule::LoopWithoutBound,
            message: format!(
                "this loop has no bound known before it runs; {}",
                instead(self.source.text_of(span))
            ),
        });
        Bound::Constant(0)
    }

    /// The turns of a loop and of all loops in it; `None` if nothing bounds it. `before` has the statements before it in its
    /// block.
    fn repeated(&mut self, label: Label, body: &[Statement], before: &[Statement]) -> Option<Bound> {
        let form = Form::of(label, body)?;
        let limits = self.limits(&form, before).or_else(|| self.fixed(&form, before))?;
        let Limits { counter, turns, most } = limits;
        let [test, tested, counting] = [
            (form.before_test, most[0].clone()),
            (form.tested, most[1].clone()),
            (form.counting, most[2].clone()),
        ]
        .map(|(statements, most)| {
            if let Some(most) = most {
                self.bound_reads(statements, counter, &most);
            }
            self.block(statements)
        });
        let of_loop = OfLoop {
            turns: turns.clone(),
            tests_by_loops: test != Bound::Constant(0),
            of_dispatch: turns.has_word_of(&self.uniforms),
        };
        self.loops.insert(label, of_loop);
        let tests = turns.clone().sum(Bound::Constant(1));
        let each = tested.sum(counting);
        Some(tests.clone().sum(tests.product(test)).sum(turns.product(each)))
    }

    /// The limits of a loop that counts up to an end that has a bound.
    fn limits(&self, form: &Form<'_>, before: &[Statement]) -> Option<Limits> {
        let found = self.counted(form)?;
        let mut end = self.upper(found.end)?;
        if found.or_equal {
            end = end.sum(Bound::Constant(1));
        }
        let start = self.start(found.counter, before);
        let distance = self.distance(&found, start, end.clone());
        distance.most(&self.uniforms)?;
        // Else the counter might start again from 0.
        let is_safe = |most: u64| u32::try_from(most.saturating_add(found.step)).is_ok();
        if (found.step > 1 || found.or_equal) && !end.most(&self.uniforms).is_some_and(is_safe) {
            return None;
        }
        // Once it has counted, the counter may be a step beyond its end; at the first test it may be anywhere.
        let beyond = end.clone().sum(Bound::Constant(found.step));
        let first = start.and_then(|start| match start {
            Start::Value(value) => self.upper(value),
            Start::Constant(bits) => Some(Bound::Constant(bits)),
        });
        let at_test = first.map(|first| Bound::Greatest(Box::new(beyond.clone()), Box::new(first)));
        Some(Limits {
            counter: found.counter,
            turns: distance.in_steps_of(found.step),
            most: [at_test, Some(end), Some(beyond)],
        })
    }

    /// The limits of a loop that counts from a constant to another one, up or down, with or without signs.
    fn fixed(&self, form: &Form<'_>, before: &[Statement]) -> Option<Limits> {
        form.tests(self.program).into_iter().find_map(|test| {
            let Op::Binary(op, a, b) = self.program.op(test) else {
                return None;
            };
            let (op, read, end) = match (self.program.op(a), self.program.op(b)) {
                (Op::Read(_), Op::Constant(end)) => (op, a, end),
                (Op::Constant(end), Op::Read(_)) => (flipped(op), b, end),
                _ => return None,
            };
            let Op::Read(counter) = self.program.op(read) else {
                return None;
            };
            let is_unsigned = match self.program.ty(read) {
                Ty::U32 => true,
                Ty::I32 => false,
                _ => return None,
            };
            if !form.leaves(counter, read) {
                return None;
            }
            let number = |bits: u32| {
                if is_unsigned {
                    i64::from(bits)
                } else {
                    i64::from(bits as i32)
                }
            };
            let start = match self.start(counter, before)? {
                Start::Value(value) => match self.program.op(value) {
                    Op::Constant(bits) => bits,
                    _ => return None,
                },
                Start::Constant(bits) => u32::try_from(bits).ok()?,
            };
            let (start, end) = (number(start), number(end));
            let step = match self.step(counter, form.counting)? {
                (Binary::Add, bits) => number(bits),
                (_, bits) => -number(bits),
            };
            let distance = match op {
                Binary::Less | Binary::NotEqual if step > 0 => end - start,
                Binary::LessEqual if step > 0 => end - start + 1,
                Binary::Greater | Binary::NotEqual if step < 0 => start - end,
                Binary::GreaterEqual if step < 0 => start - end + 1,
                _ => return None,
            };
            let size = step.abs();
            if op == Binary::NotEqual && (distance < 0 || distance % size != 0) {
                return None;
            }
            let turns = distance.max(0).unsigned_abs().div_ceil(size.unsigned_abs());
            // Else the counter would start again from the other end of its range.
            let last = start + i64::try_from(turns).ok()?.checked_mul(step)?;
            let is_within = if is_unsigned {
                u32::try_from(last).is_ok()
            } else {
                i32::try_from(last).is_ok()
            };
            let most = is_unsigned.then(|| Bound::Constant(start.max(last).unsigned_abs()));
            is_within.then_some(Limits {
                counter,
                turns: Bound::Constant(turns),
                most: [most.clone(), most.clone(), most],
            })
        })
    }

    /// Notes the upper bound of a counter where statements read it.
    fn bound_reads(&mut self, statements: &[Statement], counter: Variable, most: &Bound) {
        visit(statements, &mut |statement| {
            if let Statement::Let(value) = statement
                && self.program.op(*value) == Op::Read(counter)
            {
                self.counts.insert(*value, most.clone());
            }
        });
    }

    /// The value that a counter is set to just before a loop; `None` if it isn't set there.
    fn start(&self, counter: Variable, before: &[Statement]) -> Option<Start> {
        let set = before
            .iter()
            .rev()
            .find(|statement| changes(std::slice::from_ref(statement), counter));
        match set? {
            Statement::Write(_, start) => Some(Start::Value(*start)),
            Statement::Declare(_) => {
                let init = self.program.variables[counter.0 as usize].init;
                Some(Start::Constant(u64::from(init)))
            }
            _ => None,
        }
    }

    /// The distance that a counter covers: from its value just before the loop, or from 0, to its end.
    fn distance(&self, found: &Counted, start: Option<Start>, end: Bound) -> Bound {
        let start = start.and_then(|start| match start {
            Start::Value(value) => self.exact(value),
            Start::Constant(bits) => Some(Bound::Constant(bits)),
        });
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
            // A sum may wrap around.
            _ => end,
        }
    }

    /// Finds how a loop counts.
    fn counted(&self, form: &Form<'_>) -> Option<Counted> {
        form.tests(self.program).into_iter().find_map(|test| {
            let (small, end, or_equal) = match self.program.op(test) {
                Op::Binary(Binary::Less, a, b) | Op::Binary(Binary::Greater, b, a) => (a, b, false),
                Op::Binary(Binary::LessEqual, a, b) | Op::Binary(Binary::GreaterEqual, b, a) => (a, b, true),
                _ => return None,
            };
            let Op::Read(counter) = self.program.op(small) else {
                return None;
            };
            let (Binary::Add, step) = self.step(counter, form.counting)? else {
                return None;
            };
            let counts = self.program.ty(small) == Ty::U32 && form.leaves(counter, small);
            counts.then_some(Counted {
                counter,
                step: u64::from(step),
                end,
                or_equal,
            })
        })
    }

    /// What is added to a variable, or subtracted from it, at the end of each turn, if nothing else happens to it there.
    fn step(&self, counter: Variable, counting: &[Statement]) -> Option<(Binary, u32)> {
        let mut step = None;
        for (at, statement) in counting.iter().enumerate() {
            match statement {
                Statement::Write(variable, value) if *variable == counter => {
                    let Op::Binary(op @ (Binary::Add | Binary::Subtract), old, by) = self.program.op(*value) else {
                        return None;
                    };
                    let (Op::Read(read), Op::Constant(bits)) = (self.program.op(old), self.program.op(by)) else {
                        return None;
                    };
                    if read != counter || bits == 0 || step.is_some() || !sets(&counting[..at], old) {
                        return None;
                    }
                    step = Some((op, bits));
                }
                statement if changes(std::slice::from_ref(statement), counter) => return None,
                _ => {}
            }
        }
        step
    }

    /// Visits an operand. An end that is computed from shared values, each from the one before twice, would take forever, and
    /// a chain of thousands would overflow the stack.
    fn visited<T>(&self, visit: impl FnOnce() -> Option<T>) -> Option<T> {
        self.charge(1)?;
        let depth = self.depth.get();
        if depth == DEEPEST {
            return None;
        }
        self.depth.set(depth + 1);
        let found = visit();
        self.depth.set(depth);
        found
    }

    fn charge(&self, visits: u32) -> Option<()> {
        self.visits.set(self.visits.get().checked_sub(visits)?);
        Some(())
    }

    /// A value, if it is known before the kernel runs.
    fn exact(&self, value: Value) -> Option<Bound> {
        self.visited(|| self.exact_unless_deep(value))
    }

    fn exact_unless_deep(&self, value: Value) -> Option<Bound> {
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
                Some(match (self.exact(a)?, self.exact(b)?) {
                    (Bound::Constant(a), Bound::Constant(b)) => {
                        Bound::Constant(u64::from((a as u32).wrapping_add(b as u32)))
                    }
                    (a, b) => a.sum(b),
                })
            }
            _ => None,
        }
    }

    /// An upper bound of a value.
    fn upper(&self, value: Value) -> Option<Bound> {
        if self.program.ty(value) != Ty::U32 {
            return None;
        }
        self.visited(|| self.upper_unless_deep(value))
    }

    fn upper_unless_deep(&self, value: Value) -> Option<Bound> {
        match self.program.op(value) {
            Op::Read(_) => {
                let count = self.counts.get(&value)?;
                self.charge(count.terms())?;
                Some(count.clone())
            }
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
                    // A result that wraps around is less.
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

/// Whether one of these statements computes a value.
fn sets(statements: &[Statement], value: Value) -> bool {
    statements.iter().any(|statement| statement.results().contains(&value))
}
