//! Computes each value once: what was computed before, from the same operands and with nothing written in between, isn't
//! computed again. LLVM does the same for lane code compiled ahead of time; code compiled at run time depends on this.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use oneiro_shader_compiler::tree::{Address, Array, Block, Label, Op, Program, Statement, Ty, Value, Variable, visit};
use oneiro_shader_compiler::uniform::{Region, Shapes};
use oneiro_shader_compiler::{Trees, remove_unused, rename};

/// Something that can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Written {
    Variable(Variable),
    Array(Array),
    /// A buffer by its binding number. No two have memory in common.
    Buffer(u32),
}

impl Written {
    /// The place that a statement writes.
    fn written_by(statement: &Statement) -> Option<Self> {
        match statement {
            Statement::Write(variable, _) | Statement::Declare(variable) => Some(Self::Variable(*variable)),
            Statement::WriteElement { array, .. } | Statement::DeclareArray(array) => Some(Self::Array(*array)),
            Statement::Store { address, .. } => Some(Self::Buffer(address.buffer)),
            _ => None,
        }
    }
}

/// How a value is computed: the same computation with the same version of what it reads gives the same value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Computation {
    Op(Op, Ty, u32),
    /// A word of a buffer.
    Load(Address, Ty, u32),
}

struct Sharing<'a> {
    program: &'a mut Program,
    shapes: &'a Shapes,
    /// Values that are available at this point, and their computations in the order in which they were computed.
    known: HashMap<Computation, Value>,
    order: Vec<Computation>,
    /// Values that are no longer computed, and those in their place.
    replaced: HashMap<Value, Value>,
    /// Number of each place's last write, and the versions before the writes of the current scope.
    versions: BTreeMap<Written, u32>,
    before: Vec<(Written, u32)>,
    writes: u32,
    regions: Vec<Region>,
}

/// The tidied program without computations whose result is known where they stand. Its values have the shapes that they had:
/// what takes a value's place doesn't vary more.
pub(crate) fn shared(trees: &Trees) -> Program {
    let mut program = trees.tidied.clone();
    let mut body = std::mem::take(&mut program.body);
    let mut sharing = Sharing {
        program: &mut program,
        shapes: &trees.shapes,
        known: HashMap::new(),
        order: Vec::new(),
        replaced: HashMap::new(),
        versions: BTreeMap::new(),
        before: Vec::new(),
        writes: 0,
        regions: Vec::new(),
    };
    sharing.constants();
    sharing.block(&mut body);
    program.body = body;
    remove_unused(&mut program);
    program
}

/// Whether a statement, or one within it, exits to a label.
fn exits_to(statement: &Statement, label: Label) -> bool {
    let mut exits = false;
    visit(std::slice::from_ref(statement), &mut |inner| {
        exits |= matches!(inner, Statement::Exit(other) if *other == label);
    });
    exits
}

/// What the statements of a block write.
fn written_in(block: &Block) -> BTreeSet<Written> {
    let mut written = BTreeSet::new();
    visit(block, &mut |inner| written.extend(Written::written_by(inner)));
    written
}

