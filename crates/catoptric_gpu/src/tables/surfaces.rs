//! Objects with their materials, as records for shaders.

use crate::layout::lobe_flags;
use crate::layout::surface_flags as flags;
use crate::layout::{BINDINGS, Binding, BindingPlace, EXPRESSION, ExactSurface, LobesRecord, NONE, Surface, bits};
use catoptric::methods::projection::multiperspective::{ObjectShape, object_shapes};
use catoptric::parallel;
use catoptric::scene::{AlphaMode, Lobes, Material, Object, Role, Scene, TextureBinding};
use catoptric::surface::{AnalyticSurface, Instruction, PlacedSurface, Taylor2};
use glam::{DVec3, Vec3};

/// How far edges may be off, as a share of the object's size, in an object that has moved as a whole.
const SAME_EDGES: f32 = 1e-5;

/// Triangles that are compared at once. A size for threads.
const TRIANGLES_AT_ONCE: usize = 2048;

/// The shapes of all objects; those of an earlier moment of the scene, if they are given, while all mirrors and lenses
/// have at most moved as a whole: finding them takes seconds where meshes are large.
pub(crate) fn shapes(scene: &Scene, earlier: Option<(&Scene, &[ObjectShape])>) -> Vec<ObjectShape> {
    let specular = scene.specular_objects();
    let holds = |(before, shapes): &(&Scene, &[ObjectShape])| {
        shapes.len() == scene.objects.len()
            && before.specular_objects() == specular
            && specular.iter().all(|object| is_moved_as_whole(scene, before, *object as usize))
    };
    match earlier.filter(holds) {
        Some((_, shapes)) => shapes.to_vec(),
        None => object_shapes(scene),
    }
}

/// True if an object has at most been moved and turned between two moments of a scene.
fn is_moved_as_whole(scene: &Scene, before: &Scene, object: usize) -> bool {
    let Object { triangles, bounds, surface, .. } = &scene.objects[object];
    let range = triangles.start as usize..triangles.end as usize;
    let old = &before.objects[object];
    if old.triangles != *triangles || old.surface.is_some() != surface.is_some() {
        return false;
    }
    let (Some(now), Some(then)) = (scene.triangles.get(range.clone()), before.triangles.get(range)) else {
        return false;
    };
    let tolerance = SAME_EDGES * bounds.diagonal();
    // How long an edge is, and how it leans from the normal at its start: that no motion changes.
    let edge = |scene: &Scene, [from, to]: [u32; 2]| {
        let step = scene.positions[to as usize] - scene.positions[from as usize];
        [step.length(), step.dot(scene.normals[from as usize])]
    };
    let is_same = |ends: [u32; 2]| {
        let ([length, lean], [old_length, old_lean]) = (edge(scene, ends), edge(before, ends));
        (length - old_length).abs() <= tolerance && (lean - old_lean).abs() <= tolerance
    };
    let chunks: Vec<&[[u32; 3]]> = now.chunks(TRIANGLES_AT_ONCE).collect();
    let are_same = |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]].into_iter().all(is_same);
    now == then && !parallel::map_collect(chunks.len(), |chunk| chunks[chunk].iter().all(are_same)).contains(&false)
}

/// The records of all objects, by their shapes, and what lies behind them: the programs of surfaces that are given by
/// expressions, a texel a step, and the lobes that rays follow, if they do.
pub fn surface_records(scene: &Scene, shapes: &[ObjectShape], follows_lobes: bool) -> (Vec<Surface>, Vec<[u32; 4]>) {
    let mut behind = BehindObjects { first: scene.objects.len() * size_of::<Surface>() / 16, texels: Vec::new() };
    let with_shapes = scene.objects.iter().zip(shapes);
    let records = with_shapes.map(|(object, shape)| {
        let mut record = surface(scene, object, shape, &mut behind);
        let material = &scene.materials[object.material as usize];
        if let Some(lobes) = material.lobes().filter(|_| follows_lobes) {
            record.lobes = behind.add(bytemuck::cast_slice(&[lobes_record(scene, material, lobes)])) as u32;
        }
        record
    });
    (records.collect(), behind.texels)
}

/// Texels behind those of objects.
struct BehindObjects {
    /// The first of them.
    first: usize,
    texels: Vec<[u32; 4]>,
}

impl BehindObjects {
    /// Adds some: the place of the first.
    fn add(&mut self, texels: &[[u32; 4]]) -> usize {
        let first = self.first + self.texels.len();
        self.texels.extend_from_slice(texels);
        first
    }

    /// Adds a program: the numbers of the first step and of steps.
    fn add_program(&mut self, program: &[Instruction]) -> [f64; 2] {
        let steps: Vec<[u32; 4]> = program.iter().map(step_of).collect();
        [self.add(&steps) as f64, program.len() as f64]
    }
}

