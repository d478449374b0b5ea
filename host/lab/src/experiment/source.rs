//! Sources of an experiment's values: its file, or a `--set`. All values form one tree, whose places are offsets into
//! all texts together, so that every error can name its place.

use std::cell::{OnceCell, RefCell};
use std::collections::BTreeMap;
use std::fmt::Display;
use std::ops::{Range, RangeInclusive};
use std::path::{Path, PathBuf};

use oneiro::parameter::nearest;
use oneiro_base::exit::{Failure, Result};
use serde::Deserialize;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::values::instead;

/// Values of a file, parsed once for any number of settings that override them.
#[derive(Debug)]
pub struct Parsed<'a> {
    /// Name of the file in messages.
    name: String,
    text: &'a str,
    values: Spanned<DeTable<'a>>,
    /// Whether the program has written it.
    is_recorded: bool,
}

impl<'a> Parsed<'a> {
    /// Parses a file's text.
    ///
    /// # Errors
    /// Exit 3: the place of invalid TOML.
    pub fn new(name: String, text: &'a str) -> Result<Self> {
        match DeTable::parse(text) {
            Ok(values) => Ok(Self {
                name,
                text,
                values,
                is_recorded: false,
            }),
            Err(error) => {
                let span = error.span().unwrap_or_default();
                let place = place(&name, text, span.start);
                let problem = match error.message() {
                    "duplicate key" => repeated(text, &span),
                    message => unparsed(message, text, span.start),
                };
                Err(refused(&place, problem))
            }
        }
    }

    /// The same file, written by the program itself, maybe by an older version. Its values are not refused for having no
    /// effect.
    pub fn recorded(self) -> Self {
        Self {
            is_recorded: true,
            ..self
        }
    }

    /// Whether the program has written it.
    pub(crate) fn is_recorded(&self) -> bool {
        self.is_recorded
    }

    /// Whether there is a key such as `evolution.init`, or a table with this name.
    pub fn has(&self, path: &str) -> bool {
        let mut keys = path.split('.');
        let first = keys.next().and_then(|key| self.values.get_ref().get(key));
        let found = keys.try_fold(first, |value, key| {
            value?.get_ref().as_table().map(|table| table.get(key))
        });
        found.flatten().is_some()
    }
}

/// The texts that values came from, and the place of each key.
#[derive(Debug)]
pub struct Source<'a> {
    file: &'a Parsed<'a>,
    set: Vec<Text>,
    /// Built only if a place is needed.
    keys: OnceCell<Vec<Key>>,
    left_out: RefCell<LeftOut>,
}

/// Paths of settings that others of a higher rank left without effect, and what a refusal of each would say.
pub(crate) type LeftOut = BTreeMap<String, String>;

/// Rank of a value that a sweep varies. Values of this rank can leave each other out: each cell takes what it uses.
const SWEPT: u8 = u8::MAX;

/// A text with values: the file or one setting.
#[derive(Debug)]
struct Text {
    /// Name in messages.
    name: String,
    content: String,
    /// Offset of its start in all texts together.
    start: usize,
    /// Folder from which files that it names are looked for; `None` for the experiment's.
    folder: Option<PathBuf>,
    rank: u8,
}

/// A key or an element of a list.
#[derive(Debug)]
struct Key {
    /// Full path, such as `arena.walls[2].class`.
    path: String,
    /// Range of the key itself.
    name: Range<usize>,
    /// Range of its value.
    value: Range<usize>,
}

/// A value that overrides the file's.
#[derive(Clone, Debug)]
pub struct Setting {
    /// Place for messages.
    place: String,
    /// `key = value`
    line: String,
    /// Folder from which files that it names are looked for; `None` for the experiment's.
    folder: Option<PathBuf>,
    /// The file's is 0. A value that one of a higher rank leaves without effect is left out.
    rank: u8,
}

