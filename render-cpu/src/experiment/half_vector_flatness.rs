//! Table 7.1 of Kaplanyan 2017: how flat a path's contribution is in half-vector space, and how decorrelated.
//!
//! A chain of a point light, two rough mirrors (planes or paraboloids) and a pinhole. For half vectors given at both
//! mirrors the path is found by Newton's method in double precision, and its contribution is `f(X) |dX / dH|`, the
//! BSDFs times the kernel's [`half_vector_measure`].
//!
//! - Flatness: the half vector of the second mirror is moved over a disk, the first kept. The normalised contribution
//!   is compared with the normalised BSDF of that mirror: total variation distance, 0 when equal, 1 when disjoint. The
//!   same in vertex area measure, where the mirror's vertex moves between fixed neighbours and changes the first
//!   mirror's BSDF too.
//! - Decorrelation: both half vectors (or vertices) are moved at random as their BSDFs would. The share of the
//!   variance of the logarithm of the contribution that is not a sum of functions of one of them is the interaction; 0
//!   when the dimensions are independent factors.

use super::report::Report;
use super::search::Random;
use crate::plot::{Mark, Plot, Scale, Series};
use glam::{DMat2, DMat4, DVec2, DVec3, DVec4, Vec2, Vec3};
use halflight_kernel::bsdf::microfacet::Microfacets;
use halflight_kernel::manifold::chain::{geometry_term, half_vector_measure};
use halflight_kernel::manifold::{ChainJacobian, ChainVertex, half_vector_form};
use halflight_kernel::math::Frame;
use halflight_kernel::scene::distribution;
use std::fmt::Write;

/// A paraboloid `centre + u s + v t - curvature / 2 (u^2 + v^2) n`.
#[derive(Clone, Copy)]
struct Mirror {
    centre: DVec3,
    s: DVec3,
    t: DVec3,
    n: DVec3,
    curvature: f64,
}

impl Mirror {
    fn new(centre: DVec3, n: DVec3, curvature: f64) -> Mirror {
        let n = n.normalize();
        let s = (DVec3::X - n * n.x).normalize();
        Mirror {
            centre,
            s,
            t: n.cross(s),
            n,
            curvature,
        }
    }

    fn point(&self, x: DVec2) -> DVec3 {
        let drop = 0.5 * self.curvature * x.length_squared();
        self.centre + self.s * x.x + self.t * x.y - self.n * drop
    }

    fn normal(&self, x: DVec2) -> DVec3 {
        (self.n + (self.s * x.x + self.t * x.y) * self.curvature).normalize()
    }

    /// The kernel's vertex, with orthonormal tangents.
    fn vertex(&self, x: DVec2, alpha: f32) -> ChainVertex {
        let normal = self.normal(x);
        let length = (self.n + (self.s * x.x + self.t * x.y) * self.curvature).length();
        let across = |d: DVec3| (d - normal * normal.dot(d)) * (self.curvature / length);
        let (pu, pv) = (
            self.s - self.n * (self.curvature * x.x),
            self.t - self.n * (self.curvature * x.y),
        );
        let (nu, nv) = (across(self.s), across(self.t));
        let a = pu.length();
        let (tu, nu) = (pu / a, nu / a);
        let along = pv.dot(tu);
        let (pv, nv) = (pv - tu * along, nv - nu * along);
        let b = pv.length();
        ChainVertex {
            position: self.point(x).as_vec3(),
            geometric_normal: normal.as_vec3(),
            normal: normal.as_vec3(),
            tangent_u: tu.as_vec3(),
            tangent_v: (pv / b).as_vec3(),
            dn_u: nu.as_vec3(),
            dn_v: (nv / b).as_vec3(),
            reference: self.s.as_vec3(),
            ..ChainVertex::NONE
        }
        .scattering(false, 1.0, Vec2::splat(alpha))
    }
}

struct Chain {
    light: DVec3,
    mirrors: [Mirror; 2],
    sensor: DVec3,
    alpha: f32,
}

