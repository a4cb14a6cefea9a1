//! `onset explore`: an interactive page, served on this machine only.
//!
//! The page is a front end like the command: it shows documents of `--json`, and its questions are arguments of `--set` and `--stretch`. It is served
//! on the loopback address with everything it needs, and contacts no other server. The files of the page are public; answers require the token
//! created at the start. The token is in the fragment (after `#`) of the printed address, which browsers do not send; the page stores it and removes
//! it from the address.

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

/// Serves the page until interrupted.
///
/// # Errors
/// [`Failure`] if no port is available.
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
    // Other users may read the arguments of the browser; its token works once, and has usually been used by then.
    if is_shown && !browser::open(&opened) {
        crate::printing::tell("no browser could be started: open the address above");
    }
    server.run(&listener)
}

/// Listener on the loopback address, on a new port by default.
///
/// With a fixed port, a service worker left in the browser by an earlier server on that port could intercept the requests.
fn listener(port: Option<u16>) -> Result<TcpListener, Failure> {
    let port = port.unwrap_or(0);
    TcpListener::bind(SocketAddr::from((Ipv4Addr::LOCALHOST, port))).map_err(|error| {
        Failure::machine(format!(
            "cannot listen on 127.0.0.1:{port}: {error}\n  hint: choose another --port, or 0 for any free port"
        ))
    })
}
