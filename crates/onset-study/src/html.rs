//! Self-contained HTML pages.

/// An SVG picture for embedding in a page, without its XML declaration.
pub(crate) fn embedded(svg: &str) -> String {
    svg.find("<svg")
        .map_or(svg, |start| &svg[start..])
        .to_owned()
}

/// A text with the special characters of HTML replaced.
pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}