impl Sharing<'_> {
    fn version(&self, place: Written) -> u32 {
        self.versions.get(&place).copied().unwrap_or(0)
    }

    fn change(&mut self, place: Written) {
        self.before.push((place, self.version(place)));
        self.writes += 1;
        self.versions.insert(place, self.writes);
    }

    /// Equal constants become one. They are known everywhere, whether a statement has them or not.
    fn constants(&mut self) {
        for value in (0..self.program.values.len() as u32).map(Value) {
            if let Op::Constant(bits) = self.program.op(value) {
                let constant = Computation::Op(Op::Constant(bits), self.program.ty(value), 0);
                let first = *self.known.entry(constant).or_insert(value);
                self.replaced.insert(value, first);
            }
        }
    }

    fn computation(&self, value: Value) -> Computation {
        let op = self.program.op(value);
        let version = match op {
            Op::Read(variable) => self.version(Written::Variable(variable)),
            Op::ReadElement(array, _) => self.version(Written::Array(array)),
            _ => 0,
        };
        Computation::Op(op, self.program.ty(value), version)
    }

    fn word(&self, address: &Address, at: usize, target: Value) -> Computation {
        let offset = address.offset + at as u32;
        let version = self.version(Written::Buffer(address.buffer));
        Computation::Load(Address { offset, ..*address }, self.program.ty(target), version)
    }

    fn hold(&mut self, computation: Computation, value: Value) {
        self.known.insert(computation, value);
        self.order.push(computation);
    }

    /// A block after which what was computed in it isn't available: returns what it writes.
    fn scope(&mut self, block: &mut Block) -> BTreeSet<Written> {
        let (known, before) = (self.order.len(), self.before.len());
        self.block(block);
        for computation in self.order.drain(known..) {
            self.known.remove(&computation);
        }
        let mut written = BTreeSet::new();
        for (place, version) in self.before.drain(before..).rev() {
            self.versions.insert(place, version);
            written.insert(place);
        }
        written
    }

    fn change_all(&mut self, places: BTreeSet<Written>) {
        for place in places {
            self.change(place);
        }
    }

    fn block(&mut self, block: &mut Block) {
        for mut statement in std::mem::take(block) {
            let replaced = &self.replaced;
            rename(self.program, &mut statement, &|value| {
                replaced.get(&value).copied().unwrap_or(value)
            });
            if self.is_needed(&mut statement) {
                block.push(statement);
            }
        }
    }

    /// Enters what a statement computes and writes. Returns whether any of it was unknown.
    fn is_needed(&mut self, statement: &mut Statement) -> bool {
        match statement {
            Statement::Let(value) => {
                let computation = self.computation(*value);
                return self.is_new(computation, *value);
            }
            Statement::Load { targets, address } => {
                let mut is_new = false;
                for (at, target) in targets.iter().enumerate() {
                    let word = self.word(address, at, *target);
                    is_new |= self.is_new(word, *target);
                }
                return is_new;
            }
            Statement::If {
                condition,
                accept,
                reject,
            } => {
                self.regions.push(Region::Branch(!self.shapes.is_uniform(*condition)));
                let written = [accept, reject].map(|branch| self.scope(branch));
                self.regions.pop();
                for written in written {
                    self.change_all(written);
                }
            }
            Statement::Loop { label, body, .. } => {
                let written = written_in(body);
                self.change_all(written.clone());
                self.regions.push(Region::Label(*label));
                self.scope(body);
                self.regions.pop();
                self.change_all(written);
            }
            Statement::Labeled { label, body, .. } => self.labeled(*label, body),
            _ => self.write(statement),
        }
        true
    }

    /// Lanes that exit miss what comes after. Unless all of them jump over it together, it is computed for them nevertheless.
    fn labeled(&mut self, label: Label, body: &mut Block) {
        // An exit at the end is none.
        body.pop_if(|last| matches!(last, Statement::Exit(other) if *other == label));
        self.regions.push(Region::Label(label));
        let exit = body.iter().position(|inner| exits_to(inner, label));
        let is_left_by_all = self.shapes.is_left_by_all(label, body, &mut self.regions);
        let mut rest = body.split_off(exit.unwrap_or(body.len()));
        self.block(body);
        let written = if is_left_by_all {
            self.scope(&mut rest)
        } else {
            let written = written_in(&rest);
            self.block(&mut rest);
            written
        };
        body.append(&mut rest);
        self.regions.pop();
        self.change_all(written);
    }

    /// Returns whether a computation isn't known. If it is, its value takes the place of `value`, unless that varies less.
    fn is_new(&mut self, computation: Computation, value: Value) -> bool {
        // A value of a variable that varies may be computed from what was written last, which does not.
        let varies_more = |known: Value| self.shapes.shape(known) > self.shapes.shape(value);
        if let Some(known) = self
            .known
            .get(&computation)
            .copied()
            .filter(|known| !varies_more(*known))
        {
            self.replaced.insert(value, known);
            return false;
        }
        self.hold(computation, value);
        true
    }

    /// Enters what a statement without blocks writes. A written variable is known.
    fn write(&mut self, statement: &Statement) {
        let Some(place) = Written::written_by(statement) else {
            return;
        };
        self.change(place);
        if let Statement::Write(variable, value) = *statement {
            let read = Computation::Op(Op::Read(variable), self.program.ty(value), self.version(place));
            self.hold(read, value);
        }
    }
}

