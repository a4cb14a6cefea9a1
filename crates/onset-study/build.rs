//! Identifies the sources and options of the build. The numbers of two builds must not be combined in one map.

use std::fs;
use std::path::{Path, PathBuf};

/// Files that determine the numbers. A package from a registry contains only its sources; its dependencies are identified by their versions.
const SOURCES: [&str; 4] = [
    "src",
    "../onset/src",
    "../onset-umat/src",
    "../../Cargo.lock",
];

fn main() {
    let mut files = Vec::new();
    for source in SOURCES {
        println!("cargo::rerun-if-changed={source}");
        collect(Path::new(source), &mut files);
    }
    files.sort();
    let mut sum = Sum::new();
    for file in &files {
        sum.add(file.as_os_str().as_encoded_bytes());
        sum.add(&fs::read(file).unwrap_or_default());
    }
    let variable = |name: &str| std::env::var(name).unwrap_or_default();
    println!(
        "cargo::rustc-env=ONSET_BUILD={:016x} {} optimized {}",
        sum.0,
        variable("TARGET"),
        variable("OPT_LEVEL")
    );
}

fn collect(path: &Path, files: &mut Vec<PathBuf>) {
    match fs::read_dir(path) {
        Ok(entries) => entries
            .flatten()
            .for_each(|entry| collect(&entry.path(), files)),
        Err(_) if path.is_file() => files.push(path.to_owned()),
        Err(_) => {}
    }
}

/// Hash of Fowler, Noll and Vo (FNV-1a, 64 bits), identical on all machines.
struct Sum(u64);

impl Sum {
    fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    /// Adds bytes and their number.
    fn add(&mut self, bytes: &[u8]) {
        let length = (bytes.len() as u64).to_le_bytes();
        for byte in bytes.iter().chain(&length) {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}
