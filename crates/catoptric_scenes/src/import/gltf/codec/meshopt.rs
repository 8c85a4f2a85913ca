//! EXT_meshopt_compression: buffer views of attributes, triangles and index sequences, and their filters.
//!
//! Written after the bitstream's description in the extension's specification (Khronos glTF repository,
//! `extensions/2.0/Vendor/EXT_meshopt_compression`, appendices A and B).

use super::super::schema::Meshopt;

/// The extensions that compress buffer views.
pub(in super::super) const EXTENSIONS: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

const CUT_OFF: &str = "the compressed data is cut off";

/// The decompressed bytes of a view: `count` elements of `byteStride` bytes.
pub(in super::super) fn decode(view: &Meshopt, data: &[u8]) -> Result<Vec<u8>, String> {
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
        filter @ ("OCTAHEDRAL" | "QUATERNION") => {
            return Err(format!("filter {filter} does not go with byteStride {stride}"));
        }
        other => {
            return Err(format!("filter is `{other}`; known are NONE, OCTAHEDRAL, QUATERNION and EXPONENTIAL"));
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

/// Appendix A, mode 0: per byte of the element, zigzag differences in groups of 16.
fn decode_attributes(count: usize, stride: usize, data: &[u8]) -> Result<Vec<u8>, String> {
    check_header(data, 0xa0, &[0])?;
    let tail = stride.max(32);
    if data.len() < 1 + tail {
        return Err(CUT_OFF.into());
    }
    let (body, end) = data[1..].split_at(data.len() - 1 - tail);
    let mut last = end[tail - stride..].to_vec();
    let mut reader = Reader(body);
    let block_size = ((8192 / stride) & !(GROUP - 1)).min(256);
    // A block of 256 elements has at least 4 bytes for each byte of an element.
    if count.div_ceil(block_size).saturating_mul(stride) > body.len() {
        return Err(CUT_OFF.into());
    }
    let mut bytes = vec![0u8; count * stride];
    for block in bytes.chunks_mut(block_size * stride) {
        let groups = (block.len() / stride).div_ceil(GROUP);
        for (channel, last) in last.iter_mut().enumerate() {
            let header = reader.take(groups.div_ceil(4))?;
            for group in 0..groups {
                let differences = decode_group((header[group / 4] >> (group % 4 * 2)) & 3, &mut reader)?;
                let elements = block[group * GROUP * stride..].chunks_exact_mut(stride);
                for (element, difference) in elements.zip(differences) {
                    let step = (difference >> 1) ^ 0u8.wrapping_sub(difference & 1);
                    *last = last.wrapping_add(step);
                    element[channel] = *last;
                }
            }
        }
    }
    if !reader.0.is_empty() {
        return Err(format!("{} bytes too many", reader.0.len()));
    }
    Ok(bytes)
}

fn decode_group(mode: u8, reader: &mut Reader<'_>) -> Result<[u8; GROUP], String> {
    let mut values = [0u8; GROUP];
    let bits = match mode {
        0 => return Ok(values),
        1 => 2,
        2 => 4,
        _ => {
            values.copy_from_slice(reader.take(GROUP)?);
            return Ok(values);
        }
    };
    let packed = reader.take(GROUP * bits / 8)?;
    let all_ones = (1u8 << bits) - 1;
    for (index, value) in values.iter_mut().enumerate() {
        let bit = index * bits;
        let code = (packed[bit / 8] >> (8 - bits - bit % 8)) & all_ones;
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

/// Floats as an exponent of 8 bits and a mantissa of 24, both signed.
fn exponential(element: &mut [u8]) {
    let value = i32::from_le_bytes([element[0], element[1], element[2], element[3]]);
    let (exponent, mantissa) = (value >> 24, value << 8 >> 8);
    // Two to a power from -128 to 127, by its bits.
    let scale = f64::from_bits(((exponent + 1023) as u64) << 52);
    let float = (f64::from(mantissa) * scale) as f32;
    element.copy_from_slice(&float.to_le_bytes());
}
