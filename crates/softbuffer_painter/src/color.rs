//! Colours in one word: alpha, red, green and blue from the highest byte on, premultiplied, in gamma space. Operations
//! work on two channels at a time, each in a lane of sixteen bits.

use egui::Color32;

/// Two channels of four.
const LANES: u32 = 0x00ff_00ff;

/// A half of 255 in both lanes, for rounding.
const HALVES: u32 = 0x0080_0080;

/// The channels without alpha: what a window takes.
pub(crate) const OPAQUE_CHANNELS: u32 = 0x00ff_ffff;

pub(crate) const WHITE: u32 = u32::MAX;

/// A colour of egui.
pub(crate) fn packed(color: Color32) -> u32 {
    let [red, green, blue, alpha] = color.to_array();
    u32::from_be_bytes([alpha, red, green, blue])
}

pub(crate) fn alpha(color: u32) -> u32 {
    color >> 24
}

/// All channels times `share` / 255, rounded.
#[inline]
fn scaled(color: u32, share: u32) -> u32 {
    let divided = |lanes: u32| {
        let product = lanes * share + HALVES;
        ((product + ((product >> 8) & LANES)) >> 8) & LANES
    };
    divided(color & LANES) | (divided((color >> 8) & LANES) << 8)
}

/// The sum of both, at most 255 a channel: colours that only add light have less alpha than colour.
#[inline]
fn sum(one: u32, other: u32) -> u32 {
    let capped = |one: u32, other: u32| {
        let sum = (one & LANES) + (other & LANES);
        let over = sum & 0x0100_0100;
        (sum | (over - (over >> 8))) & LANES
    };
    capped(one, other) | (capped(one >> 8, other >> 8) << 8)
}

/// A colour over an opaque one, as a window takes it.
#[inline]
pub(crate) fn over(color: u32, beneath: u32) -> u32 {
    sum(color, scaled(beneath, 255 - alpha(color))) & OPAQUE_CHANNELS
}

/// The product of both, channel by channel.
#[inline]
pub(crate) fn product(one: u32, other: u32) -> u32 {
    if one == WHITE {
        return other;
    }
    let channel = |shift: u32| {
        let product = ((one >> shift) & 255) * ((other >> shift) & 255) + 128;
        ((product + (product >> 8)) >> 8) << shift
    };
    channel(0) | channel(8) | channel(16) | channel(24)
}

/// The mixture of two colours; `share` is the second one's, of 256.
#[inline]
pub(crate) fn between(one: u32, other: u32, share: u32) -> u32 {
    let mixed =
        |one: u32, other: u32| (((one & LANES) * (256 - share) + (other & LANES) * share + HALVES) >> 8) & LANES;
    mixed(one, other) | (mixed(one >> 8, other >> 8) << 8)
}
