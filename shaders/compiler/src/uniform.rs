//! Finds which values are the same in all lanes: the fixpoint of an analysis of data flow and control flow together, which
//! first assumes that all are, and drops those that can't be.

use std::collections::BTreeSet;

use crate::rules::Rule;
use crate::source::{Place, Refusal, Refusals};
use crate::tree::{Array, Binary, Block, Label, Op, Program, Statement, Ty, Value, Variable, visit};

/// What is wrong with the index of a long array that differs between lanes, and what to write instead.
const SAME_INDEX: &str = "the index of a local array of more than 256 elements has to be the same in all episodes, a constant or the \
    counter of a loop; go through the array: `for (var i = 0u; i < COUNT; i++)` with `x = select(x, a[i], i == index);` to read an \
    element, and `a[i] = select(a[i], x, i == index);` to write one";
/// Most elements of an array whose index differs between lanes.
const MOST: usize = 256;

/// How a value differs between lanes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Shape {
    /// The same in all lanes.
    Uniform,
    /// A uniform integer plus the lane's number.
    Linear,
    /// Any values.
    Varying,
}

/// Results of the analysis.
#[derive(Clone, Debug, Default)]
pub struct Shapes {
    values: Vec<Option<Shape>>,
    variables: BTreeSet<Variable>,
    arrays: BTreeSet<Array>,
    /// Labels that some lanes exit to while others stay.
    left_by_some: BTreeSet<Label>,
    /// Loops that some lanes leave while others stay, whatever the label that they exit to.
    loops: BTreeSet<Label>,
    /// The program's last block, unless all lanes leave it together somewhere.
    last_block: Option<Label>,
}

/// A construct around a statement.
#[derive(Clone, Copy, Debug)]
pub enum Region {
    /// A branch of an `if`, and whether its condition varies.
    Branch(bool),
    /// A labelled block or loop.
    Label(Label),
}

impl Shapes {
    /// Returns how a value differs between lanes.
    pub fn shape(&self, value: Value) -> Shape {
        self.values
            .get(value.0 as usize)
            .copied()
            .flatten()
            .unwrap_or(Shape::Uniform)
    }

    /// Returns whether a value is the same in all lanes.
    pub fn is_uniform(&self, value: Value) -> bool {
        self.shape(value) == Shape::Uniform
    }

    /// Returns whether a variable's content differs between lanes.
    pub fn variable_varies(&self, variable: Variable) -> bool {
        self.variables.contains(&variable)
    }

    /// Returns whether an array's content differs between lanes.
    pub fn array_varies(&self, array: Array) -> bool {
        self.arrays.contains(&array)
    }

    /// Returns whether some lanes exit to a label while others stay.
    pub fn is_left_by_some(&self, label: Label) -> bool {
        self.left_by_some.contains(&label)
    }

    /// Returns whether a loop must end when no lane is left in it.
    pub fn loop_is_left_by_some(&self, label: Label) -> bool {
        self.loops.contains(&label)
    }

    /// Returns whether lanes that are active outside these regions may be idle inside.
    pub fn diverges(&self, regions: &[Region]) -> bool {
        regions.iter().any(|region| match region {
            Region::Branch(varying) => *varying,
            Region::Label(label) => self.left_by_some.contains(label),
        })
    }

    /// Returns whether only some of the lanes in its label's block may take an exit.
    pub fn exit_diverges(&self, regions: &[Region], label: Label) -> bool {
        self.diverges(&regions[depth_of(regions, label) + 1..])
    }

    /// Returns whether there is an exit in the body of a labelled block that all active lanes take together. `regions` are
    /// those around the body.
    pub fn is_left_by_all(&self, label: Label, body: &Block, regions: &mut Vec<Region>) -> bool {
        body.iter().any(|statement| {
            let region = match statement {
                Statement::Exit(other) => return *other == label && !self.exit_diverges(regions, label),
                Statement::If { condition, .. } => Region::Branch(!self.is_uniform(*condition)),
                Statement::Loop { label, .. } | Statement::Labeled { label, .. } => Region::Label(*label),
                _ => return false,
            };
            regions.push(region);
            let found = statement
                .blocks()
                .any(|inner| self.is_left_by_all(label, inner, regions));
            regions.pop();
            found
        })
    }

    /// Returns whether a varying `if` with these branches, in these regions, is followed by a test that ends the program if
    /// no lane is left in it. Lanes must exit in the branches, and the `if` must be directly in the program's last block:
    /// deeper in, the test isn't worth its time.
    pub fn ends_early(&self, regions: &[Region], branches: [&Block; 2]) -> bool {
        let mut exits = false;
        if let [Region::Label(label)] = regions
            && self.last_block == Some(*label)
        {
            for block in branches {
                visit(block, &mut |statement| exits |= matches!(statement, Statement::Exit(_)));
            }
        }
        exits
    }
}

/// Index of a label's block among the enclosing regions.
///
/// # Panics
/// If it is not among them.
pub fn depth_of(regions: &[Region], label: Label) -> usize {
    regions
        .iter()
        .position(|region| matches!(region, Region::Label(other) if *other == label))
        .expect("an exit stands in its label's block")
}

