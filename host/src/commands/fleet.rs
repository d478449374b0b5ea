//! `oneiro fleet`: robots that live on board.

#[cfg(unix)]
pub(crate) mod twin;
