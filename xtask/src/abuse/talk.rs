//! Incomplete requests to the page, and unusual arrays and forks in Python.

use super::running::{Fault, INTERRUPT, Place, longest};
use super::{Programs, Random};
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::process::Command;
use std::time::{Duration, Instant};

/// Beginnings of requests that are never completed.
const HEADS: &[&[u8]] = &[
    b"",
    b"G",
    b"POST / HTTP/1.1\r\nA: ",
    b"POST /api/state HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 1000000\r\n\r\n{",
    b"GET / HTTP/1.1\r\nHost: \xff\xfe\r\n\r\n",
    b"POST /api/map HTTP/1.1\r\nContent-Length: -1\r\n\r\n",
    b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
    b"\x16\x03\x01\x02\x00\x01\x00",
    b"GET / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\nffffffffffffffff\r\n",
];

/// Checks that the page answers its owner despite incomplete requests of others.
pub(super) fn half_requests(
    programs: &Programs,
    place: &Place,
    random: &mut Random,
) -> Result<u64, Fault> {
    let mut command = programs.onset();
    command.args(["explore", "--no-browser"]);
    let mut running = place.started(command)?;
    let begun = Instant::now();
    let address: SocketAddr = loop {
        let text = std::fs::read_to_string(place.path().join(".stdout"))?;
        let found = text
            .trim()
            .strip_prefix("http://")
            .and_then(|rest| rest.split('/').next());
        match found.and_then(|address| address.parse().ok()) {
            Some(address) => break address,
            None if begun.elapsed() > longest() => {
                return Err(Fault::Hang(
                    "explore --no-browser prints no address".to_owned(),
                ));
            }
            None => std::thread::sleep(Duration::from_millis(5)),
        }
    };
    let mut open = Vec::new();
    for _ in 0..random.below(100) {
        let mut stream = TcpStream::connect(address)?;
        // The server may have closed the connection already.
        let _ = stream.write_all(random.of(HEADS));
        if random.below(2) == 0 {
            open.push(stream);
        }
    }
    let since = Instant::now();
    let answered = loop {
        match asked(address) {
            Ok(text) if text.starts_with("HTTP/1.1 200") => break true,
            _ if since.elapsed() > longest() => break false,
            _ => std::thread::sleep(Duration::from_millis(20)),
        }
    };
    drop(open);
    running.signal(INTERRUPT)?;
    running.ended()?;
    match answered {
        true => Ok(1),
        false => Err(Fault::Hang(
            "the page does not answer its owner while half requests are open".to_owned(),
        )),
    }
}

fn asked(address: SocketAddr) -> std::io::Result<String> {
    let mut stream = TcpStream::connect(address)?;
    stream.set_read_timeout(Some(longest()))?;
    write!(
        stream,
        "GET / HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n"
    )?;
    let mut bytes = [0; 64];
    let count = stream.read(&mut bytes)?;
    Ok(String::from_utf8_lossy(&bytes[..count]).into_owned())
}

/// Checks that energies of random tokens are evaluated or refused, many in one process.
pub(super) fn formulas(
    programs: &Programs,
    place: &Place,
    random: &mut Random,
) -> Result<u64, Fault> {
    let script = ("formulas.py", include_str!("formulas.py"));
    in_python(programs, place, script, &[random.word().to_string()])
}

/// Checks that calls with any arrays return or raise an exception.
pub(super) fn arrays(
    programs: &Programs,
    place: &Place,
    random: &mut Random,
) -> Result<u64, Fault> {
    let script = ("arrays.py", include_str!("arrays.py"));
    in_python(programs, place, script, &[random.word().to_string()])
}

/// Checks the same in forked processes.
pub(super) fn forks(programs: &Programs, place: &Place, random: &mut Random) -> Result<u64, Fault> {
    // A forked process that hangs is found before the script counts as hanging, and prints where it is.
    let longest = 0.5 * longest().as_secs_f64();
    let script = ("arrays.py", include_str!("arrays.py"));
    let arguments = [random.word().to_string(), longest.to_string()];
    in_python(programs, place, script, &arguments)
}

/// Checks that a signal ends a call soon.
pub(super) fn interrupts(
    programs: &Programs,
    place: &Place,
    random: &mut Random,
) -> Result<u64, Fault> {
    let script = ("interrupts.py", include_str!("interrupts.py"));
    in_python(programs, place, script, &[random.word().to_string()])
}

/// Runs a script whose last line of output is `done`, the number of counted cases and, after signals, the longest time to the end of a call.
fn in_python(
    programs: &Programs,
    place: &Place,
    (name, text): (&str, &str),
    arguments: &[String],
) -> Result<u64, Fault> {
    let Some(python) = &programs.python else {
        return Ok(0);
    };
    let script = place.write(name, text)?;
    let mut command = Command::new(python);
    command.arg(script).args(arguments);
    command.env("ONSET_UMAT_HOST", &programs.onset);
    let ended = place.started(command)?.ended()?;
    let last = ended.stdout.trim_end().lines().next_back();
    let mut words = last.unwrap_or_default().split(' ');
    let (done, count) = (
        words.next(),
        words.next().and_then(|word| word.parse().ok()),
    );
    match (ended.code, done, count) {
        (Some(0), Some("done"), Some(count)) => {
            if let Some(seconds) = words.next().and_then(|word| word.parse().ok()) {
                place.ended_after(Duration::from_secs_f64(seconds), &ended.line)?;
            }
            Ok(count)
        }
        (code, ..) => Err(Fault::Abort(format!(
            "exit code {code:?}: {}\n{}",
            ended.line, ended.stderr
        ))),
    }
}
