//! Genomes from `.npy` files.

use npyz::{NpyFile, Order};

use super::checked;

/// Numbers of a `.npy` file, row by row.
pub(super) fn parse(bytes: &[u8], genes: usize) -> Result<Vec<f32>, String> {
    let allowed = format!("allowed: an array of float32 or float64 with the shape (rows, {genes})");
    let refused = |problem: &dyn std::fmt::Display| format!("{problem}; {allowed}");
    if !bytes.starts_with(b"\x93NUMPY") {
        return Err(refused(&"is no .npy file"));
    }
    let Some(header) = plain_header(bytes) else {
        return Err(refused(
            &"has a header that is cut off, damaged or not that of one plain array",
        ));
    };
    if let Some(shape) = other_shape(header) {
        return Err(refused(&format_args!("has the shape {shape}")));
    }
    let mut rest = bytes;
    let header = npyz::NpyHeader::from_reader(&mut rest).map_err(|error| refused(&error))?;
    let rows = match *header.shape() {
        [columns] if columns == genes as u64 => 1,
        [rows, columns] if columns == genes as u64 => rows as usize,
        [length] => return Err(refused(&format_args!("has the shape ({length},)"))),
        [rows, columns] => return Err(refused(&format_args!("has the shape ({rows}, {columns})"))),
        _ => return Err(refused(&"has another shape")),
    };
    let name = header.dtype().descr();
    let size = match name.trim_matches('\'') {
        "<f4" | ">f4" => 4,
        "<f8" | ">f8" => 8,
        other => return Err(refused(&format_args!("has numbers of the type {other}"))),
    };
    if rest.len() != rows * genes * size {
        let (there, wanted) = (rest.len(), rows * genes * size);
        return Err(format!(
            "has {there} bytes of numbers, but its header means {wanted}: it is cut off or damaged"
        ));
    }
    let by_rows = header.order() == Order::C;
    let file = NpyFile::with_header(header, rest);
    let stored: Vec<f64> = if size == 4 {
        file.into_vec::<f32>()
            .map(|values| values.into_iter().map(f64::from).collect())
    } else {
        file.into_vec::<f64>()
    }
    .map_err(|error| refused(&error))?;
    let mut values = Vec::with_capacity(stored.len());
    for row in 0..rows {
        for column in 0..genes {
            let value = stored[if by_rows {
                row * genes + column
            } else {
                column * rows + row
            }];
            let gene = checked(value as f32, &value);
            values.push(gene.map_err(|problem| format!("row {}, gene {}: {problem}", row + 1, column + 1))?);
        }
    }
    Ok(values)
}

/// A `.npy` file's header if it is short and flat with small numbers, as for plain arrays. The library that parses it
/// doesn't limit nesting.
fn plain_header(bytes: &[u8]) -> Option<&str> {
    let header = match bytes {
        [0x93, b'N', b'U', b'M', b'P', b'Y', 1, 0, low, high, rest @ ..] => {
            rest.get(..usize::from(u16::from_le_bytes([*low, *high])))
        }
        [0x93, b'N', b'U', b'M', b'P', b'Y', 2 | 3, 0, a, b, c, d, rest @ ..] => {
            rest.get(..u32::from_le_bytes([*a, *b, *c, *d]) as usize)
        }
        _ => None,
    };
    let header = std::str::from_utf8(header?).ok()?;
    let brackets = header.matches(['(', '[', '{']).count();
    let mut numbers = header.split(|c: char| !c.is_ascii_digit());
    (header.len() <= 4096 && brackets <= 2 && numbers.all(|digits| digits.len() <= 9)).then_some(header)
}

/// The shape in a plain header as `NumPy` writes it, unless it has one or two lengths: the library that parses it doesn't check that
/// more of them don't overflow.
fn other_shape(header: &str) -> Option<String> {
    let (_, shape) = header.split_once('(')?;
    let lengths: Vec<&str> = shape
        .split(|c: char| !c.is_ascii_digit())
        .filter(|digits| !digits.is_empty())
        .collect();
    (![1, 2].contains(&lengths.len())).then(|| format!("({})", lengths.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use npyz::WriterBuilder;

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
        assert!(refusal(&npy(&[1.0_f32; 6], &[2, 3], Order::C)).contains("has the shape (2, 3); allowed: "));
        for (shape, shown) in [
            (&[3, 1, 2][..], "(3, 1, 2)"),
            (&[6], "(6,)"),
            (&[1; 9], "(1, 1, 1, 1, 1, 1, 1, 1, 1)"),
        ] {
            let count = shape.iter().product::<u64>() as usize;
            let refused = refusal(&npy(&vec![1.0_f32; count], shape, Order::C));
            assert!(
                refused.starts_with(&format!("has the shape {shown}; allowed: ")),
                "{refused}"
            );
        }
        assert!(refusal(b"\x93NUMPY\x01\x00\x10\x00{'shape': (), }  ").starts_with("has the shape (); "));
        assert!(refusal(b"1,2\n").starts_with("is no .npy file; allowed: "));
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
        assert_eq!(plain_header(&deep), None);
        let mut huge = b"\x93NUMPY\x02\x00\xff\xff\xff\xff".to_vec();
        huge.extend(b"{'descr': '<f4'");
        assert_eq!(plain_header(&huge), None);
    }
}
