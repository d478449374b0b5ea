//! Compiled code, and its form as bytes in the cache.

use crate::cache::Key;

/// Machine code of one kernel: a position-independent function that starts at the first byte and refers to nothing outside.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Code {
    /// Number of invocations that a call runs.
    pub(crate) lanes: u32,
    /// Machine that it was compiled for, see [`crate::Target::description`].
    pub(crate) target: String,
    /// Most words of a buffer.
    pub(crate) reach: u32,
    /// Words per element of each buffer.
    pub(crate) strides: Vec<u32>,
    /// Instructions and constants.
    pub(crate) bytes: Vec<u8>,
}

/// First bytes of cached code: a name, and the version of the format.
const MAGIC: &[u8; 8] = b"oneiro\0\x02";

impl Code {
    /// Number of bytes of instructions and constants.
    pub fn size(&self) -> usize {
        self.bytes.len()
    }

    /// Converts the code to bytes, for [`Self::from_bytes`] with the same key.
    pub(crate) fn to_bytes(&self, key: &Key) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        let number = |bytes: &mut Vec<u8>, number: usize| bytes.extend((number as u32).to_le_bytes());
        number(&mut bytes, self.lanes as usize);
        number(&mut bytes, self.reach as usize);
        number(&mut bytes, self.strides.len());
        for stride in &self.strides {
            number(&mut bytes, *stride as usize);
        }
        for part in [self.target.as_bytes(), &self.bytes] {
            number(&mut bytes, part.len());
            bytes.extend(part);
        }
        let checksum = blake3::keyed_hash(key.as_bytes(), &bytes);
        bytes.extend(checksum.as_bytes());
        bytes
    }

    /// Reads code from bytes. Returns `None` unless they are exactly what [`Self::to_bytes`] made with this key.
    pub(crate) fn from_bytes(bytes: &[u8], key: &Key) -> Option<Self> {
        let (bytes, checksum) = bytes.split_last_chunk::<{ blake3::OUT_LEN }>()?;
        if blake3::keyed_hash(key.as_bytes(), bytes) != *checksum {
            return None;
        }
        let mut reader = Reader(bytes.strip_prefix(MAGIC)?);
        let lanes = reader.number()?;
        let reach = reader.number()?;
        let buffers = reader.number()?;
        let strides = (0..buffers).map(|_| reader.number()).collect::<Option<_>>()?;
        let target = String::from_utf8(reader.part()?.to_vec()).ok()?;
        let bytes = reader.part()?.to_vec();
        let code = Self {
            lanes,
            target,
            reach,
            strides,
            bytes,
        };
        reader.0.is_empty().then_some(code)
    }
}

struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    fn number(&mut self) -> Option<u32> {
        let (number, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(u32::from_le_bytes(*number))
    }

    fn part(&mut self) -> Option<&'a [u8]> {
        let length = self.number()? as usize;
        let (part, rest) = self.0.split_at_checked(length)?;
        self.0 = rest;
        Some(part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Target;

    /// Bytes with any change, cut off anywhere, or with another key are no code.
    #[test]
    fn damaged_bytes_are_noticed() {
        let target = Target::host().expect("this machine has machine code");
        let code = Code {
            lanes: 8,
            reach: u32::MAX,
            target: target.description(),
            strides: vec![1, 4],
            bytes: (0..200).collect(),
        };
        let key = Key::new("text", 8, &target);
        let whole = code.to_bytes(&key);
        assert_eq!(Code::from_bytes(&whole, &key), Some(code));
        for at in 0..whole.len() {
            let mut changed = whole.clone();
            changed[at] ^= 1;
            assert_eq!(Code::from_bytes(&changed, &key), None, "byte {at} is changed");
            assert_eq!(Code::from_bytes(&whole[..at], &key), None, "it is cut off at {at}");
        }
        assert_eq!(Code::from_bytes(&whole, &Key::new("other text", 8, &target)), None);
    }
}
