//! Pictures of the documents: made where variables name places for them.

mod film;
mod screenshots;

use libtest_mimic::Trial;

pub(crate) fn trials() -> Vec<Trial> {
    film::trials().into_iter().chain(screenshots::trials()).collect()
}
