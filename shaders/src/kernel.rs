//! A compiled kernel: one program in three forms.

use std::fmt;

/// How a kernel sees a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BindingKind {
    /// `var<uniform>`
    Uniform,
    /// `var<storage, read>`
    Read,
    /// `var<storage, read_write>`
    ReadWrite,
}

/// A buffer that a kernel binds, in group 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Binding {
    /// `@binding` number; bindings are listed in ascending order and have no gaps.
    pub binding: u32,
    /// Its name in the WGSL.
    pub name: &'static str,
    /// How it is bound.
    pub kind: BindingKind,
    /// Bytes of one element of its array, or of the whole buffer if it is no array.
    pub stride: u32,
}

/// Gives a word of a buffer: the buffer's name, the element, and the word within it. No element is that of the uniform
/// buffer and of the episode's world.
pub type WordOf<'a> = dyn Fn(&str, Option<u64>, u32) -> u32 + 'a;

/// Computes the most turns of all loops of an invocation together, given words of buffers.
#[derive(Clone, Copy)]
pub struct Turns(pub &'static (dyn Fn(&WordOf<'_>) -> u64 + Sync));

impl fmt::Debug for Turns {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Turns")
    }
}

/// One kernel, compiled.
#[derive(Clone, Copy, Debug)]
pub struct Kernel {
    /// Its name in the catalogue, or that of a kernel composed when the program runs.
    pub name: &'static str,
    /// The paths of the shipped parts that its WGSL is made of, in order; none of a kernel composed when the program runs.
    pub parts: &'static [&'static str],
    /// The concatenated WGSL, for adapters that take no SPIR-V and for code compiled at run time; empty without the feature
    /// `wgsl`.
    pub wgsl: &'static str,
    /// SPIR-V with `NoContraction` on every float arithmetic result, without float-control modes; empty without the feature
    /// `spirv`.
    pub spirv: &'static [u32],
    /// Always `main`.
    pub entry_point: &'static str,
    /// Invocations a workgroup (x; y and z are 1).
    pub workgroup_size: u32,
    /// Its buffers.
    pub bindings: &'static [Binding],
    /// The most turns of all loops of an invocation together, given words of buffers; a loop's last look at its condition
    /// is a turn. Software drivers leave loops silently after a limit.
    pub turns: Turns,
    /// The lane code compiled with the program, widest first; [`Variant::available`] tells which of them run here. A kernel
    /// composed when the program runs has none.
    pub variants: &'static [Variant],
}

impl Kernel {
    /// Bytes of one element of a buffer, by the buffer's name; 0 if it binds none of that name.
    pub fn stride(&self, name: &str) -> usize {
        let binding = self.bindings.iter().find(|binding| binding.name == name);
        binding.map_or(0, |binding| binding.stride as usize)
    }
}

/// The lane code of a kernel for one instruction set and one number of lanes.
#[derive(Clone, Copy, Debug)]
pub struct Variant {
    /// Such as `neonx16`: instruction set, `x`, lanes.
    pub name: &'static str,
    /// Invocations that one call runs; divides the workgroup size.
    pub lanes: u32,
    /// Whether this processor can run it.
    pub available: fn() -> bool,
    /// Runs `lanes` invocations.
    pub run: LaneFn,
}

/// Runs invocations `first_lane..first_lane + lanes` of one workgroup. The buffers are those of
/// [`Kernel::bindings`], in that order, none of them empty.
///
/// # Safety
/// The variant must be available on this processor; every buffer must be valid for reads, and read-write ones
/// for writes, for its whole length; what one call writes, no other call may access at the same time.
pub type LaneFn = unsafe fn(buffers: &[Words], workgroup: u32, first_lane: u32);

/// A buffer as lane code sees it: 32-bit words.
#[derive(Clone, Copy, Debug)]
pub struct Words {
    /// First word.
    pub start: *mut u32,
    /// Words.
    pub len: usize,
}
