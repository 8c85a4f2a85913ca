//! Materials of `.mtl` files: what their statements say.

use super::text::{LineWarnings, Statement, number, statements};
use glam::{Vec2, Vec3};

/// A material's statements.
#[derive(Clone, Debug, Default)]
pub(super) struct MtlMaterial {
    pub(super) name: String,
    /// `Kd`, `Ks`, `Ke` and `Tf`: diffuse and specular reflection, emission, and the colour that passes; linear.
    pub(super) diffuse: Option<Vec3>,
    pub(super) specular: Option<Vec3>,
    pub(super) emission: Option<Vec3>,
    pub(super) filter: Option<Vec3>,
    /// `Ka`: where Blender writes the share of metal.
    pub(super) ambient: Option<Vec3>,
    /// `Ns`: the exponent of highlights.
    pub(super) exponent: Option<f32>,
    /// `Ni`: the index of refraction.
    pub(super) ior: Option<f32>,
    /// `d`, or one minus `Tr`.
    pub(super) dissolve: Option<f32>,
    /// `illum`: the model of illumination, 0 to 10.
    pub(super) model: Option<u32>,
    /// `Pr`, `Pm`, `Ps`, `Pc`, `Pcr`, `aniso` and `anisor`: the properties of physically based materials, 0 to 1.
    pub(super) roughness: Option<f32>,
    pub(super) metallic: Option<f32>,
    pub(super) sheen: Option<f32>,
    pub(super) coat: Option<f32>,
    pub(super) coat_roughness: Option<f32>,
    pub(super) anisotropy: Option<f32>,
    pub(super) anisotropy_rotation: Option<f32>,
    /// By [`MapKind`].
    pub(super) maps: [Option<Map>; MapKind::COUNT],
    /// Keywords of maps that are not drawn.
    pub(super) not_drawn: Vec<String>,
    /// The folder of its file as the `.obj` names it, with a slash at its end; empty: the same.
    pub(super) folder: String,
    /// Written by Blender, whose properties stand in statements of other meanings.
    pub(super) is_of_blender: bool,
}

/// The use of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MapKind {
    Diffuse,
    Specular,
    Emission,
    Dissolve,
    Roughness,
    Metallic,
    Bump,
    Normals,
}

impl MapKind {
    pub(super) const COUNT: usize = 8;
}

/// A picture and its options.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Map {
    /// As it is written.
    pub(super) file: String,
    pub(super) offset: Vec2,
    pub(super) scale: Vec2,
    pub(super) is_clamped: bool,
    /// `-bm`: the factor on heights.
    pub(super) bump: f32,
}

/// Reads the materials of a file, which the `.obj` names so. Broken lines are left out with a warning.
pub(super) fn read(file: &str, text: &str, warnings: &mut LineWarnings) -> Vec<MtlMaterial> {
    let folder = file.rfind('/').map_or("", |end| &file[..=end]);
    let is_of_blender = text.lines().take_while(|line| line.starts_with('#')).any(|line| line.contains("Blender"));
    let mut materials: Vec<MtlMaterial> = Vec::new();
    for statement in statements(text) {
        let keyword = statement.keyword().to_ascii_lowercase();
        if keyword == "newmtl" {
            let name = statement.rest().into();
            materials.push(MtlMaterial { name, folder: folder.into(), is_of_blender, ..MtlMaterial::default() });
        } else if let Some(material) = materials.last_mut()
            && let Err(problem) = material.set(&keyword, &statement)
        {
            warnings.add(statement.line, || format!("{problem}; the line is left out"));
        }
    }
    materials
}

impl MtlMaterial {
    pub(super) fn map(&self, kind: MapKind) -> Option<&Map> {
        self.maps[kind as usize].as_ref()
    }

