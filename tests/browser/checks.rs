//! What is asked of the page.

use serde_json::json;

use super::chromium::Chromium;
use super::page::{Page, Shot};

/// Every figure of a shot.
const FIGURES: [&str; 8] = ["velocity", "force", "deflection", "energy", "failures", "profile", "unit-cell", "tension"];

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
    let time = page.text("JSON.parse(animation.textContent).times[12].toFixed(1)");
    assert_eq!(page.text("clock.textContent"), format!("{time} µs"));
    assert_eq!(start, scrub(0), "the same time is the same picture");
    // The mark of time follows in the figures.
    let mark = "Number(document.querySelector('#velocity .now').getAttribute('x1'))";
    let at_start = page.number(mark);
    scrub(12);
    assert!(page.number(mark) > at_start + 50.0);
    let tension = page.pixels();
    for (id, change) in
        [("colour", "colour.value = 3"), ("cut", "cut.checked = !cut.checked"), ("view", "view.value = 2")]
    {
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
    // It opens at the largest deflection, and nothing plays by itself.
    assert_eq!(place(), page.number("JSON.parse(animation.textContent).opening"));
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
    for id in ["scene", "play", "scrub", "colour", "view", "cut", "save"] {
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
    for what in ["#tension svg", "#velocity svg", "h1", "#paper img"] {
        assert_eq!(shown(what), json!(true), "{what}");
    }
    assert_eq!(shown("#case table"), json!(false));
    // The picture is one of fabric on white.
    let picture = "(async () => { const i = document.querySelector('#paper img'); await i.decode(); \
                   const c = document.createElement('canvas'); c.width = i.naturalWidth; c.height = i.naturalHeight; \
                   const g = c.getContext('2d'); g.drawImage(i, 0, 0); \
                   const p = new Uint32Array(g.getImageData(0, 0, c.width, c.height).data.buffer); \
                   return p[0] == 0xffffffff ? new Set(p).size : 0 })()";
    assert!(page.number(picture) > 50.0);
    // Paper is white whatever the screen was.
    assert_eq!(page.text("getComputedStyle(document.body).backgroundColor"), "rgb(255, 255, 255)");
    assert!((1..=3).contains(&page.print()));
}

pub(crate) fn values(chromium: &Chromium, shot: &Shot) {
    let page = open(chromium, shot);
    page.value("document.querySelector('#velocity svg').focus()");
    let read = || page.text("document.querySelector('#velocity .values').textContent");
    page.press("ArrowLeft");
    let last = read();
    assert!(last.starts_with("time ") && last.contains(" µs: ") && last.ends_with(" m/s"), "{last}");
    let velocity: f64 = last.split(' ').rev().nth(1).unwrap().parse().unwrap();
    let table = "[...document.querySelectorAll('#velocity td')].at(-1).textContent";
    let expected: f64 = page.text(table).parse().unwrap();
    assert!((velocity - expected).abs() < 2.0, "{velocity} {expected}");
    page.press("ArrowLeft");
    assert_ne!(last, read());
    page.value("document.activeElement.blur()");
    assert_eq!(page.value("document.querySelector('#velocity .values').hidden"), json!(true));
    // In a stack a value is that of the area, not of its upper edge.
    let point = "(type, x) => { const s = document.querySelector('#energy svg'), b = s.getBoundingClientRect(); \
                 s.dispatchEvent(new PointerEvent(type, { clientX: b.left + x * b.width, clientY: b.top + 50 })) }";
    page.value(&format!("({point})('pointermove', 0.9)"));
    let values =
        "[...document.querySelectorAll('#energy .values b')].map(b => parseFloat(b.textContent.replace('−', '-')))";
    let sum = page.number(&format!("{values}.reduce((a, b) => a + b, 0)"));
    assert!((sum / 540.0 - 1.0).abs() < 0.03, "{sum} J of 3 g at 600 m/s");
    page.value(&format!("({point})('pointerleave', 0.9)"));
    assert_eq!(page.value("document.querySelector('#energy .values').hidden"), json!(true));
}

pub(crate) fn saves(chromium: &Chromium, shot: &Shot) {
    let first = "window.saved = []; HTMLAnchorElement.prototype.click = function () { \
                 window.saved.push({ name: this.download }) }; \
                 const make = URL.createObjectURL; window.blobs = []; \
                 URL.createObjectURL = (blob) => { window.blobs.push(blob); return make.call(URL, blob) }";
    let page = Page::open(chromium, shot, first);
    page.value("document.querySelector('#energy .save').click()");
    assert_eq!(page.text("saved[0].name"), "energy.svg");
    let svg = page.text("blobs[0].text()");
    assert!(
        svg.starts_with("<svg") && svg.contains(">Where the energy is</text>") && svg.contains(">hourglass</text>")
    );
    assert!(!svg.contains("class=\"now\"") && svg.contains("fill: rgb("));
    let errors = "(async () => new DOMParser().parseFromString(await blobs[0].text(), 'image/svg+xml')\
                  .querySelectorAll('parsererror').length)()";
    assert_eq!(page.number(errors), 0.0);
    page.value("save.click()");
    page.wait("saved.length == 2");
    assert_eq!(page.text("saved[1].name + ' ' + blobs[1].type"), "playback.png image/png");
    assert!(page.number("blobs[1].size") > 5000.0);
}

pub(crate) fn hostile(chromium: &Chromium, _: &Shot) {
    let title = "</title></script><script>window.taken=1</script><img src=x onerror=\"window.taken=1\">'\"&amp;<!--";
    let shot = Shot::new(title);
    let page = open(chromium, &shot);
    assert_eq!(page.value("typeof window.taken"), json!("undefined"));
    assert_eq!(page.text("document.querySelector('.over').textContent"), title);
    assert_eq!(page.text("document.title"), format!("{title} – ripstop"));
    let own = "document.querySelectorAll('main script, main img:not(#paper img)').length";
    assert_eq!(page.number(own), 2.0, "the animation's two");
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
