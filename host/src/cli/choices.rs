//! Flags that take one of several words, which the help lists.

use std::ffi::OsStr;

use clap::builder::{PossibleValue, PossibleValuesParser, StringValueParser, TypedValueParser};
use oneiro::parameter::Choice;
use oneiro_studies::file::{Arm, Shipped, StudyFile};

/// Reads a word of a choice.
pub(super) fn choice<C: Choice + Send + Sync>() -> impl TypedValueParser<Value = C> {
    let words = C::CHOICES.iter().map(|(word, ..)| PossibleValue::new(*word));
    PossibleValuesParser::new(words).map(|text| {
        let found = C::CHOICES.iter().find(|(word, ..)| *word == text);
        found.expect("the words are those of the choice").1.clone()
    })
}

/// Reads the name of a study's arm. It lists the compiled-in study's arms; a user's file may have others.
#[derive(Clone)]
pub(super) struct ArmParser(pub(super) &'static Shipped);

impl TypedValueParser for ArmParser {
    type Value = String;

    fn parse_ref(
        &self,
        command: &clap::Command,
        argument: Option<&clap::Arg>,
        value: &OsStr,
    ) -> Result<String, clap::Error> {
        StringValueParser::new().parse_ref(command, argument, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let arms = StudyFile::open(self.0, None)
            .and_then(|file| file.arms_of_all_editions())
            .ok()?;
        let value = |arm: Arm| PossibleValue::new(arm.name);
        Some(Box::new(arms.into_iter().map(value)))
    }
}
