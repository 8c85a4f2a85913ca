//! Tasks of new users, each in one command as the documents tell it.

use crate::workplace::Workplace;

/// A red pyramid on its base.
const OBJ: &str = "mtllib m.mtl\no pyramid\nusemtl paint\nv -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv 0 1.5 0\n\
                   f 1 2 3 4\nf 4 3 5\nf 3 2 5\nf 2 1 5\nf 1 4 5\n";
const MTL: &str = "newmtl paint\nKd 0.8 0.1 0.1\n";
const STL: &str = "solid s\nfacet normal 0 0 1\nouter loop\nvertex -1 -1 0\nvertex 1 -1 0\nvertex 0 1 0\nendloop\n\
                   endfacet\nendsolid s\n";
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                   element face 1\nproperty list uchar int vertex_indices\nend_header\n\
                   -1 -1 0\n1 -1 0\n1 1 0\n-1 1 0\n4 0 1 2 3\n";

/// Options that make pictures small.
const SMALL: [&str; 4] = ["--size", "24x16", "--samples", "1"];

/// A task: its words, the files that are there afterwards, and a part of what is said.
type Task = (&'static [&'static str], &'static [&'static str], &'static str);

/// Pictures of one's own file.
const PICTURES: [Task; 22] = [
    // Draw my file, with light that I have.
    (&["render", "p.obj", "-o", "a.png"], &["a.png"], "a.png: auto, 24x16"),
    (&["render", "p.obj", "--environment", "sky", "-o", "b.png"], &["b.png"], ""),
    (&["render", "p.obj", "--environment", "l.hdr", "--environment-rotation", "90", "-o", "c.png"], &["c.png"], ""),
    (&["render", "p.obj", "--environment", "studio", "--environment-strength", "0.5", "-o", "d.png"], &["d.png"], ""),
    // Make a part of it a mirror, or glass, and leave a part matt.
    (&["render", "p.obj", "--reflector", "pyramid", "-o", "e.png"], &["e.png"], "reflectors:"),
    (&["render", "p.obj", "--lens", "paint:1.33", "-o", "f.png"], &["f.png"], "reflectors:"),
    (&["render", "scene.toml", "--diffuse", "ball", "-o", "g.png"], &["g.png"], ""),
    // A mesh without materials as a mirror.
    (&["render", "m.stl", "--reflector", "*", "--environment", "studio", "-o", "h.png"], &["h.png"], ""),
    (&["render", "m.ply", "--reflector", "m", "--environment", "studio", "-o", "i.png"], &["i.png"], ""),
    // Look from elsewhere.
    (&["render", "scene.toml", "--eye", "-2,1,3", "--target", "0,0.5,0", "--fov", "40", "-o", "j.png"], &["j.png"], ""),
    // Brighter, with a curve that does not clip.
    (&["render", "scene.toml", "--exposure", "1", "--tone", "agx", "-o", "k.png"], &["k.png"], ""),
    // For compositing: linear floats, half floats, layers, without the background; for the web.
    (&["render", "scene.toml", "-o", "l.exr"], &["l.exr"], ""),
    (&["render", "scene.toml", "--half", "--layers", "-o", "m.exr"], &["m.exr"], ""),
    (&["render", "scene.toml", "--transparent", "-o", "n.webp"], &["n.webp"], ""),
    (&["render", "scene.toml", "--bits", "16", "-o", "o.png"], &["o.png"], ""),
    (&["render", "scene.toml", "-o", "p.jpg"], &["p.jpg"], ""),
    // A mask of the mirrors, and a part of the picture alone.
    (&["render", "scene.toml", "--mask", "mask.png", "-o", "q.png"], &["mask.png", "q.png"], ""),
    (&["render", "scene.toml", "--region", "4,4,8,8", "-o", "r.png"], &["r.png"], ""),
    // A turntable without background, and frames of a moving eye.
    (&["render", "p.obj", "--turntable", "3", "--transparent", "-o", "t-##.png"], &["t-01.png", "t-03.png"], ""),
    (&["render", "scene.toml", "--motion", "eye", "--frames", "1..2", "-o", "u-##.png"], &["u-01.png", "u-02.png"], ""),
    // The truth, and a method of a paper with a setting of its own.
    (&["render", "scene.toml", "--method", "reference", "-o", "truth.exr"], &["truth.exr"], "truth.exr: reference"),
    (&["render", "scene.toml", "--method", "environment_map", "--set", "parallax=box", "-o", "v.exr"], &["v.exr"], ""),
];

