//! JSON documents, in which every number has the fewest digits that read back exactly.

use serde::Serialize;

/// Serializes an answer as JSON.
///
/// # Errors
/// [`serde_json::Error`] when a value cannot be written as JSON.
pub fn document<T: Serialize>(answer: &T) -> Result<String, serde_json::Error> {
    serde_json::to_string_pretty(answer)
}

#[cfg(test)]
mod tests {
    #[test]
    fn numbers_are_short_and_read_back_exactly() {
        let numbers = [0.1256, 1.0, -1.0 / 3.0, 6.02e23, f64::MIN_POSITIVE];
        let text = super::document(&numbers).expect("a document");
        let words = text.split(['[', ']', ',']).map(str::trim);
        let words: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
        assert_eq!(words[..2], ["0.1256", "1.0"]);
        let back: Vec<f64> = words
            .iter()
            .map(|word| word.parse().expect("a number"))
            .collect();
        assert_eq!(back, numbers);
    }
}
