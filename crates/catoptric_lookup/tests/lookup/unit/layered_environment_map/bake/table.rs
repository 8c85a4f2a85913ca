//! Units of bakes and their batches.

use catoptric_engine::light::parallax_proxy::ParallaxProxy;
use catoptric_engine::method::bake::batches;
use catoptric_lookup::layered_environment_map::{LayeredEnvironmentMapSettings, Textures};
use catoptric_lookup::parts::{LayersBatch, Quad, Shell, UnitTable};
use glam::Vec3;

#[test]
fn every_unit_is_where_its_batch_says() {
    let around = Shell::Around(ParallaxProxy::Sphere(2.0));
    let quad = Shell::Quad(Quad { middle: Vec3::Z, normal: Vec3::Z, right: Vec3::X, up: Vec3::Y });
    for (depth, textures) in [
        (true, Textures::Projected),
        (true, Textures::Inferred),
        (false, Textures::Projected),
        (false, Textures::Inferred),
    ] {
        let settings = LayeredEnvironmentMapSettings { size: 8, depth, textures, ..Default::default() };
        let parts = [vec![&around, &quad], vec![&quad], vec![&around]];
        let table = UnitTable::new(&settings, parts.into_iter(), 2, 3, 100);
        let units = table.units();
        let found = batches(units.iter().map(|unit| unit.with_previous));
        assert_eq!(found.len(), table.batches().count(), "{depth} {textures:?}");
        for (range, batch) in found.into_iter().zip(table.batches()) {
            assert_eq!(table.units_of(batch), range);
            assert_eq!(table.batch_at(range.start), Some(batch));
            let name = &units[range.start].name;
            match batch {
                LayersBatch::Shells => assert_eq!(name, "shells"),
                LayersBatch::Surfaces { part: 2 } => assert_eq!(name, "all groups, center, layer 0, face 0"),
                LayersBatch::Surfaces { part } => assert!(name.starts_with(&format!("group {part}, center"))),
                LayersBatch::Textures { viewpoint, .. } => {
                    assert!(name.contains(&format!("viewpoint {viewpoint}, layer 0, face 0")), "{name}");
                }
            }
        }
        assert_eq!(table.batch_at(units.len()), None);
        assert!(table.units_of(LayersBatch::Textures { part: 0, viewpoint: 3 }).is_empty());
        let texels = 64 + 16 + 4 + 1;
        let depths = if depth { 12 + 64 * 4 } else { 0 };
        let last = if textures == Textures::Projected { depths + texels * 8 } else { texels * 8 };
        assert_eq!(units[units.len() - 1].bytes, last);
    }
}
