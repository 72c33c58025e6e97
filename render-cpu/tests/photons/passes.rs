//! Passes are samples: of any number of threads, cut anywhere, shared among runs.

use crate::scenes::{add_passes, film, integrator, scene};
use halflight::film::Film;
use halflight::film::aov::Aov;
use halflight::image::exr_output::{LayeredImage, write_exr};
use halflight::image::merge::Merger;
use halflight::image::metadata::{ImageMetadata, SampleRange};
use halflight::image::read_exr;

const CONTENT: &str = r#"<sensor type="perspective"><float name="fov" value="50"/>
    <transform name="to_world"><lookat origin="0, 1, 3" target="0, 0.5, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="40"/><integer name="height" value="35"/></film></sensor>
    <shape type="rectangle"><transform name="to_world"><scale value="2"/><rotate x="1" angle="-90"/></transform>
        <bsdf type="diffuse"/></shape>
    <shape type="sphere"><point name="center" x="0" y="0.5" z="0"/><float name="radius" value="0.5"/>
        <bsdf type="dielectric"/></shape>
    <emitter type="point"><point name="position" x="1" y="2" z="1"/></emitter>"#;

fn bits(film: &Film) -> Vec<[u64; 7]> {
    let pixels = film.statistics().iter();
    pixels
        .map(|p| {
            let numbers = p.mean.into_iter().chain(p.m2).chain([p.luminance_m2]);
            let mut bits = [0; 7];
            bits.iter_mut()
                .zip(numbers)
                .for_each(|(b, x)| *b = x.to_bits());
            bits
        })
        .collect()
}

#[test]
fn any_number_of_threads_and_any_cut_give_the_same_bits() {
    let rules = [("photon_count", 5000.0), ("max_depth", 6.0)];
    let nearest = [rules[0], rules[1], ("nearest", 8.0)];
    for (plugin, sampler, properties) in [
        ("sppm", "independent", &rules[..]),
        ("sppm", "sobol", &rules),
        ("sppm", "independent", &nearest),
        ("mcppm", "independent", &rules),
        ("appm", "independent", &rules),
        ("vcm", "independent", &rules),
        ("vm", "sobol", &rules),
    ] {
        let content = CONTENT.replace("</film>", &format!("</film><sampler type=\"{sampler}\"/>"));
        let scene = scene(&integrator(plugin, properties), &content);
        let with_threads = |threads: usize, count: u32| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| film(&scene, 5, 0, count))
        };
        let whole = with_threads(1, 6);
        assert!(whole.mean().iter().any(|p| p[0] > 0.0));
        assert_eq!(bits(&with_threads(3, 6)), bits(&whole));
        let mut cut = with_threads(2, 2);
        add_passes(&scene, &mut cut, 5, 0, 4);
        assert_eq!(bits(&cut), bits(&whole));
        if plugin == "appm" {
            // The bandwidths are part of what is kept.
            assert_eq!(cut, whole);
            let bandwidth = whole.aov_mean(Aov::Bandwidth, 0, 700);
            assert!(bandwidth > 0.0, "{bandwidth}");
            continue;
        }
        // Runs of different passes merge to the mean of all.
        let mut shares = film(&scene, 5, 0, 2);
        shares.merge(&film(&scene, 5, 2, 4));
        for (a, b) in shares.mean().iter().zip(whole.mean()) {
            for c in 0..3 {
                assert!((a[c] - b[c]).abs() <= 1e-12 * b[c].abs());
            }
        }
    }
}

/// Images whose passes depend on each other are not merged, and the reason is said.
#[test]
fn adaptive_images_are_not_merged() {
    let scene = scene(&integrator("appm", &[("photon_count", 2000.0)]), CONTENT);
    let folder = tempfile::tempdir().unwrap();
    let image = |from: u32| {
        let film = film(&scene, 5, from, 2);
        let metadata = ImageMetadata {
            scene: "test.xml".into(),
            integrator: scene.integrator.clone(),
            sample_ranges: vec![SampleRange {
                seed: 5,
                from,
                to: from + 2,
            }],
            samples_per_pixel: Some(2),
            ..ImageMetadata::default()
        };
        let path = folder.path().join(format!("{from}.exr"));
        write_exr(
            &path,
            &LayeredImage::from_film(&film, [40, 35], metadata),
            false,
        )
        .unwrap();
        read_exr(&path).unwrap()
    };
    let (first, second) = (image(0), image(2));
    assert!(first.channel("bandwidth").unwrap().iter().any(|r| *r > 0.0));
    let mut merger = Merger::new("first.exr", &first, false).unwrap();
    let error = merger.add("second.exr", &second).unwrap_err().to_string();
    assert!(
        error.contains("second.exr") && error.contains("radii"),
        "{error}"
    );
    let mut merger = Merger::new("first.exr", &first, true).unwrap();
    merger.add("second.exr", &second).unwrap();
    assert!(merger.warnings().iter().any(|w| w.contains("radii")));
}
