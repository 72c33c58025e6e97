//! Sampling of rays that leave emitters, and the density of a given ray.
//!
//! A ray starts at x_0 in the direction w with a density that is a product of two, per area at x_0 and per solid angle:
//!
//! | emitter | position | direction | weight |
//! |---|---|---|---|
//! | area | uniform, 1 / area | cosine about the shading normal, cos / pi | Le \|w.n_g\| / (p_A p_w) |
//! | point | discrete | uniform, 1 / (4 pi) | I / p_w |
//! | spot | discrete | uniform in the cone of the cutoff | I(w) / p_w |
//! | projector | discrete | uniform on the image plane, 1 / (A cos^3) | pi T A |
//! | collimated | discrete | discrete | power |
//! | directional | disk of the scene's radius across the direction, 1 / (pi R^2) | discrete | E pi R^2 |
//! | constant, environment | the same disk | the table of next event estimation | L / (p_A p_w) |
//!
//! The emitter is chosen as for next event estimation; the probability of the choice is part of the density of the
//! position. A discrete position or direction has the density one. Light from infinity has no starting position: its
//! direction has a density per solid angle, and the first surface that the ray hits is sampled with the density p_A \|cos\|
//! per area, at any distance (Veach 1997, sections 8.2 and 10.1).
//!
//! The weights of strategies need one more number, [`light_cosine`], which relates the densities at the emitter and at the
//! first surface point: \|w.n_g\| on area lights, the squared distance for discrete positions, one at infinity.
//!
//! Invariants (tests): rays follow their densities (chi-square), [`density`] of a sampled ray is the sampled density, and
//! the mean weight is the emitter's power.

use super::position::{pdf_position, sample_position};
use super::{area_radiance, delta, environment, select_emitter};
use crate::math::affine::{transform_vector, translation};
use crate::math::{Frame, Ray, Rgb, float, vec3, warp};
use crate::scene::{NONE, SurfacePoint, Tables, emitter_kind, features};
use core::f32::consts::{FRAC_1_PI, PI};
use glam::{Vec2, Vec3};

/// Whether light of an emitter of the kind comes from infinity.
#[inline]
pub fn is_infinite(kind: u32) -> bool {
    kind == emitter_kind::DIRECTIONAL
        || kind == emitter_kind::CONSTANT
        || kind == emitter_kind::ENVIRONMENT
}

/// Whether no ray can hit emitters of the kind, because their position or their direction is discrete.
#[inline]
pub fn is_delta(kind: u32) -> bool {
    kind == emitter_kind::POINT
        || kind == emitter_kind::SPOT
        || kind == emitter_kind::PROJECTOR
        || kind == emitter_kind::DIRECTIONAL
        || kind == emitter_kind::COLLIMATED
}

/// The density of a ray that leaves an emitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmissionDensity {
    /// Per area, the choice of the emitter included; the probability of the choice where the position is discrete.
    pub position: f32,
    /// Per solid angle; one where the direction is discrete.
    pub direction: f32,
}

impl EmissionDensity {
    /// No ray.
    pub const NONE: EmissionDensity = EmissionDensity {
        position: 0.0,
        direction: 0.0,
    };

    /// Density of the ray.
    #[inline]
    pub fn product(&self) -> f32 {
        self.position * self.direction
    }
}

/// A ray that leaves an emitter.
#[derive(Clone, Copy, Debug)]
pub struct EmissionSample {
    /// The ray.
    pub ray: Ray,
    /// Emitted radiance times the cosine at the emitter over the density: the flux of the ray.
    pub weight: Rgb,
    /// Its density.
    pub density: EmissionDensity,
    /// The point of an area light; for other emitters only the position is defined.
    pub point: SurfacePoint,
    /// Index of the emitter, [`NONE`] for no sample.
    pub emitter: u32,
}

impl EmissionSample {
    /// No ray.
    pub const NONE: EmissionSample = EmissionSample {
        ray: Ray {
            origin: Vec3::ZERO,
            direction: Vec3::Z,
            t_min: 0.0,
            t_max: 0.0,
        },
        weight: Vec3::ZERO,
        density: EmissionDensity::NONE,
        point: SurfacePoint::ZERO,
        emitter: NONE,
    };

    /// Whether it carries flux.
    #[inline]
    pub fn is_some(&self) -> bool {
        self.emitter != NONE && self.weight.max_element() > 0.0
    }
}

