//! One lane that panics where the exactness rules are broken, for tests: NaN, infinities, subnormals,
//! conversions out of range, indices out of bounds, divisions by zero.

use super::{Lanes, Scalar};
use crate::kernel::Words;

/// One lane, checked.
#[derive(Clone, Copy, Debug)]
pub struct Checked;

/// Panics unless a float is one that kernels may hold.
#[inline(always)]
fn ordinary(x: f32, operation: &'static str, a: f32, b: f32) -> f32 {
    if !(x.is_normal() || x == 0.0) {
        not_ordinary(x, operation, a, b);
    }
    x
}

#[inline(always)]
fn whole(x: f32, least: f32) -> f32 {
    if !(x > least && x < 16_777_216.0) {
        not_whole(x);
    }
    x
}

#[inline(always)]
fn exact(a: u32, size: u32) -> u32 {
    if size > 1 << 24 {
        not_exact(a);
    }
    a
}

#[inline(always)]
fn inside(e: u32, n: u32) -> u32 {
    if e >= n {
        not_inside(e, n);
    }
    e
}

// Kept out of line: formatting a message at every operation would make the kernels' code a fifth larger.

#[cold]
#[inline(never)]
fn not_ordinary(x: f32, operation: &str, a: f32, b: f32) -> ! {
    panic!("{operation} of {a:e} and {b:e} is {x:e}: kernels hold no NaN, infinity or subnormal");
}

#[cold]
#[inline(never)]
fn not_whole(x: f32) -> ! {
    panic!("{x:e} is converted to an integer, which is out of range");
}

#[cold]
#[inline(never)]
fn not_exact(a: u32) -> ! {
    panic!(
        "{a} (as a signed number {}) is converted to a float, which could round",
        a as i32
    );
}

#[cold]
#[inline(never)]
fn not_inside(e: u32, n: u32) -> ! {
    panic!("element {e} of a buffer of {n} is accessed");
}

#[cold]
#[inline(never)]
fn divided_by_zero(a: u32) -> ! {
    panic!("{a} is divided by zero");
}

macro_rules! as_scalar {
    ($($name:ident($($arg:ident: $from:ty),*) -> $to:ty;)*) => {$(
        #[inline(always)]
        unsafe fn $name($($arg: $from),*) -> $to {
            Scalar::$name($($arg),*)
        }
    )*};
}

impl Lanes for Checked {
    const N: usize = 1;
    type F = f32;
    type I = u32;
    type M = bool;

    unsafe fn f(x: f32) -> f32 {
        ordinary(x, "a uniform value made", x, x)
    }
    unsafe fn add(a: f32, b: f32) -> f32 {
        ordinary(a + b, "the sum", a, b)
    }
    unsafe fn sub(a: f32, b: f32) -> f32 {
        ordinary(a - b, "the difference", a, b)
    }
    unsafe fn mul(a: f32, b: f32) -> f32 {
        ordinary(a * b, "the product", a, b)
    }
    unsafe fn f_of_u(a: u32) -> f32 {
        exact(a, a) as f32
    }
    unsafe fn f_of_i(a: u32) -> f32 {
        exact(a, (a as i32).unsigned_abs()) as i32 as f32
    }
    unsafe fn i_of_f(a: f32) -> u32 {
        whole(a, -16_777_216.0) as i32 as u32
    }
    unsafe fn u_of_f(a: f32) -> u32 {
        whole(a, -1.0) as u32
    }
    unsafe fn float(a: u32) -> f32 {
        ordinary(f32::from_bits(a), "a bitcast", f32::from_bits(a), 0.0)
    }
    unsafe fn udiv(a: u32, b: u32) -> u32 {
        if b == 0 {
            divided_by_zero(a);
        }
        a / b
    }
    unsafe fn urem(a: u32, b: u32) -> u32 {
        if b == 0 {
            divided_by_zero(a);
        }
        a % b
    }
    unsafe fn index(e: u32, n: u32, stride: u32, offset: u32) -> u32 {
        inside(e, n) * stride + offset
    }
    unsafe fn word(buffer: Words, e: u32, n: u32, stride: u32, offset: u32) -> u32 {
        let element = if stride == 0 { 0 } else { inside(e, n) };
        *buffer.start.add((element * stride + offset) as usize)
    }
    unsafe fn load(buffer: Words, e: u32, n: u32, offset: u32) -> u32 {
        *buffer.start.add((inside(e, n) + offset) as usize)
    }
    unsafe fn save(buffer: Words, e: u32, n: u32, offset: u32, value: u32, active: bool) {
        // Where no lane is active, nothing is accessed.
        if active {
            *buffer.start.add((inside(e, n) + offset) as usize) = value;
        }
    }

    lane_by_lane! { shifts: 0 }
    lane_by_lane! { stores: 0 }
    lane_by_lane! { scattered_stores: 0 }
    as_scalar! {
        i(x: u32) -> u32;
        m(x: bool) -> bool;
        iota(base: u32) -> u32;
        neg(a: f32) -> f32;
        abs(a: f32) -> f32;
        floor(a: f32) -> f32;
        trunc(a: f32) -> f32;
        min(a: f32, b: f32) -> f32;
        max(a: f32, b: f32) -> f32;
        lt(a: f32, b: f32) -> bool;
        le(a: f32, b: f32) -> bool;
        eq(a: f32, b: f32) -> bool;
        fsel(m: bool, a: f32, b: f32) -> f32;
        iadd(a: u32, b: u32) -> u32;
        isub(a: u32, b: u32) -> u32;
        imul(a: u32, b: u32) -> u32;
        iand(a: u32, b: u32) -> u32;
        ior(a: u32, b: u32) -> u32;
        ixor(a: u32, b: u32) -> u32;
        shl(a: u32, count: u32) -> u32;
        shr(a: u32, count: u32) -> u32;
        sar(a: u32, count: u32) -> u32;
        umin(a: u32, b: u32) -> u32;
        umax(a: u32, b: u32) -> u32;
        smin(a: u32, b: u32) -> u32;
        smax(a: u32, b: u32) -> u32;
        ieq(a: u32, b: u32) -> bool;
        ult(a: u32, b: u32) -> bool;
        slt(a: u32, b: u32) -> bool;
        isel(m: bool, a: u32, b: u32) -> u32;
        bits(a: f32) -> u32;
        mand(a: bool, b: bool) -> bool;
        mor(a: bool, b: bool) -> bool;
        mxor(a: bool, b: bool) -> bool;
        mnot(a: bool) -> bool;
        mandnot(a: bool, b: bool) -> bool;
        any(a: bool) -> bool;
        test(a: bool, k: usize) -> bool;
        gather_words(buffer: Words, at: u32) -> u32;
        gather_quads(buffer: Words, at: u32) -> [u32; 4];
        load_words(buffer: Words, at: usize) -> u32;
    }
}
