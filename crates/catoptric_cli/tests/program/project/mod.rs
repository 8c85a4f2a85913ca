//! `catoptric project` as its users meet it: tables in, tables out, messages.

mod measured;

use crate::workplace::Workplace;
use std::fmt::Write as _;

/// Two mirrors that face each other across the z axis, and a glass ball that no path of theirs needs.
const SCENE: &str = r#"
[camera]
eye = [0, 1, 4]
target = [0, 0.5, 0]
fov_deg = 45
[[reflector]]
name = "floor, \"wet\""
surface = "plane"
center = [0, 0, 0]
normal = [0, 1, 0]
size = [8, 8]
[[reflector]]
name = "ceiling"
surface = "plane"
center = [0, 3, 0]
normal = [0, -1, 0]
size = [8, 8]
[[reflector]]
name = "wall"
surface = "plane"
center = [0, 1.5, -4]
normal = [0, 0, 1]
size = [8, 3]
[role]
wall = "diffuse"
"#;

/// A workplace with a table of points.
struct Place {
    workplace: Workplace,
}

impl Place {
    fn new(points: &str) -> Self {
        let workplace = Workplace::with_scene(SCENE);
        workplace.write("in.csv", points);
        Self { workplace }
    }

    /// The arguments of the program: `more`, and defaults for what that leaves out.
    fn words<'a>(more: &[&'a str]) -> Vec<&'a str> {
        let words = ["project", "scene.toml", "--points", "in.csv", "-o", "out.csv", "--method", "planar_mirror"];
        // Later words stand for earlier ones.
        let mut all: Vec<&str> = Vec::new();
        for pair in words[2..].chunks(2).filter(|pair| !more.contains(&pair[0])) {
            all.extend(pair);
        }
        [&words[..2], &all, more].concat()
    }

    fn ok(&self, more: &[&str]) -> String {
        self.workplace.ok(&Self::words(more))
    }

    /// Runs the program, which must end with this exit code and write nothing, and gives its message.
    fn fails(&self, code: i32, more: &[&str]) -> String {
        let message = self.workplace.fails(code, &Self::words(more));
        let mut left = self.workplace.files();
        left.retain(|name| name.starts_with("out") || name.starts_with('.'));
        assert!(left.is_empty(), "{more:?} left {left:?}");
        message
    }

    /// Writes `in.npy` as numpy.save does.
    fn write_array(&self, kind: &str, order: &str, shape: &str, numbers: &[u8]) {
        let mut text = format!("{{'descr': '{kind}', 'fortran_order': {order}, 'shape': ({shape}), }}");
        text += &" ".repeat(117 - text.len());
        text += "\n";
        let mut bytes = b"\x93NUMPY\x01\x00v\x00".to_vec();
        bytes.extend(text.as_bytes());
        bytes.extend(numbers);
        self.workplace.write("in.npy", bytes);
    }

    /// The header and the rows of the output.
    fn table(&self) -> (Vec<String>, Vec<Vec<String>>) {
        let mut reader = csv::Reader::from_path(self.workplace.path("out.csv")).unwrap();
        let header = reader.headers().unwrap().iter().map(String::from).collect();
        let rows = reader.records().map(|row| row.unwrap().iter().map(String::from).collect()).collect();
        (header, rows)
    }
}

fn number(cell: &str) -> f64 {
    cell.parse().unwrap()
}

const EYE: [&str; 2] = ["--eye", "-1,1.25,2"];