impl Setting {
    /// Parses `key=value` from the command line. Files are looked for from the working directory.
    ///
    /// # Errors
    /// Exit 2 without `=`.
    pub fn typed(setting: &str) -> Result<Self> {
        let Some((key, value)) = setting.split_once('=') else {
            return Err(Failure::usage(format_args!(
                "--set {setting}: allowed: KEY=VALUE, such as noise.motor=0.1"
            )));
        };
        Ok(Self {
            place: format!("--set {setting}"),
            line: toml_line(&in_toml(key), value),
            folder: Some(PathBuf::new()),
            rank: 1,
        })
    }

    /// Parses all settings of a command line.
    ///
    /// # Errors
    /// As [`Setting::typed`].
    pub fn all_typed(settings: &[String]) -> Result<Vec<Self>> {
        settings.iter().map(|setting| Self::typed(setting)).collect()
    }

    /// A key with a TOML value that stands at `place`.
    pub fn at(place: String, key: &str, value: &toml::Value) -> Self {
        Self {
            place,
            line: format!("{} = {value}", in_toml(key)),
            folder: None,
            rank: 1,
        }
    }

    /// Gives it another rank than 1.
    pub fn ranked(self, rank: u8) -> Self {
        Self { rank, ..self }
    }

    /// Makes it a value that a sweep varies.
    pub(crate) fn swept(self) -> Self {
        self.ranked(SWEPT)
    }

    /// Whether it is such a value.
    pub(crate) fn is_swept(&self) -> bool {
        self.rank == SWEPT
    }

    /// Looks for the files that it names from this folder.
    pub fn in_folder(self, folder: &Path) -> Self {
        Self {
            folder: Some(folder.to_owned()),
            ..self
        }
    }
}

impl<'a> Source<'a> {
    /// Reads values from a file and from settings that override it.
    ///
    /// # Errors
    /// Exit 3: the place, the key, and the allowed values.
    pub fn read<T: for<'b> Deserialize<'b>>(file: &'a Parsed<'a>, set: &[Setting]) -> Result<(T, Self)> {
        let mut source = Self {
            file,
            set: Vec::with_capacity(set.len()),
            keys: OnceCell::new(),
            left_out: RefCell::default(),
        };
        let mut start = file.text.len() + 1;
        for Setting {
            place,
            line,
            folder,
            rank,
        } in set
        {
            source.set.push(Text {
                name: place.clone(),
                content: line.clone(),
                start,
                folder: folder.clone(),
                rank: *rank,
            });
            start += line.len() + 1;
        }
        let mut unknown = Unknown::default();
        let mut values = source.merged()?;
        loop {
            match T::deserialize(toml::Deserializer::from(values.clone())) {
                Ok(values) => return unknown.refused().map(|()| (values, source)),
                Err(error) => {
                    let failure = source.refusal(&error);
                    // Without the unknown key, the next one shows.
                    let is_unknown = error.message().starts_with("unknown field");
                    match error.span().filter(|_| is_unknown) {
                        Some(span) if without(values.get_mut(), &span) => unknown.add(failure),
                        _ => return Err(unknown.and(failure)),
                    }
                }
            }
        }
    }

