//! The two directions of a regularised material at once, against each of them alone.

mod common;

use common::Random;
use common::empty_tables::empty_tables;
use common::lobes::{delta_cases, rough_cases};
use glam::Vec3;
use halflight_kernel::bsdf::{Bsdf, Lobe};
use halflight_kernel::regularize::both_ways::{eval_cosine_pdf_both, is_raised};
use halflight_kernel::regularize::regularized_bsdf::mixture_eval_cosine_pdf;
use halflight_kernel::scene::{
    LobeRecord, MAX_LOBES, Material, SurfacePoint, lobe_flag, lobe_kind,
};

fn is_close(a: f32, b: f32) -> bool {
    (a - b).abs() <= 2e-4 * a.abs().max(b.abs()).max(1e-6)
}

#[test]
fn both_ways_are_what_each_is_alone() {
    let mut random = Random(7);
    let mut record = <LobeRecord as bytemuck::Zeroable>::zeroed();
    record.flags = lobe_flag::FRONT | lobe_flag::BACK;
    let records = [record];
    let mut material = <Material as bytemuck::Zeroable>::zeroed();
    material.lobe_count = 1;
    let materials = [material];
    let tables = halflight_kernel::scene::Tables {
        lobes: &records,
        materials: &materials,
        ..empty_tables()
    };
    let mut point = SurfacePoint::ZERO;
    point.material = 0;
    let (mut lit, mut refracted, mut smooth) = (0, 0, 0);
    let mut cases = rough_cases();
    cases.extend(delta_cases());
    for case in &cases {
        // Records say that all exist on both sides.
        let mut lobe = case.lobe;
        lobe.flags |= lobe_flag::FRONT | lobe_flag::BACK;
        for _ in 0..4000 {
            let (wi, wo) = (random.direction(), random.direction());
            let tau = 10.0_f32.powf(1.0 + 4.0 * random.next_1d());
            let lobes = [lobe, Lobe::NONE, Lobe::NONE, Lobe::NONE];
            let lobes = core::array::from_fn::<_, MAX_LOBES, _>(|i| lobes[i.min(3)]);
            let bsdf = Bsdf::from_lobes(lobes, 1, &case.data, wi);
            if !is_raised(&bsdf, tau) {
                continue;
            }
            let tables = halflight_kernel::scene::Tables {
                data: &case.data,
                ..tables
            };
            let there = mixture_eval_cosine_pdf(&bsdf, &case.data, wi, wo, tau);
            let back = mixture_eval_cosine_pdf(&bsdf, &case.data, wo, wi, tau);
            for (is_exchanged, value) in [(false, there.0), (true, back.0)] {
                let both = eval_cosine_pdf_both(&bsdf, &tables, &point, wi, wo, is_exchanged, tau);
                let name = &case.name;
                let is_same = (0..3).all(|c| is_close(both.value[c], value[c]));
                assert!(
                    is_same,
                    "{name}, {tau}, {wi}, {wo}: {} for {value}",
                    both.value
                );
                if value == Vec3::ZERO {
                    continue;
                }
                let (p, q) = (both.pdf, both.pdf_reverse);
                assert!(
                    is_close(p, there.1),
                    "{name}, {tau}, {wi}, {wo}: {p} for {}",
                    there.1
                );
                assert!(
                    is_close(q, back.1),
                    "{name}, {tau}, {wi}, {wo}: {q} back for {}",
                    back.1
                );
                lit += 1;
                refracted += u32::from(wi.z * wo.z < 0.0);
                let kind = lobe.kind;
                smooth += u32::from(kind == lobe_kind::DIELECTRIC || kind == lobe_kind::CONDUCTOR);
            }
        }
    }
    assert!(
        lit > 10_000 && refracted > 3000 && smooth > 3000,
        "{lit}, {refracted}, {smooth}"
    );
}