impl Chain {
    fn new(alpha: f32, curvature: f64) -> Chain {
        Chain {
            light: DVec3::new(-1.6, 0.2, 1.0),
            mirrors: [
                Mirror::new(
                    DVec3::new(-0.6, 0.0, 0.0),
                    DVec3::new(0.1, 0.0, 1.0),
                    curvature,
                ),
                Mirror::new(
                    DVec3::new(0.5, 0.0, 1.3),
                    DVec3::new(0.0, 0.05, -1.0),
                    curvature,
                ),
            ],
            sensor: DVec3::new(1.5, -0.1, 0.2),
            alpha,
        }
    }

    fn points(&self, x: DVec4) -> [DVec3; 4] {
        [
            self.light,
            self.mirrors[0].point(x.truncate().truncate()),
            self.mirrors[1].point(DVec2::new(x.z, x.w)),
            self.sensor,
        ]
    }

    /// Projected half vectors of both mirrors, in frames defined by the mirrors' first axes.
    fn half_vectors(&self, x: DVec4) -> DVec4 {
        let p = self.points(x);
        let at = |i: usize, y: DVec2| {
            let mirror = &self.mirrors[i - 1];
            let n = mirror.normal(y);
            let h = ((p[i - 1] - p[i]).normalize() + (p[i + 1] - p[i]).normalize()).normalize();
            let s = (mirror.s - n * n.dot(mirror.s)).normalize();
            DVec2::new(h.dot(s), h.dot(n.cross(s)))
        };
        let (a, b) = (at(1, DVec2::new(x.x, x.y)), at(2, DVec2::new(x.z, x.w)));
        DVec4::new(a.x, a.y, b.x, b.y)
    }

    /// dH / dx by central differences.
    fn jacobian(&self, x: DVec4) -> DMat4 {
        let step = 1e-5;
        let column = |axis: DVec4| {
            (self.half_vectors(x + axis * step) - self.half_vectors(x - axis * step)) / (2.0 * step)
        };
        DMat4::from_cols(
            column(DVec4::X),
            column(DVec4::Y),
            column(DVec4::Z),
            column(DVec4::W),
        )
    }

    /// The path with the given half vectors.
    fn solve(&self, target: DVec4, start: DVec4) -> Option<DVec4> {
        let mut x = start;
        for _ in 0..30 {
            let error = target - self.half_vectors(x);
            if error.length() < 1e-11 {
                return Some(x);
            }
            let mut step = self.jacobian(x).inverse() * error;
            // Far targets are approached in bounded steps.
            let longest = 0.3;
            if step.length() > longest {
                step *= longest / step.length();
            }
            x += step;
            if !x.is_finite() {
                return None;
            }
        }
        None
    }

    fn vertices(&self, x: DVec4) -> [ChainVertex; 4] {
        let (a, b) = (DVec2::new(x.x, x.y), DVec2::new(x.z, x.w));
        [
            ChainVertex::point(self.light.as_vec3()),
            self.mirrors[0].vertex(a, self.alpha),
            self.mirrors[1].vertex(b, self.alpha),
            ChainVertex::point(self.sensor.as_vec3()),
        ]
    }

    /// BSDFs of both mirrors, without Fresnel terms.
    fn scattering(&self, v: &[ChainVertex; 4]) -> [f64; 2] {
        let facets = Microfacets::new(distribution::BECKMANN, Vec2::splat(self.alpha), 1.0);
        [1, 2].map(|i| {
            let frame = Frame::from_normal(v[i].normal);
            let local = |to: Vec3| frame.to_local((to - v[i].position).normalize());
            let (wi, wo) = (local(v[i - 1].position), local(v[i + 1].position));
            if wi.z <= 0.0 || wo.z <= 0.0 {
                return 0.0;
            }
            let d = facets.distribution((wi + wo).normalize());
            f64::from(0.25 * d / (facets.projected_area(wi) * facets.projected_area(wo)))
        })
    }

