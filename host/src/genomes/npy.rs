//! Genomes from `.npy` files.

use npyz::{NpyFile, Order};

use super::checked;

/// Numbers of a `.npy` file, row by row.
pub(super) fn parse(bytes: &[u8], genes: usize) -> Result<Vec<f32>, String> {
    let allowed = format!("allowed: an array of float32 or float64 with the shape (rows, {genes})");
    if !has_plain_header(bytes) {
        return Err(format!("is no .npy file, or not of one plain array; {allowed}"));
    }
    let refused = |problem: &dyn std::fmt::Display| format!("{problem}; {allowed}");
    let mut rest = bytes;
    let header = npyz::NpyHeader::from_reader(&mut rest).map_err(|error| refused(&error))?;
    let rows = match *header.shape() {
        [columns] if columns == genes as u64 => 1,
        [rows, columns] if columns == genes as u64 => rows as usize,
        ref shape => return Err(refused(&format_args!("has the shape {shape:?}"))),
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

/// Whether a `.npy` header is short and flat with small numbers, as for plain arrays. The library that parses it
/// doesn't limit nesting, nor check that sizes don't overflow.
fn has_plain_header(bytes: &[u8]) -> bool {
    let header = match bytes {
        [0x93, b'N', b'U', b'M', b'P', b'Y', 1, 0, low, high, rest @ ..] => {
            rest.get(..usize::from(u16::from_le_bytes([*low, *high])))
        }
        [0x93, b'N', b'U', b'M', b'P', b'Y', 2 | 3, 0, a, b, c, d, rest @ ..] => {
            rest.get(..u32::from_le_bytes([*a, *b, *c, *d]) as usize)
        }
        _ => None,
    };
    header.is_some_and(|header| {
        let brackets = header.iter().filter(|byte| b"([{".contains(byte)).count();
        let mut numbers = header
            .split(|byte| !byte.is_ascii_digit())
            .filter(|digits| !digits.is_empty());
        // The type's size and at most two lengths.
        header.len() <= 4096 && brackets <= 2 && numbers.clone().count() <= 3 && numbers.all(|digits| digits.len() <= 9)
    })
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
        assert!(!has_plain_header(&deep));
        let mut huge = b"\x93NUMPY\x02\x00\xff\xff\xff\xff".to_vec();
        huge.extend(b"{'descr': '<f4'");
        assert!(!has_plain_header(&huge));
    }
}