/// Analyses a program.
///
/// # Errors
/// A varying value that is stored at a uniform address in a buffer, or a varying index into a long local array.
pub fn analyse(program: &Program, place: &dyn Fn(naga::Span) -> Place) -> Result<Shapes, Refusals> {
    let mut analysis = Analysis {
        program,
        shapes: Shapes {
            values: vec![None; program.values.len()],
            ..Shapes::default()
        },
        homes: vec![0; program.variables.len()],
        array_homes: vec![0; program.arrays.len()],
        changed: true,
        refusals: Vec::new(),
        place,
    };
    while std::mem::take(&mut analysis.changed) {
        analysis.refusals.clear();
        analysis.block(&program.body, &mut Vec::new());
    }
    if !analysis.refusals.is_empty() {
        return Err(analysis.refusals);
    }
    let mut shapes = analysis.shapes;
    if let Some(Statement::Labeled { label, body, .. }) = program.body.last()
        && !shapes.is_left_by_all(*label, body, &mut vec![Region::Label(*label)])
    {
        shapes.last_block = Some(*label);
    }
    Ok(shapes)
}

struct Analysis<'a> {
    program: &'a Program,
    shapes: Shapes,
    /// Number of regions around each declaration.
    homes: Vec<usize>,
    array_homes: Vec<usize>,
    changed: bool,
    refusals: Refusals,
    place: &'a dyn Fn(naga::Span) -> Place,
}

impl Analysis<'_> {
    fn refuse(&mut self, span: naga::Span, rule: Rule, message: &str) {
        self.refusals.push(Refusal {
            place: (self.place)(span),
            function: None,
            rule,
            message: message.into(),
        });
    }

    /// Refuses an index that differs between lanes unless the array is short.
    fn refuse_long(&mut self, array: Array, span: naga::Span) {
        if self.program.arrays[array.0 as usize].init.len() > MOST {
            self.refuse(span, Rule::SameIndex, SAME_INDEX);
        }
    }

    fn set(&mut self, value: Value, shape: Shape) {
        let slot = &mut self.shapes.values[value.0 as usize];
        // Shapes only ever rise, so the analysis ends.
        let new = slot.map_or(shape, |old| old.max(shape));
        if *slot != Some(new) {
            *slot = Some(new);
            self.changed = true;
        }
    }

    fn block(&mut self, block: &Block, regions: &mut Vec<Region>) {
        for statement in block {
            match statement {
                Statement::Let(value) => {
                    let shape = self.computed(*value);
                    self.set(*value, shape);
                }
                Statement::Load { targets, address } => {
                    let uniform = address.element.is_none_or(|element| self.shapes.is_uniform(element));
                    for target in targets {
                        self.set(*target, if uniform { Shape::Uniform } else { Shape::Varying });
                    }
                }
                Statement::Declare(variable) => self.homes[variable.0 as usize] = regions.len(),
                Statement::DeclareArray(array) => self.array_homes[array.0 as usize] = regions.len(),
                Statement::Write(variable, value) => {
                    let home = self.homes[variable.0 as usize];
                    if !self.shapes.is_uniform(*value) || self.shapes.diverges(&regions[home..]) {
                        self.changed |= self.shapes.variables.insert(*variable);
                    }
                }
                Statement::WriteElement {
                    array,
                    index,
                    value,
                    span,
                } => {
                    let home = self.array_homes[array.0 as usize];
                    let is_same = self.shapes.is_uniform(*index);
                    if !is_same {
                        self.refuse_long(*array, *span);
                    }
                    if !is_same || !self.shapes.is_uniform(*value) || self.shapes.diverges(&regions[home..]) {
                        self.changed |= self.shapes.arrays.insert(*array);
                    }
                }
                Statement::Store { address, value, span } => {
                    let fixed = address.element.is_none_or(|element| self.shapes.is_uniform(element));
                    if fixed && !self.shapes.is_uniform(*value) {
                        self.refuse(
                            *span,
                            Rule::Internal,
                            "invocations store different values at one address; the last would win",
                        );
                    }
                }
                Statement::If {
                    condition,
                    accept,
                    reject,
                } => {
                    regions.push(Region::Branch(!self.shapes.is_uniform(*condition)));
                    self.block(accept, regions);
                    self.block(reject, regions);
                    regions.pop();
                }
                Statement::Loop { label, body, .. } | Statement::Labeled { label, body, .. } => {
                    regions.push(Region::Label(*label));
                    self.block(body, regions);
                    regions.pop();
                }
                Statement::Exit(label) => {
                    if self.shapes.exit_diverges(regions, *label) {
                        self.changed |= self.shapes.left_by_some.insert(*label);
                        for region in &regions[depth_of(regions, *label)..] {
                            if let Region::Label(inner) = region {
                                self.changed |= self.shapes.loops.insert(*inner);
                            }
                        }
                    }
                }
            }
        }
    }

    fn computed(&mut self, value: Value) -> Shape {
        let uniform_or_varying = |uniform: bool| if uniform { Shape::Uniform } else { Shape::Varying };
        match self.program.op(value) {
            Op::Constant(_) | Op::Workgroup => Shape::Uniform,
            Op::Lane => Shape::Linear,
            Op::Read(variable) => uniform_or_varying(!self.shapes.variables.contains(&variable)),
            Op::ReadElement(array, index) => {
                let is_same = self.shapes.is_uniform(index);
                if !is_same {
                    self.refuse_long(array, self.program.values[value.0 as usize].span);
                }
                uniform_or_varying(is_same && !self.shapes.arrays.contains(&array))
            }
            Op::Binary(op @ (Binary::Add | Binary::Subtract), a, b) if self.program.ty(value) == Ty::U32 => {
                match (self.shapes.shape(a), self.shapes.shape(b)) {
                    (Shape::Uniform, Shape::Uniform) => Shape::Uniform,
                    (Shape::Linear, Shape::Uniform) => Shape::Linear,
                    (Shape::Uniform, Shape::Linear) if op == Binary::Add => Shape::Linear,
                    _ => Shape::Varying,
                }
            }
            op => uniform_or_varying(op.operands().all(|operand| self.shapes.is_uniform(operand))),
        }
    }
}
