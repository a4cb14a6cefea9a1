use onset_fit::*;
fn test(name: &str, mode: Mode) -> Test {
    let text = std::fs::read_to_string(format!("../../rubber/{name}-{}.csv", mode.name())).unwrap();
    let points = text
        .lines()
        .skip(3)
        .map(|l| {
            let (a, b) = l.split_once(',').unwrap();
            Point {
                stretch: a.trim().parse().unwrap(),
                lateral: None,
                stress: b.trim().parse().unwrap(),
            }
        })
        .collect();
    Test {
        name: mode.name().into(),
        mode,
        points,
        weight: 1.0,
    }
}
#[test]
fn try_it() {
    for data in ["treloar"] {
        let tests: Vec<Test> = Mode::LOADINGS.into_iter().map(|m| test(data, m)).collect();
        for weights in [Weights::Absolute, Weights::Relative(0.0)] {
            for name in std::env::var("LAWS").unwrap().split(',') {
                let family = Family::named(name).unwrap();
                let t = std::time::Instant::now();
                match fit(
                    &tests,
                    &family,
                    &Options {
                        weights,
                        ..Options::default()
                    },
                ) {
                    Ok(f) => println!(
                        "{data} {weights:?} {name}: free {:.7} stable {:.7} cost {:.5} {:?} worst {:?} {:?} others {} {:.2?}",
                        f.free.loss,
                        f.result().loss,
                        f.result().loss / f.free.loss,
                        f.proof,
                        f.result()
                            .worst
                            .as_ref()
                            .map(|w| (w.criterion, w.value, w.stretches)),
                        f.free
                            .limits
                            .first()
                            .map(|l| (l.mode, l.criterion, l.stretch)),
                        f.others.len(),
                        t.elapsed()
                    ),
                    Err(e) => println!("{name}: {e}"),
                }
            }
        }
    }
}
