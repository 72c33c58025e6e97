//! Microfacet distributions, their masking, and the sampling of normals.
//!
//! A distribution `D(m)` is the area of microfacets per solid angle of normals over area of macrosurface, so that the
//! integral of `D(m) m.z` is 1 (tested). Everything of Smith's theory follows from the area projected along `w`,
//!
//! `projected_area(w) = integral of D(m) max(w.m, 0) dm`, `G1(w) = w.z / projected_area(w)`,
//! `D_w(m) = D(m) max(w.m, 0) / projected_area(w)` (the visible normals).
//!
//! (Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs", equations 10, 16, 17.)
//! The projected area has no pole at grazing angles, which `G1 / w.z` has in its usual form; it is what each
//! distribution implements. Masking and shadowing are separable, `G2(wi, wo) = G1(wi) G1(wo)`.
//!
//! | kind | shape | projected area | [`Microfacets::sample_visible_normal`] |
//! |---|---|---|---|
//! | Beckmann | Gaussian slopes | exact | Smith's visible normals |
//! | GGX | Trowbridge-Reitz | exact | Smith's visible normals |
//! | Phong | power of the cosine | that of Beckmann's | visible normals of V-cavities |
//! | exponential power | `exp(-slope^(2 p))` | exact to 1e-4 | visible normals of V-cavities |
//!
//! The visible normals of V-cavities ([`v_cavity`]) are a density of normals like any other: they serve where Smith's
//! have no closed form, and [`Microfacets::visible_normal_weight`] is what the difference costs.
//!
//! `alpha` is the width along x and y; each component is clamped to [`ALPHA_MIN`] and above. Normals are unit, in the
//! local frame with z up; a normal with `m.z <= 0` has `D = 0`. A further distribution is a file below this one with
//! the same functions, and a branch in each method here.

pub mod beckmann;
pub mod exponential_power;
pub mod ggx;
pub mod phong;
pub mod v_cavity;

use crate::math::float::{abs, safe_sqrt};
use crate::math::frame::upper_unit_vector;
use crate::scene::distribution as kinds;
use glam::{Vec2, Vec3};

/// Smallest roughness: below it the half vector of two `f32` directions does not resolve the lobe.
pub const ALPHA_MIN: f32 = 1e-4;

/// `alpha` within the domain of this module.
#[inline]
pub fn clamp_alpha(alpha: Vec2) -> Vec2 {
    Vec2::new(alpha.x.max(ALPHA_MIN), alpha.y.max(ALPHA_MIN))
}

/// A distribution with its parameters.
#[derive(Clone, Copy, Debug)]
pub struct Microfacets {
    /// One of [`crate::scene::distribution`].
    pub kind: u32,
    /// Width along x and y, at least [`ALPHA_MIN`].
    pub alpha: Vec2,
    /// The exponent p of the exponential power distribution; the others do not read it.
    pub exponent: f32,
    /// The features that the scene uses, see [`crate::scene::features`].
    #[cfg(target_arch = "spirv")]
    pub features: u32,
}

impl Microfacets {
    /// A distribution with its width brought into the domain.
    #[inline]
    pub fn new(kind: u32, alpha: Vec2, exponent: f32) -> Microfacets {
        Microfacets {
            kind,
            alpha: clamp_alpha(alpha),
            exponent,
            #[cfg(target_arch = "spirv")]
            features: crate::scene::features::ALL,
        }
    }

    /// Whether the scene may have microfacets of the kind.
    #[inline]
    fn may_be(&self, kind: u32) -> bool {
        #[cfg(target_arch = "spirv")]
        {
            self.features & crate::scene::features::microfacets(kind) != 0
        }
        #[cfg(not(target_arch = "spirv"))]
        {
            let _ = kind;
            true
        }
    }

    #[inline]
    fn is(&self, kind: u32) -> bool {
        self.may_be(kind) && self.kind == kind
    }

    /// Whether [`Microfacets::sample_visible_normal`] draws Smith's visible normals.
    #[inline]
    pub fn has_smith_normals(&self) -> bool {
        self.kind == kinds::BECKMANN || self.kind == kinds::GGX
    }

