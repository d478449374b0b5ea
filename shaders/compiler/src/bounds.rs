//! Upper bounds of the turns of a kernel's loops, known before it runs. A software driver may leave loops silently after a number
//! of turns, so whoever dispatches a kernel must know them.
//!
//! A loop counts a variable from a constant to another one, or up to an end: `for (var i = start; i < end; i++)`, with any constant
//! step. A `while` or `loop` counts alike if each of its turns steps once and tests. The end is computed from
//! constants and from words that the host knows: those of the uniform buffer, which it sets for each dispatch, of the
//! episode's element of `worlds`, and of other read-only buffers at indices with such a bound. It must have an upper
//! limit, so a word is written as `min(word, GREATEST)`. Any other loop is refused.
//!
//! All branches of an `if` count together, since a vector of invocations takes all of them.

use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};

use crate::assemble::leaves;
use crate::rules::Rule;
use crate::source::{Refusal, Refusals, Source};
use crate::tree::{Binary, Label, Op, Program, Statement, Ty, Unary, Value, Variable, visit};
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
        before: Vec::new(),
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
/// Most turns of a loop that counts in floats: they are counted one by one.
const MOST_TURNS_OF_FLOAT: u64 = 100_000;

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
    /// The statements before the current one in each block around it, up to the loop around it.
    before: Vec<&'a [Statement]>,
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

/// How a test bounds a loop.
struct Counted {
    counter: Variable,
    /// What is added to the counter, or subtracted from it, once in each turn.
    step: (Binary, u32),
    /// Where in a turn.
    at: usize,
    /// Whether that is before the test reads it.
    steps_first: bool,
}

impl Counted {
    /// How often a float counts, given the bits of its start and its end. Each device rounds the sums alike.
    fn turns_of_float(&self, op: Binary, start: u32, end: u32) -> Option<u64> {
        let (op_of_step, step) = self.step;
        let [mut x, end, step] = [start, end, step].map(f32::from_bits);
        let step = if op_of_step == Binary::Add { step } else { -step };
        if self.steps_first {
            x += step;
        }
        for turns in 0..=MOST_TURNS_OF_FLOAT {
            let goes_on = match op {
                Binary::Less => x < end,
                Binary::LessEqual => x <= end,
                Binary::Greater => x > end,
                Binary::GreaterEqual => x >= end,
                _ => return None,
            };
            if x.is_subnormal() || !x.is_finite() {
                return None;
            }
            if !goes_on {
                return Some(turns);
            }
            x += step;
        }
        None
    }
}

/// How long a loop turns.
struct Limits {
    turns: Bound,
    /// The counter, where it is stepped, and upper bounds of what it holds before that and from there on: before the test, and
    /// between it and the next turn.
    counter: Variable,
    at: usize,
    most: [[Option<Bound>; 2]; 2],
}

/// A test that may end a loop, and the turn around it.
struct Form<'a> {
    /// What `continue` leaves, and what follows in each turn.
    turn: [&'a [Statement]; 2],
    /// The label of the former.
    next: Label,
    /// Where the test is in a turn.
    at: usize,
    condition: Value,
    /// Which value of the condition goes on.
    goes_on: bool,
}

impl<'a> Form<'a> {
    /// The tests of a loop that each turn reaches.
    fn all(body: &'a [Statement]) -> Vec<Self> {
        let [
            Statement::Labeled {
                body: tested,
                label: next,
                function: None,
            },
            counting @ ..,
        ] = body
        else {
            return Vec::new();
        };
        let form = |(at, statement): (usize, &Statement)| {
            let Statement::If {
                condition,
                accept,
                reject,
            } = statement
            else {
                return None;
            };
            let form = Self {
                turn: [tested, counting],
                next: *next,
                at,
                condition: *condition,
                goes_on: ends(reject, *next),
            };
            (ends(accept, *next) != form.goes_on && form.is_reached(at)).then_some(form)
        };
        tested.iter().chain(counting).enumerate().filter_map(form).collect()
    }

