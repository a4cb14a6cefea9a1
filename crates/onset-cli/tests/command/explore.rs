//! `onset explore`: its answers equal the answers of the command, and only its page receives them.

use crate::{Scratch, command, onset};
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Running server of the page.
struct Page {
    server: Child,
    host: String,
    /// Complete address as printed.
    address: String,
    /// Token in the address.
    token: String,
}

impl Drop for Page {
    fn drop(&mut self) {
        // The server may have ended by itself.
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

impl Page {
    fn serve(arguments: &[&str]) -> Self {
        let all = [&["explore", "--no-browser", "--port", "0"], arguments].concat();
        Self::started(command(&all))
    }

    fn started(mut server: Command) -> Self {
        let mut server = server
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("the command starts");
        let mut address = String::new();
        let out = server.stdout.take().expect("its output");
        BufReader::new(out)
            .read_line(&mut address)
            .expect("an address");
        let address = address.trim().to_owned();
        let host = address
            .strip_prefix("http://")
            .and_then(|rest| rest.split('/').next());
        let host = host
            .unwrap_or_else(|| panic!("no address: {address}"))
            .to_owned();
        let token = token(&address);
        Self {
            server,
            host,
            address,
            token,
        }
    }

    /// Sends bytes and reads the complete answer: status and body.
    fn send(&self, request: &str) -> (u16, String) {
        let mut stream = TcpStream::connect(&self.host).expect("a connection");
        let request = request.replacen("\r\n", "\r\nConnection: close\r\n", 1);
        stream.write_all(request.as_bytes()).expect("sent");
        let mut answer = String::new();
        stream.read_to_string(&mut answer).expect("an answer");
        let (head, body) = answer.split_once("\r\n\r\n").unwrap_or((&answer, ""));
        let status = head
            .split(' ')
            .nth(1)
            .and_then(|number| number.parse().ok());
        (status.unwrap_or(0), body.to_owned())
    }

    fn get(&self, path: &str, headers: &[&str]) -> (u16, String) {
        let host = format!("Host: {}", self.host);
        let headers = match headers.iter().any(|own| own.starts_with("Host:")) {
            true => headers.join("\r\n"),
            false => [&[host.as_str()], headers].concat().join("\r\n"),
        };
        self.send(&format!("GET {path} HTTP/1.1\r\n{headers}\r\n\r\n"))
    }

    fn post(&self, name: &str, question: &Value, headers: &[&str]) -> (u16, String) {
        let body = question.to_string();
        let own = [
            format!("Host: {}", self.host),
            "Content-Type: application/json".to_owned(),
            format!("Onset-Token: {}", self.token),
        ];
        let is_given = |own: &&String| {
            let name = own.split(':').next().unwrap_or_default();
            !headers.iter().any(|given| given.starts_with(name))
        };
        let mut all: Vec<&str> = own.iter().filter(is_given).map(String::as_str).collect();
        all.extend(headers);
        self.send(&format!(
            "POST /api/{name} HTTP/1.1\r\n{}\r\nContent-Length: {}\r\n\r\n{body}",
            all.join("\r\n"),
            body.len()
        ))
    }

    /// Sends a request without waiting for the answer.
    fn begin(&self, name: &str, question: &Value) -> TcpStream {
        let body = question.to_string();
        let mut stream = TcpStream::connect(&self.host).expect("a connection");
        let request = format!(
            "POST /api/{name} HTTP/1.1\r\nHost: {}\r\nOnset-Token: {}\r\nContent-Type: application/json\r\nContent-Length: {}\r\n\r\n{body}",
            self.host,
            self.token,
            body.len()
        );
        stream.write_all(request.as_bytes()).expect("sent");
        stream
    }

    /// Processor time of the server; seconds.
    #[cfg(target_os = "linux")]
    fn work(&self) -> f64 {
        let place = format!("/proc/{}/stat", self.server.id());
        let told = std::fs::read_to_string(place).expect("a process");
        // The times follow the name, which may contain spaces, and are in hundredths of a second.
        let (_, numbers) = told.rsplit_once(')').expect("a name");
        let ticks = numbers.split_whitespace().skip(11).take(2);
        ticks
            .map(|own| own.parse::<f64>().expect("a number"))
            .sum::<f64>()
            / 100.0
    }

    fn ask(&self, name: &str, question: &Value) -> String {
        let (status, body) = self.post(name, question, &[]);
        assert_eq!(status, 200, "{name}: {body}");
        body
    }
}

/// Token of an address.
fn token(address: &str) -> String {
    let behind = address.split_once("#token=").map(|(_, behind)| behind);
    let behind = behind.unwrap_or_else(|| panic!("no token: {address}"));
    behind.split('&').next().unwrap_or_default().to_owned()
}

/// New folder.
fn folder(name: &str) -> Scratch {
    let place = Scratch::new(&format!("explore-{name}"));
    std::fs::create_dir_all(&place).expect("a folder");
    place
}

/// Questions with their assignments and stretches.
const QUESTIONS: [(&[&str], &str); 3] = [
    (&["discretization.method=updated-sph"], "1.15,1"),
    (
        &[
            "material.model=formula",
            "material.energy=mu/2*(I1 - 3 - 2*ln(J)) + ln(J)^2",
            "material.mu=0.7",
            "discretization.lattice=square",
        ],
        "0.8,1.2,1.1",
    ),
    (
        &[
            "material.model=blatz-ko",
            "discretization.method=finite-elements",
            "discretization.mesh=bricks",
            "discretization.integration=one-point",
        ],
        "1.1,1,0.9",
    ),
];

#[test]
fn page_and_command_give_identical_answers() {
    let page = Page::serve(&[]);
    for (set, stretch) in QUESTIONS {
        let set: Vec<String> = set.iter().map(|own| (*own).to_owned()).collect();
        let question = json!({ "set": set, "stretch": stretch });
        let told = |first: &[&str]| {
            let mut arguments: Vec<&str> = first.to_vec();
            arguments.extend(["--json", "--stretch", stretch]);
            for own in &set {
                arguments.extend(["--set", own]);
            }
            onset(&arguments).stdout
        };
        assert_eq!(page.ask("state", &question), told(&["state"]).trim_end());
        if set.len() == 1 {
            let waves = told(&["dispersion", "--path"]);
            assert_eq!(page.ask("dispersion", &question), waves.trim_end());
        }
    }
}

#[test]
fn page_and_command_give_identical_errors() {
    let page = Page::serve(&[]);
    let energy = "material.energy=mu/2*(I1 - 3 -* 2)";
    let set = ["material.model=formula", energy];
    let (status, body) = page.post("state", &json!({ "set": set, "stretch": "1.1,1" }), &[]);
    let refused: Value = serde_json::from_str(&body).expect("JSON");
    let message = refused["error"].as_str().expect("a message");
    assert_eq!(status, 200);
    assert!(
        message.contains("column 15") && message.contains("\n                  ^"),
        "{message}"
    );
    let command = onset(&[
        "state",
        "--stretch",
        "1.1,1",
        "--set",
        set[0],
        "--set",
        energy,
    ]);
    assert_eq!(command.stderr.trim_end(), format!("error: {message}"));
    // A name is treated as text, even if it contains markup.
    let set = ["material.model=<script>alert(1)</script>"];
    let (status, body) = page.post("state", &json!({ "set": set, "stretch": "1,1" }), &[]);
    assert_eq!(status, 200);
    assert!(
        body.contains("error") && body.contains("cannot be"),
        "{body}"
    );
    for (body, expected) in [("{", 400), ("{\"sett\": []}", 400), ("7", 400)] {
        let length = body.len();
        let (status, _) = page.send(&format!(
            "POST /api/state HTTP/1.1\r\nHost: {}\r\nOnset-Token: {}\r\nContent-Type: application/json\r\nContent-Length: {length}\r\n\r\n{body}",
            page.host, page.token
        ));
        assert_eq!(status, expected, "{body}");
    }
    assert_eq!(page.post("everything", &json!({}), &[]).0, 404);
    assert_eq!(page.get("/../Cargo.toml", &[]).0, 404);
    let host = format!("Host: {}", page.host);
    assert_eq!(
        page.send(&format!("PUT / HTTP/1.1\r\n{host}\r\n\r\n")).0,
        405
    );
    assert_eq!(
        page.send(&format!(
            "GET / HTTP/1.1\r\n{host}\r\nX: {}\r\n\r\n",
            "x".repeat(40_000)
        ))
        .0,
        431
    );
    // A repeated header is ambiguous.
    assert_eq!(page.get("/", &[&host, &host]).0, 403);
}

#[test]
fn other_hosts_and_origins_are_refused() {
    let page = Page::serve(&[]);
    let port = page.host.split(':').nth(1).expect("a port").to_owned();
    let question = json!({ "set": [], "stretch": "1,1" });
    for host in [
        "Host: example.org".to_owned(),
        format!("Host: example.org:{port}"),
        "Host: 127.0.0.1".to_owned(),
        "Host: 127.0.0.1:1".to_owned(),
        format!("Host: 127.0.0.1:{port}.example.org"),
        "Hostless: yes".to_owned(),
    ] {
        let plain = format!("GET / HTTP/1.1\r\n{host}\r\n\r\n");
        assert_eq!(page.send(&plain).0, 403, "{host}");
        if host.starts_with("Host:") {
            assert_eq!(page.post("state", &question, &[&host]).0, 403, "{host}");
        }
    }
    for origin in [
        "Origin: null".to_owned(),
        "Origin: https://example.org".to_owned(),
        format!("Origin: https://127.0.0.1:{port}"),
        format!("Origin: http://example.org:{port}"),
        "Origin: http://127.0.0.1:1".to_owned(),
        "Sec-Fetch-Site: cross-site".to_owned(),
        "Sec-Fetch-Site: same-site".to_owned(),
    ] {
        assert_eq!(page.post("state", &question, &[&origin]).0, 403, "{origin}");
    }
    for own in [
        format!("Origin: http://127.0.0.1:{port}"),
        "Sec-Fetch-Site: same-origin".to_owned(),
    ] {
        assert_eq!(page.post("state", &question, &[&own]).0, 200, "{own}");
    }
    assert_eq!(page.get("/", &[&format!("Host: localhost:{port}")]).0, 200);
    // A link from another site may open the page, but nothing else.
    assert_eq!(page.get("/", &["Sec-Fetch-Site: cross-site"]).0, 200);
    assert_eq!(page.get("/page.js", &["Sec-Fetch-Site: cross-site"]).0, 403);
    // Content types that a page can send without permission are refused.
    for kind in [
        "Content-Type: text/plain",
        "Content-Type: application/x-www-form-urlencoded",
    ] {
        assert_eq!(page.post("state", &question, &[kind]).0, 415);
    }
}

#[test]
fn other_users_of_the_machine_are_refused() {
    let page = Page::serve(&[]);
    let question = json!({ "set": [], "stretch": "1,1" });
    let changed = |n: usize| {
        let other = if &page.token[n..=n] == "0" { "1" } else { "0" };
        format!("{}{other}{}", &page.token[..n], &page.token[n + 1..])
    };
    for wrong in [
        String::new(),
        changed(0),
        changed(31),
        page.token[..31].to_owned(),
        format!("{}0", page.token),
        Page::serve(&[]).token.clone(),
    ] {
        let shown = format!("Onset-Token: {wrong}");
        for name in ["catalog", "state", "stored", "enter"] {
            let (status, body) = page.post(name, &question, &[&shown]);
            assert_eq!(status, 403, "{name} {wrong}: {body}");
            let refused: Value = serde_json::from_str(&body).expect("JSON");
            let told = refused["error"].as_str().expect("a text");
            assert!(
                told.contains("hint: open the address that `onset explore` has printed"),
                "{told}"
            );
            assert!(!body.contains(&page.token));
        }
    }
    // The printed address opens the page in any number of browsers.
    for _ in 0..2 {
        let (status, body) = page.post("enter", &json!({}), &[]);
        assert_eq!(status, 200);
        assert_eq!(
            serde_json::from_str::<Value>(&body).expect("JSON")["token"],
            page.token.as_str()
        );
    }
    // The served files are part of the program and must not contain the token.
    assert!(!page.get("/", &[]).1.contains(&page.token));
}

/// Other users can read the arguments of a program: the token given to the browser at its start is valid only once.
#[test]
#[cfg(target_os = "linux")]
fn the_address_given_to_the_browser_opens_the_page_only_once() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder("browser");
    let (browser, seen) = (folder.join("xdg-open"), folder.join("seen"));
    let script = format!(
        "#!/bin/sh\necho \"$1\" > {0}.new\nmv {0}.new {0}\n",
        seen.display()
    );
    std::fs::write(&browser, script).expect("a script");
    std::fs::set_permissions(&browser, std::fs::Permissions::from_mode(0o700)).expect("allowed");
    let mut server = command(&["explore", "--port", "0"]);
    let path = std::env::var("PATH").unwrap_or_default();
    server.env("PATH", format!("{}:{path}", folder.display()));
    let page = Page::started(server);
    let since = Instant::now();
    while !seen.exists() && since.elapsed() < Duration::from_secs(30) {
        std::thread::sleep(Duration::from_millis(10));
    }
    let address = std::fs::read_to_string(&seen).expect("an address");
    assert!(address.starts_with(&format!("http://{}/#token=", page.host)));
    let ticket = token(address.trim());
    assert_ne!(ticket, page.token);
    let shown = format!("Onset-Token: {ticket}");
    let question = json!({ "set": [], "stretch": "1,1" });
    assert_eq!(
        page.post("state", &question, &[&shown]).0,
        403,
        "it is not a token"
    );
    let (status, body) = page.post("enter", &json!({}), &[&shown]);
    assert_eq!(status, 200, "{body}");
    assert!(body.contains(&page.token));
    assert_eq!(page.post("enter", &json!({}), &[&shown]).0, 403);
}

#[test]
fn the_page_is_complete_and_contacts_no_other_server() {
    let page = Page::serve(&[]);
    let (status, html) = page.get("/", &[]);
    assert_eq!(status, 200);
    for name in html.split('"').filter(|part| {
        [".js", ".css", ".svg", ".txt"]
            .iter()
            .any(|end| part.ends_with(end))
    }) {
        assert_eq!(page.get(&format!("/{name}"), &[]).0, 200, "{name}");
    }
    let raw = format!("HEAD / HTTP/1.0\r\nHost: {}\r\n\r\n", page.host);
    let mut stream = TcpStream::connect(&page.host).expect("a connection");
    stream.write_all(raw.as_bytes()).expect("sent");
    let mut head = String::new();
    stream.read_to_string(&mut head).expect("an answer");
    for expected in [
        "default-src 'none'",
        "script-src 'self'",
        "connect-src 'self'",
        "nosniff",
        "no-referrer",
    ] {
        assert!(head.contains(expected), "{head}");
    }
    assert!(!html.contains("http://") && !html.contains("https://"));
}

#[test]
fn the_page_is_built_from_the_current_sources() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("page");
    let mut files: Vec<String> = std::fs::read_dir(folder.join("src"))
        .expect("the sources")
        .filter_map(|file| {
            Some(format!(
                "src/{}",
                file.ok()?.file_name().into_string().ok()?
            ))
        })
        .collect();
    files.extend(
        [
            "build.mjs",
            "package-lock.json",
            "package.json",
            "tsconfig.json",
        ]
        .map(str::to_owned),
    );
    files.sort();
    let mut sum = Sha256::new();
    for file in files {
        let bytes = std::fs::read(folder.join(&file)).expect("a source");
        sum.update(format!("{file}\0"));
        sum.update(bytes);
        sum.update("\0");
    }
    let found: String = sum
        .finalize()
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    let built = std::fs::read_to_string(folder.join("dist/sources.sha256")).expect("the sum");
    assert_eq!(
        built.trim(),
        found,
        "the page is older than its sources: cargo xtask page"
    );
}

