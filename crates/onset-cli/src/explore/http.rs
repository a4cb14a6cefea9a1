//! Minimal HTTP/1.1 for a page on this machine: requests with a body of known length, complete replies, and persistent connections.
//!
//! The crate `httparse` parses request heads.

use onset_study::unless;
use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

/// Limits on the bytes of a request head, the number of headers, and the bytes of a body.
const MAX_HEAD_BYTES: usize = 16 << 10;
const MAX_HEADERS: usize = 64;
const MAX_BODY_BYTES: usize = 1 << 20;
/// Longest idle time of a connection between two requests.
const MAX_IDLE_TIME: Duration = Duration::from_secs(60);
/// Longest transfer times of a request head, a body, and a reply.
const HEAD_TIME: Duration = Duration::from_secs(3);
const BODY_TIME: Duration = Duration::from_secs(5);
const ANSWER_TIME: Duration = Duration::from_secs(20);
/// Longest wait for remaining input when a connection ends.
const MAX_LINGER_TIME: Duration = Duration::from_millis(500);
/// Interval between checks of a connection while its reply is computed.
const CHECK_INTERVAL: Duration = Duration::from_millis(20);

/// Request of the page.
pub struct Request {
    /// Method, such as `GET` or `POST`.
    pub method: String,
    /// Path without the query after `?`.
    pub path: String,
    headers: Vec<(String, String)>,
    /// Body of the request.
    pub body: Vec<u8>,
    /// Whether the connection closes after this request.
    pub is_last: bool,
}

impl Request {
    /// Value of a header, by its name in lower case; `None` if it is missing or repeated.
    pub fn header(&self, name: &str) -> Option<&str> {
        let mut found = self.headers.iter().filter(|(own, _)| own == name);
        let first = found.next()?;
        found.next().is_none().then_some(first.1.as_str())
    }

    /// Returns true if a header occurs at least once.
    pub fn has(&self, name: &str) -> bool {
        self.headers.iter().any(|(own, _)| own == name)
    }
}

/// Reply to a request.
pub struct Reply {
    /// Status code with its reason phrase.
    pub status: &'static str,
    /// Media type of the body.
    pub kind: &'static str,
    pub body: Vec<u8>,
}

impl Reply {
    /// Creates a refusal with plain text.
    pub fn refused(status: &'static str, why: &str) -> Self {
        Self {
            status,
            kind: "text/plain; charset=utf-8",
            body: why.as_bytes().to_vec(),
        }
    }
}

/// Headers of every reply.
///
/// They restrict the page to scripts and connections of this server. Inline styles are allowed, because the plotting library inserts them into
/// figures.
const HEADERS_OF_ALL_REPLIES: &str = "Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; \
     connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\n\
     X-Content-Type-Options: nosniff\r\n\
     Referrer-Policy: no-referrer\r\n\
     Cross-Origin-Resource-Policy: same-origin\r\n\
     Cross-Origin-Opener-Policy: same-origin\r\n\
     Cache-Control: no-store\r\n";

/// Connection to a browser.
pub struct Connection {
    stream: TcpStream,
    /// Bytes received but not processed yet.
    rest: Vec<u8>,
    /// Longest wait for the next request: short until the first request, so that silent connections end like half-sent heads.
    idle: Duration,
}

/// Reason why no request was read.
pub enum Instead {
    /// The connection has ended.
    End,
    /// The input is refused.
    Refused(Reply),
}

impl From<io::Error> for Instead {
    fn from(_: io::Error) -> Self {
        Self::End
    }
}

fn refused(status: &'static str, why: &str) -> Instead {
    Instead::Refused(Reply::refused(status, why))
}

impl Connection {
    /// Wraps an accepted connection.
    ///
    /// # Errors
    /// The error of the operating system.
    pub fn new(stream: TcpStream) -> io::Result<Self> {
        // A reply is sent in one piece and must not be delayed.
        stream.set_nodelay(true)?;
        Ok(Self {
            stream,
            rest: Vec::new(),
            idle: HEAD_TIME,
        })
    }

    /// Reads the next request.
    pub fn request(&mut self) -> Result<Request, Instead> {
        if self.rest.is_empty() {
            self.more(Instant::now() + self.idle)?;
        }
        self.idle = MAX_IDLE_TIME;
        let end = Instant::now() + HEAD_TIME;
        let (mut request, start, length) = loop {
            if let Some(found) = head(&self.rest)? {
                break found;
            }
            if self.rest.len() > MAX_HEAD_BYTES {
                return Err(refused(
                    "431 Request Header Fields Too Large",
                    "the head of the request is too long",
                ));
            }
            self.more(end)?;
        };
        let end = Instant::now() + BODY_TIME;
        while self.rest.len() < start + length {
            self.more(end)?;
        }
        request.body = self.rest[start..start + length].to_vec();
        self.rest.drain(..start + length);
        Ok(request)
    }

    /// Reads further bytes until the deadline.
    fn more(&mut self, end: Instant) -> Result<(), Instead> {
        let mut bytes = [0; 16 << 10];
        self.stream.set_read_timeout(Some(left(end)?))?;
        match self.stream.read(&mut bytes)? {
            0 => Err(Instead::End),
            count => {
                self.rest.extend_from_slice(&bytes[..count]);
                Ok(())
            }
        }
    }

    /// Sends a reply in one piece.
    ///
    /// # Errors
    /// The error of the operating system.
    pub fn send(&mut self, reply: &Reply, has_body: bool) -> io::Result<()> {
        let mut bytes = format!(
            "HTTP/1.1 {}\r\nContent-Type: {}\r\nContent-Length: {}\r\n{HEADERS_OF_ALL_REPLIES}\r\n",
            reply.status,
            reply.kind,
            reply.body.len()
        )
        .into_bytes();
        if has_body {
            bytes.extend_from_slice(&reply.body);
        }
        let end = Instant::now() + ANSWER_TIME;
        let mut rest = &bytes[..];
        while !rest.is_empty() {
            self.stream.set_write_timeout(Some(left(end)?))?;
            match self.stream.write(rest)? {
                0 => return Err(io::ErrorKind::WriteZero.into()),
                count => rest = &rest[count..],
            }
        }
        Ok(())
    }