    /// Takes up a statement.
    fn set(&mut self, keyword: &str, statement: &Statement<'_>) -> Result<(), String> {
        let one = || -> Result<Option<f32>, String> {
            let word = statement.words().next().ok_or("a number is missing")?;
            let number = number(word).filter(|number| number.is_finite());
            Ok(Some(number.ok_or_else(|| format!("`{word}` is no number"))? as f32))
        };
        match keyword {
            "kd" => self.diffuse = color(statement)?.or(self.diffuse),
            "ks" => self.specular = color(statement)?.or(self.specular),
            "ke" => self.emission = color(statement)?.or(self.emission),
            "ka" => self.ambient = color(statement)?.or(self.ambient),
            "tf" => self.filter = color(statement)?.or(self.filter),
            "ns" => self.exponent = one()?,
            "ni" => self.ior = one()?,
            "d" => {
                // `-halo` is a dissolve that depends on the angle: its factor alone is used.
                let word = statement.words().find(|word| *word != "-halo").ok_or("a number is missing")?;
                let number = number(word).filter(|number| number.is_finite());
                self.dissolve = Some(number.ok_or_else(|| format!("`{word}` is no number"))? as f32);
            }
            "tr" => {
                let transparency = one()?;
                self.dissolve = self.dissolve.or(transparency.map(|transparency| 1.0 - transparency));
            }
            "illum" => self.model = one()?.map(|model| model as u32),
            "pr" => self.roughness = one()?,
            "pm" => self.metallic = one()?,
            "ps" => self.sheen = one()?,
            "pc" => self.coat = one()?,
            "pcr" => self.coat_roughness = one()?,
            "aniso" => self.anisotropy = one()?,
            "anisor" => self.anisotropy_rotation = one()?,
            _ => self.set_map(keyword, statement),
        }
        Ok(())
    }

    /// Takes up a picture, or the keyword of one that is not drawn.
    fn set_map(&mut self, keyword: &str, statement: &Statement<'_>) {
        let kind = match keyword {
            "map_kd" => MapKind::Diffuse,
            "map_ks" => MapKind::Specular,
            "map_ke" => MapKind::Emission,
            "map_d" | "map_tr" => MapKind::Dissolve,
            "map_pr" => MapKind::Roughness,
            "map_pm" => MapKind::Metallic,
            "map_bump" | "bump" => MapKind::Bump,
            "norm" | "map_kn" => MapKind::Normals,
            _ => {
                if ["map_", "refl", "disp", "decal"].iter().any(|known| keyword.starts_with(known))
                    && keyword != "map_ka"
                {
                    self.not_drawn.push(keyword.into());
                }
                return;
            }
        };
        self.maps[kind as usize] = map(statement.rest()).or(self.maps[kind as usize].take());
    }
}

/// A colour; one number is a grey. `None`: it is given as a spectrum or in CIE XYZ.
fn color(statement: &Statement<'_>) -> Result<Option<Vec3>, String> {
    let mut words = statement.words().peekable();
    if matches!(words.peek(), Some(&("spectral" | "xyz"))) {
        return Err("colours as spectra or in CIE XYZ are not read".into());
    }
    let mut numbers = [0.0; 3];
    let mut count = 0;
    for (place, word) in numbers.iter_mut().zip(words) {
        let value = number(word).filter(|value| value.is_finite()).ok_or_else(|| format!("`{word}` is no number"))?;
        *place = (value as f32).clamp(0.0, 1e6);
        count += 1;
    }
    match count {
        0 => Err("a colour is missing".into()),
        1 => Ok(Some(Vec3::splat(numbers[0]))),
        2 => Err("a colour has one number or three".into()),
        _ => Ok(Some(Vec3::from(numbers))),
    }
}

/// A picture's options and name; `None` without a name.
fn map(text: &str) -> Option<Map> {
    let mut map = Map { file: String::new(), offset: Vec2::ZERO, scale: Vec2::ONE, is_clamped: false, bump: 1.0 };
    let mut rest = text.trim();
    while let Some((option, after)) = rest.starts_with('-').then(|| rest.split_once(char::is_whitespace)).flatten() {
        let mut after = after.trim_start();
        let mut next_number = || -> Option<f32> {
            let (word, left) = after.split_once(char::is_whitespace)?;
            let value = number(word).filter(|value| value.is_finite())?;
            after = left.trim_start();
            Some(value as f32)
        };
        match option {
            "-s" | "-o" | "-t" => {
                let mut values = if option == "-s" { Vec2::ONE } else { Vec2::ZERO };
                let numbers = [next_number(), next_number(), next_number()];
                values.x = numbers[0].unwrap_or(values.x);
                values.y = numbers[1].unwrap_or(values.y);
                match option {
                    "-s" => map.scale = values,
                    "-o" => map.offset = values,
                    _ => {}
                }
            }
            "-bm" => map.bump = next_number().unwrap_or(1.0),
            "-mm" => {
                next_number();
                next_number();
            }
            "-texres" | "-boost" => {
                next_number();
            }
            "-blendu" | "-blendv" | "-cc" | "-clamp" | "-imfchan" | "-type" | "-colorspace" => {
                let (value, left) = after.split_once(char::is_whitespace)?;
                map.is_clamped |= option == "-clamp" && value == "on";
                after = left.trim_start();
            }
            // A name that begins with a hyphen.
            _ => break,
        }
        rest = after;
    }
    map.file = rest.trim_matches('"').into();
    (!map.file.is_empty()).then_some(map)
}