#[test]
fn an_untrusted_study_loads_no_library_and_reads_no_file() {
    let folder = folder("stranger");
    let library = folder.join("stranger.so");
    // The library is a pipe without a writer, so that reading it would block forever.
    #[cfg(unix)]
    assert!(
        std::process::Command::new("mkfifo")
            .arg(&library)
            .status()
            .expect("mkfifo")
            .success()
    );
    let study = format!(
        "[material]\nmodel = \"umat\"\nlibrary = {:?}\n[[axes]]\nquantity = \"stretch-1\"\nrange = [0.9, 1.1]\nstates = 4\n\
         [[axes]]\nquantity = \"stretch-2\"\nrange = [0.9, 1.1]\nstates = 4\n",
        library.display().to_string()
    );
    let page = Page::serve(&[]);
    let opened: Value =
        serde_json::from_str(&page.ask("open", &json!({ "text": study }))).expect("JSON");
    let mut question = opened["question"].clone();
    question["form"] = json!("toml");
    assert!(
        question["set"].to_string().contains("stranger.so"),
        "{question}"
    );
    for name in [
        "form",
        "state",
        "dispersion",
        "directions",
        "mode",
        "map",
        "boundary",
        "export",
    ] {
        let (status, body) = page.post(name, &question, &[]);
        assert_eq!(status, 200, "{name}: {body}");
        assert!(
            body.contains("error") && body.contains("nothing was loaded"),
            "{name}: {body}"
        );
    }
    // A study given as text cannot refer to other files, and an invalid study is refused.
    for text in [
        "include = \"/etc/passwd\"",
        "[material]\nfile = \"/etc/passwd\"",
        "/etc/passwd",
    ] {
        let body = page.ask("open", &json!({ "text": text }));
        assert!(
            body.contains("\"error\"") && !body.contains("root:"),
            "{body}"
        );
    }
}

