//! Quoting of words in commands that are printed for the user.

use std::ffi::OsStr;
use std::path::Path;

/// Quotes a word for a POSIX shell.
///
/// ```
/// use onset_study::shell::quoted;
/// assert_eq!(quoted("map.zarr".as_ref()), "map.zarr");
/// assert_eq!(quoted("it's a map".as_ref()), r"'it'\''s a map'");
/// ```
pub fn quoted(word: &OsStr) -> String {
    let is_plain = |letter: char| letter.is_ascii_alphanumeric() || "_-./:=,+%@".contains(letter);
    match word.to_str() {
        Some(text) if !text.is_empty() && text.chars().all(is_plain) => text.to_owned(),
        Some(text) if !text.chars().any(char::is_control) => {
            format!("'{}'", text.replace('\'', r"'\''"))
        }
        // Words that are not valid text, or contain control characters, are written with escape sequences.
        _ => {
            let byte = |byte: &u8| match byte {
                b'\'' | b'\\' => format!("\\{}", char::from(*byte)),
                b' '..=b'~' => char::from(*byte).to_string(),
                other => format!("\\{other:03o}"),
            };
            let bytes: String = word.as_encoded_bytes().iter().map(byte).collect();
            format!("$'{bytes}'")
        }
    }
}

/// Quotes a file name so that it cannot be mistaken for an option.
pub fn quoted_file(path: &Path) -> String {
    if path.as_os_str().as_encoded_bytes().starts_with(b"-") {
        quoted(Path::new(".").join(path).as_os_str())
    } else {
        quoted(path.as_os_str())
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::{quoted, quoted_file};
    use std::ffi::{OsStr, OsString};
    use std::os::unix::ffi::{OsStrExt, OsStringExt};
    use std::path::Path;
    use std::process::Command;

    #[test]
    fn a_shell_reads_back_every_word() {
        let mut words: Vec<OsString> = [
            "",
            "plain",
            "two words",
            "it's",
            "a\"b",
            "$HOME",
            "`id`",
            "~",
            "*",
            "a;b",
            "-n",
            "#",
            "ü",
            "new\nline",
            "\u{1b}[2J",
            "back\\slash",
            "!x",
            "{a,b}",
            "'\n'",
        ]
        .map(OsString::from)
        .to_vec();
        words.push(OsString::from_vec((1..=255).collect()));
        for word in words {
            // bash, zsh and other shells that follow POSIX 2024 read words in `$''`.
            let output = Command::new("bash")
                .args(["-c", &format!("printf %s {}", quoted(&word))])
                .env("LC_ALL", "C")
                .output();
            let output = output.expect("a shell").stdout;
            assert_eq!(OsStr::from_bytes(&output), word, "{}", quoted(&word));
        }
        assert_eq!(quoted_file(Path::new("-x.toml")), "./-x.toml");
    }
}
