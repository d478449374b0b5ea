//! The key of an experiment, which its robots and its operator share, and the file that it is in.

use std::fmt;
use std::path::Path;

use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;
use rand::TryRng;
use rand::rngs::SysRng;

/// A key of 256 bits. It is never shown.
#[derive(Clone, PartialEq, Eq)]
pub struct Key([u8; blake3::KEY_LEN]);

/// The content of a key's file.
const ALLOWED: &str = "allowed: one line of 64 hexadecimal digits, as `oneiro fleet key FILE` makes it";

impl Key {
    /// Reads the file of a key.
    ///
    /// # Errors
    /// Exit 3: it can't be read, its owner is not the only one who can, or it is no key. Nothing of its content is shown.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = files::bytes(path)?;
        is_private(path)?;
        Self::parse(&bytes).map_err(|problem| Failure::input(format_args!("{}: {problem}; {ALLOWED}", path.display())))
    }

    /// Draws a key, and writes it to a new file that only its owner can read.
    ///
    /// # Errors
    /// Exit 3 if the file exists or its directory doesn't; exit 6 if it can't be written; exit 1 if the system has no random numbers.
    pub fn create(path: &Path) -> Result<Self> {
        let key = random()?;
        let line = format!("{}\n", blake3::Hash::from_bytes(key).to_hex());
        files::write_secret(path, line.as_bytes())?;
        Ok(Self(key))
    }

    fn parse(bytes: &[u8]) -> std::result::Result<Self, String> {
        let text = bytes.strip_suffix(b"\n").unwrap_or(bytes);
        let mut lines = text.split(|byte| *byte == b'\n');
        let line = lines.next().unwrap_or_default().trim_ascii_end();
        if let Some(column) = line.iter().position(|byte| !byte.is_ascii_hexdigit()) {
            return Err(format!("line 1, column {}: is no hexadecimal digit", column + 1));
        }
        if lines.next().is_some() {
            return Err("line 2: is one line too many".to_owned());
        }
        match blake3::Hash::from_hex(line) {
            Ok(key) => Ok(Self(*key.as_bytes())),
            Err(_) => Err(format!("line 1: has {} digits", line.len())),
        }
    }

    /// The key of datagrams' tags.
    pub(super) fn of_tags(&self) -> [u8; blake3::KEY_LEN] {
        blake3::derive_key("Oneiro 2026 tags of datagrams between robots", &self.0)
    }

    /// A key for tests.
    #[cfg(test)]
    pub fn of(byte: u8) -> Self {
        Self([byte; blake3::KEY_LEN])
    }
}

/// Random bytes that nobody can guess.
///
/// # Errors
/// Exit 1 if the system has no random numbers.
pub fn random<const N: usize>() -> Result<[u8; N]> {
    let mut bytes = [0; N];
    SysRng
        .try_fill_bytes(&mut bytes)
        .map_err(|error| Failure::failed(format_args!("the system's random numbers: {error}")))?;
    Ok(bytes)
}

impl fmt::Debug for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Key(..)")
    }
}

/// Refuses a file that others than its owner can read or write.
fn is_private(path: &Path) -> Result {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let metadata = path.metadata().map_err(|error| Failure::unreadable(path, &error))?;
        let mode = metadata.permissions().mode() & 0o7777;
        if mode & 0o077 != 0 {
            let name = path.display().to_string();
            return Err(Failure::input(format_args!(
                "{name}: others than its owner can use this key (mode {mode:o}); allowed: mode 600, set by chmod 600 {}",
                files::for_shell(&name)
            )));
        }
    }
    let _ = path;
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    const DIGITS: &str = "00112233445566778899aabbccddeeff00112233445566778899AABBCCDDEEFF";

    fn parsed(text: &str) -> std::result::Result<Key, String> {
        Key::parse(text.as_bytes())
    }

    #[test]
    fn a_key_is_one_line_of_64_digits() {
        let key = parsed(DIGITS).unwrap();
        assert_eq!((key.0[1], key.0[31]), (0x11, 0xff));
        for same in [format!("{DIGITS}\n"), format!("{DIGITS}\r\n"), DIGITS.to_lowercase()] {
            assert_eq!(parsed(&same), Ok(key.clone()), "{same:?}");
        }
        for (text, problem) in [
            (String::new(), "line 1: has 0 digits"),
            (DIGITS[1..].to_owned(), "line 1: has 63 digits"),
            (format!("{DIGITS}0"), "line 1: has 65 digits"),
            (format!(" {DIGITS}"), "line 1, column 1: is no hexadecimal digit"),
            (DIGITS.replace("33", "3g"), "line 1, column 8: is no hexadecimal digit"),
            (
                DIGITS.replace("33", "\u{e9}"),
                "line 1, column 7: is no hexadecimal digit",
            ),
            (format!("{DIGITS}\n{DIGITS}\n"), "line 2: is one line too many"),
            (format!("{DIGITS}\n\n"), "line 2: is one line too many"),
        ] {
            assert_eq!(parsed(&text).unwrap_err(), problem, "{text:?}");
        }
    }

    /// Made, read, and refused where others can read it; and never shown.
    #[test]
    fn only_its_owner_can_read_a_key() {
        let directory = std::env::temp_dir().join(format!("oneiro-key-{}", std::process::id()));
        fs::create_dir_all(&directory).unwrap();
        let [path, other] = ["it's a.key", "other.key"].map(|name| directory.join(name));
        for path in [&path, &other] {
            // Left by an earlier test of the same number.
            let _ = fs::remove_file(path);
        }
        let key = Key::create(&path).unwrap();
        assert_eq!(Key::read(&path).unwrap(), key);
        assert_ne!(Key::create(&other).unwrap(), key);
        let digits = fs::read_to_string(&path).unwrap();
        assert_eq!((digits.len(), format!("{key:?}")), (65, "Key(..)".to_owned()));
        assert!(Key::create(&path).unwrap_err().to_string().contains("exists already"));
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o600);
            for mode in [0o640, 0o604, 0o620, 0o601] {
                fs::set_permissions(&path, fs::Permissions::from_mode(mode)).unwrap();
                let refusal = Key::read(&path).unwrap_err();
                assert_eq!(refusal.code(), 3);
                let words = refusal.to_string();
                let advice = format!("chmod 600 '{}'", path.display().to_string().replace('\'', r"'\''"));
                assert!(
                    words.starts_with(&path.display().to_string()) && words.ends_with(&advice),
                    "{words}"
                );
            }
        }
        fs::write(&other, &digits[1..]).unwrap();
        let words = Key::read(&other).unwrap_err().to_string();
        assert!(
            words.contains("other.key: line 1: has 63 digits; allowed: ") && !words.contains(&digits[8..16]),
            "{words}"
        );
        assert_eq!(Key::read(&directory.join("none")).unwrap_err().code(), 3);
        fs::remove_dir_all(&directory).unwrap();
    }
}