    /// `D(m)`.
    #[cfg_attr(not(target_arch = "spirv"), inline(always))]
    pub fn distribution(&self, m: Vec3) -> f32 {
        if m.z <= 0.0 {
            return 0.0;
        }
        match self.kind {
            kinds::GGX if self.is(kinds::GGX) => ggx::distribution(self.alpha, m),
            kinds::PHONG if self.is(kinds::PHONG) => phong::distribution(self.alpha, m),
            kinds::EXPONENTIAL_POWER if self.is(kinds::EXPONENTIAL_POWER) => {
                exponential_power::distribution(self.alpha, self.exponent, m)
            }
            _ if self.may_be(kinds::BECKMANN) => beckmann::distribution(self.alpha, m),
            _ => 0.0,
        }
    }

    /// Area of the microfacets that face `w`, projected along `w`, per area of macrosurface: `|w.z| / G1`, at least
    /// `|w.z|`, positive for every unit `w`; the same on both sides.
    #[cfg_attr(not(target_arch = "spirv"), inline(always))]
    pub fn projected_area(&self, w: Vec3) -> f32 {
        // |w.z| tan(theta) times the roughness along the azimuth of w.
        let x = self.alpha.x * w.x;
        let y = self.alpha.y * w.y;
        let spread = safe_sqrt(x * x + y * y);
        let area = match self.kind {
            kinds::GGX if self.is(kinds::GGX) => ggx::projected_area(abs(w.z), spread),
            kinds::EXPONENTIAL_POWER if self.is(kinds::EXPONENTIAL_POWER) => {
                exponential_power::projected_area(abs(w.z), spread, self.exponent)
            }
            // Phong takes Beckmann's, see there.
            _ if self.may_be(kinds::BECKMANN) || self.may_be(kinds::PHONG) => {
                beckmann::projected_area(abs(w.z), spread)
            }
            _ => abs(w.z),
        };
        area.max(f32::MIN_POSITIVE)
    }

    /// Smith's masking `G1(w, m)`: the visible fraction of the microfacets with normal `m` seen along `w`, zero when
    /// `w` is not on the same side of `m` as of the macrosurface. `w` may be below the surface.
    #[inline]
    pub fn smith_g1(&self, w: Vec3, m: Vec3) -> f32 {
        if w.dot(m) * w.z <= 0.0 {
            return 0.0;
        }
        (abs(w.z) / self.projected_area(w)).min(1.0)
    }

    /// A normal with density [`Microfacets::normal_pdf`], `D(m) m.z`.
    #[cfg_attr(not(target_arch = "spirv"), inline(always))]
    pub fn sample_normal(&self, u: Vec2) -> Vec3 {
        match self.kind {
            kinds::PHONG if self.is(kinds::PHONG) => phong::sample_normal(self.alpha, u),
            kinds::EXPONENTIAL_POWER if self.is(kinds::EXPONENTIAL_POWER) => {
                self.stretch_slope(exponential_power::sample_slope(self.exponent, u))
            }
            kinds::GGX if self.is(kinds::GGX) => self.stretch_slope(ggx::sample_slope(u)),
            _ => self.stretch_slope(beckmann::sample_slope(u)),
        }
    }

    /// Density per solid angle of [`Microfacets::sample_normal`].
    #[inline]
    pub fn normal_pdf(&self, m: Vec3) -> f32 {
        self.distribution(m) * m.z
    }

    /// Samples a normal visible from `wi`, `wi.z >= 0`, with density [`Microfacets::visible_normal_pdf`].
    #[cfg_attr(not(target_arch = "spirv"), inline(always))]
    pub fn sample_visible_normal(&self, wi: Vec3, u: Vec2) -> Vec3 {
        let has_cavities = self.may_be(kinds::PHONG) || self.may_be(kinds::EXPONENTIAL_POWER);
        if has_cavities && !self.has_smith_normals() {
            return self.sample_cavity_normal(wi, u);
        }
        let w = self.stretched(wi);
        if w == Vec3::ZERO {
            return Vec3::Z;
        }
        let h = if self.is(kinds::GGX) {
            ggx::sample_visible_normal(w, u)
        } else if self.may_be(kinds::BECKMANN) {
            beckmann::sample_visible_normal(w, u)
        } else {
            Vec3::Z
        };
        self.unstretched(h)
    }

