//! Conversion between an experiment's TOML and its fields, by the rows that describe each value.

use oneiro::parameter::{Allowed, Datum, Field, Parameter, nearest};
use oneiro_base::exit::{Failure, Result};
use toml::{Table, Value};

use super::degrees;
use super::source::{Source, Unknown};

/// Values that rows describe.
pub trait Described: Default + 'static {
    /// One row for each value, in the order of a file.
    fn rows() -> &'static [Parameter<Self>];

    /// Why a value can't have an effect with the chosen kinds, if more can be said than which kinds it has one with.
    fn reason(&self, _key: &str) -> Option<String> {
        None
    }
}

/// A value of a file and its row.
struct Leaf<T: 'static> {
    /// Full path, such as `arena.walls[2].class`.
    path: String,
    /// Index of the list element that it belongs to; 0 without one.
    index: usize,
    row: &'static Parameter<T>,
    datum: Datum,
}

/// Sets the values that a file has and leaves all others.
///
/// # Errors
/// Exit 3: the place, the key, the value found, and the allowed values.
pub fn read<T: Described>(given: &Table, own: &mut T, source: &Source<'_>) -> Result {
    let mut leaves = Vec::new();
    let mut unknown = Unknown::default();
    for (key, value) in given {
        collect(key, value, source, &mut leaves, &mut unknown)?;
    }
    unknown.refused()?;
    // Kinds come first.
    for kinds in [true, false] {
        for leaf in &leaves {
            set(leaf, kinds, own, source)?;
        }
    }
    for row in T::rows() {
        for index in 0..row.count(own) {
            let datum = (row.field)(own, index).and_then(|field| field.get());
            let name = row.name(index);
            if datum.is_some_and(|datum| is_open(&datum)) && !leaves.iter().any(|leaf| leaf.path == name) {
                let (table, key) = name.rsplit_once('.').unwrap_or(("", &name));
                let field = (row.field)(own, index).map(|field| allowed(row, field));
                let (words, unit) = (field.unwrap_or_default(), unit_words(row.key, row.unit));
                return Err(source.invalid(table, format_args!("lacks `{key}`; allowed: {words}{unit}")));
            }
        }
    }
    oneiro::parameter::check(T::rows(), own).map_err(|invalid| {
        let row = T::rows().iter().find(|row| row.key == key_of(&invalid.field).0);
        // Degrees are a common mistake.
        let turns = if row.is_some_and(|row| row.unit == "turns") {
            " turns, each of 360 degrees"
        } else {
            ""
        };
        source.invalid(&invalid.field, format_args!("{}{turns}", invalid.problem))
    })
}

/// Collects the values at a path and below, and the keys that no row has.
fn collect<T: Described>(
    path: &str,
    value: &Value,
    source: &Source<'_>,
    leaves: &mut Vec<Leaf<T>>,
    unknown: &mut Unknown,
) -> Result {
    let (key, index) = key_of(path);
    let has = |start: String| T::rows().iter().any(|row| row.key.starts_with(&start));
    let Some(row) = T::rows().iter().find(|row| row.key == key) else {
        if !has(format!("{key}.")) {
            unknown.add(unknown_key::<T>(path, source));
            return Ok(());
        }
        let Value::Table(table) = value else {
            return Err(source.invalid(path, format_args!("is {}; allowed: a table of keys", datum(value))));
        };
        for (key, value) in table {
            collect(&format!("{path}.{key}"), value, source, leaves, unknown)?;
        }
        return Ok(());
    };
    let elements = match value {
        Value::Array(list) if has(format!("{key}[].")) => &list[..],
        _ => &[],
    };
    leaves.push(Leaf {
        path: path.to_owned(),
        index,
        row,
        datum: datum(value),
    });
    for (index, value) in elements.iter().enumerate() {
        collect(&format!("{path}[{index}]"), value, source, leaves, unknown)?;
    }
    Ok(())
}

/// Error for an unknown key, with the allowed keys of its table and the one that was probably meant.
fn unknown_key<T: Described>(path: &str, source: &Source<'_>) -> Failure {
    let (key, _) = key_of(path);
    let (table, own) = key.rsplit_once('.').map_or(("", &*key), |(table, own)| (table, own));
    let mut siblings: Vec<&str> = Vec::new();
    for row in T::rows() {
        let below = if table.is_empty() {
            Some(row.key)
        } else {
            row.key.strip_prefix(table).and_then(|below| below.strip_prefix('.'))
        };
        let sibling = below.and_then(|below| below.split(['.', '[']).next());
        siblings.extend(sibling.filter(|sibling| !siblings.contains(sibling)));
    }
    let keys = || T::rows().iter().map(|row| row.key);
    let tables = keys().flat_map(|key| key.match_indices('.').map(|(end, _)| &key[..end]));
    // A key of the same table is more likely than one of another.
    let of_table = |name: &str| {
        if table.is_empty() {
            name.to_owned()
        } else {
            format!("{table}.{name}")
        }
    };
    let sibling = nearest(siblings.iter().copied(), own).map(of_table);
    let meant = sibling.as_deref();
    let meant = meant.or_else(|| nearest(keys().chain(tables.filter(|table| !table.contains('['))), &key));
    let meant = meant.map(|meant| {
        if meant == own {
            format!("{meant}, which is in no table")
        } else {
            meant.to_owned()
        }
    });
    let problem = format!("unknown key `{own}`{}", instead(meant.as_deref(), &siblings.join(", ")));
    source.invalid_key(path, problem)
}

