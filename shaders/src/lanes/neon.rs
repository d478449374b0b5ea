//! 4 lanes of 64-bit ARM's NEON.

use core::arch::aarch64::*;

use super::Lanes;
use crate::kernel::Words;

/// 4 lanes; every 64-bit ARM has them.
#[derive(Clone, Copy, Debug)]
pub struct Neon;

macro_rules! intrinsics {
    ($($name:ident($($arg:ident: $from:ident),+) -> $to:ident { $body:expr })*) => {$(
        #[inline(always)]
        unsafe fn $name($($arg: Self::$from),+) -> Self::$to { $body }
    )*};
}

impl Lanes for Neon {
    const N: usize = 4;
    type F = float32x4_t;
    type I = uint32x4_t;
    /// All bits of a lane set or none.
    type M = uint32x4_t;

    #[inline(always)]
    unsafe fn f(x: f32) -> float32x4_t {
        vdupq_n_f32(x)
    }
    #[inline(always)]
    unsafe fn i(x: u32) -> uint32x4_t {
        vdupq_n_u32(x)
    }
    #[inline(always)]
    unsafe fn m(x: bool) -> uint32x4_t {
        vdupq_n_u32(if x { !0 } else { 0 })
    }
    #[inline(always)]
    unsafe fn iota(base: u32) -> uint32x4_t {
        let steps = [0, 1, 2, 3];
        vaddq_u32(vdupq_n_u32(base), vld1q_u32(steps.as_ptr()))
    }
    intrinsics! {
        add(a: F, b: F) -> F { vaddq_f32(a, b) }
        sub(a: F, b: F) -> F { vsubq_f32(a, b) }
        mul(a: F, b: F) -> F { vmulq_f32(a, b) }
        neg(a: F) -> F { vnegq_f32(a) }
        abs(a: F) -> F { vabsq_f32(a) }
        floor(a: F) -> F { vrndmq_f32(a) }
        trunc(a: F) -> F { vrndq_f32(a) }
        min(a: F, b: F) -> F { vbslq_f32(vcltq_f32(a, b), a, b) }
        max(a: F, b: F) -> F { vbslq_f32(vcgtq_f32(a, b), a, b) }
        lt(a: F, b: F) -> M { vcltq_f32(a, b) }
        le(a: F, b: F) -> M { vcleq_f32(a, b) }
        eq(a: F, b: F) -> M { vceqq_f32(a, b) }
        fsel(m: M, a: F, b: F) -> F { vbslq_f32(m, a, b) }
        iadd(a: I, b: I) -> I { vaddq_u32(a, b) }
        isub(a: I, b: I) -> I { vsubq_u32(a, b) }
        imul(a: I, b: I) -> I { vmulq_u32(a, b) }
        iand(a: I, b: I) -> I { vandq_u32(a, b) }
        ior(a: I, b: I) -> I { vorrq_u32(a, b) }
        ixor(a: I, b: I) -> I { veorq_u32(a, b) }
        umin(a: I, b: I) -> I { vminq_u32(a, b) }
        umax(a: I, b: I) -> I { vmaxq_u32(a, b) }
        smin(a: I, b: I) -> I {
            vreinterpretq_u32_s32(vminq_s32(vreinterpretq_s32_u32(a), vreinterpretq_s32_u32(b)))
        }
        smax(a: I, b: I) -> I {
            vreinterpretq_u32_s32(vmaxq_s32(vreinterpretq_s32_u32(a), vreinterpretq_s32_u32(b)))
        }
        ieq(a: I, b: I) -> M { vceqq_u32(a, b) }
        ult(a: I, b: I) -> M { vcltq_u32(a, b) }
        slt(a: I, b: I) -> M { vcltq_s32(vreinterpretq_s32_u32(a), vreinterpretq_s32_u32(b)) }
        isel(m: M, a: I, b: I) -> I { vbslq_u32(m, a, b) }
        f_of_i(a: I) -> F { vcvtq_f32_s32(vreinterpretq_s32_u32(a)) }
        f_of_u(a: I) -> F { vcvtq_f32_u32(a) }
        i_of_f(a: F) -> I { vreinterpretq_u32_s32(vcvtq_s32_f32(a)) }
        u_of_f(a: F) -> I { vcvtq_u32_f32(a) }
        bits(a: F) -> I { vreinterpretq_u32_f32(a) }
        float(a: I) -> F { vreinterpretq_f32_u32(a) }
        mand(a: M, b: M) -> M { vandq_u32(a, b) }
        mor(a: M, b: M) -> M { vorrq_u32(a, b) }
        mxor(a: M, b: M) -> M { veorq_u32(a, b) }
        mnot(a: M) -> M { vmvnq_u32(a) }
        mandnot(a: M, b: M) -> M { vbicq_u32(a, b) }
    }
    #[inline(always)]
    unsafe fn shl(a: uint32x4_t, count: u32) -> uint32x4_t {
        vshlq_u32(a, vdupq_n_s32(count as i32))
    }
    #[inline(always)]
    unsafe fn shr(a: uint32x4_t, count: u32) -> uint32x4_t {
        vshlq_u32(a, vdupq_n_s32(-(count as i32)))
    }
    #[inline(always)]
    unsafe fn sar(a: uint32x4_t, count: u32) -> uint32x4_t {
        vreinterpretq_u32_s32(vshlq_s32(vreinterpretq_s32_u32(a), vdupq_n_s32(-(count as i32))))
    }
    lane_by_lane! { division: 0 1 2 3 }
    lane_by_lane! { shifts: 0 1 2 3 }
    lane_by_lane! { stores: 0 1 2 3 }
    lane_by_lane! { scattered_stores: 0 1 2 3 }
    #[inline(always)]
    unsafe fn any(a: uint32x4_t) -> bool {
        vmaxvq_u32(a) != 0
    }
    #[inline(always)]
    unsafe fn test(a: uint32x4_t, k: usize) -> bool {
        Self::lane(a, k) != 0
    }
    #[inline(always)]
    unsafe fn gather_words(buffer: Words, at: uint32x4_t) -> uint32x4_t {
        let words = [
            *buffer.start.add(Self::lane(at, 0) as usize),
            *buffer.start.add(Self::lane(at, 1) as usize),
            *buffer.start.add(Self::lane(at, 2) as usize),
            *buffer.start.add(Self::lane(at, 3) as usize),
        ];
        vld1q_u32(words.as_ptr())
    }
    #[inline(always)]
    unsafe fn gather_quads(buffer: Words, at: uint32x4_t) -> [uint32x4_t; 4] {
        let a = vld1q_u32(buffer.start.add(Self::lane(at, 0) as usize));
        let b = vld1q_u32(buffer.start.add(Self::lane(at, 1) as usize));
        let c = vld1q_u32(buffer.start.add(Self::lane(at, 2) as usize));
        let d = vld1q_u32(buffer.start.add(Self::lane(at, 3) as usize));
        let low = vzipq_u32(a, c);
        let high = vzipq_u32(b, d);
        let first = vzipq_u32(low.0, high.0);
        let last = vzipq_u32(low.1, high.1);
        [first.0, first.1, last.0, last.1]
    }
    #[inline(always)]
    unsafe fn load_words(buffer: Words, at: usize) -> uint32x4_t {
        vld1q_u32(buffer.start.add(at))
    }
}
