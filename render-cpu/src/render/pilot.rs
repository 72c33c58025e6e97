//! Pilot passes, and that of vertex merging: how many photons there are where, for its weights
//! ([`halflight_kernel::path::photon_density`]).
//!
//! Its photons are those of a stream of numbers of its own, so the weights of a pass do not depend on the photons of that
//! pass, and every pass of a run has the same. Cells are twice as wide as the first radius.

use super::first_radii::FirstRadii;
use super::pass_context::PassContext;
use super::photon_cache::SortedPhotons;
use super::photon_pass::{PhotonTask, WorkspacePool};
use halflight_kernel::path::PhotonDensity;
use halflight_kernel::path::photon_density::entry_of;
use halflight_kernel::sampler::LaneSampler;
use halflight_kernel::scene::traverse::Traverse;
use halflight_kernel::transport::bidirectional::Bidirectional;
use halflight_kernel::transport::integrator_kind;
use halflight_kernel::transport::photon::merging::merging_tracer;
use halflight_kernel::transport::photon::progressive::{first_radius, light_walks};
use std::sync::OnceLock;

/// Most light walks of a pilot pass.
const MOST_WALKS: u32 = 1 << 18;

/// Turns the seed of a run into that of its pilot pass.
const PILOT_STREAM: u32 = 0x7a1d_90c5;

/// Width of a cell in first radii.
const RADII: f32 = 2.0;

/// Entries of the grid for a number of photons.
fn entries(photons: usize) -> usize {
    (2 * photons).next_power_of_two().clamp(1 << 10, 1 << 20)
}

/// What a run knows of its photons before its passes: each pilot pass runs when it is first asked for.
#[derive(Default)]
pub struct Pilots {
    /// How many there are where, for the weights of vertex merging.
    pub density: OnceLock<PilotDensity>,
    /// The first radii of pixels.
    pub radii: OnceLock<FirstRadii>,
}

/// The counts.
#[derive(Clone, Debug)]
pub struct PilotDensity {
    counts: Vec<u32>,
    cells_per_length: f32,
    per_count: f32,
}

impl PilotDensity {
    /// What the weights of a run may know of its photons: nothing without merging, else what its pilot pass has counted, which the
    /// first call traces. No density if that is to stop.
    pub fn of_run<'a, T: Traverse + Sync, S: LaneSampler + Send>(
        pilot: &'a OnceLock<PilotDensity>,
        pass: &PassContext<'a, T, S>,
    ) -> Option<PhotonDensity<'a>> {
        let (view, settings) = (pass.view, pass.settings);
        if settings.kind != integrator_kind::VERTEX_MERGING {
            return Some(PhotonDensity::unknown(&view.tables));
        }
        if pilot.get().is_none() {
            let counted = PilotDensity::trace(pass)?;
            // There is one writer: a backend takes one pass at a time.
            let _ = pilot.set(counted);
        }
        pilot.get().map(PilotDensity::view)
    }

    /// Counts the photons of a pilot pass; nothing if it is to stop.
    fn trace<T: Traverse + Sync, S: LaneSampler + Send>(
        pass: &PassContext<'_, T, S>,
    ) -> Option<PilotDensity> {
        let (view, settings) = (pass.view, pass.settings);
        let algorithm = Bidirectional::new(&view.tables, settings);
        let emitted = light_walks(&view.tables, settings).min(MOST_WALKS);
        let pilot = PhotonTask {
            view,
            tracer: merging_tracer(&algorithm.connector),
            expressions: None,
            edits: None,
            adaptive: None,
            emitted,
            seed: pass.options.seed ^ PILOT_STREAM,
            index: 0,
        };
        let idle = WorkspacePool::new();
        let photons = pilot.trace(&idle, pass.stop, &pass.new_sampler)?;
        let width = RADII * first_radius(&view.tables, settings);
        Some(PilotDensity::of(&photons, emitted, width))
    }

    /// Of the photons that `emitted` light walks left, by cells of a width.
    fn of(photons: &SortedPhotons, emitted: u32, width: f32) -> PilotDensity {
        let positions = photons.view().positions;
        let entries = entries(positions.len());
        let cells_per_length = 1.0 / width;
        let mut counts = vec![0; entries];
        for &position in positions {
            let cell = glam::Vec3::from_array(position) * cells_per_length;
            counts[entry_of(cell, entries as u32) as usize] += 1;
        }
        PilotDensity {
            counts,
            cells_per_length,
            per_count: cells_per_length * cells_per_length / emitted.max(1) as f32,
        }
    }

    /// What the kernel reads.
    fn view(&self) -> PhotonDensity<'_> {
        PhotonDensity {
            counts: &self.counts,
            entries: self.counts.len() as u32,
            cells_per_length: self.cells_per_length,
            per_count: self.per_count,
        }
    }
}
