//! Genomes from `.npy` files.

use super::checked;

/// Numbers of a `.npy` file, row by row.
pub(super) fn parse(bytes: &[u8], genes: usize) -> Result<Vec<f32>, String> {
    let allowed = format!("allowed: an array of float32 or float64 with the shape (rows, {genes})");
    let Some((header, numbers)) = Header::read(bytes) else {
        return Err(format!("is no .npy file, or not of one plain array; {allowed}"));
    };
    let rows = match header.shape[..] {
        [columns] if columns == genes => 1,
        [rows, columns] if columns == genes => rows,
        ref shape => return Err(format!("has the shape {shape:?}; {allowed}")),
    };
    let number: fn(&[u8]) -> Option<f64> = match header.kind {
        "<f4" => |bytes| Some(f32::from_le_bytes(bytes.try_into().ok()?).into()),
        ">f4" => |bytes| Some(f32::from_be_bytes(bytes.try_into().ok()?).into()),
        "<f8" => |bytes| Some(f64::from_le_bytes(bytes.try_into().ok()?)),
        ">f8" => |bytes| Some(f64::from_be_bytes(bytes.try_into().ok()?)),
        other => return Err(format!("has numbers of the type {other}; {allowed}")),
    };
    let size = if header.kind.ends_with('4') { 4 } else { 8 };
    let wanted = rows.saturating_mul(genes).saturating_mul(size);
    let stored: Vec<f64> = numbers.chunks(size).filter_map(number).collect();
    if numbers.len() != wanted {
        return Err(format!(
            "has {} bytes of numbers, but its header means {wanted}: it is cut off or damaged",
            numbers.len()
        ));
    }
    let mut values = Vec::with_capacity(stored.len());
    for row in 0..rows {
        for column in 0..genes {
            let value = stored[if header.is_by_columns {
                column * rows + row
            } else {
                row * genes + column
            }];
            let gene = checked(value as f32, &value);
            values.push(gene.map_err(|problem| format!("row {}, gene {}: {problem}", row + 1, column + 1))?);
        }
    }
    Ok(values)
}

/// What the header of a plain array says: a dictionary as Python writes it.
struct Header<'a> {
    /// Of the numbers, such as `<f4`.
    kind: &'a str,
    is_by_columns: bool,
    shape: Vec<usize>,
}

impl<'a> Header<'a> {
    /// The header of a file and the bytes behind it.
    fn read(bytes: &'a [u8]) -> Option<(Self, &'a [u8])> {
        let (length, rest) = match bytes {
            [0x93, b'N', b'U', b'M', b'P', b'Y', 1, 0, low, high, rest @ ..] => {
                (u16::from_le_bytes([*low, *high]).into(), rest)
            }
            [0x93, b'N', b'U', b'M', b'P', b'Y', 2 | 3, 0, a, b, c, d, rest @ ..] => {
                (u32::from_le_bytes([*a, *b, *c, *d]) as usize, rest)
            }
            _ => return None,
        };
        let (text, numbers) = rest.split_at_checked(length)?;
        Some((Self::parse(str::from_utf8(text).ok()?)?, numbers))
    }

    fn parse(text: &'a str) -> Option<Self> {
        let (mut kind, mut order, mut shape) = (None, None, None);
        let mut rest = text.trim().strip_prefix('{')?.strip_suffix('}')?.trim();
        while !rest.is_empty() {
            let (key, behind) = rest.split_once(':')?;
            let key = unquoted(key.trim())?;
            // Only a shape has commas of its own.
            let end = match key {
                "shape" => behind.find(')')? + 1,
                _ => behind.find(',').unwrap_or(behind.len()),
            };
            let (value, behind) = behind.split_at(end);
            let value = value.trim();
            match key {
                "descr" => kind = Some(unquoted(value)?),
                "fortran_order" if value == "True" => order = Some(true),
                "fortran_order" if value == "False" => order = Some(false),
                "shape" => {
                    let lengths = value.strip_prefix('(')?.strip_suffix(')')?.trim();
                    let lengths = lengths.strip_suffix(',').unwrap_or(lengths).split(',');
                    shape = Some(
                        lengths
                            .map(|length| length.trim().parse().ok())
                            .collect::<Option<_>>()?,
                    );
                }
                _ => return None,
            }
            let behind = behind.trim_start();
            rest = match behind.strip_prefix(',') {
                Some(next) => next.trim_start(),
                None if behind.is_empty() => behind,
                None => return None,
            };
        }
        Some(Self {
            kind: kind?,
            is_by_columns: order?,
            shape: shape?,
        })
    }
}

/// What stands between two quotation marks of a kind.
fn unquoted(text: &str) -> Option<&str> {
    let of = |mark| text.strip_prefix(mark)?.strip_suffix(mark);
    of('\'').or_else(|| of('"'))
}

#[cfg(test)]
mod tests {
    use npyz::{Order, WriterBuilder};

    use super::*;

