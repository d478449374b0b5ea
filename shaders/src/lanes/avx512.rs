//! 16 lanes of AVX-512.

use core::arch::x86_64::*;

use super::Lanes;
use crate::kernel::Words;

/// 16 lanes; needs AVX-512 F, BW, DQ and VL.
#[derive(Clone, Copy, Debug)]
pub struct Avx512;

macro_rules! intrinsics {
    ($($name:ident($($arg:ident: $from:ident),+) -> $to:ident { $body:expr })*) => {$(
        #[inline(always)]
        unsafe fn $name($($arg: Self::$from),+) -> Self::$to { $body }
    )*};
}

impl Lanes for Avx512 {
    const N: usize = 16;
    type F = __m512;
    type I = __m512i;
    type M = __mmask16;

    #[inline(always)]
    unsafe fn f(x: f32) -> __m512 {
        _mm512_set1_ps(x)
    }
    #[inline(always)]
    unsafe fn i(x: u32) -> __m512i {
        _mm512_set1_epi32(x as i32)
    }
    #[inline(always)]
    unsafe fn m(x: bool) -> __mmask16 {
        if x { !0 } else { 0 }
    }
    #[inline(always)]
    unsafe fn iota(base: u32) -> __m512i {
        let steps = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
        _mm512_add_epi32(_mm512_set1_epi32(base as i32), steps)
    }
    intrinsics! {
        add(a: F, b: F) -> F { _mm512_add_ps(a, b) }
        sub(a: F, b: F) -> F { _mm512_sub_ps(a, b) }
        mul(a: F, b: F) -> F { _mm512_mul_ps(a, b) }
        neg(a: F) -> F { _mm512_xor_ps(a, _mm512_set1_ps(-0.0)) }
        abs(a: F) -> F { _mm512_abs_ps(a) }
        floor(a: F) -> F { _mm512_roundscale_ps::<0x09>(a) }
        trunc(a: F) -> F { _mm512_roundscale_ps::<0x0b>(a) }
        min(a: F, b: F) -> F { _mm512_min_ps(a, b) }
        max(a: F, b: F) -> F { _mm512_max_ps(a, b) }
        lt(a: F, b: F) -> M { _mm512_cmp_ps_mask::<_CMP_LT_OQ>(a, b) }
        le(a: F, b: F) -> M { _mm512_cmp_ps_mask::<_CMP_LE_OQ>(a, b) }
        eq(a: F, b: F) -> M { _mm512_cmp_ps_mask::<_CMP_EQ_OQ>(a, b) }
        fsel(m: M, a: F, b: F) -> F { _mm512_mask_blend_ps(m, b, a) }
        iadd(a: I, b: I) -> I { _mm512_add_epi32(a, b) }
        isub(a: I, b: I) -> I { _mm512_sub_epi32(a, b) }
        imul(a: I, b: I) -> I { _mm512_mullo_epi32(a, b) }
        iand(a: I, b: I) -> I { _mm512_and_si512(a, b) }
        ior(a: I, b: I) -> I { _mm512_or_si512(a, b) }
        ixor(a: I, b: I) -> I { _mm512_xor_si512(a, b) }
        umin(a: I, b: I) -> I { _mm512_min_epu32(a, b) }
        umax(a: I, b: I) -> I { _mm512_max_epu32(a, b) }
        smin(a: I, b: I) -> I { _mm512_min_epi32(a, b) }
        smax(a: I, b: I) -> I { _mm512_max_epi32(a, b) }
        ieq(a: I, b: I) -> M { _mm512_cmpeq_epi32_mask(a, b) }
        ult(a: I, b: I) -> M { _mm512_cmplt_epu32_mask(a, b) }
        slt(a: I, b: I) -> M { _mm512_cmplt_epi32_mask(a, b) }
        isel(m: M, a: I, b: I) -> I { _mm512_mask_blend_epi32(m, b, a) }
        f_of_i(a: I) -> F { _mm512_cvtepi32_ps(a) }
        f_of_u(a: I) -> F { _mm512_cvtepi32_ps(a) }
        i_of_f(a: F) -> I { _mm512_cvttps_epi32(a) }
        u_of_f(a: F) -> I { _mm512_cvttps_epi32(a) }
        bits(a: F) -> I { _mm512_castps_si512(a) }
        float(a: I) -> F { _mm512_castsi512_ps(a) }
        mand(a: M, b: M) -> M { a & b }
        mor(a: M, b: M) -> M { a | b }
        mxor(a: M, b: M) -> M { a ^ b }
        mnot(a: M) -> M { !a }
        mandnot(a: M, b: M) -> M { a & !b }
        shl_each(a: I, b: I) -> I { _mm512_sllv_epi32(a, _mm512_and_si512(b, _mm512_set1_epi32(31))) }
        shr_each(a: I, b: I) -> I { _mm512_srlv_epi32(a, _mm512_and_si512(b, _mm512_set1_epi32(31))) }
        sar_each(a: I, b: I) -> I { _mm512_srav_epi32(a, _mm512_and_si512(b, _mm512_set1_epi32(31))) }
    }
    #[inline(always)]
    unsafe fn shl(a: __m512i, count: u32) -> __m512i {
        _mm512_sll_epi32(a, _mm_cvtsi32_si128(count as i32))
    }
    #[inline(always)]
    unsafe fn shr(a: __m512i, count: u32) -> __m512i {
        _mm512_srl_epi32(a, _mm_cvtsi32_si128(count as i32))
    }
    #[inline(always)]
    unsafe fn sar(a: __m512i, count: u32) -> __m512i {
        _mm512_sra_epi32(a, _mm_cvtsi32_si128(count as i32))
    }
    lane_by_lane! { division: 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 }
    #[inline(always)]
    unsafe fn any(a: __mmask16) -> bool {
        a != 0
    }
    #[inline(always)]
    unsafe fn test(a: __mmask16, k: usize) -> bool {
        a >> k & 1 != 0
    }
    #[inline(always)]
    unsafe fn gather_words(buffer: Words, at: __m512i) -> __m512i {
        _mm512_i32gather_epi32::<4>(at, buffer.start.cast())
    }
    #[inline(always)]
    unsafe fn gather_quads(buffer: Words, at: __m512i) -> [__m512i; 4] {
        // Vector j holds the quads of lanes j, j + 4, j + 8, j + 12; a transposition in each quarter then
        // brings the lanes into order. Four gathers would load each word by itself.
        let rows = [
            quads::<0>(buffer, at),
            quads::<1>(buffer, at),
            quads::<2>(buffer, at),
            quads::<3>(buffer, at),
        ];
        let low_01 = _mm512_unpacklo_epi32(rows[0], rows[1]);
        let high_01 = _mm512_unpackhi_epi32(rows[0], rows[1]);
        let low_23 = _mm512_unpacklo_epi32(rows[2], rows[3]);
        let high_23 = _mm512_unpackhi_epi32(rows[2], rows[3]);
        [
            _mm512_unpacklo_epi64(low_01, low_23),
            _mm512_unpackhi_epi64(low_01, low_23),
            _mm512_unpacklo_epi64(high_01, high_23),
            _mm512_unpackhi_epi64(high_01, high_23),
        ]
    }
    #[inline(always)]
    unsafe fn load_words(buffer: Words, at: usize) -> __m512i {
        _mm512_loadu_si512(buffer.start.add(at).cast())
    }
    #[inline(always)]
    unsafe fn scatter_words(buffer: Words, at: __m512i, value: __m512i, active: __mmask16) {
        // Of lanes with one index, the instruction keeps the last.
        _mm512_mask_i32scatter_epi32::<4>(buffer.start.cast(), active, at, value);
    }
    #[inline(always)]
    unsafe fn store_words(buffer: Words, at: usize, value: __m512i, active: __mmask16) {
        _mm512_mask_storeu_epi32(buffer.start.add(at).cast(), active, value);
    }
}

/// The four words from the index of lane `J` on, and those of lanes `J + 4`, `J + 8` and `J + 12`.
#[inline(always)]
unsafe fn quads<const J: usize>(buffer: Words, at: __m512i) -> __m512i {
    let a = quad(buffer, Avx512::lane(at, J));
    let b = quad(buffer, Avx512::lane(at, J + 4));
    let c = quad(buffer, Avx512::lane(at, J + 8));
    let d = quad(buffer, Avx512::lane(at, J + 12));
    let low = _mm256_inserti128_si256::<1>(_mm256_castsi128_si256(a), b);
    let high = _mm256_inserti128_si256::<1>(_mm256_castsi128_si256(c), d);
    _mm512_inserti64x4::<1>(_mm512_castsi256_si512(low), high)
}

#[inline(always)]
unsafe fn quad(buffer: Words, at: u32) -> __m128i {
    _mm_loadu_si128(buffer.start.add(at as usize).cast())
}