    fn statements(&self) -> impl Iterator<Item = (usize, &'a [Statement])> {
        let each = self.turn.into_iter().flatten();
        each.map(std::slice::from_ref).enumerate()
    }

    /// Whether no `continue` skips a statement.
    fn is_reached(&self, at: usize) -> bool {
        let [tested, _] = self.turn;
        at >= tested.len() || !leaves(&tested[..at], self.next)
    }

    /// The statement that computes a value, or in which it is computed.
    fn place(&self, value: Value) -> Option<usize> {
        let mut statements = self.statements();
        statements.find_map(|(at, statement)| computes(statement, value).then_some(at))
    }

    /// Comparisons that all hold if it goes on, each with its operands in both orders.
    fn comparisons(&self, program: &Program) -> Vec<(Binary, Value, Value)> {
        let mut all = Vec::new();
        let mut rest = vec![(self.condition, self.goes_on)];
        let mut seen = BTreeSet::new();
        while let Some((test, truth)) = rest.pop() {
            if !seen.insert((test, truth)) {
                continue;
            }
            match program.op(test) {
                Op::Binary(Binary::And, a, b) if truth => rest.extend([(b, true), (a, true)]),
                Op::Binary(Binary::Or, a, b) if !truth => rest.extend([(b, false), (a, false)]),
                Op::Unary(Unary::Not, a) => rest.push((a, !truth)),
                // `&&` and `||` are branches that set a variable.
                Op::Read(variable) => {
                    let mut parts = self.turn.into_iter();
                    if let Some([condition, accept, reject]) =
                        parts.find_map(|part| set_by_branch(part, test, variable))
                    {
                        let is_other = |value| matches!(program.op(value), Op::Constant(bits) if (bits != 0) != truth);
                        if is_other(reject) {
                            rest.extend([(accept, truth), (condition, true)]);
                        } else if is_other(accept) {
                            rest.extend([(reject, truth), (condition, false)]);
                        }
                    }
                }
                Op::Binary(op, a, b) if op.compares() => {
                    let op = if truth { op } else { negated(op) };
                    all.extend([(op, a, b), (flipped(op), b, a)]);
                }
                _ => {}
            }
        }
        all
    }

    /// How the counter that a test reads counts, if a constant is added to it in each turn and nothing else changes it.
    fn counted(&self, program: &Program, read: Value) -> Option<Counted> {
        let Op::Read(counter) = program.op(read) else {
            return None;
        };
        let mut changing = self.statements().filter(|(_, statement)| changes(statement, counter));
        let (Some((at, [Statement::Write(_, value)])), None) = (changing.next(), changing.next()) else {
            return None;
        };
        let Op::Binary(op @ (Binary::Add | Binary::Subtract), old, by) = program.op(*value) else {
            return None;
        };
        let (Op::Read(before), Op::Constant(bits)) = (program.op(old), program.op(by)) else {
            return None;
        };
        let is_of_turn = self.place(old).is_some_and(|place| place < at);
        let counts = before == counter && bits != 0 && is_of_turn && self.is_reached(at);
        let steps_first = self.place(read)? > at;
        counts.then_some(Counted {
            counter,
            step: (op, bits),
            at,
            steps_first,
        })
    }
}

/// Whether a block leaves a loop whose `continue` leads to a label, and has no loop itself.
fn ends(block: &[Statement], next: Label) -> bool {
    let mut is_plain = true;
    visit(block, &mut |statement| {
        is_plain &= !matches!(statement, Statement::Loop { .. });
    });
    is_plain && !leaves(block, next) && matches!(block.last(), Some(Statement::Exit(_)))
}

