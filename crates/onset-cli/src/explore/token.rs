//! What a page must show before it is answered: every user of a machine can reach its loopback address.

use std::fmt;
use std::hint::black_box;

/// Random bytes of a token: nobody guesses 128 bits.
const BYTES: usize = 16;

/// Random bits of the operating system, in hexadecimal.
pub struct Token(String);

impl Token {
    /// A new one.
    ///
    /// # Errors
    /// What the operating system says where it has none to give.
    pub fn random() -> Result<Self, getrandom::Error> {
        let mut bytes = [0; BYTES];
        getrandom::fill(&mut bytes)?;
        Ok(Self(
            bytes.iter().map(|byte| format!("{byte:02x}")).collect(),
        ))
    }

    /// Whether it is what was shown, in a time that does not tell how much of it is right.
    pub fn is(&self, shown: &str) -> bool {
        let (own, shown) = (self.0.as_bytes(), shown.as_bytes());
        let pairs = own.iter().zip(shown);
        let differences = pairs.fold(0, |all, (a, b)| black_box(all | (a ^ b)));
        own.len() == shown.len() && differences == 0
    }
}

impl fmt::Display for Token {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::Token;

    #[test]
    fn a_token_is_itself_alone() {
        let [own, other] = [(); 2].map(|()| Token::random().expect("random bytes"));
        let text = own.to_string();
        assert_eq!(text.len(), 32);
        assert!(own.is(&text) && !own.is(&other.to_string()));
        for wrong in [
            "".to_owned(),
            text[..31].to_owned(),
            format!("{text}0"),
            format!("{}x", &text[..31]),
            format!("x{}", &text[1..]),
        ] {
            assert!(!own.is(&wrong), "{wrong}");
        }
    }
}
