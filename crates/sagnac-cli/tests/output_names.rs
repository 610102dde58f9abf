//! A model is written as .toml, a page as .html: another ending is refused with what to write instead.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use std::fs;

use common::{refused, said};

#[test]
fn endings_that_belong_to_another_file_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let model = "name = \"part\"\n[gyro.noise]\nangle_random_walk = \"0.3 deg/sqrt(h)\"\n";
    fs::write(at.join("m.toml"), model).unwrap();
    said(
        at,
        &[
            "simulate", "m.toml", "--rest", "10s", "--rate", "100Hz", "-o", "good.csv",
        ],
    );
    for (line, words) in [
        (
            "characterize good.csv -o q.svg",
            "a model cannot be written as q.svg -o name the model q.toml; \
             for a picture: sagnac allan LOG -o F.svg; every plot: --report F.html",
        ),
        (
            "characterize good.csv -o q.html",
            "a model cannot be written as q.html -o name it q.toml",
        ),
        (
            "characterize good.csv --report q.toml",
            "a page cannot be written as q.toml --report name it q.html",
        ),
        (
            "characterize good.csv --report q.PNG",
            "name it q.html: it has every plot",
        ),
        (
            "compare good.csv --with m.toml --report q.csv",
            "name it q.html",
        ),
        ("grade m.toml --report q.svg", "name it q.html"),
        ("drift m.toml --report q.json", "name it q.html"),
        ("explain m.toml --report q.json", "name it q.html"),
        ("catalog list --report q.json", "name it q.html"),
        (
            "calibrate thermal good.csv -o q.png",
            "name the model q.toml",
        ),
        (
            "calibrate multi-position good.csv -o q.csv",
            "name it q.toml",
        ),
        ("calibrate merge m.toml m.toml -o q.csv", "name it q.toml"),
        ("import x.yaml -o q.yaml", "name it q.toml"),
    ] {
        let words_of: Vec<&str> = line.split(' ').collect();
        let text = refused(at, &words_of, 2);
        assert!(text.contains(words), "{line}: {text}");
    }
    for line in [
        "characterize good.csv -o plain --report PAGE.HTML",
        "characterize good.csv -o q.TOML",
        "characterize good.csv -o unit_2.5",
        #[cfg(target_os = "linux")]
        "characterize good.csv -o /dev/null --report /dev/stdout",
    ] {
        said(at, &line.split(' ').collect::<Vec<_>>());
    }
    for name in ["plain", "PAGE.HTML", "unit_2.5"] {
        assert!(at.join(name).exists(), "{name}");
    }
}