    /// The unit vector along `wi`, `wi.z >= 0`, where the roughness is stretched to one (Heitz and d'Eon 2014, "Importance
    /// Sampling Microfacet-Based BSDFs using the Distribution of Visible Normals", section 3): the visible normals of alpha
    /// are those of 1, stretched back. Zero in the plane of the surface.
    #[inline]
    pub(crate) fn stretched(&self, wi: Vec3) -> Vec3 {
        let stretched = Vec3::new(self.alpha.x * wi.x, self.alpha.y * wi.y, wi.z.max(0.0));
        let length = safe_sqrt(stretched.length_squared());
        if length < 1e-18 {
            return Vec3::ZERO;
        }
        stretched * (1.0 / length)
    }

    /// The unit normal that a normal of unit roughness is stretched back to.
    #[inline]
    pub(crate) fn unstretched(&self, h: Vec3) -> Vec3 {
        upper_unit_vector(self.alpha.x * h.x, self.alpha.y * h.y, h.z)
    }

    /// Density per solid angle of [`Microfacets::sample_visible_normal`].
    #[cfg_attr(not(target_arch = "spirv"), inline(always))]
    pub fn visible_normal_pdf(&self, wi: Vec3, m: Vec3) -> f32 {
        let cos_i = wi.dot(m);
        if wi.z < 0.0 || cos_i <= 0.0 {
            return 0.0;
        }
        if self.has_smith_normals() {
            self.distribution(m) * cos_i / self.projected_area(wi)
        } else if self.mirrors_normals() {
            self.distribution(m) * v_cavity::facing_area(wi, m)
        } else {
            self.normal_pdf(m)
        }
    }

    /// Smith's density of visible normals over [`Microfacets::visible_normal_pdf`], for a visible `m`: one for the
    /// distributions whose normals are sampled so.
    #[cfg_attr(not(target_arch = "spirv"), inline(always))]
    pub fn visible_normal_weight(&self, wi: Vec3, m: Vec3) -> f32 {
        if self.has_smith_normals() {
            return 1.0;
        }
        let cos_i = wi.dot(m);
        let sampled = if self.mirrors_normals() {
            v_cavity::facing_area(wi, m)
        } else {
            m.z
        };
        if cos_i <= 0.0 || sampled <= 0.0 {
            return 0.0;
        }
        cos_i / (self.projected_area(wi) * sampled)
    }

    /// Density of slopes `-m.xy / m.z`: `D(m) m.z^4`, whose integral over the plane is 1.
    #[inline]
    pub fn slope_density(&self, slope: Vec2) -> f32 {
        let z2 = 1.0 / (1.0 + slope.length_squared());
        let z = safe_sqrt(z2);
        self.distribution(Vec3::new(-slope.x * z, -slope.y * z, z)) * z2 * z2
    }

    /// The squared width of the Beckmann distribution that has the same logarithmic derivative of the slope density
    /// along the azimuth of `m`: `-2 t / (d ln P / dt)`, `t = tan(theta_m)`, with its limit at `t = 0`
    /// (Holzschuch et al. 2016, "Estimating Local Beckmann Roughness for Complex BSDFs", equation 3).
    #[inline]
    pub fn local_alpha_squared(&self, m: Vec3) -> f32 {
        let across = m.x * m.x + m.y * m.y;
        // 1 / alpha^2 along the azimuth of m; on the axis the mean of both.
        let (a2, b2) = (self.alpha.x * self.alpha.x, self.alpha.y * self.alpha.y);
        let inverse = if across > 0.0 {
            (m.x * m.x / a2 + m.y * m.y / b2) / across
        } else {
            0.5 / a2 + 0.5 / b2
        };
        // Slopes beyond 1e9 are the horizon.
        let t2 = across / (m.z * m.z).max(1e-18);
        match self.kind {
            kinds::GGX => 0.5 * (1.0 / inverse + t2),
            kinds::PHONG => phong::local_alpha_squared(inverse, t2),
            kinds::EXPONENTIAL_POWER => {
                exponential_power::local_alpha_squared(inverse, t2, self.exponent)
            }
            _ => 1.0 / inverse,
        }
    }

