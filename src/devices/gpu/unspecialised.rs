//! Without the feature `compose` there is no compiler in the program, and all kernels stay generic.

use std::sync::Arc;
use std::time::Duration;

use super::device::{Device, Pipeline};
use crate::batch::Part;
use crate::devices::variants::Specialise;
use crate::evaluator::Control;

/// The variants of kernels: none.
#[derive(Debug, Default)]
pub(super) struct Variants {
    pub(super) when: Specialise,
    pub(super) problems: Vec<String>,
    pub(super) steps: u64,
}

/// A variant with unrolled loops, of which there is none.
#[allow(dead_code, reason = "none is ever made")]
pub(super) struct Unrolled {
    pub(super) made: Arc<Pipeline>,
    pub(super) begin_turns: u32,
    pub(super) turns: u32,
}

pub(super) fn unrolled(
    _: &mut Variants,
    _: &Device,
    _: &Part<'_>,
    _: u32,
    _: u32,
    _: &Control,
) -> Result<Option<Unrolled>, String> {
    Ok(None)
}

pub(super) fn expect_gpu_compiler(_: &mut Variants) {}

pub(super) fn ready(_: &mut Variants, _: &Device, _: &Part<'_>, _: u32, _: &Control) -> Option<Arc<Pipeline>> {
    None
}

pub(super) fn spend(_: &mut Variants, _: &Device, _: &Part<'_>, _: u32, _: Duration) {}
