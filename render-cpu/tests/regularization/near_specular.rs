//! Metals and glass so little rough that they count as specular while the blur is wider than their lobes.

use crate::known_answers::{mirror_of, mirror_on_axis};
use crate::scenes::{ALGORITHMS, ball, bits, mollified, render_film, room, scene};
use glam::{Vec2, vec3};
use halflight_kernel::bsdf::microfacet::Microfacets;
use halflight_kernel::regularize::near_specular::slope_quantile;
use halflight_kernel::scene::distribution;

/// Share of the normals by D cos whose slope is at most `limit`, by 4000 midpoints of the angle.
fn share_below(kind: u32, alpha: f32, limit: f32) -> f64 {
    let facets = Microfacets::new(kind, Vec2::splat(alpha), 1.0);
    let last = f64::from(limit).atan();
    let steps = 4000;
    let mut sum = 0.0;
    for i in 0..steps {
        let theta = last * (f64::from(i) + 0.5) / f64::from(steps);
        let (sin, cos) = theta.sin_cos();
        let d = facets.distribution(vec3(sin as f32, 0.0, cos as f32));
        sum += f64::from(d) * cos * sin * last / f64::from(steps);
    }
    sum * std::f64::consts::TAU
}

#[test]
fn a_share_of_the_normals_lies_within_the_quantile() {
    for q in [0.5, 0.9, 0.99] {
        for alpha in [0.01_f32, 0.1, 0.3] {
            for kind in [
                distribution::GGX,
                distribution::BECKMANN,
                distribution::PHONG,
            ] {
                let share = share_below(kind, alpha, alpha * slope_quantile(kind, q));
                let is_exact = kind != distribution::PHONG;
                let error = share - f64::from(q);
                assert!(
                    error > -2e-3 && (!is_exact || error < 2e-3),
                    "kind {kind}, alpha {alpha}: {share} of {q}"
                );
            }
        }
    }
    assert!(slope_quantile(distribution::GGX, 1.0) > 1e6);
    assert!(slope_quantile(distribution::EXPONENTIAL_POWER, 0.5) > 1e6);
}

fn rough(alpha: f32) -> String {
    format!(
        r#"<bsdf type="roughconductor"><string name="material" value="none"/><float name="alpha" value="{alpha}"/>
        <string name="distribution" value="ggx"/></bsdf>"#
    )
}

#[test]
fn lobes_within_the_blur_are_mirrors() {
    for name in ALGORITHMS {
        let film = |content: &str, options: &str| {
            let mut scene = scene(name, content);
            scene.settings.rules.max_depth = 2;
            bits(&render_film(&mollified(scene, options), 16))
        };
        let mirror = film(&mirror_on_axis(), "r0=0.2,constant");
        let sharp = mirror_of(&rough(0.0005));
        // As wide as a twentieth of the scene.
        let wide = mirror_of(&rough(0.05));
        assert!(film(&sharp, "r0=0.2,constant") == mirror, "{name}");
        assert!(film(&wide, "r0=0.2,constant") != mirror, "{name}");
        let none = film(&sharp, "r0=0");
        assert!(
            film(&sharp, "r0=0.2,constant,quantile=1") == none,
            "{name}: no share is all of a lobe"
        );
        assert!(
            film(&sharp, "r0=0.0001,constant") == none,
            "{name}: wider than the blur"
        );
        assert!(none != mirror, "{name}");
    }
}

#[test]
fn glass_within_the_blur_is_smooth() {
    // The weights of vcm know from a pilot pass how many photons rough glass has.
    for name in ["path", "bdpt"] {
        let film = |glass: &str| {
            let walls = r#"<bsdf type="diffuse"/>"#;
            let scene = scene(name, &room(walls, &ball(glass)));
            bits(&render_film(&mollified(scene, "r0=5%,constant"), 4))
        };
        let sharp = r#"<bsdf type="roughdielectric"><float name="alpha" value="0.001"/></bsdf>"#;
        let wide = r#"<bsdf type="roughdielectric"><float name="alpha" value="0.1"/></bsdf>"#;
        let smooth = film(r#"<bsdf type="dielectric"/>"#);
        assert!(film(sharp) == smooth, "{name}");
        assert!(film(wide) != smooth, "{name}");
    }
}
