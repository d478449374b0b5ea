//! Loads and stores. Indices are clamped in all lanes; idle lanes store to memory that nothing reads.

use oneiro_shader_compiler::tree::{Address, Binary, Ty, Value};
use oneiro_shader_compiler::uniform::Shape;

use super::{Emitter, WORD, WORDS};
use crate::assembler::{Assembler, Form};

impl<A: Assembler> Emitter<'_, A> {
    /// Element of an address, unless it is the same for all lanes.
    pub(super) fn varying_element(&self, address: &Address) -> Option<Value> {
        address.element.filter(|element| !self.shapes.is_uniform(*element))
    }

    /// Returns whether the lanes' elements are consecutive words.
    pub(super) fn is_consecutive(&self, address: &Address, element: Value) -> bool {
        self.shapes.shape(element) == Shape::Linear && address.stride == 1
    }

    /// Pointer to a uniform element, clamped.
    fn pointer(&mut self, address: &Address) -> A::Value {
        let Some(element) = address.element else {
            let zero = self.word(0);
            return self.asm.buffer_pointer(address.buffer, zero);
        };
        let key = (address.buffer, element, address.stride, 0);
        if let Some(known) = self.uniform_pointers.get(&key) {
            return *known;
        }
        let element = self.scalar(element);
        let last = self.ends[address.buffer as usize].last;
        let mut index = self.arithmetic(Binary::Min, element, last);
        if address.stride != 1 {
            let stride = self.word(address.stride);
            index = self.arithmetic(Binary::Multiply, index, stride);
        }
        let pointer = self.asm.buffer_pointer(address.buffer, index);
        self.uniform_pointers.insert(key, pointer);
        self.known.push(key);
        pointer
    }

    /// Pointers to the elements of a vector's lanes, clamped.
    fn pointers(&mut self, address: &Address, element: Value, k: usize, mask: Option<A::Value>) -> A::Pointers {
        let elements = self.part(element, k);
        let lasts = self.ends[address.buffer as usize].lasts;
        let mut indices = self.asm.binary(Binary::Min, WORDS, elements, lasts);
        let stride = address.stride;
        if stride.is_power_of_two() && stride > 1 {
            let count = self.word(stride.trailing_zeros());
            indices = self.asm.binary(Binary::ShiftLeft, WORDS, indices, count);
        } else if stride > 1 {
            let strides = self.asm.constant(WORDS, stride);
            indices = self.asm.binary(Binary::Multiply, WORDS, indices, strides);
        }
        self.asm.buffer_pointers(address.buffer, indices, mask)
    }

    /// The same without a mask, computed only once.
    fn known_pointers(&mut self, address: &Address, element: Value, k: usize) -> A::Pointers {
        let key = (address.buffer, element, address.stride, k);
        if let Some(known) = self.pointers.get(&key) {
            return known.clone();
        }
        let pointers = self.pointers(address, element, k, None);
        self.pointers.insert(key, pointers.clone());
        self.known.push(key);
        pointers
    }

    pub(super) fn load_uniform(&mut self, targets: &[Value], address: &Address) {
        let pointer = self.pointer(address);
        for (word, target) in (0..).zip(targets) {
            let ty = self.program.ty(*target);
            let scalar = self.asm.load(Form::One(ty), pointer, address.offset + word);
            self.hold_scalar(*target, scalar);
        }
    }

    pub(super) fn load(
        &mut self,
        targets: &[Value],
        address: &Address,
        element: Value,
        k: usize,
        pointer: Option<A::Value>,
    ) {
        if let (Some(pointer), [target]) = (pointer, targets) {
            let form = Form::Vector(self.program.ty(*target));
            let part = self.asm.load(form, pointer, k as u32 * A::LANES);
            return self.hold_part(*target, k, part);
        }
        let pointers = self.known_pointers(address, element, k);
        let words = if let [_] = targets {
            vec![self.asm.gather(&pointers, address.offset)]
        } else {
            self.asm.gather_four(&pointers, address.offset).to_vec()
        };
        for (target, words) in targets.iter().zip(words) {
            let ty = self.program.ty(*target);
            let part = self.asm.bitcast(WORDS, ty, words);
            self.hold_part(*target, k, part);
        }
    }

    /// Returns whether some lane's consecutive word lies beyond the buffer's end.
    fn is_beyond(&mut self, address: &Address, first: A::Value) -> A::Value {
        let starts = self.ends[address.buffer as usize].starts;
        self.arithmetic(Binary::GreaterEqual, first, starts)
    }

    /// Pointer to the lanes' consecutive words: in the buffer, or in a copy in the rare case that they reach beyond its end.
    pub(super) fn consecutive(&mut self, address: &Address, element: Value) -> A::Value {
        let first = self.scalar(element);
        let words = self.asm.pointer_variable();
        let pointer = self.asm.buffer_pointer(address.buffer, first);
        self.asm.set(words, pointer);
        let beyond = self.is_beyond(address, first);
        let scratch = self.scratch();
        self.asm.begin_rare_if(beyond);
        self.each_word(address, first, scratch, true);
        let copy = self.scratch_pointer(scratch);
        self.asm.set(words, copy);
        self.asm.end_if();
        self.asm.get(words)
    }

    fn scratch_pointer(&mut self, scratch: A::Array) -> A::Value {
        let zero = self.word(0);
        self.asm.array_pointer(scratch, zero)
    }

    /// Memory of one word per lane, for use within one statement.
    fn scratch(&mut self) -> A::Array {
        let words = self.vectors as u32 * A::LANES;
        *self.scratch.get_or_insert_with(|| self.asm.array(words))
    }

    /// Copies the lanes' words one by one, with clamped indices: to `scratch` if `load`, else from it.
    fn each_word(&mut self, address: &Address, first: A::Value, scratch: A::Array, load: bool) {
        let lane = self.asm.variable(WORD);
        let (zero, one) = (self.word(0), self.word(1));
        self.asm.set(lane, zero);
        let label = self.asm.begin_loop();
        let at = self.asm.get(lane);
        let element = self.arithmetic(Binary::Add, first, at);
        let last = self.ends[address.buffer as usize].last;
        let index = self.arithmetic(Binary::Min, element, last);
        let pointer = self.asm.buffer_pointer(address.buffer, index);
        let copy = self.asm.array_pointer(scratch, at);
        if load {
            let word = self.asm.load(WORD, pointer, 0);
            self.asm.store(WORD, copy, 0, word);
        } else {
            let word = self.asm.load(WORD, copy, 0);
            self.asm.store(WORD, pointer, 0, word);
        }
        let next = self.arithmetic(Binary::Add, at, one);
        self.asm.set(lane, next);
        let lanes = self.word(self.vectors as u32 * A::LANES);
        let all = self.arithmetic(Binary::Equal, next, lanes);
        self.asm.begin_if(all);
        self.asm.leave(label);
        self.asm.end_if();
        self.asm.end_loop();
    }

    pub(super) fn store(&mut self, address: &Address, value: Value) {
        let active = self.active();
        let Some(element) = self.varying_element(address) else {
            return self.store_uniform(address, value, active.as_deref());
        };
        let words: Vec<_> = (0..self.vectors).map(|k| self.stored_words(value, k)).collect();
        if self.is_consecutive(address, element) {
            match active {
                None => return self.store_consecutive(address, element, &words),
                Some(active) if A::STORES_MASKED => return self.store_active(address, element, &words, &active),
                Some(_) => {}
            }
        }
        self.store_each(address, element, &words, active.as_deref());
    }

    /// Stores each lane's word where its own pointer points to.
    fn store_each(&mut self, address: &Address, element: Value, words: &[A::Value], active: Option<&[A::Value]>) {
        let pointers = self.active_pointers(address, element, active);
        for (pointers, words) in pointers.iter().zip(words) {
            self.asm.scatter(pointers, address.offset, *words);
        }
    }

    /// Stores the active lanes' words, which are consecutive unless they reach beyond the buffer's end.
    fn store_active(&mut self, address: &Address, element: Value, words: &[A::Value], active: &[A::Value]) {
        let first = self.scalar(element);
        let beyond = self.is_beyond(address, first);
        self.asm.begin_rare_if(beyond);
        self.store_each(address, element, words, Some(active));
        self.stored_to = None;
        self.asm.begin_else();
        let pointer = self.asm.buffer_pointer(address.buffer, first);
        for (k, (words, active)) in (0..).zip(words.iter().zip(active)) {
            self.asm.store_masked(pointer, k * A::LANES, *words, *active);
        }
        self.asm.end_if();
    }

    /// The words of a vector in the form in which they are stored.
    fn stored_words(&mut self, value: Value, k: usize) -> A::Value {
        let part = self.part(value, k);
        match self.program.ty(value) {
            Ty::Bool => self.masked_bits(part, 1),
            ty => self.asm.bitcast(Form::Vector(ty), Ty::U32, part),
        }
    }

    fn store_uniform(&mut self, address: &Address, value: Value, active: Option<&[A::Value]>) {
        let scalar = self.scalar(value);
        let word = match self.program.ty(value) {
            Ty::Bool => self.asm.convert(Form::One(Ty::Bool), Ty::U32, scalar),
            ty => self.asm.bitcast(Form::One(ty), Ty::U32, scalar),
        };
        let pointer = self.pointer(address);
        if let Some(active) = active {
            let any = self.any(active);
            self.asm.begin_if(any);
        }
        self.asm.store(WORD, pointer, address.offset, word);
        if active.is_some() {
            self.asm.end_if();
        }
    }

    fn store_consecutive(&mut self, address: &Address, element: Value, words: &[A::Value]) {
        let first = self.scalar(element);
        let place = self.asm.pointer_variable();
        let pointer = self.asm.buffer_pointer(address.buffer, first);
        self.asm.set(place, pointer);
        let beyond = self.is_beyond(address, first);
        let scratch = self.scratch();
        self.asm.begin_rare_if(beyond);
        let copy = self.scratch_pointer(scratch);
        self.asm.set(place, copy);
        self.asm.end_if();
        let pointer = self.asm.get(place);
        for (k, words) in (0..).zip(words) {
            self.asm.store(WORDS, pointer, k * A::LANES, *words);
        }
        self.asm.begin_rare_if(beyond);
        self.each_word(address, first, scratch, false);
        self.asm.end_if();
    }

    /// Pointers to the active lanes' elements. The last ones are kept, since a struct is stored word by word.
    fn active_pointers(&mut self, address: &Address, element: Value, active: Option<&[A::Value]>) -> Vec<A::Pointers> {
        let key = (address.buffer, element, address.stride, 0);
        if let Some((_, known)) = self.stored_to.as_ref().filter(|(other, _)| *other == key) {
            return known.clone();
        }
        let mut pointers = Vec::new();
        for k in 0..self.vectors {
            let mask = active.map(|active| active[k]);
            pointers.push(self.pointers(address, element, k, mask));
        }
        self.stored_to = Some((key, pointers.clone()));
        pointers
    }
}
