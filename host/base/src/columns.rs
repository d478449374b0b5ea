//! Columns of numbers from `.csv` files, by name, or by position in files that name none.

use std::collections::HashMap;

use crate::console::counted;

/// Names that a message lists, and those that it lists of what is allowed.
pub const LISTED: usize = 4;
const ALLOWED: usize = 32;

/// Numbers of the wanted columns.
#[derive(Debug)]
pub struct Columns {
    /// Row by row, in the order of the wanted names.
    pub values: Vec<f32>,
    /// Line of each row.
    pub lines: Vec<u64>,
    /// What the user should hear: that columns were taken by position, or which ones are ignored.
    pub word: Option<String>,
}

/// Reads the named columns. A first line without any number has the columns' names, in any order and in upper or lower
/// case, and all wanted names must be among them; other columns are ignored. Without names, the file must have exactly
/// the wanted columns in their order. `check` converts a column's number, or returns why it isn't allowed.
///
/// # Errors
/// The line and the column, the value found, and the allowed values.
pub fn read<S: AsRef<str>>(
    bytes: &[u8],
    names: &[S],
    check: impl Fn(f32, &str) -> Result<f32, String>,
) -> Result<Columns, String> {
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let line = bytes[..error.valid_up_to()].split(|byte| *byte == b'\n').count();
        format!("line {line}: is not text: {error}")
    })?;
    // Spreadsheets begin a file with a byte order mark.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let (mut values, mut lines) = (Vec::new(), Vec::new());
    separated(text)?;
    let mut layout: Option<Layout> = None;
    let mut cells = Vec::new();
    for (text, line) in text.lines().zip(1..).filter(|(text, _)| !text.trim().is_empty()) {
        cells.clear();
        cells.extend(text.split(',').map(|cell| cell.trim().trim_matches('"')));
        let at_line = |problem| format!("line {line}: {problem}");
        // In a header, no cell is a number.
        let is_head = layout.is_none() && cells.iter().all(|cell| cell.parse::<f64>().is_err());
        if is_head {
            layout = Some(Layout::named(&cells, names).map_err(at_line)?);
            continue;
        }
        let known = layout.get_or_insert_with(|| Layout::in_order(names));
        if cells.len() != known.cells {
            let (count, allowed) = (cells.len(), known.cells);
            return Err(at_line(format!(
                "has {}; allowed: {allowed}, one a column",
                counted(count, "number", "numbers")
            )));
        }
        for &index in &known.columns {
            let cell = cells[index];
            let place = |problem| format!("line {line}, column {}: {problem}", index + 1);
            let value = cell
                .parse::<f32>()
                .map_err(|_| place(format!("`{cell}` is no number")))?;
            values.push(check(value, cell).map_err(place)?);
        }
        lines.push(line);
    }
    let word = layout.and_then(|layout| layout.word);
    Ok(Columns { values, lines, word })
}

/// Finds each wanted name among others: the same letters first, else the only name that differs only in upper and lower
/// case.
///
/// # Errors
/// A wanted name occurs twice.
pub fn places<S: AsRef<str>, T: AsRef<str>>(found: &[S], wanted: &[T]) -> Result<Vec<Option<usize>>, String> {
    let folded = |name: &str| name.to_lowercase();
    let mut known = HashMap::<&str, Vec<usize>>::new();
    for (name, place) in found.iter().zip(0..) {
        known.entry(name.as_ref()).or_default().push(place);
    }
    // Names that differ only in case are only found by exactly their letters.
    let (mut alike, mut twice) = (HashMap::<String, Vec<usize>>::new(), HashMap::<String, u32>::new());
    for name in wanted {
        *twice.entry(folded(name.as_ref())).or_default() += 1;
    }
    for (name, place) in found.iter().zip(0..) {
        alike.entry(folded(name.as_ref())).or_default().push(place);
    }
    let place = |name: &T| {
        let (name, key) = (name.as_ref(), folded(name.as_ref()));
        let by_case = || alike.get(&key).filter(|_| twice[&key] == 1);
        match known.get(name).or_else(by_case).map(Vec::as_slice) {
            None => Ok(None),
            Some([place]) => Ok(Some(*place)),
            Some(several) => Err(format!(
                "{} `{name}`; allowed: each name once",
                counted(several.len(), "name is", "names are")
            )),
        }
    };
    wanted.iter().map(place).collect()
}

