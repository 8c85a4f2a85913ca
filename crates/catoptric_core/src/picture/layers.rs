//! OpenEXR files: a picture, and further channels beside it.

use crate::framebuffer::Framebuffer;
use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Encoding, FlatSamples, Image, Layer, LayerAttributes, SmallVec, Text,
    WritableImage, f16,
};
use std::io;

/// The attribute of the header that says what the channels hold.
const ATTRIBUTE: &str = "catoptric";

/// A channel beside those of the picture, such as `depth.Z`.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// The layer's name, a point, and the channel's.
    pub name: &'static str,
    /// A value a pixel, rows from the top.
    pub values: ChannelValues,
}

/// The values of a channel.
#[derive(Clone, Debug, PartialEq)]
pub enum ChannelValues {
    /// Light, as the picture's: 16-bit floats where it has them.
    Light(Vec<f32>),
    /// 32-bit floats.
    Float(Vec<f32>),
    /// Whole numbers.
    Number(Vec<u32>),
}

/// The content of an OpenEXR file of a picture with further channels, and JSON about them for its header's attribute
/// `catoptric`. Colours are 16-bit floats if `half`: those that are too bright become the brightest of them.
///
/// # Errors
/// Channels without one value a pixel.
pub fn encode_layers(
    picture: &Framebuffer,
    half: bool,
    channels: Vec<Channel>,
    about: Option<&str>,
) -> io::Result<Vec<u8>> {
    let light = |values: Vec<f32>| if half { FlatSamples::F16(halves(&values)) } else { FlatSamples::F32(values) };
    let own = ["R", "G", "B", "A"]
        .into_iter()
        .enumerate()
        .map(|(channel, name)| (name, light(picture.pixels.iter().map(|pixel| pixel[channel]).collect::<Vec<f32>>())));
    let further = channels.into_iter().map(|Channel { name, values }| match values {
        ChannelValues::Light(values) => (name, light(values)),
        ChannelValues::Float(values) => (name, FlatSamples::F32(values)),
        ChannelValues::Number(values) => (name, FlatSamples::U32(values)),
    });
    encode(picture.width, picture.height, own.chain(further), about)
}

/// The content of an OpenEXR file with the one channel `Y`.
pub(super) fn encode_grey(width: u32, height: u32, values: &[f32]) -> io::Result<Vec<u8>> {
    encode(width, height, [("Y", FlatSamples::F32(values.to_vec()))].into_iter(), None)
}

fn encode(
    width: u32,
    height: u32,
    channels: impl Iterator<Item = (&'static str, FlatSamples)>,
    about: Option<&str>,
) -> io::Result<Vec<u8>> {
    let count = width as usize * height as usize;
    let channels: SmallVec<[AnyChannel<FlatSamples>; 4]> =
        channels.map(|(name, samples)| AnyChannel::new(name, samples)).collect();
    if let Some(channel) = channels.iter().find(|channel| channel.sample_data.len() != count) {
        let problem = format!("{} has {} values for {width}x{height} pixels", channel.name, channel.sample_data.len());
        return Err(io::Error::new(io::ErrorKind::InvalidInput, problem));
    }
    let mut attributes = LayerAttributes::default();
    if let Some(about) = about.and_then(|about| Text::new_or_none(ascii(about))) {
        // One alone: several would be written in no certain order.
        attributes.other.insert(Text::from(ATTRIBUTE), AttributeValue::Text(about));
    }
    let size = (width as usize, height as usize);
    let layer = Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, AnyChannels::sort(channels));
    // EXR is written with seeks: in memory, then.
    let mut bytes = io::Cursor::new(Vec::new());
    Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes).map_err(io::Error::other)?;
    Ok(bytes.into_inner())
}

/// The nearest 16-bit floats, none of them infinite.
fn halves(values: &[f32]) -> Vec<f16> {
    let most = f16::MAX.to_f32();
    values.iter().map(|value| f16::from_f32(value.clamp(-most, most))).collect()
}

/// JSON with all letters beyond ASCII as escapes: text in headers has no known encoding.
fn ascii(json: &str) -> String {
    let mut escaped = String::with_capacity(json.len());
    for letter in json.chars() {
        match letter.is_ascii() {
            true => escaped.push(letter),
            false => letter.encode_utf16(&mut [0; 2]).iter().for_each(|unit| escaped += &format!("\\u{unit:04x}")),
        }
    }
    escaped
}
