//! The light from infinity and of other surfaces that arrives at surfaces, as a table for shaders.

use catoptric::scene::Sky;

/// Texels of what arrives at a place.
const ARRIVING_TEXELS: usize = 3;

/// The texels that lie behind the first of a table: nodes, one each, with the places of others in the table, and behind
/// them what arrives at places, which is the share of the sky and the irradiance by surfaces on one side, then on the
/// other. Empty without a sky.
pub fn sky_texels(sky: Option<&Sky>, first: usize) -> Vec<[u32; 4]> {
    let Some(sky) = sky else { return Vec::new() };
    let nodes = sky.nodes();
    let behind_nodes = first + nodes.len();
    let place = |corner: u32| (behind_nodes + corner as usize * ARRIVING_TEXELS) as u32;
    let part = |part: u32| if part == 0 { 0 } else { first as u32 + part };
    let node = |[a, b, c, parts]: [u32; 4]| [place(a), place(b), place(c), part(parts)];
    let mut texels: Vec<[u32; 4]> = nodes.map(node).collect();
    for [[share, other_share], [scattered, other_scattered]] in sky.arriving() {
        let numbers = [share, scattered, other_share, other_scattered].map(|light| light.to_array().map(f32::to_bits));
        let numbers = numbers.concat();
        texels.extend(numbers.chunks_exact(4).map(|four| std::array::from_fn(|index| four[index])));
    }
    texels
}
