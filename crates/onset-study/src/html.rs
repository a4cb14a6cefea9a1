//! Pages that need nothing else.

/// A picture as part of a page: without the declaration of a document of its own.
pub(crate) fn embedded(svg: &str) -> String {
    svg.find("<svg")
        .map_or(svg, |start| &svg[start..])
        .to_owned()
}

/// A text with the characters that pages take for their own replaced.
pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}