fn lobes_record(scene: &Scene, material: &Material, lobes: &Lobes) -> LobesRecord {
    let mut record = LobesRecord {
        transmission: lobes.transmission,
        flags: bits(&[
            (lobe_flags::THIN, lobes.is_thin),
            (lobe_flags::PLATE, lobes.is_plate),
            (lobe_flags::HAS_INSIDE, material.has_inside()),
            (lobe_flags::BLENDS, material.alpha_mode == AlphaMode::Blend),
        ]),
        coat_normal_scale: material.coat_normal_map.as_ref().map_or(0.0, |map| map.scale),
        ..LobesRecord::default()
    };
    for (record, binding) in record.bindings.iter_mut().zip(&lobes.textures) {
        *record = binding.as_ref().map_or_else(Binding::default, |binding| binding_record(scene, binding));
    }
    record
}

/// A step as shaders read it: what it does, and a whole number or another one.
fn step_of(step: &Instruction) -> [u32; 4] {
    let number = |value: f64| (value as f32).to_bits();
    match *step {
        Instruction::Variable(axis) => [0, axis as u32, 0, 0],
        Instruction::Constant(value) => [1, 0, number(value), 0],
        Instruction::Add => [2, 0, 0, 0],
        Instruction::Subtract => [3, 0, 0, 0],
        Instruction::Multiply => [4, 0, 0, 0],
        Instruction::Divide => [5, 0, 0, 0],
        Instruction::Negate => [6, 0, 0, 0],
        Instruction::WholePower(exponent) => [7, exponent.cast_unsigned(), 0, 0],
        Instruction::RealPower(exponent) => [8, 0, number(exponent), 0],
        Instruction::Power => [9, 0, 0, 0],
        Instruction::Sqrt => [10, 0, 0, 0],
        Instruction::Exp => [11, 0, 0, 0],
        Instruction::Sin => [12, 0, 0, 0],
        Instruction::Cos => [13, 0, 0, 0],
        Instruction::Abs => [14, 0, 0, 0],
    }
}

fn surface(scene: &Scene, object: &Object, shape: &ObjectShape, behind: &mut BehindObjects) -> Surface {
    let material = &scene.materials[object.material as usize];
    let facets = material.microfacets.clone().unwrap_or_default();
    let blend = material.blend.unwrap_or_default();
    let attenuation = blend.attenuation;
    Surface {
        base_color: material.base_color.to_array(),
        emissive: material.emissive.to_array(),
        role: match material.role {
            Role::Diffuse => 0,
            Role::Reflector => 1,
            Role::Lens => 2,
            Role::Coated => 3,
        },
        absorption: material.absorption.to_array(),
        flags: flags_of(object, material, shape),
        specular: facets.specular.to_array(),
        specular_at_grazing: facets.specular_at_grazing,
        own_color: blend.diffuse.unwrap_or(Vec3::ZERO).to_array(),
        alpha_cutoff: match material.alpha_mode {
            AlphaMode::Opaque => -1.0,
            AlphaMode::Mask(cutoff) => cutoff,
            // Wherever there is anything of it.
            AlphaMode::Blend => f32::MIN_POSITIVE,
        },
        metallic: facets.metallic,
        roughness: facets.roughness,
        facets_coat: facets.coat,
        facets_coat_roughness: facets.coat_roughness,
        ior: material.ior,
        coat: material.coat,
        highlight_roughness: material.highlight_roughness().unwrap_or(-1.0),
        extent: object.bounds.diagonal(),
        ramp: blend.fresnel.unwrap_or([1.0; 2]),
        attenuation: attenuation.map_or([1.0; 2], |attenuation| attenuation.specularity),
        attenuation_distance: attenuation.map_or(1.0, |attenuation| attenuation.distance),
        normal_scale: material.normal_map.as_ref().map_or(0.0, |map| map.scale),
        occlusion_strength: material.occlusion_map.as_ref().map_or(0.0, |map| map.strength),
        mirror_roughness: material.reflection_roughness(),
        turning_map: turning_map(scene, material),
        turning_scale: material.turning_map().map_or(0.0, |map| map.scale),
        lobes: NONE,
        unused: 0.0,
        exact: object.surface.as_ref().map(|surface| exact(surface, behind)).unwrap_or_default(),
        bindings: bindings(scene, material),
    }
}

fn flags_of(object: &Object, material: &Material, shape: &ObjectShape) -> u32 {
    let blend = material.blend.unwrap_or_default();
    bits(&[
        (flags::UNLIT, material.unlit),
        (flags::SCHLICK, material.schlick),
        (flags::INSIDE, object.inside),
        (flags::MICROFACETS, material.microfacets.is_some()),
        (flags::RAMP, blend.fresnel.is_some()),
        (flags::ATTENUATION, blend.attenuation.is_some()),
        (flags::OWN_COLOR, blend.diffuse.is_some()),
        (flags::ALPHA_TESTED, material.alpha_mode != AlphaMode::Opaque),
        (flags::CONVEX, shape.is_convex),
        (flags::CLOSED, shape.is_closed),
        (flags::EXACT, object.surface.is_some()),
        (flags::OWN_LIGHT, material.has_own_light()),
        (flags::BLEND, material.blend.is_some()),
    ])
}

