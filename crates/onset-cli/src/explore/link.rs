//! The address of a question: behind its `#`, so that it stays in the browser.

use onset_study::explore::Question;
use std::fmt;

/// What the page shows first.
pub enum Link {
    /// A question.
    Question(Box<Question>),
    /// The map that was opened.
    Stored,
    /// What the page shows by itself.
    Nothing,
}

impl fmt::Display for Link {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nothing => Ok(()),
            Self::Stored => formatter.write_str("#map=stored"),
            Self::Question(question) => {
                let mut parts: Vec<String> = question
                    .set
                    .iter()
                    .map(|own| format!("set={}", escaped(own)))
                    .collect();
                if !question.stretch.is_empty() {
                    parts.push(format!("stretch={}", escaped(&question.stretch)));
                }
                let window = &question.window;
                for (name, [low, high]) in window.axes.iter().zip(window.ranges) {
                    parts.push(format!("axis={}", escaped(&format!("{name},{low},{high}"))));
                }
                write!(formatter, "#{}", parts.join("&"))
            }
        }
    }
}

/// A text as a part of an address: all but letters, digits and a few signs in hexadecimal.
fn escaped(text: &str) -> String {
    let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-._~,".contains(&byte);
    text.bytes()
        .map(|byte| match is_plain(byte) {
            true => char::from(byte).to_string(),
            false => format!("%{byte:02X}"),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::{Link, Question};

    #[test]
    fn a_link_has_the_whole_question() {
        let question = Question {
            set: vec!["material.energy=mu*(I1 - 3)".to_owned()],
            stretch: "1.1,0.9".to_owned(),
            ..Question::default()
        };
        assert_eq!(
            Link::Question(Box::new(question)).to_string(),
            "#set=material.energy%3Dmu%2A%28I1%20-%203%29&stretch=1.1,0.9&axis=stretch-1,0.5,2&axis=stretch-2,0.5,2"
        );
    }
}
