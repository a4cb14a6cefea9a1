//! Frames of runs of LAMMPS, PySPH and a finite element code, and tables written by users.

use flate2::{Compression, write::GzEncoder};
use onset_frames::{Format, Frame, FrameError, Quantity, Reading, Series};
use std::io::Write;
use std::path::{Path, PathBuf};

fn data(name: &str) -> PathBuf {
    Path::new("tests/data").join(name)
}

fn open(name: &str) -> Series {
    Series::open(&[data(name)], &Reading::default()).expect("a series")
}

fn all(series: Series) -> Vec<Frame> {
    series.map(|frame| frame.expect("a frame")).collect()
}

fn written(folder: &tempfile::TempDir, name: &str, text: impl AsRef<[u8]>) -> PathBuf {
    let path = folder.path().join(name);
    std::fs::write(&path, text).expect("written");
    path
}

fn refused(path: PathBuf, reading: &Reading) -> String {
    let outcome =
        Series::open(&[path], reading).and_then(|series| series.collect::<Result<Vec<_>, _>>());
    outcome.expect_err("refused").to_string()
}

#[test]
fn a_lammps_dump_gives_stresses_digits_and_times() {
    let reading = Reading {
        time_step: Some(0.1),
        ..Reading::default()
    };
    let series = Series::open(&[data("tl-healthy.dump.gz")], &reading).expect("a series");
    assert_eq!(series.recognized().format, Format::Lammps);
    assert_eq!(series.recognized().digits, Some(6));
    let frames = all(series);
    assert_eq!(frames.len(), 3);
    assert!(frames.iter().all(|frame| frame.len() == 392));
    assert_eq!(frames[0].position[1], [0.0, 1.0, 0.0]);
    assert_eq!(frames[0].kind.as_ref().expect("types")[0], 2);
    assert_eq!(
        frames[2].stress_given,
        [true, true, true, true, false, false]
    );
    let (time, step) = (
        frames[2].time.expect("a time"),
        frames[2].step.expect("a step"),
    );
    assert!((time - 0.1 * step as f64).abs() < 1e-12 && step > 0);
    let bounds = frames[0].bounds.expect("a box");
    assert_eq!((bounds.low[0], bounds.high[0]), (-3.0, 30.0));
    assert_eq!(bounds.periodic, [false, false, true]);
}

