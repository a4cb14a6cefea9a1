//! Problem in the fragment of an address (after `#`), which the browser does not send to the server.

use super::token::Token;
use onset_study::explore::Question;

/// Initial content of the page.
pub enum Link {
    /// Problem given by the user.
    Question(Box<Question>),
    /// Map opened by the user.
    Stored,
    /// Default problem of the page.
    Nothing,
}

impl Link {
    /// Fragment of the address, with a token that the page removes from it.
    pub fn with(&self, token: &Token) -> String {
        let mut parts = vec![format!("token={token}")];
        parts.extend(self.parts());
        format!("#{}", parts.join("&"))
    }

    fn parts(&self) -> Vec<String> {
        match self {
            Self::Nothing => Vec::new(),
            Self::Stored => vec!["map=stored".to_owned()],
            Self::Question(question) => of_question(question),
        }
    }

    /// Initial content given by an address of the page, also from another run; `None` if the text is not an address.
    ///
    /// # Errors
    /// The error in the address, with a hint.
    pub fn of_address(text: &str) -> Option<Result<Self, String>> {
        if !text.starts_with("http://") {
            return None;
        }
        let asked = text.split_once('#').map_or("", |(_, asked)| asked);
        Some(read(asked))
    }
}

fn of_question(question: &Question) -> Vec<String> {
    let set = question.set.iter();
    let mut parts: Vec<String> = set.map(|own| format!("set={}", escaped(own))).collect();
    if !question.stretch.is_empty() {
        parts.push(format!("stretch={}", escaped(&question.stretch)));
    }
    let window = &question.window;
    for (name, [low, high]) in window.axes.iter().zip(window.ranges) {
        parts.push(format!("axis={}", escaped(&format!("{name},{low},{high}"))));
    }
    parts
}

fn read(asked: &str) -> Result<Link, String> {
    let mut question = Question::default();
    let mut axes = 0;
    for part in asked.split('&').filter(|part| !part.is_empty()) {
        let (name, value) = part.split_once('=').unwrap_or((part, ""));
        let value = unescaped(value)
            .ok_or_else(|| format!("`{part}` of the address cannot be read: it is not UTF-8"))?;
        match name {
            // The token belongs to another run.
            "token" => {}
            "set" => question.set.push(value),
            "stretch" => question.stretch = value,
            "axis" if axes < 2 => {
                (question.window.axes[axes], question.window.ranges[axes]) = axis(&value)?;
                axes += 1;
            }
            "map" => {
                return Err(
                    "the address refers to a stored map, which it does not contain\n  hint: open the map with onset explore MAP.zarr"
                        .to_owned(),
                );
            }
            _ => {
                return Err(format!(
                    "`{part}` of the address is unknown\n  hint: expected an address copied with Copy link on the page, http://...#set=...&stretch=..."
                ));
            }
        }
    }
    Ok(match question == Question::default() {
        true => Link::Nothing,
        false => Link::Question(Box::new(question)),
    })
}

/// Parses a name and a range.
fn axis(text: &str) -> Result<(String, [f64; 2]), String> {
    let parts: Vec<&str> = text.split(',').collect();
    let number = |text: &str| text.parse::<f64>().ok().filter(|value| value.is_finite());
    match parts[..] {
        [name, low, high] => number(low)
            .zip(number(high))
            .filter(|(low, high)| low < high)
            .map(|(low, high)| (name.to_owned(), [low, high])),
        _ => None,
    }
    .ok_or_else(|| format!("`axis={text}` of the address is not an axis\n  hint: expected the name of the axis and its ends, for example stretch-1,0.5,2"))
}

/// Percent-encodes a text, except for letters, digits and a few punctuation characters.
fn escaped(text: &str) -> String {
    let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-._~,".contains(&byte);
    text.bytes()
        .map(|byte| match is_plain(byte) {
            true => char::from(byte).to_string(),
            false => format!("%{byte:02X}"),
        })
        .collect()
}

/// Decodes a percent-encoded text; `None` if it is not UTF-8.
fn unescaped(part: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(part.len());
    let mut rest = part.as_bytes();
    while let Some((first, others)) = rest.split_first() {
        let is_code = |code: &&[u8]| *first == b'%' && code.iter().all(u8::is_ascii_hexdigit);
        let coded = others.get(..2).filter(is_code);
        let digits = coded.and_then(|digits| std::str::from_utf8(digits).ok());
        match digits.and_then(|digits| u8::from_str_radix(digits, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                rest = &others[2..];
            }
            None => {
                bytes.push(*first);
                rest = others;
            }
        }
    }
    String::from_utf8(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::{Link, Question, of_question};

    fn question() -> Question {
        Question {
            set: vec!["material.energy=mu*(I1 - 3) + 100%".to_owned()],
            stretch: "1.1,0.9".to_owned(),
            ..Question::default()
        }
    }

    #[test]
    fn a_link_contains_the_complete_problem() {
        assert_eq!(
            of_question(&question()).join("&"),
            "set=material.energy%3Dmu%2A%28I1%20-%203%29%20%2B%20100%25&stretch=1.1,0.9&axis=stretch-1,0.5,2&axis=stretch-2,0.5,2"
        );
    }

    #[test]
    fn a_link_of_another_run_opens_the_same_problem() {
        let mut asked = question();
        asked.window.axes[1] = "discretization.support".to_owned();
        asked.window.ranges[1] = [1.2, 4.0];
        for start in ["http://127.0.0.1:6673/#", "http://localhost:1/#token=00ff&"] {
            let address = format!("{start}{}", of_question(&asked).join("&"));
            match Link::of_address(&address) {
                Some(Ok(Link::Question(found))) => assert_eq!(*found, asked),
                _ => panic!("{address}"),
            }
        }
        assert!(Link::of_address("study.toml").is_none());
        assert!(matches!(
            Link::of_address("http://127.0.0.1:6673/"),
            Some(Ok(Link::Nothing))
        ));
        for wrong in [
            "map=stored",
            "axis=stretch-1,2,1",
            "axis=stretch-1",
            "set=%ff",
            "sets=1",
        ] {
            let address = format!("http://127.0.0.1:6673/#{wrong}");
            assert!(
                matches!(Link::of_address(&address), Some(Err(_))),
                "{wrong}"
            );
        }
    }
}