    /// f(X) |dX / dH|, and the BSDF of the second mirror.
    fn in_half_vector_space(&self, x: DVec4) -> (f64, f64) {
        let v = self.vertices(x);
        let jacobian = ChainJacobian::<4>::new(&v, 4, half_vector_form::PROJECTED);
        let measure = half_vector_measure(&v, &jacobian, half_vector_form::PROJECTED).value();
        let f = self.scattering(&v);
        (f[0] * f[1] * f64::from(measure), f[1])
    }

    /// f(X) per area of the vertices, and the BSDF of the second mirror.
    fn in_area(&self, x: DVec4) -> (f64, f64) {
        let v = self.vertices(x);
        let f = self.scattering(&v);
        let g: f64 = (1..4)
            .map(|i| f64::from(geometry_term(&v[i - 1], &v[i])))
            .product();
        (f[0] * f[1] * g, f[1])
    }
}

/// Total variation distance of two tables after normalisation.
fn distance(pairs: &[(f64, f64)]) -> f64 {
    let (mut a, mut b) = (0.0, 0.0);
    for p in pairs {
        a += p.0;
        b += p.1;
    }
    0.5 * pairs.iter().map(|p| (p.0 / a - p.1 / b).abs()).sum::<f64>()
}

/// Share of the variance of `both - none` that is interaction.
struct Interaction {
    total: f64,
    rest: f64,
}

impl Interaction {
    fn of(samples: &[[f64; 4]]) -> f64 {
        let mut sum = Interaction {
            total: 0.0,
            rest: 0.0,
        };
        let n = samples.len() as f64;
        let mean = |f: &dyn Fn(&[f64; 4]) -> f64| samples.iter().map(f).sum::<f64>() / n;
        let total = |s: &[f64; 4]| s[3] - s[0];
        let rest = |s: &[f64; 4]| s[3] - s[1] - s[2] + s[0];
        let (mt, mr) = (mean(&total), mean(&rest));
        for s in samples {
            sum.total += (total(s) - mt).powi(2);
            sum.rest += (rest(s) - mr).powi(2);
        }
        sum.rest / sum.total.max(1e-300)
    }
}

fn gaussian(random: &mut Random) -> DVec2 {
    let r = (-2.0 * (1.0 - random.uniform()).ln()).sqrt();
    let (s, c) = (std::f64::consts::TAU * random.uniform()).sin_cos();
    DVec2::new(r * c, r * s)
}