    /// Derivative of the logarithm of the slope density by `tan(theta_m)` at fixed azimuth.
    #[inline]
    pub fn ln_slope_density_derivative(&self, m: Vec3) -> f32 {
        let t = safe_sqrt((m.x * m.x + m.y * m.y) / (m.z * m.z).max(1e-18));
        -2.0 * t / self.local_alpha_squared(m)
    }

    /// Derivative of `ln D(m)` by `tan(theta_m)` at fixed azimuth: `D = P / m.z^4` adds `4 t / (1 + t^2)`.
    #[inline]
    pub fn ln_distribution_derivative(&self, m: Vec3) -> f32 {
        let t = safe_sqrt((m.x * m.x + m.y * m.y) / (m.z * m.z).max(1e-18));
        self.ln_slope_density_derivative(m) + 4.0 * t / (1.0 + t * t)
    }

    /// Whether [`Microfacets::sample_cavity_normal`] can mirror a normal: the azimuth must be uniform at every slope.
    /// Anisotropic Phong has no stretched form; all its normals are sampled.
    #[inline]
    fn mirrors_normals(&self) -> bool {
        self.kind != kinds::PHONG || self.alpha.x == self.alpha.y
    }

    /// A normal with the density of the visible normals of V-cavities, or of all normals.
    #[cfg_attr(not(target_arch = "spirv"), inline(always))]
    fn sample_cavity_normal(&self, wi: Vec3, u: Vec2) -> Vec3 {
        if !self.mirrors_normals() {
            return self.sample_normal(u);
        }
        // Slopes as multiples of the width, along azimuth zero.
        let (radius, stretch) = if self.is(kinds::PHONG) {
            (phong::sample_radius(self.alpha.x, u.y), Vec2::ONE)
        } else if self.may_be(kinds::EXPONENTIAL_POWER) {
            (
                exponential_power::sample_radius(self.exponent, u.y),
                self.alpha,
            )
        } else {
            (0.0, self.alpha)
        };
        let slope = v_cavity::sample_azimuth(
            Vec3::new(stretch.x * wi.x, stretch.y * wi.y, wi.z.max(0.0)),
            radius,
            u.x,
        );
        upper_unit_vector(stretch.x * slope.x, stretch.y * slope.y, 1.0)
    }

    #[inline]
    fn stretch_slope(&self, slope: Vec2) -> Vec3 {
        upper_unit_vector(self.alpha.x * slope.x, self.alpha.y * slope.y, 1.0)
    }
}

/// [`Microfacets::distribution`] of a kind without an exponent.
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn distribution(kind: u32, alpha: Vec2, m: Vec3) -> f32 {
    Microfacets::new(kind, alpha, 1.0).distribution(m)
}

/// [`Microfacets::projected_area`] of a kind without an exponent.
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn projected_area(kind: u32, alpha: Vec2, w: Vec3) -> f32 {
    Microfacets::new(kind, alpha, 1.0).projected_area(w)
}

/// [`Microfacets::smith_g1`] of a kind without an exponent.
#[inline]
pub fn smith_g1(kind: u32, alpha: Vec2, w: Vec3, m: Vec3) -> f32 {
    Microfacets::new(kind, alpha, 1.0).smith_g1(w, m)
}

/// [`Microfacets::sample_visible_normal`] of a kind without an exponent.
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn sample_visible_normal(kind: u32, alpha: Vec2, wi: Vec3, u: Vec2) -> Vec3 {
    Microfacets::new(kind, alpha, 1.0).sample_visible_normal(wi, u)
}

/// [`Microfacets::visible_normal_pdf`] of a kind without an exponent.
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn visible_normal_pdf(kind: u32, alpha: Vec2, wi: Vec3, m: Vec3) -> f32 {
    Microfacets::new(kind, alpha, 1.0).visible_normal_pdf(wi, m)
}

/// [`Microfacets::sample_normal`] of a kind without an exponent.
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn sample_normal(kind: u32, alpha: Vec2, u: Vec2) -> Vec3 {
    Microfacets::new(kind, alpha, 1.0).sample_normal(u)
}

/// [`Microfacets::normal_pdf`] of a kind without an exponent.
#[inline]
pub fn normal_pdf(kind: u32, alpha: Vec2, m: Vec3) -> f32 {
    Microfacets::new(kind, alpha, 1.0).normal_pdf(m)
}
