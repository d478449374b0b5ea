//! 4 lanes of SSE4.1.

use core::arch::x86_64::*;

use super::Lanes;
use crate::kernel::Words;

/// 4 lanes; needs SSE4.1.
#[derive(Clone, Copy, Debug)]
pub struct Sse41;

macro_rules! intrinsics {
    ($($name:ident($($arg:ident: $from:ident),+) -> $to:ident { $body:expr })*) => {$(
        #[inline(always)]
        unsafe fn $name($($arg: Self::$from),+) -> Self::$to { $body }
    )*};
}

impl Lanes for Sse41 {
    const N: usize = 4;
    type F = __m128;
    type I = __m128i;
    /// All bits of a lane set or none.
    type M = __m128;

    #[inline(always)]
    unsafe fn f(x: f32) -> __m128 {
        _mm_set1_ps(x)
    }
    #[inline(always)]
    unsafe fn i(x: u32) -> __m128i {
        _mm_set1_epi32(x as i32)
    }
    #[inline(always)]
    unsafe fn m(x: bool) -> __m128 {
        _mm_castsi128_ps(_mm_set1_epi32(-i32::from(x)))
    }
    #[inline(always)]
    unsafe fn iota(base: u32) -> __m128i {
        _mm_add_epi32(_mm_set1_epi32(base as i32), _mm_setr_epi32(0, 1, 2, 3))
    }
    intrinsics! {
        add(a: F, b: F) -> F { _mm_add_ps(a, b) }
        sub(a: F, b: F) -> F { _mm_sub_ps(a, b) }
        mul(a: F, b: F) -> F { _mm_mul_ps(a, b) }
        neg(a: F) -> F { _mm_xor_ps(a, _mm_set1_ps(-0.0)) }
        abs(a: F) -> F { _mm_andnot_ps(_mm_set1_ps(-0.0), a) }
        floor(a: F) -> F { _mm_floor_ps(a) }
        trunc(a: F) -> F { _mm_round_ps::<0x0b>(a) }
        min(a: F, b: F) -> F { _mm_min_ps(a, b) }
        max(a: F, b: F) -> F { _mm_max_ps(a, b) }
        lt(a: F, b: F) -> M { _mm_cmplt_ps(a, b) }
        le(a: F, b: F) -> M { _mm_cmple_ps(a, b) }
        eq(a: F, b: F) -> M { _mm_cmpeq_ps(a, b) }
        fsel(m: M, a: F, b: F) -> F { _mm_blendv_ps(b, a, m) }
        iadd(a: I, b: I) -> I { _mm_add_epi32(a, b) }
        isub(a: I, b: I) -> I { _mm_sub_epi32(a, b) }
        imul(a: I, b: I) -> I { _mm_mullo_epi32(a, b) }
        iand(a: I, b: I) -> I { _mm_and_si128(a, b) }
        ior(a: I, b: I) -> I { _mm_or_si128(a, b) }
        ixor(a: I, b: I) -> I { _mm_xor_si128(a, b) }
        umin(a: I, b: I) -> I { _mm_min_epu32(a, b) }
        umax(a: I, b: I) -> I { _mm_max_epu32(a, b) }
        smin(a: I, b: I) -> I { _mm_min_epi32(a, b) }
        smax(a: I, b: I) -> I { _mm_max_epi32(a, b) }
        ieq(a: I, b: I) -> M { _mm_castsi128_ps(_mm_cmpeq_epi32(a, b)) }
        ult(a: I, b: I) -> M { Self::mnot(_mm_castsi128_ps(_mm_cmpeq_epi32(_mm_max_epu32(a, b), a))) }
        slt(a: I, b: I) -> M { _mm_castsi128_ps(_mm_cmplt_epi32(a, b)) }
        isel(m: M, a: I, b: I) -> I { Self::bits(_mm_blendv_ps(Self::float(b), Self::float(a), m)) }
        f_of_i(a: I) -> F { _mm_cvtepi32_ps(a) }
        f_of_u(a: I) -> F { _mm_cvtepi32_ps(a) }
        i_of_f(a: F) -> I { _mm_cvttps_epi32(a) }
        u_of_f(a: F) -> I { _mm_cvttps_epi32(a) }
        bits(a: F) -> I { _mm_castps_si128(a) }
        float(a: I) -> F { _mm_castsi128_ps(a) }
        mand(a: M, b: M) -> M { _mm_and_ps(a, b) }
        mor(a: M, b: M) -> M { _mm_or_ps(a, b) }
        mxor(a: M, b: M) -> M { _mm_xor_ps(a, b) }
        mnot(a: M) -> M { _mm_xor_ps(a, Self::m(true)) }
        mandnot(a: M, b: M) -> M { _mm_andnot_ps(b, a) }
    }
    #[inline(always)]
    unsafe fn shl(a: __m128i, count: u32) -> __m128i {
        _mm_sll_epi32(a, _mm_cvtsi32_si128(count as i32))
    }
    #[inline(always)]
    unsafe fn shr(a: __m128i, count: u32) -> __m128i {
        _mm_srl_epi32(a, _mm_cvtsi32_si128(count as i32))
    }
    #[inline(always)]
    unsafe fn sar(a: __m128i, count: u32) -> __m128i {
        _mm_sra_epi32(a, _mm_cvtsi32_si128(count as i32))
    }
    lane_by_lane! { division: 0 1 2 3 }
    lane_by_lane! { shifts: 0 1 2 3 }
    lane_by_lane! { stores: 0 1 2 3 }
    lane_by_lane! { scattered_stores: 0 1 2 3 }
    #[inline(always)]
    unsafe fn any(a: __m128) -> bool {
        _mm_movemask_ps(a) != 0
    }
    #[inline(always)]
    unsafe fn test(a: __m128, k: usize) -> bool {
        _mm_movemask_ps(a) >> k & 1 != 0
    }
    #[inline(always)]
    unsafe fn gather_words(buffer: Words, at: __m128i) -> __m128i {
        _mm_setr_epi32(
            *buffer.start.add(Self::lane(at, 0) as usize) as i32,
            *buffer.start.add(Self::lane(at, 1) as usize) as i32,
            *buffer.start.add(Self::lane(at, 2) as usize) as i32,
            *buffer.start.add(Self::lane(at, 3) as usize) as i32,
        )
    }
    #[inline(always)]
    unsafe fn gather_quads(buffer: Words, at: __m128i) -> [__m128i; 4] {
        let rows = [
            quad::<0>(buffer, at),
            quad::<1>(buffer, at),
            quad::<2>(buffer, at),
            quad::<3>(buffer, at),
        ];
        let low_01 = _mm_unpacklo_epi32(rows[0], rows[1]);
        let high_01 = _mm_unpackhi_epi32(rows[0], rows[1]);
        let low_23 = _mm_unpacklo_epi32(rows[2], rows[3]);
        let high_23 = _mm_unpackhi_epi32(rows[2], rows[3]);
        [
            _mm_unpacklo_epi64(low_01, low_23),
            _mm_unpackhi_epi64(low_01, low_23),
            _mm_unpacklo_epi64(high_01, high_23),
            _mm_unpackhi_epi64(high_01, high_23),
        ]
    }
    #[inline(always)]
    unsafe fn load_words(buffer: Words, at: usize) -> __m128i {
        _mm_loadu_si128(buffer.start.add(at).cast())
    }
}

/// The four words from lane `J`'s index on.
#[inline(always)]
unsafe fn quad<const J: usize>(buffer: Words, at: __m128i) -> __m128i {
    _mm_loadu_si128(buffer.start.add(Sse41::lane(at, J) as usize).cast())
}
