//! Server of the page: access control and replies.

use super::http::{Connection, Instead, Reply, Request};
use super::open::{Admitted, Connections};
use super::page;
use super::token::Token;
use crate::commands::Failure;
use onset_study::explore::{Explorer, Question, Refusal};
use std::collections::BTreeMap;
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::process::ExitCode;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

/// Pause after a failed connection.
const RETRY_PAUSE: Duration = Duration::from_millis(20);
/// Header with the token of the page. Pages of other servers cannot send it without a permission that this server never grants.
const TOKEN_HEADER: &str = "onset-token";
/// Refusal of a request without a valid token.
const NO_TOKEN: &str = "this page is for the user who started it: the token of the running program is missing or wrong\n  hint: open the address \
     that `onset explore` has printed; links without a token then work in the same browser";

/// HTTP server of the page, which also answers its requests.
pub struct Server {
    explorer: Explorer,
    /// Token that the page sends with every request.
    token: Token,
    /// One-time ticket in the address given to the browser at the start, because the arguments of a program are visible to all users of a machine.
    ticket: Mutex<Option<Token>>,
    /// Accepted `Host` headers, with the port.
    hosts: [String; 2],
    open: Connections,
}

impl Server {
    /// Server at a loopback address, with a token for requests and a ticket that is exchanged for the token once.
    pub fn new(explorer: Explorer, address: SocketAddr, token: Token, ticket: Token) -> Self {
        let port = address.port();
        Self {
            explorer,
            token,
            ticket: Mutex::new(Some(ticket)),
            hosts: [format!("127.0.0.1:{port}"), format!("localhost:{port}")],
            open: Connections::default(),
        }
    }

    /// Serves until the program is interrupted.
    ///
    /// # Errors
    /// [`Failure`] if the listener fails.
    pub fn run(self, listener: &TcpListener) -> Result<ExitCode, Failure> {
        let server = Arc::new(self);
        for stream in listener.incoming() {
            // A failed connection does not affect the others.
            let Ok(stream) = stream else {
                thread::sleep(RETRY_PAUSE);
                continue;
            };
            let own = Arc::clone(&server);
            let conversation = thread::Builder::new().spawn(move || {
                if let Ok(admitted) = own.open.admit(&stream) {
                    own.converse(stream, &admitted);
                }
            });
            // If no thread can be started, other connections must end first.
            if conversation.is_err() {
                thread::sleep(RETRY_PAUSE);
            }
        }
        Ok(ExitCode::SUCCESS)
    }

    /// Replies to all requests on a connection.
    fn converse(&self, stream: TcpStream, admitted: &Admitted<'_>) {
        let Ok(mut connection) = Connection::new(stream) else {
            return;
        };
        loop {
            let (reply, has_body, is_last) = match connection.request() {
                Ok(request) => match self.reply(&request, &connection, admitted) {
                    Some(reply) => (reply, request.method != "HEAD", request.is_last),
                    None => return,
                },
                Err(Instead::Refused(reply)) => (reply, true, true),
                Err(Instead::End) => return,
            };
            if connection.send(&reply, has_body).is_err() {
                return;
            }
            if is_last {
                return connection.end();
            }
            admitted.mark(false);
        }
    }

    /// Reply to a request; `None` if the request was cancelled.
    fn reply(
        &self,
        request: &Request,
        connection: &Connection,
        admitted: &Admitted<'_>,
    ) -> Option<Reply> {
        if let Some(why) = self.stranger(request) {
            return Some(Reply::refused("403 Forbidden", why));
        }
        match request.method.as_str() {
            "GET" | "HEAD" => Some(file(&request.path)),
            "POST" => match request.path.strip_prefix("/api/") {
                Some("enter") => Some(self.entered(request)),
                Some(name) if self.is_shown(request) => {
                    admitted.computing(|| self.answer(name, request, connection))
                }
                Some(_) => Some(error("403 Forbidden", NO_TOKEN)),
                None => Some(missing()),
            },
            _ => Some(Reply::refused(
                "405 Method Not Allowed",
                "expected GET or POST",
            )),
        }
    }

