//! Cells of CSV tables.

/// A text as a cell, quoted if needed. An apostrophe is prepended to texts that a spreadsheet would interpret as a formula.
pub(crate) fn text(text: &str) -> String {
    let line = text.replace(['\n', '\r'], " ");
    let is_formula = line.trim_start().starts_with([
        '=', '+', '-', '@', '\t', '\u{ff1d}', '\u{ff0b}', '\u{ff0d}', '\u{ff20}',
    ]);
    let safe = if is_formula { format!("'{line}") } else { line };
    if is_formula || safe.contains(['"', ',', ';', '\t']) {
        format!("\"{}\"", safe.replace('"', "\"\""))
    } else {
        safe
    }
}

#[cfg(test)]
mod tests {
    use super::text;

    #[test]
    fn csv_cells_are_quoted_and_never_formulas() {
        assert_eq!(text("SPH"), "SPH");
        assert_eq!(text("a, \"b\"\nc"), "\"a, \"\"b\"\" c\"");
        for start in ["=", "+", "-", "@", "\t=", " =", "\n=", "\r="] {
            let cell = text(&format!("{start}cmd|' /C calc'!A0"));
            assert!(cell.starts_with("\"'"), "{cell}");
        }
    }
}
