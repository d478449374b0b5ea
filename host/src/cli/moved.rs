//! Names that commands had, and what to type now.

/// Commands that became options or sub-commands of others: the old name, and a command line that does the same.
const MOVED: [(&str, &str); 10] = [
    ("audit", "verify RUN_DIR --recompute --fraction 0.01"),
    ("bench", "device bench"),
    ("best", "evaluate --best --genomes RUN_DIR --trials 100"),
    ("calibrate", "robot calibrate EXPERIMENT.toml --log LOG_DIR --out DIR"),
    ("devices", "device list"),
    ("keys", "new --keys noise"),
    ("sample", "robot sample --robot surrogate:1 --out DIR"),
    ("selftest", "device test"),
    ("tables", "robot tables show wall"),
    ("tournament", "evaluate --tournament --genomes RUN_DIR --trials 10"),
];

/// What to type instead of an old name.
pub(super) fn tip(name: &str) -> Option<String> {
    let (_, new) = MOVED.iter().find(|(old, _)| *old == name)?;
    Some(format!("it is now '{} {new}'", super::PROGRAM))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_old_name_is_refused_with_a_line_to_type() {
        let program = super::super::command();
        for (old, new) in MOVED {
            program
                .clone()
                .try_get_matches_from([super::super::PROGRAM, old])
                .expect_err(old);
            let tip = super::super::command_tip(old, &program, &program).unwrap();
            assert!(tip.contains(new), "{old}: {tip}");
            let words = std::iter::once(super::super::PROGRAM).chain(new.split(' '));
            if let Err(problem) = program.clone().try_get_matches_from(words) {
                panic!("{new}: {problem}");
            }
        }
    }
}
