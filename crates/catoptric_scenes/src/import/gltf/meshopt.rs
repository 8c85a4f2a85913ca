//! EXT_meshopt_compression and KHR_meshopt_compression: buffer views of attributes, triangles and index sequences, and
//! their filters.
//!
//! Written after the bitstream's description in the extension's specification (Khronos glTF repository,
//! `extensions/2.0/Vendor/EXT_meshopt_compression`, appendices A and B); version 1 of attributes and colours after what
//! meshoptimizer 1.0 writes.

use super::schema::Meshopt;

/// The extensions that compress buffer views.
pub(super) const EXTENSIONS: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

const CUT_OFF: &str = "the compressed data is cut off";

/// The decompressed bytes of a view: `count` elements of `byteStride` bytes.
pub(super) fn decode(view: &Meshopt, data: &[u8]) -> Result<Vec<u8>, String> {
    let size = view.count.checked_mul(view.byte_stride).and_then(|size| usize::try_from(size).ok());
    let (Some(size), Ok(stride)) = (size, usize::try_from(view.byte_stride)) else {
        return Err("count times byteStride is too large".into());
    };
    let count = size.checked_div(stride).unwrap_or(0);
    let mut bytes = match view.mode.as_str() {
        "ATTRIBUTES" if stride == 0 || stride > 256 || !stride.is_multiple_of(4) => {
            return Err(format!("byteStride is {stride}; attributes need a multiple of 4 up to 256"));
        }
        "ATTRIBUTES" => decode_attributes(count, stride, data)?,
        "TRIANGLES" | "INDICES" if stride != 2 && stride != 4 => {
            return Err(format!("byteStride is {stride}; indices need 2 or 4"));
        }
        "TRIANGLES" if !count.is_multiple_of(3) => return Err(format!("count is {count}, which is no multiple of 3")),
        "TRIANGLES" => index_bytes(&decode_triangles(count, data)?, stride),
        "INDICES" => index_bytes(&decode_indices(count, data)?, stride),
        other => return Err(format!("mode is `{other}`; known are ATTRIBUTES, TRIANGLES and INDICES")),
    };
    match view.filter.as_deref().unwrap_or("NONE") {
        "NONE" => {}
        _ if view.mode != "ATTRIBUTES" => return Err("only attributes may have a filter".into()),
        "OCTAHEDRAL" if stride == 4 => bytes.chunks_exact_mut(4).for_each(octahedral_8),
        "OCTAHEDRAL" if stride == 8 => bytes.chunks_exact_mut(8).for_each(octahedral_16),
        "QUATERNION" if stride == 8 => bytes.chunks_exact_mut(8).for_each(quaternion),
        "EXPONENTIAL" => bytes.chunks_exact_mut(4).for_each(exponential),
        "COLOR" if stride == 4 => bytes.chunks_exact_mut(4).for_each(|element| color(element, 1)),
        "COLOR" if stride == 8 => bytes.chunks_exact_mut(8).for_each(|element| color(element, 2)),
        filter @ ("OCTAHEDRAL" | "QUATERNION" | "COLOR") => {
            return Err(format!("filter {filter} does not go with byteStride {stride}"));
        }
        other => {
            return Err(format!("filter is `{other}`; known are NONE, OCTAHEDRAL, QUATERNION, EXPONENTIAL and COLOR"));
        }
    }
    Ok(bytes)
}

/// Reads bytes from the front.
struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let (head, rest) = self.0.split_at_checked(count).ok_or(CUT_OFF)?;
        self.0 = rest;
        Ok(head)
    }

    fn byte(&mut self) -> Result<u8, String> {
        Ok(self.take(1)?[0])
    }

    /// A number in groups of 7 bits, lowest first.
    fn varint(&mut self) -> Result<u32, String> {
        let mut value = 0u32;
        for shift in (0..35).step_by(7) {
            let byte = self.byte()?;
            value |= u32::from(byte & 127).wrapping_shl(shift);
            if byte < 128 {
                return Ok(value);
            }
        }
        Err("a number has more than 32 bits".into())
    }

    /// A signed difference to `last`.
    fn index(&mut self, last: u32) -> Result<u32, String> {
        let value = self.varint()?;
        Ok(last.wrapping_add(unzigzag(value)))
    }
}

fn unzigzag(value: u32) -> u32 {
    (value >> 1) ^ 0u32.wrapping_sub(value & 1)
}

fn check_header(data: &[u8], kind: u8, versions: &[u8]) -> Result<u8, String> {
    let header = *data.first().ok_or(CUT_OFF)?;
    if header & 0xf0 != kind {
        return Err(format!("the data begins with {header:#x}, which is another kind of stream"));
    }
    let version = header & 15;
    if !versions.contains(&version) {
        return Err(format!("version {version} of the stream; known are {versions:?}"));
    }
    Ok(version)
}

