//! A studio that fails while it works: another one goes on.

use crate::painted::Painted;
use crate::session::{SCENE, Session, choose_parallax_box, expected, open_woken, scene, settle, start};
use crate::trial;
use catoptric_viewer::app::Viewer;
use egui::Key;
use libtest_mimic::Trial;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

pub(crate) fn trials() -> Vec<Trial> {
    vec![trial("after a panic the same is shown again, three times at most", goes_on_after_panics)]
}

/// True if a message has these words.
fn told(viewer: &Viewer, words: &str) -> bool {
    viewer.messages().any(|message| message.contains(words))
}

/// Flies back a little.
fn fly(session: &mut Session) {
    session.key_down(Key::S);
    (0..3).for_each(|_| session.step());
    session.key_up(Key::S);
}

fn goes_on_after_panics() {
    // The number of the failure that is to come; 0: none.
    let failure = Arc::new(AtomicU32::new(0));
    let armed = failure.clone();
    let wake_up = move || {
        let number = armed.swap(0, Ordering::SeqCst);
        assert!(number == 0, "failure {number} of the test");
    };
    let builtin = format!("builtin:{SCENE}");
    let mut session = open_woken(Painted::default(), None, start(&builtin, "environment_map", None), Box::new(wake_up));
    // Something of the user's own: the view, and a setting.
    choose_parallax_box(&mut session);
    let scene = scene(SCENE);
    for number in 1..=3 {
        let before = session.state().wish().unwrap().clone();
        failure.store(number, Ordering::SeqCst);
        fly(&mut session);
        let words = format!("started again: failure {number} of the test");
        settle(&mut session, |viewer| viewer.is_sharp() && told(viewer, &words));
        let after = session.state().wish().unwrap().clone();
        assert_ne!((before.scene, &before.camera), (after.scene, &after.camera));
        assert_eq!(before.sides, after.sides);
        assert_eq!(session.state().picture(0).unwrap(), &expected(&scene, &after, 0));
    }
    failure.store(4, Ordering::SeqCst);
    fly(&mut session);
    settle(&mut session, |viewer| told(viewer, "drawing has stopped"));
    // The last picture stays.
    assert!(session.state().picture(0).is_some());
}
