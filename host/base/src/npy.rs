//! Arrays of float32 as `.npy` files, format 1.0.

/// The start of a `.npy` file (format 1.0) of little-endian f32, rows first.
pub fn header(shape: &[usize]) -> Vec<u8> {
    let mut text = "{'descr': '<f4', 'fortran_order': False, 'shape': (".to_owned();
    for (index, length) in shape.iter().enumerate() {
        text += if index > 0 { ", " } else { "" };
        text += &length.to_string();
    }
    // A single length keeps its comma.
    text += if shape.len() == 1 { ",), }" } else { "), }" };
    // In this format the numbers start at a multiple of 64 bytes, after a line end.
    let start = MAGIC.len() + 2;
    let end = (start + text.len() + 1).next_multiple_of(64);
    let mut bytes = [MAGIC, &((end - start) as u16).to_le_bytes(), text.as_bytes()].concat();
    bytes.resize(end - 1, b' ');
    bytes.push(b'\n');
    bytes
}

const MAGIC: &[u8] = b"\x93NUMPY\x01\x00";

/// A `.npy` file.
pub fn npy(shape: &[usize], values: &[f32]) -> Vec<u8> {
    let mut bytes = header(shape);
    bytes.reserve_exact(size_of_val(values));
    put(values, &mut bytes);
    bytes
}

/// Appends numbers as little-endian f32. Whole numbers at a time: extending by single bytes is several times slower.
pub fn put<'a>(values: impl IntoIterator<Item = &'a f32>, bytes: &mut Vec<u8>) {
    for value in values {
        bytes.extend_from_slice(&value.to_le_bytes());
    }
}

/// Little-endian f32 from bytes; an incomplete last one is ignored.
pub fn floats(bytes: &[u8]) -> Vec<f32> {
    bytes
        .as_chunks()
        .0
        .iter()
        .map(|bytes| f32::from_le_bytes(*bytes))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn npy_is_what_its_readers_expect() {
        let bytes = npy(&[2, 3], &[1.0, 2.0, 3.0, 4.0, 5.0, -6.5]);
        let file = npyz::NpyFile::new(&bytes[..]).unwrap();
        assert_eq!(file.shape(), [2, 3]);
        assert_eq!(file.into_vec::<f32>().unwrap(), [1.0, 2.0, 3.0, 4.0, 5.0, -6.5]);
        assert_eq!((bytes.len() - 24) % 64, 0);
        let one = npy(&[4], &[0.0; 4]);
        assert_eq!(npyz::NpyFile::new(&one[..]).unwrap().shape(), [4]);
        assert_eq!(floats(&bytes[bytes.len() - 8..]), [5.0, -6.5]);
    }
}