/// A problem that takes hours.
const LONG: [&str; 3] = [
    "discretization.method=material-points",
    "discretization.lattice=simple-cubic",
    "discretization.unknowns=particles",
];

#[test]
fn a_cancelled_map_is_not_computed_to_the_end() {
    let page = Page::serve(&[]);
    let window = json!({ "axes": ["stretch-1", "stretch-2"], "ranges": [[0.5, 2.0], [0.5, 2.0]] });
    let question = json!({ "set": LONG, "stretch": "1,1,1", "window": window, "level": 3 });
    let stream = page.begin("map", &question);
    std::thread::sleep(Duration::from_millis(300));
    drop(stream);
    // Another request is answered immediately, on all cores.
    let since = Instant::now();
    page.ask(
        "map",
        &json!({ "set": ["discretization.method=updated-sph"], "stretch": "1,1", "level": 0 }),
    );
    assert!(
        since.elapsed() < Duration::from_secs(60),
        "{:?}",
        since.elapsed()
    );
}

/// A problem that takes a minute for one state.
#[cfg(target_os = "linux")]
const SLOW: [&str; 4] = [
    "discretization.method=updated-sph",
    "discretization.lattice=simple-cubic",
    "discretization.cells=3",
    "discretization.perturbation=0.05",
];

/// A slider requests many states, and only the last answer is needed.
#[test]
#[cfg(target_os = "linux")]
fn closing_the_connection_cancels_a_state_its_mode_and_its_dispersion() {
    let page = Page::serve(&[]);
    let question = json!({ "set": SLOW, "stretch": "1.1,1,1" });
    for name in ["state", "mode", "dispersion"] {
        let before = page.work();
        let stream = page.begin(name, &question);
        let since = Instant::now();
        while page.work() - before < 4.0 {
            assert!(
                since.elapsed() < Duration::from_secs(120),
                "{name} has not come far"
            );
            std::thread::sleep(Duration::from_millis(20));
        }
        drop(stream);
        // Without cancellation it would take a minute.
        let since = Instant::now();
        let mut done = page.work();
        loop {
            std::thread::sleep(Duration::from_millis(500));
            let now = page.work();
            if now - done < 0.02 {
                break;
            }
            done = now;
            assert!(since.elapsed() < Duration::from_secs(20), "{name} goes on");
        }
        assert!(done - before < 10.0, "{name} took {} s", done - before);
    }
}

