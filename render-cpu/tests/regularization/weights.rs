//! Weights of regularised strategies are a partition of one: with the model's own values they leave the mean as it is.
//!
//! In a scene without specular surfaces every strategy can evaluate the model itself. Weighted by p_hat instead of p the sum is
//! still unbiased, exactly if the weights of all strategies of each path sum to one, forward and backward densities, merges,
//! light images and emission that is met included.

use crate::scenes::{add, ball, film, mean, regularized, render_film, room, scene};
use halflight::scene::build::Scene;
use halflight_kernel::regularize::settings::flag;

/// Walls and a ball that are both raised from alpha 0.1 to 0.4 and more.
fn shiny_room(name: &str) -> Scene {
    let walls = r#"<bsdf type="roughplastic"><float name="alpha" value="0.1"/></bsdf>"#;
    let glass = r#"<bsdf type="roughdielectric"><float name="alpha" value="0.1"/></bsdf>"#;
    let mut scene = scene(name, &room(walls, &ball(glass)));
    scene.settings.photon.initial_radius = 0.02;
    scene.settings.photon.photon_count = 2000;
    scene
}

/// Runs whose means are compared, each of the same samples with and without regularised weights: what differs between the two
/// is a small part of the noise.
const BATCHES: u32 = 16;

#[test]
fn weights_by_regularised_densities_are_unbiased_with_plain_values() {
    for (name, samples) in [("path", 96), ("bdpt", 48), ("vcm", 32)] {
        let plain = shiny_room(name);
        for options in ["tau=30,constant", "tau=30,quality,diffusion,fade=0.3"] {
            let mut weighted = regularized(plain.clone(), options);
            weighted.settings.regularization.flags |= flag::PLAIN_VALUES;
            let mut differences = Vec::new();
            let mut whole = 0.0;
            for batch in 0..BATCHES {
                let of = |scene: &Scene| {
                    let mut film = film(scene);
                    add(scene, &mut film, batch * samples, samples);
                    mean(&film).0
                };
                let expected = of(&plain);
                whole += expected / f64::from(BATCHES);
                differences.push(of(&weighted) - expected);
            }
            let n = f64::from(BATCHES);
            let bias = differences.iter().sum::<f64>() / n;
            let squares: f64 = differences.iter().map(|d| (d - bias).powi(2)).sum();
            let sigma = (squares / (n * (n - 1.0))).sqrt();
            println!(
                "{name}, {options}: {:.5} +- {:.5} of the mean",
                bias / whole,
                sigma / whole
            );
            assert!(sigma < 0.01 * whole, "{name}: noise hides everything");
            assert!(
                bias.abs() < 5.0 * sigma,
                "{name}, {options}: {bias} +- {sigma}"
            );
            // And the weights are others.
            assert!(bias != 0.0, "{name}");
        }
    }
}

/// Weights by the densities of the model itself are a partition of one too, so that both agree where nothing is raised much.
#[test]
fn both_kinds_of_weights_have_one_limit() {
    for name in ["path", "bdpt"] {
        let own = |options: &str| mean(&render_film(&regularized(shiny_room(name), options), 512));
        let (hat, sigma0) = own("tau=3000,constant");
        let (plain, sigma1) = own("tau=3000,constant,weights=plain");
        let z = (hat - plain) / sigma0.hypot(sigma1);
        println!("{name}: {hat:.4} and {plain:.4}, z = {z:.2}");
        assert!(
            (hat / plain - 1.0).abs() < 0.03 || z.abs() < 4.5,
            "{name}: {hat} and {plain}"
        );
    }
}
