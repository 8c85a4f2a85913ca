//! Reports of `catoptric compare` as they are sent to other people: one file, tables, crops, another's reference.

use crate::workplace::{Workplace, files};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use catoptric::framebuffer::Framebuffer;
use catoptric::picture;
use serde_json::Value;

const SMALL: [&str; 6] = ["--size", "32x24", "--samples", "1", "--frames", "1"];

/// Compares in the report's folder `report`.
fn compare(place: &Workplace, more: &[&str]) -> String {
    place.ok(&[&["compare", "scene.toml", "--report", "report"], &SMALL[..], more].concat())
}

/// The pictures in a page, as they come from its text.
fn pictures_in(page: &str) -> Vec<Vec<u8>> {
    let parts = page.split("data:image/png;base64,").skip(1);
    parts.map(|part| BASE64_STANDARD.decode(part.split('"').next().unwrap()).unwrap()).collect()
}

fn read(place: &Workplace, png: &[u8]) -> Framebuffer {
    place.write("embedded.png", png);
    picture::read(&place.path("embedded.png")).unwrap()
}

/// The part of a text between two others.
fn between<'a>(text: &'a str, from: &str, to: &str) -> &'a str {
    let start = text.find(from).unwrap_or_else(|| panic!("no {from}"));
    text[start..].split(to).next().unwrap()
}

/// The part of the page's table that has a method.
fn row_of<'a>(page: &'a str, method: &str) -> &'a str {
    let mut rows = between(page, "<tbody>", "</tbody>").split("<tr");
    let name = method.replace('_', "_<wbr>");
    rows.find(|row| row.contains(&format!(">{name}<"))).unwrap_or_else(|| panic!("no row of {method}"))
}

#[test]
fn a_report_is_one_file_that_names_no_folder() {
    let place = Workplace::new();
    // Shells need quotes around this folder.
    let folder = place.folder.path().canonicalize().unwrap().join("it's deep");
    std::fs::create_dir(&folder).unwrap();
    std::fs::copy(place.path("scene.toml"), folder.join("scene.toml")).unwrap();
    let (scene, report) = (folder.join("scene.toml"), folder.join("report"));
    let views = format!("light_field:views={}", folder.join("none.toml").display());
    let words = ["compare", scene.to_str().unwrap(), "--report", report.to_str().unwrap()];
    place.ends(1, &[&words, &SMALL[..], &["--method", "environment_map", "--method", &views]].concat());
    assert_eq!(files(&report), ["report.html", "report.json"]);
    let [page, json] = ["html", "json"].map(|kind| place.text(&format!("it's deep/report/report.{kind}")));
    for text in [&page, &json] {
        assert!(!text.contains("deep") && text.contains("scene.toml") && text.contains("none.toml"));
    }
    assert_eq!(place.json("it's deep/report/report.json")[0]["scene"], "scene.toml");
    assert!(page.contains("<title>catoptric: methods on scene.toml</title>"));

    // The reference, the method, and where they differ; the reference is that of `render`.
    let pictures = pictures_in(&page);
    assert_eq!(pictures.len(), 3);
    for png in &pictures {
        let found = read(&place, png);
        assert_eq!((found.width, found.height), (32, 24));
    }
    place.ok(&[&["render", "scene.toml", "--method", "reference", "-o", "truth.png"], &SMALL[..]].concat());
    assert_eq!(pictures[0], place.bytes("truth.png"));
}

#[test]
fn columns_without_values_are_left_out_and_the_reference_has_a_row() {
    let place = Workplace::new();
    let all =
        ["FLIP reflectors", "drawn by", "FLIP picture", "RMSE picture", "px p50", "missing", "frame ms", "speed-up"];
    let said = compare(&place, &["--diffuse", "*", "--method", "environment_map"]);
    let shown = all.map(|heading| said.lines().next().unwrap().contains(heading));
    assert_eq!(shown, [false, false, true, true, false, false, true, true], "{said}");
    assert!(said.lines().nth(1).is_some_and(|row| row.starts_with("reference ") && row.ends_with("1.00×")), "{said}");
    let page = place.text("report/report.html");
    let head = between(&page, "<thead>", "</thead>");
    assert!(head.contains("Whole picture") && !head.contains("Reflectors") && !head.contains("Projection"), "{head}");
    assert!(row_of(&page, "reference").contains("1.00×"));
    // Each column is explained.
    let legend = between(&page, "<dl class=\"legend\">", "</dl>");
    for name in ["Speed-up: a frame", "Time, ms: a frame", "Whole picture: FLIP mean"] {
        assert!(legend.contains(name), "{name} in {legend}");
    }
    // The reference was not asked for: programs get what they always got.
    assert_eq!(place.json("report/report.json").as_array().unwrap().len(), 1);
}

