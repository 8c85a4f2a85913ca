use catoptric_core::error::did_you_mean;

#[test]
fn slips_of_the_pen_lead_to_the_name_that_was_meant() {
    let known = ["sphere_room", "environment_map", "Mirror.Left", "accuracy_px", "ball", "bell"];
    for (given, meant) in [
        ("sphere_rom", "sphere_room"),
        ("shpere_room", "sphere_room"),
        ("sphere", "sphere_room"),
        ("enviroment_map", "environment_map"),
        ("miror.left", "Mirror.Left"),
        ("Mirror*", "Mirror.Left"),
        ("bal", "ball"),
        ("bel", "bell"),
    ] {
        assert_eq!(did_you_mean(given, known), format!(" (did you mean `{meant}`?)"), "{given}");
    }
    for given in ["", "*", "x", "torus", "reference", &"ball".repeat(1000)] {
        assert_eq!(did_you_mean(given, known), "", "{given}");
    }
    assert_eq!(did_you_mean("ball", []), "");
}