#[test]
fn reflections_are_where_the_mirrored_points_are_seen() {
    let place = Place::new("name,z,x,y\nfirst,0,1,2\n\nbelow,0,1,-1\nthird, -1.5 ,0.25,1e0\n");
    let said =
        place.ok(&[&EYE[..], &["--order", "2", "--size", "400x300", "--target", "0,0,0", "--jacobian"]].concat());
    assert!(said.contains("3 points, 8 reflections, 1 points without any, 0 points"), "{said}");
    let (header, rows) = place.table();
    let expected = "point,kinds,path,focal_index,path_length,residual,image_x,image_y,x1,y1,z1,x2,y2,z2,\
                    j11,j12,j13,j21,j22,j23,j31,j32,j33,visible,in_picture,blocked_by";
    assert_eq!(header.join(","), expected);
    assert_eq!(rows.iter().map(|row| row[0].as_str()).collect::<String>(), "00002222");
    // The images of the first point in the floor, the ceiling, and both in either order; the shortest path first.
    let (eye, point) = ([-1.0, 1.25, 2.0], [1.0, 2.0, 0.0]);
    let floor = "floor, \"wet\"";
    let images = [
        ("R", "ceiling".into(), 4.0),
        ("R", floor.to_owned(), -2.0),
        ("RR", format!("{floor}>ceiling"), -4.0),
        ("RR", format!("ceiling>{floor}"), 8.0),
    ];
    let length = |height: f64| (8.0 + (height - eye[1]).powi(2)).sqrt();
    for (row, (kinds, path, height)) in rows.iter().zip(&images) {
        assert_eq!((row[1].as_str(), row[2].as_str(), row[3].as_str()), (*kinds, path.as_str(), "0"));
        assert!((number(&row[4]) - length(*height)).abs() < 1e-14, "{row:?}");
        assert!(number(&row[5]) < 1e-14);
        assert_eq!(row[11].is_empty(), *kinds == "R", "{row:?}");
        // The bounce is where the line to the image meets the mirror.
        let plane = if *height > 0.0 { 3.0 } else { 0.0 };
        let share = (plane - eye[1]) / (height - eye[1]);
        for axis in [0, 2] {
            assert!((number(&row[8 + axis]) - (eye[axis] + share * (point[axis] - eye[axis]))).abs() < 1e-14);
        }
        assert!((number(&row[9]) - plane).abs() < 1e-15);
        // Sideways the bounce moves by the same share.
        assert!((number(&row[14]) - share).abs() < 1e-14 && number(&row[18]).abs() < 1e-15, "{row:?}");
    }
}

#[test]
fn pictures_are_those_of_the_camera() {
    let place = Place::new("x,y,z\n0.5,1,0\n");
    place.ok(&["--size", "640x480"]);
    let (_, rows) = place.table();
    // From the eye (0, 1, 4) the bounce (0.25, 0, 2) is at an angle to the axis towards (0, 0.5, 0).
    let axis = [0.0, -0.5, -4.0];
    let length = (0.25f64 + 16.0).sqrt();
    let (forward, up) = ([0.0, axis[1] / length, axis[2] / length], [0.0, 4.0 / length, -0.5 / length]);
    let step = [0.25, -1.0, -2.0];
    let dot = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let scale = 240.0 / (22.5f64.to_radians().tan() * dot(step, forward));
    let row = rows.iter().find(|row| row[9] == "0.0").unwrap();
    assert!((number(&row[6]) - (320.0 + step[0] * scale)).abs() < 1e-3, "{row:?}");
    assert!((number(&row[7]) - (240.0 - dot(step, up) * scale)).abs() < 1e-3, "{row:?}");
    // Without a size there is no picture.
    place.ok(&[]);
    assert!(place.table().1.iter().all(|row| row[6].is_empty() && row[7].is_empty()));
}