const GROUP: usize = 16;

/// The most elements of a block.
const MAX_BLOCK: usize = 256;

/// Appendix A, mode 0: the bytes of elements in groups of 16, as differences to the element before. Version 1 has four
/// ways of storing the bytes of a block, and three kinds of differences.
fn decode_attributes(count: usize, stride: usize, data: &[u8]) -> Result<Vec<u8>, String> {
    let version = check_header(data, 0xa0, &[0, 1])?;
    // At the end stand the first element's predecessor and, in version 1, the kinds of differences; padded.
    let (kept, tail) =
        if version == 0 { (stride, stride.max(32)) } else { (stride + stride / 4, (stride + stride / 4).max(24)) };
    if data.len() < 1 + tail {
        return Err(CUT_OFF.into());
    }
    let (body, end) = data[1..].split_at(data.len() - 1 - tail);
    let (last, kinds) = end[tail - kept..].split_at(stride);
    let mut last = last.to_vec();
    let mut reader = Reader(body);
    let block_size = ((8192 / stride) & !(GROUP - 1)).min(MAX_BLOCK);
    // A block has at least a byte for each byte of an element, in version 1 two bits.
    let least = if version == 0 { stride } else { stride / 4 };
    if count.div_ceil(block_size).saturating_mul(least) > body.len() {
        return Err(CUT_OFF.into());
    }
    let mut bytes = vec![0u8; count * stride];
    let mut planes = [[0u8; MAX_BLOCK]; 4];
    for block in bytes.chunks_mut(block_size * stride) {
        let elements = block.len() / stride;
        let controls = if version == 0 { None } else { Some(reader.take(stride / 4)?) };
        for word in 0..stride / 4 {
            for (byte, plane) in planes.iter_mut().enumerate() {
                let control = controls.map(|controls| (controls[word] >> (byte * 2)) & 3);
                decode_plane(control, &mut plane[..elements], &mut reader)?;
            }
            let kind = kinds.get(word).copied().unwrap_or(0);
            let last = &mut last[word * 4..word * 4 + 4];
            for (index, element) in block.chunks_exact_mut(stride).enumerate() {
                let differences = planes.each_ref().map(|plane| plane[index]);
                let next = next_word([last[0], last[1], last[2], last[3]], differences, kind)?;
                last.copy_from_slice(&next);
                element[word * 4..word * 4 + 4].copy_from_slice(&next);
            }
        }
    }
    if !reader.0.is_empty() {
        return Err(format!("{} bytes too many", reader.0.len()));
    }
    Ok(bytes)
}

/// One byte of all elements of a block. `control`: of version 1, 0 and 1 for groups, 2 for zeros, 3 for bytes as they
/// are.
fn decode_plane(control: Option<u8>, plane: &mut [u8], reader: &mut Reader<'_>) -> Result<(), String> {
    let widths = match control {
        None => [0, 2, 4, 8],
        Some(0) => [0, 1, 2, 4],
        Some(1) => [1, 2, 4, 8],
        Some(2) => {
            plane.fill(0);
            return Ok(());
        }
        Some(_) => {
            plane.copy_from_slice(reader.take(plane.len())?);
            return Ok(());
        }
    };
    let header = reader.take(plane.len().div_ceil(GROUP).div_ceil(4))?;
    for (group, values) in plane.chunks_mut(GROUP).enumerate() {
        let decoded = decode_group(widths[usize::from((header[group / 4] >> (group % 4 * 2)) & 3)], reader)?;
        values.copy_from_slice(&decoded[..values.len()]);
    }
    Ok(())
}

/// Four bytes of an element by those of the one before: differences of bytes or of 16-bit numbers, or all 32 bits that
/// have changed, turned.
fn next_word(last: [u8; 4], differences: [u8; 4], kind: u8) -> Result<[u8; 4], String> {
    let halves = |bytes: [u8; 4]| [u16::from_le_bytes([bytes[0], bytes[1]]), u16::from_le_bytes([bytes[2], bytes[3]])];
    Ok(match kind & 3 {
        0 => std::array::from_fn(|byte| last[byte].wrapping_add(unzigzag(differences[byte].into()) as u8)),
        1 => {
            let ([a, b], [da, db]) = (halves(last), halves(differences));
            let [a, b] = [(a, da), (b, db)].map(|(last, step)| last.wrapping_add(unzigzag(step.into()) as u16));
            let ([a, b], [c, d]) = (a.to_le_bytes(), b.to_le_bytes());
            [a, b, c, d]
        }
        2 => {
            let turned = u32::from_le_bytes(differences).rotate_right(u32::from(kind >> 4));
            (turned ^ u32::from_le_bytes(last)).to_le_bytes()
        }
        _ => return Err("a kind of differences is 3; known are 0 to 2".into()),
    })
}

