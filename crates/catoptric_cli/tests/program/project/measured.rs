//! `catoptric project` as a tool of measurement: cameras as matrices, what hides points, grids, JSON lines.

use super::{Place, number};
use serde_json::{Value, json};

/// A camera that looks along -z from (0.2, 1.1, 4), turned by 0.3 about its axis, with a skew and a principal point
/// off the middle: the numbers of [`seen_by_formula`].
fn camera() -> Value {
    let (sine, cosine) = 0.3f64.sin_cos();
    // x to the right, y down, z forward.
    let rotation = [[cosine, -sine, 0.0], [-sine, -cosine, 0.0], [0.0, 0.0, -1.0]];
    let eye = [0.2, 1.1, 4.0];
    let translation = rotation.map(|row| -row.iter().zip(eye).map(|(a, b)| a * b).sum::<f64>());
    json!({
        "width": 640, "height": 480,
        "K": [[500.0, 3.0, 300.0], [0.0, 520.0, 250.0], [0.0, 0.0, 1.0]],
        "R": rotation, "t": translation.map(|number| [number]),
    })
}

/// OpenCV's projection, written out: pixels of which the first has its middle at 0, 0.
fn seen_by_formula([x, y, z]: [f64; 3]) -> [f64; 2] {
    let (sine, cosine) = 0.3f64.sin_cos();
    let [x, y, depth] = [x - 0.2, y - 1.1, 4.0 - z];
    let (right, down) = ((x * cosine - y * sine) / depth, (-x * sine - y * cosine) / depth);
    [500.0 * right + 3.0 * down + 300.0, 520.0 * down + 250.0]
}

/// The columns of each row, by name.
fn rows(place: &Place, names: &[&str]) -> Vec<Vec<String>> {
    let (header, rows) = place.table();
    let columns: Vec<usize> =
        names.iter().map(|name| header.iter().position(|column| column == name).unwrap()).collect();
    rows.iter().map(|row| columns.iter().map(|column| row[*column].clone()).collect()).collect()
}

#[test]
fn cameras_are_those_of_opencv() {
    let place = Place::new("x,y,z\n0.5,1,0\n0,1,9\n");
    let formula = |name: &str, camera: &Value| {
        place.workplace.write(name, camera.to_string());
        place.ok(&["--method", "exact", "--camera", name, "--direct", "--ignore-visibility"]);
        let rows = rows(&place, &["kinds", "x1", "y1", "z1", "image_x", "image_y", "in_picture"]);
        let direct = rows.iter().find(|row| row[0].is_empty()).unwrap();
        let bounce = rows.iter().find(|row| row[0] == "R").unwrap();
        let at = [1, 2, 3].map(|column| number(&bounce[column]));
        for (row, at) in [(direct, [0.5, 1.0, 0.0]), (bounce, at)] {
            for (column, expected) in [4, 5].into_iter().zip(seen_by_formula(at)) {
                assert!((number(&row[column]) - expected - 0.5).abs() < 1e-9, "{name}: {row:?}, {expected}");
            }
            let [x, y] = seen_by_formula(at).map(|pixel| pixel + 0.5);
            let is_within = (0.0..640.0).contains(&x) && (0.0..480.0).contains(&y);
            assert_eq!(row[6] == "1", is_within, "{name}: {row:?}");
        }
        // The second point is behind the eye.
        let behind = rows.iter().rfind(|row| row[0].is_empty()).unwrap();
        assert_eq!([&behind[4], &behind[6]], ["", "0"]);
    };
    formula("camera.json", &camera());
    // The written file is the same camera, and its matrix alone is, by any factor.
    place.ok(&["--method", "exact", "--camera", "camera.json", "--write-camera", "written.json"]);
    let written = place.workplace.json("written.json");
    for (key, tolerance) in [("K", 1e-9), ("R", 1e-12)] {
        for (row, expected) in written[key].as_array().unwrap().iter().zip(camera()[key].as_array().unwrap()) {
            for (found, expected) in row.as_array().unwrap().iter().zip(expected.as_array().unwrap()) {
                assert!((found.as_f64().unwrap() - expected.as_f64().unwrap()).abs() < tolerance, "{key} {row}");
            }
        }
    }
    formula("whole.json", &written);
    let matrix: Vec<Vec<f64>> = serde_json::from_value(written["P"].clone()).unwrap();
    for factor in [-2.5, 1e105, 1e-105] {
        let scaled: Vec<Vec<f64>> = matrix.iter().map(|row| row.iter().map(|x| x * factor).collect()).collect();
        formula("matrix.json", &json!({ "width": 640, "height": 480, "P": scaled, "dist": [[0, 0, 0, 0]] }));
    }
}