#[test]
fn limits_and_visibility() {
    let place = Place::new("x,y,z\n1,2,0\n");
    let names = |more: &[&str]| -> Vec<String> {
        place.ok(&[&EYE[..], more].concat());
        place.table().1.into_iter().map(|row| row[2].clone()).collect()
    };
    assert_eq!(names(&["--reflector", "ceil*", "--order", "3"]), ["ceiling"]);
    assert_eq!(names(&["--reflector", "ceiling", "--reflector", "floor*"]).len(), 2);
    // Diffuse objects do not block, glass does.
    let pane =
        "[[reflector]]\nname=\"pane\"\nsurface=\"plane\"\ncenter=[0,2.6,1]\nnormal=[1,0,0]\nsize=[8,0.7]\nior=1.5";
    place.workplace.write("scene.toml", SCENE.replace("[role]", &format!("{pane}\n[role]")));
    assert_eq!(names(&["--reflector", "ceil*"]), [""; 0]);
    assert_eq!(names(&["--reflector", "ceil*", "--ignore-visibility"]), ["ceiling"]);
    assert_eq!(names(&["--reflector", "ceil*", "--diffuse", "pane"]), ["ceiling"]);
    assert_eq!(names(&["--reflector", "floor*"]).len(), 1);
}

#[test]
fn negative_numbers_stand_with_and_without_an_equals_sign() {
    let place = Place::new("x,y,z\n-1,2,-0.5\n");
    place.ok(&EYE);
    let apart = place.workplace.text("out.csv");
    place.ok(&["--eye=-1,1.25,2"]);
    assert_eq!(apart, place.workplace.text("out.csv"));
    place.ok(&["--eye", "1,1.25,2"]);
    assert_ne!(apart, place.workplace.text("out.csv"));
}

#[test]
fn many_points_keep_their_order_on_any_number_of_threads() {
    let mut points = "x,y,z\n".to_owned();
    for index in 0..40_000 {
        let unit = |salt: u64| (index * 2_654_435_761 + salt * 40_503) % 10_007;
        writeln!(
            points,
            "{},{},{}",
            unit(1) as f64 / 5e3 - 1.0,
            unit(2) as f64 / 3.2e3 - 0.1,
            unit(3) as f64 / 5e3 - 1.0
        )
        .unwrap();
    }
    let place = Place::new(&points);
    place.ok(&[&EYE[..], &["--threads", "1"]].concat());
    let one = place.workplace.text("out.csv");
    place.ok(&[&EYE[..], &["--threads", "3"]].concat());
    assert!(one == place.workplace.text("out.csv"));
    let order: Vec<u64> = one.lines().skip(1).map(|line| line.split(',').next().unwrap().parse().unwrap()).collect();
    assert!(order.is_sorted() && order.len() > 1000);
    assert!(order.iter().any(|point| *point > 39_000), "the last chunk is missing");
}

