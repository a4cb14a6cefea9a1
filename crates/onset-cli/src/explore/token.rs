//! Secret token of the page, required because every user of a machine can reach its loopback address.

use std::fmt;
use std::hint::black_box;

/// Number of random bytes in a token; 128 bits cannot be guessed.
const TOKEN_BYTES: usize = 16;

/// Random bits from the operating system, in hexadecimal.
pub struct Token(String);

impl Token {
    /// Creates a new token.
    ///
    /// # Errors
    /// The error of the operating system if it provides no random bits.
    pub fn random() -> Result<Self, getrandom::Error> {
        let mut bytes = [0; TOKEN_BYTES];
        getrandom::fill(&mut bytes)?;
        Ok(Self(
            bytes.iter().map(|byte| format!("{byte:02x}")).collect(),
        ))
    }

    /// Compares a text with the token, in a time that does not depend on the number of correct characters.
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
    fn a_token_is_accepted_only_if_it_is_identical() {
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
