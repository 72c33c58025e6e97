//! The edits of a scene's light transport ([`halflight_kernel::path::retarget`]).

use crate::expression::selections::CompiledSelections;
use flate2::Crc;
use halflight_kernel::path::retarget::Edit;
use halflight_kernel::path::retarget_states::Edits;

/// Edits, with their selections compiled for the scene.
#[derive(Clone, Debug, Default)]
pub struct SceneEdits {
    list: Vec<Edit>,
    texts: Vec<String>,
    compiled: Option<CompiledSelections>,
}

impl SceneEdits {
    /// Of records and the texts of their selections, compiled in the same order.
    pub fn new(list: Vec<Edit>, texts: Vec<String>, compiled: CompiledSelections) -> SceneEdits {
        SceneEdits {
            list,
            texts,
            compiled: Some(compiled),
        }
    }

    /// For the kernel; none if there are no edits.
    pub fn view(&self) -> Option<Edits<'_>> {
        Some(Edits {
            list: &self.list,
            words: self.compiled.as_ref()?.words.view(),
        })
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// What decides the numbers of the image: the selections, and what else they hold as digests.
    pub fn settings(&self) -> impl Iterator<Item = (String, String)> + '_ {
        let all = self.list.iter().zip(&self.texts).enumerate();
        all.flat_map(|(i, (edit, text))| {
            let mut digest = Crc::new();
            digest.update(bytemuck::bytes_of(edit));
            let number = i + 1;
            [
                (format!("edit {number}"), text.clone()),
                (
                    format!("content of edit {number} (digest)"),
                    format!("{:08x}", digest.sum()),
                ),
            ]
        })
    }
}