#[test]
fn gradients_of_a_dump_are_reported_with_their_assumed_order() {
    let series = open("notch-step.dump.gz");
    assert_eq!(series.recognized().digits, Some(9));
    let columns = &series.recognized().columns;
    let gradient = columns
        .iter()
        .filter(|own| own.quantity == Some(Quantity::Gradient));
    assert!(gradient.clone().all(|own| own.order_is_assumed));
    assert_eq!(gradient.count(), 9);
    let frames = all(series);
    let gradients = frames[2].gradient.as_ref().expect("gradients");
    assert_eq!(gradients[5], [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
}

#[test]
fn an_archive_of_numpy_has_frames_as_first_axis_and_static_arrays() {
    let series = open("pysph-tension.npz");
    let times: Vec<Option<f64>> = series.times().map(|(time, _)| time).collect();
    assert!(times.windows(2).all(|pair| pair[0] < pair[1]));
    let frames = all(series);
    assert_eq!((frames.len(), frames[0].len()), (3, 400));
    let last = &frames[2];
    assert_eq!(last.reference, frames[0].reference);
    assert_ne!(last.position, frames[0].position);
    assert_eq!(last.stress_given, [true, true, false, true, false, false]);
    assert!(last.velocity.is_some() && last.density.is_some() && last.held.is_some());
}

#[test]
fn positions_that_never_change_are_reference_positions() {
    let series = open("fem-tension.pvd");
    assert_eq!(series.recognized().assumed.len(), 1);
    let frames = all(series);
    assert_eq!((frames.len(), frames[0].len()), (3, 325));
    let last = &frames[2];
    assert_eq!(last.time, Some(255.0));
    let (reference, displacement) = (
        last.reference.as_ref().expect("a reference"),
        last.displacement.as_ref().expect("displacements"),
    );
    assert_eq!(
        reference,
        frames[0].reference.as_ref().expect("a reference")
    );
    for ((x, big_x), u) in last.position.iter().zip(reference).zip(displacement) {
        assert_eq!(x[0], big_x[0] + u[0]);
    }
    let cells = last.cells.as_ref().expect("elements");
    assert_eq!((cells.len(), cells.points(0).len()), (288, 4));
    assert_eq!(cells.gradient.as_ref().expect("gradients").len(), 288);
}

#[test]
fn all_encodings_of_vtk_give_the_same_frame() {
    let read = |name: &str| {
        let mut frames = all(open(name));
        frames[0].source = Default::default();
        frames.remove(0)
    };
    let frame = read("meshio-ascii.vtu");
    assert_eq!(frame.position[3], [1.0, 1.0, 0.5]);
    assert_eq!(
        frame.velocity.as_ref().expect("velocities")[3],
        [2.0, 2.0, 1.0]
    );
    let cells = frame.cells.as_ref().expect("cells");
    assert_eq!(cells.gradient.as_ref().expect("gradients")[0][5], 5.0);
    assert_eq!(read("meshio-base64.vtu"), frame);
    assert_eq!(read("meshio-zlib.vtu"), frame);
}

#[test]
fn appended_binary_data_are_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut bytes = b"<?xml version=\"1.0\"?><VTKFile type=\"PolyData\" byte_order=\"LittleEndian\" header_type=\"UInt64\"><PolyData>\
        <FieldData><DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">2.5</DataArray></FieldData>\
        <Piece NumberOfPoints=\"2\" NumberOfVerts=\"0\"><PointData><DataArray type=\"Float32\" Name=\"rho\" format=\"appended\" offset=\"56\"/></PointData>\
        <Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"appended\" offset=\"0\"/></Points></Piece></PolyData>\
        <AppendedData encoding=\"raw\">_".to_vec();
    bytes.extend(48u64.to_le_bytes());
    bytes.extend(
        [1.0f64, 2.0, 3.0, 4.0, 5.0, 6.0]
            .iter()
            .flat_map(|x| x.to_le_bytes()),
    );
    bytes.extend(8u64.to_le_bytes());
    bytes.extend([0.5f32, 0.25].iter().flat_map(|x| x.to_le_bytes()));
    bytes.extend(b"</AppendedData></VTKFile>");
    let path = written(&folder, "a.vtp", bytes);
    let frames = all(Series::open(&[path], &Reading::default()).expect("a series"));
    assert_eq!(frames[0].time, Some(2.5));
    assert_eq!(frames[0].position, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    assert_eq!(frames[0].density, Some(vec![0.5, 0.25]));
}

/// Frame of a dump with wrapped or scaled coordinates.
fn dump(step: u64, names: &str, row: &str) -> String {
    format!(
        "ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS pp pp pp\n0 10\n0 20\n-1 1\nITEM: ATOMS {names}\n{row}\n"
    )
}

#[test]
fn scaled_and_wrapped_positions_are_converted_with_the_box() {
    let folder = tempfile::tempdir().expect("a folder");
    let read = |text: String| {
        let path = written(&folder, "a.dump", text);
        all(Series::open(&[path], &Reading::default()).expect("a series")).remove(0)
    };
    let scaled = read(dump(0, "id xs ys zs", "1 0.5 0.25 0.5"));
    assert_eq!(
        (scaled.position[0], scaled.may_be_wrapped),
        ([5.0, 5.0, 0.0], true)
    );
    let images = read(dump(0, "id x y z ix iy iz", "1 1 2 0 1 -1 0"));
    assert_eq!(
        (images.position[0], images.may_be_wrapped),
        ([11.0, -18.0, 0.0], false)
    );
    let unwrapped = read(dump(0, "id x y z xu yu zu", "1 1 2 0 11 2 0"));
    assert_eq!(
        (unwrapped.position[0], unwrapped.may_be_wrapped),
        ([11.0, 2.0, 0.0], false)
    );
}

#[test]
fn frames_of_compressed_text_are_read_in_order_of_time() {
    let folder = tempfile::tempdir().expect("a folder");
    let text: String = [7, 2, 5, 2]
        .map(|step| dump(step, "id x y", &format!("1 {step} 0")))
        .concat();
    let mut packed = GzEncoder::new(Vec::new(), Compression::fast());
    packed.write_all(text.as_bytes()).expect("compressed");
    let path = written(&folder, "a.dump.gz", packed.finish().expect("compressed"));
    let series = Series::open(&[path], &Reading::default()).expect("a series");
    // One frame repeats a time, and the frames are sorted.
    assert_eq!(series.recognized().ignored.len(), 2);
    let frames = all(series);
    let steps: Vec<f64> = frames.iter().map(|frame| frame.position[0][0]).collect();
    assert_eq!(steps, [2.0, 5.0, 7.0]);
}

#[test]
fn a_dump_that_is_still_written_ends_with_its_last_complete_frame() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = dump(0, "id x y", "1 0.5 0") + &dump(1, "id x y", "1 0.625 0");
    for cut in 1..40 {
        let path = written(&folder, "a.dump", &text[..text.len() - cut]);
        let series = Series::open(&[path], &Reading::default()).expect("a series");
        assert!(!series.recognized().ignored.is_empty());
        assert_eq!(all(series).len(), 1, "cut {cut}");
    }
}

#[test]
fn an_archive_with_a_changed_byte_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let whole = std::fs::read(data("stored.npz")).expect("an archive");
    let numbers = 1.0_f64.to_le_bytes();
    let place = whole.windows(8).position(|bytes| bytes == numbers);
    let mut changed = whole.clone();
    changed[place.expect("a one") + 6] ^= 1;
    let told = refused(written(&folder, "a.npz", changed), &Reading::default());
    assert!(told.contains("the checksum of an array is wrong"), "{told}");
}

