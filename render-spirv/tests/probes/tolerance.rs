//! The one table of how far a device may be from the processor, each row with its reason.
//!
//! Both run the same kernel in `f32`; what differs is the functions that Vulkan leaves to the device (its
//! specification, "Precision and Operation of SPIR-V Instructions": 2.5 ulp for division, 3 ulp for `exp` and `ln` outside
//! the neighbourhood of 1, 2^-11 absolute for `sin` and `cos`, 4096 ulp for `atan`), products that a compiler fuses with
//! sums, and subnormal numbers, which a device may take as zero.

/// How far results may differ: `|device - host| <= absolute + relative |host|`, except for `outliers` in 10,000 inputs.
#[derive(Clone, Copy, Debug)]
pub struct Tolerance {
    /// Names of the probes.
    names: &'static [&'static str],
    /// Absolute part.
    pub absolute: f32,
    /// Relative part.
    pub relative: f32,
    /// Inputs of 10,000 that may lie outside.
    pub outliers: usize,
    /// Why.
    pub reason: &'static str,
}

/// The row of a probe.
///
/// # Panics
/// If there is none.
pub fn tolerance(name: &str) -> &'static Tolerance {
    TABLE
        .iter()
        .find(|row| row.names.contains(&name))
        .unwrap_or_else(|| panic!("no tolerance for {name}"))
}

const fn row(
    names: &'static [&'static str],
    absolute: f32,
    relative: f32,
    outliers: usize,
    reason: &'static str,
) -> Tolerance {
    Tolerance {
        names,
        absolute,
        relative,
        outliers,
        reason,
    }
}

