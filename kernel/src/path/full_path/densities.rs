//! Densities of the strategies that make a full path ([`super`]), from those at its vertices.
//!
//! Hosts only, as full paths are.

use super::Path;
use crate::scene::emitter;
use crate::scene::emitter::emission::{self, is_delta, is_infinite};
use crate::scene::{SurfacePoint, Tables, emitter_kind};

impl<const N: usize> Path<N> {
    /// p_s: density of the strategy with `s` vertices from the light, of which the sensor's subpath has at least the lens; zero
    /// where there is no such strategy. With `keeps_light` the point of the strategy s = 1 is the start of a light walk.
    pub fn strategy_pdf(&self, tables: &Tables<'_>, s: usize, keeps_light: bool) -> f32 {
        let k = self.edges();
        let kind = tables.emitters[self.emitter as usize].kind;
        let joins = |i: usize| i == 0 || i == k || self.vertices[i].is_smooth();
        if self.joined != 0 && s != self.joined {
            return 0.0;
        }
        if s > k || (s == 0 && is_delta(kind)) || (s > 0 && !(joins(s - 1) && joins(s))) {
            return 0.0;
        }
        if s == 1 && k == 1 && kind != emitter_kind::AREA {
            return 0.0;
        }
        let mut pdf = 1.0;
        // From the sensor.
        for j in s..k {
            if j + 1 < k {
                pdf *= self.vertices[j + 1].pdf_to_light;
            }
            pdf *= self.vertices[j].edge.pass;
            if j > 0 {
                pdf *= self.vertices[j].stop * self.vertices[j].guesses[1];
            }
        }
        if s == 0 {
            return pdf;
        }
        let outgoing = -self.to_light;
        let emitted = emission::density(tables, self.emitter, &self.vertices[0].point, outgoing);
        if s == 1 {
            if k == 1 || keeps_light {
                let density = if is_infinite(kind) {
                    // Its direction, and no position.
                    self.direction_pdf(tables)
                } else {
                    emitted.position
                };
                return pdf * density * self.solid_angle_per_area(tables, 0);
            }
            let reference = self.vertices[1].point.position;
            let light = &self.vertices[0].point;
            let direct = emitter::pdf_direct_of(tables, self.emitter, reference, light, outgoing);
            // Of a point light the density is one over the choice, and its intensity is not over d^2.
            let is_point = is_delta(kind) && !is_infinite(kind);
            let scale = if is_point { self.distance2(0) } else { 1.0 };
            return pdf * direct * scale;
        }
        pdf *= emitted.product();
        for i in 0..s - 1 {
            let next = &self.vertices[i + 1];
            pdf *= self.vertices[i].edge.pass * next.stop * next.guesses[0];
            if i > 0 {
                pdf *= self.vertices[i].pdf_to_sensor * self.light_ratio(i);
            }
        }
        pdf * self.end_ratio(tables, s - 1) * self.solid_angle_per_area(tables, s - 1)
    }

    /// Density of the direction of a light at infinity, the choice of the emitter included.
    fn direction_pdf(&self, tables: &Tables<'_>) -> f32 {
        let outgoing = -self.to_light;
        let density = emission::density(tables, self.emitter, &SurfacePoint::ZERO, outgoing);
        density.direction * tables.emitters[self.emitter as usize].selection_pdf
    }
}
