//! Bakes of catoptric's methods: their identities, and the check that they fit a scene and settings.

use crate::container::BakedFile;
use crate::error::BakeError;
use crate::plan::{Estimate, Identity, PlannedUnit, SCHEMA};
use crate::run::{Payload, Work};
use catoptric::error::RenderError;
use catoptric::methods::bake::{BakeUnit, BakeWork, Baked, MadeUnit, UnitMaker};
use catoptric::methods::{MethodInfo, Quality};
use catoptric::scene::Scene;
use std::ops::Range;
use std::path::Path;

/// The setting of every bake that is no method's: the highest order of paths.
const ORDER: &str = "order";

/// The bake of a method for a scene.
///
/// ```
/// use catoptric::methods::{self, Quality};
/// use catoptric::progress::Silent;
/// use catoptric_scenes::builtin;
/// use catoptric_bake::{LocalStore, MethodBake, RunOptions, merge, run};
///
/// let scene = builtin::load("sphere_room", &[("tess", "8")]).unwrap().pose(&Default::default()).unwrap();
/// let settings = toml::from_str("st = 2\nuv = 4").unwrap();
/// let (light_field, quality) = (methods::find("light_field").unwrap(), Quality { samples: 1, order: 1 });
/// let bake = MethodBake::new(light_field, &settings, &scene, quality).unwrap();
///
/// let folder = tempfile::tempdir().unwrap();
/// let store = LocalStore::create_folder(folder.path().join("units")).unwrap();
/// let file = folder.path().join("room.bake");
/// let (plan, units) = bake.plan(serde_json::Value::Null).unwrap();
/// plan.publish(&store).unwrap();
/// run(&plan, &store, &units, &RunOptions::default()).unwrap();
/// merge(&plan, &store, &file).unwrap();
///
/// let (method, baked) = (methods::create("light_field", &settings).unwrap(), bake.open(&file).unwrap());
/// let scene = std::sync::Arc::new(scene.clone());
/// method.prepare(&scene, quality, Some(std::sync::Arc::new(baked)), &Silent).unwrap();
/// ```
pub struct MethodBake<'a> {
    work: Box<dyn BakeWork + 'a>,
    /// The identity but for its units: they follow from the rest, and finding them may take time.
    request: Identity,
}

/// Makes the units of a bake.
pub struct MethodUnits<'a> {
    maker: Box<dyn UnitMaker + 'a>,
}

