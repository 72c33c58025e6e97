//! The door to the trees: a ray, or many at once, and the hits.
//!
//! What the processor has is looked up once, when a traverser is made: single rays take the walk that is compiled for its
//! instruction set, and many rays at once go in a stream where there is AVX-512, else one after the other.

#[cfg(target_arch = "x86_64")]
use super::single::avx2::Avx2;
#[cfg(not(target_arch = "x86_64"))]
use super::single::instruction_set::Portable;
#[cfg(target_arch = "x86_64")]
use super::single::instruction_set::Sse2;
use super::single::walk::World;
#[cfg(target_arch = "x86_64")]
use super::stream;
use super::trees::Accel;
#[cfg(target_arch = "x86_64")]
use crate::processor::simd_level;
use halflight_kernel::math::Ray;

#[cfg(target_arch = "x86_64")]
use halflight_kernel::scene::traverse::{are_occluded_in_turn, closest_hits_in_turn};
use halflight_kernel::scene::{Hit, HitBatch, RayBatch, Tables, Traverse};
#[cfg(target_arch = "x86_64")]
use halflight_kernel::simd::SimdLevel;

/// The ray tracer over an [`Accel`].
#[derive(Clone, Copy)]
pub struct CpuTraverse<'a> {
    world: World<'a>,
    #[cfg(target_arch = "x86_64")]
    has_avx2: bool,
    #[cfg(target_arch = "x86_64")]
    simd: SimdLevel,
}

impl Accel {
    /// The traverser over these trees; `tables` are those of [`Accel::build`].
    pub fn traverse<'a>(&'a self, tables: Tables<'a>) -> CpuTraverse<'a> {
        CpuTraverse {
            world: World {
                groups: &self.groups,
                tables,
            },
            #[cfg(target_arch = "x86_64")]
            has_avx2: is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma"),
            #[cfg(target_arch = "x86_64")]
            simd: simd_level(),
        }
    }
}

#[cfg(target_arch = "x86_64")]
impl CpuTraverse<'_> {
    #[target_feature(enable = "avx2,fma")]
    fn closest_avx2(&self, ray: &Ray) -> Hit {
        self.world.trace::<Avx2, false>(ray)
    }

    #[target_feature(enable = "avx2,fma")]
    fn any_avx2(&self, ray: &Ray) -> Hit {
        self.world.trace::<Avx2, true>(ray)
    }
}

#[cfg(target_arch = "x86_64")]
impl Traverse for CpuTraverse<'_> {
    fn closest_hit(&self, ray: &Ray) -> Hit {
        if self.has_avx2 {
            // SAFETY: the processor has the features.
            unsafe { self.closest_avx2(ray) }
        } else {
            self.world.trace::<Sse2, false>(ray)
        }
    }

    fn is_occluded(&self, ray: &Ray) -> bool {
        if self.has_avx2 {
            // SAFETY: the processor has the features.
            unsafe { self.any_avx2(ray) }.is_hit()
        } else {
            self.world.trace::<Sse2, true>(ray).is_hit()
        }
    }

    fn closest_hits<const N: usize>(
        &self,
        rays: &RayBatch<N>,
        count: usize,
        hits: &mut HitBatch<N>,
    ) {
        if self.simd.has_avx512() {
            // SAFETY: the processor has the features (`simd_level`).
            return unsafe { stream::trace::<false, N>(&self.world, rays, count, hits) };
        }
        closest_hits_in_turn(self, rays, count, hits);
    }

    fn are_occluded<const N: usize>(
        &self,
        rays: &RayBatch<N>,
        count: usize,
        hits: &mut HitBatch<N>,
    ) {
        if self.simd.has_avx512() {
            // SAFETY: the processor has the features (`simd_level`).
            return unsafe { stream::trace::<true, N>(&self.world, rays, count, hits) };
        }
        are_occluded_in_turn(self, rays, count, hits);
    }
}

#[cfg(not(target_arch = "x86_64"))]
impl Traverse for CpuTraverse<'_> {
    fn closest_hit(&self, ray: &Ray) -> Hit {
        self.world.trace::<Portable, false>(ray)
    }

    fn is_occluded(&self, ray: &Ray) -> bool {
        self.world.trace::<Portable, true>(ray).is_hit()
    }
}
