//! The shares of path expressions in a whole path ([`super::expression`]).
//!
//! Hosts only, as whole paths are.

use super::expression::PathExpressions;
use super::path_states::{PathStates, Shares};
use super::scattered::Scattered;
use super::whole::Path;
use crate::bsdf::{Bsdf, mode};
use crate::scene::Tables;

impl<const N: usize> Path<N> {
    /// Reads the path from its light; `bsdf` is a buffer for those of its vertices.
    pub fn shares(
        &self,
        tables: &Tables<'_>,
        expressions: &PathExpressions<'_>,
        bsdf: &mut Bsdf,
    ) -> Shares {
        let mut states = PathStates::at_emitter(expressions, self.emitter);
        for i in 1..self.edges() {
            let vertex = &self.vertices[i];
            let point = &vertex.point;
            let scattered = if vertex.is_smooth() {
                let to_sensor = point.frame.to_local(self.next_direction(i));
                let to_light = point.frame.to_local(self.previous_direction(i));
                bsdf.look_up(tables, point, to_sensor, mode::RADIANCE);
                Scattered::smooth(bsdf, tables.data, to_sensor, to_light)
            } else {
                Scattered::specular(vertex.event)
            };
            states.advance(expressions, &expressions.from_light, point, &scattered);
        }
        states.reach_sensor(expressions)
    }
}
