//! A scene's tables as storage buffers, in the layout of the kernel's records.

use crate::interface::SceneConstants;
use crate::vulkan::{Buffer, Device, VulkanError};
use halflight::accel::Accel;
use halflight::scene::build::Scene;
use std::sync::Arc;

/// The buffers of bindings 0 to 17, in order.
pub struct SceneBuffers {
    buffers: Vec<Buffer>,
    bytes: u64,
}

impl SceneBuffers {
    /// Uploads a scene and the trees of the kernel's own walk.
    ///
    /// # Errors
    /// If a table is larger than a shader may see, or does not fit into memory.
    pub fn upload(
        device: &Arc<Device>,
        scene: &Scene,
        accel: &Accel,
    ) -> Result<SceneBuffers, VulkanError> {
        let t = &scene.tables;
        let trees = accel.shader_nodes(t.view());
        let mut instances = t.instances.clone();
        for instance in &mut instances {
            if let Some(&root) = trees.roots.get(instance.group as usize) {
                instance.root = root;
            }
        }
        let constants = SceneConstants {
            camera: t.camera,
            info: t.info,
            settings: scene.settings,
        };
        // In the order of the bindings.
        let buffers = vec![
            device.upload("vertex positions", &t.positions)?,
            device.upload("vertex normals", &t.normals)?,
            device.upload("texture coordinates", &t.uvs)?,
            device.upload("triangles", &t.triangles)?,
            device.upload("quadrics", &t.quadrics)?,
            device.upload("shapes", &t.shapes)?,
            device.upload("instances", &instances)?,
            device.upload("materials", &t.materials)?,
            device.upload("lobes", &t.lobes)?,
            device.upload("mixing factors", &t.factors)?,
            device.upload("frame maps", &t.frame_maps)?,
            device.upload("textures", &t.textures)?,
            device.upload("texels", &t.texels)?,
            device.upload("sampling tables", &t.data)?,
            device.upload("emitters", &t.emitters)?,
            device.upload("tree nodes", &trees.nodes)?,
            device.upload("tree leaves", &trees.primitive_indices)?,
            device.upload("scene constants", &[constants])?,
        ];
        let bytes = buffers.iter().map(Buffer::size).sum();
        Ok(SceneBuffers { buffers, bytes })
    }

    /// The buffers, in the order of their bindings.
    pub fn buffers(&self) -> &[Buffer] {
        &self.buffers
    }

    /// Bytes of all buffers.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }
}