/// A group of values of so many bits each; the largest stands for a byte that follows the group.
fn decode_group(bits: usize, reader: &mut Reader<'_>) -> Result<[u8; GROUP], String> {
    let mut values = [0u8; GROUP];
    match bits {
        0 => return Ok(values),
        8 => {
            values.copy_from_slice(reader.take(GROUP)?);
            return Ok(values);
        }
        _ => {}
    }
    let packed = reader.take(GROUP * bits / 8)?;
    let all_ones = (1u8 << bits) - 1;
    for (index, value) in values.iter_mut().enumerate() {
        let bit = index * bits;
        // Single bits begin at the lowest one, others at the highest.
        let shift = if bits == 1 { bit % 8 } else { 8 - bits - bit % 8 };
        let code = (packed[bit / 8] >> shift) & all_ones;
        *value = if code == all_ones { reader.byte()? } else { code };
    }
    Ok(values)
}

/// Recently used values; older ones are overwritten.
struct Fifo<T> {
    entries: [T; 16],
    next: usize,
}

impl<T: Copy> Fifo<T> {
    fn new(initial: T) -> Self {
        Self { entries: [initial; 16], next: 0 }
    }

    fn push(&mut self, value: T) {
        self.entries[self.next & 15] = value;
        self.next += 1;
    }

    /// The value pushed `back` pushes ago; 1 is the last.
    fn back(&self, back: usize) -> T {
        self.entries[(self.next.wrapping_sub(back)) & 15]
    }
}

/// Appendix A, mode 1: triangles by their edges and vertices used of late.
fn decode_triangles(count: usize, data: &[u8]) -> Result<Vec<u32>, String> {
    let version = check_header(data, 0xe0, &[0, 1])?;
    let triangles = count / 3;
    if data.len() < 1 + triangles + 16 {
        return Err(CUT_OFF.into());
    }
    let (codes, rest) = data[1..].split_at(triangles);
    let (body, table) = rest.split_at(rest.len() - 16);
    let mut reader = Reader(body);
    let mut edges = Fifo::new([u32::MAX; 2]);
    let mut vertices = Fifo::new(u32::MAX);
    let (mut next, mut last) = (0u32, 0u32);
    let fifo_codes = if version >= 1 { 13 } else { 15 };
    let mut indices = Vec::with_capacity(count);
    let mut take_next = |reset: bool| {
        let value = if reset { 0 } else { next };
        next = value.wrapping_add(1);
        value
    };
    for &code in codes {
        let (a, b, c);
        if code < 0xf0 {
            [a, b] = edges.back((code >> 4) as usize + 1);
            let low = (code & 15) as usize;
            if low == 0 {
                c = take_next(false);
                vertices.push(c);
            } else if low < fifo_codes {
                c = vertices.back(low + 1);
            } else {
                c = match low {
                    13 => last.wrapping_sub(1),
                    14 => last.wrapping_add(1),
                    _ => reader.index(last)?,
                };
                last = c;
                vertices.push(c);
            }
            edges.push([c, b]);
            edges.push([a, c]);
        } else {
            let from_table = code < 0xfe;
            let pair = if from_table { table[(code & 15) as usize] } else { reader.byte()? };
            let (high, low) = ((pair >> 4) as usize, (pair & 15) as usize);
            let free = |code: usize| code == 15 && !from_table;
            let a_is_free = code == 0xff;
            // A new vertex takes the next number, in order; only then are the free ones read.
            let reset = !from_table && pair == 0;
            let mut corner = [0u32; 3];
            corner[0] = if a_is_free { 0 } else { take_next(reset) };
            corner[1] = match high {
                0 => take_next(reset && a_is_free),
                _ => vertices.back(high),
            };
            corner[2] = if low == 0 { take_next(false) } else { vertices.back(low) };
            for (value, is_free) in corner.iter_mut().zip([a_is_free, free(high), free(low)]) {
                if is_free {
                    *value = reader.index(last)?;
                    last = *value;
                }
            }
            [a, b, c] = corner;
            vertices.push(a);
            for (value, is_new) in [(b, high == 0 || free(high)), (c, low == 0 || free(low))] {
                if is_new {
                    vertices.push(value);
                }
            }
            edges.push([b, a]);
            edges.push([c, b]);
            edges.push([a, c]);
        }
        indices.extend([a, b, c]);
    }
    if !reader.0.is_empty() {
        return Err(format!("{} bytes too many", reader.0.len()));
    }
    Ok(indices)
}

