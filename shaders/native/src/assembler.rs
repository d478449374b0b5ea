//! What the emitter writes to: an instruction set with scalars, vectors of four lanes and structured control flow.
//! A truth value in a vector is a word, all of whose bits it sets or clears: such a mask may be used as words.

use oneiro_shader_compiler::tree::{Binary, Ty, Unary};

/// Lanes of a vector.
pub(crate) const LANES: u32 = 4;

/// The form of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Form {
    /// A scalar.
    One(Ty),
    /// A vector.
    Four(Ty),
}

/// Writes one function. Its parameters are the buffers, the workgroup, the first lane, and how often loops may turn.
/// Arithmetic wraps; floats are rounded after each operation. Memory is never checked: see the emitter.
pub(crate) trait Assembler {
    /// A computed value; it may be used wherever its block has been passed.
    type Value: Copy;
    /// A local variable of one form.
    type Variable: Copy;
    /// Words of memory that belong to one call.
    type Array: Copy;
    /// Where in a buffer one lane's words begin.
    type Place: Copy;
    /// A block or loop that can be left.
    type Label: Copy;

    fn workgroup(&mut self) -> Self::Value;
    fn first_lane(&mut self) -> Self::Value;
    /// The number of elements of so many words that a buffer has.
    fn elements(&mut self, buffer: u32, stride: u32) -> Self::Value;

    /// A constant; in a vector, the same in each lane.
    fn constant(&mut self, form: Form, bits: u32) -> Self::Value;
    /// The words `first`, `first + 1`, ..
    fn ramp(&mut self, first: u32) -> Self::Value;
    /// A vector of equal lanes.
    fn splat(&mut self, ty: Ty, scalar: Self::Value) -> Self::Value;
    /// Word `lane` of a vector of words.
    fn lane(&mut self, vector: Self::Value, lane: u32) -> Self::Value;
    /// Replaces word `lane`.
    fn with_lane(&mut self, vector: Self::Value, lane: u32, word: Self::Value) -> Self::Value;

    fn unary(&mut self, op: Unary, form: Form, a: Self::Value) -> Self::Value;
    /// `form` is that of the operands, and of the result unless it is a comparison. A vector is shifted by a scalar.
    /// Shifts count modulo 32. Division is of unsigned scalars, and never by zero. The lesser of two floats is
    /// `a < b ? a : b`, the greater `a > b ? a : b`.
    fn binary(&mut self, op: Binary, form: Form, a: Self::Value, b: Self::Value) -> Self::Value;
    /// `condition ? accept : reject`, the condition a scalar.
    fn select(&mut self, condition: Self::Value, accept: Self::Value, reject: Self::Value) -> Self::Value;
    /// The same for vectors, lane by lane.
    fn blend(&mut self, ty: Ty, mask: Self::Value, accept: Self::Value, reject: Self::Value) -> Self::Value;
    /// Converts numbers, and scalar truth values to words. Out of range, any number may result.
    fn convert(&mut self, from: Form, to: Ty, a: Self::Value) -> Self::Value;
    /// The same bits as another type.
    fn bitcast(&mut self, from: Form, to: Ty, a: Self::Value) -> Self::Value;
    /// Whether any lane of a mask is set, as a scalar.
    fn any(&mut self, mask: Self::Value) -> Self::Value;

    /// Where a word of a buffer lies.
    fn place(&mut self, buffer: u32, index: Self::Value) -> Self::Place;
    /// The same for each lane's index; where nothing is for lanes that a mask leaves out.
    fn places(&mut self, buffer: u32, indices: Self::Value, mask: Option<Self::Value>) -> [Self::Place; 4];
    /// Memory for so many words.
    fn array(&mut self, words: u32) -> Self::Array;
    /// Where a word of an array lies.
    fn place_in(&mut self, array: Self::Array, index: Self::Value) -> Self::Place;
    /// One of two places.
    fn choose(&mut self, condition: Self::Value, accept: Self::Place, reject: Self::Place) -> Self::Place;
    /// The number, or the numbers one after the other, that lie `offset` words after a place.
    fn load(&mut self, form: Form, place: Self::Place, offset: u32) -> Self::Value;
    fn store(&mut self, form: Form, place: Self::Place, offset: u32, value: Self::Value);
    /// The word `offset` after each place.
    fn gather(&mut self, places: &[Self::Place; 4], offset: u32) -> Self::Value;
    /// The four words from there on: a vector for each.
    fn gather_four(&mut self, places: &[Self::Place; 4], offset: u32) -> [Self::Value; 4];
    /// Stores the word `offset` after each place, in the lanes' order.
    fn scatter(&mut self, places: &[Self::Place; 4], offset: u32, words: Self::Value);

    fn variable(&mut self, form: Form) -> Self::Variable;
    /// What a variable holds; it has been set on every way here.
    fn get(&mut self, variable: Self::Variable) -> Self::Value;
    fn set(&mut self, variable: Self::Variable, value: Self::Value);

    /// Begins what runs if a condition is true.
    fn begin_if(&mut self, condition: Self::Value);
    /// Begins what runs if not. An `if` may have none.
    fn begin_else(&mut self);
    fn end_if(&mut self);
    fn begin_block(&mut self) -> Self::Label;
    fn end_block(&mut self);
    /// Begins what is repeated until it is left.
    fn begin_loop(&mut self) -> Self::Label;
    fn end_loop(&mut self);
    /// Goes to the end of a block or loop.
    fn leave(&mut self, label: Self::Label);
    /// Counts a turn of a loop. If there is none left, the function ends and says so.
    fn count_turn(&mut self);
    /// Ends the function.
    fn finish(&mut self);
}