#[test]
fn pictures_that_cannot_be_used_are_never_the_best() {
    let place = Workplace::new();
    let said = compare(&place, &["--method", "planar_mirror", "--method", "environment_map"]);
    assert!(said.contains("planar_mirror: the picture is mostly black"), "{said}");
    let report = place.json("report/report.json");
    assert_eq!(report[0]["unusable"], "mostly black");
    assert!(report[1]["unusable"].is_null());
    let page = place.text("report/report.html");
    let stars = |method: &str| row_of(&page, method).matches(" best").count();
    assert!(stars("planar_mirror") == 0 && stars("environment_map") > 5 && stars("reference") == 0);
    assert!(between(&page, "<dl class=\"legend\">", "</dl>").contains("black in over half"));
}

/// Every channel of the reference is the method's and a quarter: that is the root mean square difference.
#[test]
fn methods_are_measured_against_the_pictures_of_others() {
    let place = Workplace::new();
    let draw = |method: &str, output: &str| {
        place
            .ok(&[&["render", "scene.toml", "--exposure", "0", "--method", method, "-o", output], &SMALL[..]].concat());
    };
    draw("path_perturbation", "own.exr");
    draw("path_perturbation", "own.png");
    let mut other = picture::read(&place.path("own.exr")).unwrap();
    other.pixels.iter_mut().for_each(|pixel| pixel[..3].iter_mut().for_each(|value| *value += 0.25));
    picture::write(&place.path("other.exr"), &other).unwrap();

    let against = |name: &str, more: &[&str]| {
        let words = ["--exposure", "0", "--reference", name, "--method", "path_perturbation"];
        let said = compare(&place, &[&words, more].concat());
        (said, place.json("report/report.json"), place.text("report/report.html"))
    };
    let (said, report, page) = against("other.exr", &[]);
    for part in ["image", "reflector"] {
        let rmse = report[0]["error"][part]["rmse"].as_f64().unwrap();
        assert!((rmse - 0.25).abs() < 1e-6, "{part}: {rmse}");
    }
    assert!(report[0]["error"]["projection_px"].is_null() && report[0]["reference_ms"].is_null(), "{report}");
    assert_eq!(report[0]["reference_file"], "other.exr");
    assert!(said.contains("measured against other.exr") && !said.contains("speed-up"), "{said}");
    assert!(page.contains("measured against the picture <b>other.exr</b>"));
    assert_eq!(report.as_array().unwrap().len(), 1);

    // The picture that `render` writes as .png differs in nothing; the reference is a method where it is wanted.
    let (said, report, _) = against("own.png", &["--method", "reference"]);
    for key in ["flip_mean", "rmse", "over_0_1"] {
        assert_eq!(report[0]["error"]["image"][key], 0.0, "{key}");
    }
    assert!(report[1]["method"] == "reference" && report[1]["speedup"] == 1.0, "{report}");
    assert!(said.contains("speed-up") && said.lines().any(|line| line.starts_with("reference ")), "{said}");

    let words = ["compare", "scene.toml", "--report", "report", "--method", "environment_map", "--reference"];
    let message = place.fails(1, &[&words[..], &["own.exr", "--size", "40x24"]].concat());
    assert!(message.contains("32x24") && message.contains("40x24") && message.contains("--size"), "{message}");
    other.pixels[33][1] = f32::NAN;
    picture::write(&place.path("broken.exr"), &other).unwrap();
    let message = place.fails(1, &[&words[..], &["broken.exr"], &SMALL].concat());
    assert!(message.contains("broken.exr") && message.contains("1, 1 is not finite"), "{message}");
    for wrong in [["--exposure", "auto"], ["--projection-every", "2"], ["--set", "reference.seed=1"]] {
        let message = place.fails(2, &[&words[..], &["own.png"], &SMALL, &wrong].concat());
        assert!(message.contains(wrong[0]), "{message}");
    }
}

/// Records of RFC 4180: fields in quotes may have commas, line ends and doubled quotes in them.
fn records(text: &str) -> Vec<Vec<String>> {
    let (mut records, mut record, mut field, mut is_quoted) = (Vec::new(), Vec::new(), String::new(), false);
    let mut rest = text.chars().peekable();
    while let Some(c) = rest.next() {
        match c {
            '"' if is_quoted && rest.peek() == Some(&'"') => field.extend(rest.next()),
            '"' => is_quoted = !is_quoted,
            ',' if !is_quoted => record.push(std::mem::take(&mut field)),
            '\r' if !is_quoted => {
                assert_eq!(rest.next(), Some('\n'), "lines end with both");
                record.push(std::mem::take(&mut field));
                records.push(std::mem::take(&mut record));
            }
            c => field.push(c),
        }
    }
    assert!(record.is_empty() && field.is_empty() && !is_quoted, "the last line ends, too");
    records
}

