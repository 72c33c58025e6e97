//! The order of a bounce, once for all drivers.
//!
//! A driver runs one path or many, and its state lives in a local variable, in the lanes of a wavefront or in buffers of a
//! device; what each stage computes is said in [`super::path`] and [`super::direct`]. The stages:
//!
//! | stage | what it does |
//! |---|---|
//! | trace | finds what the rays meet |
//! | arrive | gathers emission, applies the rules of depth, hidden emitters and strict normals, looks up the BSDF |
//! | sample emitter | chooses an emitter point for next event estimation |
//! | evaluate emitter | makes a shadow ray of it: the light that the BSDF reflects, weighted against BSDF samples |
//! | sample BSDF | draws a direction of one lobe |
//! | mix lobes | makes it a sample of the whole BSDF |
//! | scatter | leaves the surface along it; Russian roulette |
//! | trace shadow rays | adds the light of the emitter points that are visible |
//!
//! Random numbers are drawn in this order: three for the emitter point, where the BSDF has a density, three for the BSDF, one
//! for the roulette. Invariant (tests): all drivers give the same numbers to the bit.

use super::settings::DirectSettings;

/// What happens at a surface, for one path or many.
pub trait Shading {
    /// Gathers emission, applies the rules, looks up the BSDF.
    fn arrive(&mut self);
    /// Chooses an emitter point.
    fn sample_emitter(&mut self);
    /// Makes a shadow ray of it.
    fn evaluate_emitter(&mut self);
    /// Draws a direction of one lobe.
    fn sample_bsdf(&mut self);
    /// Makes it a sample of the whole BSDF.
    fn mix_lobes(&mut self);
    /// Leaves the surface along it.
    fn scatter(&mut self);
}

/// The rays of a bounce, of one path or many.
pub trait Rays {
    /// Finds what the rays meet.
    fn trace(&mut self);
    /// Adds the light of the emitter points that are visible.
    fn trace_shadow_rays(&mut self);
}

/// Direct illumination, whose BSDF samples are branches: paths of their own, followed to their ends.
pub trait Branches: Rays + Shading {
    /// Starts a branch along the BSDF sample.
    fn branch(&mut self);
    /// Traces the branch's ray and gathers the light at its end; whether it goes on behind a mask.
    fn follow_branch(&mut self) -> bool;
    /// Goes on behind the masks of the surface.
    fn continue_through_masks(&mut self);
}

/// One bounce of path tracing; `shade_all` runs [`shade`] for all paths.
#[inline(always)]
pub fn bounce<D: Rays>(driver: &mut D, shade_all: impl FnOnce(&mut D)) {
    driver.trace();
    shade_all(driver);
    driver.trace_shadow_rays();
}

/// The part of a bounce between the ray that arrives and the rays that leave.
#[inline(always)]
pub fn shade(driver: &mut impl Shading) {
    driver.arrive();
    driver.sample_emitter();
    driver.evaluate_emitter();
    driver.sample_bsdf();
    driver.mix_lobes();
    driver.scatter();
}

/// Direct illumination at the next surface, with the numbers of samples of the settings.
#[inline(always)]
pub fn illuminate(driver: &mut impl Branches, samples: &DirectSettings) {
    driver.trace();
    driver.arrive();
    for _ in 0..samples.emitter_samples {
        driver.sample_emitter();
        driver.evaluate_emitter();
        driver.trace_shadow_rays();
    }
    for _ in 0..samples.bsdf_samples {
        driver.sample_bsdf();
        driver.mix_lobes();
        driver.branch();
        while driver.follow_branch() {}
    }
    driver.continue_through_masks();
}
