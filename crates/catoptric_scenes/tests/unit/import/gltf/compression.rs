use super::*;
use catoptric_core::scene::model::ChannelValues;
use glam::Vec3;
use meshopt_rs::index::IndexEncodingVersion;
use meshopt_rs::index::buffer::{encode_index_buffer, encode_index_buffer_bound};
use meshopt_rs::index::sequence::{encode_index_sequence, encode_index_sequence_bound};
use meshopt_rs::vertex::VertexEncodingVersion;
use meshopt_rs::vertex::buffer::{encode_vertex_buffer, encode_vertex_buffer_bound};

/// The description of a compressed view.
#[derive(Clone)]
struct Stream {
    mode: &'static str,
    filter: &'static str,
    count: u64,
    stride: u64,
}

fn stream(mode: &'static str, filter: &'static str, count: usize, stride: usize) -> Stream {
    Stream { mode, filter, count: count as u64, stride: stride as u64 }
}

/// The decompressed bytes of a view, which are the weights of a morph target over time, or the message about its fault.
fn decode(view: &Stream, bytes: &[u8]) -> Result<Vec<u8>, String> {
    let Stream { mode, filter, count, stride } = view;
    let size = count.saturating_mul(*stride).clamp(1, 1 << 16) as usize;
    let mut file = File::new();
    let positions = file.positions(&TRIANGLE);
    let attributes = json!({ "POSITION": positions });
    file.show(json!({ "attributes": attributes, "targets": [attributes] }));
    let times: Vec<f32> = (0..size).map(|key| key as f32).collect();
    let times = file.accessor(F32, "SCALAR", size, &times);
    let compressed = file.view(bytes);
    let mut extension = file.json["bufferViews"][compressed].clone();
    for (key, value) in [("mode", json!(mode)), ("filter", json!(filter)), ("count", json!(count))] {
        extension[key] = value;
    }
    extension["byteStride"] = json!(stride);
    let whole = json!({ "buffer": 0, "byteLength": size, "extensions": { "EXT_meshopt_compression": extension } });
    let whole = file.push("bufferViews", whole);
    let weights = json!({
        "bufferView": whole, "componentType": U8, "normalized": true, "type": "SCALAR", "count": size
    });
    let weights = file.push("accessors", weights);
    file.push(
        "animations",
        json!({
            "samplers": [{ "input": times, "output": weights }],
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "weights" } }],
        }),
    );
    let model = file.model();
    let place = "animations[0].channels[0] is left out: ";
    if let Some(problem) = model.warnings.iter().find_map(|warning| warning.strip_prefix(place)) {
        let field = format!("bufferViews[{whole}].extensions.EXT_meshopt_compression: ");
        return Err(problem.strip_prefix(&field).unwrap_or_else(|| panic!("{problem}")).into());
    }
    let ChannelValues::Weights { numbers, .. } = &model.animations[0].channels[0].values else { panic!("no weights") };
    Ok(numbers.iter().map(|number| (number * 255.0).round() as u8).collect())
}

/// Numbers that look like those of meshes: smooth, noisy and constant bytes, not a multiple of a block.
fn vertices(count: usize) -> Vec<[u16; 4]> {
    let mut random = 12345u32;
    (0..count as u32)
        .map(|index| {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            [index as u16 * 3, (random >> 16) as u16, 77, (random >> 30) as u16]
        })
        .collect()
}

fn encoded_vertices(vertices: &[[u16; 4]]) -> Vec<u8> {
    let mut bytes = vec![0; encode_vertex_buffer_bound(vertices.len(), 8)];
    let size = encode_vertex_buffer(&mut bytes, vertices, VertexEncodingVersion::V0).unwrap();
    bytes.truncate(size);
    bytes
}

/// Forty vertices of 24 bytes, as meshoptimizer 1.0 writes them in version 1 of its stream: floats, 16-bit numbers,
/// bytes and a 32-bit number, so that all ways of storing bytes and kinds of differences are there.
const VERSION_1: &str = "\
    a1686aaa7bb9950102010f1f1a0ffff8f8f4c4f4c4a060103018f81cf262e262f262e2623c1edddd00007e030703153d\
    1ff47f7ffefe7f7ffefe7f7fd1ff47fdfefe7f7ffefe7f7ffe1ff40000fe7f7ffe004a4a4a4a4a4a4a4a4a4a4a4a4a4a\
    4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a0057575757575757575757575757575757575757575757\
    5757575757575757575757575757575757152aaaaaaaaaaaaaaaaaaa0000152aaaaaaaaaaaaaaaaaaa000000b6b6b6b6\
    b6b6b6b6b6b6b6b6b6b6b6b6b6b6b6b6b6b6b6b6b6b6b6b6b6b6b6b6b6b6b6b6b6b6b62a066666666666666666666666\
    6666666666666666000000002a044444444444444444444444444444444444444400000000152aaaaaaaaaaaaaaaaaaa\
    000000000000000000000000c0bfe803ffff00ff000700000000621200010000";

