//! What the wrappers around a BSDF pass down while it is flattened, and the lobes that come out of it.

use crate::scene::build::texture::MeshAttributes;
use crate::scene::error::SceneError;
use crate::scene::xml::{Object, ObjectKind};
use halflight_kernel::scene::{CoatRecord, LobeRecord, NONE, WeightFactor, lobe_flag, lobe_kind};
use std::sync::Arc;

/// The settings of all wrappers around a BSDF.
#[derive(Clone)]
pub(super) struct Context<'a> {
    pub factors: Vec<WeightFactor>,
    pub sides: u32,
    pub frame: u32,
    pub coats: Coats,
    pub mesh: Option<&'a MeshAttributes>,
    pub depth: usize,
}

/// A lobe whose factors are not yet in the table of factors.
pub(super) struct PendingLobe {
    pub record: LobeRecord,
    pub factors: Vec<WeightFactor>,
}

impl PendingLobe {
    /// Whether light passes through the surface.
    pub fn transmits(&self) -> bool {
        matches!(
            self.record.kind,
            lobe_kind::DIELECTRIC
                | lobe_kind::THIN_DIELECTRIC
                | lobe_kind::ROUGH_DIELECTRIC
                | lobe_kind::DIFFUSE_TRANSMISSION
                | lobe_kind::THIN_TRANSMISSION
                | lobe_kind::HANRAHAN_KRUEGER
                | lobe_kind::NULL
        )
    }
}

/// The coats above a lobe, outermost first, and the perturbed frame that they follow.
#[derive(Clone, Default)]
pub(super) struct Coats {
    pub records: Vec<CoatRecord>,
    pub frame: u32,
}

impl Coats {
    /// Writes the coats into a lobe that has its frame.
    pub(super) fn apply(&self, object: &Object, record: &mut LobeRecord) -> Result<(), SceneError> {
        if self.records.is_empty() {
            return Ok(());
        }
        record.coat_count = self.records.len() as u32;
        record.coats[..self.records.len()].copy_from_slice(&self.records);
        if self.frame != record.frame {
            if self.frame != NONE {
                return Err(object.error(
                    "a coating inside one normal or bump map and around another is not supported",
                ));
            }
            record.flags |= lobe_flag::COATS_OUTSIDE_FRAME;
        }
        Ok(())
    }
}

/// The nested BSDFs of a wrapper, between `least` and `most` of them.
pub(super) fn nested_bsdfs(
    object: &Object,
    least: usize,
    most: usize,
) -> Result<Vec<Arc<Object>>, SceneError> {
    let nested: Vec<_> = object
        .children_of(ObjectKind::Bsdf)
        .map(|child| child.object.clone())
        .collect();
    if nested.len() < least || nested.len() > most {
        let wanted = match most {
            _ if least == most => format!("{least}"),
            usize::MAX => format!("at least {least}"),
            _ => format!("{least} or {most}"),
        };
        return Err(object.error(format!(
            "needs {wanted} nested BSDF(s), found {}",
            nested.len()
        )));
    }
    Ok(nested)
}