#[test]
fn cameras_that_are_none_are_refused_by_key() {
    let place = Place::new("x,y,z\n0.5,1,0\n");
    let faults = [
        (json!({ "K": [[2, 0, 1], [0, -2, 1], [0, 0, 1]] }), "K must be [[fx, s, cx], [0, fy, cy], [0, 0, 1]]"),
        (json!({ "R": [[1, 0, 0], [0, 1, 0], [0, 0, -1]] }), "R must be a rotation"),
        (json!({ "R": null }), "one of them is missing"),
        (json!({ "dist": [0.1, 0, 0, 0] }), "lens distortion is not supported; undistort"),
        (json!({ "P": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]] }), "P is not K [R | t]"),
        (json!({ "width": null, "height": null }), "no width and height: add them, or give --size"),
        (json!({ "width": null }), "width and height belong together"),
        (json!({ "K": [[1, 0], [0, 1]] }), "K must be 3 rows of 3 numbers"),
        (json!({ "t": ["a", 0, 0] }), "t must be made of finite numbers"),
        (json!({ "t": [0, 1e12, 0] }), "the eye is not within 1e9 of the origin"),
        (json!({ "tvec": [0, 0, 0] }), "unknown field `tvec`"),
        (json!({ "K": null, "R": null, "t": null }), "it has neither K, R and t nor P"),
    ];
    for (change, said) in faults {
        let mut camera = camera();
        camera.as_object_mut().unwrap().extend(change.as_object().unwrap().clone());
        place.workplace.write("bad.json", camera.to_string());
        let message = place.fails(1, &["--camera", "bad.json", "--method", "exact"]);
        assert!(message.contains("bad.json: ") && message.contains(said), "{message}");
    }
    place.workplace.write("camera.json", camera().to_string());
    place.workplace.write("scene.csv", "");
    for (words, said) in [
        (&["--camera", "camera.json"][..], "leave out --method"),
        (&["--method", "exact", "--camera", "camera.json", "--fov", "40"], "--fov: the camera's file says it"),
        (&["--method", "exact", "--write-camera", "new.json"], "--write-camera needs the picture's --size"),
        (&["--method", "exact", "--camera", "camera.json", "--write-camera", "camera.json"], "both --camera and"),
        (&["--size", "8x8", "--write-camera", "new.txt"], "must end in .json"),
        (&["-o", "scene.csv", "--size", "8x8", "--set", "views=scene.csv"], "scene.csv: is a file that is read, too"),
    ] {
        assert!(place.fails(2, words).contains(said), "{words:?}");
    }
}

#[test]
fn walls_hide_points_and_are_named() {
    // Behind the wall at z = -4, in front of it, and on it.
    let place = Place::new("x,y,z\n0.5,1,-5\n0.5,1,0\n0.5,1,-4\n");
    let said = place.ok(&["--direct", "--reflector", "floor*"]);
    assert!(said.contains("3 reflections") && said.contains("2 points in direct sight"), "{said}");
    let expected = [
        ["0", "", "0", "wall"],
        ["0", "R", "0", "wall"],
        ["1", "", "1", ""],
        ["1", "R", "1", ""],
        ["2", "", "1", ""],
        ["2", "R", "1", ""],
    ];
    assert_eq!(rows(&place, &["point", "kinds", "visible", "blocked_by"]), expected);
    // A ball of glass hides, too; its own paths are not asked for.
    let scene = place.workplace.text("scene.toml");
    let ball = "[[reflector]]\nname = \"ball\"\nsurface = \"sphere\"\ncenter = [0.25, 1, 2]\nradius = 0.3\nior = 1.5\n";
    place.workplace.write("scene.toml", scene.replace("[role]", &format!("{ball}[role]")));
    place.ok(&["--direct", "--only", "floor*", "--method", "exact"]);
    let found = rows(&place, &["point", "kinds", "blocked_by"]);
    assert_eq!(found[2], ["1", "", "ball"], "{found:?}");
}

#[test]
fn only_limits_and_reflector_makes() {
    let place = Place::new("x,y,z\n1,2,0\n");
    let names = |words: &[&str]| {
        place.ok(&[&["--method", "exact"], words].concat());
        rows(&place, &["path"]).concat()
    };
    assert_eq!(names(&["--reflector", "wall"]), ["wall"]);
    assert_eq!(names(&["--reflector", "wall", "--only", "ceiling"]), ["ceiling"]);
    let mut all = names(&["--reflector", "wall", "--only", "*"]);
    all.sort_unstable();
    assert_eq!(all, ["ceiling", "floor, \"wet\"", "wall"]);
    let message = Place::new("x,y,z\n").fails(1, &["--method", "exact", "--only", "cieling"]);
    assert!(message.contains("--only cieling: matches no object or material (did you mean `ceiling`?)"), "{message}");
}