#[test]
fn tables_are_written_for_spreadsheets_and_papers() {
    let place = Workplace::new();
    let methods = ["--method", "path_perturbation", "--method", "environment_map:parallax=box,size=32"];
    let said = compare(&place, &[&methods[..], &["--csv", "t.csv", "--latex", "t.tex"]].concat());
    assert!(said.contains("t.csv") && said.contains("t.tex"), "{said}");
    let report = place.json("report/report.json");
    let table = records(&place.text("t.csv"));
    assert!(table.iter().all(|row| row.len() == table[0].len()) && table.len() == 4, "{table:?}");
    let cell = |row: usize, key: &str| table[row][table[0].iter().position(|name| name == key).unwrap()].clone();
    for (row, entry) in [(2, &report[0]), (3, &report[1])] {
        assert_eq!(Value::from(cell(row, "method")), entry["label"]);
        let expected = [
            ("frame_ms", &entry["frame_ms"]["median"]),
            ("speedup", &entry["speedup"]),
            ("reflector_flip_mean", &entry["error"]["reflector"]["flip_mean"]),
            ("rmse", &entry["error"]["image"]["rmse"]),
        ];
        for (key, value) in expected {
            assert_eq!(cell(row, key).parse::<f64>().ok(), value.as_f64(), "{key} of row {row}");
        }
    }
    assert!(cell(1, "method") == "reference" && cell(1, "rmse") == "0" && cell(3, "projection_px_p50").is_empty());

    let latex = place.text("t.tex");
    let columns = between(&latex, "{l", "}").len() - 1;
    let lines: Vec<&str> = latex.lines().filter(|line| line.ends_with("\\\\")).collect();
    assert_eq!(lines.len(), 5, "{latex}");
    assert!(lines[1..].iter().all(|line| line.matches('&').count() == columns - 1), "{latex}");
    assert!(lines[4].starts_with("environment\\_map:parallax=box,size=32 & ") && latex.contains("\\textbf{"));
    assert!(!latex.contains(['–', '×', '★']));
}

#[test]
fn a_crop_of_all_pictures_is_shown_side_by_side() {
    let place = Workplace::new();
    let more = ["--method", "environment_map", "--method", "path_perturbation", "--crop", "12,6,10,8", "--pictures"];
    compare(&place, &more);
    let page = place.text("report/report.html");
    let crops = pictures_in(between(&page, "<section class=\"crop\"", "</section>"));
    let all = pictures_in(&page);
    let pixels = |png: &[u8]| read(&place, png);
    // Reference, then both methods: pixel by pixel what the whole pictures have there.
    for (crop, whole) in crops.iter().zip([&all[0], &all[1], &all[3]]) {
        let (crop, whole) = (pixels(crop), pixels(whole));
        assert_eq!((crop.width, crop.height), (10, 8));
        for (x, y) in [(0, 0), (9, 0), (4, 5), (9, 7)] {
            assert_eq!(crop.pixel(x, y), whole.pixel(x + 12, y + 6));
        }
    }
    let figure = picture::read(&place.path("report/crop.png")).unwrap();
    assert_eq!((crops.len(), figure.width, figure.height), (3, 34, 8));
    assert_eq!(figure.pixel(24, 3), pixels(&crops[2]).pixel(0, 3));
    assert_eq!(place.bytes("report/environment_map.png"), all[1]);
    let captions = between(&page, "<section class=\"crop\"", "</section>");
    assert!(captions.contains("environment_map</figcaption>") && captions.contains("reference</figcaption>"));

    let words = ["compare", "scene.toml", "--report", "other", "--crop"];
    for outside in ["24,0,9,8", "0,17,8,8", "4294967295,0,1,1"] {
        let message = place.fails(2, &[&words[..], &[outside], &SMALL].concat());
        assert!(message.contains("--crop") && message.contains("32x24"), "{message}");
    }
    assert!(!place.path("other").exists());
}

#[test]
fn reports_replace_their_own_files_and_no_input() {
    let place = Workplace::new();
    let method = ["--method", "environment_map"];
    compare(&place, &[&method[..], &["--pictures", "--crop", "0,0,4,4"]].concat());
    let separate = ["crop.png", "environment_map-flip.png", "environment_map.png", "error_time.svg", "reference.png"];
    assert_eq!(files(&place.path("report"))[..5], separate);
    // The page finds nothing in the folder: it can be sent alone.
    assert!(!place.text("report/report.html").contains("src=\"environment_map.png\""));
    let before = place.bytes("report/reference.png");
    let words = [&["compare", "scene.toml", "--report", "report"], &SMALL[..], &method].concat();
    for (more, problem) in [
        (["--reference", "report/reference.png"], "measure against"),
        (["--csv", "report/report.html"], "two outputs"),
        (["--latex", "scene.toml"], "is read, too"),
        (["--csv", "none/t.csv"], "none/t.csv"),
    ] {
        let output = place.run(&[&words[..], &more].concat());
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success() && message.contains(problem), "{message}");
    }
    assert_eq!(place.bytes("report/reference.png"), before);

    place.write("report/mine.png", "mine");
    compare(&place, &method);
    assert_eq!(files(&place.path("report")), ["mine.png", "report.html", "report.json"]);
    // A file of that name is of no report any more.
    place.write("report/environment_map.png", "mine");
    let message = place.fails(2, &[&words[..], &["--pictures"]].concat());
    assert!(message.contains("environment_map.png") && message.contains("of no report"), "{message}");
    compare(&place, &method);
    assert_eq!(place.bytes("report/environment_map.png"), b"mine");
}