/// Measuring, finding and learning.
const OTHERS: [Task; 24] = [
    (&["diff", "l.exr", "truth.exr"], &[], "FLIP mean"),
    (&["diff", "l.exr", "truth.exr", "-o", "heat.png"], &["heat.png"], "RMSE"),
    (&["diff", "l.exr", "l.exr", "--max-flip", "0"], &[], "0 of 384 pixels"),
    (&["diff", "v.exr", "truth.exr", "--json"], &[], "\"flip_mean\""),
    (
        &["compare", "scene.toml", "--size", "24x16", "--samples", "1", "--method", "auto", "--report", "report"],
        &["report/report.html", "report/report.json"],
        "FLIP",
    ),
    // Against another program's picture of the same view, and as a table for a paper.
    (
        &["compare", "scene.toml", "--size", "24x16", "--method", "auto", "--reference", "truth.exr", "--report", "r"],
        &["r/report.html"],
        "truth.exr",
    ),
    (
        &[
            "compare",
            "scene.toml",
            "--size",
            "24x16",
            "--samples",
            "1",
            "--frames",
            "1",
            "--method",
            "auto",
            "--csv",
            "t.csv",
            "--latex",
            "t.tex",
            "--crop",
            "4,4,8,8",
            "--report",
            "paper",
        ],
        &["t.csv", "t.tex", "paper/report.html"],
        "speed-up",
    ),
    // Where does this point appear in that mirror?
    (&["project", "scene.toml", "--reflector", "ball", "--points", "x.csv", "-o", "-"], &[], "0,R,ball"),
    (&["project", "scene.toml", "--size", "640x480", "--points", "x.csv", "-o", "px.csv"], &["px.csv"], ""),
    (&["project", "scene.toml", "--jacobian", "--points", "x.csv", "-o", "px.npy"], &["px.npy"], ""),
    // In my calibrated camera, of a whole surface, with what hides it.
    (&["project", "scene.toml", "--points", "x.csv", "--camera", "c.json", "-o", "pc.csv"], &["pc.csv"], ""),
    (
        &["project", "p.obj", "--reflector", "*", "--points", "grid:pyramid:0.2", "--direct", "-o", "g.jsonl"],
        &["g.jsonl"],
        "in direct sight",
    ),
    (
        &["project", "scene.toml", "--size", "64x48", "--points", "x.csv", "--write-camera", "w.json", "-o", "-"],
        &["w.json"],
        "blocked_by",
    ),
    // A scene that I write myself.
    (&["info", "mine.toml"], &[], "board"),
    (&["info", "p.obj"], &[], "pyramid"),
    (&["info", "scene.toml", "--json"], &[], "\"objects\""),
    (&["scenes"], &[], "sphere_room"),
    (&["render", "builtin:sphere_room", "--size", "24x16", "--samples", "1", "-o", "w.png"], &["w.png"], ""),
    (&["methods"], &[], "light_field"),
    (&["explain", "light_field"], &[], "Yu"),
    (&["doctor"], &[], ""),
    (&["completions", "bash"], &[], "catoptric"),
    (
        &["bake", "scene.toml", "--method", "light_field", "--set", "st=2", "--set", "uv=4", "-o", "b.bake"],
        &["b.bake"],
        "",
    ),
    (&["render", "--help"], &[], "--turntable"),
];

#[test]
fn tasks_take_one_command_each() {
    let place = Workplace::new();
    place.write("p.obj", OBJ);
    place.write("m.mtl", MTL);
    place.write("m.stl", STL);
    place.write("m.ply", PLY);
    place.write("x.csv", "x,y,z\n2,0.5,1\n");
    place.write("mine.toml", "[[object]]\nname = \"board\"\nshape = \"quad\"\nsize = [1, 1]\n");
    place.write(
        "c.json",
        r#"{"width": 64, "height": 48, "K": [[50, 0, 32], [0, 50, 24], [0, 0, 1]],
            "R": [[1, 0, 0], [0, -1, 0], [0, 0, -1]], "t": [0, 1, 4]}"#,
    );
    let sky = image_of_light();
    place.write("l.hdr", sky);
    let with_size = PICTURES.iter().map(|(words, files, said)| ([words, &SMALL[..]].concat(), files, said));
    let as_they_are = OTHERS.iter().map(|(words, files, said)| (words.to_vec(), files, said));
    for (words, files, said) in with_size.chain(as_they_are) {
        let output = place.ok(&words);
        assert!(output.contains(said), "{words:?} should say {said}: {output}");
        for file in *files {
            assert!(place.path(file).metadata().is_ok_and(|about| about.len() > 0), "{words:?} should write {file}");
        }
    }
}

/// A Radiance picture of one bright colour: two rows of four pixels, uncompressed.
fn image_of_light() -> Vec<u8> {
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n".to_vec();
    bytes.extend([128, 128, 128, 129].repeat(8));
    bytes
}

#[test]
fn mirrors_in_mirrors_are_drawn_without_being_asked_for() {
    let place = Workplace::new();
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/scenes/kaleidoscope.toml");
    let draw = |output: &str, more: &[&str]| {
        place.ok(&[&["render", scene, "--size", "32x32", "--samples", "1", "-o", output], more].concat());
        place.bytes(output)
    };
    let all = draw("all.png", &["--order", "16"]);
    assert!(draw("few.png", &["--order", "2"]) != all);
    assert!(draw("of-itself.png", &[]) == all);
}
