//! `onset explore`: a page to play with, on this machine alone.
//!
//! The page is a front end like the command: what it shows are the documents of `--json`, and what it asks is what is written after `--set`
//! and `--stretch`. It is served on the loopback address, with everything it needs, and asks no other server for anything. The files of the
//! page are those of the program, and for everybody; answers are for who shows the token that was made at the start. It stands behind the `#` of
//! the printed address, which a browser sends nowhere; the page keeps it, and takes it out of the address.

mod browser;
mod http;
mod link;
mod open;
mod page;
mod server;
mod token;

pub use link::Link;

use crate::commands::Failure;
use onset_study::explore::{Explorer, Stored};
use onset_study::settings::Trust;
use server::Server;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::process::ExitCode;
use token::Token;

/// Serves the page until it is interrupted.
///
/// # Errors
/// [`Failure`] when no port can be had.
pub fn serve(
    link: &Link,
    port: Option<u16>,
    is_shown: bool,
    trust: Trust,
    stored: Option<Stored>,
) -> Result<ExitCode, Failure> {
    let listener = listener(port)?;
    let address = listener.local_addr().map_err(Failure::machine)?;
    let random = || Token::random().map_err(Failure::machine);
    let (token, ticket) = (random()?, random()?);
    let place = |token: &Token| format!("http://{address}/{}", link.with(token));
    crate::printing::print_text(&place(&token))?;
    crate::printing::tell("the page is served on this machine until it is interrupted (Ctrl-C)");
    let opened = place(&ticket);
    let server = Server::new(Explorer::new(trust, stored), address, token, ticket);
    // Whoever sees the arguments of a browser sees a token that is good once, and mostly used by then.
    if is_shown && !browser::open(&opened) {
        crate::printing::tell("no browser could be started: open the address above");
    }
    server.run(&listener)
}

/// A listener on the loopback address, on a new port unless one is asked for: what an earlier server of the same port has left in a browser,
/// such as a service worker, would hear what this one is asked.
fn listener(port: Option<u16>) -> Result<TcpListener, Failure> {
    let port = port.unwrap_or(0);
    TcpListener::bind(SocketAddr::from((Ipv4Addr::LOCALHOST, port))).map_err(|error| {
        Failure::machine(format!(
            "cannot listen on 127.0.0.1:{port}: {error}\n  hint: choose another --port, or 0 for any that is free"
        ))
    })
}
