//! Tests of the library `oneiro`: each file beside this one that `Cargo.toml` names is a program of its own. This library is empty, since a package
//! must have one.
