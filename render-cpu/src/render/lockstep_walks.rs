//! Walks of one thread whose rays are traced in lockstep, bounce by bounce.

use halflight_kernel::path::Walk;
use halflight_kernel::path::rules::step;
use halflight_kernel::scene::traverse::Traverse;
use halflight_kernel::scene::{Hit, HitBatch, RayBatch, SceneView};

/// Rays that are traced together.
pub(super) const RAYS: usize = 1024;

/// Walks, and storage for their rays.
pub(super) struct LockstepWalks {
    rays: Box<RayBatch<RAYS>>,
    hits: Box<HitBatch<RAYS>>,
    walks: Vec<Walk>,
    active: Vec<u32>,
}

impl LockstepWalks {
    /// No walk.
    pub fn new() -> LockstepWalks {
        LockstepWalks {
            rays: bytemuck::zeroed_box(),
            hits: bytemuck::zeroed_box(),
            walks: Vec::with_capacity(RAYS),
            active: Vec::with_capacity(RAYS),
        }
    }

    /// Forgets all walks.
    pub fn clear(&mut self) {
        self.walks.clear();
        self.active.clear();
    }

    /// Adds a walk, at most [`RAYS`]; one that is not active has ended already.
    pub fn push(&mut self, walk: Walk, is_active: bool) {
        if is_active {
            self.active.push(self.walks.len() as u32);
        }
        self.walks.push(walk);
    }

    /// Traces the next rays of all walks that have not ended and hands each with its index and what it met to `bounce`,
    /// which returns what is next, one of [`step`].
    pub fn bounce<T: Traverse>(
        &mut self,
        view: &SceneView<'_, T>,
        mut bounce: impl FnMut(usize, &mut Walk, &Hit) -> u32,
    ) {
        for (k, &i) in self.active.iter().enumerate() {
            self.rays.set(k, &self.walks[i as usize].subpath.ray);
        }
        view.traverse
            .closest_hits(&self.rays, self.active.len(), &mut self.hits);
        let mut kept = 0;
        for k in 0..self.active.len() {
            let i = self.active[k] as usize;
            if bounce(i, &mut self.walks[i], &self.hits.get(k)) == step::TRACE {
                self.active[kept] = i as u32;
                kept += 1;
            }
        }
        self.active.truncate(kept);
    }

    /// Whether all have ended.
    pub fn is_done(&self) -> bool {
        self.active.is_empty()
    }
}
