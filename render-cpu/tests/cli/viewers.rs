//! Viewers that hold up nothing.

use super::Place;
use std::net::TcpListener;

#[test]
fn a_viewer_that_does_not_read_holds_up_nothing() {
    let place = Place::with_scene();
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address").to_string();
    let (release, held) = std::sync::mpsc::channel::<()>();
    let viewer = std::thread::spawn(move || {
        let client = listener.accept().expect("a client");
        let _ = held.recv();
        drop(client);
    });
    // Larger than what lies between the two programs.
    let large = ["--size", "2000x1500", "--time", "2s", "--no-png"];
    let base = ["render", "scene.xml", "-o", "out.exr", "--json", "--tev"];
    let output = place.run(&[&base[..], &[&address], &large].concat());
    release.send(()).expect("a viewer");
    viewer.join().expect("a viewer");
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{text}");
    assert!(text.contains("tev is gone: timed out"), "{text}");
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let passes = report["passes"].as_u64().expect("a number");
    assert!(passes >= 1, "{report}");
}
