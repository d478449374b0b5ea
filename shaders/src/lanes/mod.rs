//! Values of several lanes and the operations on them, over which lane code is generic: one implementation an
//! instruction set.
//!
//! Everything from a `#[target_feature]` wrapper down to an intrinsic is `#[inline(always)]`, without closures
//! and without the standard library's combinators in between: one function that is not inlined would be
//! compiled without the instruction set, which only a benchmark would show.
#![allow(clippy::missing_safety_doc, reason = "one reason for all: see `Lanes`")]
#![allow(missing_docs, reason = "operations are named for what they do")]
#![allow(clippy::many_single_char_names, reason = "they are lanes")]
#![allow(clippy::wildcard_imports, reason = "intrinsics name their instruction set")]
#![allow(clippy::needless_bitwise_bool, reason = "masks are combined without a branch")]
#![allow(clippy::inline_always, reason = "see above")]
#![allow(unsafe_op_in_unsafe_fn, reason = "every function here is one operation of the lanes")]

use crate::kernel::Words;

/// Operations that an instruction set lacks or that are rare, lane by lane: those named, for the lanes listed.
///
/// They are written out because LLVM would unroll each of a kernel's thousands of small loops by itself, and reconsider
/// the loops around it every time: that took four fifths of the time that all kernels took to compile.
macro_rules! lane_by_lane {
    (division: $($k:literal)+) => {
        #[inline(always)]
        unsafe fn udiv(a: Self::I, b: Self::I) -> Self::I {
            core::mem::transmute([$(super::uniform::divide(Self::lane(a, $k), Self::lane(b, $k))),+])
        }
        #[inline(always)]
        unsafe fn urem(a: Self::I, b: Self::I) -> Self::I {
            core::mem::transmute([$(super::uniform::remainder(Self::lane(a, $k), Self::lane(b, $k))),+])
        }
    };
    (shifts: $($k:literal)+) => {
        #[inline(always)]
        unsafe fn shl_each(a: Self::I, b: Self::I) -> Self::I {
            core::mem::transmute([$(Self::lane(a, $k).wrapping_shl(Self::lane(b, $k))),+])
        }
        #[inline(always)]
        unsafe fn shr_each(a: Self::I, b: Self::I) -> Self::I {
            core::mem::transmute([$(Self::lane(a, $k).wrapping_shr(Self::lane(b, $k))),+])
        }
        #[inline(always)]
        unsafe fn sar_each(a: Self::I, b: Self::I) -> Self::I {
            core::mem::transmute([$((Self::lane(a, $k) as i32).wrapping_shr(Self::lane(b, $k)) as u32),+])
        }
    };
    (stores: $($k:literal)+) => {
        #[inline(always)]
        unsafe fn store_words(buffer: crate::kernel::Words, at: usize, value: Self::I, active: Self::M) {
            $(if Self::test(active, $k) {
                *buffer.start.add(at + $k) = Self::lane(value, $k);
            })+
        }
    };
    (scattered_stores: $($k:literal)+) => {
        #[inline(always)]
        unsafe fn scatter_words(buffer: crate::kernel::Words, at: Self::I, value: Self::I, active: Self::M) {
            $(if Self::test(active, $k) {
                *buffer.start.add(Self::lane(at, $k) as usize) = Self::lane(value, $k);
            })+
        }
    };
}

mod checked;
#[cfg(target_arch = "aarch64")]
mod neon;
mod pair;
mod scalar;
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
mod simd128;
pub mod uniform;

pub use checked::Checked;
#[cfg(target_arch = "aarch64")]
pub use neon::Neon;
pub use pair::Pair;
pub use scalar::Scalar;
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
pub use simd128::Simd128;

#[cfg(all(target_arch = "arm", target_feature = "neon"))]
compile_error!("NEON on 32-bit ARM flushes subnormals: build for a target without it");
#[cfg(all(target_arch = "x86", not(target_feature = "sse2")))]
compile_error!("x87 arithmetic rounds twice: build for x86 with SSE2");

/// Aligns the stack frame of the function that it is called in to a vector.
///
/// LLVM aligns a frame only if something in it needs alignment before registers are allocated. Registers that it
/// spills afterwards would lie across two cache lines, all of them with vectors of 64 bytes.
#[inline(always)]
pub fn align_frame<V: Lanes>() {
    core::hint::black_box(&core::mem::MaybeUninit::<V::F>::uninit());
}