const TABLE: &[Tolerance] = &[
    row(
        &["texture"],
        5e-5,
        1e-4,
        0,
        "A texture's affine map of coordinates of up to 100, fused or not, moves the place between texels by their rounding.",
    ),
    row(
        &["sqrt"],
        0.0,
        5e-7,
        0,
        "3 ulp, by way of the inverse root.",
    ),
    row(&["ceil", "floor"], 0.0, 0.0, 0, "Exact."),
    row(
        &["sin", "cos"],
        2e-6,
        0.0,
        0,
        "Vulkan asks for 2^-11; lavapipe's are good to an ulp.",
    ),
    row(&["tan"], 1e-6, 2e-6, 0, "sin over cos."),
    row(
        &["atan"],
        1e-6,
        5e-5,
        0,
        "lavapipe's polynomial; Vulkan asks for 4096 ulp. The kernel takes its own atan2.",
    ),
    row(
        &["exp"],
        0.0,
        1e-5,
        0,
        "By exp2(x log2 e): the product's rounding grows with x, here up to 80.",
    ),
    row(
        &["ln"],
        4e-6,
        1e-6,
        0,
        "Absolute near one, where the result vanishes.",
    ),
    row(
        &["pow"],
        1e-30,
        1e-5,
        0,
        "exp2(y log2 x), as exp; what underflows may be zero.",
    ),
    row(
        &["atan2", "erfc_scaled", "gamma_1p"],
        1e-7,
        1e-6,
        0,
        "The kernel's own polynomials. Sums, products, quotients and roots; a device may divide with 2.5 ulp and fuse products with sums.",
    ),
    row(
        &["erf", "erf_inv"],
        1e-6,
        1e-6,
        0,
        "The kernel's polynomials over exp or ln.",
    ),
    row(
        &["inverse_gamma"],
        1e-6,
        2e-5,
        0,
        "Halley's steps end at a relative 1e-5 on either side.",
    ),
    row(
        &["scaled product"],
        4e-6,
        5e-6,
        0,
        "Mantissa and exponent are exact, the logarithm is absolute near one.",
    ),
    row(
        &[
            "fresnel_dielectric",
            "fresnel_conductor",
            "fresnel_diffuse_reflectance",
            "mollifier",
            "bounds",
            "alpha_hat",
            "heuristics",
            "square_to_triangle",
            "frame",
            "reflect and refract",
            "moebius",
            "cone value",
            "half vector",
            "half vector outgoing",
            "diffuse bounds",
            "rough diffuse bounds",
            "conductor bounds",
            "rough conductor bounds",
            "dielectric bounds",
            "thin dielectric bounds",
            "rough dielectric bounds",
            "plastic bounds",
            "rough plastic bounds",
            "coat bounds",
            "rough coat bounds",
            "measured bounds",
            "diffracting conductor bounds",
            "null bounds",
        ],
        1e-6,
        2e-6,
        0,
        "Sums, products, quotients and roots; a device may divide with 2.5 ulp and fuse products with sums.",
    ),
    row(
        &["filter"],
        2e-6,
        2e-6,
        0,
        "sin and exp of the windowed filters.",
    ),
    row(
        &["sampler"],
        0.0,
        0.0,
        0,
        "Integers: exact, or the two would not see the same paths.",
    ),
    row(
        &["mollifier radius"],
        1e-5,
        1e-5,
        0,
        "Roots of pow of what is left at the rim.",
    ),
    row(&["bandwidth"], 1e-30, 2e-5, 0, "exp and pow of up to 80."),
    row(
        &[
            "square_to_disk",
            "square_to_uniform_sphere",
            "square_to_uniform_hemisphere",
            "square_to_uniform_cone",
        ],
        1e-6,
        1e-6,
        0,
        "sin and cos.",
    ),
    row(
        &["square_to_cosine_hemisphere"],
        2e-6,
        1e-6,
        400,
        "On the square's border z is the root of a difference that cancels: up to 3.5e-4. A tenth of the inputs lie there.",
    ),
    row(
        &["half vector charts"],
        2e-6,
        2e-6,
        0,
        "Sums, products, quotients and roots; a device may divide with 2.5 ulp and fuse products with sums.",
    ),
    row(
        &["disk lobe sample"],
        4e-6,
        1e-5,
        0,
        "exp, ln, sin and cos.",
    ),
    row(
        &["disk lobe density"],
        1e-6,
        1e-3,
        0,
        "A power with exponents of up to 1e6.",
    ),
    row(&["slope gaussian"], 1e-6, 2e-5, 0, "ln, exp, sin and cos."),
    row(
        &["cone sample"],
        4e-6,
        4e-6,
        5,
        "A pole of the whole sphere: the root of a difference that cancels.",
    ),
    row(
        &["mollifier sample"],
        1e-5,
        1e-5,
        0,
        "As the mollifier's radius.",
    ),
    row(
        &["block-tridiagonal solve"],
        2e-6,
        2e-5,
        30,
        "Components far below the solution's norm carry its rounding.",
    ),
    row(
        &["constraint"],
        4e-6,
        4e-6,
        0,
        "Sums, products, quotients and roots; a device may divide with 2.5 ulp and fuse products with sums.",
    ),
    row(
        &["chain measure"],
        1e-5,
        1e-5,
        200,
        "Ill-conditioned chains, up to 1e6, amplify; so does the estimate of their condition.",
    ),
    row(&["Beckmann values"], 2e-5, 2e-5, 0, "exp of up to 80."),
    row(
        &["GGX values"],
        2e-6,
        4e-6,
        0,
        "Sums, products, quotients and roots; a device may divide with 2.5 ulp and fuse products with sums.",
    ),
    row(
        &["Phong values"],
        5e-5,
        5e-5,
        0,
        "pow with exponents of up to 2e6.",
    ),
    row(&["exponential power values"], 5e-5, 1e-4, 0, "exp of pow."),
    row(
        &[
            "Beckmann normal",
            "Phong normal",
            "Phong visible normal",
            "GGX normal",
            "exponential power normal",
        ],
        2e-6,
        1e-5,
        0,
        "ln, sin and cos.",
    ),
    row(
        &["GGX visible normal"],
        2e-6,
        1e-5,
        5,
        "u on the border cancels.",
    ),
    row(
        &["exponential power visible normal"],
        4e-6,
        1e-4,
        0,
        "ln, sin and cos; small components cancel.",
    ),
    row(
        &["Beckmann visible normal"],
        4e-6,
        1e-4,
        400,
        "u at its largest lies in the far tail, which has one bit left; a tenth of the inputs are there.",
    ),
    row(
        &[
            "diffuse value",
            "rough diffuse value",
            "conductor value",
            "dielectric value",
            "thin dielectric value",
            "plastic value",
            "coat value",
            "null value",
        ],
        2e-6,
        1e-5,
        0,
        "Absorption of coats is an exp; else sums, products, quotients and roots; a device may divide with 2.5 ulp and fuse products with sums.",
    ),
    row(
        &["diffuse sample", "rough diffuse sample", "plastic sample"],
        1e-5,
        1e-4,
        200,
        "z on the border of the square, as square_to_cosine_hemisphere.",
    ),
    row(
        &[
            "conductor sample",
            "dielectric sample",
            "thin dielectric sample",
            "coat sample",
            "null sample",
        ],
        2e-6,
        1e-5,
        0,
        "Sums, products, quotients and roots; a device may divide with 2.5 ulp and fuse products with sums.",
    ),
    row(
        &[
            "rough conductor value",
            "rough dielectric value",
            "rough plastic value",
            "rough coat value",
            "measured value",
            "diffracting conductor value",
        ],
        1e-5,
        1e-4,
        0,
        "The distribution's exp or pow, and tables between whose entries both interpolate alike.",
    ),
    row(
        &[
            "rough conductor sample",
            "rough dielectric sample",
            "rough plastic sample",
            "rough coat sample",
            "measured sample",
            "diffracting conductor sample",
        ],
        2e-5,
        5e-4,
        600,
        "u on the border and wi in the horizon: one rounding decides whether wo is above it, and 1 / cos amplifies. Edges are a fifth of each input.",
    ),
];