#[test]
fn grids_cover_surfaces_evenly_however_they_are_divided() {
    let place = Place::new("");
    let board = "[[object]]\nname = \"board\"\nshape = \"quad\"\nsize = [1, 0.5]\ncenter = [0.25, 1.25, -1]\n";
    let scene = place.workplace.text("scene.toml");
    place.workplace.write("scene.toml", scene.replace("[role]", &format!("{board}[role]")));
    place.ok(&["--points", "grid:board:0.125", "--direct", "--only", "floor*", "--method", "exact"]);
    let found: Vec<[f64; 3]> = rows(&place, &["kinds", "point_x", "point_y", "point_z"])
        .iter()
        .filter(|row| row[0].is_empty())
        .map(|row| [1, 2, 3].map(|column| number(&row[column])))
        .collect();
    // The middles of 8 x 4 squares from (-0.25, 1) on.
    let mut sorted: Vec<[f64; 3]> = found.clone();
    sorted.sort_by(|a, b| a.partial_cmp(b).unwrap());
    let expected: Vec<[f64; 3]> = (0..32)
        .map(|index| [-0.25 + (f64::from(index / 4) + 0.5) * 0.125, 1.0 + (f64::from(index % 4) + 0.5) * 0.125, -1.0])
        .collect();
    assert_eq!(sorted, expected);
    std::fs::remove_file(place.workplace.path("out.csv")).unwrap();
    // Faces at an even angle to two axes, however their triangles lie, and exact surfaces, which hide no point of
    // their own that faces the eye.
    let turned = "[[object]]\nname = \"turned\"\nshape = \"box\"\nsize = [1, 1, 1]\nrotation_deg = [0, 45, 0]\n\
                  [[reflector]]\nname = \"ball\"\nsurface = \"sphere\"\ncenter = [0.5, 1.25, -1]\nradius = 0.25\n";
    place.workplace.write("scene.toml", scene.replace("[role]", &format!("{turned}[role]")));
    place.ok(&["--points", "grid:turned:0.0625", "--direct", "--only", "floor*", "--method", "exact"]);
    let count = rows(&place, &["kinds"]).iter().filter(|row| row[0].is_empty()).count();
    // Two level faces of 16 x 16 cells, and four that are seen at 45 degrees: 11.3 x 16.
    assert!((1190..=1270).contains(&count), "{count}");
    place.ok(&["--points", "grid:ball:0.02", "--direct", "--only", "floor*", "--method", "exact"]);
    let found = rows(&place, &["kinds", "visible", "point_x", "point_y", "point_z"]);
    let mut counts = [0, 0];
    for row in found.iter().filter(|row| row[0].is_empty()) {
        let [x, y, z] = [2, 3, 4].map(|column| number(&row[column]));
        let normal = [x - 0.5, y - 1.25, z + 1.0];
        let length = normal.iter().map(|part| part * part).sum::<f64>().sqrt();
        assert!((length - 0.25).abs() < 1e-9, "{length}");
        let to_eye = [-x, 1.0 - y, 4.0 - z];
        let facing = normal.iter().zip(to_eye).map(|(a, b)| a * b).sum::<f64>() / length;
        if facing.abs() > 0.02 {
            assert_eq!(row[1] == "1", facing > 0.0, "{row:?}");
            counts[usize::from(facing > 0.0)] += 1;
        }
    }
    assert!(counts.iter().all(|count| *count > 300), "{counts:?}");
    std::fs::remove_file(place.workplace.path("out.csv")).unwrap();
    place.workplace.write("scene.toml", scene.replace("[role]", &format!("{board}[role]")));
    for (words, said) in [
        (&["--points", "grid:board:9"][..], "no cell of this size has its middle on it"),
        (&["--points", "grid:bord:0.1"], "no node or material `bord` (did you mean `board`?)"),
        (&["--points", "grid:board:1e-4"], "the step is too small: there are more than 4000000 points"),
        (&["--points", "grid:board:1e-9"], "the step is too small: it makes more than 50000000 cells"),
        (&["--points", "grid:board:0"], "the step of a grid must be a number from 1e-9 to 1e9"),
        (&["--points", "grid:board"], "grid:NODE:STEP, such as grid:board:0.01"),
    ] {
        let code = if said.starts_with("no node") { 1 } else { 2 };
        assert!(place.fails(code, words).contains(said), "{words:?}");
    }
}

#[test]
fn lines_of_json_have_the_values_of_tables() {
    let place = Place::new("x,y,z\n0.5,1,0\n-1,0.25,1\n");
    place.ok(&["--direct", "--size", "64x48", "--order", "2"]);
    let (header, rows) = place.table();
    place.workplace.write("in.jsonl", "{\"x\": 0.5, \"name\": \"a\", \"y\": 1, \"z\": 0}\n\n[-1, 0.25, 1.0]\n");
    place.ok(&["--direct", "--size", "64x48", "--order", "2", "--points", "in.jsonl", "-o", "out.jsonl"]);
    let text = place.workplace.text("out.jsonl");
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert!(lines.len() == rows.len() && rows.len() > 6, "{rows:?}");
    for (line, row) in lines.iter().zip(&rows) {
        for (name, cell) in header.iter().zip(row) {
            let found = match &line[name] {
                Value::Null => String::new(),
                Value::String(text) => text.clone(),
                number => number.to_string(),
            };
            let numbers = found.parse::<f64>().ok().zip(cell.parse::<f64>().ok());
            assert!(found == *cell || numbers.is_some_and(|(one, other)| one == other), "{name}: {found} and {cell}");
        }
    }
    for (text, said) in [("[1, 2]", "line 1: a point is"), ("[1,2,3]\n{\"x\": 1e13, \"y\": 0, \"z\": 0}", "line 2: ")] {
        let place = Place::new("");
        place.workplace.write("in.jsonl", text);
        assert!(place.fails(1, &["--points", "in.jsonl"]).contains(said));
    }
}