#[test]
fn a_link_opens_the_problem_of_the_command() {
    let page = Page::serve(&["--set", "discretization.method=tlsph"]);
    assert!(page.address.ends_with(
        "&set=discretization.method%3Dtotal-lagrangian-sph&stretch=1,1&axis=stretch-1,0.5,2&axis=stretch-2,0.5,2"
    ), "{}", page.address);
    let plain = Page::serve(&[]);
    assert!(plain.address.ends_with(&format!("/#token={}", plain.token)));
    // A link of another run, with another token and port, opens the same problem.
    let again = Page::serve(&[&page.address]);
    assert_ne!(again.token, page.token);
    let asked = |page: &Page| {
        page.address
            .split_once("&set")
            .map(|(_, asked)| asked.to_owned())
    };
    assert_eq!(asked(&again), asked(&page));
    let refused = onset(&["explore", "http://127.0.0.1:6673/#axis=stretch-1"]);
    assert_eq!(refused.code, Some(2));
    assert!(
        refused
            .stderr
            .contains("hint: expected the name of the axis and its ends"),
        "{}",
        refused.stderr
    );
    let refused = onset(&["explore", "no-such-study.toml"]);
    assert_eq!(refused.code, Some(2));
    let refused = onset(&["state", "--open", "--deformation-gradient", "1,0,0,1"]);
    assert_eq!(refused.code, Some(2));
    let refused = onset(&["explore", "--json"]);
    assert_eq!(refused.code, Some(2));
}

