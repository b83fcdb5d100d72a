//! What is asked of the page.

use serde_json::json;

use super::chromium::Chromium;
use super::page::{Page, Shot};

/// Every figure of a shot.
const FIGURES: [&str; 7] = ["velocity", "force", "energy", "failures", "profile", "unit-cell", "tension"];

fn open<'a>(chromium: &'a Chromium, shot: &Shot) -> Page<'a> {
    Page::open(chromium, shot, "")
}

/// Starts the playback at the beginning, waits until it has moved, stops it.
fn play_and_pause(page: &Page<'_>) {
    page.value("scrub.value = 0; scrub.dispatchEvent(new Event('input'))");
    page.wait("scene.dataset.place == '0.000'");
    page.value("play.click()");
    page.wait("play.textContent == 'Pause' && Number(scene.dataset.place) > 1");
    page.value("play.click()");
    page.wait("play.textContent == 'Play'");
}

pub(crate) fn quiet(chromium: &Chromium, shot: &Shot) {
    let page = open(chromium, shot);
    assert_eq!(page.text("document.documentElement.dataset.playback"), "ready");
    play_and_pause(&page);
    page.value("document.querySelectorAll('details').forEach(d => { d.open = true })");
    page.picture("light.png");
    assert_eq!(page.complaints(), Vec::<serde_json::Value>::new());
    // The policy holds: what a script asks of a network is refused, and that is heard of.
    page.value("fetch('http://127.0.0.1:9/').catch(() => 0)");
    page.value("new Promise(done => setTimeout(done, 50))");
    assert!(!page.complaints().is_empty());
}

pub(crate) fn figures(chromium: &Chromium, shot: &Shot) {
    let page = open(chromium, shot);
    for id in FIGURES {
        let drawings = format!("[...document.querySelectorAll('#{id} svg')].map(svg => svg.getBoundingClientRect())");
        let seen = format!("{drawings}.filter(box => box.width > 200 && box.height > 120).length");
        let count = if id == "tension" { 3.0 } else { 1.0 };
        assert_eq!(page.number(&seen), count, "{id}");
        let shapes = format!("[...document.querySelectorAll('#{id} :is(polyline, polygon, image)')]");
        let large = format!("{shapes}.filter(shape => shape.getBBox().width > 100).length");
        assert!(page.number(&large) >= 1.0, "{id}");
        let named =
            format!("[...document.querySelectorAll('#{id} svg')].every(svg => svg.querySelector('title').textContent)");
        assert_eq!(page.value(&named), json!(true), "{id}");
    }
    let colours = "[...document.querySelectorAll('.curve')].every(line => getComputedStyle(line).stroke != 'none')";
    assert_eq!(page.value(colours), json!(true));
    // The maps are pictures of something.
    let map = "(async () => { const i = new Image(); i.src = document.querySelectorAll('#tension image')[1].href.baseVal; \
               await i.decode(); const c = document.createElement('canvas'); c.width = i.width; c.height = i.height; \
               const g = c.getContext('2d'); g.drawImage(i, 0, 0); \
               return new Set(new Uint32Array(g.getImageData(0, 0, c.width, c.height).data.buffer)).size })()";
    assert!(page.number(map) > 8.0);
    assert!(page.text("document.querySelector('h1').textContent").len() > 3);
}

pub(crate) fn playback(chromium: &Chromium, shot: &Shot) {
    let page = open(chromium, shot);
    let scrub = |to: u32| {
        page.value(&format!("scrub.value = {to}; scrub.dispatchEvent(new Event('input'))"));
        page.pixels()
    };
    let [start, later] = [scrub(0), scrub(12)];
    assert_ne!(start, later, "scrubbing");
    let time = page.text("JSON.parse(film.textContent).times[12].toFixed(1)");
    assert_eq!(page.text("clock.textContent"), format!("{time} µs"));
    assert_eq!(start, scrub(0), "the same time is the same picture");
    // The mark of time follows in the figures.
    let mark = "Number(document.querySelector('#velocity .now').getAttribute('x1'))";
    let at_start = page.number(mark);
    scrub(12);
    assert!(page.number(mark) > at_start + 50.0);
    let tension = page.pixels();
    for (id, change) in [("colour", "colour.value = 3"), ("cut", "cut.checked = true"), ("view", "view.value = 1")] {
        page.value(&format!("{change}; {id}.dispatchEvent(new Event('change'))"));
        assert_ne!(tension, page.pixels(), "{id}");
    }
    assert!(page.text("high.textContent").ends_with("mm"));
    let colours = "(() => { const c = document.createElement('canvas'); c.width = scene.width; c.height = scene.height; \
                   const g = c.getContext('2d'); g.drawImage(scene, 0, 0); \
                   return new Set(new Uint32Array(g.getImageData(0, 0, c.width, c.height).data.buffer)).size })()";
    assert!(page.number(colours) > 50.0, "the scene is drawn");
    let before = scrub(0);
    play_and_pause(&page);
    assert_ne!(before, page.pixels(), "playing");
}