#[test]
fn version_1_is_decoded() {
    let bytes: Vec<u8> = (0..VERSION_1.len() / 2)
        .map(|place| u8::from_str_radix(&VERSION_1[2 * place..2 * place + 2], 16).expect("a byte"))
        .collect();
    let mut expected = Vec::new();
    for index in 0..40u32 {
        for number in [index as f32 * 0.25, (index * index % 7) as f32, -1.5] {
            expected.extend(number.to_le_bytes());
        }
        for number in [1000 + index * 37, 65535 - index * 300] {
            expected.extend((number as u16).to_le_bytes());
        }
        expected.extend([index as u8, 255, (index * 91) as u8, 7]);
        expected.extend((0x10203 * index).to_le_bytes());
    }
    let whole = stream("ATTRIBUTES", "NONE", 40, 24);
    assert_eq!(decode(&whole, &bytes), Ok(expected));
    for end in 0..bytes.len() {
        assert!(decode(&whole, &bytes[..end]).is_err(), "{end}");
    }
}

/// Eight bits of red, green, blue and alpha through meshoptimizer's own filter.
#[test]
fn colors_are_filtered_back() {
    let encoded: [u8; 12] = [0x40, 0x7f, 0xc1, 0xff, 0x7f, 0x00, 0x7f, 0xc0, 0x8d, 0xe7, 0x59, 0x99];
    let mut bytes = vec![0; encode_vertex_buffer_bound(3, 4)];
    let size = encode_vertex_buffer(&mut bytes, encoded.as_chunks::<4>().0, VertexEncodingVersion::V0).unwrap();
    bytes.truncate(size);
    let decoded = decode(&stream("ATTRIBUTES", "COLOR", 3, 4), &bytes).expect("a sound stream");
    for (color, expected) in decoded.chunks(4).zip([[255, 0, 0, 255], [0, 255, 0, 128], [26, 230, 77, 51]]) {
        assert!(color.iter().zip(expected).all(|(byte, expected)| byte.abs_diff(expected) <= 1), "{color:?}");
    }
}

#[test]
fn attributes_of_another_encoder_are_decoded() {
    for count in [1, 15, 16, 17, 255, 256, 257, 1000] {
        let vertices = vertices(count);
        let decoded = decode(&stream("ATTRIBUTES", "NONE", count, 8), &encoded_vertices(&vertices)).unwrap();
        assert_eq!(decoded, vertices.concat().bytes(), "{count}");
    }
}

/// A grid of quads: shared edges, shared vertices, and jumps.
fn grid(side: u32) -> Vec<u32> {
    let quad = |x: u32, y: u32| {
        let a = y * (side + 1) + x;
        [a, a + 1, a + side + 1, a + side + 1, a + 1, a + side + 2]
    };
    (0..side).flat_map(|y| (0..side).flat_map(move |x| quad(x, y))).collect()
}

/// The same triangles, whichever corner comes first: the encoder may turn them.
fn rotated(indices: &[u32]) -> Vec<[u32; 3]> {
    let least_first = |t: &[u32]| {
        let least = (0..3).min_by_key(|corner| t[*corner]).unwrap();
        [t[least], t[(least + 1) % 3], t[(least + 2) % 3]]
    };
    indices.chunks_exact(3).map(least_first).collect()
}

#[test]
fn triangles_of_another_encoder_are_decoded() {
    let mut scattered: Vec<u32> = Vec::new();
    for triangle in 0..200u32 {
        scattered.extend([triangle * 7919 % 601, triangle * 104_729 % 599 + 700, triangle * 31 % 97 + 1400]);
    }
    for (indices, version) in [
        (grid(9), IndexEncodingVersion::V0),
        (grid(9), IndexEncodingVersion::V1),
        (scattered.clone(), IndexEncodingVersion::V0),
        (scattered, IndexEncodingVersion::V1),
    ] {
        let mut bytes = vec![0; encode_index_buffer_bound(indices.len(), 1500)];
        let size = encode_index_buffer(&mut bytes, &indices, version).unwrap();
        bytes.truncate(size);
        let decoded = decode(&stream("TRIANGLES", "NONE", indices.len(), 4), &bytes).unwrap();
        let decoded: Vec<u32> = decoded.as_chunks().0.iter().map(|bytes| u32::from_le_bytes(*bytes)).collect();
        assert_eq!(rotated(&decoded), rotated(&indices));
    }
}

