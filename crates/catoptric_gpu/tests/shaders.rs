//! Shaders without a device: every one is valid, and reads records as they are written.

use catoptric::surface::Implicit;
use catoptric_gpu::layout::{
    Appearance, Binding, ExactSurface, FieldRegion, FieldSlab, Frame, GRID_SIDE, GRIDS, Grids, Layer, LayerGroup,
    LeafTriangle, Level, LightRecord, LobesRecord, MAX_DEPTH, MAX_LIGHTS, MAX_ORDER, MAX_VIEWPOINTS, MOST_REDUCTIONS,
    MirrorPath, Node, PICTURE_SIDE, PathList, Piece, Point, Reflection, ReflectorMap, START_RAY_BYTES, Surface,
    TEXEL_ROW, TextureRecord, Tiling, Vertex, WIDTH, WideChild, frame_flags, hit_flags, lobe_flags, surface_flags,
    triangle_flags,
};
use catoptric_gpu::shader;
use naga::front::wgsl;
use naga::proc::Layouter;
use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{Block, Module, Statement, TypeInner};
use std::mem::offset_of;

fn module(path: &str) -> Module {
    let source = shader::source(path);
    wgsl::parse_str(&source).unwrap_or_else(|error| panic!("{path}: {}", error.emit_to_string(&source)))
}

#[test]
fn all_shaders_are_valid() {
    for path in shader::SHADERS {
        let module = module(path);
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::default());
        if let Err(error) = validator.validate(&module) {
            panic!("{path}: {}", error.emit_to_string(&shader::source(path)));
        }
        assert!(!module.entry_points.is_empty(), "{path} has no entry point");
    }
}

