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

/// Serializes an answer as JSON with full precision.
///
/// # Errors
/// [`serde_json::Error`] when a value cannot be written as JSON.
pub fn document<T: Serialize>(answer: &T) -> Result<String, serde_json::Error> {
    let mut bytes = Vec::new();
    let formatter = FullPrecision(PrettyFormatter::with_indent(b"  "));
    answer.serialize(&mut Serializer::with_formatter(&mut bytes, formatter))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// Serializes an answer as CSV, with one line for each value: its path in the document (`discretization.wave_vector.0`), and the value.
///
/// # Errors
/// [`serde_json::Error`] when the value cannot be serialized.
pub fn csv(value: &impl Serialize) -> Result<String, serde_json::Error> {
    let mut lines = String::from("name,value\n");
    walk("", &serde_json::to_value(value)?, &mut lines);
    Ok(lines)
}

fn walk(name: &str, value: &serde_json::Value, lines: &mut String) {
    let below = |own: &str| match name {
        "" => own.to_owned(),
        _ => format!("{name}.{own}"),
    };
    let cell = match value {
        serde_json::Value::Object(fields) => {
            for (own, value) in fields {
                walk(&below(own), value, lines);
            }
            return;
        }
        serde_json::Value::Array(items) => {
            for (n, value) in items.iter().enumerate() {
                walk(&below(&n.to_string()), value, lines);
            }
            return;
        }
        serde_json::Value::Number(number) if number.is_f64() => {
            format!("{:.16e}", number.as_f64().unwrap_or(f64::NAN))
        }
        serde_json::Value::String(text) => crate::csv::text(text),
        serde_json::Value::Null => String::new(),
        other => other.to_string(),
    };
    lines.push_str(&format!("{},{cell}\n", crate::csv::text(name)));
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

    #[test]
    fn the_csv_of_an_answer_has_one_line_for_each_value() {
        let document = serde_json::json!({"a": {"b": [1.5, 2], "c": "x, y"}, "d": null, "e": true});
        let csv = super::csv(&document).expect("a document");
        assert_eq!(
            csv,
            "name,value\na.b.0,1.5000000000000000e0\na.b.1,2\na.c,\"x, y\"\nd,\ne,true\n"
        );
    }
}
