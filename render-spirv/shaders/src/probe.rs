//! Entry points of the function probes: one input per invocation, one call, one output.

use crate::interface::{Dispatch, SceneConstants, WorkItem};
use crate::probes::chains::{ChainInput, ChainOutput, SolveInput, SolveOutput};
use crate::probes::lobes::{LobeInput, LobeOutput};
use crate::probes::microfacets::{MicrofacetInput, MicrofacetOutput};
use crate::probes::numbers::{NumberInput, NumberOutput};
use crate::probes::vectors::{VectorInput, VectorOutput};
use crate::probes::{ProbeDispatch, chains, layout, lobes, microfacets, numbers, vectors};
use halflight_kernel::scene as s;
use spirv_std::{glam::UVec3, spirv};

/// Declares a probe: its name, its records, and the function of the dispatch, an input and the table `data`.
macro_rules! probe {
    ($name:ident, $input:ty, $output:ty, |$dispatch:ident, $record:ident, $data:ident| $body:expr) => {
        #[spirv(compute(threads(64)))]
        pub fn $name(
            #[spirv(global_invocation_id)] id: UVec3,
            #[spirv(push_constant)] $dispatch: &ProbeDispatch,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] inputs: &[$input],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] $data: &[f32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] out: &mut [$output],
        ) {
            if id.x < $dispatch.count {
                let $record = inputs[id.x as usize];
                out[id.x as usize] = $body;
            }
        }
    };
}

probe!(number, NumberInput, NumberOutput, |dispatch, input, _data| {
    numbers::evaluate(dispatch.function, &input)
});
probe!(vector, VectorInput, VectorOutput, |dispatch, input, _data| {
    vectors::evaluate(dispatch.function, &input)
});
probe!(microfacet, MicrofacetInput, MicrofacetOutput, |dispatch, input, _data| {
    microfacets::evaluate(dispatch.function, &input)
});
/// Declares a probe of lobes. What kinds there are is a constant of the pipeline, so that drivers compile few models and not
/// all.
macro_rules! lobe_probe {
    ($name:ident, $function:path) => {
        #[spirv(compute(threads(64)))]
        pub fn $name(
            #[spirv(global_invocation_id)] id: UVec3,
            #[spirv(push_constant)] dispatch: &ProbeDispatch,
            #[spirv(spec_constant(id = 0, default = 0xffff_ffff))] features: u32,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] inputs: &[LobeInput],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] data: &[f32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] out: &mut [LobeOutput],
        ) {
            if id.x < dispatch.count {
                let input = inputs[id.x as usize];
                out[id.x as usize] = $function(&input, data, features);
            }
        }
    };
}

lobe_probe!(lobe_value, lobes::value);
lobe_probe!(lobe_sample, lobes::sample);
lobe_probe!(lobe_bounds, lobes::bounds);

probe!(solve, SolveInput, SolveOutput, |dispatch, input, _data| chains::solve(&input));
probe!(constraint, ChainInput, ChainOutput, |dispatch, input, _data| {
    chains::constraint(&input)
});
probe!(measure, ChainInput, ChainOutput, |dispatch, input, _data| chains::measure(&input));

/// Where the fields of the scene's tables lie.
#[spirv(compute(threads(1)))]
pub fn layout_tables(
    #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] triangles: &[s::Triangle],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] quadrics: &[s::Quadric],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] shapes: &[s::Shape],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] instances: &[s::Instance],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] materials: &[s::Material],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] lobes: &[s::LobeRecord],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] factors: &[s::WeightFactor],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] frame_maps: &[s::FrameMap],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 8)] textures: &[s::Texture],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 9)] emitters: &[s::Emitter],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 10)] nodes: &[s::BvhNode],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 11)] out: &mut [u32],
) {
    let at = layout::triangle(triangles, out, 0);
    let at = layout::quadric(quadrics, out, at);
    let at = layout::shape(shapes, out, at);
    let at = layout::instance(instances, out, at);
    let at = layout::material(materials, out, at);
    let at = layout::lobe(lobes, out, at);
    let at = layout::factor(factors, out, at);
    let at = layout::frame_map(frame_maps, out, at);
    let at = layout::texture(textures, out, at);
    let at = layout::emitter(emitters, out, at);
    layout::node(nodes, out, at);
}

/// Where the fields of everything else lie.
#[spirv(compute(threads(1)))]
pub fn layout_parts(
    #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] cameras: &[s::Camera],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] infos: &[s::SceneInfo],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)]
    settings: &[halflight_kernel::transport::IntegratorSettings],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] constants: &[SceneConstants],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] items: &[WorkItem],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] dispatches: &[Dispatch],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] rgbs: &[s::RgbParameter],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] scalars: &[s::ScalarParameter],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 8)] coats: &[s::CoatRecord],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 9)] out: &mut [u32],
) {
    let at = layout::camera(cameras, out, 0);
    let at = layout::info(infos, out, at);
    let at = layout::settings(settings, out, at);
    let at = layout::constants(constants, out, at);
    let at = layout::item(items, out, at);
    let at = layout::dispatch(dispatches, out, at);
    let at = layout::rgb(rgbs, out, at);
    let at = layout::scalar(scalars, out, at);
    layout::coat(coats, out, at);
}