/// Samples a ray that leaves an emitter, `u_select` choosing the emitter, `u_position` and `u_direction` the rest.
pub fn sample(
    tables: &Tables<'_>,
    u_select: f32,
    u_position: Vec2,
    u_direction: Vec2,
) -> EmissionSample {
    let emitter = select_emitter(tables, u_select);
    if emitter == NONE {
        return EmissionSample::NONE;
    }
    let record = &tables.emitters[emitter as usize];
    let kind = record.kind;
    let mut sample = EmissionSample {
        emitter,
        ..EmissionSample::NONE
    };
    let radiance;
    // |w.n_g|, for radiance; one for intensity and irradiance.
    let mut cosine = 1.0;
    if tables.has(features::AREA_LIGHTS) && kind == emitter_kind::AREA {
        let (point, pdf) = sample_position(tables, emitter, u_position);
        let local = warp::square_to_cosine_hemisphere(u_direction);
        let direction = Frame::from_normal(point.frame.n)
            .to_world(local)
            .normalize();
        sample.density = EmissionDensity {
            position: pdf,
            direction: warp::cosine_hemisphere_pdf(point.frame.n.dot(direction)),
        };
        cosine = float::abs(point.geometric_normal.dot(direction));
        radiance = area_radiance(tables, &point, direction);
        sample.ray = point.spawn(direction);
        sample.point = point;
    } else if is_infinite(kind) {
        let direct = super::sample_emitter(tables, emitter, vec3(tables.info.center), u_direction);
        if !direct.is_some() {
            return EmissionSample::NONE;
        }
        radiance = direct.radiance;
        sample.density = EmissionDensity {
            position: disk_pdf(tables),
            direction: direct.pdf,
        };
        sample.ray = from_disk(tables, -direct.direction, u_position);
        sample.point.position = sample.ray.origin;
    } else if tables.has(features::DELTA_LIGHTS) {
        let local = sample_delta_direction(tables, emitter, u_direction);
        let direction = transform_vector(&record.to_world, local).normalize();
        sample.density = EmissionDensity {
            position: 1.0,
            direction: delta_direction_pdf(tables, emitter, direction),
        };
        radiance = if kind == emitter_kind::COLLIMATED {
            vec3(record.radiance.value)
        } else {
            delta::intensity(tables, emitter, direction)
        };
        sample.ray = Ray::new(translation(&record.to_world), direction);
        sample.point.position = sample.ray.origin;
    } else {
        return EmissionSample::NONE;
    }
    let pdf = sample.density.product();
    sample.density.position *= record.selection_pdf;
    let weight = radiance * (cosine / (pdf * record.selection_pdf));
    if !(pdf > 0.0) || !weight.is_finite() {
        return EmissionSample::NONE;
    }
    sample.weight = weight;
    sample
}

/// A ray whose start is that of another, the position of an area or point light or the direction of one at infinity: the rest is
/// sampled as in [`sample`]. Not for shaders, which keep no starts.
#[cfg(not(target_arch = "spirv"))]
pub fn resume(
    tables: &Tables<'_>,
    emitter: u32,
    point: &SurfacePoint,
    direction: Vec3,
    u_position: Vec2,
    u_direction: Vec2,
) -> Ray {
    let record = &tables.emitters[emitter as usize];
    if record.kind == emitter_kind::AREA {
        let local = warp::square_to_cosine_hemisphere(u_direction);
        let frame = Frame::from_normal(point.frame.n);
        point.spawn(frame.to_world(local).normalize())
    } else if is_infinite(record.kind) {
        from_disk(tables, direction, u_position)
    } else {
        let local = sample_delta_direction(tables, emitter, u_direction);
        let direction = transform_vector(&record.to_world, local).normalize();
        Ray::new(translation(&record.to_world), direction)
    }
}

