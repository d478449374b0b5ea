//! The study of O'Dowd, Studley and Winfield (2014).

#[cfg_attr(
    not(test),
    expect(
        dead_code,
        unused_imports,
        reason = "the command that runs the study is not there yet"
    )
)]
pub(crate) mod report;
#[expect(dead_code, reason = "the command that runs the study is not there yet")]
pub(crate) mod results;