/// The condition and the results of the branch that sets a variable before it is read in the same block.
fn set_by_branch(block: &[Statement], read: Value, variable: Variable) -> Option<[Value; 3]> {
    let Some(at) = block.iter().position(|statement| statement.results().contains(&read)) else {
        let mut inner = block.iter().flat_map(Statement::blocks);
        return inner.find_map(|inner| set_by_branch(inner, read, variable));
    };
    let mut before = block[..at].iter().rev();
    let set = before.find(|statement| changes(std::slice::from_ref(statement), variable));
    let Statement::If {
        condition,
        accept,
        reject,
    } = set?
    else {
        return None;
    };
    match (accept.last()?, reject.last()?) {
        (Statement::Write(a, x), Statement::Write(b, y)) if [*a, *b] == [variable; 2] => Some([*condition, *x, *y]),
        _ => None,
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

/// The comparison that holds for integers if another one doesn't.
fn negated(op: Binary) -> Binary {
    match op {
        Binary::Less => Binary::GreaterEqual,
        Binary::LessEqual => Binary::Greater,
        Binary::Greater => Binary::LessEqual,
        Binary::GreaterEqual => Binary::Less,
        Binary::Equal => Binary::NotEqual,
        _ => Binary::Equal,
    }
}

/// What to write instead of a loop that nothing bounds, given its text.
fn instead(text: &str) -> String {
    let text = blank_comments(text);
    let head = text.split('{').next().unwrap_or_default();
    if let Some(test) = head.strip_prefix("while") {
        let test: Vec<_> = test.split_whitespace().collect();
        let test = test.join(" ");
        let inner = test.strip_prefix('(').and_then(|rest| rest.strip_suffix(')'));
        let is_one = inner.is_some_and(|inner| inner.find(')') >= inner.find('('));
        let test = if is_one { test } else { format!("({test})") };
        return format!("give it a maximum, such as 40: `for (var i = 0u; i < 40u && {test}; i++) {{ .. }}`");
    }
    let message = if !head.starts_with("for") {
        "give it a maximum, such as 40: `for (var i = 0u; i < 40u; i++) { .. }`, with `break` in it"
    } else if head.contains("--") || head.contains("-=") {
        "write `for (var i = start; i > end; i -= step)`, where `end` is a constant, and `start` is one or has a visible \
         maximum, such as `min(x, 8u)`; or count upwards"
    } else {
        "write `for (var i = start; i < end; i += step)`, where `start` is a constant, and `end` is one or has a visible \
         maximum, such as `min(x, 8u)`"
    };
    message.to_owned()
}

impl<'a> Analysis<'a> {
    fn block(&mut self, block: &'a [Statement]) -> Bound {
        let mut all = Bound::Constant(0);
        for (at, statement) in block.iter().enumerate() {
            self.before.push(&block[..at]);
            let turns = match statement {
                Statement::Loop { label, body, span } => match self.repeated(*label, body) {
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
            self.before.pop();
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

    /// The turns of a loop and of all loops in it; `None` if nothing bounds it.
    fn repeated(&mut self, label: Label, body: &'a [Statement]) -> Option<Bound> {
        let forms = Form::all(body);
        let all = forms.iter().flat_map(|form| {
            let tests = form.comparisons(self.program);
            let limits = |test| self.limits(form, test).or_else(|| self.fixed(form, test));
            tests.into_iter().filter_map(limits).map(move |limits| (form, limits))
        });
        // What the host knows may be less than any constant.
        let (form, limits) = all.min_by_key(|(_, limits)| match limits.turns {
            Bound::Constant(turns) => Some(turns),
            _ => None,
        })?;
        for (at, statement) in form.statements() {
            let most = &limits.most[usize::from(at > form.at)][usize::from(at > limits.at)];
            if let Some(most) = most {
                self.bound_reads(statement, limits.counter, most);
            }
        }
        // Nothing from before the loop is the latest now.
        let around = std::mem::take(&mut self.before);
        let [tested, counting] = form.turn;
        let (first, last) = if form.at < tested.len() {
            let (first, last) = tested.split_at(form.at);
            (self.block(first), self.block(last).sum(self.block(counting)))
        } else {
            let (first, last) = counting.split_at(form.at - tested.len());
            (self.block(tested).sum(self.block(first)), self.block(last))
        };
        self.before = around;
        let turns = limits.turns;
        let of_loop = OfLoop {
            turns: turns.clone(),
            tests_by_loops: first != Bound::Constant(0),
            of_dispatch: turns.has_word_of(&self.uniforms),
        };
        self.loops.insert(label, of_loop);
        let tests = turns.clone().sum(Bound::Constant(1));
        Some(tests.clone().sum(tests.product(first)).sum(turns.product(last)))
    }

    /// The limits of a loop that counts up to an end that has a bound, by one of its tests.
    fn limits(&self, form: &Form<'_>, (op, read, end): (Binary, Value, Value)) -> Option<Limits> {
        if !matches!(op, Binary::Less | Binary::LessEqual) || self.program.ty(read) != Ty::U32 {
            return None;
        }
        let counted = form.counted(self.program, read)?;
        let (Binary::Add, step) = counted.step else {
            return None;
        };
        let step = u64::from(step);
        let or_equal = op == Binary::LessEqual;
        let most = self.upper(end)?.sum(Bound::Constant(u64::from(or_equal)));
        let start = self.start(counted.counter);
        let known = start.and_then(|start| match start {
            Start::Value(value) => self.exact(value),
            Start::Constant(bits) => Some(Bound::Constant(bits)),
        });
        let tested = match known {
            // A sum that wraps around begins at 0.
            Some(Bound::Constant(start)) if counted.steps_first => {
                let first = u32::try_from(start.saturating_add(step)).ok();
                first.map(|first| Bound::Constant(first.into()))
            }
            _ if counted.steps_first => None,
            known => known,
        };
        let distance = self.distance(tested, end, or_equal, most.clone());
        distance.most(&self.uniforms)?;
        // Else the counter might start again from 0.
        let is_safe = |most: u64| u32::try_from(most.saturating_add(step)).is_ok();
        if (step > 1 || or_equal) && !most.most(&self.uniforms).is_some_and(is_safe) {
            return None;
        }
        let first = start.and_then(|start| match start {
            Start::Value(value) => self.upper(value),
            Start::Constant(bits) => Some(Bound::Constant(bits)),
        });
        // Once it has counted, the counter may be a step beyond its end; at the first test it may be anywhere.
        let beyond = most.clone().sum(Bound::Constant(step));
        let before = if counted.steps_first { &most } else { &beyond };
        let before = first.map(|first| Bound::Greatest(Box::new(before.clone()), Box::new(first)));
        let stepped = before.clone().map(|before| before.sum(Bound::Constant(step)));
        let after = if counted.steps_first { most.clone() } else { beyond };
        Some(Limits {
            turns: distance.in_steps_of(step),
            counter: counted.counter,
            at: counted.at,
            most: [[before, stepped], [Some(most), Some(after)]],
        })
    }

    /// The limits of a loop that counts from a constant to another one, up or down, with or without signs, by one of its tests.
    /// Where it begins, if it counts down, or ends, if it counts up, may be a value with a maximum.
    fn fixed(&self, form: &Form<'_>, (op, read, end): (Binary, Value, Value)) -> Option<Limits> {
        let counted = form.counted(self.program, read)?;
        let start = self.start(counted.counter)?;
        let constant = |value| match self.program.op(value) {
            Op::Constant(bits) => Some(bits),
            _ => None,
        };
        let bits_of_start = match start {
            Start::Value(value) => constant(value),
            Start::Constant(bits) => u32::try_from(bits).ok(),
        };
        let is_unsigned = match self.program.ty(read) {
            Ty::U32 => true,
            Ty::I32 => false,
            _ => {
                return Some(Limits {
                    turns: Bound::Constant(counted.turns_of_float(op, bits_of_start?, constant(end)?)?),
                    counter: counted.counter,
                    at: counted.at,
                    most: [[None, None], [None, None]],
                });
            }
        };
        let number = |bits: u32| {
            if is_unsigned {
                i64::from(bits)
            } else {
                i64::from(bits as i32)
            }
        };
        let step = match counted.step {
            (Binary::Add, bits) => number(bits),
            (_, bits) => -number(bits),
        };
        let are_constant = bits_of_start.is_some() && constant(end).is_some();
        let (start, end) = match (bits_of_start, constant(end), start) {
            (Some(start), Some(end), _) => (number(start), number(end)),
            (Some(start), None, _) if step > 0 => (number(start), self.maximum(end)?),
            (None, Some(end), Start::Value(start)) if step < 0 && !counted.steps_first => {
                (self.maximum(start)?, number(end))
            }
            _ => return None,
        };
        let first = if counted.steps_first { start + step } else { start };
        // How far it goes, and the last number with which it goes on.
        let (distance, passing) = match op {
            Binary::NotEqual if are_constant && step > 0 => (end - first, end - step),
            Binary::NotEqual if are_constant => (first - end, end - step),
            Binary::Less if step > 0 => (end - first, end - 1),
            Binary::LessEqual if step > 0 => (end - first + 1, end),
            Binary::Greater if step < 0 => (first - end, end + 1),
            Binary::GreaterEqual if step < 0 => (first - end + 1, end),
            _ => return None,
        };
        let size = step.abs();
        if op == Binary::NotEqual && (distance < 0 || distance % size != 0) {
            return None;
        }
        let turns = distance.max(0).unsigned_abs().div_ceil(size.unsigned_abs());
        // Else the counter would start again from the other end of its range.
        let last = first + i64::try_from(turns).ok()?.checked_mul(step)?;
        let furthest = if are_constant { last } else { passing + step };
        let is_within = |number: i64| {
            if is_unsigned {
                u32::try_from(number).is_ok()
            } else {
                i32::try_from(number).is_ok()
            }
        };
        let most = is_unsigned.then(|| Bound::Constant(start.max(last).unsigned_abs()));
        (is_within(first) && is_within(furthest)).then_some(Limits {
            turns: Bound::Constant(turns),
            counter: counted.counter,
            at: counted.at,
            most: [[most.clone(), most.clone()], [most.clone(), most]],
        })
    }

    /// The maximum of an integer.
    fn maximum(&self, value: Value) -> Option<i64> {
        if self.program.ty(value) == Ty::U32 {
            return i64::try_from(self.upper(value)?.most(&self.uniforms)?).ok();
        }
        self.visited(|| match self.program.op(value) {
            Op::Constant(bits) => Some(i64::from(bits as i32)),
            Op::Binary(Binary::Min, a, b) => match (self.maximum(a), self.maximum(b)) {
                (Some(a), Some(b)) => Some(a.min(b)),
                (a, b) => a.or(b),
            },
            Op::Binary(Binary::Max, a, b) => Some(self.maximum(a)?.max(self.maximum(b)?)),
            Op::Select { accept, reject, .. } => Some(self.maximum(accept)?.max(self.maximum(reject)?)),
            Op::Bitcast(bits) if self.program.ty(bits) == Ty::U32 => {
                let most = self.maximum(bits)?;
                i32::try_from(most).is_ok().then_some(most)
            }
            _ => None,
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

    /// The value that a counter is set to before a loop; `None` if it isn't set there, or only in a branch.
    fn start(&self, counter: Variable) -> Option<Start> {
        let before = self.before.iter().rev().flat_map(|block| block.iter().rev());
        let set = before
            .map(std::slice::from_ref)
            .find(|statement| changes(statement, counter));
        match set? {
            [Statement::Write(_, start)] => Some(Start::Value(*start)),
            [Statement::Declare(_)] => {
                let init = self.program.variables[counter.0 as usize].init;
                Some(Start::Constant(u64::from(init)))
            }
            _ => None,
        }
    }

    /// The distance that a counter covers: from the value that is tested first, or from 0, to its end.
    fn distance(&self, start: Option<Bound>, end: Value, or_equal: bool, most: Bound) -> Bound {
        let Some(known) = start else { return most };
        // From `start` to `start + count`.
        if let Op::Binary(Binary::Add, a, b) = self.program.op(end)
            && !or_equal
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
            Bound::Constant(_) | Bound::Word { .. } => most.less(known),
            // A sum may wrap around.
            _ => most,
        }
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

/// Whether one of these statements, or of those in them, computes a value.
fn computes(statements: &[Statement], value: Value) -> bool {
    let mut computes = false;
    visit(statements, &mut |statement| {
        computes |= statement.results().contains(&value);
    });
    computes
}