#[test]
fn arrays_have_the_values_of_text() {
    let points = [[1.0f64, 2.0, 0.0], [0.25, 1.125, -0.75], [0.0, -5.0, 0.0]];
    let place = Place::new("x,y,z\n1,2,0\n0.25,1.125,-0.75\n0,-5,0\n");
    let options = [&EYE[..], &["--order", "2", "--jacobian"]].concat();
    place.ok(&options);
    let (header, rows) = place.table();
    let text = place.workplace.text("out.csv");
    std::fs::remove_file(place.workplace.path("out.csv")).unwrap();
    // In both precisions and byte orders.
    let flat = points.as_flattened();
    let numbers = |encode: &dyn Fn(f64) -> Vec<u8>| flat.iter().flat_map(|value| encode(*value)).collect::<Vec<u8>>();
    let little = numbers(&|value| value.to_le_bytes().to_vec());
    for (kind, numbers) in [
        ("<f8", little.clone()),
        (">f8", numbers(&|value| value.to_be_bytes().to_vec())),
        ("<f4", numbers(&|value| (value as f32).to_le_bytes().to_vec())),
        (">f4", numbers(&|value| (value as f32).to_be_bytes().to_vec())),
    ] {
        place.write_array(kind, "False", "3, 3", &numbers);
        place.ok(&[&options[..], &["--points", "in.npy"]].concat());
        assert!(text == place.workplace.text("out.csv"), "{kind}");
        std::fs::remove_file(place.workplace.path("out.csv")).unwrap();
    }
    // The same column by column.
    let columns: Vec<u8> = (0..9).flat_map(|at| little[(at % 3 * 3 + at / 3) * 8..][..8].to_vec()).collect();
    place.write_array("<f8", "True", "3, 3", &columns);
    place.ok(&[&options[..], &["--points", "in.npy"]].concat());
    assert!(text == place.workplace.text("out.csv"), "by columns");
    std::fs::remove_file(place.workplace.path("out.csv")).unwrap();
    place.write_array("<f8", "False", "3, 3", &little);
    place.ok(&[&options[..], &["--points", "in.npy", "-o", "out.npy"]].concat());
    let bytes = place.workplace.bytes("out.npy");
    std::fs::remove_file(place.workplace.path("out.npy")).unwrap();
    let start = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let described = std::str::from_utf8(&bytes[10..start]).unwrap();
    assert!(described.contains(&format!("'shape': ({},)", rows.len())), "{described}");
    // Names and kinds in turn.
    let words: Vec<&str> = described.split_once('[').unwrap().1.split('\'').skip(1).step_by(2).collect();
    let fields: Vec<(&str, usize)> =
        words.chunks_exact(2).take(header.len()).map(|field| (field[0], field[1][2..].parse().unwrap())).collect();
    assert_eq!(fields.iter().map(|field| field.0).collect::<Vec<_>>(), header);
    let width: usize = fields.iter().map(|field| field.1).sum();
    assert_eq!(bytes.len() - start, width * rows.len());
    for (row, bytes) in rows.iter().zip(bytes[start..].chunks_exact(width)) {
        let mut at = 0;
        for ((name, size), cell) in fields.iter().zip(row) {
            let bytes = &bytes[at..at + size];
            at += size;
            match *name {
                "point" | "focal_index" | "visible" => {
                    assert_eq!(u64::from_le_bytes(bytes.try_into().unwrap()).to_string(), *cell)
                }
                "kinds" | "path" | "blocked_by" => {
                    assert_eq!(String::from_utf8_lossy(bytes).trim_end_matches('\0'), cell)
                }
                name => {
                    let value = f64::from_le_bytes(bytes.try_into().unwrap());
                    let same = if cell.is_empty() { value.is_nan() } else { value == number(cell) };
                    assert!(same, "{name}: {value} against {cell}");
                }
            }
        }
    }
}

#[test]
fn broken_arrays_are_refused() {
    let little: Vec<u8> = (0..9).flat_map(|value| f64::from(value).to_le_bytes()).collect();
    let place = Place::new("");
    for (kind, order, shape, problem) in [
        ("<f8", "False", "9,", "must be N x 3, not 9"),
        ("<f8", "False", "1, 9", "must be N x 3, not 1 x 9"),
        ("<f8", "False", "4, 3", "row 3: the file ends early"),
        ("<f8", "False", "99999999999999, 3", "row 3: the file ends early"),
        ("<f8", "True", "4, 3", "row 1: the file ends early"),
        ("<c16", "False", "3, 3", "f4 or f8 or whole numbers"),
        ("<i3", "False", "3, 3", "f4 or f8 or whole numbers"),
        ("<f8", "Perhaps", "3, 3", "not that of an array"),
    ] {
        place.write_array(kind, order, shape, &little);
        let message = place.fails(1, &["--points", "in.npy"]);
        assert!(message.contains("in.npy: ") && message.contains(problem), "{kind} {order} {shape}: {message}");
    }
    place.write_array("<f8", "False", "1, 3", &[1.0, f64::NAN, 2.0].map(f64::to_le_bytes).concat());
    assert!(place.fails(1, &["--points", "in.npy"]).contains("row 0: y: `NaN` is not a finite number"));
    for broken in [&b"x,y,z"[..], b"x,y,z and more", b"\x93NUMPY\x02\x00\xff\xff\xff\xff{", b"\x93NUMPY\x09\x00v\x00"] {
        place.workplace.write("in.npy", broken);
        assert!(place.fails(1, &["--points", "in.npy"]).contains("in.npy: "));
    }
}