    fn npy<T: npyz::AutoSerialize>(values: &[T], shape: &[u64], order: Order) -> Vec<u8> {
        let mut bytes = Vec::new();
        let writer = npyz::WriteOptions::new()
            .default_dtype()
            .order(order)
            .shape(shape)
            .writer(&mut bytes);
        let mut writer = writer.begin_nd().unwrap();
        for value in values {
            writer.push(value).unwrap();
        }
        writer.finish().unwrap();
        bytes
    }

    #[test]
    fn npy_of_both_widths_and_orders() {
        let genes = [1.0_f32, 2.0, 3.0, 4.0, 5.0, 6.0];
        assert_eq!(parse(&npy(&genes, &[3, 2], Order::C), 2).unwrap(), genes);
        assert_eq!(parse(&npy(&genes.map(f64::from), &[3, 2], Order::C), 2).unwrap(), genes);
        assert_eq!(
            parse(&npy(&[1.0, 3.0, 5.0, 2.0, 4.0, 6.0], &[3, 2], Order::Fortran), 2).unwrap(),
            genes
        );
        assert_eq!(parse(&npy(&genes, &[6], Order::C), 6).unwrap(), genes);
    }

    #[test]
    fn npy_that_is_not_allowed_is_refused_with_its_place() {
        let refusal = |bytes: &[u8]| parse(bytes, 2).unwrap_err();
        assert!(refusal(&npy(&[1.0_f32; 6], &[2, 3], Order::C)).contains("[2, 3]"));
        assert!(refusal(&npy(&[1_i32; 4], &[2, 2], Order::C)).contains("i4"));
        assert!(refusal(&npy(&[0.0, 1.0, 2.0, f32::NAN], &[2, 2], Order::C)).contains("row 2, gene 2: NaN"));
        assert!(refusal(&npy(&[0.0, 1e300], &[1, 2], Order::C)).contains("row 1, gene 2"));
    }

    #[test]
    fn damaged_npy_is_refused_whatever_is_wrong() {
        let good = npy(&[1.0_f32, 2.0, 3.0, 4.0], &[2, 2], Order::C);
        for length in 0..good.len() {
            parse(&good[..length], 2).unwrap_err();
        }
        for place in 0..good.len() {
            for bit in 0..8 {
                let mut bad = good.clone();
                bad[place] ^= 1 << bit;
                // Some flips only change a number; none may panic.
                let _ = parse(&bad, 2);
            }
        }
        let mut deep = b"\x93NUMPY\x01\x00\xff\xff".to_vec();
        deep.extend(std::iter::repeat_n(b'(', 65535));
        parse(&deep, 2).unwrap_err();
    }

    /// Headers that other programs write, and ones that nobody should.
    #[test]
    fn headers_are_read_as_python_reads_them() {
        let read = |version: &[u8], header: &str| {
            let length = (header.len() as u32).to_le_bytes();
            let length = &length[..if version[0] == 1 { 2 } else { 4 }];
            let numbers = [1.0_f32, 2.0].map(f32::to_le_bytes).concat();
            parse(
                &[b"\x93NUMPY", version, length, header.as_bytes(), &numbers].concat(),
                2,
            )
        };
        for good in [
            "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 2), }    \n",
            "{'shape':(2,),'fortran_order':True,'descr':\"<f4\"}",
            "{ \"shape\" : ( 1 , 2 , ) , 'descr' : '<f4' , 'fortran_order' : False }\n",
        ] {
            for version in [[1, 0], [2, 0], [3, 0]] {
                assert_eq!(read(&version, good).unwrap(), [1.0, 2.0], "{good}");
            }
        }
        for (bad, problem) in [
            ("", "is no .npy file"),
            ("{}", "is no .npy file"),
            ("{'descr': '<f4', 'fortran_order': False}", "is no .npy file"),
            ("{'descr': '<f4', 'shape': (1, 2)}", "is no .npy file"),
            (
                "{'descr': '<f4', 'fortran_order': 0, 'shape': (1, 2)}",
                "is no .npy file",
            ),
            (
                "{'descr': [('a', '<f4')], 'fortran_order': False, 'shape': (2,)}",
                "is no .npy file",
            ),
            (
                "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 2) 3}",
                "is no .npy file",
            ),
            (
                "{'descr': '<f4', 'fortran_order': False, 'shape': (1, -2)}",
                "is no .npy file",
            ),
            (
                "{'descr': '<f4', 'fortran_order': False, 'shape': ()}",
                "is no .npy file",
            ),
            (
                "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 2, 1)}",
                "has the shape [1, 2, 1]",
            ),
            (
                "{'descr': '<f2', 'fortran_order': False, 'shape': (1, 2)}",
                "of the type <f2",
            ),
            (
                "{'descr': '<f4', 'fortran_order': False, 'shape': (9223372036854775807, 2)}",
                "is cut off or damaged",
            ),
        ] {
            let refused = read(&[1, 0], bad).unwrap_err();
            assert!(refused.contains(problem), "{bad}: {refused}");
        }
        assert!(read(&[4, 0], "{}").is_err());
    }
}
