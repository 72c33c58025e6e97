//! The page as someone uses it: what is seen, clicks, keys, addresses.

use crate::browser::Browser;
use crate::{BALL, browser, write_page};
use image::RgbImage;
use serde_json::Value;

/// Share of the pixels that differ by more than 8 of 255 somewhere.
fn difference(a: &RgbImage, b: &RgbImage) -> f64 {
    assert_eq!(a.dimensions(), b.dimensions());
    let differs =
        |(a, b): &(&image::Rgb<u8>, &image::Rgb<u8>)| (0..3).any(|c| a.0[c].abs_diff(b.0[c]) > 8);
    a.pixels().zip(b.pixels()).filter(differs).count() as f64 / f64::from(a.width() * a.height())
}

/// Number of different colours, up to rounding.
fn colors(picture: &RgbImage) -> usize {
    let all: std::collections::HashSet<[u8; 3]> =
        picture.pixels().map(|p| p.0.map(|v| v / 8)).collect();
    all.len()
}

fn summary(browser: &mut Browser) -> Value {
    browser.value("halflight.summary")
}

fn selected(browser: &mut Browser) -> u64 {
    summary(browser)["selected"].as_u64().unwrap()
}

#[test]
fn the_page_shows_what_is_asked_for() {
    let Some(mut browser) = browser() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    write_page(
        folder.path(),
        BALL,
        &[
            "--spp",
            "24",
            "--record-count",
            "4000",
            "--pixel",
            "30,50",
            "--rows",
            "12",
        ],
    );
    let page = folder.path().join("page.html");
    browser.open(&page, "");
    let all = selected(&mut browser);
    assert_eq!(all, 4000);

    // Both views show something, and the scene turns.
    let (scene, image) = (browser.picture("#space"), browser.picture("#picture"));
    assert!(
        colors(&scene) > 60 && colors(&image) > 60,
        "{} {}",
        colors(&scene),
        colors(&image)
    );
    let middle = browser.middle("#space");
    browser.drag(middle, [middle[0] + 90.0, middle[1] + 30.0]);
    let turned = browser.picture("#space");
    assert!(difference(&scene, &turned) > 0.1);
    assert!(
        browser
            .value("location.hash")
            .as_str()
            .unwrap()
            .contains("view=")
    );
    browser.key("c");
    assert!(difference(&scene, &browser.picture("#space")) < 0.01);

    // A pixel, then a rectangle.
    let middle = browser.middle("#picture");
    browser.click(middle);
    let of_pixel = selected(&mut browser);
    assert!(of_pixel >= 12 && of_pixel < all / 20, "{of_pixel}");
    let region = browser.value("halflight.state.region");
    assert!(
        region[2] == region[3] && region[2].as_u64().unwrap() < 12,
        "{region}"
    );
    browser.drag(
        [middle[0] - 80.0, middle[1] - 60.0],
        [middle[0] + 80.0, middle[1] + 60.0],
    );
    let of_region = selected(&mut browser);
    assert!(of_region > of_pixel && of_region < all, "{of_region}");
    assert!(difference(&image, &browser.picture("#picture")) > 0.1);
    browser.key("Escape");
    assert_eq!(selected(&mut browser), all);

    // An expression filters while it is written; a mistake is told, and leaves what was there.
    browser.key("e");
    browser.write("L S+ D E");
    let caustic = selected(&mut browser);
    assert!(caustic > 0 && caustic < all / 2, "{caustic}");
    browser.write(" Q");
    assert_eq!(selected(&mut browser), caustic);
    assert!(
        browser
            .value("document.getElementById('mistake').textContent")
            .as_str()
            .unwrap()
            .contains("'Q' is none of")
    );
    browser.key("Backspace");
    browser.value("(document.execCommand('delete'), document.execCommand('delete'))");
    browser.key("Enter");
    assert!(summary(&mut browser)["mistake"].is_null());
    assert!(difference(&scene, &browser.picture("#space")) > 0.002);

    // A surface, a cluster, a path.
    browser.key("Escape");
    assert_eq!(selected(&mut browser), all);
    let middle = browser.middle("#space");
    browser.click([middle[0], middle[1] + 90.0]);
    let near = selected(&mut browser);
    assert!(near > 0 && near < all, "{near}");
    browser.key("Escape");
    let clusters = "[...document.querySelectorAll('.cluster')]";
    assert!(
        browser
            .value(&format!("{clusters}.length"))
            .as_u64()
            .unwrap()
            > 2
    );
    browser.value(&format!("{clusters}[1].click()"));
    let cluster = selected(&mut browser);
    assert!(cluster > 0 && cluster < all, "{cluster}");
    browser.key("j");
    assert!(summary(&mut browser)["path"].is_u64());
    assert!(
        browser
            .value("document.querySelectorAll('#vertices tbody tr').length")
            .as_u64()
            .unwrap()
            >= 2
    );

    // The other tools.
    let mut last = (browser.picture("#space"), browser.picture("#picture"));
    for (key, tool) in [
        ("2", "color"),
        ("3", "plot"),
        ("4", "volume"),
        ("1", "paths"),
    ] {
        browser.key(key);
        assert_eq!(browser.value("halflight.state.tool"), tool);
        let next = (browser.picture("#space"), browser.picture("#picture"));
        let differs = difference(&last.0, &next.0).max(difference(&last.1, &next.1));
        assert!(differs > 0.002, "{tool}: {differs}");
        last = next;
    }
    browser.key("?");
    assert_eq!(browser.value("document.getElementById('help').open"), true);
    assert!(
        browser
            .value("document.getElementById('help').innerText")
            .as_str()
            .unwrap()
            .contains("spherical plot")
    );
    browser.key("?");
    assert_eq!(browser.value("document.getElementById('help').open"), false);
    assert!(browser.errors.is_empty(), "{:?}", browser.errors);
}

#[test]
fn an_address_restores_what_was_seen() {
    let Some(mut browser) = browser() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    write_page(
        folder.path(),
        BALL,
        &["--spp", "8", "--record-count", "2000"],
    );
    let page = folder.path().join("page.html");
    browser.open(&page, "");
    browser.value(
        "halflight.set({expression: 'L[lamp] .* E', region: [20, 10, 60, 50], by: 'object', from: 'sensor', tool: 'volume', log: false, look: 'x-ray', exposure: 1})",
    );
    browser.value(
        "halflight.set({cluster: [halflight.selection.tree.root.children[0].labels.join(' ')]})",
    );
    let middle = browser.middle("#space");
    browser.drag(middle, [middle[0] - 60.0, middle[1]]);
    browser.settle();
    let state = browser.value("JSON.stringify(halflight.state)");
    let before = (summary(&mut browser), browser.picture("#app"));
    let fragment = browser.value("location.hash").as_str().unwrap().to_owned();
    browser.open(&page, &fragment);
    assert_eq!(browser.value("JSON.stringify(halflight.state)"), state);
    let after = (summary(&mut browser), browser.picture("#app"));
    assert_eq!(before.0, after.0);
    assert!(after.0["selected"].as_u64().unwrap() > 0);
    let changed = difference(&before.1, &after.1);
    assert!(changed < 0.005, "{changed}");
    // Whatever someone writes there, the page opens.
    browser.open(
        &page,
        "#e=L%20Q&tool=none&px=1,2&view=a&cluster=[&voxels=1e9&plot=7",
    );
    assert_eq!(browser.value("halflight.state.tool"), "paths");
    assert_eq!(browser.value("halflight.state.region"), Value::Null);
    assert!(browser.errors.is_empty(), "{:?}", browser.errors);
}