/// Suggestions for an unknown name: first the one that was probably meant, then all allowed ones.
pub fn instead(meant: Option<&str>, allowed: &str) -> String {
    match meant {
        Some(meant) => format!("; did you mean {meant}? (allowed: {allowed})"),
        None => format!("; allowed: {allowed}"),
    }
}

/// Whether other values exist only under one choice of this one. No value depends on the kind of a list's element.
fn is_kind(key: &str) -> bool {
    key.rsplit('.').next() == Some("kind") && !key.contains("[]")
}

/// Sets one value, if it is such a kind and `kinds` is true, or if neither.
fn set<T: Described>(leaf: &Leaf<T>, kinds: bool, own: &mut T, source: &Source<'_>) -> Result {
    let Some(field) = (leaf.row.field)(own, leaf.index) else {
        if kinds {
            return Ok(());
        }
        let (key, words) = under(leaf.row, Some(own)).map_or_else(|| ("kind", String::new()), |(kind, _)| kind);
        let reason = own
            .reason(leaf.row.key)
            .map_or_else(String::new, |reason| format!(", but {reason}"));
        let problem = format_args!("is given{reason}; allowed: only with {key} = {words}");
        return source.leave_out_of_kind(&leaf.path, problem);
    };
    if is_kind(leaf.row.key) != kinds || taken(field, &leaf.datum) {
        return Ok(());
    }
    if let Datum::Table(table) = &leaf.datum {
        // A refusal of a table by names is for one of its values.
        let is_refused =
            |(name, datum): &&(String, Datum)| !field.set(&Datum::Table(vec![(name.clone(), datum.clone())]));
        if let Some((name, datum)) = table.iter().find(is_refused)
            && let Some(kind) = field.kind().strip_prefix("a table of ")
        {
            let problem = format!("is {datum}; allowed: {kind}");
            return Err(source.invalid(&format!("{}.{name}", leaf.path), problem));
        }
    }
    let example = match leaf.datum {
        Datum::Double(number) if field.kind() == "a whole number" && number.fract() == 0.0 => {
            format!(", such as {number}")
        }
        _ => String::new(),
    };
    let problem = format!("is {}; allowed: {}{example}", leaf.datum, allowed(leaf.row, field));
    Err(source.invalid(&leaf.path, problem))
}

/// Sets a field, and returns whether it accepted the value.
fn taken(field: &mut dyn Field, datum: &Datum) -> bool {
    match datum {
        Datum::List(list) if field.get().is_none() && field.resize(list.len()) => true,
        _ => field.set(datum),
    }
}

/// Whether the row of a key allows a value of its type, and what it allows; `None` without such a row.
pub(super) fn alone<T: Described>(key: &str, value: &dyn Field) -> Option<(bool, String)> {
    let row = T::rows().iter().find(|row| row.key == key)?;
    let is_allowed = value
        .get()
        .is_some_and(|datum| row.allowed.check(&datum, |_| None).is_ok());
    Some((is_allowed, allowed(row, value)))
}

/// Description of the values that a row allows.
pub(super) fn allowed<T>(row: &Parameter<T>, field: &dyn Field) -> String {
    let choices: Vec<&str> = field.choices().into_iter().map(|(word, _)| word).collect();
    match (&choices[..], row.allowed) {
        ([], Allowed::Any) => field.kind().to_owned(),
        ([], Allowed::Text(words)) => words.to_owned(),
        ([], range) => format!("{} from {range}", field.kind()),
        ([one], _) => (*one).to_owned(),
        ([first, second], _) => format!("{first} or {second}"),
        (all, _) => all.join(", "),
    }
}

/// A key's unit in words that follow a range.
pub(super) fn unit_words(key: &str, unit: &str) -> String {
    match degrees::name(key, unit) {
        _ if unit.is_empty() => String::new(),
        Some(name) => {
            let name = name.rsplit('.').next().unwrap_or_default();
            format!(" ({unit}; in degrees: `{name}`)")
        }
        None => format!(" ({unit})"),
    }
}

