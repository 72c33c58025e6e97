//! What all entry points over a scene have in common: the bindings, and which sample of which pixel is theirs.

use crate::interface::{Dispatch, WorkItem};
use halflight_kernel::sampler::AnySampler;
use halflight_kernel::scene::Camera;
use spirv_std::glam::Vec3;

/// The sampler and the absolute film coordinates of work item `index`.
pub fn work(camera: &Camera, dispatch: &Dispatch, item: WorkItem) -> (AnySampler, [u32; 2]) {
    let absolute = [
        camera.crop_offset[0] + item.pixel % camera.crop_size[0],
        camera.crop_offset[1] + item.pixel / camera.crop_size[0],
    ];
    let stream = absolute[1]
        .wrapping_mul(camera.film_size[0])
        .wrapping_add(absolute[0]);
    let sampler = AnySampler::new(dispatch.sampler, dispatch.seed, stream, item.sample);
    (sampler, absolute)
}

/// A vector and a fourth number.
pub fn vector(v: Vec3, w: f32) -> [f32; 4] {
    [v.x, v.y, v.z, w]
}

/// Declares an entry point: its name and what it does with the view, the settings, the work (see [`work`]), the results
/// and the paths; `slot` is the invocation's place among the results, and `path` among the paths.
macro_rules! scene_entry {
    ($name:ident, |$view:ident, $settings:ident, $work:ident, $out:ident[$slot:ident], $paths:ident[$path:ident]| $body:block) => {
        #[allow(missing_docs, unused)]
        #[spirv_std::spirv(compute(threads(64)))]
        pub fn $name(
            #[spirv(global_invocation_id)] id: spirv_std::glam::UVec3,
            #[spirv(push_constant)] dispatch: &crate::interface::Dispatch,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] positions: &[[f32; 3]],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] normals: &[[f32; 3]],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] uvs: &[[f32; 2]],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 3)]
            triangles: &[halflight_kernel::scene::Triangle],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 4)]
            quadrics: &[halflight_kernel::scene::Quadric],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 5)]
            shapes: &[halflight_kernel::scene::Shape],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 6)]
            instances: &[halflight_kernel::scene::Instance],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 7)]
            materials: &[halflight_kernel::scene::Material],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 8)]
            lobes: &[halflight_kernel::scene::LobeRecord],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 9)]
            factors: &[halflight_kernel::scene::WeightFactor],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 10)]
            frame_maps: &[halflight_kernel::scene::FrameMap],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 11)]
            textures: &[halflight_kernel::scene::Texture],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 12)] texels: &[u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 13)] data: &[f32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 14)]
            emitters: &[halflight_kernel::scene::Emitter],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 15)]
            nodes: &[halflight_kernel::scene::BvhNode],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 16)] primitive_indices: &[u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 17)]
            constants: &[crate::interface::SceneConstants],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 18)]
            items: &[crate::interface::WorkItem],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 19)] $out: &mut [[f32; 4]],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 20)]
            $paths: &mut [halflight_kernel::transport::staged::PathRecord],
            #[spirv(spec_constant(id = 0, default = 4294967295))] features: u32,
        ) {
            // Before anything depends on the invocation: software devices load such values once for many.
            let $settings = constants[0].settings;
            let camera = constants[0].camera;
            let info = constants[0].info;
            if id.x >= dispatch.count {
                return;
            }
            let item = items[id.x as usize];
            let $slot = item.slot as usize;
            let $path = (item.slot + dispatch.first) as usize;
            let tables = halflight_kernel::scene::Tables {
                positions,
                normals,
                uvs,
                triangles,
                quadrics,
                shapes,
                instances,
                materials,
                lobes,
                factors,
                frame_maps,
                textures,
                texels,
                data,
                emitters,
                camera,
                info,
                #[cfg(target_arch = "spirv")]
                features,
            };
            let traverse = halflight_kernel::scene::Bvh2Traverse {
                tables,
                nodes,
                primitive_indices,
            };
            let $view = halflight_kernel::scene::SceneView {
                tables,
                traverse: &traverse,
            };
            let $work = || crate::scene_entry::work(&camera, dispatch, item);
            $body
        }
    };
}
pub(crate) use scene_entry;
