//! 4 lanes of WebAssembly's 128-bit vectors.

use core::arch::wasm32::*;

use super::Lanes;
use crate::kernel::Words;

/// 4 lanes. Code that has them runs only in engines that have them too: a module is refused as a whole where it is loaded.
#[derive(Clone, Copy, Debug)]
pub struct Simd128;

macro_rules! intrinsics {
    ($($name:ident($($arg:ident: $from:ident),+) -> $to:ident { $body:expr })*) => {$(
        #[inline(always)]
        unsafe fn $name($($arg: Self::$from),+) -> Self::$to { $body }
    )*};
}

impl Lanes for Simd128 {
    const N: usize = 4;
    type F = v128;
    type I = v128;
    /// All bits of a lane set or none.
    type M = v128;

    #[inline(always)]
    unsafe fn f(x: f32) -> v128 {
        f32x4_splat(x)
    }
    #[inline(always)]
    unsafe fn i(x: u32) -> v128 {
        u32x4_splat(x)
    }
    #[inline(always)]
    unsafe fn m(x: bool) -> v128 {
        u32x4_splat(if x { !0 } else { 0 })
    }
    #[inline(always)]
    unsafe fn iota(base: u32) -> v128 {
        u32x4_add(u32x4_splat(base), u32x4(0, 1, 2, 3))
    }
    intrinsics! {
        add(a: F, b: F) -> F { f32x4_add(a, b) }
        sub(a: F, b: F) -> F { f32x4_sub(a, b) }
        mul(a: F, b: F) -> F { f32x4_mul(a, b) }
        neg(a: F) -> F { f32x4_neg(a) }
        abs(a: F) -> F { f32x4_abs(a) }
        floor(a: F) -> F { f32x4_floor(a) }
        trunc(a: F) -> F { f32x4_trunc(a) }
        // Of two equal values, both have the second as the lanes of other machines do.
        min(a: F, b: F) -> F { f32x4_pmin(b, a) }
        max(a: F, b: F) -> F { f32x4_pmax(b, a) }
        lt(a: F, b: F) -> M { f32x4_lt(a, b) }
        le(a: F, b: F) -> M { f32x4_le(a, b) }
        eq(a: F, b: F) -> M { f32x4_eq(a, b) }
        fsel(m: M, a: F, b: F) -> F { v128_bitselect(a, b, m) }
        iadd(a: I, b: I) -> I { u32x4_add(a, b) }
        isub(a: I, b: I) -> I { u32x4_sub(a, b) }
        imul(a: I, b: I) -> I { u32x4_mul(a, b) }
        iand(a: I, b: I) -> I { v128_and(a, b) }
        ior(a: I, b: I) -> I { v128_or(a, b) }
        ixor(a: I, b: I) -> I { v128_xor(a, b) }
        umin(a: I, b: I) -> I { u32x4_min(a, b) }
        umax(a: I, b: I) -> I { u32x4_max(a, b) }
        smin(a: I, b: I) -> I { i32x4_min(a, b) }
        smax(a: I, b: I) -> I { i32x4_max(a, b) }
        ieq(a: I, b: I) -> M { u32x4_eq(a, b) }
        ult(a: I, b: I) -> M { u32x4_lt(a, b) }
        slt(a: I, b: I) -> M { i32x4_lt(a, b) }
        isel(m: M, a: I, b: I) -> I { v128_bitselect(a, b, m) }
        f_of_i(a: I) -> F { f32x4_convert_i32x4(a) }
        // Below 2^24, signed conversions do, and most machines have no others.
        f_of_u(a: I) -> F { f32x4_convert_i32x4(a) }
        i_of_f(a: F) -> I { i32x4_trunc_sat_f32x4(a) }
        u_of_f(a: F) -> I { i32x4_trunc_sat_f32x4(a) }
        bits(a: F) -> I { a }
        float(a: I) -> F { a }
        mand(a: M, b: M) -> M { v128_and(a, b) }
        mor(a: M, b: M) -> M { v128_or(a, b) }
        mxor(a: M, b: M) -> M { v128_xor(a, b) }
        mnot(a: M) -> M { v128_not(a) }
        mandnot(a: M, b: M) -> M { v128_andnot(a, b) }
    }
    #[inline(always)]
    unsafe fn shl(a: v128, count: u32) -> v128 {
        u32x4_shl(a, count)
    }
    #[inline(always)]
    unsafe fn shr(a: v128, count: u32) -> v128 {
        u32x4_shr(a, count)
    }
    #[inline(always)]
    unsafe fn sar(a: v128, count: u32) -> v128 {
        i32x4_shr(a, count)
    }
    lane_by_lane! { division: 0 1 2 3 }
    lane_by_lane! { shifts: 0 1 2 3 }
    lane_by_lane! { stores: 0 1 2 3 }
    lane_by_lane! { scattered_stores: 0 1 2 3 }
    #[inline(always)]
    unsafe fn any(a: v128) -> bool {
        v128_any_true(a)
    }
    #[inline(always)]
    unsafe fn test(a: v128, k: usize) -> bool {
        Self::lane(a, k) != 0
    }
    #[inline(always)]
    unsafe fn gather_words(buffer: Words, at: v128) -> v128 {
        u32x4(
            *buffer.start.add(Self::lane(at, 0) as usize),
            *buffer.start.add(Self::lane(at, 1) as usize),
            *buffer.start.add(Self::lane(at, 2) as usize),
            *buffer.start.add(Self::lane(at, 3) as usize),
        )
    }
    #[inline(always)]
    unsafe fn gather_quads(buffer: Words, at: v128) -> [v128; 4] {
        let a = Self::load_words(buffer, Self::lane(at, 0) as usize);
        let b = Self::load_words(buffer, Self::lane(at, 1) as usize);
        let c = Self::load_words(buffer, Self::lane(at, 2) as usize);
        let d = Self::load_words(buffer, Self::lane(at, 3) as usize);
        let low = [u32x4_shuffle::<0, 4, 1, 5>(a, c), u32x4_shuffle::<2, 6, 3, 7>(a, c)];
        let high = [u32x4_shuffle::<0, 4, 1, 5>(b, d), u32x4_shuffle::<2, 6, 3, 7>(b, d)];
        [
            u32x4_shuffle::<0, 4, 1, 5>(low[0], high[0]),
            u32x4_shuffle::<2, 6, 3, 7>(low[0], high[0]),
            u32x4_shuffle::<0, 4, 1, 5>(low[1], high[1]),
            u32x4_shuffle::<2, 6, 3, 7>(low[1], high[1]),
        ]
    }
    #[inline(always)]
    unsafe fn load_words(buffer: Words, at: usize) -> v128 {
        v128_load(buffer.start.add(at).cast())
    }
}