/// The choice that a value requires, of its table's `kind`, or else of the robot's, the optimiser's or its selection's, as a key and
/// its words; and settings with the first of them. A value that all words of a choice have does not require one of them, and
/// of settings that lack the value, what is wrong is not a choice that allows it.
pub(super) fn under<T: Described>(
    row: &Parameter<T>,
    mut lacking: Option<&mut T>,
) -> Option<((&'static str, String), T)> {
    const OTHERS: [&str; 3] = ["robot.kind", "evolution.kind", "evolution.selection.kind"];
    let (list, _) = row.key.split_once("[]").unwrap_or((row.key, ""));
    let (table, _) = list.rsplit_once('.')?;
    let own = format!("{table}.kind");
    let kinds = std::iter::once((&*own, "kind")).chain(OTHERS.map(|key| (key, key)));
    kinds.into_iter().find_map(|(key, shown)| {
        let kind = T::rows().iter().find(|kind| kind.key == key)?;
        let words = (kind.field)(&mut T::default(), 0)?.choices();
        let with = |word: &'static str| {
            let mut own = T::default();
            (kind.field)(&mut own, 0)?.set(&Datum::Word(word.into()));
            grow(row, &mut own);
            (row.field)(&mut own, 0)?;
            Some((word, own))
        };
        let mut found: Vec<(&str, T)> = words.iter().filter_map(|(word, _)| with(word)).collect();
        // A choice that is not written is the first.
        let first = || Datum::Word(words[0].0.into());
        let now = lacking
            .as_mut()
            .and_then(|own| (kind.field)(own, 0))
            .map(|field| field.get().unwrap_or_else(first));
        let is_allowed = found.iter().any(|(word, _)| now == Some(Datum::Word((*word).into())));
        if found.is_empty() || found.len() == words.len() || is_allowed {
            return None;
        }
        let allowed: Vec<String> = found.iter().map(|(word, _)| format!("{word:?}")).collect();
        Some(((shown, allowed.join(" or ")), found.swap_remove(0).1))
    })
}

/// The row of a path, and the index of the list element that it belongs to.
pub(super) fn row_of<T: Described>(path: &str) -> Option<(&'static Parameter<T>, usize)> {
    let (key, index) = key_of(path);
    T::rows().iter().find(|row| row.key == key).map(|row| (row, index))
}

/// Settings in which a value has its default, under the first choice that has it.
pub(super) fn with_default<T: Described>(row: &Parameter<T>) -> T {
    let mut own = T::default();
    grow(row, &mut own);
    if (row.field)(&mut own, 0).is_none() {
        own = under(row, None).map_or(own, |(_, own)| own);
    }
    own
}

/// The default of a value, if it has one.
pub(super) fn default_of<T: Described>(row: &Parameter<T>) -> Option<Datum> {
    let datum = (row.field)(&mut with_default(row), 0)?.get()?;
    (!is_open(&datum)).then_some(datum)
}

/// Whether a list of tables has elements.
pub(super) fn has_elements<T: Described>(list: &Parameter<T>, own: &mut T) -> bool {
    let start = format!("{}[].", list.key);
    T::rows()
        .iter()
        .any(|row| row.key.starts_with(&start) && row.count(own) > 0)
}

/// Removes the value at a path such as `arena.walls[2].class`.
pub(super) fn remove(table: &mut Table, path: &str) {
    let (first, rest) = path
        .split_once('.')
        .map_or((path, None), |(first, rest)| (first, Some(rest)));
    let Some(rest) = rest else {
        table.remove(first);
        return;
    };
    let inner = match first.split_once('[') {
        None => table.get_mut(first),
        Some((list, index)) => table
            .get_mut(list)
            .and_then(Value::as_array_mut)
            .and_then(|list| list.get_mut(index.trim_end_matches(']').parse::<usize>().ok()?)),
    };
    if let Some(inner) = inner.and_then(Value::as_table_mut) {
        remove(inner, rest);
    }
}

/// Adds an element to the list that a value belongs to, if it does.
pub(super) fn grow<T: Described>(row: &Parameter<T>, own: &mut T) {
    let list = row.key.split_once("[]").map(|(list, _)| list);
    let list = list.and_then(|list| T::rows().iter().find(|row| row.key == list));
    if let Some(list) = list.and_then(|list| (list.field)(own, 0)) {
        list.resize(1);
    }
}

/// All values as TOML, in the order of the rows. Single-precision numbers keep the digits they have in `given`.
pub fn table<T: Described>(own: &mut T, given: &Table) -> Table {
    let mut all = Table::new();
    for row in T::rows() {
        for index in 0..row.count(own) {
            let Some(datum) = (row.field)(own, index).and_then(|field| field.get()) else {
                continue;
            };
            let name = row.name(index);
            let exact = at(given, &name).map(self::datum);
            put(&mut all, &name, value(&datum, exact.as_ref()));
        }
    }
    ordered(all)
}

