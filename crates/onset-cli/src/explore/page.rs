//! Files of the page, built by `cargo xtask page` from `crates/onset-cli/page`.

/// Static file that the server of `onset explore` delivers.
pub struct File {
    /// Path on the server.
    pub path: &'static str,
    /// Media type of the file.
    pub kind: &'static str,
    /// Content of the file.
    pub bytes: &'static [u8],
}

macro_rules! file {
    ($path:literal, $name:literal, $kind:literal) => {
        File {
            path: $path,
            kind: $kind,
            bytes: include_bytes!(concat!("../../page/dist/", $name)),
        }
    };
}

/// All files of the page.
pub const FILES: &[File] = &[
    file!("/", "index.html", "text/html; charset=utf-8"),
    file!("/page.js", "page.js", "text/javascript; charset=utf-8"),
    file!("/page.css", "page.css", "text/css; charset=utf-8"),
    file!("/space.js", "space.js", "text/javascript; charset=utf-8"),
    file!("/licenses.txt", "licenses.txt", "text/plain; charset=utf-8"),
    file!("/icon.svg", "icon.svg", "image/svg+xml"),
];
