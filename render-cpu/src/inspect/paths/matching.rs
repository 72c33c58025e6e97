//! Which recorded paths an expression matches.
//!
//! Records hold shapes, not the instances that place them: a vertex on a copy has the names of its shape alone.

use super::super::record_file::RecordedPath;
use glam::Vec3;
use halflight_kernel::path::PathExpressions;
use halflight_kernel::path::expression::START;
use halflight_kernel::scene::SurfacePoint;
use halflight_kernel::transport::recorded::vertex_kind;

/// Bits of the expressions that match a path of the scene that they were compiled for; none if the path is of another scene.
pub fn matched(expressions: &PathExpressions<'_>, path: &RecordedPath) -> u32 {
    let automaton = &expressions.from_sensor;
    let mut state = START;
    for vertex in &path.vertices {
        let object = vertex.object as usize;
        let letter = match vertex.kind {
            vertex_kind::SENSOR => expressions.sensor,
            vertex_kind::LIGHT | vertex_kind::LIGHT_AT_INFINITY => {
                let Some(letter) = expressions.emitters.get(object) else {
                    return 0;
                };
                *letter
            }
            kind => {
                if object >= expressions.shapes.len() {
                    return 0;
                }
                let point = SurfacePoint {
                    position: Vec3::from_array(vertex.position),
                    shape: vertex.object,
                    ..SurfacePoint::ZERO
                };
                expressions.letter(expressions.first_letter(&point), kind)
            }
        };
        state = automaton.after(state, letter);
    }
    automaton.matched[state as usize]
}