/// The defaults of the kinds that are chosen here.
pub(super) fn with_kinds_of<T: Described>(own: &mut T) -> T {
    let mut usual = T::default();
    for row in T::rows().iter().filter(|row| is_kind(row.key)) {
        let kind = (row.field)(own, 0).and_then(|field| field.get());
        if let (Some(kind), Some(field)) = (kind, (row.field)(&mut usual, 0)) {
            field.set(&kind);
        }
    }
    usual
}

/// Puts values before tables, as TOML requires.
fn ordered(table: Table) -> Table {
    let (tables, values): (Vec<_>, Vec<_>) = table.into_iter().partition(|(_, value)| value.is_table());
    let tables = tables.into_iter().map(|(key, value)| match value {
        Value::Table(table) => (key, Value::Table(ordered(table))),
        other => (key, other),
    });
    values.into_iter().chain(tables).collect()
}

/// The value at a path such as `arena.walls[2].class`.
pub fn at<'a>(table: &'a Table, path: &str) -> Option<&'a Value> {
    let (first, rest) = path
        .split_once('.')
        .map_or((path, None), |(first, rest)| (first, Some(rest)));
    let mut value = match first.split_once('[') {
        Some((list, index)) => table
            .get(list)?
            .get(index.trim_end_matches(']').parse::<usize>().ok()?)?,
        None => table.get(first)?,
    };
    if let Some(rest) = rest {
        value = at(value.as_table()?, rest)?;
    }
    Some(value)
}

/// Puts a value at a path, creating the tables and the next element of a list on the way.
pub(super) fn put(table: &mut Table, path: &str, value: Value) {
    let Some((first, rest)) = path.split_once('.') else {
        table.insert(path.into(), value);
        return;
    };
    let inner = match first.split_once('[') {
        None => table.entry(first).or_insert_with(|| Table::new().into()),
        Some((list, index)) => {
            let list = table.entry(list).or_insert_with(|| Value::Array(Vec::new()));
            let list = list.as_array_mut().expect("rows are lists or none");
            let index: usize = index.trim_end_matches(']').parse().expect("rows number elements");
            if list.len() <= index {
                list.resize(index + 1, Table::new().into());
            }
            &mut list[index]
        }
    };
    put(inner.as_table_mut().expect("rows are tables or none"), rest, value);
}

/// Splits a path into its row's key and its index: `arena.walls[2].class` into `arena.walls[].class` and 2.
fn key_of(path: &str) -> (String, usize) {
    let Some((list, rest)) = path.split_once('[') else {
        return (path.to_owned(), 0);
    };
    let (index, rest) = rest.split_once(']').unwrap_or((rest, ""));
    (format!("{list}[]{rest}"), index.parse().unwrap_or(0))
}

/// Whether a number has not been set.
pub(super) fn is_open(datum: &Datum) -> bool {
    match datum {
        Datum::Single(number) => number.is_nan(),
        Datum::List(list) => list.iter().any(is_open),
        _ => false,
    }
}

fn datum(value: &Value) -> Datum {
    match value {
        Value::Boolean(flag) => Datum::Flag(*flag),
        Value::Integer(number) => Datum::Whole((*number).into()),
        Value::Float(number) => Datum::Double(*number),
        Value::String(word) => Datum::Word(word.clone()),
        Value::Datetime(time) => Datum::Word(time.to_string()),
        Value::Array(list) => Datum::List(list.iter().map(datum).collect()),
        Value::Table(table) => Datum::Table(table.iter().map(|(key, value)| (key.clone(), datum(value))).collect()),
    }
}

/// A field's value as TOML, with the digits given in the file.
pub(super) fn value(own: &Datum, given: Option<&Datum>) -> Value {
    match own {
        Datum::Flag(flag) => (*flag).into(),
        Datum::Whole(number) => (*number as i64).into(),
        Datum::Single(number) => match given {
            Some(Datum::Double(exact)) => *exact,
            Some(Datum::Whole(exact)) => *exact as f64,
            // The shortest digits that distinguish it from its neighbours.
            _ => number.to_string().parse().unwrap_or(f64::NAN),
        }
        .into(),
        Datum::Double(number) => (*number).into(),
        Datum::Word(word) => word.clone().into(),
        Datum::List(list) => {
            let given = |index: usize| match given {
                Some(Datum::List(given)) => given.get(index),
                _ => None,
            };
            let values = list.iter().enumerate().map(|(index, own)| value(own, given(index)));
            Value::Array(values.collect())
        }
        Datum::Table(table) => {
            let values = table.iter().map(|(key, own)| (key.clone(), value(own, None)));
            Value::Table(values.collect())
        }
    }
}