#[test]
fn tables_of_other_programs_are_read() {
    let place = Place::new("x,y,z\n1,2,0\n0.5,1,-1\n");
    place.ok(&EYE);
    let expected = place.workplace.text("out.csv");
    for points in [
        "X,Y,Z\n1,2,0\n0.5,1,-1\n",
        "1,2,0\n0.5,1,-1\n",
        "name;z;y;x\na;0;2;1\nb;-1;1;0.5\n",
        "1\t2\t0\n0.5\t1\t-1\n",
        "# x y z\n 1.0  2.0 0\n0.5 1e0   -1\n",
        "  x  y z\n 1 2   0\n# between\n.5 1 -1",
    ] {
        place.workplace.write("in.csv", points);
        place.ok(&EYE);
        assert!(place.workplace.text("out.csv") == expected, "{points:?}");
    }
    let whole: Vec<u8> = [1i16, 2, 0, -1, 1, -1].iter().flat_map(|value| value.to_be_bytes()).collect();
    place.write_array(">i2", "False", "2, 3", &whole);
    place.ok(&[&EYE[..], &["--points", "in.npy"]].concat());
    let of_whole = place.workplace.text("out.csv");
    place.workplace.write("in.csv", "x,y,z\n1,2,0\n-1,1,-1\n");
    place.ok(&EYE);
    assert!(place.workplace.text("out.csv") == of_whole);
}

#[test]
fn what_is_no_mirror_is_made_one() {
    let place = Place::new("x,y,z\n1,2,0\n");
    place.ok(&[&EYE[..], &["--reflector", "wall", "--method", "exact"]].concat());
    let rows = place.table().1;
    // The law of reflection in the plane z = -4: the eye is 6 before it, the point 4.
    assert_eq!((rows.len(), rows[0][2].as_str()), (1, "wall"));
    let at = [8, 9].map(|column| number(&rows[0][column]));
    assert!((at[0] - (-1.0 + 2.0 * 0.6)).abs() < 1e-9 && (at[1] - (1.25 + 0.75 * 0.6)).abs() < 1e-9, "{at:?}");
}

#[test]
fn wrong_tables_are_named_with_line_and_field() {
    for (points, named) in [
        ("x,y\n1,2\n", "line 1: the header has no column `z`; it needs x, y and z and has x,y"),
        ("", "no column `x`"),
        ("x,y,z,x\n1,2,3,4\n", "two columns `x`"),
        ("x,y,z\n1,2,3\n1,two,3\n", "line 3: y: `two` is not a number"),
        ("x,y,z\n1,2,nan\n", "line 2: z: `NaN` is not a finite number"),
        ("x,y,z\n\n\n1,-inf,3\n", "line 4: y: `-inf` is not a finite number"),
        ("\r\nx,y,z\r\n1,2,3\r\n\r\n1,2,a", "line 5: z: `a` is not a number"),
        ("x,y,z\n1e13,2,3\n", "line 2: x: 1e13 is not between"),
        ("x,y,z\n1,2\n", "line 2: z: the row has no such cell"),
        ("x,y,z\n1,,3\n", "line 2: y: `` is not a number"),
    ] {
        let message = Place::new(points).fails(1, &EYE);
        assert!(message.contains("in.csv: ") && message.contains(named), "{points:?} should say {named}: {message}");
    }
    let place = Place::new("x,y,z\n");
    assert!(place.ok(&EYE).contains("0 points, 0 reflections"));
    assert_eq!(place.table().1.len(), 0);
}