#[test]
fn a_stored_map_is_shown() {
    let folder = folder("stored");
    let study = folder.join("study.toml");
    let axis =
        |name: &str| format!("[[axes]]\nquantity = \"{name}\"\nrange = [0.9, 1.3]\nstates = 8\n");
    let text = format!(
        "title = \"Two <b>stretches</b>\"\n[discretization]\nmethod = \"updated-sph\"\n{}{}[map]\ntile = 8\n",
        axis("stretch-1"),
        axis("stretch-2")
    );
    std::fs::write(&study, text).expect("a study");
    let store = folder.join("map.zarr");
    let [study, store] = [&study, &store].map(|path| path.to_str().expect("UTF-8"));
    assert_eq!(
        onset(&["map", study, "--out", store, "--quiet"]).code,
        Some(0)
    );
    let page = Page::serve(&[store]);
    assert!(page.address.ends_with("&map=stored"));
    let shown: Value = serde_json::from_str(&page.ask("stored", &json!({}))).expect("JSON");
    assert_eq!(shown["title"], "Two <b>stretches</b>");
    assert_eq!(
        shown["question"]["set"],
        json!(["discretization.method=updated-sph"])
    );
    let stored = shown["map"]["classes"].as_array().expect("classes").clone();
    assert_eq!(stored.len(), 64);
    // The state at the center of a cell has the stored class.
    let catalog: Value = serde_json::from_str(&page.ask("catalog", &json!({}))).expect("JSON");
    for n in [0, 27, 63] {
        let at = |i: usize| 0.9 + 0.4 * (i as f64 + 0.5) / 8.0;
        let stretch = format!("{},{}", at(n % 8), at(n / 8));
        let question = json!({ "set": shown["question"]["set"], "stretch": stretch });
        let state: Value = serde_json::from_str(&page.ask("state", &question)).expect("JSON");
        let class = &catalog["classes"][stored[n].as_u64().expect("a class") as usize]["name"];
        let verdict = state["verdict"].as_str().expect("a verdict");
        assert!(
            class.as_str().expect("a name").starts_with(verdict),
            "{class} {verdict}"
        );
    }
    let refused = onset(&["explore", folder.to_str().expect("UTF-8"), "--no-browser"]);
    assert_eq!(refused.code, Some(2), "{}", refused.stderr);
}