/// Some names for a message: the first ones, and how many more there are.
pub fn listed<S: AsRef<str>>(names: &[S], most: usize) -> String {
    let shown: Vec<String> = names
        .iter()
        .take(most)
        .map(|name| format!("`{}`", name.as_ref()))
        .collect();
    match names.len().saturating_sub(most) {
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}

/// Refuses a table that has something else than commas between its cells, as spreadsheets write it in some languages.
fn separated(text: &str) -> Result<(), String> {
    let (line, first) = (1..)
        .zip(text.lines())
        .find(|(_, line)| !line.trim().is_empty())
        .unwrap_or_default();
    match [(';', "semicolons"), ('\t', "tabs")]
        .iter()
        .find(|(mark, _)| first.contains(*mark))
    {
        Some((_, marks)) => Err(format!(
            "line {line}: has {marks} between its cells; allowed: commas, and points in numbers"
        )),
        None => Ok(()),
    }
}

/// Positions of the wanted columns.
pub struct Layout {
    /// Number of cells in a row.
    cells: usize,
    /// Indices of the wanted columns, in the order of their names.
    pub columns: Vec<usize>,
    /// As [`Columns::word`].
    pub word: Option<String>,
}

impl Layout {
    fn in_order<S: AsRef<str>>(names: &[S]) -> Self {
        let order = listed(names, LISTED);
        Self {
            cells: names.len(),
            columns: (0..names.len()).collect(),
            word: Some(format!("names no columns; they are read in this order: {order}")),
        }
    }

    /// Finds columns by a line of names.
    ///
    /// # Errors
    /// A wanted name is missing, or occurs twice.
    pub fn named<S: AsRef<str>>(head: &[&str], names: &[S]) -> Result<Self, String> {
        let places = places(head, names)?;
        let mut others = head.to_vec();
        for place in places.iter().flatten() {
            others[*place] = "";
        }
        others.retain(|name| !name.is_empty());
        let others = listed(&others, LISTED);
        let missing = names.iter().zip(&places).filter(|(_, place)| place.is_none());
        let missing: Vec<&str> = missing.map(|(name, _)| name.as_ref()).collect();
        if missing.is_empty() {
            return Ok(Self {
                cells: head.len(),
                columns: places.into_iter().flatten().collect(),
                word: (!others.is_empty()).then(|| format!("has other columns, which are ignored: {others}")),
            });
        }
        Err(format!(
            "names {}, but none is called {}; allowed: all of {}, in any order and among any others, or no line of names and \
             these columns in this order",
            counted(head.len(), "column", "columns"),
            listed(&missing, LISTED),
            listed(names, ALLOWED)
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn two(bytes: &[u8]) -> Result<Vec<f32>, String> {
        let check = |value: f32, shown: &str| {
            if value.is_finite() {
                Ok(value)
            } else {
                Err(format!("{shown} is not finite"))
            }
        };
        read(bytes, &["a", "b"], check).map(|columns| columns.values)
    }

    /// The message about a file whose columns are `a` and `b`.
    fn word(text: &str) -> String {
        let columns = read(text.as_bytes(), &["a", "b"], |value, _| Ok(value)).unwrap();
        columns.word.unwrap_or_default()
    }

    #[test]
    fn with_and_without_a_line_of_names() {
        assert_eq!(two(b"1, 2.5\n-3e-1,4\n").unwrap(), [1.0, 2.5, -0.3, 4.0]);
        assert_eq!(two(b"b,a\r\n1,2\r\n").unwrap(), [2.0, 1.0]);
        assert_eq!(two(b"B,A\n1,2\n").unwrap(), [2.0, 1.0]);
        assert_eq!(two(b"\xef\xbb\xbf\"B\",\"a\"\n1,2\n").unwrap(), [2.0, 1.0]);
        assert_eq!(two(b"name,b,fitness,a\nbest,1,300,2\n").unwrap(), [2.0, 1.0]);
        assert_eq!(two(b"").unwrap().len(), 0);
    }

    #[test]
    fn what_is_not_by_name_is_said() {
        assert_eq!(word("b,a\n1,2\n"), "");
        assert_eq!(word("1,2\n"), "names no columns; they are read in this order: `a`, `b`");
        assert_eq!(
            word("id,A,c,B,d,e,f\nx,1,0,2,0,0,0\n"),
            "has other columns, which are ignored: `id`, `c`, `d`, `e` and 1 more"
        );
    }

    #[test]
    fn names_that_differ_in_case_alone_are_found_by_their_letters() {
        let two = |found: &[&str]| places(found, &["Left", "left", "right"]);
        assert_eq!(two(&["RIGHT", "left", "Left"]).unwrap(), [Some(2), Some(1), Some(0)]);
        assert_eq!(two(&["LEFT", "left", "right"]).unwrap(), [None, Some(1), Some(2)]);
        assert!(
            two(&["left", "Right", "RIGHT"])
                .unwrap_err()
                .contains("2 names are `right`")
        );
        assert!(two(&["left", "left"]).unwrap_err().contains("2 names are `left`"));
        // A name's own letters come first.
        assert_eq!(two(&["right", "Right"]).unwrap()[2], Some(0));
    }

    #[test]
    fn invalid_lines_are_refused_with_their_number() {
        let refusal = |text: &str| two(text.as_bytes()).unwrap_err();
        assert!(refusal("1,2\n1,2,3\n").contains("line 2: has 3 numbers"));
        assert!(refusal("1,2\n\n1,x\n").contains("line 3, column 2: `x`"));
        assert!(refusal("1,nan\n").contains("line 1, column 2: nan"));
        assert!(refusal("1,1e39\n").contains("line 1, column 2: 1e39"));
        assert!(refusal("a,b\nc,d\n").contains("line 2, column 1"));
        assert!(refusal("a,c\n1,2\n").contains("line 1: names 2 columns, but none is called `b`"));
        assert!(refusal("x,y\n1,2\n").contains("none is called `a`, `b`; allowed: all of `a`, `b`, in any order"));
        assert!(refusal("a,a,b\n1,2,3\n").contains("line 1: 2 names are `a`"));
        assert!(refusal("b,c,a\n1,x\n").contains("line 2: has 2 numbers; allowed: 3"));
        assert!(refusal("b,c,a\n1,x,y\n").contains("line 2, column 3: `y`"));
        assert!(two(b"1,2\n1,\xff\n").unwrap_err().contains("line 2"));
    }
}