    /// Renames keys that have a second name: `name` returns the first one. Returns each second name that is given, and the first one
    /// if no text of a higher rank gives that.
    ///
    /// # Errors
    /// Exit 3: a key that texts of one rank give by both names.
    pub(super) fn renamed(&mut self, name: fn(&str) -> Option<String>) -> Result<Vec<(String, Option<String>)>> {
        let texts = std::iter::once(self.file.text).chain(self.set.iter().map(|text| &*text.content));
        // Keys are listed only if there is something to rename: a sweep has many cells.
        if !texts.into_iter().any(|text| text.contains("_deg")) {
            return Ok(Vec::new());
        }
        let named = |path: &String| Some((path.clone(), name(path)?));
        let seconds: Vec<(String, String)> = self.keys().iter().filter_map(|key| named(&key.path)).collect();
        let mut renamed = Vec::with_capacity(seconds.len());
        for (second, first) in seconds {
            let rank = self.rank_of(&second);
            if self.rank_of(&first) == rank {
                let [place, other] = [&second, &first].map(|key| self.place_of(key));
                return Err(Self::conflict(&second, &place, &first, &other));
            }
            let is_used = self.rank_of(&first) < rank;
            let replaced = if is_used { &first } else { &second };
            let is_replaced = |path: &str| {
                let rest = path.strip_prefix(replaced.as_str());
                rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('['))
            };
            let keys = self.keys.get_mut().expect("keys are listed");
            keys.retain(|key| !is_replaced(&key.path));
            for key in keys.iter_mut().filter(|_| is_used) {
                if let Some(rest) = key.path.strip_prefix(&second)
                    && (rest.is_empty() || rest.starts_with('['))
                {
                    key.path = format!("{first}{rest}");
                }
            }
            renamed.push((second, is_used.then_some(first)));
        }
        Ok(renamed)
    }

    /// Merges all values, with places as offsets into all texts together.
    fn merged(&self) -> Result<Spanned<DeTable<'_>>> {
        let mut whole = self.file.values.clone();
        for text in &self.set {
            let table = DeTable::parse(&text.content).map_err(|error| {
                let at = error.span().unwrap_or_default().start;
                let problem = unparsed(error.message(), &text.content, at);
                refused(&text.name, format_args!("{problem}; allowed: KEY=VALUE, as in TOML"))
            })?;
            merge(whole.get_mut(), moved_table(table.into_inner(), text.start))
                .map_err(|problem| refused(&text.name, problem))?;
        }
        Ok(whole)
    }

    /// The keys of all texts with their places.
    fn keys(&self) -> &[Key] {
        self.keys.get_or_init(|| {
            let mut keys = Vec::new();
            // Texts that were parsed before can be parsed again.
            if let Ok(whole) = self.merged() {
                list(whole.get_ref(), "", &mut keys);
            }
            keys
        })
    }

    /// Error for a value that isn't allowed; `problem` names the value and the allowed ones. The place is that of the
    /// key, or of the nearest existing table around it. A table's problem may be in what settings add to it, which are named too.
    pub fn invalid(&self, key: &str, problem: impl Display) -> Failure {
        let mut places = vec![self.place_of(key)];
        let is_within = |path: &str| path.strip_prefix(key).is_some_and(|rest| rest.starts_with('.'));
        for within in self.keys().iter().filter(|known| is_within(&known.path)) {
            if let Some(setting) = self.setting(within.value.start)
                && !places.contains(&setting.name)
            {
                places.push(setting.name.clone());
            }
        }
        refused(&places.join(", "), format_args!("{key}: {problem}"))
    }

    /// Checks the range of a value.
    pub fn within<T: PartialOrd + Display + Copy>(&self, key: &str, value: T, allowed: &RangeInclusive<T>) -> Result {
        if allowed.contains(&value) {
            return Ok(());
        }
        let (least, greatest) = (allowed.start(), allowed.end());
        Err(self.invalid(key, format_args!("is {value}; allowed: {least} to {greatest}")))
    }

    /// Error for a key that isn't allowed, whatever its value.
    pub fn invalid_key(&self, key: &str, problem: impl Display) -> Failure {
        let place = self.keys().iter().find(|known| known.path == key);
        let place = place.map_or_else(|| self.place_of(key), |known| self.place(known.name.start));
        refused(&place, format_args!("{key}: {problem}"))
    }

    /// Folder from which the files that a value names are looked for; `None` for the experiment's.
    pub(crate) fn folder_of(&self, key: &str) -> Option<&Path> {
        let start = self.start_of(key).unwrap_or_default();
        self.setting(start)?.folder.as_deref()
    }

    /// The setting at a place; `None` if the place is in the file.
    fn setting(&self, at: usize) -> Option<&Text> {
        self.set.iter().rfind(|text| text.start <= at)
    }

    /// Leaves out a value that only another `kind` of its table, or of one around it, or another selection of parents has.
    ///
    /// # Errors
    /// Exit 3 if the kind doesn't outrank the value: its place, its key and `problem`.
    pub(crate) fn leave_out_of_kind(&self, key: &str, problem: impl Display) -> Result {
        const SELECTION: &str = "evolution.selection.kind";
        let list = key.split('[').next().unwrap_or_default();
        let tables = list.match_indices('.').map(|(end, _)| &list[..end]);
        let mut kinds: Vec<String> = tables.map(|table| format!("{table}.kind")).collect();
        if list.starts_with("evolution.") {
            kinds.push(SELECTION.into());
        }
        self.leave_out(key, &kinds, problem)
    }

    /// Leaves out a value that is without effect because of other keys.
    ///
    /// # Errors
    /// Exit 3 if none of them outranks the value: its place, its key and `problem`.
    pub(crate) fn leave_out(&self, key: &str, others: &[impl AsRef<str>], problem: impl Display) -> Result {
        let own = self.rank_of(key);
        let outranks = |other| other > own || other == own && own == Some(SWEPT);
        let refused = self.invalid(key, problem);
        if own.is_none() || !others.iter().any(|other| outranks(self.rank_of(other.as_ref()))) {
            return Err(refused);
        }
        if self.is_set(key) {
            self.left_out.borrow_mut().insert(key.to_owned(), refused.to_string());
        }
        Ok(())
    }

    /// Of two keys that contradict each other, that of the lower rank, which is left out.
    ///
    /// # Errors
    /// Exit 3 if both have the same rank.
    pub(crate) fn outranked<'k>(&self, keys: [&'k str; 2]) -> Result<&'k str> {
        let [one, other] = keys;
        let (key, by) = if self.rank_of(one) < self.rank_of(other) {
            (one, other)
        } else {
            (other, one)
        };
        let problem = format!("is given beside {by}; allowed: one of them");
        if self.rank_of(one) == self.rank_of(other) {
            return Err(self.invalid(key, problem));
        }
        self.leave_out(key, &[by], problem)?;
        Ok(key)
    }

    /// Takes the settings that [`Source::leave_out`] has left out.
    pub fn left_out(&self) -> LeftOut {
        self.left_out.take()
    }

    /// Whether there are settings that go before the file.
    pub(crate) fn is_overridden(&self) -> bool {
        self.set.iter().any(|text| text.rank > 0)
    }

    /// Whether a setting gives a key.
    pub fn is_set(&self, key: &str) -> bool {
        self.rank_of(key).is_some_and(|rank| rank > 0)
    }

    /// Rank of the text that gives a key, 0 for the file; `None` if it is not given.
    fn rank_of(&self, key: &str) -> Option<u8> {
        let known = self.keys().iter().find(|known| known.path == key)?;
        Some(self.setting(known.value.start).map_or(0, |text| text.rank))
    }

    /// The keys at a path or below it, in the order of the texts. A file that the program has written gives none.
    pub fn given(&self, path: &str) -> impl Iterator<Item = &str> {
        let is_below = move |own: &str| {
            let rest = own.strip_prefix(path);
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        let keys = self.keys().iter().map(|known| &*known.path);
        keys.filter(move |own| is_below(own) && !(self.file.is_recorded && self.rank_of(own) == Some(0)))
    }

    /// A key among those wanted that a setting gives, if none of a higher rank gives `other`.
    pub fn given_over(&self, other: &str, is_wanted: impl Fn(&str) -> bool) -> Option<&str> {
        let rank = self.given(other).filter_map(|key| self.rank_of(key)).max().unwrap_or(0);
        let keys = self.keys().iter().map(|known| &*known.path);
        keys.filter(|key| is_wanted(key))
            .find(|key| self.rank_of(key).is_some_and(|own| own >= rank.max(1)))
    }

    /// Whether all values are those of a file that the program has written.
    pub fn is_recorded(&self) -> bool {
        self.file.is_recorded && self.set.iter().all(|text| text.rank == 0)
    }

    /// Error for a key with two values.
    pub(crate) fn conflict(key: &str, place: &str, other: &str, first: &str) -> Failure {
        let problem = format!("{key}: is already given, as {other} ({first}); allowed: each key once");
        refused(place, problem)
    }

    /// Place of a key's value, or of the nearest existing table around it.
    pub fn place_of(&self, key: &str) -> String {
        self.start_of(key)
            .map_or_else(|| self.file.name.clone(), |at| self.place(at))
    }

    /// Offset of that place in all texts together, by which keys can be sorted in the order of the texts.
    pub(crate) fn start_of(&self, key: &str) -> Option<usize> {
        let mut prefix = key;
        loop {
            if let Some(found) = self.keys().iter().find(|known| known.path == prefix) {
                let range = if prefix == key { &found.value } else { &found.name };
                return Some(range.start);
            }
            prefix = &prefix[..prefix.rfind(['.', '['])?];
        }
    }

    /// Translates an error of serde into this program's wording.
    fn refusal(&self, error: &toml::de::Error) -> Failure {
        let Some(span) = error.span() else {
            return refused(&self.file.name, plain(error.message()));
        };
        // The file as a whole lacks something, so no key is at fault, not even the first one.
        if span.is_empty() && span.start == 0 {
            return refused(&self.place(0), plain(error.message()));
        }
        // The innermost key around the place.
        let holds = |range: &Range<usize>| range.start <= span.start && span.end <= range.end;
        let around = self
            .keys()
            .iter()
            .filter(|known| holds(&known.name) || holds(&known.value));
        let key = around
            .max_by_key(|known| known.path.len())
            .map(|known| format!("{}: ", known.path));
        let message = plain(error.message());
        refused(
            &self.place(span.start),
            format_args!("{}{message}", key.unwrap_or_default()),
        )
    }

    /// `file:line:column` of an offset, or the setting.
    fn place(&self, at: usize) -> String {
        match self.setting(at) {
            Some(setting) => setting.name.clone(),
            None => place(&self.file.name, self.file.text, at),
        }
    }
}

