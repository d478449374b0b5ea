//! One lane, for machines without a vector unit that we know.

use super::{Lanes, uniform};
use crate::kernel::Words;

/// One lane in plain Rust.
#[derive(Clone, Copy, Debug)]
pub struct Scalar;

macro_rules! plain {
    ($($name:ident($($arg:ident: $from:ident),+) -> $to:ident { $body:expr })*) => {$(
        #[inline(always)]
        unsafe fn $name($($arg: Self::$from),+) -> Self::$to { $body }
    )*};
}

impl Lanes for Scalar {
    const N: usize = 1;
    type F = f32;
    type I = u32;
    type M = bool;

    #[inline(always)]
    unsafe fn f(x: f32) -> f32 {
        x
    }
    #[inline(always)]
    unsafe fn i(x: u32) -> u32 {
        x
    }
    #[inline(always)]
    unsafe fn m(x: bool) -> bool {
        x
    }
    #[inline(always)]
    unsafe fn iota(base: u32) -> u32 {
        base
    }
    plain! {
        add(a: F, b: F) -> F { a + b }
        sub(a: F, b: F) -> F { a - b }
        mul(a: F, b: F) -> F { a * b }
        neg(a: F) -> F { -a }
        abs(a: F) -> F { a.abs() }
        floor(a: F) -> F { uniform::floor(a) }
        trunc(a: F) -> F { uniform::trunc(a) }
        min(a: F, b: F) -> F { uniform::min(a, b) }
        max(a: F, b: F) -> F { uniform::max(a, b) }
        lt(a: F, b: F) -> M { a < b }
        le(a: F, b: F) -> M { a <= b }
        eq(a: F, b: F) -> M { a == b }
        fsel(m: M, a: F, b: F) -> F { if m { a } else { b } }
        iadd(a: I, b: I) -> I { a.wrapping_add(b) }
        isub(a: I, b: I) -> I { a.wrapping_sub(b) }
        imul(a: I, b: I) -> I { a.wrapping_mul(b) }
        iand(a: I, b: I) -> I { a & b }
        ior(a: I, b: I) -> I { a | b }
        ixor(a: I, b: I) -> I { a ^ b }
        umin(a: I, b: I) -> I { uniform::min(a, b) }
        umax(a: I, b: I) -> I { uniform::max(a, b) }
        smin(a: I, b: I) -> I { uniform::min(a as i32, b as i32) as u32 }
        smax(a: I, b: I) -> I { uniform::max(a as i32, b as i32) as u32 }
        ieq(a: I, b: I) -> M { a == b }
        ult(a: I, b: I) -> M { a < b }
        slt(a: I, b: I) -> M { (a as i32) < (b as i32) }
        isel(m: M, a: I, b: I) -> I { if m { a } else { b } }
        f_of_i(a: I) -> F { a as i32 as f32 }
        f_of_u(a: I) -> F { a as i32 as f32 }
        i_of_f(a: F) -> I { a as i32 as u32 }
        u_of_f(a: F) -> I { a as i32 as u32 }
        bits(a: F) -> I { a.to_bits() }
        float(a: I) -> F { f32::from_bits(a) }
        mand(a: M, b: M) -> M { a & b }
        mor(a: M, b: M) -> M { a | b }
        mxor(a: M, b: M) -> M { a ^ b }
        mnot(a: M) -> M { !a }
        mandnot(a: M, b: M) -> M { a & !b }
    }
    #[inline(always)]
    unsafe fn shl(a: u32, count: u32) -> u32 {
        a.wrapping_shl(count)
    }
    #[inline(always)]
    unsafe fn shr(a: u32, count: u32) -> u32 {
        a.wrapping_shr(count)
    }
    #[inline(always)]
    unsafe fn sar(a: u32, count: u32) -> u32 {
        (a as i32).wrapping_shr(count) as u32
    }
    lane_by_lane! { division: 0 }
    lane_by_lane! { shifts: 0 }
    lane_by_lane! { stores: 0 }
    lane_by_lane! { scattered_stores: 0 }
    #[inline(always)]
    unsafe fn any(a: bool) -> bool {
        a
    }
    #[inline(always)]
    unsafe fn test(a: bool, _k: usize) -> bool {
        a
    }
    #[inline(always)]
    unsafe fn gather_words(buffer: Words, at: u32) -> u32 {
        *buffer.start.add(at as usize)
    }
    #[inline(always)]
    unsafe fn gather_quads(buffer: Words, at: u32) -> [u32; 4] {
        let start = buffer.start.add(at as usize);
        [*start, *start.add(1), *start.add(2), *start.add(3)]
    }
    #[inline(always)]
    unsafe fn load_words(buffer: Words, at: usize) -> u32 {
        *buffer.start.add(at)
    }
}
