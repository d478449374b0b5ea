//! Two of a kind side by side: more lanes than a register has.

use super::Lanes;
use crate::kernel::Words;

/// Twice the lanes of `S`; a `Pair` of `Pair`s has four times as many.
///
/// There are no loops over the two: LLVM would unroll each of the thousands in a kernel one by one, and reconsider the
/// loops around it every time, which took five times as long as everything else.
#[derive(Clone, Copy, Debug)]
pub struct Pair<S>(core::marker::PhantomData<S>);

macro_rules! lanewise {
    ($($name:ident($($arg:ident: $from:ident),+) -> $to:ident;)*) => {$(
        #[inline(always)]
        unsafe fn $name($($arg: Self::$from),+) -> Self::$to {
            [S::$name($($arg[0]),+), S::$name($($arg[1]),+)]
        }
    )*};
}

macro_rules! shifts {
    ($($name:ident)*) => {$(
        #[inline(always)]
        unsafe fn $name(a: Self::I, count: u32) -> Self::I {
            [S::$name(a[0], count), S::$name(a[1], count)]
        }
    )*};
}

impl<S: Lanes> Lanes for Pair<S> {
    const N: usize = 2 * S::N;
    type F = [S::F; 2];
    type I = [S::I; 2];
    type M = [S::M; 2];

    #[inline(always)]
    unsafe fn f(x: f32) -> Self::F {
        [S::f(x), S::f(x)]
    }
    #[inline(always)]
    unsafe fn i(x: u32) -> Self::I {
        [S::i(x), S::i(x)]
    }
    #[inline(always)]
    unsafe fn m(x: bool) -> Self::M {
        [S::m(x), S::m(x)]
    }
    #[inline(always)]
    unsafe fn iota(base: u32) -> Self::I {
        [S::iota(base), S::iota(base.wrapping_add(S::N as u32))]
    }

    lanewise! {
        add(a: F, b: F) -> F;
        sub(a: F, b: F) -> F;
        mul(a: F, b: F) -> F;
        neg(a: F) -> F;
        abs(a: F) -> F;
        floor(a: F) -> F;
        trunc(a: F) -> F;
        min(a: F, b: F) -> F;
        max(a: F, b: F) -> F;
        lt(a: F, b: F) -> M;
        le(a: F, b: F) -> M;
        eq(a: F, b: F) -> M;
        fsel(m: M, a: F, b: F) -> F;
        iadd(a: I, b: I) -> I;
        isub(a: I, b: I) -> I;
        imul(a: I, b: I) -> I;
        iand(a: I, b: I) -> I;
        ior(a: I, b: I) -> I;
        ixor(a: I, b: I) -> I;
        umin(a: I, b: I) -> I;
        umax(a: I, b: I) -> I;
        smin(a: I, b: I) -> I;
        smax(a: I, b: I) -> I;
        ieq(a: I, b: I) -> M;
        ult(a: I, b: I) -> M;
        slt(a: I, b: I) -> M;
        isel(m: M, a: I, b: I) -> I;
        f_of_i(a: I) -> F;
        f_of_u(a: I) -> F;
        i_of_f(a: F) -> I;
        u_of_f(a: F) -> I;
        bits(a: F) -> I;
        float(a: I) -> F;
        mand(a: M, b: M) -> M;
        mor(a: M, b: M) -> M;
        mxor(a: M, b: M) -> M;
        mnot(a: M) -> M;
        mandnot(a: M, b: M) -> M;
        udiv(a: I, b: I) -> I;
        urem(a: I, b: I) -> I;
        shl_each(a: I, b: I) -> I;
        shr_each(a: I, b: I) -> I;
        sar_each(a: I, b: I) -> I;
    }
    shifts! { shl shr sar }

    #[inline(always)]
    unsafe fn any(a: Self::M) -> bool {
        S::any(S::mor(a[0], a[1]))
    }
    #[inline(always)]
    unsafe fn test(a: Self::M, k: usize) -> bool {
        S::test(a[k / S::N], k % S::N)
    }

    #[inline(always)]
    unsafe fn gather_words(buffer: Words, at: Self::I) -> Self::I {
        [S::gather_words(buffer, at[0]), S::gather_words(buffer, at[1])]
    }
    #[inline(always)]
    unsafe fn gather_quads(buffer: Words, at: Self::I) -> [Self::I; 4] {
        let a = S::gather_quads(buffer, at[0]);
        let b = S::gather_quads(buffer, at[1]);
        [[a[0], b[0]], [a[1], b[1]], [a[2], b[2]], [a[3], b[3]]]
    }
    #[inline(always)]
    unsafe fn load_words(buffer: Words, at: usize) -> Self::I {
        [S::load_words(buffer, at), S::load_words(buffer, at + S::N)]
    }
    #[inline(always)]
    unsafe fn scatter_words(buffer: Words, at: Self::I, value: Self::I, active: Self::M) {
        S::scatter_words(buffer, at[0], value[0], active[0]);
        S::scatter_words(buffer, at[1], value[1], active[1]);
    }
    #[inline(always)]
    unsafe fn store_words(buffer: Words, at: usize, value: Self::I, active: Self::M) {
        S::store_words(buffer, at, value[0], active[0]);
        S::store_words(buffer, at + S::N, value[1], active[1]);
    }
}