#[test]
fn a_wrong_checksum_is_found_if_reading_ends_early() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["stored.npz", "pysph-tension.npz"] {
        let mut bytes = std::fs::read(data(name)).expect("an archive");
        let mut whole = open(name);
        whole.frame(0).expect("the first frame");
        whole.check_rest().expect("an undamaged archive");
        assert!(whole.all(|frame| frame.is_ok()), "frames after the check");
        // The list of members has the checksum 30 bytes before the name.
        let member = b"position.npy";
        let place = bytes.windows(member.len()).rposition(|own| own == member);
        bytes[place.expect("a member") - 30] ^= 1;
        let path = written(&folder, name, bytes);
        let mut series = Series::open(&[path], &Reading::default()).expect("a series");
        series.frame(0).expect("the first frame");
        let error = series.check_rest().expect_err("a wrong checksum");
        let told = error.to_string();
        assert!(told.contains("the checksum of an array is wrong"), "{told}");
    }
}

#[test]
fn a_truncated_grid_is_refused_and_a_list_of_grids_is_reported() {
    let folder = tempfile::tempdir().expect("a folder");
    let grid = std::fs::read_to_string(data("meshio-ascii.vtu")).expect("a grid");
    for place in ["<PointData>", "<CellData>", "</Piece>", "</VTKFile>"] {
        let cut = grid.find(place).expect("a place");
        let told = refused(written(&folder, "a.vtu", &grid[..cut]), &Reading::default());
        assert!(told.contains("the end of `VTKFile`"), "{place}: {told}");
    }
    let list = std::fs::read_to_string(data("small.pvd")).expect("a list");
    written(&folder, "meshio-ascii.vtu", &grid);
    let second = list.find("meshio-zlib").expect("the second file");
    let (head, tail) = list.split_at(list.rfind("DataSet").expect("a tag"));
    for damaged in [
        &list[..second],
        &format!("{head}dataset{}", &tail[7..]),
        &format!("{}{tail}", &head[..head.len() - 1]),
    ] {
        let path = written(&folder, "a.pvd", damaged);
        let series = Series::open(&[path], &Reading::default()).expect("a series");
        assert!(series.recognized().ignored[0].contains("is cut off or damaged"));
        assert_eq!(all(series).len(), 1);
    }
}

#[test]
fn rows_of_a_table_are_sorted_into_frames() {
    let folder = tempfile::tempdir().expect("a folder");
    let table = "\u{feff}id;time;x [mm];y [mm];Fxx;Fxy;Fyx;Fyy\n1;0;0;0;1;0;0;1\n1;1;0.5;0;2;0;0;1\n2;0;1;0;1;0;0;1\n2;1;1.5;0;2;3;0;1\n";
    let path = written(&folder, "a.csv", table);
    let mut series = Series::open(&[path], &Reading::default()).expect("a series");
    let frame = series.frame(1).expect("a frame");
    assert_eq!((frame.time, frame.dimensions), (Some(1.0), 2));
    assert_eq!(frame.identity, Some(vec![1, 2]));
    assert_eq!(frame.position, [[0.5, 0.0, 0.0], [1.5, 0.0, 0.0]]);
    assert_eq!(
        frame.gradient.as_ref().expect("gradients")[1],
        [2.0, 3.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
    );
    assert!(!frame.gradient_given[8]);
}

#[test]
fn a_table_whose_times_begin_again_is_refused_with_the_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let rows = "0,1,0,0\n0,2,1,0\n1,1,0,0\n1,2,1,0\n";
    let path = written(&folder, "a.csv", format!("time,id,x,y\n{rows}{rows}"));
    let mut series = Series::open(&[path], &Reading::default()).expect("a series");
    let error = series.frame(0).expect_err("two rows of a particle");
    let error = error.to_string();
    assert!(
        error.contains(
            "line 6: a time that was already written begins again, with particle 1 a second time"
        ),
        "{error}"
    );
}

