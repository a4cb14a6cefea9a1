//! `onset plot`.

use super::{fresh_place, onset};

#[test]
fn what_is_no_store_is_refused() {
    let answer = onset(&["plot", "nowhere.zarr"]);
    assert_eq!(answer.code, Some(2));
    assert!(
        answer.stderr.contains("there is no store at nowhere.zarr"),
        "{}",
        answer.stderr
    );
    let folder = fresh_place("plot");
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
fn a_figure_of_another_format_is_refused_before_any_work() {
    let answer = onset(&["plot", "nowhere.zarr", "--out", "map.pdf"]);
    assert_eq!(answer.code, Some(2));
    assert!(answer.stderr.contains("SVG and PNG"), "{}", answer.stderr);
}