#[test]
fn incomplete_requests_do_not_block_other_connections() {
    let page = Page::serve(&[]);
    let half = |n: usize| {
        let mut stream = TcpStream::connect(&page.host).expect("a connection");
        let sent = [
            "POST / HTTP/1.1\r\nA: ",
            "",
            "POST /api/state HTTP/1.1\r\nContent-Length: 9\r\n\r\n{",
        ];
        stream
            .write_all(sent[n % sent.len()].as_bytes())
            .expect("sent");
        stream
    };
    let _idle: Vec<TcpStream> = (0..150).map(half).collect();
    let asked = Instant::now();
    let answer = page.ask("state", &json!({ "set": [], "stretch": "1,1" }));
    assert!(answer.contains("verdict"), "{answer}");
    assert!(
        asked.elapsed() < Duration::from_secs(10),
        "{:?}",
        asked.elapsed()
    );
}

#[test]
fn a_request_that_arrives_too_slowly_is_ended() {
    let page = Page::serve(&[]);
    let mut stream = TcpStream::connect(&page.host).expect("a connection");
    let begun = Instant::now();
    // The first byte that cannot be sent, or an answer, marks the end.
    let mut answer = [0; 64];
    stream
        .set_read_timeout(Some(Duration::from_millis(200)))
        .expect("set");
    while stream.write_all(b"A").is_ok() && !matches!(stream.read(&mut answer), Ok(0)) {
        assert!(begun.elapsed() < Duration::from_secs(30), "still open");
    }
}

#[test]
fn a_connection_that_sends_nothing_is_ended() {
    let page = Page::serve(&[]);
    let mut stream = TcpStream::connect(&page.host).expect("a connection");
    stream
        .set_read_timeout(Some(Duration::from_secs(20)))
        .expect("set");
    assert!(matches!(stream.read(&mut [0; 64]), Ok(0)), "still open");
}