#[test]
fn named_columns_replace_guesses_and_similar_names_are_listed() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = written(&folder, "a.csv", "n,a,b,x,y\n4,1,2,0,0\n");
    let reading = Reading::default()
        .with_columns("x=a,b,id=n")
        .expect("columns");
    let frames = all(Series::open(std::slice::from_ref(&path), &reading).expect("a series"));
    assert_eq!(frames[0].position, [[1.0, 2.0, 0.0]]);
    assert_eq!(frames[0].identity, Some(vec![4]));
    let reading = Reading::default()
        .with_columns("stress=c")
        .expect("columns");
    let error = refused(path, &reading);
    assert!(
        error.contains("no column c for stress")
            && error.ends_with("the file has 5 columns, `n`, `a`, `b`, `x`, `y`"),
        "{error}"
    );
    let path = written(&folder, "b.csv", "SECRET one,xpos_1,SECRET two\n4,1,2\n");
    let error = refused(path, &Reading::default());
    assert!(
        error.contains("the file has 3 columns, among them `xpos_1`") && !error.contains("SECRET"),
        "{error}"
    );
}

#[test]
fn ranges_of_frames_are_slices() {
    let reading = |range: &str| Reading {
        frames: range.parse().expect("a range"),
        ..Reading::default()
    };
    let count = |range: &str| {
        let series = Series::open(&[data("tl-healthy.dump.gz")], &reading(range));
        series.map(|series| all(series).len())
    };
    assert_eq!(count("1:").ok(), Some(2));
    assert_eq!(count("::2").ok(), Some(2));
    assert_eq!(count("-1:").ok(), Some(1));
    assert!(matches!(count("5:"), Err(FrameError::Request { .. })));
    assert!("1:2:0".parse::<onset_frames::FrameRange>().is_err());
}

#[test]
fn particles_are_reordered_and_differences_are_reported() {
    let mut frame = Frame {
        identity: Some(vec![5, 3, 9, 3]),
        position: vec![[5.0; 3], [3.0; 3], [9.0; 3], [4.0; 3]],
        ..Frame::default()
    };
    let order = frame.in_order_of(&[3, 4, 5]);
    assert_eq!(
        (order.missing, order.new, order.doubled),
        (vec![4], vec![9], vec![3])
    );
    assert_eq!(frame.position, [[3.0; 3], [5.0; 3]]);
}

#[test]
fn counts_beyond_the_file_are_refused_before_memory_is_reserved() {
    let folder = tempfile::tempdir().expect("a folder");
    let hostile = dump(0, "id x y", "1 0 0").replace("ATOMS\n1\n", "ATOMS\n900000000000000\n");
    assert!(
        refused(written(&folder, "a.dump", hostile), &Reading::default()).contains("the limit is")
    );
    let grid = std::fs::read_to_string(data("meshio-zlib.vtu")).expect("a grid");
    let hostile = grid.replace("NumberOfPoints=\"4\"", "NumberOfPoints=\"19999999\"");
    assert!(
        refused(written(&folder, "a.vtu", hostile), &Reading::default())
            .contains("59999997 numbers")
    );
}

#[test]
fn pickled_arrays_and_other_formats_are_refused_with_a_hint() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut pickled = b"\x93NUMPY\x01\x00".to_vec();
    let header = "{'descr': '|O', 'fortran_order': False, 'shape': (3,), }\n";
    pickled.extend((header.len() as u16).to_le_bytes());
    pickled.extend(header.as_bytes());
    pickled.extend([0; 24]);
    let error = refused(written(&folder, "a.npy", pickled), &Reading::default());
    assert!(
        error.contains("pickled objects") && error.contains("HDF5"),
        "{error}"
    );
    let error = refused(
        written(&folder, "a.vtk", "# vtk DataFile Version 3.0\n"),
        &Reading::default(),
    );
    assert!(error.contains("legacy"), "{error}");
    let error = refused(
        written(&folder, "a.bin", b"\x89BIN\r\n\x1a\n\0\0"),
        &Reading::default(),
    );
    assert!(error.contains("binary"), "{error}");
    #[cfg(unix)]
    assert!(refused("/dev/zero".into(), &Reading::default()).contains("not a regular file"));
}

