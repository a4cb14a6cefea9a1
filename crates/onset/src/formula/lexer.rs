//! Splits a formula into numbers, names and symbols.

use super::Place;
use super::error::{FormulaError, Problem};
use std::ops::Range;

/// Token of a formula.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Token<'a> {
    Number(f64),
    Name(&'a str),
    /// Operator, parenthesis, comma, semicolon or equals sign.
    Sign(&'static str),
    End,
}

impl Token<'_> {
    /// Returns the token as part of a sentence.
    pub(super) fn found(self, text: &str) -> String {
        match self {
            Self::End => "the end of the formula".to_owned(),
            _ => format!("`{text}`"),
        }
    }
}

/// Symbols, sorted so that a longer symbol precedes its prefixes.
const SIGNS: [&str; 18] = [
    "**", "<=", ">=", "==", "!=", "&&", "||", "+", "-", "*", "/", "^", "(", ")", ",", ";", "<", ">",
];

/// Tokens of a text, each with its range of bytes. The last token is [`Token::End`].
pub(super) fn tokens(text: &str) -> Result<Vec<(Token<'_>, Range<usize>)>, FormulaError> {
    let mut tokens = Vec::new();
    let mut at = 0;
    while let Some(first) = text[at..].chars().next() {
        let rest = &text[at..];
        let (token, length) = if first.is_whitespace() {
            at += first.len_utf8();
            continue;
        } else if is_start_of_number(rest) {
            number(rest).map_err(|(problem, length)| error(text, at..at + length, problem))?
        } else if first.is_ascii_alphabetic() {
            let length = rest.find(|c| !is_part_of_name(c)).unwrap_or(rest.len());
            (Token::Name(&rest[..length]), length)
        } else if let Some(sign) = SIGNS
            .iter()
            .chain(&["="])
            .find(|sign| rest.starts_with(**sign))
        {
            (Token::Sign(sign), sign.len())
        } else {
            let problem = Problem::Character { character: first };
            return Err(error(text, at..at + first.len_utf8(), problem));
        };
        tokens.push((token, at..at + length));
        at += length;
    }
    tokens.push((Token::End, text.len()..text.len()));
    Ok(tokens)
}

fn error(text: &str, range: Range<usize>, problem: Problem) -> FormulaError {
    FormulaError {
        problem,
        place: Some(Place::of(text, range)),
    }
}

fn is_part_of_name(character: char) -> bool {
    character.is_ascii_alphanumeric() || character == '_'
}

fn is_start_of_number(rest: &str) -> bool {
    let mut bytes = rest.bytes();
    match bytes.next() {
        Some(first) if first.is_ascii_digit() => true,
        Some(b'.') => bytes.next().is_some_and(|second| second.is_ascii_digit()),
        _ => false,
    }
}

/// Number at the beginning of a text, with its length: digits, a point, an exponent.
fn number(rest: &str) -> Result<(Token<'static>, usize), (Problem, usize)> {
    let bytes = rest.as_bytes();
    let digits = |from: usize| {
        let count = bytes[from..]
            .iter()
            .take_while(|byte| byte.is_ascii_digit());
        from + count.count()
    };
    let mut length = digits(0);
    if bytes.get(length) == Some(&b'.') {
        length = digits(length + 1);
    }
    if matches!(bytes.get(length), Some(b'e' | b'E')) {
        let is_signed = matches!(bytes.get(length + 1), Some(b'+' | b'-'));
        let start = length + 1 + usize::from(is_signed);
        if digits(start.min(bytes.len())) > start {
            length = digits(start);
        }
    }
    // Characters that follow without a space belong to the number for the reader: 2mu, 1.2.3.
    let tail = rest[length..].find(|c| !is_part_of_name(c) && c != '.');
    let whole = tail.map_or(rest.len(), |tail| length + tail);
    match rest[..length].parse::<f64>() {
        Ok(value) if whole == length && value.is_finite() => Ok((Token::Number(value), length)),
        _ => {
            let text = rest[..whole].to_owned();
            Err((Problem::Number { text }, whole))
        }
    }
}
