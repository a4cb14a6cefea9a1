//! Damaged files yield frames or an error, without a panic or a long computation.
//!
//! `ONSET_MUTATIONS` sets the number of damaged files.

use flate2::read::MultiGzDecoder;
use flate2::write::GzEncoder;
use onset_frames::{Reading, Series};
use std::io::{Read, Write};
use std::path::Path;
use std::time::{Duration, Instant};

/// SplitMix64.
struct Random(u64);

impl Random {
    fn below(&mut self, bound: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) % bound.max(1) as u64) as usize
    }
}

const DUMP: &str = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS xy xz yz pp pp ss\n0 1 0.1\n0 1 0\n0 1 0\nITEM: ATOMS id type xs ys zs ix iy iz c_S[1] c_S[2] c_S[3]\n1 1 0 0 0 0 0 0 1 2 3\n2 1 0.5 0 0 1 0 0 1 2 3\n";
const TABLE: &str = "# run\ntime,id,x,y,stress_xx,stress_yy,stress_xy,\"held\"\n0,1,0,0,1,2,3,0\n0,2,1,0,1,2,3,1\n1,1,0,0,1,2,3,0\n1,2,1.5,0,1,2,3,1\n";
const XYZ: &str = "2\nLattice=\"10 0 0 0 10 0 0 0 1\" Properties=species:S:1:pos:R:3:id:I:1 Time=0.5\nA 0 0 0 1\nB 1 0 0 2\n";
/// Words that change the meaning of counts and names.
const WORDS: [&str; 14] = [
    "0",
    "-1",
    "18446744073709551615",
    "1e308",
    "nan",
    "inf",
    "9999999",
    "x",
    "\n",
    "\"",
    "<",
    "ITEM: ",
    ",",
    "\0",
];

fn damaged(bytes: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..1 + random.below(4) {
        let place = random.below(bytes.len());
        match random.below(7) {
            0 => bytes.truncate(place),
            1 | 2 => {
                if let Some(byte) = bytes.get_mut(place) {
                    *byte ^= 1 << random.below(8);
                }
            }
            3 => {
                let end = (place + random.below(40)).min(bytes.len());
                bytes.drain(place..end);
            }
            4 => {
                let end = (place + random.below(200)).min(bytes.len());
                let part = bytes[place..end].to_vec();
                let to = random.below(bytes.len());
                bytes.splice(to..to, part).for_each(drop);
            }
            5 => {
                // Replaces a number.
                let is_digit = |byte: &u8| byte.is_ascii_digit();
                if let Some(start) = bytes[place..].iter().position(is_digit) {
                    let start = place + start;
                    let length = bytes[start..].iter().position(|byte| !is_digit(byte));
                    let end = length.map_or(bytes.len(), |length| start + length);
                    let word = WORDS[random.below(WORDS.len())];
                    bytes.splice(start..end, word.bytes()).for_each(drop);
                }
            }
            _ => {
                let word = WORDS[random.below(WORDS.len())];
                bytes.splice(place..place, word.bytes()).for_each(drop);
            }
        }
    }
    bytes
}

/// Grid with its numbers appended as bytes: two points and their densities.
fn appended() -> Vec<u8> {
    let mut bytes = b"<VTKFile type=\"PolyData\" byte_order=\"LittleEndian\" header_type=\"UInt64\"><PolyData>\
        <Piece NumberOfPoints=\"2\" NumberOfVerts=\"0\"><PointData><DataArray type=\"Float32\" Name=\"rho\" format=\"appended\" offset=\"56\"/></PointData>\
        <Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"appended\" offset=\"0\"/></Points></Piece></PolyData>\
        <AppendedData encoding=\"raw\">_"
        .to_vec();
    bytes.extend(48_u64.to_le_bytes());
    bytes.extend(
        [0.0, 0.0, 0.0, 1.0, 0.5, 0.0]
            .map(f64::to_le_bytes)
            .concat(),
    );
    bytes.extend(8_u64.to_le_bytes());
    bytes.extend([1.0, 2.0].map(f32::to_le_bytes).concat());
    bytes.extend(b"</AppendedData></VTKFile>");
    bytes
}