/// Unknown keys of a file, which are refused together.
#[derive(Debug, Default)]
pub struct Unknown {
    refused: Vec<Failure>,
    /// Bytes of their messages.
    length: usize,
    more: usize,
}

impl Unknown {
    /// Adds the refusal of a key. Of many only the first ones are shown.
    pub fn add(&mut self, failure: Failure) {
        const LONGEST: usize = 3_000;
        self.length += failure.to_string().len();
        if self.refused.is_empty() || self.length <= LONGEST {
            self.refused.push(failure);
        } else {
            self.more += 1;
        }
    }

    /// One failure for all of them.
    ///
    /// # Errors
    /// Exit 3: a line for each key.
    pub fn refused(self) -> Result {
        let more = (self.more > 0).then(|| Failure::input(format_args!("and {} more unknown keys", self.more)));
        match self.refused.into_iter().chain(more).reduce(Failure::and) {
            Some(failure) => Err(failure),
            None => Ok(()),
        }
    }

    /// The same with another failure at the end.
    fn and(self, last: Failure) -> Failure {
        match self.refused() {
            Ok(()) => last,
            Err(failure) => failure.and(last),
        }
    }
}

/// Removes the key at a place; whether it was there.
fn without(table: &mut DeTable<'_>, at: &Range<usize>) -> bool {
    let found = table
        .keys()
        .find(|key| key.span() == *at)
        .map(|key| key.get_ref().clone());
    match found {
        Some(key) => table.remove(&*key).is_some(),
        None => table.iter_mut().any(|(_, value)| without_within(value.get_mut(), at)),
    }
}

