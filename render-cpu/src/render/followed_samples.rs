//! Samples that are taken one by one, because each of their walks is followed: by path expressions, by edits, through interfaces, or
//! by a regularisation that depends on the full path.

use super::bidirectional_job::{TileSample, Vertices, regularized};
use super::division::Division;
use super::splat::Splat;
use glam::Vec3;
use halflight_kernel::math::Rgb;
use halflight_kernel::path::retarget_states::Edits;
use halflight_kernel::path::{Contribution, PathStates, Shares};
use halflight_kernel::sampler::LaneSampler;
use halflight_kernel::scene::SceneView;
use halflight_kernel::scene::camera::CameraSample;
use halflight_kernel::scene::traverse::Traverse;
use halflight_kernel::transport::bidirectional::adaptive::{
    Adaptive, AdaptivePhotons, AdaptiveWorkspace,
};
use halflight_kernel::transport::bidirectional::manifold::sample_through_interfaces;
use halflight_kernel::transport::bidirectional::{
    Bidirectional, DividedPhotons, DividedSample, PathObserver, StateStore, Unshadowed, counted,
    sample_observed,
};
use halflight_kernel::transport::photon::adaptive::AdaptiveRadii;
use halflight_kernel::transport::photon::divided::sample_among_photons;
use halflight_kernel::transport::photon::progressive::Progressive;
use halflight_kernel::transport::photon::statistics::PhotonPass;
use halflight_kernel::transport::retargeted::bidirectional::EditedSample;
use halflight_kernel::transport::retargeted::photons::EditedPhotons;
use halflight_kernel::transport::{IntegratorSettings, camera_ray, integrator_kind, retargeted};
/// What is made of the paths of an image, each followed by itself.
#[derive(Clone, Copy)]
pub(super) struct Followed<'a> {
    /// What divides it.
    pub division: Option<&'a Division<'a>>,
    /// The edits of its light transport.
    pub edits: Option<&'a Edits<'a>>,
    /// Whether its regularisation depends on full paths.
    pub is_adaptive: bool,
}

/// What some rows gave: for the image and for each part the radiance of their pixels, and splats.
pub(super) struct RowSamples {
    pub radiance: Vec<Vec<Rgb>>,
    pub splats: Vec<Vec<Splat>>,
    /// Of adaptive photon mapping: what is new in the statistics of each pixel.
    pub statistics: Vec<PhotonPass>,
}

/// Radii of the pixels of some rows.
pub(super) enum OwnRadii {
    /// None of their own.
    Shared,
    /// By schedule.
    Scheduled(Vec<f32>),
    /// From statistics.
    Adaptive(Vec<AdaptiveRadii>),
}

/// The states along a light walk.
#[derive(Default)]
struct States(Vec<PathStates>);

impl StateStore for States {
    fn clear(&mut self) {
        self.0.clear();
    }

    fn push(&mut self, states: &PathStates) {
        self.0.push(*states);
    }

    fn get(&self, index: usize) -> PathStates {
        self.0.get(index).copied().unwrap_or(PathStates::DEAD)
    }
}

/// The samples of a layer whose paths are followed one by one.
pub(super) struct FollowedSamples<'a, T: Traverse> {
    pub view: &'a SceneView<'a, T>,
    pub settings: &'a IntegratorSettings,
    pub algorithm: &'a Bidirectional<'a>,
    pub followed: Followed<'a>,
    /// With the states of path expressions.
    pub photons: Option<DividedPhotons<'a>>,
    /// With the states of edits.
    pub edited: Option<EditedPhotons<'a>>,
}