/// Name, size and fields of a record.
struct Record {
    name: &'static str,
    size: usize,
    fields: Vec<(&'static str, usize)>,
}

macro_rules! record {
    ($name:literal: $record:ty { $($field:ident $(as $shader:literal)?),* $(,)? }) => {
        Record {
            name: $name,
            size: size_of::<$record>(),
            fields: vec![$((record!(@ $field $($shader)?), offset_of!($record, $field))),*],
        }
    };
    ($name:literal: $record:ty { $($field:ident),* $(,)? } before $rest:ident) => {
        Record {
            name: $name,
            size: offset_of!($record, $rest),
            fields: vec![$((stringify!($field), offset_of!($record, $field))),*],
        }
    };
    (@ $field:ident) => { stringify!($field) };
    (@ $field:ident $shader:literal) => { $shader };
}

fn records() -> Vec<Record> {
    vec![
        record!("Vertex": Vertex { position, u0, normal, v0, color, tangent, uv1, part }),
        record!("Node": Node { low0, child0, high0, low1, child1, high1 }),
        record!("LeafTriangle": LeafTriangle { a, triangle, b, object, c, flags }),
        record!("Binding": Binding { matrix, translation, texture, channel }),
        record!("Level": Level { size, first, stride }),
        record!("TextureRecord": TextureRecord {
            size, last_level, nearest_level, magnified_half, minified_half, wrap,
        } before levels),
        record!("Light": LightRecord { position, kind, direction, range, intensity, inner_cos, outer_cos }),
        record!("ExactSurface": ExactSurface {
            center, value, gradient, size, curved, kind, twisted, axes as "axis_x", low, high,
        }),
        record!("Surface": Surface {
            base_color, emissive, role, absorption, flags, specular, specular_at_grazing, own_color, alpha_cutoff,
            metallic, roughness, facets_coat, facets_coat_roughness, ior, coat, highlight_roughness, extent, ramp,
            attenuation, attenuation_distance, normal_scale, occlusion_strength, mirror_roughness, turning_map,
            turning_scale, lobes,
        } before exact),
        record!("LobesRecord": LobesRecord { transmission, flags, coat_normal_scale } before bindings),
        record!("Frame": Frame {
            clip_from_world, origin, flags, direction, order, right, width, down, height, light_count, root,
            first_row, extent, cells, tiled_events, followed, maps, reductions, sample_place,
            sample_side, sun_count,
        }),
    ]
}

#[test]
fn records_are_laid_out_as_shaders_read_them() {
    compare("frame.wgsl", &records());
}

/// Records on both sides.
fn compare(path: &str, records: &[Record]) {
    let module = module(path);
    let mut layouter = Layouter::default();
    layouter.update(module.to_ctx()).expect("naga lays out what it has parsed");
    for record in records {
        let named = |(_, ty): &(_, &naga::Type)| ty.name.as_deref() == Some(record.name);
        let (handle, ty) = module.types.iter().find(named).unwrap_or_else(|| panic!("no record {}", record.name));
        let TypeInner::Struct { members, .. } = &ty.inner else { panic!("{} is no record", record.name) };
        assert_eq!(layouter[handle].size as usize, record.size, "the size of {}", record.name);
        for (field, offset) in &record.fields {
            let member = members.iter().find(|member| member.name.as_deref() == Some(field));
            let member = member.unwrap_or_else(|| panic!("{} has no field {field}", record.name));
            assert_eq!(member.offset as usize, *offset, "{}.{field}", record.name);
        }
        let is_known = |name: &str| {
            record.fields.iter().any(|(field, _)| *field == name)
                || name.starts_with("unused")
                || name.starts_with("axis_")
        };
        for member in members {
            let name = member.name.as_deref().unwrap_or_default();
            assert!(is_known(name), "{}.{name} is not compared", record.name);
        }
    }
}

#[test]
fn tables_are_read_where_records_lie() {
    let source = shader::source("frame.wgsl");
    let bytes = [
        ("VERTEX_TEXELS", size_of::<Vertex>()),
        ("SURFACE_TEXELS", size_of::<Surface>()),
        ("EXACT_AT", offset_of!(Surface, exact)),
        ("BINDINGS_AT", offset_of!(Surface, bindings)),
        ("LOBE_BINDINGS_AT", offset_of!(LobesRecord, bindings)),
        ("TEXTURE_TEXELS", size_of::<TextureRecord>()),
        ("LEVELS_AT", offset_of!(TextureRecord, levels)),
        ("NODE_TEXELS", size_of::<Node>()),
        ("LEAF_TRIANGLE_TEXELS", size_of::<LeafTriangle>()),
    ];
    for (name, bytes) in bytes {
        assert_eq!(bytes % 16, 0, "{name}");
        let texels = bytes / 16;
        assert!(source.contains(&format!("const {name} = {texels}u;")), "{name} is not {texels} in the shaders");
    }
}

/// The records of tiles, of environment maps, of flat mirrors and of virtual geometry.
#[test]
fn passes_read_their_own_records_as_they_are_written() {
    let tiling = record!("Tiling": Tiling { events, kinds, queue, traced_queue, shade_queue, some_known });
    let map = record!("ReflectorMap": ReflectorMap { center, shape, low, size, high, first });
    compare("look.wgsl", &[map]);
    assert_eq!(size_of::<ReflectorMap>(), 3 * 16);
    compare("mirrors.wgsl", &[record!("MirrorPath": MirrorPath { clip_from_scene, plane, mirror, parent, number })]);
    assert!(shader::source("look.wgsl").contains("const REFLECTOR_MAP_TEXELS = 3u;"));
    let region = record!("FieldRegion": FieldRegion {
        root, views, pixels, first_layer, has_depth, by_one_event,
    } before slabs);
    compare("field.wgsl", &[region, record!("FieldSlab": FieldSlab { low, plane, focal, spacing })]);
    let group = record!("LayerGroup": LayerGroup { root, first_layer, layers, viewpoints, shares });
    let layer = record!("Layer": Layer {
        center, shape, low, size, high, faces, right, least, up, most, has_depths, first_depth, depth_base,
        depth_shift, first_bound, bound_levels, first_texels,
    });
    compare("layered.wgsl", &[group, layer]);
    let source = shader::source("layered.wgsl");
    for (name, bytes) in [("LAYER_GROUP_TEXELS", size_of::<LayerGroup>()), ("LAYER_TEXELS", size_of::<Layer>())] {
        assert!(source.contains(&format!("const {name} = {}u;", bytes / 16)), "{name}");
    }
    assert!(source.contains(&format!("const MOST_VIEWPOINTS = {MAX_VIEWPOINTS}u;")));
    let source = shader::source("field.wgsl");
    for (name, bytes) in
        [("FIELD_REGION_TEXELS", offset_of!(FieldRegion, slabs)), ("FIELD_SLAB_TEXELS", size_of::<FieldSlab>())]
    {
        assert!(source.contains(&format!("const {name} = {}u;", bytes / 16)), "{name}");
    }
    let grids = record!("Grids": Grids {
        levels, reductions, forward, near, margin_px, greatest_distance, level, reduction, reduction_count,
    });
    compare("rough/blur.wgsl", &[grids]);
    let source = shader::source("rough/blur.wgsl");
    for (name, value) in [("GRIDS", GRIDS), ("MOST_REDUCTIONS", MOST_REDUCTIONS)] {
        assert!(source.contains(&format!("const {name} = {value}u;")), "{name}");
    }
    compare("lists.wgsl", &[record!("PathList": PathList { object, parent, number })]);
    let reflection = record!("Reflection": Reflection {
        clip_from_world, low, size, shown_low, shown_high, box_low, radius, box_high, object, axis, near, far,
        edge_error_px, piece_px, shortest, own_vertices, own_triangles, vertex_count, triangle_count,
        most_appearances, most_pieces, most_drawn, number, most_points, shows_itself, map_x, far_radius, map_y, map_z,
    });
    let point = record!("Point": Point { position, first, weights, count });
    let appearance = record!("Appearance": Appearance { image_px, w, depth, change_x, state, change_y, is_turned });
    let piece = record!("Piece": Piece { corners, source });
    compare("virtual_mesh/divide.wgsl", &[reflection, point, appearance, piece]);
    let source = shader::source("virtual_mesh/divide.wgsl");
    for (name, value) in [("PICTURE_SIDE", PICTURE_SIDE), ("GRID_SIDE", GRID_SIDE)] {
        assert!(source.contains(&format!("const {name} = {value}u;")), "{name}");
    }
    assert_eq!(START_RAY_BYTES, 2 * 16, "two vectors");
    compare("tiles/cover.wgsl", &[tiling, record!("WideChild": WideChild { low, code, high })]);
    assert!(shader::source("tiles/cover.wgsl").contains(&format!("const WIDTH = {WIDTH}u;")));
}

#[test]
fn limits_are_the_same_on_both_sides() {
    let source = shader::source("frame.wgsl");
    assert_eq!(TEXEL_ROW, 1 << 13);
    assert!(source.contains("const TEXEL_ROW_LOG2 = 13u;"));
    assert!(source.contains(&format!("const MOST_VALUES = {}u;", Implicit::MAX_DEPTH)));
    for (name, value) in [("MAX_ORDER", MAX_ORDER as usize), ("MAX_LIGHTS", MAX_LIGHTS), ("MAX_DEPTH", MAX_DEPTH)] {
        assert!(source.contains(&format!("const {name} = {value}u;")), "{name} is not {value} in the shaders");
    }
}

#[test]
fn flags_are_the_same_on_both_sides() {
    let source = shader::source("frame.wgsl");
    let all = [surface_flags::ALL, lobe_flags::ALL, frame_flags::ALL, triangle_flags::ALL, hit_flags::ALL].concat();
    for (name, value) in all {
        let written = [format!("const {name} = {value}u;"), format!("const {name} = {value:#x}u;")];
        assert!(written.iter().any(|line| source.contains(line)), "{name} is not {value} in the shaders");
    }
}

#[test]
fn no_shader_binds_more_than_browsers_do() {
    for path in shader::SHADERS {
        let module = module(path);
        let info = Validator::new(ValidationFlags::all(), Capabilities::default()).validate(&module).unwrap();
        for (index, entry) in module.entry_points.iter().enumerate() {
            let of_entry = info.get_entry_point(index);
            let storage = module.global_variables.iter().filter(|(handle, variable)| {
                matches!(variable.space, naga::AddressSpace::Storage { .. }) && !of_entry[*handle].is_empty()
            });
            let count = storage.count();
            assert!(count <= 8, "{path}: {} reads {count} storage buffers; WebGPU's default limit is 8", entry.name);
            let textures = module.global_variables.iter().filter(|(handle, variable)| {
                let is_read = match module.types[variable.ty].inner {
                    TypeInner::Image { class, .. } => !matches!(class, naga::ImageClass::Storage { .. }),
                    _ => false,
                };
                is_read && !of_entry[*handle].is_empty()
            });
            let count = textures.count();
            assert!(count <= 16, "{path}: {} reads {count} textures; WebGPU's default limit is 16", entry.name);
        }
    }
}

/// Words that the language keeps for itself; naga lets some of them pass.
const RESERVED: &str = "NULL Self abstract active alignas alignof as asm asm_fragment async attribute auto await \
    become cast catch class co_await co_return co_yield coherent column_major common compile compile_fragment concept \
    const_cast consteval constexpr constinit crate debugger decltype delete demote demote_to_helper do dynamic_cast \
    enum explicit export extends extern external fallthrough filter final finally friend from fxgroup get goto \
    groupshared highp impl implements import inline instanceof interface layout lowp macro macro_rules match mediump \
    meta mod module move mut mutable namespace new nil noexcept noinline nointerpolation non_coherent noncoherent \
    noperspective null nullptr of operator package packoffset partial pass patch pixelfragment precise precision \
    premerge priv protected pub public readonly ref regardless register reinterpret_cast require resource restrict \
    self set shared sizeof smooth snorm static static_assert static_cast std subroutine super target template this \
    thread_local throw trait try type typedef typeid typename typeof union unless unorm unsafe unsized use using \
    varying virtual volatile wgsl where with writeonly yield";

/// True if a block has a barrier, at any depth.
fn has_barrier(block: &Block) -> bool {
    block.iter().any(|statement| match statement {
        Statement::ControlBarrier(_) | Statement::WorkGroupUniformLoad { .. } => true,
        Statement::Block(inner) => has_barrier(inner),
        Statement::If { accept, reject, .. } => has_barrier(accept) || has_barrier(reject),
        Statement::Switch { cases, .. } => cases.iter().any(|case| has_barrier(&case.body)),
        Statement::Loop { body, continuing, .. } => has_barrier(body) || has_barrier(continuing),
        _ => false,
    })
}

/// True if a block of a loop with a barrier (`in_one`), or a loop in it that has one, begins its loop again from its
/// midst.
fn continues_past_barriers(block: &Block, in_one: bool) -> bool {
    block.iter().any(|statement| match statement {
        Statement::Continue => in_one,
        Statement::Block(inner) => continues_past_barriers(inner, in_one),
        Statement::If { accept, reject, .. } => {
            continues_past_barriers(accept, in_one) || continues_past_barriers(reject, in_one)
        }
        Statement::Switch { cases, .. } => cases.iter().any(|case| continues_past_barriers(&case.body, in_one)),
        Statement::Loop { body, .. } => continues_past_barriers(body, has_barrier(body)),
        _ => false,
    })
}

/// Barriers are for all threads of a group: browsers refuse loops in which some may begin again before the others.
#[test]
fn all_threads_meet_at_barriers() {
    let mut loops = 0;
    for path in shader::SHADERS {
        let module = module(path);
        let functions = module.functions.iter().map(|(_, function)| function);
        for function in functions.chain(module.entry_points.iter().map(|entry| &entry.function)) {
            let name = function.name.as_deref().unwrap_or_default();
            assert!(!continues_past_barriers(&function.body, false), "{path}: {name}");
            let is_one = |statement: &Statement| matches!(statement, Statement::Loop { body, .. } if has_barrier(body));
            loops += function.body.iter().filter(|statement| is_one(statement)).count();
        }
    }
    assert!(loops > 2, "there are some: {loops}");
}

/// Browsers' compilers are stricter than naga: names may not be reserved words, and `&&` and `||` may not be mixed
/// without parentheses.
#[test]
fn browsers_can_compile_all_shaders() {
    let reserved: Vec<&str> = RESERVED.split_whitespace().collect();
    for path in shader::SHADERS {
        for line in shader::source(path).lines() {
            let code = line.split("//").next().unwrap_or_default();
            let is_part = |c: char| !(c.is_alphanumeric() || c == '_');
            let word = code.split(is_part).find(|word| reserved.contains(word));
            assert_eq!(word, None, "{path}: {line}");
        }
        let source = shader::source(path);
        let code: String = source.lines().map(|line| line.split("//").next().unwrap_or_default()).collect();
        // The operators on each level of parentheses.
        let mut levels = vec![String::new()];
        for character in code.chars() {
            match character {
                '(' | '[' => levels.push(String::new()),
                ';' | '{' | '}' | ',' | ')' | ']' => {
                    let expression = levels.last().map_or("", String::as_str);
                    assert!(!(expression.contains("&&") && expression.contains("||")), "{path}: {expression}");
                    match character {
                        ')' | ']' if levels.len() > 1 => drop(levels.pop()),
                        _ => levels.last_mut().expect("one level at least").clear(),
                    }
                }
                _ => levels.last_mut().expect("one level at least").push(character),
            }
        }
    }
}
