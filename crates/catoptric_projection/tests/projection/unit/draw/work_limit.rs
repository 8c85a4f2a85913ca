//! Steps of the limit of work.

use catoptric_projection::parts::in_steps;

#[test]
fn steps_are_near_and_few() {
    for work in (0..2000).chain([8_388_607, 8_388_608, 11_600_000, 60_000_000]) {
        let step = in_steps(work);
        assert!(step.abs_diff(work) * 8 <= work, "{work}: {step}");
        assert_eq!(in_steps(step), step, "{work}");
    }
    let steps: std::collections::BTreeSet<u64> = (8 << 20..16 << 20).step_by(1000).map(in_steps).collect();
    assert_eq!(steps.len(), 5);
}
