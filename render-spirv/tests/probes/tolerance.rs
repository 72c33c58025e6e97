//! The one table of how far a device may be from the processor, each row with its reason.
//!
//! Both run the same kernel in `f32`, in which all but quotients and roots is rounded in one way: elementary functions are the
//! kernel's own, and the modules forbid a device to fuse products with sums. Of quotients Vulkan asks for 2.5 ulp, of roots for
//! what an inverse root of 2 ulp gives ("Precision and Operation of SPIR-V Instructions"), and subnormal numbers a device may
//! take as zero. Mesa's software device rounds these too as a processor does: there every difference is zero.

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
        "A quotient among coordinates of up to 100 moves the place between texels by its rounding.",
    ),
    row(
        &["ceil", "floor", "sin", "cos", "exp", "ln", "gamma_1p"],
        0.0,
        0.0,
        0,
        "Sums, products and bits.",
    ),
    row(
        &["sqrt", "tan", "atan", "atan2", "pow", "erf", "erfc_scaled"],
        0.0,
        6e-7,
        0,
        "One quotient or root; 5 ulp where a subtraction follows.",
    ),
    row(&["erf_inv"], 0.0, 2e-6, 0, "A root less a constant."),
    row(
        &["inverse_gamma"],
        1e-6,
        2e-5,
        0,
        "Halley's steps end at a relative 1e-5 on either side.",
    ),
    row(
        &["scaled product"],
        1e-6,
        1e-6,
        0,
        "A quotient, and the logarithm of it, which is absolute near one.",
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
        "Several quotients and roots.",
    ),
    row(&["filter"], 2e-6, 2e-6, 0, "Quotients."),
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
    row(
        &["bandwidth"],
        1e-30,
        2e-5,
        0,
        "exp and pow of up to 80 times a quotient.",
    ),
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
        "A quotient and a root.",
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
        "Several quotients and roots.",
    ),
    row(
        &["disk lobe sample"],
        4e-6,
        1e-5,
        0,
        "Quotients and roots, of which some cancel.",
    ),
    row(
        &["disk lobe density"],
        1e-6,
        1e-3,
        0,
        "A power with exponents of up to 1e6.",
    ),
    row(
        &["slope gaussian"],
        1e-6,
        2e-5,
        0,
        "exp of squares of quotients.",
    ),
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
        "Several quotients and roots.",
    ),
    row(
        &["chain measure"],
        1e-5,
        1e-5,
        200,
        "Ill-conditioned chains, up to 1e6, amplify; so does the estimate of their condition.",
    ),
    row(
        &["Beckmann values"],
        2e-5,
        2e-5,
        0,
        "exp of a quotient of up to 80.",
    ),
    row(
        &["GGX values"],
        2e-6,
        4e-6,
        0,
        "Several quotients and roots.",
    ),
    row(
        &["Phong values"],
        5e-5,
        5e-5,
        0,
        "pow of a quotient, with exponents of up to 2e6.",
    ),
    row(
        &["exponential power values"],
        5e-5,
        1e-4,
        0,
        "exp of a power of a quotient.",
    ),
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
        "Quotients and roots, of which some cancel.",
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
        "Quotients and roots; small components cancel.",
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
        "Several quotients and roots; absorption of coats is an exp of one.",
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
        "Several quotients and roots.",
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
        "The distribution's exp or pow of quotients, and tables between whose entries both interpolate alike.",
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
