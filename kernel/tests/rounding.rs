//! Whole numbers from floats against the standard library's, over all exponents and at the ends.

use halflight_kernel::math::float::{floor, to_index, to_integer};

/// Floats of both signs, of every exponent, among them whole numbers, halves and their neighbours.
fn floats() -> impl Iterator<Item = f32> {
    let spread = (0..=f32::INFINITY.to_bits())
        .step_by(6151)
        .map(f32::from_bits);
    let halves = (0..4096).map(|i| 0.5 * i as f32);
    let powers = (0..128).map(|i| 2f32.powi(i));
    let near = halves
        .chain(powers)
        .flat_map(|x| [x, x.next_down().max(0.0), x.next_up()]);
    spread.chain(near).flat_map(|x| [x, -x])
}

#[test]
fn indices_are_whole_parts() {
    const END: f32 = 2_147_483_520.0;
    assert_eq!(END.next_up(), 2_147_483_648.0);
    for x in floats() {
        assert_eq!(to_index(x), x.min(END) as u32, "{x}");
    }
    assert_eq!(to_index(END), 2_147_483_520);
    assert_eq!(to_index(END.next_down()), 2_147_483_392);
    assert_eq!((to_index(0.0), to_index(-0.0)), (0, 0));
    for x in [1.0f32.next_down(), f32::MIN_POSITIVE, 1e-45] {
        assert_eq!((to_index(x), to_index(-x)), (0, 0), "{x}");
    }
    for x in [END.next_up(), f32::MAX, f32::INFINITY] {
        assert_eq!((to_index(x), to_index(-x)), (2_147_483_520, 0), "{x}");
    }
    assert_eq!((to_index(f32::NAN), to_index(-f32::NAN)), (0, 0));
}

#[test]
fn whole_floats_are_their_integers() {
    const END: f32 = 1_073_741_824.0;
    for x in floats() {
        assert_eq!(to_integer(x), x.clamp(-END, END) as i32, "{x}");
    }
    let end = END as i32;
    for x in [END, END.next_up(), f32::MAX, f32::INFINITY] {
        assert_eq!((to_integer(x), to_integer(-x)), (end, -end), "{x}");
    }
    let before = END.next_down();
    assert_eq!(
        (to_integer(before), to_integer(-before)),
        (end - 64, 64 - end)
    );
    assert_eq!((to_integer(0.0), to_integer(-0.0)), (0, 0));
    assert_eq!((to_integer(1.75), to_integer(-1.75)), (1, -1));
    assert_eq!((to_integer(f32::NAN), to_integer(-f32::NAN)), (-end, -end));
}

#[test]
fn floors_are_exact() {
    for x in floats() {
        // Zeros may differ in their sign.
        assert_eq!(floor(x), x.floor(), "{x}");
    }
    // From 2^23 on there are no fractions, below it the last is a half.
    let whole = 8_388_608.0f32;
    for x in [whole, whole.next_up(), f32::MAX, f32::INFINITY] {
        assert_eq!((floor(x), floor(-x)), (x, -x), "{x}");
    }
    let half = whole.next_down();
    assert_eq!((floor(half), floor(-half)), (whole - 1.0, -whole));
    assert_eq!((floor(0.5), floor(-0.5), floor(-1e-45)), (0.0, -1.0, -1.0));
    assert!(floor(f32::NAN).is_nan() && floor(-f32::NAN).is_nan());
}