/// The place of the map that turns rays among a material's textures. Without tangents normal maps say nothing.
fn turning_map(scene: &Scene, material: &Material) -> u32 {
    let place = if material.role == Role::Coated { BindingPlace::CoatNormals } else { BindingPlace::Normals };
    let is_there = material.turning_map().is_some() && !scene.tangents.is_empty();
    if is_there { place as u32 } else { NONE }
}

fn bindings(scene: &Scene, material: &Material) -> [Binding; BINDINGS] {
    let mut records = [Binding::default(); BINDINGS];
    let facets = material.microfacets.as_ref().and_then(|facets| facets.texture.as_ref());
    // Without tangents normal maps say nothing.
    let [normals, coat_normals] = [&material.normal_map, &material.coat_normal_map]
        .map(|map| map.as_ref().filter(|_| !scene.tangents.is_empty()).map(|map| &map.binding));
    let occlusion = material.occlusion_map.as_ref().map(|map| &map.binding);
    let places = [
        (BindingPlace::Base, material.base_texture.as_ref()),
        (BindingPlace::Emissive, material.emissive_texture.as_ref()),
        (BindingPlace::Facets, facets),
        (BindingPlace::Normals, normals),
        (BindingPlace::Occlusion, occlusion),
        (BindingPlace::Coat, material.coat_texture.as_ref()),
        (BindingPlace::CoatNormals, coat_normals),
    ];
    for (place, binding) in places {
        if let Some(binding) = binding {
            records[place as usize] = binding_record(scene, binding);
        }
    }
    records
}

fn binding_record(scene: &Scene, binding: &TextureBinding) -> Binding {
    let TextureBinding { texture, uv_channel, texture_from_uv: map } = binding;
    let is_there = (*texture as usize) < scene.textures.len();
    Binding {
        matrix: map.matrix2.to_cols_array(),
        translation: map.translation.to_array(),
        texture: if is_there { *texture } else { NONE },
        channel: u32::from(uv_channel & 1),
    }
}

/// The record of a surface given by a formula.
fn exact(placed: &PlacedSurface, behind: &mut BehindObjects) -> ExactSurface {
    let place = &placed.world_from_surface;
    // A polynomial of second degree is known everywhere by its value and derivatives at the centre.
    let polynomial = || {
        let Taylor2 { value, gradient, hessian } = placed.taylor2(place.translation);
        ExactSurface {
            value: value as f32,
            gradient: numbers(gradient),
            curved: numbers(DVec3::new(hessian.x_axis.x, hessian.y_axis.y, hessian.z_axis.z)),
            twisted: numbers(DVec3::new(hessian.y_axis.z, hessian.z_axis.x, hessian.x_axis.y)),
            ..ExactSurface::default()
        }
    };
    let formula = |kind, curved: [f64; 3], twisted: [f64; 3]| ExactSurface {
        kind,
        curved: numbers(curved.into()),
        twisted: numbers(twisted.into()),
        ..ExactSurface::default()
    };
    let (is_closed, record) = match &placed.surface {
        AnalyticSurface::Sphere { .. } | AnalyticSurface::Ellipsoid(_) => (true, polynomial()),
        AnalyticSurface::Plane { .. } | AnalyticSurface::Quadric(_) => (false, polynomial()),
        AnalyticSurface::Torus(torus) => {
            (true, formula(1, [torus.major_radius(), torus.minor_radius(), 0.0], [0.0; 3]))
        }
        AnalyticSurface::Revolution(shape) => {
            let [a, b, c, d] = shape.profile();
            (false, formula(2, [a, b, c], [d, shape.height(), 0.0]))
        }
        AnalyticSurface::Superquadric(shape) => {
            let [profile, section] = shape.exponents();
            (true, formula(3, shape.radii().to_array(), [profile, section, 0.0]))
        }
        AnalyticSurface::Implicit(shape) => {
            let (program, [scale, factor]) = shape.program();
            let [first, count] = behind.add_program(program);
            (false, formula(EXPRESSION, [1.0 / scale, factor, 0.0], [first, count, 0.0]))
        }
    };
    let bounds = placed.surface.bounds();
    let size = bounds.diagonal();
    let axis = |axis: DVec3| axis.as_vec3().extend(0.0).to_array();
    // Rounding must not cut a surface that ends nowhere.
    let margin = if is_closed { size } else { 1e-5 * size };
    ExactSurface {
        center: numbers(place.translation),
        size,
        axes: [place.matrix3.x_axis, place.matrix3.y_axis, place.matrix3.z_axis].map(axis),
        low: (bounds.min - Vec3::splat(margin)).to_array(),
        high: (bounds.max + Vec3::splat(margin)).to_array(),
        ..record
    }
}

fn numbers(vector: DVec3) -> [f32; 3] {
    vector.as_vec3().to_array()
}
