//! The corpus, compiled.

mod spirv;
mod variants;