fn without_within(value: &mut DeValue<'_>, at: &Range<usize>) -> bool {
    match value {
        DeValue::Table(table) => without(table, at),
        DeValue::Array(list) => list.iter_mut().any(|value| without_within(value.get_mut(), at)),
        _ => false,
    }
}

/// The problem of a key that is there already, with the line that has it first if that is easily found.
fn repeated(text: &str, at: &Range<usize>) -> String {
    let own = text.get(at.clone()).unwrap_or_default().trim_matches(['[', ']', ' ']);
    let start = text.get(..at.start).and_then(|before| before.rfind('\n'));
    let (before, line) = text.split_at(start.map_or(0, |end| end + 1));
    let is_table = |line: &str| line.trim_start().starts_with('[');
    let name_of = |line: &str| line.trim().trim_matches(['[', ']', ' ']).to_owned();
    let line = line.lines().next().unwrap_or_default();
    let table = before.lines().rfind(|line| is_table(line));
    let path = match table {
        _ if is_table(line) => name_of(line),
        Some(table) => format!("{}.{own}", name_of(table)),
        None => own.to_owned(),
    };
    let mut keys = Vec::new();
    if (is_table(line) || line.split('=').next().map(str::trim) == Some(own))
        && let Ok(whole) = DeTable::parse(before)
    {
        list(whole.get_ref(), "", &mut keys);
    }
    let first = keys.iter().find(|known| known.path == path);
    let first = first.map_or_else(String::new, |first| {
        format!(
            ", first in line {}",
            before[..first.name.start].matches('\n').count() + 1
        )
    });
    format!("duplicate key `{own}`{first}; allowed: each key once")
}

