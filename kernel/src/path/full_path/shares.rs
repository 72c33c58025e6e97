//! The shares of path expressions in a full path ([`crate::path::expression`]).
//!
//! Hosts only, as full paths are.

use super::Path;
use crate::bsdf::{Bsdf, mode};
use crate::path::expression::PathExpressions;
use crate::path::expression_shares::Shares;
use crate::path::path_states::PathStates;
use crate::path::retarget_states::Edits;
use crate::path::scattered::Scattered;
use crate::scene::Tables;

impl<const N: usize> Path<N> {
    /// Reads the path from its light; `bsdf` is a buffer for those of its vertices.
    pub fn shares(
        &self,
        tables: &Tables<'_>,
        expressions: &PathExpressions<'_>,
        edits: Option<&Edits<'_>>,
        bsdf: &mut Bsdf,
    ) -> Shares {
        let mut states = PathStates::at_emitter(expressions, self.emitter);
        for i in 1..self.edges() {
            let vertex = &self.vertices[i];
            let point = &vertex.point;
            let scattered = if vertex.is_smooth() {
                let (next, previous) = (self.next_direction(i), self.previous_direction(i));
                let Some(turned) = vertex.edited(edits, next, previous) else {
                    return Shares::NONE;
                };
                let to_sensor = turned.to_sensor;
                bsdf.look_up(tables, point, to_sensor, mode::RADIANCE);
                Scattered::smooth(bsdf, tables.data, to_sensor, turned.to_light)
            } else {
                Scattered::specular(vertex.event)
            };
            states.advance(expressions, &expressions.from_light, point, &scattered);
        }
        states.reach_sensor(expressions)
    }
}
