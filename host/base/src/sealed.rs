//! Saved states as bytes that can only be opened as what they are: a name, a version, a hash of their owner, the state,
//! and a BLAKE3 hash of it all.

use std::fmt;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

#[derive(Serialize, Deserialize)]
struct Header<'a> {
    name: &'a str,
    version: u32,
    owner: [u8; blake3::OUT_LEN],
}

/// Reason why bytes can't be opened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Problem {
    /// They aren't what was sealed.
    Damaged,
    /// They are intact, but were sealed by something else, or by another version, as described.
    Other(String),
    /// They belong to something else.
    Owner,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Damaged => f.write_str("is cut off or damaged"),
            Self::Other(words) => f.write_str(words),
            Self::Owner => f.write_str("belongs to other settings"),
        }
    }
}

/// Seals a state under a name and version. `owner` is a hash of what it belongs to: its settings, its experiment.
pub fn seal(name: &str, version: u32, owner: &blake3::Hash, state: &impl Serialize) -> Vec<u8> {
    let header = Header {
        name,
        version,
        owner: *owner.as_bytes(),
    };
    let mut bytes = postcard::to_allocvec(&(header, state)).expect("states are numbers, words and lists");
    let hash = blake3::hash(&bytes);
    bytes.extend_from_slice(hash.as_bytes());
    bytes
}

/// Opens a sealed state, or returns the problem with the bytes.
pub fn open<T: DeserializeOwned>(name: &str, version: u32, owner: &blake3::Hash, bytes: &[u8]) -> Result<T, Problem> {
    let (content, hash) = bytes
        .split_last_chunk::<{ blake3::OUT_LEN }>()
        .ok_or(Problem::Damaged)?;
    if blake3::hash(content) != blake3::Hash::from_bytes(*hash) {
        return Err(Problem::Damaged);
    }
    let other = |words: &dyn fmt::Display| Problem::Other(words.to_string());
    let Ok((header, state)) = postcard::take_from_bytes::<Header<'_>>(content) else {
        return Err(other(&"has another format"));
    };
    if header.name != name {
        return Err(other(&format_args!("is of \"{}\"; allowed: \"{name}\"", header.name)));
    }
    if header.version != version {
        return Err(other(&format_args!(
            "is of version {}; allowed: {version}",
            header.version
        )));
    }
    if header.owner != *owner.as_bytes() {
        return Err(Problem::Owner);
    }
    match postcard::take_from_bytes(state) {
        Ok((state, [])) => Ok(state),
        _ => Err(other(&"has unexpected contents")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every bit flipped, every length cut, and bytes added: none opens.
    #[test]
    fn damaged_bytes_never_open() {
        let owner = blake3::hash(b"an experiment");
        let open = |bytes: &[u8]| open::<(u32, Vec<f32>)>("thing", 1, &owner, bytes);
        let good = seal("thing", 1, &owner, &(7_u32, vec![1.5_f32, -0.0]));
        assert_eq!(open(&good), Ok((7, vec![1.5, -0.0])));
        for length in 0..good.len() {
            open(&good[..length]).unwrap_err();
        }
        for place in 0..8 * good.len() {
            let mut bad = good.clone();
            bad[place / 8] ^= 1 << (place % 8);
            open(&bad).unwrap_err();
        }
        open(&[&good[..], &[0]].concat()).unwrap_err();
    }

    #[test]
    fn another_s_bytes_are_refused_by_what_differs() {
        let owner = blake3::hash(b"an experiment");
        let good = seal("thing", 1, &owner, &7_u32);
        let problem = |name, version, owner: &[u8]| {
            open::<u32>(name, version, &blake3::hash(owner), &good)
                .unwrap_err()
                .to_string()
        };
        assert_eq!(
            problem("other", 1, b"an experiment"),
            "is of \"thing\"; allowed: \"other\""
        );
        assert_eq!(problem("thing", 2, b"an experiment"), "is of version 1; allowed: 2");
        assert_eq!(problem("thing", 1, b"another"), "belongs to other settings");
        // A state of another shape, sealed alike.
        open::<(u32, u32)>("thing", 1, &owner, &good).unwrap_err();
        open::<()>("thing", 1, &owner, &good).unwrap_err();
    }
}
