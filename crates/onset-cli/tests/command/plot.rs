//! `onset plot`.

use super::{Scratch, onset};

#[test]
fn a_path_that_is_not_a_store_is_refused() {
    let answer = onset(&["plot", "nowhere.zarr"]);
    assert_eq!(answer.code, Some(2));
    assert!(
        answer.stderr.contains("there is no store at nowhere.zarr"),
        "{}",
        answer.stderr
    );
    let folder = Scratch::new("plot");
    std::fs::create_dir_all(&folder).expect("a folder");
    std::fs::write(folder.join("notes.txt"), "no store").expect("a file");
    let answer = onset(&["plot", &folder.display().to_string()]);
    assert_eq!(answer.code, Some(2));
    assert!(
        answer.stderr.contains("is not a store") && answer.stderr.contains("the folder of a map"),
        "{}",
        answer.stderr
    );
    assert_eq!(onset(&["plot"]).code, Some(2));
}

#[test]
fn an_unknown_figure_format_is_refused_before_any_work() {
    let answer = onset(&["plot", "nowhere.zarr", "--out", "map.eps"]);
    assert_eq!(answer.code, Some(2));
    assert!(
        answer.stderr.contains("SVG, PNG and PDF"),
        "{}",
        answer.stderr
    );
}

#[test]
fn an_impossible_figure_layout_is_refused() {
    for (option, wrong, told) in [
        ("--size", "420", "width and height"),
        ("--size", "1,1", "from 40 to 4000"),
        ("--x-limits", "2,1", "LOW below HIGH"),
        ("--y-limits", "0,nan", "LOW,HIGH"),
        ("--limits", "a,b", "LOW,HIGH"),
        ("--color-map", "jet", "viridis, cividis, grey, red-blue"),
    ] {
        let answer = onset(&["plot", "nowhere.zarr", option, wrong]);
        assert_eq!(answer.code, Some(2), "{option}");
        assert!(answer.stderr.contains(told), "{option}: {}", answer.stderr);
    }
    let both = onset(&["plot", "nowhere.zarr", "--trace", "--no-trace"]);
    assert_eq!(both.code, Some(2));
}

#[test]
fn a_map_is_drawn_as_pdf_svg_and_png() {
    let folder = Scratch::new("pdf");
    std::fs::create_dir_all(&folder).expect("a folder");
    let study = folder.join("study.toml");
    let text = "[[axes]]\nquantity = 'stretch-1'\nrange = [0.8, 3.2]\nstates = 12\n\
         [[axes]]\nquantity = 'stretch-2'\nrange = [0.8, 3.2]\nstates = 12\n";
    std::fs::write(&study, text).expect("a file");
    let path = |name: &str| folder.join(name).display().to_string();
    let made = onset(&[
        "map",
        &path("study.toml"),
        "--out",
        &path("a.zarr"),
        "--quiet",
    ]);
    assert_eq!(made.code, Some(0), "{}", made.stderr);
    let figure = path("figure.pdf");
    let line = [
        "plot",
        &path("a.zarr"),
        "--title",
        "A map",
        "--out",
        &figure,
    ];
    let answer = onset(&line);
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    for name in ["figure.svg", "figure.png", "figure.pdf"] {
        assert!(answer.stdout.contains(name), "{}", answer.stdout);
    }
    let pdf = std::fs::read(figure).expect("a figure");
    assert!(pdf.starts_with(b"%PDF-"));
    let svg = std::fs::read_to_string(folder.join("figure.svg")).expect("a figure");
    assert!(svg.contains("A map"));
}

#[test]
fn boundaries_that_are_edges_of_cells_are_reported() {
    let folder = Scratch::new("edges");
    std::fs::create_dir_all(&folder).expect("a folder");
    // An axis varies the method, so that the boundaries are not traced by default.
    let text = "[[axes]]\nquantity = 'stretch-1'\nrange = [0.8, 3.2]\nstates = 4\n\
         [[axes]]\nquantity = 'discretization.support'\nrange = [1.5, 2.5]\nstates = 4\n";
    std::fs::write(folder.join("study.toml"), text).expect("a file");
    let path = |name: &str| folder.join(name).display().to_string();
    let store = path("a.zarr");
    let made = onset(&["map", &path("study.toml"), "--out", &store, "--quiet"]);
    assert_eq!(made.code, Some(0), "{}", made.stderr);
    let figure = path("figure.pdf");
    let plot = ["plot", &store, "--out", &figure];
    let told = |line: &[&str]| {
        let answer = onset(line);
        answer.stdout + &answer.stderr
    };
    let (traced, asked) = (told(&plot), told(&[&plot[..], &["--no-trace"]].concat()));
    assert!(traced.contains("edges of the map's cells"), "{traced}");
    assert!(traced.contains("--trace"), "{traced}");
    assert!(!asked.contains("edges of"), "{asked}");
}
