//! Forbids drivers to contract or reorder arithmetic.
//!
//! A driver may fuse a product with a sum, and may reorder operations as if they were associative, unless the result is
//! decorated with `NoContraction` (SPIR-V specification, section 3.20). The compiler decorates nothing, so `build-shaders` does
//! it for every result of floating-point arithmetic: the triangle test is watertight only if the two products of an edge function
//! are rounded separately (`halflight_kernel::scene::intersect`), and a path through several layers of glass ends at the same
//! point as on the processor only if all roundings are the same. Functions like the sine are the kernel's own
//! ([`halflight_kernel::math::float::elementary`]); only the last bits of quotients and roots can still differ.

use crate::module::instructions;
use std::collections::HashSet;

const OP_DECORATE: u32 = 71;
/// `OpDecorate`, `OpMemberDecorate` and the deprecated groups.
const DECORATIONS: std::ops::RangeInclusive<u32> = 71..=75;
const NO_CONTRACTION: u32 = 42;
/// Words before the first instruction.
const HEADER: usize = 5;

/// Whether an instruction computes with floating-point numbers.
fn is_arithmetic(opcode: u32) -> bool {
    const NEGATE: u32 = 127;
    const ADD: u32 = 129;
    const SUBTRACT: u32 = 131;
    const MULTIPLY: u32 = 133;
    const DIVIDE: u32 = 136;
    const REMAINDER: u32 = 140;
    const MODULO: u32 = 141;
    // Vectors and matrices with scalars and each other, and dot products.
    const PRODUCTS: std::ops::RangeInclusive<u32> = 142..=148;
    matches!(
        opcode,
        NEGATE | ADD | SUBTRACT | MULTIPLY | DIVIDE | REMAINDER | MODULO
    ) || PRODUCTS.contains(&opcode)
}

/// Results of arithmetic that a driver may still fuse, in the order of the module.
pub fn contractible(words: &[u32]) -> Vec<u32> {
    let exact: HashSet<u32> = instructions(words)
        .filter(|i| i[0] & 0xffff == OP_DECORATE && i.get(2) == Some(&NO_CONTRACTION))
        .map(|i| i[1])
        .collect();
    instructions(words)
        .filter(|i| is_arithmetic(i[0] & 0xffff))
        .map(|i| i[2])
        .filter(|result| !exact.contains(result))
        .collect()
}

/// The module with all its arithmetic decorated.
pub fn decorated(words: &[u32]) -> Vec<u32> {
    let results = contractible(words);
    // All modules have decorations: their bindings.
    let before: usize = instructions(words)
        .take_while(|i| !DECORATIONS.contains(&(i[0] & 0xffff)))
        .map(<[u32]>::len)
        .sum();
    let (start, rest) = words.split_at((HEADER + before).min(words.len()));
    let decorations = results
        .iter()
        .flat_map(|&result| [3 << 16 | OP_DECORATE, result, NO_CONTRACTION]);
    start
        .iter()
        .copied()
        .chain(decorations)
        .chain(rest.iter().copied())
        .collect()
}