    /// Closes the connection after reading remaining input; otherwise the reply could be lost.
    pub fn end(mut self) {
        let mut bytes = [0; 16 << 10];
        let is_set = self.stream.set_read_timeout(Some(MAX_LINGER_TIME)).is_ok();
        if !is_set || self.stream.shutdown(Shutdown::Write).is_err() {
            return;
        }
        let mut rest = MAX_BODY_BYTES;
        while let Ok(count @ 1..) = self.stream.read(&mut bytes) {
            rest = rest.saturating_sub(count);
            if rest == 0 {
                return;
            }
        }
    }

    /// Runs a computation that is cancelled if the browser closes the connection; returns `None` if it is cancelled.
    ///
    /// # Errors
    /// The error of the operating system.
    pub fn while_there<T>(&self, work: impl FnOnce() -> T) -> io::Result<Option<T>> {
        self.stream.set_nonblocking(true)?;
        let (done, waiting) = channel::<()>();
        let is_gone = Arc::new(AtomicBool::new(false));
        let gone = Arc::clone(&is_gone);
        let answer = thread::scope(move |scope| {
            thread::Builder::new().spawn_scoped(scope, move || {
                // Polls until the sender is dropped.
                while waiting.recv_timeout(CHECK_INTERVAL) == Err(RecvTimeoutError::Timeout) {
                    gone.store(self.has_gone(), Ordering::Relaxed);
                }
            })?;
            let answer = unless(move || is_gone.load(Ordering::Relaxed), work);
            drop(done);
            Ok::<_, io::Error>(answer)
        })?;
        self.stream.set_nonblocking(false)?;
        Ok(answer)
    }

    fn has_gone(&self) -> bool {
        match self.stream.peek(&mut [0]) {
            Ok(count) => count == 0,
            Err(error) => error.kind() != io::ErrorKind::WouldBlock,
        }
    }
}

/// Time left until a deadline.
fn left(end: Instant) -> io::Result<Duration> {
    let left = end.saturating_duration_since(Instant::now());
    match left.is_zero() {
        true => Err(io::ErrorKind::TimedOut.into()),
        false => Ok(left),
    }
}

/// Head of a request, with the offset and the length of its body; `None` if the head is incomplete.
fn head(bytes: &[u8]) -> Result<Option<(Request, usize, usize)>, Instead> {
    let mut headers = [httparse::EMPTY_HEADER; MAX_HEADERS];
    let mut parsed = httparse::Request::new(&mut headers);
    let start = match parsed.parse(bytes) {
        Ok(httparse::Status::Complete(start)) => start,
        Ok(httparse::Status::Partial) => return Ok(None),
        Err(error) => return Err(refused("400 Bad Request", &error.to_string())),
    };
    let target = parsed.path.unwrap_or_default();
    let headers = parsed.headers.iter().map(|header| {
        let value = String::from_utf8_lossy(header.value).trim().to_owned();
        (header.name.to_ascii_lowercase(), value)
    });
    let mut request = Request {
        method: parsed.method.unwrap_or_default().to_owned(),
        path: target.split('?').next().unwrap_or_default().to_owned(),
        headers: headers.collect(),
        body: Vec::new(),
        is_last: parsed.version == Some(0),
    };
    let is_closing = |own: &str| own.eq_ignore_ascii_case("close");
    request.is_last |= request.header("connection").is_some_and(is_closing);
    if request.has("transfer-encoding") {
        return Err(refused(
            "501 Not Implemented",
            "a body has a Content-Length here",
        ));
    }
    let length = match (
        request.has("content-length"),
        request.header("content-length"),
    ) {
        (false, _) => 0,
        (true, Some(text)) if text.bytes().all(|byte| byte.is_ascii_digit()) => {
            text.parse().unwrap_or(usize::MAX)
        }
        _ => return Err(refused("400 Bad Request", "Content-Length is not a number")),
    };
    if length > MAX_BODY_BYTES {
        return Err(refused("413 Content Too Large", "the request is too long"));
    }
    Ok(Some((request, start, length)))
}

#[cfg(test)]
mod tests {
    use super::{Instead, head};

    fn told(text: &str) -> String {
        match head(text.as_bytes()) {
            Ok(None) => "more".to_owned(),
            Ok(Some((request, start, length))) => {
                format!("{} {} {start} {length}", request.method, request.path)
            }
            Err(Instead::Refused(reply)) => reply.status[..3].to_owned(),
            Err(Instead::End) => "end".to_owned(),
        }
    }

    #[test]
    fn request_heads_are_parsed_or_refused() {
        assert_eq!(told("GET / HTTP/1.1\r\nHost: a"), "more");
        assert_eq!(told("GET /a?b HTTP/1.1\r\nHost: a\r\n\r\n"), "GET /a 30 0");
        let post = |header: &str| told(&format!("POST / HTTP/1.1\r\n{header}\r\n\r\n"));
        assert!(post("Content-Length: 12").ends_with(" 12"));
        assert_eq!(post("Content-Length: 1\r\nContent-Length: 2"), "400");
        assert_eq!(post("Content-Length: -1"), "400");
        assert_eq!(post("Content-Length: 99999999999999999999999"), "413");
        assert_eq!(post("Transfer-Encoding: chunked"), "501");
        assert_eq!(told("nothing\r\n\r\n"), "400");
    }
}
