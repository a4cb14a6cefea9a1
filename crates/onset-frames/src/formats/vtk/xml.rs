//! Tags of an XML file. Text between tags is a range of bytes: data of VTK files can be binary.

use std::ops::Range;

/// Tag with its attributes.
#[derive(Clone, Debug)]
pub(super) struct Tag {
    pub name: String,
    pub attributes: Vec<(String, String)>,
    /// Whether the tag ends an element, as `</NAME>` does.
    pub is_end: bool,
    /// Whether the element has no contents, as in `<NAME/>`.
    pub is_empty: bool,
    pub place: Range<usize>,
}

impl Tag {
    pub(super) fn get(&self, name: &str) -> Option<&str> {
        let found = self.attributes.iter().find(|(own, _)| own == name);
        found.map(|(_, value)| value.as_str())
    }

    pub(super) fn number<T: std::str::FromStr>(&self, name: &str) -> Option<T> {
        self.get(name)?.trim().parse().ok()
    }
}

/// Maximum length of a tag, in bytes.
const MAX_TAG: usize = 1 << 16;

fn find(bytes: &[u8], from: usize, what: &[u8]) -> Option<usize> {
    let rest = bytes.get(from..)?;
    let found = rest.windows(what.len()).position(|part| part == what);
    found.map(|place| from + place)
}

/// Next tag after a position; `Ok(None)` at the end, `Err` with the position of an invalid tag.
pub(super) fn next(bytes: &[u8], mut from: usize) -> Result<Option<Tag>, usize> {
    loop {
        let rest = bytes.get(from..).unwrap_or_default();
        let Some(start) = rest.iter().position(|byte| *byte == b'<') else {
            return Ok(None);
        };
        let start = from + start;
        let rest = &bytes[start..];
        let end = match rest {
            [b'<', b'!', b'-', b'-', ..] => find(bytes, start, b"-->").map(|end| end + 3),
            [b'<', b'?', ..] => find(bytes, start, b"?>").map(|end| end + 2),
            [b'<', b'!', ..] => find(bytes, start, b">").map(|end| end + 1),
            _ => return tag(bytes, start).map(Some).ok_or(start),
        };
        from = end.ok_or(start)?;
    }
}

fn tag(bytes: &[u8], start: usize) -> Option<Tag> {
    let most = bytes.len().min(start + MAX_TAG);
    let is_end = bytes.get(start + 1) == Some(&b'/');
    let mut at = start + 1 + usize::from(is_end);
    let word = |at: &mut usize| {
        let from = *at;
        while *at < most
            && !matches!(
                bytes[*at],
                b' ' | b'\t' | b'\r' | b'\n' | b'/' | b'>' | b'='
            )
        {
            *at += 1;
        }
        String::from_utf8_lossy(&bytes[from..*at]).into_owned()
    };
    let blanks = |at: &mut usize| {
        while *at < most && bytes[*at].is_ascii_whitespace() {
            *at += 1;
        }
    };
    let name = word(&mut at);
    let mut attributes = Vec::new();
    loop {
        blanks(&mut at);
        match bytes.get(at).filter(|_| at < most)? {
            b'>' => {
                return (!name.is_empty()).then_some(Tag {
                    name,
                    attributes,
                    is_end,
                    is_empty: false,
                    place: start..at + 1,
                });
            }
            b'/' if bytes.get(at + 1) == Some(&b'>') => {
                return (!name.is_empty()).then_some(Tag {
                    name,
                    attributes,
                    is_end,
                    is_empty: true,
                    place: start..at + 2,
                });
            }
            _ => {
                let key = word(&mut at);
                blanks(&mut at);
                if key.is_empty() || bytes.get(at) != Some(&b'=') {
                    return None;
                }
                at += 1;
                blanks(&mut at);
                let quote = *bytes.get(at).filter(|byte| matches!(byte, b'"' | b'\''))?;
                let from = at + 1;
                let length = bytes
                    .get(from..most)?
                    .iter()
                    .position(|byte| *byte == quote)?;
                at = from + length + 1;
                let value = String::from_utf8_lossy(&bytes[from..from + length]);
                attributes.push((key, unescaped(&value)));
            }
        }
    }
}

fn unescaped(text: &str) -> String {
    if !text.contains('&') {
        return text.to_owned();
    }
    text.replace("&lt;", "<")
        .replace("&gt;", ">")
        .replace("&quot;", "\"")
        .replace("&apos;", "'")
        .replace("&amp;", "&")
}
