//! Where nothing is to be regularised nothing changes, and a sample does not depend on the run that takes it.

use crate::scenes::{
    ALGORITHMS, DIFFUSE, MIRROR, add, ball, bits, film, mollified, regularized, render_film, room,
    scene,
};
use halflight::film::Film;

#[test]
fn nothing_changes_without_shiny_materials() {
    // alpha_hat is 0.43 at most.
    let rough = r#"<bsdf type="roughconductor"><float name="alpha" value="0.5"/></bsdf>"#;
    for name in ALGORITHMS {
        let plain = || scene(name, &room(DIFFUSE, &ball(rough)));
        let expected = bits(&render_film(&plain(), 4));
        for tau in ["tau=30", "tau=1000,constant"] {
            let film = render_film(&regularized(plain(), tau), 4);
            assert!(bits(&film) == expected, "{name}, {tau}");
        }
        // Paths followed one by one are added in another order.
        let film = render_film(&regularized(plain(), "tau=30,quality,diffusion"), 4);
        assert!(is_same(&film, &render_film(&plain(), 4)), "{name}");
        let film = render_film(&mollified(plain(), "r0=5%"), 4);
        assert!(bits(&film) == expected, "{name}, mollified");
    }
}

#[test]
fn an_infinite_tau_and_a_radius_of_zero_are_no_regularisation() {
    for name in ALGORITHMS {
        let plain = || scene(name, &room(DIFFUSE, &ball(MIRROR)));
        let expected = bits(&render_film(&plain(), 3));
        let infinite = render_film(&regularized(plain(), "tau=inf"), 3);
        assert!(bits(&infinite) == expected, "{name}");
        let infinite = regularized(plain(), "tau=inf,quality,diffusion");
        assert!(bits(&render_film(&infinite, 3)) == expected, "{name}");
        let zero = render_film(&mollified(plain(), "r0=0"), 3);
        assert!(bits(&zero) == expected, "{name}");
        let finite = render_film(&regularized(plain(), "tau=30"), 3);
        assert!(bits(&finite) != expected, "{name} is not regularised");
    }
}

#[test]
fn samples_are_regularised_by_their_index() {
    for (name, options) in ALGORITHMS
        .iter()
        .flat_map(|n| [(n, "tau=20"), (n, "tau=20,fade=0.2,diffusion")])
    {
        let scene = regularized(scene(name, &room(DIFFUSE, &ball(MIRROR))), options);
        let whole = render_film(&scene, 6);
        // A run that goes on.
        let mut resumed = film(&scene);
        add(&scene, &mut resumed, 0, 2);
        add(&scene, &mut resumed, 0, 6);
        assert!(bits(&resumed) == bits(&whole), "{name}, {options}");
        // Shares of several machines: their mean is that of the whole but for rounding.
        let mut shares = Vec::new();
        for first in [0, 3] {
            let mut share = film(&scene);
            add(&scene, &mut share, first, 3);
            shares.push(share);
        }
        let of = |k: usize| shares[k].mean();
        for ((a, b), expected) in of(0).iter().zip(&of(1)).zip(&whole.mean()) {
            for c in 0..3 {
                let mean = 0.5 * (a[c] + b[c]);
                let close = (mean - expected[c]).abs() <= 1e-5 * expected[c].max(1.0);
                assert!(close, "{name}, {options}: {mean} for {}", expected[c]);
            }
        }
    }
}

/// Whether two images are equal but for the order in which light was added.
fn is_same(a: &Film, b: &Film) -> bool {
    let (a, b) = (a.mean(), b.mean());
    let all = a.iter().flatten().zip(b.iter().flatten());
    all.into_iter()
        .all(|(a, b)| (a - b).abs() <= 1e-5 * b.abs().max(1e-3))
}