#[test]
fn an_unsupported_type_of_positions_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    for (described, size) in [("<f2", 2), ("<c16", 16), ("<U5", 20)] {
        let mut array = b"\x93NUMPY\x01\x00".to_vec();
        let header =
            format!("{{'descr': '{described}', 'fortran_order': False, 'shape': (2, 3, 2), }}\n");
        array.extend((header.len() as u16).to_le_bytes());
        array.extend(header.as_bytes());
        array.extend(vec![0; 12 * size]);
        let error = refused(written(&folder, "a.npy", array), &Reading::default());
        assert!(
            error.contains(&format!(
                "the type {described} of `position` is not supported"
            )),
            "{error}"
        );
    }
}

#[test]
fn files_of_two_formats_are_refused_with_both_names() {
    let folder = tempfile::tempdir().expect("a folder");
    let paths = [
        written(&folder, "a.csv", "n,x,y\n4,1,2\n"),
        data("small.npz"),
    ];
    let error = Series::open(&paths, &Reading::default()).expect_err("a refusal");
    let error = error.to_string();
    assert!(
        error.contains("has the format table") && error.contains("the format NumPy arrays"),
        "{error}"
    );
}

#[test]
fn unsupported_formats_are_named_in_the_error() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, start, told) in [
        ("run.h5", &b"\x89HDF\r\n\x1a\n"[..], "HDF5"),
        ("run.dump.zst", &b"\x28\xb5\x2f\xfd"[..], "zstd"),
    ] {
        let path = written(&folder, name, [start, &[0; 64]].concat());
        assert!(refused(path, &Reading::default()).contains(told));
    }
}

#[test]
fn extended_xyz_has_properties_times_and_a_box() {
    let folder = tempfile::tempdir().expect("a folder");
    let frame = |time: f64, x: f64| {
        format!(
            "2\nLattice=\"10 0 0 0 10 0 0 0 1\" Properties=species:S:1:pos:R:3:velo:R:3:id:I:1:F:R:9 Time={time} pbc=\"F F T\"\n\
             A {x} 0.5 0 1 2 0 7 1 0.1 0 0 1 0 0 0 1\nB 1.25 0.5 0 1 2 0 3 1 0 0 0.2 1 0 0 0 1\n"
        )
    };
    let text = frame(0.0, 0.25) + &frame(0.5, 0.375) + "2\nProperties=pos:R:3 Time=1\n1 1 1\n";
    let path = written(&folder, "run.xyz", text);
    let series = Series::open(&[path], &Reading::default()).expect("a series");
    assert_eq!(series.recognized().format, Format::Xyz);
    assert_eq!(series.recognized().digits, Some(3));
    assert!(series.recognized().ignored[0].contains("cut off"));
    let frames = all(series);
    assert_eq!(frames.len(), 2);
    let last = &frames[1];
    assert_eq!(
        (last.time, last.position[0]),
        (Some(0.5), [0.375, 0.5, 0.0])
    );
    assert_eq!(last.identity.as_deref(), Some(&[7, 3][..]));
    assert_eq!(
        last.velocity.as_ref().expect("velocities")[1],
        [1.0, 2.0, 0.0]
    );
    assert_eq!(last.gradient.as_ref().expect("gradients")[0][1], 0.1);
    assert_eq!(last.bounds.expect("a box").periodic, [false, false, true]);
    let path = written(&folder, "bad2.xyz", "1\nProperties=pos:R:x\n1 1 1\n");
    assert!(refused(path, &Reading::default()).contains("Properties=NAME:TYPE:NUMBER"));
}

