//! OpenEXR pictures, block by block: latitude-longitude ones in their display window, and cube maps.

use super::canvas::{Canvas, Radiance, check_sides};
use super::colors::{Conversion, Primaries};
use super::cube;
use super::exr_header;
use catoptric_core::{exr_blocks, parallel};
use exr::block::chunk::{Chunk, CompressedBlock};
use exr::block::reader::ChunksReader;
use exr::block::{BlockIndex, UncompressedBlock};
use exr::error::Error;
use exr::meta::BlockDescription;
use exr::meta::attribute::{EnvironmentMap, SampleType};
use exr::meta::header::Header;
use glam::DVec2;
use std::collections::HashSet;
use std::io::Cursor;

/// The memory that a block may take when it is decoded, in bytes; that of all blocks which are decoded at once.
const MAX_BLOCK_BYTES: usize = 512 << 20;
const BATCH_BYTES: usize = 64 << 20;
const BATCH_BLOCKS: usize = 64;

/// The longest side of a tile.
const MAX_TILE: usize = 1 << 15;

/// The part of a file that is drawn, and where its colours are.
struct Layer {
    part: usize,
    /// Indices of the channels of red, green and blue; all the same for grey.
    channels: [usize; 3],
    colors: Option<Conversion>,
}

/// The picture in the bytes of an OpenEXR file.
pub(super) fn read(bytes: &[u8], warnings: &mut Vec<String>) -> Result<Radiance, String> {
    let broken = |error: Error| exr_header::explain(bytes, &error);
    let reader = exr::block::read(Cursor::new(bytes), false).map_err(broken)?;
    let headers = reader.headers().to_vec();
    let layer = find_layer(&headers)?;
    headers.iter().try_for_each(check_blocks)?;
    let header = &headers[layer.part];
    let data = header.data_window();
    let is_cube = header.own_attributes.environment_map == Some(EnvironmentMap::Cube);
    // A cube's faces fill the data window.
    let display = if is_cube { data } else { header.shared_attributes.display_window };
    let (width, height) = (display.size.width() as u64, display.size.height() as u64);
    let [x, y] = [(data.position.x(), display.position.x()), (data.position.y(), display.position.y())]
        .map(|(data, display)| i64::from(data) - i64::from(display));
    check_sides(data.size.width() as u64, data.size.height() as u64)?;
    if x >= width as i64
        || y >= height as i64
        || x + data.size.width() as i64 <= 0
        || y + data.size.height() as i64 <= 0
    {
        return Err("has its data window beside its display window: nothing of it would be seen".into());
    }
    if is_cube {
        let mut faces = cube::Faces::new(width, height)?;
        decode(bytes, header, &layer, &mut |x, y, radiance| faces.set(x, y, radiance))?;
        return faces.into_radiance(warnings);
    }
    let mut canvas = Canvas::new(width, height, warnings)?;
    decode(bytes, header, &layer, &mut |column, row, radiance| {
        if let (Ok(column), Ok(row)) = (usize::try_from(column as i64 + x), usize::try_from(row as i64 + y)) {
            canvas.set(column, row, radiance);
        }
    })?;
    Ok(canvas.into_radiance())
}

/// The first part with colours: channels R, G and B, of whatever layer if there is one, or grey from Y.
fn find_layer(headers: &[Header]) -> Result<Layer, String> {
    let mut problem = String::new();
    for (part, header) in headers.iter().enumerate() {
        match find_channels(header) {
            Ok(channels) => {
                let colors = header.shared_attributes.chromaticities.and_then(|places| {
                    let place = |at: exr::math::Vec2<f32>| DVec2::new(f64::from(at.x()), f64::from(at.y()));
                    let [red, green, blue, white] = [places.red, places.green, places.blue, places.white].map(place);
                    Primaries { red, green, blue, white }.to_rec_709()
                });
                // Grey is the luminance of white, whatever the primaries are.
                let is_grey = channels[0] == channels[1];
                let colors = colors.filter(|_| !is_grey);
                return Ok(Layer { part, channels, colors });
            }
            Err(of_part) if problem.is_empty() => problem = of_part,
            Err(_) => {}
        }
    }
    Err(problem)
}

/// The channels of red, green and blue of a part.
fn find_channels(header: &Header) -> Result<[usize; 3], String> {
    let channels = &header.channels.list;
    let names: Vec<String> = channels.iter().map(|channel| channel.name.to_string()).collect();
    let index = |name: String| names.iter().position(|other| *other == name);
    let all = |prefix: &str, letters: [&str; 3]| {
        let [first, second, third] = letters.map(|letter| index(format!("{prefix}{letter}")));
        Some([first?, second?, third?])
    };
    let mut prefixes: Vec<&str> = names.iter().map(|name| &name[..name.rfind('.').map_or(0, |dot| dot + 1)]).collect();
    prefixes.sort_unstable();
    prefixes.dedup();
    let mut found: Vec<(&str, [usize; 3])> =
        prefixes.iter().filter_map(|prefix| Some((*prefix, all(prefix, ["R", "G", "B"])?))).collect();
    let has = |list: &str| exr_header::channels_told(names.iter().map(String::as_str), list);
    if found.len() > 1 {
        // Among several layers the one without a name is the picture, then what renderers call the combined one.
        let is_whole = |prefix: &str| prefix.is_empty() || prefix.ends_with("Combined.");
        found.retain(|(prefix, _)| is_whole(prefix));
        found.truncate(if found.first().is_some_and(|(prefix, _)| prefix.is_empty()) { 1 } else { found.len() });
        if found.len() != 1 {
            return Err(has("several layers have R, G and B: save the one that is wanted alone"));
        }
    }
    let is_grey = |prefix: &&str| {
        index(format!("{prefix}Y")).is_some()
            && ["X", "RY", "BY"].iter().all(|letter| index(format!("{prefix}{letter}")).is_none())
    };
    let chosen = match found.first() {
        Some((_, chosen)) => *chosen,
        None => {
            let grey = prefixes.iter().find(|prefix| is_grey(prefix)).and_then(|prefix| index(format!("{prefix}Y")));
            [grey.ok_or_else(|| has("an environment needs R, G and B, or grey as Y alone: save it so"))?; 3]
        }
    };
    if chosen.iter().any(|channel| channels[*channel].sampling != exr::math::Vec2(1, 1)) {
        return Err(has("some at a lower resolution; all must have the same: save it so"));
    }
    Ok(chosen)
}

