//! The features of composed kernels, a line each: pinned, and with the same bits on all devices.

use crate::composed::check;

/// A test for each feature, whose module has its subjects.
macro_rules! features {
    ($($feature:ident: $file:literal,)*) => {$(
        #[test]
        fn $feature() {
            check(concat!(env!("CARGO_MANIFEST_DIR"), "/goldens/composed/", $file, ".rows"), &crate::$feature::subjects());
        }
    )*};
}

features! {
    behaviour_tree: "behaviour-trees",
    differential: "differential",
    drawn: "drawn",
    drives: "drives",
    forager_parts: "forager-parts",
    genomes: "genomes",
    individual: "individual",
    members: "members",
    near: "near",
    neighbours: "neighbours",
    network: "network",
    observed: "observed",
    pucks: "pucks",
    ordinary: "ordinary",
    pictures: "pictures",
    missions: "reference",
    state_machine: "state-machines",
    tasks: "tasks",
    varied: "varied",
}