/// Values of [`Lanes::N`] lanes. Integers are 32 bits, signed or not as the operation says; they wrap.
///
/// # Safety
/// Every function needs the instruction set of its implementation to be there; those with a buffer also need
/// it to be valid as [`crate::LaneFn`] says. Memory is only touched within a buffer's `len`.
pub trait Lanes: Copy {
    /// How many lanes.
    const N: usize;
    /// Floats.
    type F: Copy;
    /// Integers: `N` words in memory.
    type I: Copy;
    /// Truth values.
    type M: Copy;

    unsafe fn f(x: f32) -> Self::F;
    unsafe fn i(x: u32) -> Self::I;
    unsafe fn m(x: bool) -> Self::M;
    /// `base`, `base + 1`, ..
    unsafe fn iota(base: u32) -> Self::I;

    unsafe fn add(a: Self::F, b: Self::F) -> Self::F;
    unsafe fn sub(a: Self::F, b: Self::F) -> Self::F;
    unsafe fn mul(a: Self::F, b: Self::F) -> Self::F;
    unsafe fn neg(a: Self::F) -> Self::F;
    unsafe fn abs(a: Self::F) -> Self::F;
    unsafe fn floor(a: Self::F) -> Self::F;
    unsafe fn trunc(a: Self::F) -> Self::F;
    /// `a < b ? a : b`
    unsafe fn min(a: Self::F, b: Self::F) -> Self::F;
    /// `a > b ? a : b`
    unsafe fn max(a: Self::F, b: Self::F) -> Self::F;
    unsafe fn lt(a: Self::F, b: Self::F) -> Self::M;
    unsafe fn le(a: Self::F, b: Self::F) -> Self::M;
    unsafe fn eq(a: Self::F, b: Self::F) -> Self::M;
    unsafe fn fsel(m: Self::M, a: Self::F, b: Self::F) -> Self::F;

    unsafe fn iadd(a: Self::I, b: Self::I) -> Self::I;
    unsafe fn isub(a: Self::I, b: Self::I) -> Self::I;
    unsafe fn imul(a: Self::I, b: Self::I) -> Self::I;
    unsafe fn iand(a: Self::I, b: Self::I) -> Self::I;
    unsafe fn ior(a: Self::I, b: Self::I) -> Self::I;
    unsafe fn ixor(a: Self::I, b: Self::I) -> Self::I;
    /// `count` below 32.
    unsafe fn shl(a: Self::I, count: u32) -> Self::I;
    unsafe fn shr(a: Self::I, count: u32) -> Self::I;
    unsafe fn sar(a: Self::I, count: u32) -> Self::I;
    unsafe fn umin(a: Self::I, b: Self::I) -> Self::I;
    unsafe fn umax(a: Self::I, b: Self::I) -> Self::I;
    unsafe fn smin(a: Self::I, b: Self::I) -> Self::I;
    unsafe fn smax(a: Self::I, b: Self::I) -> Self::I;
    unsafe fn ieq(a: Self::I, b: Self::I) -> Self::M;
    unsafe fn ult(a: Self::I, b: Self::I) -> Self::M;
    unsafe fn slt(a: Self::I, b: Self::I) -> Self::M;
    unsafe fn isel(m: Self::M, a: Self::I, b: Self::I) -> Self::I;

    unsafe fn f_of_i(a: Self::I) -> Self::F;
    /// Below 2^24.
    unsafe fn f_of_u(a: Self::I) -> Self::F;
    /// Towards zero; in range.
    unsafe fn i_of_f(a: Self::F) -> Self::I;
    /// Towards zero; in `0..2^24`.
    unsafe fn u_of_f(a: Self::F) -> Self::I;
    unsafe fn bits(a: Self::F) -> Self::I;
    unsafe fn float(a: Self::I) -> Self::F;

    unsafe fn mand(a: Self::M, b: Self::M) -> Self::M;
    unsafe fn mor(a: Self::M, b: Self::M) -> Self::M;
    unsafe fn mxor(a: Self::M, b: Self::M) -> Self::M;
    unsafe fn mnot(a: Self::M) -> Self::M;
    /// `a & !b`
    unsafe fn mandnot(a: Self::M, b: Self::M) -> Self::M;
    unsafe fn any(a: Self::M) -> bool;
    /// Whether lane `k` is set.
    unsafe fn test(a: Self::M, k: usize) -> bool;

