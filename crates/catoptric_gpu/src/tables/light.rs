//! Lights and the environment as tables for shaders.

use crate::error::GpuError;
use crate::layout::{ENVIRONMENT_MAPS, LightRecord, MAX_LIGHTS, MAX_REDUCTIONS};
use catoptric::scene::{LightKind, LightMap, Scene, Sky};

/// The records of a scene's lights, those of its sky's suns behind them, then empty ones: [`MAX_LIGHTS`] in all.
///
/// # Errors
/// [`GpuError::Limit`] for more than [`MAX_LIGHTS`].
pub fn light_records(scene: &Scene) -> Result<Vec<LightRecord>, GpuError> {
    let suns = scene.sky.as_deref().map_or(&[][..], Sky::suns);
    if scene.lights.len() + suns.len() > MAX_LIGHTS {
        return Err(GpuError::Limit {
            what: "the scene".into(),
            needed: format!("{} lights", scene.lights.len()),
            allowed: MAX_LIGHTS.to_string(),
            remedy: "leave out the faintest, or use the CPU backend",
        });
    }
    let records = scene.lights.iter().chain(suns).map(|light| {
        let (kind, range, [inner_cos, outer_cos]) = match light.kind {
            LightKind::Directional => (0, 0.0, [0.0; 2]),
            LightKind::Point { range } => (1, range, [0.0; 2]),
            LightKind::Spot { range, inner_cos, outer_cos } => (2, range, [inner_cos, outer_cos]),
        };
        LightRecord {
            position: light.position.to_array(),
            kind,
            direction: light.direction.to_array(),
            range: if range.is_finite() { range } else { 0.0 },
            intensity: light.intensity.to_array(),
            inner_cos,
            outer_cos,
            unused: [0.0; 3],
        }
    });
    Ok(records.chain(std::iter::repeat(LightRecord::default())).take(MAX_LIGHTS).collect())
}

/// An environment's pictures for shaders.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EnvironmentTexels {
    /// Width and height of the picture.
    pub size: [u32; 2],
    /// The environment's radiance: red, green, blue and 0 a texel, rows from the top.
    pub picture: Vec<[f32; 4]>,
    /// Width and height of the picture that holds all maps, one above the other.
    pub maps_size: [u32; 2],
    /// The texels of that picture, rows from the top.
    pub maps: Vec<[f32; 4]>,
    /// Where the maps are in it.
    pub places: EnvironmentPlaces,
}

/// Where an environment's maps are in the picture that holds them: width, height and first row of each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EnvironmentPlaces {
    /// The maps of light by direction. The fourth number of the first map counts the reductions, that of the second
    /// one has the bits of [`Environment::turn`](catoptric::scene::Environment::turn), that of the fourth one counts
    /// lamps and, times 65536, has the first reduction without their light; that of the fifth is the row where lamps
    /// begin.
    pub maps: [[u32; 4]; ENVIRONMENT_MAPS],
    /// The reductions of the environment's picture, ever smaller; the fourth number is the first row of the same
    /// without the light of lamps.
    pub reductions: [[u32; 4]; MAX_REDUCTIONS],
}

/// The pictures of a scene's environment, if wanted with its picture's reductions; single black texels without one.
/// Where surfaces see but a share of it, the irradiance is that of its rest beside suns.
pub fn environment_texels(scene: &Scene, with_reductions: bool) -> EnvironmentTexels {
    let Some(environment) = &scene.environment else {
        let black = vec![[0.0; 4]];
        let size = [1; 2];
        return EnvironmentTexels { size, picture: black.clone(), maps_size: size, maps: black, ..Default::default() };
    };
    let (width, height, radiance) = environment.picture();
    let picture = radiance.iter().map(|&[red, green, blue]| [red, green, blue, 0.0]).collect();
    let mut maps = environment.light_maps();
    if let Some(sky) = &scene.sky {
        maps[0] = sky.rest();
    }
    let reductions = environment.reductions().take(if with_reductions { MAX_REDUCTIONS } else { 0 });
    let count = reductions.len() as u32;
    let all: Vec<_> = maps.into_iter().chain(reductions).collect();
    let stride = all.iter().map(|map| map.width + 2).max().unwrap_or(1);
    let mut texels = EnvironmentTexels { size: [width, height], picture, ..EnvironmentTexels::default() };
    let mut rows = 0;
    let EnvironmentPlaces { maps, reductions } = &mut texels.places;
    for (place, map) in maps.iter_mut().chain(&mut *reductions).zip(&all) {
        *place = [map.width as u32, map.height as u32, rows, 0];
        rows += push_rows(&mut texels.maps, map, stride);
    }
    maps[0][3] = count;
    maps[1][3] = environment.turn().to_bits();
    if let Some(lamps) = environment.lamps().filter(|_| with_reductions) {
        let (finest, rest) = lamps.rest();
        for (place, map) in reductions[finest - 1..].iter_mut().zip(rest) {
            place[3] = rows;
            rows += push_rows(&mut texels.maps, &map, stride);
        }
        maps[3][3] = lamps.all().len() as u32 | (finest as u32) << 16;
        maps[4][3] = rows;
        let numbers =
            lamps.all().iter().flat_map(|lamp| [lamp.towards.extend(lamp.brightness), lamp.light.extend(0.0)]);
        texels.maps.extend(numbers.map(|numbers| numbers.to_array()));
        texels.maps.resize(texels.maps.len().next_multiple_of(stride), [0.0; 4]);
        rows = (texels.maps.len() / stride) as u32;
    }
    texels.maps_size = [stride as u32, rows];
    texels
}

/// Adds a map to a picture of so many columns: how many rows it has.
fn push_rows(texels: &mut Vec<[f32; 4]>, map: &LightMap<'_>, stride: usize) -> u32 {
    for row in map.texels.chunks_exact(map.width + 2) {
        texels.extend_from_slice(row);
        texels.resize(texels.len() + stride - row.len(), [0.0; 4]);
    }
    map.height as u32 + 2
}
