//! 8 lanes of AVX2.

use core::arch::x86_64::*;

use super::Lanes;
use crate::kernel::Words;

/// 8 lanes; needs AVX2.
#[derive(Clone, Copy, Debug)]
pub struct Avx2;

macro_rules! intrinsics {
    ($($name:ident($($arg:ident: $from:ident),+) -> $to:ident { $body:expr })*) => {$(
        #[inline(always)]
        unsafe fn $name($($arg: Self::$from),+) -> Self::$to { $body }
    )*};
}

impl Lanes for Avx2 {
    const N: usize = 8;
    type F = __m256;
    type I = __m256i;
    /// All bits of a lane set or none.
    type M = __m256;

    #[inline(always)]
    unsafe fn f(x: f32) -> __m256 {
        _mm256_set1_ps(x)
    }
    #[inline(always)]
    unsafe fn i(x: u32) -> __m256i {
        _mm256_set1_epi32(x as i32)
    }
    #[inline(always)]
    unsafe fn m(x: bool) -> __m256 {
        _mm256_castsi256_ps(_mm256_set1_epi32(-i32::from(x)))
    }
    #[inline(always)]
    unsafe fn iota(base: u32) -> __m256i {
        _mm256_add_epi32(
            _mm256_set1_epi32(base as i32),
            _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7),
        )
    }
    intrinsics! {
        add(a: F, b: F) -> F { _mm256_add_ps(a, b) }
        sub(a: F, b: F) -> F { _mm256_sub_ps(a, b) }
        mul(a: F, b: F) -> F { _mm256_mul_ps(a, b) }
        neg(a: F) -> F { _mm256_xor_ps(a, _mm256_set1_ps(-0.0)) }
        abs(a: F) -> F { _mm256_andnot_ps(_mm256_set1_ps(-0.0), a) }
        floor(a: F) -> F { _mm256_floor_ps(a) }
        trunc(a: F) -> F { _mm256_round_ps::<0x0b>(a) }
        min(a: F, b: F) -> F { _mm256_min_ps(a, b) }
        max(a: F, b: F) -> F { _mm256_max_ps(a, b) }
        lt(a: F, b: F) -> M { _mm256_cmp_ps::<_CMP_LT_OQ>(a, b) }
        le(a: F, b: F) -> M { _mm256_cmp_ps::<_CMP_LE_OQ>(a, b) }
        eq(a: F, b: F) -> M { _mm256_cmp_ps::<_CMP_EQ_OQ>(a, b) }
        fsel(m: M, a: F, b: F) -> F { _mm256_blendv_ps(b, a, m) }
        iadd(a: I, b: I) -> I { _mm256_add_epi32(a, b) }
        isub(a: I, b: I) -> I { _mm256_sub_epi32(a, b) }
        imul(a: I, b: I) -> I { _mm256_mullo_epi32(a, b) }
        iand(a: I, b: I) -> I { _mm256_and_si256(a, b) }
        ior(a: I, b: I) -> I { _mm256_or_si256(a, b) }
        ixor(a: I, b: I) -> I { _mm256_xor_si256(a, b) }
        umin(a: I, b: I) -> I { _mm256_min_epu32(a, b) }
        umax(a: I, b: I) -> I { _mm256_max_epu32(a, b) }
        smin(a: I, b: I) -> I { _mm256_min_epi32(a, b) }
        smax(a: I, b: I) -> I { _mm256_max_epi32(a, b) }
        ieq(a: I, b: I) -> M { _mm256_castsi256_ps(_mm256_cmpeq_epi32(a, b)) }
        ult(a: I, b: I) -> M { Self::mnot(_mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_max_epu32(a, b), a))) }
        slt(a: I, b: I) -> M { _mm256_castsi256_ps(_mm256_cmpgt_epi32(b, a)) }
        isel(m: M, a: I, b: I) -> I { Self::bits(_mm256_blendv_ps(Self::float(b), Self::float(a), m)) }
        f_of_i(a: I) -> F { _mm256_cvtepi32_ps(a) }
        f_of_u(a: I) -> F { _mm256_cvtepi32_ps(a) }
        i_of_f(a: F) -> I { _mm256_cvttps_epi32(a) }
        u_of_f(a: F) -> I { _mm256_cvttps_epi32(a) }
        bits(a: F) -> I { _mm256_castps_si256(a) }
        float(a: I) -> F { _mm256_castsi256_ps(a) }
        mand(a: M, b: M) -> M { _mm256_and_ps(a, b) }
        mor(a: M, b: M) -> M { _mm256_or_ps(a, b) }
        mxor(a: M, b: M) -> M { _mm256_xor_ps(a, b) }
        mnot(a: M) -> M { _mm256_xor_ps(a, Self::m(true)) }
        mandnot(a: M, b: M) -> M { _mm256_andnot_ps(b, a) }
        shl_each(a: I, b: I) -> I { _mm256_sllv_epi32(a, _mm256_and_si256(b, _mm256_set1_epi32(31))) }
        shr_each(a: I, b: I) -> I { _mm256_srlv_epi32(a, _mm256_and_si256(b, _mm256_set1_epi32(31))) }
        sar_each(a: I, b: I) -> I { _mm256_srav_epi32(a, _mm256_and_si256(b, _mm256_set1_epi32(31))) }
    }
    #[inline(always)]
    unsafe fn shl(a: __m256i, count: u32) -> __m256i {
        _mm256_sll_epi32(a, _mm_cvtsi32_si128(count as i32))
    }
    #[inline(always)]
    unsafe fn shr(a: __m256i, count: u32) -> __m256i {
        _mm256_srl_epi32(a, _mm_cvtsi32_si128(count as i32))
    }
    #[inline(always)]
    unsafe fn sar(a: __m256i, count: u32) -> __m256i {
        _mm256_sra_epi32(a, _mm_cvtsi32_si128(count as i32))
    }
    lane_by_lane! { division: 0 1 2 3 4 5 6 7 }
    lane_by_lane! { scattered_stores: 0 1 2 3 4 5 6 7 }
    #[inline(always)]
    unsafe fn any(a: __m256) -> bool {
        _mm256_movemask_ps(a) != 0
    }
    #[inline(always)]
    unsafe fn test(a: __m256, k: usize) -> bool {
        _mm256_movemask_ps(a) >> k & 1 != 0
    }
    #[inline(always)]
    unsafe fn gather_words(buffer: Words, at: __m256i) -> __m256i {
        _mm256_i32gather_epi32::<4>(buffer.start.cast::<i32>(), at)
    }
    #[inline(always)]
    unsafe fn gather_quads(buffer: Words, at: __m256i) -> [__m256i; 4] {
        // As in AVX-512: vector j holds the quads of lanes j and j + 4.
        let rows = [
            quads::<0>(buffer, at),
            quads::<1>(buffer, at),
            quads::<2>(buffer, at),
            quads::<3>(buffer, at),
        ];
        let low_01 = _mm256_unpacklo_epi32(rows[0], rows[1]);
        let high_01 = _mm256_unpackhi_epi32(rows[0], rows[1]);
        let low_23 = _mm256_unpacklo_epi32(rows[2], rows[3]);
        let high_23 = _mm256_unpackhi_epi32(rows[2], rows[3]);
        [
            _mm256_unpacklo_epi64(low_01, low_23),
            _mm256_unpackhi_epi64(low_01, low_23),
            _mm256_unpacklo_epi64(high_01, high_23),
            _mm256_unpackhi_epi64(high_01, high_23),
        ]
    }
    #[inline(always)]
    unsafe fn load_words(buffer: Words, at: usize) -> __m256i {
        _mm256_loadu_si256(buffer.start.add(at).cast())
    }
    #[inline(always)]
    unsafe fn store_words(buffer: Words, at: usize, value: __m256i, active: __m256) {
        _mm256_maskstore_epi32(buffer.start.add(at).cast(), _mm256_castps_si256(active), value);
    }
}

/// The four words from the index of lane `J` on, and those of lane `J + 4`.
#[inline(always)]
unsafe fn quads<const J: usize>(buffer: Words, at: __m256i) -> __m256i {
    let low = _mm_loadu_si128(buffer.start.add(Avx2::lane(at, J) as usize).cast());
    let high = _mm_loadu_si128(buffer.start.add(Avx2::lane(at, J + 4) as usize).cast());
    _mm256_inserti128_si256::<1>(_mm256_castsi128_si256(low), high)
}