    /// Reason to refuse a request from outside this page, including requests of other servers whose name resolves to this machine.
    fn stranger(&self, request: &Request) -> Option<&'static str> {
        let is_own = |host: &str| self.hosts.iter().any(|own| own.eq_ignore_ascii_case(host));
        if !request.header("host").is_some_and(is_own) {
            return Some("this page serves browsers on this machine only: the Host header differs");
        }
        let is_own_origin = |origin: &str| origin.strip_prefix("http://").is_some_and(is_own);
        if request.has("origin") && !request.header("origin").is_some_and(is_own_origin) {
            return Some("this server answers its page only: the Origin header differs");
        }
        let site = request.header("sec-fetch-site");
        let is_navigation = request.method == "GET" && request.path == "/";
        match site {
            Some("cross-site" | "same-site") if !is_navigation => {
                Some("this server answers its page only: the request comes from another site")
            }
            _ => None,
        }
    }

    /// Returns true if the request contains the token.
    fn is_shown(&self, request: &Request) -> bool {
        request
            .header(TOKEN_HEADER)
            .is_some_and(|shown| self.token.is(shown))
    }

    /// Reply with the token, if the request contains the token, or the ticket for the first time.
    fn entered(&self, request: &Request) -> Reply {
        let mut ticket = self.ticket.lock().unwrap_or_else(PoisonError::into_inner);
        let shown = request.header(TOKEN_HEADER).unwrap_or_default();
        let is_ticket = ticket.as_ref().is_some_and(|own| own.is(shown));
        if is_ticket {
            *ticket = None;
        } else if !self.token.is(shown) {
            return error("403 Forbidden", NO_TOKEN);
        }
        json("200 OK", told("token", self.token.to_string()))
    }

    fn answer(&self, name: &str, request: &Request, connection: &Connection) -> Option<Reply> {
        // Other pages can send only simple content types without permission, and JSON is not among them.
        let kind = request.header("content-type").unwrap_or_default();
        if kind.split(';').next().map(str::trim) != Some("application/json") {
            return Some(Reply::refused(
                "415 Unsupported Media Type",
                "a request is application/json",
            ));
        }
        let Ok(text) = std::str::from_utf8(&request.body) else {
            return Some(error("400 Bad Request", "the request is not UTF-8"));
        };
        let question = match Question::parse(text) {
            Ok(question) => question,
            Err(refusal) => return Some(error("400 Bad Request", &refusal.to_string())),
        };
        let answered = connection.while_there(|| self.explorer.answer(name, &question));
        Some(match answered.ok()?? {
            Ok(document) => json("200 OK", document),
            Err(refusal @ Refusal::Unknown(_)) => error("404 Not Found", &refusal.to_string()),
            // An error message of the command is a valid answer; with another status, browsers would report a fault of the page.
            Err(refusal) => error("200 OK", &refusal.to_string()),
        })
    }
}

fn json(status: &'static str, document: String) -> Reply {
    Reply {
        status,
        kind: "application/json",
        body: document.into_bytes(),
    }
}

/// Error message as a document, without control sequences for terminals or pages.
fn error(status: &'static str, message: &str) -> Reply {
    let message = onset_umat::message(message);
    json(status, told("error", message))
}

/// Document with a single text.
fn told(name: &str, text: String) -> String {
    onset_study::json::document(&BTreeMap::from([(name, text)])).unwrap_or_default()
}

fn missing() -> Reply {
    Reply::refused("404 Not Found", "there is nothing here")
}

fn file(path: &str) -> Reply {
    let found = page::FILES.iter().find(|file| file.path == path);
    found.map_or_else(missing, |file| Reply {
        status: "200 OK",
        kind: file.kind,
        body: file.bytes.to_vec(),
    })
}