/// Runs the experiment.
pub fn run(quick: bool) -> Report {
    let (grid, pairs) = if quick { (9, 150) } else { (25, 3000) };
    let mut text = String::from(
        "two rough mirrors between a point light and a pinhole, Beckmann; distance of f(X) from the second \
         mirror's BSDF, and interaction\n  alpha  curvature   distance: half vectors   vertex area    interaction: half vectors   vertex area\n",
    );
    let mut figures = vec![];
    let mut slices = vec![];
    for curvature in [0.0, 0.4, -0.15] {
        for alpha in [0.02_f32, 0.1, 0.3, 0.6] {
            let chain = Chain::new(alpha, curvature);
            let Some(specular) = chain.solve(DVec4::ZERO, DVec4::ZERO) else {
                let _ = writeln!(text, "  {alpha:<6} {curvature:<9}   no specular path");
                continue;
            };
            let jacobian = chain.jacobian(specular);
            // How each vertex moves its own half vector: the blocks B_1 and B_2.
            let block = |i: usize| {
                let c = [jacobian.col(2 * i), jacobian.col(2 * i + 1)];
                DMat2::from_cols(
                    DVec2::new(c[0][2 * i], c[0][2 * i + 1]),
                    DVec2::new(c[1][2 * i], c[1][2 * i + 1]),
                )
                .inverse()
            };
            let inverse = [block(0), block(1)];
            let reach = (1.8 * f64::from(alpha)).min(0.6);
            let (mut half, mut area) = (vec![], vec![]);
            let (mut slice, mut local) = (vec![], vec![]);
            for i in 0..grid {
                for j in 0..grid {
                    let node = |i: i32| 2.0 * f64::from(i) / f64::from(grid - 1) - 1.0;
                    let h = DVec2::new(node(i), node(j)) * reach;
                    if h.length() > reach {
                        continue;
                    }
                    if let Some(x) = chain.solve(DVec4::new(0.0, 0.0, h.x, h.y), specular) {
                        let value = chain.in_half_vector_space(x);
                        half.push(value);
                        if j == grid / 2 {
                            slice.push((h.x / f64::from(alpha), value.0));
                            local.push((h.x / f64::from(alpha), value.1));
                        }
                    }
                    let moved = inverse[1] * h;
                    area.push(chain.in_area(specular + DVec4::new(0.0, 0.0, moved.x, moved.y)));
                }
            }
            let mut random = Random(5);
            let (mut interaction, mut area_interaction) = (vec![], vec![]);
            for _ in 0..pairs {
                // Projected half vectors of the BSDF, cut at the disk's middle ring.
                let sigma = f64::from(alpha) * 0.5_f64.sqrt();
                let (a, b) = (gaussian(&mut random) * sigma, gaussian(&mut random) * sigma);
                if a.length().max(b.length()) > 0.6 {
                    continue;
                }
                let sets = [
                    (DVec2::ZERO, DVec2::ZERO),
                    (a, DVec2::ZERO),
                    (DVec2::ZERO, b),
                    (a, b),
                ];
                let mut logs = [f64::NAN; 4];
                let mut area_logs = [f64::NAN; 4];
                for (k, (a, b)) in sets.into_iter().enumerate() {
                    if let Some(x) = chain.solve(DVec4::new(a.x, a.y, b.x, b.y), specular) {
                        logs[k] = chain.in_half_vector_space(x).0.ln();
                    }
                    let (p, q) = (inverse[0] * a, inverse[1] * b);
                    let x = specular + DVec4::new(p.x, p.y, q.x, q.y);
                    area_logs[k] = chain.in_area(x).0.ln();
                }
                // The same samples in both domains.
                if logs.iter().chain(&area_logs).all(|v| v.is_finite()) {
                    interaction.push(logs);
                    area_interaction.push(area_logs);
                }
            }
            let (dh, da) = (distance(&half), distance(&area));
            let (ih, ia) = (
                Interaction::of(&interaction),
                Interaction::of(&area_interaction),
            );
            let _ = writeln!(
                text,
                "  {alpha:<6} {curvature:<9} {dh:>16.4} {da:>17.4} {ih:>22.2e} {ia:>19.2e}"
            );
            for (name, value) in [
                ("distance", dh),
                ("area distance", da),
                ("interaction", ih),
                ("area interaction", ia),
            ] {
                figures.push((format!("{name} {alpha} {curvature}"), value));
            }
            if curvature == 0.4 && alpha != 0.02 {
                let colour = slices.len() / 2;
                for (mark, points, name) in [
                    (Mark::Line, slice, format!("f(X) |dX/dH|, alpha {alpha}")),
                    (Mark::Points, local, "BSDF of the mirror".to_string()),
                ] {
                    let top = points.iter().fold(0.0_f64, |m, p| m.max(p.1)).max(1e-300);
                    slices.push(Series {
                        label: name,
                        mark,
                        colour,
                        points: points.into_iter().map(|(x, y)| (x, y / top)).collect(),
                    });
                }
            }
        }
    }
    text.push_str(
        "Moving one half vector changes the contribution as the local BSDF does; moving a vertex \
         changes its neighbour's BSDF as well (thesis section 7.2.2).\n",
    );
    Report {
        text,
        plots: vec![Plot {
            title: "Contribution over the half vector of one mirror (curvature 0.4)".into(),
            axes: [
                "projected half vector / alpha".into(),
                "over its largest value".into(),
            ],
            scales: [Scale::Linear; 2],
            series: slices,
        }],
        figures,
    }
}