/// Appendix A, mode 2: differences to one of two baselines.
fn decode_indices(count: usize, data: &[u8]) -> Result<Vec<u32>, String> {
    check_header(data, 0xd0, &[0, 1])?;
    if data.len() < 1 + count + 4 {
        return Err(CUT_OFF.into());
    }
    let mut reader = Reader(&data[1..data.len() - 4]);
    let mut last = [0u32; 2];
    let mut indices = Vec::with_capacity(count);
    for _ in 0..count {
        let value = reader.varint()?;
        let baseline = &mut last[(value & 1) as usize];
        *baseline = baseline.wrapping_add(unzigzag(value >> 1));
        indices.push(*baseline);
    }
    if !reader.0.is_empty() {
        return Err(format!("{} bytes too many", reader.0.len()));
    }
    Ok(indices)
}

fn index_bytes(indices: &[u32], stride: usize) -> Vec<u8> {
    indices.iter().flat_map(|index| index.to_le_bytes().into_iter().take(stride)).collect()
}

/// Unfolds an octahedron to unit vectors; `one` is the input's value for 1.
fn octahedral(x: f32, y: f32, one: f32) -> [f32; 3] {
    let (mut x, mut y) = (x / one, y / one);
    let z = 1.0 - x.abs() - y.abs();
    let fold = (-z).max(0.0);
    x -= fold.copysign(x);
    y -= fold.copysign(y);
    let length = (x * x + y * y + z * z).sqrt();
    [x / length, y / length, z / length]
}

fn octahedral_8(element: &mut [u8]) {
    let [x, y, one] = [0, 1, 2].map(|i| element[i] as i8 as f32);
    for (byte, value) in element.iter_mut().zip(octahedral(x, y, one)) {
        *byte = (value * 127.0).round() as i8 as u8;
    }
}

fn word(element: &[u8], index: usize) -> i16 {
    i16::from_le_bytes([element[index * 2], element[index * 2 + 1]])
}

fn set_word(element: &mut [u8], index: usize, value: f32) {
    element[index * 2..index * 2 + 2].copy_from_slice(&((value * 32767.0).round() as i16).to_le_bytes());
}

fn octahedral_16(element: &mut [u8]) {
    let [x, y, one] = [0, 1, 2].map(|i| word(element, i) as f32);
    for (index, value) in octahedral(x, y, one).into_iter().enumerate() {
        set_word(element, index, value);
    }
}

/// Three components of a unit quaternion, the largest left out.
fn quaternion(element: &mut [u8]) {
    let packed = word(element, 3);
    let scale = std::f32::consts::FRAC_1_SQRT_2 / (packed | 3) as f32;
    let [x, y, z] = [0, 1, 2].map(|i| word(element, i) as f32 * scale);
    let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    let largest = (packed & 3) as usize;
    for (offset, value) in [w, x, y, z].into_iter().enumerate() {
        set_word(element, (largest + offset) & 3, value);
    }
}

/// Luma, two differences of colour and alpha, of so many bytes each, as red, green, blue and alpha. The highest bit of
/// alpha tells how many bits all of them have.
fn color(element: &mut [u8], bytes: usize) {
    let number = |index: usize| {
        let at = &element[index * bytes..];
        if bytes == 1 { i32::from(at[0] as i8) } else { i32::from(i16::from_le_bytes([at[0], at[1]])) }
    };
    let largest = (1i32 << (8 * bytes)) - 1;
    let [luma, alpha] = [0, 3].map(|index| number(index) & largest);
    let [orange, green] = [1, 2].map(number);
    let top_bit = 31 - (alpha as u32 | 1).leading_zeros();
    let all_ones = (2i32 << top_bit) - 1;
    let alpha = ((alpha << 1) & all_ones) | (alpha & 1);
    let scale = largest as f32 / all_ones as f32;
    let colors = [luma + orange - green, luma + green, luma - orange - green, alpha];
    for (place, value) in element.chunks_exact_mut(bytes).zip(colors) {
        let scaled = ((value as f32 * scale + 0.5) as i32).clamp(0, largest);
        place.copy_from_slice(&scaled.to_le_bytes()[..bytes]);
    }
}

/// Floats as an exponent of 8 bits and a mantissa of 24, both signed.
fn exponential(element: &mut [u8]) {
    let value = i32::from_le_bytes([element[0], element[1], element[2], element[3]]);
    let (exponent, mantissa) = (value >> 24, value << 8 >> 8);
    // Two to a power from -128 to 127, by its bits.
    let scale = f64::from_bits(((exponent + 1023) as u64) << 52);
    let float = (f64::from(mantissa) * scale) as f32;
    element.copy_from_slice(&float.to_le_bytes());
}