/// Why a bake cannot be planned.
#[derive(Debug, thiserror::Error)]
pub enum MethodBakeError {
    /// By the method.
    #[error(transparent)]
    Method(#[from] RenderError),
    /// By the rules of bakes.
    #[error(transparent)]
    Bake(#[from] BakeError),
}

impl<'a> MethodBake<'a> {
    /// The bake of a method with settings and the highest order of paths, for a scene.
    ///
    /// # Errors
    /// [`RenderError::Setting`] for settings that are not allowed; [`RenderError::Limit`] for methods that bake
    /// nothing, and where there is nothing to be baked.
    pub fn new(
        method: &MethodInfo,
        settings: &toml::Table,
        scene: &'a Scene,
        quality: Quality,
    ) -> Result<Self, RenderError> {
        let problem = || RenderError::Limit { method: method.id, problem: "it bakes nothing".into() };
        let work = method.bake.ok_or_else(problem)?(settings, scene, quality)?;
        let mut hasher = blake3::Hasher::new();
        work.write_scene(&mut |piece| {
            hasher.update(piece);
        });
        let request = Identity {
            schema: SCHEMA,
            method: method.id.into(),
            payload_version: work.payload_version(),
            settings: serde_json::to_value(work.settings()).unwrap_or_default(),
            scene_hash: hasher.finalize().to_hex().to_string(),
            program_version: env!("CARGO_PKG_VERSION").into(),
            units: Vec::new(),
        };
        Ok(Self { work, request })
    }

    /// The identity of the bake, before any work. Finding the units may take as long as a picture.
    ///
    /// # Errors
    /// [`MethodBakeError::Method`] where what is made at once does not fit into memory, [`MethodBakeError::Bake`] for
    /// units that are too large.
    pub fn identity(&self) -> Result<Identity, MethodBakeError> {
        let planned = |unit: BakeUnit| {
            let BakeUnit { name, bytes, at_most, with_previous } = unit;
            PlannedUnit { name, bytes, at_most, with_previous }
        };
        let units = self.work.units()?.into_iter().map(planned).collect();
        let identity = Identity { units, ..self.request.clone() };
        identity.validate(&identity.method)?;
        Ok(identity)
    }

    /// A plan of it, with its costs, which are estimated by making a small part of it; and the maker of its units.
    ///
    /// # Errors
    /// As for [`Self::identity`] and [`Self::units`].
    pub fn plan(&self, recipe: serde_json::Value) -> Result<(crate::Plan, MethodUnits<'_>), MethodBakeError> {
        let identity = self.identity()?;
        let units = self.units()?;
        let planned = || identity.units.iter().map(|unit| unit.bytes).sum();
        let bytes = units.maker.estimate_bytes().unwrap_or_else(planned);
        let estimate = Estimate { core_hours: units.maker.estimate_core_secs() / 3600.0, bytes };
        Ok((crate::Plan { identity, recipe, estimate }, units))
    }

    /// The maker of its units; builds what all of them share.
    ///
    /// # Errors
    /// [`RenderError::Setting`] where what they are made of, such as pictures, is not at hand.
    pub fn units(&self) -> Result<MethodUnits<'_>, RenderError> {
        Ok(MethodUnits { maker: self.work.maker()? })
    }

    /// True for a file of it that this version of the program would make: baking again would make the same.
    pub fn is_current(&self, file: &BakedFile) -> bool {
        file.identity().program_version == self.request.program_version && self.check(file, "").is_ok()
    }

    /// Opens a baked file, which must be of it; the version of the program that made it does not count, that of its
    /// units does.
    ///
    /// # Errors
    /// [`BakeError::OtherBake`] where it is another one; as for [`BakedFile::open`].
    pub fn open(&self, path: impl AsRef<Path>) -> Result<BakedFile, BakeError> {
        let file = BakedFile::open(&path)?;
        self.check(&file, &path.as_ref().display().to_string())?;
        Ok(file)
    }

    /// Checks that an open file has this identity, but for its units: that they are those of the scene, the method
    /// checks when it takes them. `name` is the file's in messages.
    ///
    /// # Errors
    /// [`BakeError::OtherBake`] where it is not.
    pub fn check(&self, file: &BakedFile, name: &str) -> Result<(), BakeError> {
        let found = file.identity();
        let (program_version, units) = (found.program_version.clone(), found.units.clone());
        let requested = Identity { program_version, units, ..self.request.clone() };
        match found.difference(&requested) {
            None => Ok(()),
            Some(difference) => Err(BakeError::OtherBake { file: name.into(), difference: difference.to_string() }),
        }
    }
}

impl Work for MethodUnits<'_> {
    fn batch(&self, numbers: Range<u64>) -> Result<Vec<Payload>, String> {
        let number = |number: u64| usize::try_from(number).map_err(|error| error.to_string());
        let batch = number(numbers.start)?..number(numbers.end)?;
        let made = self.maker.make(batch).map_err(|error| error.to_string())?;
        Ok(made.into_iter().map(|MadeUnit { bytes, note }| Payload { bytes, note }).collect())
    }
}

impl Baked for BakedFile {
    fn unit_count(&self) -> usize {
        Self::unit_count(self) as usize
    }

    fn unit(&self, number: usize) -> &[u8] {
        if (number as u64) < Self::unit_count(self) { Self::unit(self, number as u64) } else { &[] }
    }
}