impl<T: Traverse> FollowedSamples<'_, T> {
    /// Takes the samples of whole rows, with radii of their own if there are any.
    pub fn sample_rows<S: LaneSampler>(
        &self,
        radii: &OwnRadii,
        samples: &mut [TileSample<S>],
    ) -> RowSamples {
        let (view, settings, followed) = (self.view, self.settings, self.followed);
        let (first, count) = followed.division.map_or((0, 0), |d| (d.first, d.count));
        let images = 1 + count;
        let mut found = RowSamples {
            radiance: vec![vec![Vec3::ZERO; samples.len()]; images],
            splats: vec![Vec::new(); images],
            statistics: Vec::new(),
        };
        if matches!(radii, OwnRadii::Adaptive(_)) {
            found.statistics = vec![PhotonPass::default(); samples.len()];
        }
        let has_photons_alone = matches!(
            settings.kind,
            integrator_kind::PROGRESSIVE_PHOTONS | integrator_kind::ADAPTIVE_PHOTONS
        );
        let mut vertices = Vertices::default();
        let mut states = States::default();
        let expressions = followed.division.map(|division| division.expressions);
        for (i, sample) in samples.iter_mut().enumerate() {
            let seen = camera_ray(&view.tables, &mut sample.camera, sample.pixel);
            vertices.clear();
            let mut add = |contribution: Contribution, shares: &Shares| {
                for image in 0..images {
                    let value = match (image, &expressions) {
                        (_, None) => contribution.value,
                        (0, Some(expressions)) => counted(expressions, shares, contribution.value),
                        (part, _) => contribution.value * shares.of(first + part - 1),
                    };
                    if !(value.max_element() > 0.0) {
                        continue;
                    }
                    if contribution.is_splat() {
                        found.splats[image].push(Splat {
                            film: contribution.film,
                            value,
                        });
                    } else {
                        found.radiance[image][i] += value * seen.weight;
                    }
                }
            };
            if let (true, Some(photons), Some(expressions)) =
                (has_photons_alone, &self.photons, &expressions)
            {
                let algorithm = Progressive::new(&view.tables, settings);
                let mut photons = *photons;
                let mut adaptive = None;
                match radii {
                    OwnRadii::Shared => {}
                    OwnRadii::Scheduled(radii) => photons.photons.radius = radii[i],
                    OwnRadii::Adaptive(radii) => {
                        adaptive = Some((radii[i], &mut found.statistics[i]));
                    }
                }
                let connector = &algorithm.connector;
                let mut divided = DividedSample::new(
                    view,
                    connector,
                    *expressions,
                    Some(photons),
                    &mut states,
                    add,
                );
                sample_among_photons(
                    view,
                    &algorithm,
                    &photons.photons,
                    adaptive,
                    &mut sample.camera,
                    &seen,
                    &mut divided,
                );
                continue;
            }
            if let (true, Some(photons), Some(edits)) =
                (has_photons_alone, &self.edited, followed.edits)
            {
                let mut photons = *photons;
                if let OwnRadii::Scheduled(radii) = radii {
                    photons.photons.radius = radii[i];
                }
                let add = |contribution: Contribution| add(contribution, &Shares::NONE);
                retargeted::photons::sample_among_photons(
                    view,
                    &Progressive::new(&view.tables, settings),
                    edits,
                    &photons,
                    &mut sample.camera,
                    &seen,
                    &mut Unshadowed::new(view, settings.rules, add),
                );
                continue;
            }
            let connector = &self.algorithm.connector;
            match expressions {
                Some(expressions) => {
                    let mut divided = DividedSample::new(
                        view,
                        connector,
                        expressions,
                        self.photons,
                        &mut states,
                        add,
                    );
                    self.follow(sample, &seen, &mut vertices, &mut divided);
                }
                None if settings.kind == integrator_kind::MANIFOLD_BIDIRECTIONAL => {
                    let (light, camera) = (&mut sample.light, &mut sample.camera);
                    let add = |contribution: Contribution| add(contribution, &Shares::NONE);
                    sample_through_interfaces(
                        view,
                        self.algorithm,
                        light,
                        camera,
                        &seen,
                        &mut vertices,
                        add,
                    );
                }
                None => {
                    let add = |contribution: Contribution| add(contribution, &Shares::NONE);
                    let mut unshadowed = Unshadowed::new(view, settings.rules, add);
                    self.follow(sample, &seen, &mut vertices, &mut unshadowed);
                }
            }
        }
        found
    }

    /// Takes one sample, with edits if there are any.
    fn follow<S: LaneSampler>(
        &self,
        sample: &mut TileSample<S>,
        seen: &CameraSample,
        vertices: &mut Vertices,
        observer: &mut impl PathObserver,
    ) {
        let (light, camera) = (&mut sample.light, &mut sample.camera);
        let (view, algorithm, photons) = (self.view, self.algorithm, self.edited.as_ref());
        match self.followed.edits {
            Some(edits) => EditedSample::new(view, algorithm, edits, photons)
                .sample_observed(light, camera, seen, vertices, observer),
            None => sample_observed(view, algorithm, light, camera, seen, vertices, observer),
        }
    }
}

/// Takes the samples of whole rows, regularised as each path needs it; what of them is regularised is a second image where that is
/// wanted.
pub(super) fn sample_adaptive<T: Traverse, S: LaneSampler>(
    view: &SceneView<'_, T>,
    adaptive: &Adaptive<'_>,
    photons: Option<&AdaptivePhotons<'_>>,
    keeps_regularized: bool,
    samples: &mut [TileSample<S>],
) -> RowSamples {
    let images = 1 + usize::from(keeps_regularized);
    let mut found = RowSamples {
        radiance: vec![vec![Vec3::ZERO; samples.len()]; images],
        splats: vec![Vec::new(); images],
        statistics: Vec::new(),
    };
    let mut room = Box::new(AdaptiveWorkspace::new());
    for (i, sample) in samples.iter_mut().enumerate() {
        let seen = camera_ray(&view.tables, &mut sample.camera, sample.pixel);
        let numbers = (&mut sample.light, &mut sample.camera);
        adaptive.sample(view, photons, numbers, &seen, &mut room, |contribution| {
            for image in 0..images {
                let value = if image == 0 {
                    contribution.value
                } else if contribution.blur > 0.0 {
                    regularized(contribution.value, contribution.blur)
                } else {
                    continue;
                };
                if !contribution.is_splat() {
                    found.radiance[image][i] += value * seen.weight;
                } else if value.x.max(value.y).max(value.z) > 0.0 {
                    found.splats[image].push(Splat {
                        film: contribution.film,
                        value,
                    });
                }
            }
        });
    }
    found
}