#[test]
fn index_sequences_of_another_encoder_are_decoded() {
    let indices: Vec<u32> = (0..500u32).map(|index| index * 7919 % 1009).collect();
    let mut bytes = vec![0; encode_index_sequence_bound(indices.len(), 1009)];
    let size = encode_index_sequence(&mut bytes, &indices, IndexEncodingVersion::V1);
    bytes.truncate(size);
    let decoded = decode(&stream("INDICES", "NONE", indices.len(), 2), &bytes).unwrap();
    assert_eq!(decoded, indices.iter().map(|index| *index as u16).collect::<Vec<_>>().bytes());
}

/// Applies a filter to one element that the attribute coder passes through.
fn filtered(filter: &'static str, element: &[u8]) -> Vec<u8> {
    let stride = element.len();
    let mut bytes = vec![0xa0];
    bytes.extend(vec![0; stride]); // a header of all-zero groups for each byte
    let mut tail = vec![0; 32usize.max(stride)];
    let begin = tail.len() - stride;
    tail[begin..].copy_from_slice(element);
    bytes.extend(tail);
    decode(&stream("ATTRIBUTES", filter, 1, stride), &bytes).unwrap()
}

#[test]
fn octahedral_filters_give_unit_vectors() {
    assert_eq!(filtered("OCTAHEDRAL", &[0u8, 0, 127, 9]), [0, 0, 127, 9]);
    assert_eq!(filtered("OCTAHEDRAL", &[127u8, 0, 127, 0])[..3], [127, 0, 0]);
    // (-1, -1) folds to -z.
    assert_eq!(filtered("OCTAHEDRAL", &[-127i8, -127, 127, 5].bytes()), [0i8, 0, -127, 5].bytes());
    let diagonal = filtered("OCTAHEDRAL", &[10922i16, 10922, 32767, 4].bytes());
    let component = (32767.0 / 3f32.sqrt()).round() as i16;
    let got: Vec<i16> = diagonal.as_chunks().0.iter().map(|bytes| i16::from_le_bytes(*bytes)).collect();
    assert!(got[..3].iter().all(|number| (number - component).abs() <= 2), "{got:?}");
    assert_eq!(got[3], 4);
    // All zeros is no direction; it must still be a number.
    assert_eq!(filtered("OCTAHEDRAL", &[0u8; 4]).len(), 4);
}

#[test]
fn quaternion_filters_restore_the_largest_component() {
    // x = 0.5 / sqrt(2) of the scale 32767, negative y, the largest stored at index 2.
    let packed: [i16; 4] = [16384, -16384, 0, 32764 | 2];
    let got: Vec<i16> =
        filtered("QUATERNION", &packed.bytes()).as_chunks().0.iter().map(|bytes| i16::from_le_bytes(*bytes)).collect();
    let part = 16384.0 / 32767.0 * std::f32::consts::FRAC_1_SQRT_2;
    let largest = (1.0 - 2.0 * part * part).sqrt();
    let expected = [-part, 0.0, largest, part].map(|value| (value * 32767.0).round() as i16);
    assert!(got.iter().zip(expected).all(|(a, b)| (a - b).abs() <= 1), "{got:?} {expected:?}");
}

#[test]
fn exponential_filters_give_floats() {
    let packed = |exponent: i32, mantissa: i32| (exponent << 24) | (mantissa & 0x00ff_ffff);
    let float = |value: i32| f32::from_le_bytes(filtered("EXPONENTIAL", &value.to_le_bytes()).try_into().unwrap());
    assert_eq!(float(packed(-3, 5)), 0.625);
    assert_eq!(float(packed(2, -7)), -28.0);
    assert_eq!(float(packed(-128, 1)), 2f32.powi(-128));
    assert_eq!(float(0), 0.0);
}

#[test]
fn wrong_streams_are_errors() {
    let good = encoded_vertices(&vertices(40));
    let problem = |view: Stream, bytes: &[u8]| decode(&view, bytes).unwrap_err();
    let attributes = || stream("ATTRIBUTES", "NONE", 40, 8);
    for length in 0..good.len() {
        assert!(decode(&attributes(), &good[..length]).is_err(), "{length}");
    }
    assert!(problem(stream("ATTRIBUTES", "NONE", 40, 6), &good).contains("multiple of 4"));
    assert!(problem(stream("ATTRIBUTES", "NONE", 40, 0), &good).contains("byteStride"));
    for count in [1 << 40, usize::MAX] {
        assert!(problem(stream("ATTRIBUTES", "NONE", count, 8), &good).contains("bytes of decoded data; allowed are"));
    }
    assert!(problem(stream("ATTRIBUTES", "NONE", 1 << 24, 8), &good).contains("cut off"));
    assert!(problem(stream("TRIANGLES", "NONE", 3, 4), &good).contains("another kind"));
    assert!(problem(stream("TRIANGLES", "NONE", 4, 4), &good).contains("multiple of 3"));
    assert!(problem(stream("INDICES", "NONE", 1 << 25, 4), &[0xd1; 40]).contains("cut off"));
    assert!(problem(stream("LINES", "NONE", 4, 4), &good).contains("LINES"));
    assert!(problem(stream("ATTRIBUTES", "BLUR", 40, 8), &good).contains("BLUR"));
    assert!(problem(stream("ATTRIBUTES", "NONE", 20, 8), &good).contains("too many"));
    let longer = [&[0xa0], &[0; 12][..], &[0; 32]].concat();
    assert!(problem(stream("ATTRIBUTES", "OCTAHEDRAL", 1, 12), &longer).contains("does not go with byteStride 12"));
    let mut newer = good.clone();
    newer[0] = 0xa2;
    assert!(problem(attributes(), &newer).contains("version 2"));
}