    /// The words at these indices, which lie within the buffer.
    unsafe fn gather_words(buffer: Words, at: Self::I) -> Self::I;
    /// Four words from each of these indices on, which lie within the buffer.
    unsafe fn gather_quads(buffer: Words, at: Self::I) -> [Self::I; 4];
    /// `N` words from this index on, which lie within the buffer.
    unsafe fn load_words(buffer: Words, at: usize) -> Self::I;
    /// Stores the active ones of `N` words from this index on, which lie within the buffer.
    unsafe fn store_words(buffer: Words, at: usize, value: Self::I, active: Self::M);
    /// Stores the active ones of `N` words at these indices, which lie within the buffer, in the lanes' order.
    unsafe fn scatter_words(buffer: Words, at: Self::I, value: Self::I, active: Self::M);

    unsafe fn udiv(a: Self::I, b: Self::I) -> Self::I;
    unsafe fn urem(a: Self::I, b: Self::I) -> Self::I;
    // Shifts by counts of each lane, modulo 32.
    unsafe fn shl_each(a: Self::I, b: Self::I) -> Self::I;
    unsafe fn shr_each(a: Self::I, b: Self::I) -> Self::I;
    unsafe fn sar_each(a: Self::I, b: Self::I) -> Self::I;

    #[inline(always)]
    unsafe fn msel(m: Self::M, a: Self::M, b: Self::M) -> Self::M {
        Self::mor(Self::mand(m, a), Self::mandnot(b, m))
    }

    /// Lane `k` of an integer.
    #[inline(always)]
    unsafe fn lane(a: Self::I, k: usize) -> u32 {
        *core::ptr::addr_of!(a).cast::<u32>().add(k)
    }

    // The kernels' buffer accesses: element `e`, clamped below `n` as SPIR-V's is, of `stride` words,
    // and the word `offset` in it.

    /// The word at a uniform place.
    #[inline(always)]
    unsafe fn word(buffer: Words, e: u32, n: u32, stride: u32, offset: u32) -> u32 {
        let element = if stride == 0 { 0 } else { uniform::min(e, n - 1) };
        *buffer.start.add(element as usize * stride as usize + offset as usize)
    }

    /// The index of a word for each lane.
    #[inline(always)]
    unsafe fn index(e: Self::I, n: u32, stride: u32, offset: u32) -> Self::I {
        let mut at = Self::umin(e, Self::i(n - 1));
        if stride != 1 {
            at = if stride.is_power_of_two() {
                Self::shl(at, stride.trailing_zeros())
            } else {
                Self::imul(at, Self::i(stride))
            };
        }
        if offset != 0 {
            at = Self::iadd(at, Self::i(offset));
        }
        at
    }

    /// A word for each lane.
    #[inline(always)]
    unsafe fn gather(buffer: Words, e: Self::I, n: u32, stride: u32, offset: u32) -> Self::I {
        Self::gather_words(buffer, Self::index(e, n, stride, offset))
    }

    /// Four consecutive words for each lane.
    #[inline(always)]
    unsafe fn quad(buffer: Words, e: Self::I, n: u32, stride: u32, offset: u32) -> [Self::I; 4] {
        Self::gather_quads(buffer, Self::index(e, n, stride, offset))
    }

    /// Word elements `e`, `e + 1`, .. of the lanes.
    #[inline(always)]
    unsafe fn load(buffer: Words, e: u32, n: u32, offset: u32) -> Self::I {
        if e as usize + Self::N <= n as usize {
            Self::load_words(buffer, e as usize + offset as usize)
        } else {
            Self::gather(buffer, Self::iota(e), n, 1, offset)
        }
    }

    /// Stores a word for each active lane, in the lanes' order.
    #[inline(always)]
    unsafe fn store(buffer: Words, e: Self::I, n: u32, stride: u32, offset: u32, value: Self::I, active: Self::M) {
        Self::scatter_words(buffer, Self::index(e, n, stride, offset), value, active);
    }

    /// Stores word elements `e`, `e + 1`, .. of the active lanes.
    #[inline(always)]
    unsafe fn save(buffer: Words, e: u32, n: u32, offset: u32, value: Self::I, active: Self::M) {
        if e as usize + Self::N <= n as usize {
            Self::store_words(buffer, e as usize + offset as usize, value, active);
        } else {
            Self::store(buffer, Self::iota(e), n, 1, offset, value, active);
        }
    }

    /// Stores a word at a uniform place if any lane is active.
    #[inline(always)]
    unsafe fn store_word(buffer: Words, e: u32, n: u32, stride: u32, offset: u32, value: u32, active: Self::M) {
        if Self::any(active) {
            let element = if stride == 0 { 0 } else { uniform::min(e, n - 1) };
            *buffer.start.add(element as usize * stride as usize + offset as usize) = value;
        }
    }
}
