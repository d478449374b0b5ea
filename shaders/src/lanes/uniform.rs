//! Operations on values that all lanes share.

/// What [`min`] and [`max`] compare.
pub trait Number: Copy + PartialOrd {}
impl Number for f32 {}
impl Number for i32 {}
impl Number for u32 {}

/// `a < b ? a : b`
#[inline(always)]
pub fn min<T: Number>(a: T, b: T) -> T {
    if a < b { a } else { b }
}

/// `a > b ? a : b`
#[inline(always)]
pub fn max<T: Number>(a: T, b: T) -> T {
    if a > b { a } else { b }
}

/// `a / b`; by zero, `a`, as the SPIR-V has it.
#[inline(always)]
pub fn divide(a: u32, b: u32) -> u32 {
    a / if b == 0 { 1 } else { b }
}

/// `a % b`; by zero, 0.
#[inline(always)]
pub fn remainder(a: u32, b: u32) -> u32 {
    a % if b == 0 { 1 } else { b }
}

/// Beyond this every float is whole.
const WHOLE: f32 = 8_388_608.0;

/// Towards zero. `f32::trunc` would be a library call on processors without an instruction for it.
#[inline(always)]
pub fn trunc(x: f32) -> f32 {
    if x.abs() < WHOLE { (x as i32) as f32 } else { x }
}

/// Towards minus infinity.
#[inline(always)]
pub fn floor(x: f32) -> f32 {
    let whole = trunc(x);
    if whole > x { whole - 1.0 } else { whole }
}