/// The parser's message for the text at a byte, with a correction if there is an obvious one.
fn unparsed(message: &str, text: &str, at: usize) -> String {
    let rest = text.get(at..).unwrap_or_default().lines().next().unwrap_or_default();
    let line = text
        .get(..at)
        .unwrap_or_default()
        .lines()
        .next_back()
        .unwrap_or_default();
    let value = rest.split('#').next().unwrap_or_default().trim();
    if let Some(number) = with_decimal_comma(line, rest) {
        return format!("a number has a decimal point; write `{number}`");
    }
    let whole = format!("{line}{rest}");
    if let Some(quote) = whole
        .split('#')
        .next()
        .unwrap_or_default()
        .chars()
        .find(|c| "\u{201c}\u{201d}\u{201e}\u{2018}\u{2019}".contains(*c))
    {
        return format!("`{quote}` is no quote of TOML; write `\"`");
    }
    match value.strip_suffix(';') {
        Some("") => "a line of TOML ends without `;`; leave it out".to_owned(),
        Some(value) => format!("a line of TOML ends without `;`; write `{}`", value.trim_end()),
        None if message.starts_with("string values must be quoted") && value.is_empty() => "has no value".to_owned(),
        None if message.starts_with("string values must be quoted")
            && value.starts_with(|c: char| c.is_ascii_digit()) =>
        {
            format!("`{value}` is no number; words are quoted")
        }
        None if message.starts_with("string values must be quoted") => {
            format!("words are quoted; write `\"{value}\"`")
        }
        None if text.trim_start().starts_with('{') => "is JSON; allowed: TOML, lines such as `cycles = 500`".to_owned(),
        None if message.starts_with("key with no value") && line.contains(':') => {
            "a key and its value have `=` between them in TOML, such as `cycles = 500`".to_owned()
        }
        None if message.starts_with("key with no value") => format!("{message}; allowed: KEY = VALUE"),
        None if message.starts_with("invalid boolean") => "true and false are written in small letters".to_owned(),
        None if message.starts_with("invalid float") || message.starts_with("invalid integer") => {
            "is no number; words are quoted, and what has no value is left out".to_owned()
        }
        None if message.starts_with("unexpected key or value") && value.starts_with(',') => {
            "a line of TOML ends without `,`; leave it out".to_owned()
        }
        None if message.starts_with("missing comma between array elements") => {
            "a list lacks a comma, or its end, `]`".to_owned()
        }
        None => message.to_owned(),
    }
}

