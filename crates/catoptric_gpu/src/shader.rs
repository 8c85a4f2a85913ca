//! The shaders' sources. A line `//#include "path"` stands for another file, once in each shader.

use std::collections::HashSet;

macro_rules! sources {
    ($($path:literal),* $(,)?) => {
        /// All files by their paths.
        const FILES: &[(&str, &str)] = &[$(($path, include_str!(concat!("../wgsl/", $path)))),*];
    };
}

sources!(
    "confined.wgsl",
    "field.wgsl",
    "frame.wgsl",
    "layered.wgsl",
    "light/cubes.wgsl",
    "light/hierarchy.wgsl",
    "light/layered/depths.wgsl",
    "light/layered/layers.wgsl",
    "light/layered/shells.wgsl",
    "light/maps.wgsl",
    "light/paths/bounce.wgsl",
    "light/paths/follow.wgsl",
    "light/paths/lobes.wgsl",
    "light/paths/nothing_known.wgsl",
    "light/paths/paths.wgsl",
    "light/paths/spread.wgsl",
    "light/paths/surface_lobes.wgsl",
    "light/paths/tabled.wgsl",
    "light/paths/whole_scene.wgsl",
    "light/reflectors.wgsl",
    "light/slabs.wgsl",
    "light/surrounds.wgsl",
    "light/trace.wgsl",
    "lists.wgsl",
    "look.wgsl",
    "mirrors.wgsl",
    "optics/step.wgsl",
    "present.wgsl",
    "rough/blur.wgsl",
    "rough/cells.wgsl",
    "rough/grids.wgsl",
    "rough/tables.wgsl",
    "scene/base.wgsl",
    "scene/bumps.wgsl",
    "scene/environment.wgsl",
    "scene/exact.wgsl",
    "scene/expression.wgsl",
    "scene/lobes.wgsl",
    "scene/microfacets.wgsl",
    "scene/point.wgsl",
    "scene/records.wgsl",
    "scene/shade.wgsl",
    "scene/sky.wgsl",
    "scene/texture.wgsl",
    "sum.wgsl",
    "tiles/blurred.wgsl",
    "tiles/cells.wgsl",
    "tiles/classify.wgsl",
    "tiles/cover.wgsl",
    "tiles/followed.wgsl",
    "tiles/gather.wgsl",
    "tiles/one_surface.wgsl",
    "tiles/path_ray.wgsl",
    "tiles/pixels.wgsl",
    "tiles/trace.wgsl",
    "tiles/work.wgsl",
    "twins/encounters.wgsl",
    "twins/events.wgsl",
    "twins/points.wgsl",
    "virtual_mesh/divide.wgsl",
    "virtual_mesh/explosion.wgsl",
    "virtual_mesh/points.wgsl",
    "virtual_mesh/project.wgsl",
    "virtual_mesh/reflection.wgsl",
    "virtual_mesh/reflector.wgsl",
    "virtual_mesh/search.wgsl",
    "virtual_mesh/spheres.wgsl",
    "virtual_mesh/starts.wgsl",
    "virtual_mesh/work.wgsl",
    "visibility.wgsl",
);

/// The shaders that pipelines are made of.
pub const SHADERS: &[&str] = &[
    "field.wgsl",
    "frame.wgsl",
    "layered.wgsl",
    "lists.wgsl",
    "look.wgsl",
    "mirrors.wgsl",
    "present.wgsl",
    "rough/blur.wgsl",
    "rough/cells.wgsl",
    "sum.wgsl",
    "tiles/blurred.wgsl",
    "tiles/classify.wgsl",
    "tiles/cover.wgsl",
    "tiles/gather.wgsl",
    "tiles/trace.wgsl",
    "twins/encounters.wgsl",
    "twins/events.wgsl",
    "twins/points.wgsl",
    "virtual_mesh/divide.wgsl",
    "virtual_mesh/explosion.wgsl",
    "virtual_mesh/project.wgsl",
    "virtual_mesh/reflector.wgsl",
    "visibility.wgsl",
];

/// The source of a shader with all that it includes.
///
/// # Panics
/// If there is no file of this path, or an included one is missing: a test asks for all.
pub fn source(path: &str) -> String {
    let mut text = String::new();
    append(path, &mut text, &mut HashSet::new());
    text
}

fn append(path: &str, text: &mut String, done: &mut HashSet<String>) {
    if !done.insert(path.to_owned()) {
        return;
    }
    let Some((_, file)) = FILES.iter().find(|(known, _)| *known == path) else {
        panic!("there is no shader file `{path}`");
    };
    for line in file.lines() {
        match line.strip_prefix("//#include \"").and_then(|rest| rest.strip_suffix('"')) {
            Some(included) => append(included, text, done),
            None => {
                text.push_str(line);
                text.push('\n');
            }
        }
    }
}
