//! Every combination of the choices for a discretization has an answer.

use crate::onset;
use serde_json::Value;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Values of each choice.
const CHOICES: [(&str, &[&str]); 8] = [
    ("frame", &["lagrangian", "eulerian"]),
    ("lattice", &["square", "hexagonal", "chain"]),
    (
        "quadrature",
        &["nodal", "stress-points", "stress-points-only"],
    ),
    ("approximation", &["raw", "shepard", "mls"]),
    ("background", &["imposed", "interpolated"]),
    ("current-lattice", &["convected", "regular"]),
    ("support-size", &["fixed", "scaled", "convected"]),
    (
        "linearization",
        &[
            "exact",
            "paper",
            "exact-plane-wave",
            "paper-interpolated",
            "frozen-normalization",
        ],
    ),
];

const STATES: [&str; 2] = ["1.2,0.9", "0.7,1.1"];

/// Digits of the combination with the given number, last choice first.
fn digits(mut number: usize) -> impl Iterator<Item = usize> {
    CHOICES.iter().rev().map(move |(_, words)| {
        let digit = number % words.len();
        number /= words.len();
        digit
    })
}

/// Assignments of the combination with the given number; the last choice varies fastest.
///
/// Choices for Eulerian kernels are omitted with Lagrangian kernels, which refuse them.
fn combination(number: usize) -> Vec<String> {
    let eulerian = ["current-lattice", "support-size", "linearization"];
    let all: usize = CHOICES.iter().map(|(_, words)| words.len()).product();
    let is_lagrangian = number < all / 2;
    let choices = CHOICES.iter().rev().zip(digits(number));
    choices
        .filter(|((key, _), _)| !(is_lagrangian && eulerian.contains(key)))
        .map(|((key, words), digit)| format!("discretization.{key}={}", words[digit]))
        .collect()
}

fn is_finite(value: &Value) -> bool {
    match value {
        Value::Number(number) => number.as_f64().is_some_and(f64::is_finite),
        Value::Array(items) => items.iter().all(is_finite),
        Value::Object(fields) => fields.values().all(is_finite),
        _ => true,
    }
}

/// Reason why the answer to a combination is wrong, or `None`.
fn complaint(assignments: &[String], state: &str) -> Option<String> {
    let mut arguments = vec!["state", "--json", "--stretch", state];
    for assignment in assignments {
        arguments.extend(["--set", assignment]);
    }
    let start = Instant::now();
    let answer = onset(&arguments);
    let fact = match answer.code {
        _ if start.elapsed() > Duration::from_secs(5) => "slow",
        _ if answer.stderr.contains("panicked") => "panic",
        Some(0) => match serde_json::from_str::<Value>(&answer.stdout) {
            Ok(document) if !is_finite(&document) => "a number that is not finite",
            Ok(document) if !document["verdict"].is_string() => "no verdict",
            Ok(_) => return None,
            Err(_) => "not one JSON document",
        },
        Some(2) if answer.stdout.is_empty() && answer.stderr.starts_with("error: ") => return None,
        _ => "another end",
    };
    Some(format!("{fact}: {arguments:?}\n{}", answer.stderr))
}

#[test]
fn every_combination_of_choices_is_answered() {
    let total: usize = CHOICES.iter().map(|(_, words)| words.len()).product();
    // The last three choices concern Eulerian kernels only; each combination of the other choices has 30 variants.
    let for_eulerian = 30;
    let next = AtomicUsize::new(0);
    let threads = std::thread::available_parallelism().map_or(2, usize::from);
    let complaints: Vec<String> = std::thread::scope(|scope| {
        let work = || {
            let mut complaints = Vec::new();
            loop {
                let number = next.fetch_add(1, Ordering::Relaxed);
                if number >= total {
                    return complaints;
                }
                // With Lagrangian kernels the first of these 30 combinations represents all.
                let is_lagrangian = number < total / 2;
                if is_lagrangian && !number.is_multiple_of(for_eulerian) {
                    continue;
                }
                // Adjacent combinations are tested at alternating states.
                let assignments = combination(number);
                let state = STATES[digits(number).sum::<usize>() % STATES.len()];
                complaints.extend(complaint(&assignments, state));
            }
        };
        let handles: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        handles
            .into_iter()
            .flat_map(|handle| handle.join().expect("a thread"))
            .collect()
    });
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

#[test]
fn choices_for_eulerian_kernels_are_refused_with_lagrangian_kernels() {
    for (key, words) in &CHOICES[5..] {
        for word in *words {
            let assignment = format!("discretization.{key}={word}");
            let answer = onset(&["state", "--stretch", STATES[0], "--set", &assignment]);
            assert_eq!(answer.code, Some(2), "{assignment}");
            assert!(answer.stderr.contains("has no effect"), "{}", answer.stderr);
        }
    }
}

#[test]
fn the_method_becomes_undefined_where_compression_overfills_its_support() {
    // With a fixed support the number of neighbors grows without bound, until the method refuses the state.
    let run = onset(&[
        "path",
        "--from=0.2,0.2",
        "--to=0.1,0.1",
        "--set=discretization.frame=eulerian",
        "--json",
    ]);
    let answer: Value = serde_json::from_str(&run.stdout).expect("a document");
    let crossings = answer["discretization_crossings"]
        .as_array()
        .expect("a list");
    assert_eq!(crossings.last().expect("a crossing")["to"], "undefined");
}
