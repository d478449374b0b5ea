//! Columns of numbers from `.csv` files, by name or by position.

/// Reads the named columns: numbers row by row, and the line of each row. Without a header, or with one that has none
/// of these names, the file must have exactly as many columns as names, in their order. Other columns are ignored if
/// there is a header with the names. `check` converts a column's number, or says why it isn't allowed.
///
/// # Errors
/// The line and the column, the value found, and the allowed values.
pub(crate) fn read<S: AsRef<str>>(
    bytes: &[u8],
    names: &[S],
    check: impl Fn(f32, &str) -> Result<f32, String>,
) -> Result<(Vec<f32>, Vec<u64>), String> {
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let line = bytes[..error.valid_up_to()].split(|byte| *byte == b'\n').count();
        format!("line {line}: is not text: {error}")
    })?;
    let (mut values, mut lines) = (Vec::new(), Vec::new());
    let mut layout: Option<Layout> = None;
    let mut cells = Vec::new();
    for (text, line) in text.lines().zip(1..).filter(|(text, _)| !text.trim().is_empty()) {
        cells.clear();
        cells.extend(text.split(',').map(|cell| cell.trim().trim_matches('"')));
        let at_line = |problem| format!("line {line}: {problem}");
        // In a header, no cell is a number.
        let is_head = layout.is_none() && cells.iter().all(|cell| cell.parse::<f64>().is_err());
        let known = layout.get_or_insert(Layout::in_order(names.len()));
        if is_head {
            *known = Layout::named(&cells, names).map_err(at_line)?;
            continue;
        }
        if cells.len() != known.cells {
            let (count, allowed) = (cells.len(), known.cells);
            return Err(at_line(format!(
                "has {count} numbers; allowed: {allowed}, one a column"
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
    Ok((values, lines))
}

/// Positions of the wanted columns.
struct Layout {
    /// Number of cells in a row.
    cells: usize,
    /// Indices of the wanted columns, in the order of their names.
    columns: Vec<usize>,
}

impl Layout {
    fn in_order(count: usize) -> Self {
        Self {
            cells: count,
            columns: (0..count).collect(),
        }
    }

    fn named<S: AsRef<str>>(head: &[&str], names: &[S]) -> Result<Self, String> {
        let columns: Vec<Option<usize>> = names
            .iter()
            .map(|name| head.iter().position(|cell| *cell == name.as_ref()))
            .collect();
        let missing = names.iter().zip(&columns).find(|(_, column)| column.is_none());
        match missing {
            None => Ok(Self {
                cells: head.len(),
                columns: columns.into_iter().flatten().collect(),
            }),
            Some(_) if columns.iter().all(Option::is_none) && head.len() == names.len() => {
                Ok(Self::in_order(names.len()))
            }
            Some((name, _)) => {
                let all: Vec<&str> = names.iter().map(AsRef::as_ref).collect();
                Err(format!(
                    "names {} columns, but none is called {}; allowed: the columns {}, and any others beside them",
                    head.len(),
                    name.as_ref(),
                    all.join(", ")
                ))
            }
        }
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
        read(bytes, &["a", "b"], check).map(|(values, _)| values)
    }

    #[test]
    fn with_and_without_a_line_of_names() {
        assert_eq!(two(b"1, 2.5\n-3e-1,4\n").unwrap(), [1.0, 2.5, -0.3, 4.0]);
        assert_eq!(two(b"x,y\r\n1,2\r\n").unwrap(), [1.0, 2.0]);
        assert_eq!(two(b"b,a\n1,2\n").unwrap(), [2.0, 1.0]);
        assert_eq!(two(b"name,b,fitness,a\nbest,1,300,2\n").unwrap(), [2.0, 1.0]);
        assert_eq!(two(b"").unwrap().len(), 0);
    }

    #[test]
    fn invalid_lines_are_refused_with_their_number() {
        let refusal = |text: &str| two(text.as_bytes()).unwrap_err();
        assert!(refusal("1,2\n1,2,3\n").contains("line 2: has 3 numbers"));
        assert!(refusal("1,2\n\n1,x\n").contains("line 3, column 2: `x`"));
        assert!(refusal("1,nan\n").contains("line 1, column 2: nan"));
        assert!(refusal("1,1e39\n").contains("line 1, column 2: 1e39"));
        assert!(refusal("x,y\nc,d\n").contains("line 2, column 1"));
        assert!(refusal("a,c\n1,2\n").contains("line 1: names 2 columns, but none is called b"));
        assert!(refusal("x,y,z\n1,2,3\n").contains("allowed: the columns a, b"));
        assert!(refusal("b,c,a\n1,x\n").contains("line 2: has 2 numbers; allowed: 3"));
        assert!(refusal("b,c,a\n1,x,y\n").contains("line 2, column 3: `y`"));
        assert!(two(b"1,2\n1,\xff\n").unwrap_err().contains("line 2"));
    }
}
