//! Bakes in memory.

use catoptric::methods::bake::{Baked, batches};
use catoptric::methods::{self, Quality};
use catoptric::scene::Scene;

/// Units in memory.
pub struct Units(pub Vec<Vec<u8>>);

impl Baked for Units {
    fn unit_count(&self) -> usize {
        self.0.len()
    }

    fn unit(&self, number: usize) -> &[u8] {
        self.0.get(number).map(Vec::as_slice).unwrap_or_default()
    }
}

/// All units of a method's bake, batches made from the last to the first; each is as large as was said, and there are
/// no more.
pub fn baked(id: &str, settings: &str, scene: &Scene, quality: Quality) -> Units {
    let bake = methods::find(id).expect("there is the method").bake.expect("it can be baked");
    let settings_table = toml::from_str(settings).expect("the test's input is valid");
    let work = bake(&settings_table, scene, quality).expect("the test's input is valid");
    let units = work.units().expect("the test's input is valid");
    let maker = work.maker().expect("the test's input is valid");
    let make = |batch| maker.make(batch).expect("the test's input is valid");
    let batches = batches(units.iter().map(|unit| unit.with_previous));
    let mut made: Vec<Vec<Vec<u8>>> = Vec::new();
    for batch in batches.into_iter().rev() {
        made.push(make(batch).into_iter().map(|unit| unit.bytes).collect());
    }
    let made: Vec<Vec<u8>> = made.into_iter().rev().flatten().collect();
    assert_eq!(made.len(), units.len());
    for (unit, bytes) in units.iter().zip(&made) {
        let (said, found) = (unit.bytes, bytes.len() as u64);
        assert!(found == said || found < said && unit.at_most, "{}: {found} of {said} bytes", unit.name);
    }
    assert!(make(units.len()..units.len() + 1).is_empty());
    // Pictures of other renderers take no time to make.
    assert!(maker.estimate_core_secs() > 0.0 || settings.contains("views"));
    Units(made)
}