#[cfg(test)]
mod tests {
    use oneiro_shader_compiler::tree::Binary;
    use oneiro_shader_compiler::{Part, trees};

    use super::*;

    /// A kernel. `x` is a number of each lane, `s` the same for all.
    fn kernel(body: &str) -> Trees {
        let text = format!(
            "@group(0) @binding(0) var<storage, read> settings: array<f32>;
            @group(0) @binding(1) var<storage, read_write> numbers: array<f32>;
            fn cut(x: f32, off: bool) -> f32 {{
                if (off) {{ return 1.0f; }}
                return x * x;
            }}
            @compute @workgroup_size(64)
            fn main(@builtin(local_invocation_index) lane: u32) {{
                let s = settings[0];
                let x = numbers[lane];
                {body}
            }}"
        );
        let path = "kernel.wgsl".to_owned();
        trees(&[Part { path, text }]).expect("it is exact")
    }

    /// Multiplications in a kernel before and after values are shared.
    fn multiplications(body: &str) -> [usize; 2] {
        let trees = kernel(body);
        let count = |program: &Program| {
            let mut count = 0;
            visit(&program.body, &mut |statement| {
                let results = statement.results().iter().map(|value| program.op(*value));
                count += results
                    .filter(|op| matches!(op, Op::Binary(Binary::Multiply, ..)))
                    .count();
            });
            count
        };
        [count(&trees.tidied), count(&shared(&trees))]
    }

    /// Known values are not computed again; those written since, or perhaps jumped over, are.
    #[test]
    fn values_are_computed_once() {
        for (body, expected) in [
            ("numbers[lane] = (x * s) + (x * s);", [2, 1]),
            ("numbers[lane] = (x * s) + (s * x);", [2, 2]),
            // A buffer is stored to in between.
            (
                "numbers[lane] = 2.0f * numbers[lane]; numbers[lane] = 2.0f * numbers[lane];",
                [2, 2],
            ),
            (
                "numbers[lane] = 2.0f * settings[1]; numbers[lane + 1u] = 2.0f * settings[1];",
                [2, 1],
            ),
            // Variables: written, written in one branch, written in each turn of a loop.
            (
                "var v = x; numbers[lane] = v * v; v = v; numbers[lane] = v * v;",
                [2, 1],
            ),
            (
                "var v = x; numbers[lane] = v * v; v += 1.0f; numbers[lane] = v * v;",
                [2, 2],
            ),
            (
                "var v = x; numbers[lane] = v * v; if (s > 1.0f) { v += s; } numbers[lane] = v * v;",
                [2, 2],
            ),
            (
                "var v = x; numbers[lane] = v * v;
                for (var i = 0u; i < 3u; i++) { numbers[lane + i] = v * v; v += 1.0f; }",
                [2, 2],
            ),
            (
                "numbers[lane] = x * x; for (var i = 0u; i < 3u; i++) { numbers[lane + i] = x * x; }",
                [2, 1],
            ),
            // A branch's values don't exist after it; those from before it exist in it.
            (
                "if (x > 1.0f) { numbers[lane] = x * x; } numbers[lane] = x * x;",
                [2, 2],
            ),
            (
                "numbers[lane] = x * x; if (x > 1.0f) { numbers[lane + 1u] = x * x; }",
                [2, 1],
            ),
            // After a return of some lanes the rest is computed for all; a return of all lanes jumps over it.
            ("numbers[lane] = cut(x, x > 1.0f) + cut(x, x > 1.0f);", [2, 1]),
            ("numbers[lane] = cut(x, s > 1.0f) + cut(x, s > 1.0f);", [2, 2]),
        ] {
            assert_eq!(multiplications(body), expected, "{body}");
        }
    }

    /// A value written to a variable that differs between lanes later replaces the values read from it, but what is computed from
    /// that counts as different: it doesn't take the place of the same computation with what was written.
    #[test]
    fn what_is_the_same_in_all_lanes_stays_so() {
        let trees = kernel(
            "var v = s;
            numbers[lane] = v * v;
            if (x > 1.0f) { v = x; }
            numbers[lane + 1u] = v;
            numbers[lane + 2u] = settings[u32(s * s)];",
        );
        let target = crate::Target::host().expect("there is one for this processor");
        target.compile(&trees, 8).expect("each value is what is expected of it");
    }
}
