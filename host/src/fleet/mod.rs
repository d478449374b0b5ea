//! A fleet of robots that live on board, on the operator's machine.

#[cfg(unix)]
pub(crate) mod twin;
