//! `report.html` in a real browser: Chromium without a window, driven over its DevTools protocol.
//!
//! Promise: the page asks nothing of a network and writes no error; every figure is there; the playback moves, by mouse and by
//! keyboard; it fits a phone, follows light and dark, prints on three pages with a picture; figures give their values and can be saved; what a user wrote stays words; without WebGL the
//! rest of it works. `RIPSTOP_SCREENSHOTS=DIR` leaves pictures to look at.
//!
//! Without Chromium every test is ignored and says so; with `RIPSTOP_REQUIRE_BROWSER=1` it fails instead.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on has failed")]

mod browser {
    pub(crate) mod checks;
    pub(crate) mod chromium;
    pub(crate) mod page;
}

use std::sync::{Mutex, PoisonError};

use browser::checks;
use browser::chromium::Chromium;
use browser::page::Shot;
use libtest_mimic::{Arguments, Completion, Trial};

/// Set to 1 where a missing browser must not go unnoticed.
const REQUIRE: &str = "RIPSTOP_REQUIRE_BROWSER";
/// Why a test did not run.
const MISSING: &str = "no Chromium";

/// The browser of all tests, started by the first; `None` where there is none.
static CHROMIUM: Mutex<Option<Option<Chromium>>> = Mutex::new(None);

fn trial(name: &str, check: fn(&Chromium, &Shot)) -> Trial {
    Trial::ignorable_test(name, move || {
        let mut started = CHROMIUM.lock().unwrap_or_else(PoisonError::into_inner);
        match started.get_or_insert_with(Chromium::start) {
            Some(chromium) => {
                check(chromium, Shot::small());
                Ok(Completion::Completed)
            }
            None if std::env::var(REQUIRE).is_ok_and(|value| value == "1") => Err(MISSING.into()),
            None => Ok(Completion::ignored_with(MISSING)),
        }
    })
}

fn main() -> std::process::ExitCode {
    let mut arguments = Arguments::from_args();
    arguments.test_threads.get_or_insert(1);
    let trials = vec![
        trial("nothing_is_asked_of_a_network_and_nothing_goes_wrong", checks::quiet),
        trial("every_figure_is_there", checks::figures),
        trial("the_playback_moves", checks::playback),
        trial("the_keyboard_does_everything", checks::keyboard),
        trial("it_fits_a_phone", checks::phone),
        trial("it_follows_light_and_dark", checks::dark),
        trial("it_prints_on_three_pages_with_a_picture", checks::print),
        trial("figures_give_values_by_pointer_and_keyboard", checks::values),
        trial("pictures_can_be_saved", checks::saves),
        trial("what_a_user_wrote_stays_words", checks::hostile),
        trial("without_webgl_the_rest_works", checks::without_webgl),
    ];
    let code = libtest_mimic::run(&arguments, trials).exit_code();
    // What is static is never dropped, and a browser must not outlive the tests.
    drop(CHROMIUM.lock().unwrap_or_else(PoisonError::into_inner).take());
    code
}
