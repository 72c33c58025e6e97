//! Full paths with a specular vertex that is connected all the same, its discrete events blurred ([`crate::path::mollified`]).
//!
//! As in bidirectional path tracing ([`crate::path::specular_chain`]) that is a vertex of a path that nothing samples: the specular end
//! of the longest edge that joins such a vertex with one that is not specular, of equal ones of that nearest to the light. The only
//! strategy that can make the path is the one that connects this edge.
//!
//! Invariant (tests): chains of such paths have the image of mollified bidirectional path tracing, block by block.
//!
//! Hosts only, as [`super`].

use super::Path;
use super::vertex::{BLURRED, SMOOTH};
use crate::bsdf::{Bsdf, mode};
use crate::math::{Rgb, float};
use crate::path::evaluation::Interaction;
use crate::path::mollified::{Blur, mollified};
use crate::path::rules::PathRules;
use crate::scene::emitter::emission::is_delta;
use crate::scene::{Tables, camera};

impl<const N: usize> Path<N> {
    /// Whether the strategy `s` may have made the path: not where it connected another edge than the one that is blurred.
    #[inline]
    pub fn may_join(&self, s: usize) -> bool {
        self.joined == 0 || self.joined == s
    }

    /// Whether a vertex is blurred.
    #[inline]
    pub fn is_blurred(&self) -> bool {
        self.joined != 0
    }

    /// The vertex that is blurred.
    #[inline]
    pub fn blurred_vertex(&self) -> Option<usize> {
        let s = self.joined;
        let is_at = |i: usize| self.vertices[i].event == BLURRED;
        (s != 0).then(|| if is_at(s) { s } else { s - 1 })
    }

    /// Notes which edge a blurred vertex connects; returns whether it is where it has to be.
    pub(super) fn find_joined(&mut self, tables: &Tables<'_>, rules: &PathRules) -> bool {
        self.joined = 0;
        if !(self.blurring.radius > 0.0) {
            return true;
        }
        let mut blurred = self.vertices.iter().map(|v| v.event == BLURRED);
        let Some(at) = blurred.position(|is_blurred| is_blurred) else {
            return true;
        };
        if blurred.any(|is_blurred| is_blurred) {
            return false;
        }
        let s = self.edge_to_blur(tables, rules);
        self.joined = s;
        s != 0 && (at == s || at + 1 == s)
    }

    /// The far end, from the light, of the edge where a path that nothing samples is blurred; zero if something does.
    fn edge_to_blur(&self, tables: &Tables<'_>, rules: &PathRules) -> usize {
        let k = self.edges();
        let has_lens = camera::pdf_lens_area(&tables.camera) > 0.0 && rules.hide_emitters == 0;
        if has_lens || !is_delta(tables.emitters[self.emitter as usize].kind) {
            return 0;
        }
        let is_rough = |i: usize| i == 0 || i == k || self.vertices[i].event == SMOOTH;
        let (mut chosen, mut longest) = (0, 0.0);
        for i in 0..k {
            if is_rough(i) && is_rough(i + 1) {
                return 0;
            }
            let edge = if i == 0 && self.is_infinite(tables) {
                float::sqr(tables.info.radius)
            } else {
                self.distance2(i)
            };
            if is_rough(i) != is_rough(i + 1) && edge > longest {
                (chosen, longest) = (i + 1, edge);
            }
        }
        chosen
    }

    /// What a blurred vertex scatters, in the measure of full paths.
    pub(super) fn blurred_value(
        &self,
        tables: &Tables<'_>,
        rules: &PathRules,
        i: usize,
        bsdf: &mut Bsdf,
    ) -> Rgb {
        let (to_sensor, to_light) = (self.next_direction(i), self.previous_direction(i));
        let point = &self.vertices[i].point;
        let is_lit = i == self.joined;
        let distance = if !is_lit {
            float::sqrt(self.distance2(i))
        } else if i == 1 && self.is_infinite(tables) {
            tables.info.radius
        } else {
            float::sqrt(self.distance2(i - 1))
        };
        let blur = Blur::new(self.blurring.kernel, self.blurring.radius, distance);
        let (from, to, transport_mode) = if is_lit {
            (to_sensor, to_light, mode::RADIANCE)
        } else {
            (to_light, to_sensor, mode::IMPORTANCE)
        };
        bsdf.look_up(tables, point, point.frame.to_local(from), mode::RADIANCE);
        let at = Interaction::new(point, bsdf, -from);
        let value = mollified(&at, tables, rules, transport_mode, to, blur);
        if is_lit {
            value
        } else {
            value * (self.cosine(i, to_light) / self.cosine(i, to_sensor))
        }
    }
}