#[test]
fn data_sets_of_hdf5_have_frames_as_their_first_axis() {
    let series = open("series.h5");
    let recognized = series.recognized().clone();
    assert_eq!(recognized.format, Format::Hdf5);
    assert_eq!(recognized.digits, Some(7));
    assert!(
        recognized
            .ignored
            .iter()
            .any(|text| text.contains("run/name"))
    );
    let frames = all(series);
    assert_eq!(frames.len(), 4);
    for (n, frame) in frames.iter().enumerate() {
        let stretch = 1.0 + 0.01 * n as f64;
        assert_eq!(frame.time, Some(0.5 * n as f64));
        assert!((frame.position[8][0] - 2.0 * stretch).abs() < 1e-6);
        let reference = frame.reference.as_ref().expect("reference positions");
        assert_eq!(reference[8], [2.0, 2.0, 0.0]);
        let gradient = frame.gradient.as_ref().expect("gradients");
        let held = frame.held.as_ref().expect("held particles");
        assert_eq!(held[..4], [true, false, false, true]);
        assert_eq!(frame.identity.as_ref().expect("numbers")[..2], [8, 7]);
        assert!((gradient[0][0] - stretch).abs() < 1e-12 && gradient[0][1] == 0.0);
    }
    // A data set can be named by its path, too.
    let reading = Reading::default();
    let reading = reading
        .with_columns("x=run/reference time=time")
        .expect("columns");
    let series = Series::open(&[data("series.h5")], &reading).expect("a series");
    assert_eq!(all(series)[3].position[8], [2.0, 2.0, 0.0]);
}

#[test]
fn a_file_without_known_names_is_refused_with_its_arrays_and_the_option() {
    let path = data("unnamed.h5");
    let error =
        Series::open(std::slice::from_ref(&path), &Reading::default()).expect_err("no positions");
    let told = error.to_string();
    for part in [
        "unnamed.h5: no positions found, expected an array of numbers with the shape (particles, D) or (frames, particles, D)",
        "hint: name it, for example --columns x=NAME; the file has the arrays `coords_of_points` (3 x 4 x 2)",
        "not arrays of numbers: `comment`",
    ] {
        assert!(told.contains(part), "{part}: {told}");
    }
    let named = Reading::default()
        .with_columns("x=coords_of_points")
        .expect("columns");
    let series = Series::open(std::slice::from_ref(&path), &named).expect("a series");
    assert_eq!(series.times().len(), 3);
}

#[test]
fn hdf5_files_of_pysph_are_read_as_frames_of_one_body() {
    let reading = Reading {
        time_step: Some(0.1),
        ..Reading::default()
    };
    let series = Series::open(&[data("square_*.hdf5")], &reading).expect("a series");
    let recognized = series.recognized().clone();
    assert_eq!(recognized.digits, None);
    assert!(
        recognized
            .ignored
            .iter()
            .any(|text| text.contains("`wall`"))
    );
    let frames = all(series);
    let times: Vec<f64> = frames.iter().filter_map(|frame| frame.time).collect();
    assert_eq!(times, [0.5, 1.0, 10.5]);
    let last = &frames[2];
    assert_eq!(last.len(), 9);
    assert!((last.position[8][0] - 2.0 * 1.105).abs() < 1e-12);
    assert_eq!(last.velocity.as_ref().expect("velocities")[8][0], 0.02);
    // The stress is the deviator minus the pressure.
    let stress = last.stress.as_ref().expect("stresses")[8];
    assert!((stress[0] - (0.2 - 0.5)).abs() < 1e-12);
    let wall = Reading {
        group: Some("wall".to_owned()),
        ..reading
    };
    let series = Series::open(&[data("square_5.hdf5")], &wall).expect("a series");
    assert_eq!(all(series)[0].len(), 3);
}

#[test]
fn a_byte_order_mark_is_skipped_and_other_encodings_are_refused_by_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let dump = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS ff ff pp\n0 9\n0 9\n0 1\nITEM: ATOMS id x y z\n1 2 3 0\n";
    let texts = [
        ("a.dump", dump),
        ("a.csv", "time,id,x,y\n0,1,2,3\n"),
        ("a.xyz", "1\nProperties=id:I:1:pos:R:3 Time=0\n1 2 3 0\n"),
    ];
    for (name, text) in texts {
        let path = written(&folder, name, format!("\u{feff}{text}"));
        let frames = all(Series::open(&[path], &Reading::default()).expect("a series"));
        assert_eq!(frames[0].position, [[2.0, 3.0, 0.0]], "{name}");
        let wide: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
        let of_four: Vec<u8> = text
            .chars()
            .flat_map(|c| (c as u32).to_le_bytes())
            .collect();
        for (bytes, told) in [
            ([b"\xff\xfe", &wide[..]].concat(), "it is UTF-16"),
            (wide, "it is UTF-16"),
            ([b"\xff\xfe\0\0", &of_four[..]].concat(), "it is UTF-32"),
            (text.replace('\n', "\r").into_bytes(), "carriage returns"),
        ] {
            let error = refused(written(&folder, name, bytes), &Reading::default());
            assert!(error.contains(told), "{name}: {error}");
        }
    }
}