/// The number with a decimal point, if a line is not parsed after a comma between digits, or before its decimals.
fn with_decimal_comma(before: &str, after: &str) -> Option<String> {
    let is_digit = |c: char| c.is_ascii_digit();
    let (before, decimals) = match (after.strip_prefix(','), after.starts_with('}')) {
        (Some(decimals), _) => (before, decimals),
        (None, false) => (before.strip_suffix(',')?, after),
        // In a table of one line, what comes after the comma would be a key.
        (None, true) => before.trim_end().rsplit_once(',')?,
    };
    let decimals = &decimals[..decimals.find(|c| !is_digit(c)).unwrap_or(decimals.len())];
    let whole = &before[before
        .rfind(|c| !is_digit(c))
        .map_or(0, |at| at + before[at..].chars().next().map_or(1, char::len_utf8))..];
    (!whole.is_empty() && !decimals.is_empty()).then(|| format!("{whole}.{decimals}"))
}

/// Error for the text at a place. The middle of a long problem is left out: a value or a key may be of any length.
fn refused(place: &str, problem: impl Display) -> Failure {
    const HALF: usize = 1_000;
    let problem = problem.to_string();
    let count = problem.chars().count();
    if count <= 2 * HALF {
        return Failure::input(format_args!("{place}: {problem}"));
    }
    let first: String = problem.chars().take(HALF).collect();
    let last: String = problem.chars().skip(count - HALF).collect();
    let between = count - 2 * HALF;
    Failure::input(format_args!("{place}: {first} .. ({between} characters) .. {last}"))
}

/// `file:line:column` of a byte.
fn place(name: &str, text: &str, at: usize) -> String {
    let before = text.get(..at).unwrap_or(text);
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().unwrap_or_default().chars().count() + 1;
    format!("{name}:{line}:{column}")
}

/// Formats `key = value` as TOML; a word that isn't a TOML value is a string without its quotes.
fn toml_line(key: &str, value: &str) -> String {
    let line = format!("{key}={value}");
    let is_word = value.starts_with(|first: char| first.is_ascii_alphabetic() || "./_".contains(first))
        && value
            .chars()
            .all(|c| c.is_ascii_alphanumeric() || "._-/:@#+ ".contains(c));
    if is_word && DeTable::parse(&line).is_err() {
        format!("{key}='{value}'")
    } else {
        line
    }
}

/// A key as TOML writes it: that of a list's element is `list.2.key`, not `list[2].key`.
fn in_toml(key: &str) -> String {
    key.replace('[', ".").replace(']', "")
}

fn moved(range: &Range<usize>, by: usize) -> Range<usize> {
    range.start + by..range.end + by
}

