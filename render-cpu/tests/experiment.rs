//! The experiments, run quickly: their figures are those that the papers prove. Deterministic, with fixed seeds.

use halflight::experiment::{ALL, Report, appm, bounds, half_vector_flatness, mollified_estimator};
use halflight::plot::{Mark, Plot, PlotError, Scale, Series, write_png};

fn figure(report: &Report, name: &str) -> f64 {
    match report.figure(name) {
        Some(value) => value,
        None => panic!("no figure '{name}' among {:?}", report.figures),
    }
}

#[test]
fn the_mollified_estimator_converges_at_its_rates() {
    let report = mollified_estimator::run(true);
    for d in [1, 2] {
        for i in 0..5 {
            // Exponents in the order of the table: 0 and 1 are slow enough to be asymptotic by 2048 samples.
            let tolerance = if i < 2 { 0.03 } else { 0.3 };
            let bias = figure(&report, &format!("d{d} bias {i}"));
            assert!(bias.abs() < tolerance, "d {d}, {i}: {bias}");
            // 120 runs: the slope of the variance is known to about 0.1.
            let variance = figure(&report, &format!("d{d} variance {i}"));
            assert!(variance.abs() < 0.25, "d {d}, {i}: {variance}");
        }
        // The optimal exponent falls fastest, the inconsistent one not at all.
        let errors: Vec<f64> = (0..5)
            .map(|i| figure(&report, &format!("d{d} error {i}")))
            .collect();
        assert!(
            errors[1] < errors[3] - 0.2 && errors[4] > -0.1,
            "{errors:?}"
        );
    }
}

#[test]
fn progressive_photon_mapping_is_best_near_two_thirds() {
    let report = appm::run(true);
    let best = figure(&report, "best alpha");
    assert!((0.5..0.8).contains(&best), "{best}");
    for i in [3, 4, 5] {
        let slope = figure(&report, &format!("slope {i}"));
        let theory = figure(&report, &format!("theory {i}"));
        assert!((slope - theory).abs() < 0.15, "{i}: {slope} {theory}");
    }
    let kernel = figure(&report, "statistics, kernel variance");
    let known = figure(&report, "all constants known");
    assert!(kernel < 2.2 * known, "{}", report.text);
    for worse in ["statistics, equation 5.12", "fixed, r_1 / 4"] {
        assert!(figure(&report, worse) > 1.3 * kernel, "{}", report.text);
    }
}

#[test]
fn regularized_lobes_stay_below_tau() {
    let report = bounds::run(true);
    let largest = figure(&report, "largest over tau");
    assert!(largest > 0.9 && largest < 1.001, "{}", report.text);
    let least = figure(&report, "least refracted over tau");
    assert!(least > 0.94, "the search loses the peak: {}", report.text);
    assert!((figure(&report, "Beckmann 1 1 reflection") - 1.47).abs() < 0.03);
    for name in ["GGX 0.1 0.1 reflection", "Beckmann 0.4 0.4 reflection"] {
        let ratio = figure(&report, name);
        assert!(ratio > 0.9 && ratio < 1.001, "{name}: {ratio}");
    }
}

#[test]
fn half_vector_space_is_flat_and_decorrelated() {
    let report = half_vector_flatness::run(true);
    for curvature in ["0", "0.4"] {
        for alpha in ["0.02", "0.1", "0.3"] {
            let get = |name: &str| figure(&report, &format!("{name} {alpha} {curvature}"));
            assert!(
                get("distance") < 0.04,
                "{alpha} {curvature}: {}",
                get("distance")
            );
            assert!(get("distance") < 0.5 * get("area distance"));
            assert!(get("interaction") < 0.01 && get("area interaction") > 0.1);
        }
    }
}

#[test]
fn experiments_have_names_and_diagrams() {
    let directory = tempfile::tempdir().unwrap();
    for experiment in &ALL {
        assert!(!experiment.about.is_empty());
        assert_eq!(experiment.name, experiment.name.to_lowercase());
    }
    let report = half_vector_flatness::run(true);
    let path = directory.path().join("plot.png");
    write_png(&path, &report.plots).unwrap();
    let image = image::open(&path).unwrap().to_rgb8();
    let inked = image.pixels().filter(|p| p.0 != [255, 255, 255]).count();
    assert!(inked > 5_000, "{inked}");
    // Text is drawn: the title's strip above the diagram is not empty.
    let title = image
        .enumerate_pixels()
        .filter(|(_, y, p)| *y < 34 && p.0[0] < 128);
    assert!(title.count() > 200);
}

/// Points that an axis cannot show are left out; a diagram without any is an error, not a panic.
#[test]
fn diagrams_survive_odd_data() {
    let directory = tempfile::tempdir().unwrap();
    let plot = |points: Vec<(f64, f64)>, scale| Plot {
        title: "odd".into(),
        axes: ["x".into(), "y".into()],
        scales: [scale; 2],
        series: vec![Series {
            label: "data".into(),
            mark: Mark::Line,
            colour: 99,
            points,
        }],
    };
    let path = directory.path().join("odd.png");
    for scale in [Scale::Linear, Scale::Logarithmic] {
        for points in [
            vec![],
            vec![(f64::NAN, 1.0)],
            vec![(f64::INFINITY, f64::NAN)],
        ] {
            let result = write_png(&path, &[plot(points, scale)]);
            assert!(matches!(result, Err(PlotError::Empty(_))));
        }
        write_png(&path, &[plot(vec![(3.0, 7.0)], scale)]).unwrap();
        let mixed = vec![
            (1.0, -1.0),
            (0.0, 2.0),
            (1e-30, 1e30),
            (2.0, f64::NAN),
            (5.0, 5.0),
        ];
        write_png(&path, &[plot(mixed, scale)]).unwrap();
    }
    let negative = plot(vec![(-1.0, -1.0)], Scale::Logarithmic);
    assert!(write_png(&path, &[negative]).is_err());
    let unwritable = directory.path().join("missing").join("plot.png");
    let fine = plot(vec![(1.0, 2.0), (2.0, 3.0)], Scale::Linear);
    assert!(matches!(
        write_png(&unwritable, &[fine]),
        Err(PlotError::Write(..))
    ));
}