/// The density with which [`sample`] starts a ray at a point of an emitter (whose position matters for area lights only) in
/// the unit `direction`, which leads away from it. Zero for discrete emitters other than the given one.
pub fn density(
    tables: &Tables<'_>,
    emitter: u32,
    point: &SurfacePoint,
    direction: Vec3,
) -> EmissionDensity {
    if emitter == NONE {
        return EmissionDensity::NONE;
    }
    let record = &tables.emitters[emitter as usize];
    let kind = record.kind;
    let mut result = if tables.has(features::AREA_LIGHTS) && kind == emitter_kind::AREA {
        EmissionDensity {
            position: pdf_position(tables, point),
            direction: warp::cosine_hemisphere_pdf(point.frame.n.dot(direction)),
        }
    } else if kind == emitter_kind::DIRECTIONAL {
        EmissionDensity {
            position: disk_pdf(tables),
            direction: 1.0,
        }
    } else if is_infinite(kind) {
        EmissionDensity {
            position: disk_pdf(tables),
            direction: environment::pdf(tables, emitter, -direction),
        }
    } else {
        EmissionDensity {
            position: 1.0,
            direction: delta_direction_pdf(tables, emitter, direction),
        }
    };
    result.position *= record.selection_pdf;
    result
}

/// The factor that relates the densities at an emitter and at the first surface point, at a squared distance of `distance2`:
/// see the module.
#[inline]
pub fn light_cosine(
    tables: &Tables<'_>,
    emitter: u32,
    point: &SurfacePoint,
    direction: Vec3,
    distance2: f32,
) -> f32 {
    let kind = tables.emitters[emitter as usize].kind;
    if kind == emitter_kind::AREA {
        float::abs(point.geometric_normal.dot(direction))
    } else if is_infinite(kind) {
        1.0
    } else {
        distance2
    }
}

/// Density per area of the disk, perpendicular to a direction, through which light from infinity is sampled.
#[inline]
fn disk_pdf(tables: &Tables<'_>) -> f32 {
    let radius = tables.info.radius;
    FRAC_1_PI / (radius * radius)
}

/// A ray in `direction` that starts on the disk of the scene's radius in front of the scene.
#[inline]
fn from_disk(tables: &Tables<'_>, direction: Vec3, u: Vec2) -> Ray {
    let radius = tables.info.radius;
    let frame = Frame::from_normal(direction);
    let p = warp::square_to_disk(u) * radius;
    let center = vec3(tables.info.center);
    // Twice the radius, so that no surface at the sphere's rim is missed by rounding.
    let origin = center + frame.s * p.x + frame.t * p.y - direction * (2.0 * radius);
    Ray::new(origin, direction)
}

/// 1 - cos of the cone of a spot light.
#[inline]
fn cone(cutoff: f32) -> f32 {
    2.0 * float::sqr(float::sin(0.5 * cutoff.min(PI)))
}

/// A direction in the frame of a light with a discrete position.
fn sample_delta_direction(tables: &Tables<'_>, emitter: u32, u: Vec2) -> Vec3 {
    let record = &tables.emitters[emitter as usize];
    if record.kind == emitter_kind::POINT {
        warp::square_to_uniform_sphere(u)
    } else if record.kind == emitter_kind::SPOT {
        warp::square_to_uniform_cone(u, cone(record.parameters[1]))
    } else if record.kind == emitter_kind::COLLIMATED {
        Vec3::Z
    } else {
        let (tan_x, tan_y) = (record.parameters[0], record.parameters[1]);
        Vec3::new((2.0 * u.x - 1.0) * tan_x, (2.0 * u.y - 1.0) * tan_y, 1.0)
    }
}

/// Density per solid angle of [`sample_delta_direction`] in a world direction.
fn delta_direction_pdf(tables: &Tables<'_>, emitter: u32, direction: Vec3) -> f32 {
    let record = &tables.emitters[emitter as usize];
    if record.kind == emitter_kind::POINT {
        return warp::UNIFORM_SPHERE_PDF;
    }
    if record.kind == emitter_kind::COLLIMATED {
        return 1.0;
    }
    let local = transform_vector(&record.to_local, direction);
    let cos_theta = local.z / local.length();
    if record.kind == emitter_kind::SPOT {
        let one_minus_cos = cone(record.parameters[1]);
        // Directions that rounding puts just outside carry no light.
        if 1.0 - cos_theta <= one_minus_cos {
            warp::uniform_cone_pdf(one_minus_cos)
        } else {
            0.0
        }
    } else {
        let area = 4.0 * record.parameters[0] * record.parameters[1];
        let inside = local.z > 0.0
            && float::abs(local.x) <= local.z * record.parameters[0] * (1.0 + 1e-6)
            && float::abs(local.y) <= local.z * record.parameters[1] * (1.0 + 1e-6);
        if inside && area > 0.0 {
            1.0 / (area * cos_theta * cos_theta * cos_theta)
        } else {
            0.0
        }
    }
}
