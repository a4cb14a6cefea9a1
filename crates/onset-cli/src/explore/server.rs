//! Who is answered, and with what.

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

/// What is waited after a connection that could not be had.
const PAUSE: Duration = Duration::from_millis(20);
/// The header in which the page shows its token. Pages of other servers cannot send it without being asked for leave, which is not given.
const SHOWN: &str = "onset-token";
/// What is said to whoever has none.
const UNKNOWN: &str = "this page is for the user who has started it: the token of the running program is missing, or another one\n  hint: open the address \
     that `onset explore` has printed; in the same browser links without a token are answered then";

/// The page and what answers its questions.
pub struct Server {
    explorer: Explorer,
    /// What the page shows with every question.
    token: Token,
    /// What the address has that a browser is started with, for its first use: the arguments of a program can be seen by all users of a
    /// machine.
    ticket: Mutex<Option<Token>>,
    /// The names under which a browser of this machine knows the server, with its port.
    hosts: [String; 2],
    open: Connections,
}

impl Server {
    /// A server at an address of this machine, which answers whoever shows the token, and gives it to who is the first to show the ticket.
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

    /// Answers until the program is interrupted.
    ///
    /// # Errors
    /// [`Failure`] when nobody can be heard any more.
    pub fn run(self, listener: &TcpListener) -> Result<ExitCode, Failure> {
        let server = Arc::new(self);
        for stream in listener.incoming() {
            // A connection that was given up, or for which there is no room just now, is none of the others' business.
            let Ok(stream) = stream else {
                thread::sleep(PAUSE);
                continue;
            };
            let own = Arc::clone(&server);
            let conversation = thread::Builder::new().spawn(move || {
                if let Ok(admitted) = own.open.admit(&stream) {
                    own.converse(stream, &admitted);
                }
            });
            // Where there is no room for a thread, others have to end first.
            if conversation.is_err() {
                thread::sleep(PAUSE);
            }
        }
        Ok(ExitCode::SUCCESS)
    }

    /// Answers on a connection as long as there is one.
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

    /// The answer to a request; `None` when nobody waits for it any more.
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
                Some(_) => Some(error("403 Forbidden", UNKNOWN)),
                None => Some(missing()),
            },
            _ => Some(Reply::refused(
                "405 Method Not Allowed",
                "expected GET or POST",
            )),
        }
    }

    /// Why a request is none of this page: pages of other servers must not ask, also where a name of theirs leads to this machine.
    fn stranger(&self, request: &Request) -> Option<&'static str> {
        let is_own = |host: &str| self.hosts.iter().any(|own| own.eq_ignore_ascii_case(host));
        if !request.header("host").is_some_and(is_own) {
            return Some(
                "this page is for the browser on its own machine: the Host is another one",
            );
        }
        let is_own_origin = |origin: &str| origin.strip_prefix("http://").is_some_and(is_own);
        if request.has("origin") && !request.header("origin").is_some_and(is_own_origin) {
            return Some("this page answers itself alone: the Origin is another one");
        }
        let site = request.header("sec-fetch-site");
        let is_navigation = request.method == "GET" && request.path == "/";
        match site {
            Some("cross-site" | "same-site") if !is_navigation => {
                Some("this page answers itself alone: another site asks")
            }
            _ => None,
        }
    }

    /// Whether a request shows the token.
    fn is_shown(&self, request: &Request) -> bool {
        request
            .header(SHOWN)
            .is_some_and(|shown| self.token.is(shown))
    }

    /// The token, for whoever shows it already, or shows the ticket for the first time.
    fn entered(&self, request: &Request) -> Reply {
        let mut ticket = self.ticket.lock().unwrap_or_else(PoisonError::into_inner);
        let shown = request.header(SHOWN).unwrap_or_default();
        let is_ticket = ticket.as_ref().is_some_and(|own| own.is(shown));
        if is_ticket {
            *ticket = None;
        } else if !self.token.is(shown) {
            return error("403 Forbidden", UNKNOWN);
        }
        json("200 OK", told("token", self.token.to_string()))
    }

    fn answer(&self, name: &str, request: &Request, connection: &Connection) -> Option<Reply> {
        // What other pages can send without being asked is no JSON.
        let kind = request.header("content-type").unwrap_or_default();
        if kind.split(';').next().map(str::trim) != Some("application/json") {
            return Some(Reply::refused(
                "415 Unsupported Media Type",
                "a question is application/json",
            ));
        }
        let Ok(text) = std::str::from_utf8(&request.body) else {
            return Some(error("400 Bad Request", "the question is not UTF-8"));
        };
        let question = match Question::parse(text) {
            Ok(question) => question,
            Err(refusal) => return Some(error("400 Bad Request", &refusal.to_string())),
        };
        let answered = connection.while_there(|is_gone| {
            if is_gone() {
                return Err(Refusal::GivenUp);
            }
            self.explorer.answer(name, &question, is_gone)
        });
        Some(match answered.ok()? {
            Ok(document) => json("200 OK", document),
            Err(refusal @ Refusal::Unknown(_)) => error("404 Not Found", &refusal.to_string()),
            // What the command says against a question is an answer too: a browser takes other statuses for faults of the page.
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

/// A message as a document: what a file says must not command a terminal, nor a page.
fn error(status: &'static str, message: &str) -> Reply {
    let message = onset_umat::message(message);
    json(status, told("error", message))
}

/// A document with one text.
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