#[test]
fn compressed_views_are_used_in_files() {
    let mut file = File::new();
    let positions = [[0i16, 0, 0, 0], [2, 0, 0, 0], [0, 2, 0, 0]].map(|p| p.map(|number| number as u16));
    let bytes = encoded_vertices(&positions);
    file.binary = bytes.clone();
    file.json["buffers"] = json!([
        { "byteLength": bytes.len() },
        { "byteLength": 24, "extensions": { "EXT_meshopt_compression": { "fallback": true } } },
    ]);
    let compression = json!({
        "buffer": 0, "byteLength": bytes.len(), "byteStride": 8, "mode": "ATTRIBUTES", "count": 3
    });
    file.push(
        "bufferViews",
        json!({
            "buffer": 1, "byteLength": 24, "byteStride": 8,
            "extensions": { "EXT_meshopt_compression": compression },
        }),
    );
    file.push("accessors", json!({ "bufferView": 0, "componentType": I16, "type": "VEC3", "count": 3 }));
    file.show(json!({ "attributes": { "POSITION": 0 } }));
    file.json["extensionsRequired"] = json!(["EXT_meshopt_compression", "KHR_mesh_quantization"]);
    assert_eq!(file.scene().positions, [Vec3::ZERO, Vec3::X * 2.0, Vec3::Y * 2.0]);
    file.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]["count"] = json!(1_000_000_000_000u64);
    file.assert_error("bufferViews[0].extensions.EXT_meshopt_compression");
}

/// A quad, compressed by Draco's own encoder.
fn draco_quad() -> Vec<u8> {
    use draco_core::*;
    let mut mesh = Mesh::new();
    let mut positions = PointAttribute::new();
    positions.init(GeometryAttributeType::Position, 3, DataType::Float32, false, 4);
    for (point, corner) in [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]].iter().enumerate() {
        positions.buffer_mut().write(point * 12, &corner.bytes());
    }
    mesh.add_attribute(positions);
    mesh.set_num_faces(2);
    mesh.set_face(FaceIndex(0), [0u32.into(), 1u32.into(), 2u32.into()]);
    mesh.set_face(FaceIndex(1), [0u32.into(), 2u32.into(), 3u32.into()]);
    let mut encoder = MeshEncoder::new();
    encoder.set_mesh(mesh);
    let mut buffer = EncoderBuffer::new();
    encoder.encode(&EncoderOptions::default(), &mut buffer).unwrap();
    buffer.data().to_vec()
}

pub(super) fn draco_file() -> File {
    let mut file = File::new();
    let view = file.view(&draco_quad());
    file.push("accessors", json!({ "componentType": F32, "type": "VEC3", "count": 4 }));
    file.push("accessors", json!({ "componentType": U16, "type": "SCALAR", "count": 6 }));
    let compressed = json!({ "bufferView": view, "attributes": { "POSITION": 0 } });
    file.show(json!({
        "attributes": { "POSITION": 0 }, "indices": 1, "extensions": { "KHR_draco_mesh_compression": compressed }
    }));
    file.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    file
}

#[test]
fn draco_meshes_are_decompressed() {
    let file = draco_file();
    let scene = file.scene();
    assert_eq!(scene.triangles.len(), 2);
    assert!((scene.bounds.max - Vec3::new(1.0, 1.0, 0.0)).length() < 1e-3 && scene.bounds.min.length() < 1e-3);
    assert!(scene.normals.iter().all(|normal| (*normal - Vec3::Z).length() < 1e-3));
    let mut missing = file.clone();
    missing.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]["attributes"] =
        json!({ "POSITION": 9 });
    missing.assert_error("KHR_draco_mesh_compression.attributes.POSITION: 9; there is no such attribute");
    let mut cut = file;
    cut.json["bufferViews"][0]["byteLength"] = json!(20);
    cut.assert_error("meshes[0].primitives[0].extensions.KHR_draco_mesh_compression: cannot be decompressed");
}
