//! Faults in parts of a file that may not be drawn: they give warnings, and the rest is drawn.
//!
//! In a part that is drawn the same fault is an error.

use super::accessors::is_too_long;
use super::schema::{Document, Texture};
use super::source::Source;

/// Warns of indices that point nowhere and of ranges outside their data.
pub(super) fn warn_of_faults(source: &Source<'_>) {
    check_buffers(source);
    check_accessors(source);
    check_textures(source);
    check_meshes(source);
}

fn check_index(source: &Source<'_>, index: Option<usize>, count: usize, field: impl FnOnce() -> String, list: &str) {
    if let Some(index) = index.filter(|index| *index >= count) {
        source.warn(format!("{}: there is no {list}[{index}]; the file has {count}", field()));
    }
}

fn check_buffers(source: &Source<'_>) {
    let document = source.document;
    if let (Some(first), Some(binary)) = (document.buffers.first(), source.binary())
        && first.uri.is_none()
        && first.byte_length > binary.len() as u64
    {
        let length = first.byte_length;
        source.warn(format!("buffers[0].byteLength: {length} bytes, but only {} are there", binary.len()));
    }
    for (index, view) in document.buffer_views.iter().enumerate() {
        let field = || format!("bufferViews[{index}].buffer");
        check_index(source, view.buffer, document.buffers.len(), field, "buffers");
        let Some(buffer) = view.buffer.and_then(|buffer| document.buffers.get(buffer)) else { continue };
        if view.byte_offset.saturating_add(view.byte_length) > buffer.byte_length {
            let (length, offset, size) = (view.byte_length, view.byte_offset, buffer.byte_length);
            source.warn(format!("bufferViews[{index}]: {length} bytes from byte {offset} in a buffer of {size} bytes"));
        }
    }
}

fn check_accessors(source: &Source<'_>) {
    let document = source.document;
    let views = document.buffer_views.len();
    for (index, accessor) in document.accessors.iter().enumerate() {
        check_index(source, accessor.buffer_view, views, || format!("accessors[{index}].bufferView"), "bufferViews");
        if let Some(view) = accessor.buffer_view.and_then(|view| document.buffer_views.get(view))
            && is_too_long(accessor, view)
        {
            let (count, size) = (accessor.count, view.byte_length);
            source.warn(format!("accessors[{index}]: {count} elements are more than the {size} bytes of its view"));
        }
        let Some(sparse) = &accessor.sparse else { continue };
        let field = |part: &str| format!("accessors[{index}].sparse.{part}");
        if sparse.count == 0 || sparse.count > accessor.count {
            source.warn(format!("{}: {} of {} elements", field("count"), sparse.count, accessor.count));
        }
        check_index(source, sparse.indices.buffer_view, views, || field("indices.bufferView"), "bufferViews");
        check_index(source, sparse.values.buffer_view, views, || field("values.bufferView"), "bufferViews");
    }
}

fn check_textures(source: &Source<'_>) {
    let Document { textures, images, samplers, buffer_views, .. } = source.document;
    for (index, Texture { sampler, source: picture, extensions }) in textures.iter().enumerate() {
        check_index(source, *sampler, samplers.len(), || format!("textures[{index}].sampler"), "samplers");
        check_index(source, *picture, images.len(), || format!("textures[{index}].source"), "images");
        for (key, extension) in extensions {
            let picture = extension.get("source").and_then(|number| number.as_u64());
            let picture = picture.map(|number| usize::try_from(number).unwrap_or(usize::MAX));
            check_index(
                source,
                picture,
                images.len(),
                || format!("textures[{index}].extensions.{key}.source"),
                "images",
            );
        }
    }
    for (index, image) in images.iter().enumerate() {
        let field = || format!("images[{index}].bufferView");
        check_index(source, image.buffer_view, buffer_views.len(), field, "bufferViews");
    }
}

fn check_meshes(source: &Source<'_>) {
    let document = source.document;
    let count = document.accessors.len();
    for (mesh, part, primitive) in (document.meshes.iter().enumerate())
        .flat_map(|(mesh, entry)| entry.primitives.iter().enumerate().map(move |(part, p)| (mesh, part, p)))
    {
        let field = |rest: &str| format!("meshes[{mesh}].primitives[{part}].{rest}");
        check_index(source, primitive.indices, count, || field("indices"), "accessors");
        for (name, accessor) in &primitive.attributes {
            check_index(source, Some(*accessor), count, || field(&format!("attributes.{name}")), "accessors");
        }
        for (target, attributes) in primitive.targets.iter().enumerate() {
            for (name, accessor) in attributes {
                check_index(
                    source,
                    Some(*accessor),
                    count,
                    || field(&format!("targets[{target}].{name}")),
                    "accessors",
                );
            }
        }
    }
}