impl BakedFile {
    /// The settings with which a method looks this bake up, unless `given` has others: those that it was baked
    /// with, then the given ones. A given preset counts with all settings that it sets.
    ///
    /// # Errors
    /// [`RenderError::Setting`] for given settings that are not allowed.
    pub fn settings_for(&self, method: &MethodInfo, given: &toml::Table) -> Result<toml::Table, RenderError> {
        let problem = |error: toml::de::Error| RenderError::Setting { method: method.id, problem: error.to_string() };
        let all = (method.effective)(given)?;
        let mut settings: toml::Table = serde_json::from_value(self.identity().settings.clone())
            .map_err(|error| problem(serde::de::Error::custom(error)))?;
        settings.remove(ORDER);
        settings.retain(|key, _| all.contains_key(key));
        if given.contains_key("preset") {
            settings.clear();
        }
        settings.extend(given.clone());
        Ok(settings)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LocalStore, RunOptions, merge, run};
    use catoptric::methods;
    use catoptric_scenes::builtin;

    fn scene(spec: &str) -> Scene {
        builtin::parse(spec).unwrap().pose(&Default::default()).unwrap()
    }

    fn table(text: &str) -> toml::Table {
        toml::from_str(text).unwrap()
    }

    fn bake<'a>(settings: &str, scene: &'a Scene, order: u32) -> MethodBake<'a> {
        let method = methods::find("light_field").unwrap();
        MethodBake::new(method, &table(settings), scene, Quality { samples: 1, order }).unwrap()
    }

    #[test]
    fn files_of_other_scenes_and_settings_are_refused() {
        const SETTINGS: &str = "st = 2\nuv = 4\nregion_margin = 0.1";
        let room = scene("sphere_room?tess=8");
        let made = bake(SETTINGS, &room, 1);
        let folder = tempfile::tempdir().unwrap();
        let store = LocalStore::create_folder(folder.path().join("units")).unwrap();
        let (plan, units) = made.plan(serde_json::Value::Null).unwrap();
        run(&plan, &store, &units, &RunOptions::default()).unwrap();
        let path = folder.path().join("room.bake");
        merge(&plan, &store, &path).unwrap();
        let file = made.open(&path).unwrap();
        let refused = |settings: &str, scene: &Scene, order| {
            let error = bake(settings, scene, order).open(&path).unwrap_err().to_string();
            assert!(error.contains("room.bake"), "{error}");
            error
        };
        assert!(refused("st = 3\nuv = 4\nregion_margin = 0.1", &room, 1).contains("st is 2 in the bake, 3 asked for"));
        assert!(refused(SETTINGS, &room, 2).contains("order is 1 in the bake, 2 asked for"));
        assert!(refused(SETTINGS, &scene("sphere_room?tess=9"), 1).contains("the scene's hash"));
        // Settings of the look-up are no part of it.
        let method = methods::find("light_field").unwrap();
        bake(&format!("{SETTINGS}\ndisparity = 'none'\ntransfer = 'first'"), &room, 1).open(&path).unwrap();

        // Settings that are not given are taken from it.
        let settings = file.settings_for(method, &table("disparity = 'plane'")).unwrap();
        let effective = (method.effective)(&settings).unwrap();
        assert_eq!((effective["st"].as_integer(), effective["disparity"].as_str()), (Some(2), Some("plane")));
        bake(&settings.to_string(), &room, 1).open(&path).unwrap();
        let settings = file.settings_for(method, &table("preset = 'full'")).unwrap();
        assert!(bake(&settings.to_string(), &room, 1).open(&path).is_err(), "a preset says how many views there are");
        assert!(file.settings_for(method, &table("sd = 3")).is_err());
    }

    #[test]
    fn methods_and_scenes_without_anything_to_bake_say_so() {
        let room = scene("sphere_room?tess=8");
        let error = |method: &str, scene: &Scene, order| {
            let method = methods::find(method).unwrap();
            let made = MethodBake::new(method, &toml::Table::new(), scene, Quality { samples: 1, order });
            made.err().map(|error| error.to_string()).unwrap_or_default()
        };
        assert!(error("reference", &room, 1).contains("bakes nothing"));
        assert!(error("light_field", &room, 0).contains("nothing to bake"));
        assert!(error("light_field", &Scene::default(), 1).contains("nothing to bake"));
    }
}