#[test]
fn wrong_usage_ends_with_2_and_wrong_input_with_1() {
    let place = Place::new("x,y,z\n1,2,0\n");
    let usage: [(&[&str], &str); 13] = [
        (&["--order", "0"], "1 to 4"),
        (&["--order", "5"], "1 to 4"),
        (&["--eye", "1,2"], "X,Y,Z"),
        (&["--eye", "1,2,nan"], "nan"),
        (&["--target", "1,2,3"], "--eye"),
        (&["--eye", "1,2,3", "--target", "1,2,3"], "same point"),
        (&["--method", "no_such"], "no_such"),
        (&["--method", "exact", "--set", "a=1"], "no settings"),
        (&["--set", "no_such=1"], "no_such"),
        (&["--points", "in.txt"], ".csv, .npy or .jsonl"),
        (&["-o", "out.txt"], ".csv, .npy or .jsonl"),
        (&["-o", "in.csv"], "both"),
        (&["--size", "64"], "WxH"),
    ];
    let input: [(&[&str], &str); 6] = [
        (&["--reflector", "no_such*"], "no_such*: matches no object or material; reflectors and lenses are: floor"),
        (&["--diffuse", "*"], "no object is a reflector"),
        (&["--points", "none.csv"], "none.csv"),
        (&["-o", "no/out.csv"], "no/out.csv"),
        (&["--camera", "no_such"], "no_such"),
        (&["--method", "environment_map"], "does not say where points appear"),
    ];
    for (code, faults) in [(2, &usage[..]), (1, &input)] {
        for (words, named) in faults {
            let message = place.fails(code, words);
            assert!(message.contains(named), "{words:?} should name {named}: {message}");
        }
    }
    assert!(place.ok(&[&EYE[..], &["--quiet"]].concat()).is_empty());
    assert!(place.ok(&["--help"]).contains("Example"));
}

#[test]
fn the_exact_search_finds_reflections_in_a_ball() {
    let scene = "[camera]\neye = [0, 0, 3]\ntarget = [0, 0, 0]\n[[reflector]]\nname = \"ball\"\n\
                 surface = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\n";
    // Eye and point as far from the centre: the bounce is on the line that halves the angle between them.
    let place = Place::new("x,y,z\n0,3,0\n3,0,0\n0,0.5,0\n");
    place.workplace.write("scene.toml", scene);
    let more = ["--method", "exact", "--eye", "0,0,3", "--target", "0,0,0", "--order", "2", "--size", "200x200"];
    let said = place.ok(&[&more[..], &["--jacobian"]].concat());
    assert!(said.contains("3 points, 2 reflections, 1 points without any, 0 points"), "{said}");
    let (header, rows) = place.table();
    assert_eq!(rows.iter().map(|row| row[0].as_str()).collect::<Vec<_>>(), ["0", "1"]);
    let column = |name: &str| header.iter().position(|word| word == name).unwrap();
    let half = 0.5f64.sqrt();
    let leg = (half * half + (3.0 - half).powi(2)).sqrt();
    for (row, bounce) in rows.iter().zip([[0.0, half, half], [half, 0.0, half]]) {
        assert_eq!((row[1].as_str(), row[2].as_str(), row[3].as_str()), ("R", "ball", "0"));
        assert!((number(&row[column("path_length")]) - 2.0 * leg).abs() < 1e-9, "{row:?}");
        for (name, expected) in ["x1", "y1", "z1"].iter().zip(bounce) {
            assert!((number(&row[column(name)]) - expected).abs() < 1e-9, "{row:?}");
        }
        let moved: Vec<f64> = (1..=3)
            .map(|i| (1..=3).map(|j| number(&row[column(&format!("j{i}{j}"))]) * [0.0, 0.0, 1.0][j - 1]).sum())
            .collect();
        // Towards the eye by a step s the point turns by s / 3 and nears the centre not at all, to first order,
        // and the bounce turns half as far.
        assert!(bounce.iter().zip(&moved).map(|(a, b)| a * b).sum::<f64>().abs() < 1e-9);
        let turned = moved.iter().map(|m| m * m).sum::<f64>().sqrt();
        assert!((turned - 1.0 / 6.0).abs() < 1e-9, "{turned}");
        let image = [number(&row[column("image_x")]), number(&row[column("image_y")])];
        assert!(image.iter().all(|place| (0.0..200.0).contains(place)));
    }
}