/// Array of two frames, three particles and two components.
fn array() -> Vec<u8> {
    let head = "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3, 2), }";
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((head.len() as u16 + 56).to_le_bytes());
    bytes.extend(format!("{head:<width$}\n", width = head.len() + 55).bytes());
    bytes.extend((0..12).flat_map(|n| f64::from(n * n).to_le_bytes()));
    bytes
}

/// Damages a file, or the contents of every second compressed file.
fn damaged_file(bytes: &[u8], is_compressed: bool, random: &mut Random) -> Vec<u8> {
    if !is_compressed || random.below(2) == 0 {
        return damaged(bytes, random);
    }
    let mut contents = Vec::new();
    let mut decoder = MultiGzDecoder::new(bytes);
    decoder.read_to_end(&mut contents).expect("compressed data");
    let mut encoder = GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder
        .write_all(&damaged(&contents, random))
        .expect("compressed");
    encoder.finish().expect("compressed")
}

#[test]
fn damaged_files_give_frames_or_an_error() {
    let folder = tempfile::tempdir().expect("a folder");
    let read = |name: &str| std::fs::read(Path::new("tests/data").join(name)).expect("data");
    let files: Vec<(&str, Vec<u8>)> = vec![
        ("a.dump", DUMP.repeat(2).into_bytes()),
        ("a.csv", TABLE.into()),
        ("a.xyz", XYZ.repeat(2).into_bytes()),
        ("a.dump.gz", read("small.dump.gz")),
        ("a.npz", read("small.npz")),
        ("b.npz", read("stored.npz")),
        ("a.vtu", read("meshio-ascii.vtu")),
        ("b.vtu", read("meshio-base64.vtu")),
        ("c.vtu", read("meshio-zlib.vtu")),
        ("a.pvd", read("small.pvd")),
        ("a.h5", read("series.h5")),
        ("b.h5", read("square_5.hdf5")),
        ("a.vtp", appended()),
        ("a.npy", array()),
    ];
    for name in ["meshio-ascii.vtu", "meshio-zlib.vtu"] {
        std::fs::write(folder.path().join(name), read(name)).expect("written");
    }
    for (name, bytes) in &files {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("written");
        let frames = Series::open(&[path], &Reading::default()).map(Iterator::count);
        assert!(frames.is_ok(), "{name}: {frames:?}");
    }
    let count = std::env::var("ONSET_MUTATIONS")
        .ok()
        .and_then(|count| count.parse().ok());
    let count: usize = count.unwrap_or(20_000);
    let end = count
        .eq(&20_000)
        .then(|| Instant::now() + Duration::from_secs(15));
    let reading = Reading::default();
    let mut random = Random(1);
    let (mut answered, mut refused) = (0, 0);
    for _ in 0..count {
        if end.is_some_and(|end| Instant::now() > end) {
            break;
        }
        let (name, bytes) = &files[random.below(files.len())];
        let path = folder.path().join(name);
        let bytes = damaged_file(bytes, name.ends_with(".gz"), &mut random);
        std::fs::write(&path, &bytes).expect("written");
        let start = Instant::now();
        let outcome = Series::open(&[path], &reading)
            .and_then(|series| series.collect::<Result<Vec<_>, _>>());
        match outcome {
            Ok(frames) => {
                answered += 1;
                for frame in frames {
                    let count = frame.position.len();
                    assert!(frame.identity.is_none_or(|ids| ids.len() == count));
                    assert!(frame.stress.is_none_or(|stress| stress.len() == count));
                }
            }
            Err(error) => {
                refused += 1;
                assert!(error.to_string().len() < 4000);
            }
        }
        let time = start.elapsed();
        assert!(
            time < Duration::from_secs(5),
            "{name} took {time:?}: {bytes:?}"
        );
    }
    println!("{answered} damaged files were read, {refused} refused");
    assert!(answered > 0 && refused > 0);
}
