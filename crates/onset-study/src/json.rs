//! JSON documents with 17 significant digits, so that every number can be read back exactly.

use serde::Serialize;
use serde_json::Serializer;
use serde_json::ser::{Formatter, PrettyFormatter};
use std::io;

/// Pretty-printing with every floating-point number as `d.dddddddddddddddde±x`.
struct FullPrecision<'a>(PrettyFormatter<'a>);

impl Formatter for FullPrecision<'_> {
    fn write_f64<W: ?Sized + io::Write>(&mut self, writer: &mut W, value: f64) -> io::Result<()> {
        write!(writer, "{value:.16e}")
    }
    fn begin_array<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.0.begin_array(writer)
    }
    fn end_array<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.0.end_array(writer)
    }
    fn begin_array_value<W: ?Sized + io::Write>(
        &mut self,
        writer: &mut W,
        first: bool,
    ) -> io::Result<()> {
        self.0.begin_array_value(writer, first)
    }
    fn end_array_value<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.0.end_array_value(writer)
    }
    fn begin_object<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.0.begin_object(writer)
    }
    fn end_object<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.0.end_object(writer)
    }
    fn begin_object_key<W: ?Sized + io::Write>(
        &mut self,
        writer: &mut W,
        first: bool,
    ) -> io::Result<()> {
        self.0.begin_object_key(writer, first)
    }
    fn begin_object_value<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.0.begin_object_value(writer)
    }
    fn end_object_value<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.0.end_object_value(writer)
    }
}

/// The document of an answer.
///
/// # Errors
/// [`serde_json::Error`] when a value cannot be written as JSON.
pub fn document<T: Serialize>(answer: &T) -> Result<String, serde_json::Error> {
    let mut bytes = Vec::new();
    let formatter = FullPrecision(PrettyFormatter::with_indent(b"  "));
    answer.serialize(&mut Serializer::with_formatter(&mut bytes, formatter))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

#[cfg(test)]
mod tests {
    #[test]
    fn numbers_have_17_significant_digits_and_read_back_exactly() {
        let numbers = [0.1, -1.0 / 3.0, 0.0, 6.02e23, f64::MIN_POSITIVE];
        let text = super::document(&numbers).expect("a document");
        assert!(text.contains("1.0000000000000001e-1"), "{text}");
        let back: Vec<f64> = serde_json::from_str(&text).expect("JSON");
        assert_eq!(back, numbers);
    }
}
