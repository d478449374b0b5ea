//! Structured control flow, and how it is made of blocks of code and jumps between them.

/// Control flow as the emitter writes it.
pub(crate) trait Structured {
    /// A computed value or pointer, valid wherever its place has already run.
    type Value: Copy;
    /// A block or loop that can be left.
    type Label: Copy;

    /// Begins the code that runs if the condition is true.
    fn begin_if(&mut self, condition: Self::Value);
    /// The same for code that hardly ever runs.
    fn begin_rare_if(&mut self, condition: Self::Value);
    /// Begins the code that runs if it is false. Optional.
    fn begin_else(&mut self);
    fn end_if(&mut self);
    fn begin_block(&mut self) -> Self::Label;
    fn end_block(&mut self);
    /// Begins a loop, which repeats until it is left.
    fn begin_loop(&mut self) -> Self::Label;
    fn end_loop(&mut self);
    /// Jumps to the end of a block or loop.
    fn leave(&mut self, label: Self::Label);
}

/// What has begun and not ended.
#[derive(Debug)]
pub(crate) struct Control<B> {
    open: Vec<Open<B>>,
    /// Number of open constructs in code that hardly ever runs, of which the last is the `if` that it stands in.
    rare: Option<usize>,
}

impl<B> Default for Control<B> {
    fn default() -> Self {
        Self {
            open: Vec::new(),
            rare: None,
        }
    }
}

/// A construct that has begun and not ended.
#[derive(Clone, Copy, Debug)]
enum Open<B> {
    /// An `if`: the block of its `else`, and the block after it.
    If(B, B),
    /// An `else`: the block after it.
    Else(B),
    /// A block: the one after it.
    Block(B),
    /// A loop: its head, and the block after it.
    Loop(B, B),
}

/// Blocks and jumps of a function, of which the constructs are made.
pub(crate) trait Blocks {
    type Value: Copy;
    /// A part of the code that is entered at its beginning alone.
    type Block: Copy;

    fn control(&mut self) -> &mut Control<Self::Block>;
    /// Creates a block, which is put aside if it hardly ever runs.
    fn create(&mut self, is_rare: bool) -> Self::Block;
    /// Puts the current block aside.
    fn mark_rare(&mut self);
    fn start(&mut self, block: Self::Block);
    /// Says that no later code jumps to a block.
    fn seal(&mut self, block: Self::Block);
    fn jump(&mut self, to: Self::Block);
    fn branch(&mut self, condition: Self::Value, accept: Self::Block, reject: Self::Block);

    fn block(&mut self) -> Self::Block {
        let is_rare = self.control().rare.is_some();
        self.create(is_rare)
    }

    fn start_sealed(&mut self, block: Self::Block) {
        self.start(block);
        self.seal(block);
    }

    /// Starts an unreachable block, for what follows a jump.
    fn start_unreachable(&mut self) {
        let block = self.block();
        self.start_sealed(block);
    }
}

impl<B: Blocks> Structured for B {
    type Value = B::Value;
    type Label = B::Block;

    fn begin_if(&mut self, condition: B::Value) {
        let [accept, reject, after] = [(); 3].map(|()| self.block());
        self.branch(condition, accept, reject);
        self.start_sealed(accept);
        self.control().open.push(Open::If(reject, after));
    }

    fn begin_rare_if(&mut self, condition: B::Value) {
        self.begin_if(condition);
        let control = self.control();
        control.rare = Some(control.open.len());
        self.mark_rare();
    }

    fn begin_else(&mut self) {
        let Some(Open::If(reject, after)) = self.control().open.pop() else {
            unreachable!("an `else` stands in an `if`")
        };
        self.jump(after);
        self.start_sealed(reject);
        self.control().open.push(Open::Else(after));
    }

    fn end_if(&mut self) {
        let control = self.control();
        if control.rare == Some(control.open.len()) {
            control.rare = None;
        }
        if let Some(Open::If(..)) = control.open.last() {
            self.begin_else();
        }
        let Some(Open::Else(after)) = self.control().open.pop() else {
            unreachable!("an `if` was begun")
        };
        self.jump(after);
        self.start_sealed(after);
    }

    fn begin_block(&mut self) -> B::Block {
        let after = self.block();
        self.control().open.push(Open::Block(after));
        after
    }

    fn end_block(&mut self) {
        let Some(Open::Block(after)) = self.control().open.pop() else {
            unreachable!("a block was begun")
        };
        self.jump(after);
        self.start_sealed(after);
    }

    fn begin_loop(&mut self) -> B::Block {
        let [head, after] = [(); 2].map(|()| self.block());
        self.jump(head);
        self.start(head);
        self.control().open.push(Open::Loop(head, after));
        after
    }

    fn end_loop(&mut self) {
        let Some(Open::Loop(head, after)) = self.control().open.pop() else {
            unreachable!("a loop was begun")
        };
        self.jump(head);
        self.seal(head);
        self.start_sealed(after);
    }

    fn leave(&mut self, after: B::Block) {
        self.jump(after);
        self.start_unreachable();
    }
}