pub(crate) fn keyboard(chromium: &Chromium, shot: &Shot) {
    let page = open(chromium, shot);
    let place = || page.number("Number(scene.dataset.place)");
    // Nothing plays by itself.
    let rest = place();
    page.value("new Promise(done => setTimeout(done, 200))");
    assert_eq!(place(), rest);
    // Tab alone leads to the canvas and every control, and the focus is seen.
    let mut reached = Vec::new();
    for _ in 0..12 {
        page.press("Tab");
        reached.push(page.text("document.activeElement.id || ''"));
        let outlined = page.text("getComputedStyle(document.activeElement).outlineStyle");
        assert_ne!(outlined, "none", "{reached:?}");
    }
    for id in ["scene", "play", "scrub", "colour", "view", "cut"] {
        assert!(reached.iter().any(|at| at == id), "{id} not in {reached:?}");
    }
    page.value("scene.focus()");
    page.press("Home");
    page.wait("scene.dataset.place == '0.000'");
    page.press("ArrowRight");
    page.wait("scene.dataset.place == '1.000'");
    page.press("ArrowRight");
    page.press("ArrowLeft");
    page.wait("scene.dataset.place == '1.000'");
    page.press(" ");
    page.wait("play.textContent == 'Pause'");
    page.wait("Number(scene.dataset.place) > 1.2");
    page.press(" ");
    page.wait("play.textContent == 'Play'");
}

pub(crate) fn phone(chromium: &Chromium, shot: &Shot) {
    let page = open(chromium, shot);
    page.window(390, 844);
    page.wait("document.documentElement.clientWidth == 390");
    assert!(page.number("document.documentElement.scrollWidth") <= 390.0);
    page.value("document.querySelectorAll('details').forEach(d => { d.open = true })");
    assert!(page.number("document.documentElement.scrollWidth") <= 390.0);
    // Verdict, story and trust are on the first screen; letters of a figure are not too small to read.
    assert!(page.number("document.querySelector('.answer').getBoundingClientRect().top") < 844.0);
    let scale = page.number(
        "(s => s.getBoundingClientRect().width / s.viewBox.baseVal.width)(document.querySelector('#velocity svg'))",
    );
    assert!(12.0 * scale >= 8.5, "{scale}");
    page.value("document.querySelectorAll('details').forEach(d => { d.open = false })");
    page.picture("phone.png");
}

pub(crate) fn dark(chromium: &Chromium, shot: &Shot) {
    let page = open(chromium, shot);
    let light = |of: &str| {
        let rgb = format!(
            "getComputedStyle(document.body).{of}.match(/\\d+/g).slice(0, 3).reduce((a, b) => a + Number(b), 0) / 765"
        );
        page.number(&rgb)
    };
    page.media("screen", "light");
    assert!(light("backgroundColor") > 0.9 && light("color") < 0.3);
    let bright = page.pixels();
    page.media("screen", "dark");
    assert!(light("backgroundColor") < 0.2 && light("color") > 0.8);
    page.wait("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))");
    assert_ne!(bright, page.pixels());
    let curve =
        "getComputedStyle(document.querySelector('.curve')).stroke.match(/\\d+/g).reduce((a, b) => a + Number(b), 0)";
    assert!(page.number(curve) > 350.0, "lines stand out from the dark");
    page.picture("dark.png");
}

pub(crate) fn print(chromium: &Chromium, shot: &Shot) {
    let page = open(chromium, shot);
    page.media("print", "dark");
    let shown = |of: &str| page.value(&format!("document.querySelector('{of}').getClientRects().length > 0"));
    assert_eq!(shown("canvas"), json!(false));
    for what in ["#tension svg", "#velocity svg", "h1", "#instead", "#case table"] {
        assert_eq!(shown(what), json!(true), "{what}");
    }
    // Paper is white whatever the screen was.
    assert_eq!(page.text("getComputedStyle(document.body).backgroundColor"), "rgb(255, 255, 255)");
    assert!(page.print() > 50_000);
}

pub(crate) fn hostile(chromium: &Chromium, _: &Shot) {
    let title = "</title></script><script>window.taken=1</script><img src=x onerror=\"window.taken=1\">'\"&amp;<!--";
    let shot = Shot::new(title);
    let page = open(chromium, &shot);
    assert_eq!(page.value("typeof window.taken"), json!("undefined"));
    assert_eq!(page.text("document.querySelector('.over').textContent"), title);
    assert_eq!(page.text("document.title"), format!("{title} – ripstop"));
    assert_eq!(page.number("document.querySelectorAll('main script, main img').length"), 2.0, "the film's two");
    assert_eq!(page.text("document.documentElement.dataset.playback"), "ready");
    assert_eq!(page.complaints(), Vec::<serde_json::Value>::new());
}

pub(crate) fn without_webgl(chromium: &Chromium, shot: &Shot) {
    let page = Page::open(chromium, shot, "HTMLCanvasElement.prototype.getContext = () => null");
    assert_eq!(page.text("document.documentElement.dataset.playback"), "unsupported");
    assert_eq!(page.value("document.querySelector('.player').hidden"), json!(true));
    assert!(page.number("document.getElementById('instead').getBoundingClientRect().height") > 10.0);
    assert!(page.number("document.querySelector('#velocity svg').getBoundingClientRect().height") > 120.0);
    assert_eq!(page.complaints(), Vec::<serde_json::Value>::new());
}