fn moved_table(table: DeTable<'_>, by: usize) -> DeTable<'_> {
    table
        .into_iter()
        .map(|(key, value)| {
            (
                Spanned::new(moved(&key.span(), by), key.into_inner()),
                moved_value(value, by),
            )
        })
        .collect()
}

fn moved_value(value: Spanned<DeValue<'_>>, by: usize) -> Spanned<DeValue<'_>> {
    let span = moved(&value.span(), by);
    let value = match value.into_inner() {
        DeValue::Table(table) => DeValue::Table(moved_table(table, by)),
        DeValue::Array(array) => DeValue::Array(array.into_iter().map(|value| moved_value(value, by)).collect()),
        other => other,
    };
    Spanned::new(span, value)
}

/// Replaces values of `under` with those of `over`; tables are merged. A table whose keys are numbers changes elements of a list.
///
/// # Errors
/// An element that a list doesn't have, and those that it has.
fn merge<'a>(under: &mut DeTable<'a>, over: DeTable<'a>) -> std::result::Result<(), String> {
    for (key, value) in over {
        match (under.get_mut(&**key.get_ref()).map(Spanned::get_mut), value) {
            (Some(own), value) if value.get_ref().is_table() && (own.is_table() || own.is_array()) => {
                let is_empty = |own: &DeValue<'_>| own.as_table().is_some_and(DeTable::is_empty);
                if is_empty(value.get_ref()) && !is_empty(own) {
                    return Err(format!(
                        "{}: is an empty table, which changes nothing, since tables are merged; allowed: the keys to change",
                        key.get_ref()
                    ));
                }
                merge_value(own, value.into_inner()).map_err(|problem| format!("{}{problem}", key.get_ref()))?;
            }
            (_, value) => {
                // The key is replaced with the value because it carries the place.
                under.remove(&**key.get_ref());
                under.insert(key, value);
            }
        }
    }
    Ok(())
}

/// The same for a value that a table changes. The error follows the name of `under`.
fn merge_value<'a>(under: &mut DeValue<'a>, over: DeValue<'a>) -> std::result::Result<(), String> {
    match (under, over) {
        (DeValue::Table(under), DeValue::Table(over)) => merge(under, over).map_err(|problem| format!(".{problem}")),
        (DeValue::Array(list), DeValue::Table(over)) => {
            for (key, value) in over {
                let key = key.into_inner();
                let count = list.len();
                let own = key.parse::<usize>().ok().and_then(|index| list.get_mut(index));
                let own = own.ok_or_else(|| match count {
                    0 => format!(".{key}: is given, and the list is empty; allowed: the whole list"),
                    _ => format!(".{key}: is no element of the list; allowed: 0 to {}", count - 1),
                })?;
                if own.get_ref().is_table() && value.get_ref().is_table() {
                    merge_value(own.get_mut(), value.into_inner()).map_err(|problem| format!("[{key}]{problem}"))?;
                } else {
                    *own = value;
                }
            }
            Ok(())
        }
        (under, over) => {
            *under = over;
            Ok(())
        }
    }
}

/// Lists the keys of a table and their places.
fn list(table: &DeTable<'_>, prefix: &str, keys: &mut Vec<Key>) {
    for (key, value) in table {
        let path = format!("{prefix}{}", key.get_ref());
        list_value(path, &key.span(), value, keys);
    }
}

fn list_value(path: String, name: &Range<usize>, value: &Spanned<DeValue<'_>>, keys: &mut Vec<Key>) {
    match value.get_ref() {
        DeValue::Table(table) => list(table, &format!("{path}."), keys),
        DeValue::Array(array) => {
            for (index, element) in array.iter().enumerate() {
                list_value(format!("{path}[{index}]"), &element.span(), element, keys);
            }
        }
        _ => (),
    }
    keys.push(Key {
        path,
        name: name.clone(),
        value: value.span(),
    });
}

/// Removes Rust's terms from serde's message.
fn plain(message: &str) -> String {
    let Some((problem, expected)) = message.split_once(", expected ") else {
        return message
            .replace("missing field", "lacks")
            .replace(
                "integer number overflowed",
                "is too large; allowed: whole numbers up to 9223372036854775807",
            )
            .replace(
                "u64 value was too large",
                "is too large; allowed: whole numbers up to 9223372036854775807",
            )
            .replace(
                "floating-point number overflowed",
                "is too large; allowed: numbers up to 1.7e308",
            )
            .replace("duplicate field", "a second key");
    };
    let allowed = match expected {
        "f32" | "f64" => "a number",
        "u32" => "a whole number from 0 to 4294967295",
        "u64" => "a whole number from 0 to 9223372036854775807",
        "a boolean" => "true or false",
        "a sequence" => "a list",
        other if other.starts_with("struct ") => "a table of keys",
        other => other.strip_prefix("one of ").unwrap_or(other),
    };
    let key = problem
        .strip_prefix("unknown field `")
        .map(|key| key.trim_end_matches('`'));
    let meant = key.and_then(|key| nearest(expected.split('`').skip(1).step_by(2), key));
    let problem = problem
        .replace("unknown field", "unknown key")
        .replace("unknown variant", "unknown choice")
        .replace("invalid type: ", "is ")
        .replace("invalid value: ", "is ")
        .replace("floating point", "number")
        .replace("map", "table")
        .replace("sequence", "list");
    problem + &instead(meant, &allowed.replace('`', ""))
}
