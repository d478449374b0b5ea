//! Several vectors side by side: more lanes than a register has.

use super::Lanes;
use crate::kernel::Words;

/// `K` times the lanes of `S`.
#[derive(Clone, Copy, Debug)]
pub struct Wide<S, const K: usize>(core::marker::PhantomData<S>);

macro_rules! lanewise {
    ($($name:ident($($arg:ident: $from:ident),+) -> $to:ident;)*) => {$(
        #[inline(always)]
        unsafe fn $name($($arg: Self::$from),+) -> Self::$to {
            // Every element is written below; all bits zero is a value of every vector and mask.
            let mut out: Self::$to = core::mem::zeroed();
            let mut k = 0;
            while k < K {
                out[k] = S::$name($($arg[k]),+);
                k += 1;
            }
            out
        }
    )*};
}

macro_rules! shifts {
    ($($name:ident)*) => {$(
        #[inline(always)]
        unsafe fn $name(a: Self::I, count: u32) -> Self::I {
            let mut out = a;
            let mut k = 0;
            while k < K {
                out[k] = S::$name(a[k], count);
                k += 1;
            }
            out
        }
    )*};
}

impl<S: Lanes, const K: usize> Lanes for Wide<S, K> {
    const N: usize = S::N * K;
    type F = [S::F; K];
    type I = [S::I; K];
    type M = [S::M; K];

    #[inline(always)]
    unsafe fn f(x: f32) -> Self::F {
        [S::f(x); K]
    }
    #[inline(always)]
    unsafe fn i(x: u32) -> Self::I {
        [S::i(x); K]
    }
    #[inline(always)]
    unsafe fn m(x: bool) -> Self::M {
        [S::m(x); K]
    }
    #[inline(always)]
    unsafe fn iota(base: u32) -> Self::I {
        let mut out = [S::i(0); K];
        let mut k = 0;
        while k < K {
            out[k] = S::iota(base.wrapping_add((k * S::N) as u32));
            k += 1;
        }
        out
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
    }
    shifts! { shl shr sar }

    #[inline(always)]
    unsafe fn any(a: Self::M) -> bool {
        let mut all = a[0];
        let mut k = 1;
        while k < K {
            all = S::mor(all, a[k]);
            k += 1;
        }
        S::any(all)
    }
    #[inline(always)]
    unsafe fn test(a: Self::M, k: usize) -> bool {
        S::test(a[k / S::N], k % S::N)
    }

    #[inline(always)]
    unsafe fn gather_words(buffer: Words, at: Self::I) -> Self::I {
        let mut out = at;
        let mut k = 0;
        while k < K {
            out[k] = S::gather_words(buffer, at[k]);
            k += 1;
        }
        out
    }
    #[inline(always)]
    unsafe fn gather_quads(buffer: Words, at: Self::I) -> [Self::I; 4] {
        let mut out = [at; 4];
        let mut k = 0;
        while k < K {
            let quad = S::gather_quads(buffer, at[k]);
            out[0][k] = quad[0];
            out[1][k] = quad[1];
            out[2][k] = quad[2];
            out[3][k] = quad[3];
            k += 1;
        }
        out
    }
    #[inline(always)]
    unsafe fn load_words(buffer: Words, at: usize) -> Self::I {
        let mut out = [S::i(0); K];
        let mut k = 0;
        while k < K {
            out[k] = S::load_words(buffer, at + k * S::N);
            k += 1;
        }
        out
    }
    #[inline(always)]
    unsafe fn store_words(buffer: Words, at: usize, value: Self::I, active: Self::M) {
        let mut k = 0;
        while k < K {
            S::store_words(buffer, at + k * S::N, value[k], active[k]);
            k += 1;
        }
    }
}
