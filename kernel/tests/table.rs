//! Elements of tables, inside and outside of them.

use halflight_kernel::math::table::most_elements;
use halflight_kernel::math::{element, entry, field, within};
use halflight_kernel::scene::{LobeRecord, Quadric, Triangle};

#[test]
fn elements_and_fields() {
    let table: Vec<[f32; 3]> = (0..7).map(|i| [i as f32, 0.5, -(i as f32)]).collect();
    for i in 0..7 {
        assert_eq!(element(&table, i), table[i as usize]);
        assert_eq!(field(&table, i, |e| e[2]), -(i as f32));
        assert!(std::ptr::eq(within(&table, i).unwrap(), &table[i as usize]));
    }
    // Indices without their highest bits would be inside.
    let most = most_elements::<[f32; 3]>() as u32;
    for i in [
        7,
        8,
        most - 1,
        most,
        most + 3,
        1 << 31,
        u32::MAX - 1,
        u32::MAX,
    ] {
        assert_eq!(element(&table, i), [0.0; 3], "{i}");
        assert_eq!(field(&table, i, |e| e[1]), 0.0, "{i}");
        assert!(within(&table, i).is_none(), "{i}");
    }
    assert_eq!(element::<u32>(&[], 0), 0);
}

/// The last element's offset in words has 31 bits at most, and twice as many elements would have none to spare.
fn is_most<T>() {
    let words = size_of::<T>() / 4;
    let most = most_elements::<T>();
    assert!(most.is_power_of_two());
    assert!((most - 1) * words < 1 << 31 && 2 * most * words > 1 << 31);
}

#[test]
fn most_elements_have_offsets_of_a_word() {
    is_most::<u32>();
    is_most::<[f32; 2]>();
    is_most::<[f32; 3]>();
    is_most::<Triangle>();
    is_most::<Quadric>();
    is_most::<LobeRecord>();
    assert_eq!(most_elements::<[f32; 3]>(), 1 << 29);
}

#[test]
fn entries_beyond_the_end_are_the_last() {
    let table = [1.0, 2.0, 3.0];
    for (i, expected) in [(0, 1.0), (2, 3.0), (3, 3.0), (usize::MAX, 3.0)] {
        assert_eq!(entry(table, i), expected);
    }
}