/// Refuses blocks that take much memory.
fn check_blocks(header: &Header) -> Result<(), String> {
    if let BlockDescription::Tiles(tiles) = header.blocks {
        let (width, height) = (tiles.tile_size.width(), tiles.tile_size.height());
        if !(1..=MAX_TILE).contains(&width) || !(1..=MAX_TILE).contains(&height) {
            return Err(format!("has tiles of {width} x {height} pixels; allowed are 1 to {MAX_TILE} a side"));
        }
    }
    let bytes = header.max_block_byte_size();
    if bytes > MAX_BLOCK_BYTES {
        return Err(format!("has blocks of {bytes} bytes; allowed are {MAX_BLOCK_BYTES}: save it in scanlines"));
    }
    Ok(())
}

/// Decodes a layer, and calls `set` for each of its pixels by column and row in the data window.
fn decode(
    bytes: &[u8],
    header: &Header,
    layer: &Layer,
    set: &mut dyn FnMut(usize, usize, [f32; 3]),
) -> Result<(), String> {
    let broken = |error: Error| exr_header::explain(bytes, &error);
    let is_wanted = |block: &BlockIndex| block.layer == layer.part && block.level == exr::math::Vec2(0, 0);
    let mut chunks = exr::block::read(Cursor::new(bytes), false)
        .and_then(|reader| reader.filter_chunks(false, |_, _, block| is_wanted(&block)))
        .map_err(broken)?;
    let metadata = chunks.meta_data().clone();
    let at_once = (BATCH_BYTES / header.max_block_byte_size().max(1)).clamp(1, BATCH_BLOCKS);
    let (mut seen, mut pixels) = (HashSet::new(), 0);
    loop {
        let batch: Vec<Chunk> = chunks.by_ref().take(at_once).collect::<Result<_, Error>>().map_err(broken)?;
        if batch.is_empty() {
            break;
        }
        // A broken table of offsets may lead to other chunks.
        if batch.iter().any(|chunk| chunk.layer_index != layer.part || !is_largest_level(chunk)) {
            return Err("is broken: its table of offsets leads astray; save it again".into());
        }
        batch.iter().try_for_each(|chunk| exr_blocks::check(chunk, header))?;
        let mut batch: Vec<(Option<Chunk>, Option<exr::error::Result<UncompressedBlock>>)> =
            batch.into_iter().map(|chunk| (Some(chunk), None)).collect();
        parallel::for_each_mut(&mut batch, |_, (chunk, block)| {
            *block = chunk.take().map(|chunk| UncompressedBlock::decompress_chunk(chunk, &metadata, false));
        });
        for block in batch.into_iter().filter_map(|(_, block)| block) {
            let block = block.map_err(broken)?;
            if !seen.insert((block.index.pixel_position.x(), block.index.pixel_position.y())) {
                return Err("is broken: it has a block twice; save it again".into());
            }
            pixels += block.index.pixel_size.area();
            fill(&block, header, layer, set).map_err(broken)?;
        }
    }
    match pixels == header.layer_size.area() {
        true => Ok(()),
        false => Err("lacks some of its blocks: it was not written to its end; save it again".into()),
    }
}

/// Returns true for blocks of the picture itself, not of its reductions.
fn is_largest_level(chunk: &Chunk) -> bool {
    match &chunk.compressed_block {
        CompressedBlock::Tile(tile) => tile.coordinates.is_largest_resolution_level(),
        _ => true,
    }
}

/// Sets the pixels of a block.
fn fill(
    block: &UncompressedBlock,
    header: &Header,
    layer: &Layer,
    set: &mut dyn FnMut(usize, usize, [f32; 3]),
) -> Result<(), Error> {
    let last = header.channels.list.len() - 1;
    let mut row = vec![[0.0f32; 3]; block.index.pixel_size.width()];
    for line in block.lines(&header.channels) {
        let channel = line.location.channel;
        for (color, _) in layer.channels.iter().enumerate().filter(|(_, wanted)| **wanted == channel) {
            let mut put = |place: usize, value: f32| {
                if let Some(pixel) = row.get_mut(place) {
                    pixel[color] = value;
                }
            };
            match header.channels.list[channel].sample_type {
                SampleType::F16 => {
                    for (place, value) in line.read_samples::<exr::prelude::f16>().enumerate() {
                        put(place, value?.to_f32());
                    }
                }
                SampleType::F32 => {
                    for (place, value) in line.read_samples::<f32>().enumerate() {
                        put(place, value?);
                    }
                }
                SampleType::U32 => {
                    for (place, value) in line.read_samples::<u32>().enumerate() {
                        put(place, value? as f32);
                    }
                }
            }
        }
        if channel == last {
            for (place, pixel) in row.iter().enumerate() {
                let color = layer.colors.as_ref().map_or(*pixel, |colors| colors.of(*pixel));
                set(line.location.position.x() + place, line.location.position.y(), color);
            }
        }
    }
    Ok(())
}
