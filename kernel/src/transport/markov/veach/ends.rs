//! What a connection may make of the ends of its edge: which of them is blurred, and by which edits they are turned.

use super::ChainPath;
use crate::bsdf::{Bsdf, mode};
use crate::path::full_path::vertex::{BLURRED, SMOOTH};
use crate::path::retarget::{MAX_EDITS, flow};
use crate::path::tracer::Tracer;
use crate::scene::{Tables, Traverse};
use arrayvec::ArrayVec;

/// Which ends of the edge to vertex `s` make a path of one that is connected there.
#[derive(Clone, Copy, Debug)]
pub struct ConnectionEnds {
    /// Both scatter.
    smooth: bool,
    /// That at the light is blurred.
    light: bool,
    /// That at the sensor is blurred.
    sensor: bool,
}

impl ConnectionEnds {
    /// Those of a path, whatever its events there.
    pub fn of(tables: &Tables<'_>, path: &ChainPath, s: usize) -> ConnectionEnds {
        if !(path.blurring.radius > 0.0) {
            return ConnectionEnds {
                smooth: true,
                light: false,
                sensor: false,
            };
        }
        let mut bsdf = Bsdf::BLACK;
        let mut lobes = |i: usize| {
            if i == 0 || i == path.edges() {
                return (true, false);
            }
            let point = &path.vertices[i].point;
            let to_sensor = path.vertices[i + 1].point.position - point.position;
            let wc = point.frame.to_local(to_sensor.normalize());
            bsdf.look_up(tables, point, wc, mode::RADIANCE);
            (bsdf.has_smooth(), bsdf.has_delta())
        };
        let (light, sensor) = (lobes(s - 1), lobes(s));
        ConnectionEnds {
            smooth: light.0 && sensor.0,
            light: light.1 && sensor.0,
            sensor: light.0 && sensor.1,
        }
    }

    /// How many paths those are.
    pub fn count(&self) -> u32 {
        u32::from(self.smooth) + u32::from(self.light) + u32::from(self.sensor)
    }

    /// One of those paths by number: the vertex that is blurred if any is, beside its edge to vertex `s`.
    pub fn choose(&self, s: usize, index: u32) -> Option<usize> {
        let choices = [
            (self.smooth, None),
            (self.light, Some(s - 1)),
            (self.sensor, Some(s)),
        ];
        let mut left = choices.into_iter().filter(|choice| choice.0);
        left.nth(index as usize).and_then(|choice| choice.1)
    }
}

/// The pairs of labels that the ends of the edge to vertex `s` can have, whatever the selections: of light at the one, of importance
/// at the other.
pub fn end_labels<T: Traverse>(
    tracer: &Tracer<'_, T>,
    path: &ChainPath,
    s: usize,
) -> ArrayVec<[u32; 2], { (MAX_EDITS + 1) * (MAX_EDITS + 1) }> {
    let mut pairs = ArrayVec::new();
    let (k, tables) = (path.edges(), &tracer.view.tables);
    // Neither emitters turn what they send nor lenses what they see, and no light is turned towards a lens.
    let Some(edits) = tracer.edits.filter(|_| s < k) else {
        pairs.push([0; 2]);
        return pairs;
    };
    let (from, to) = (&path.vertices[s - 1].point, &path.vertices[s].point);
    let direction = if s == 1 && path.is_infinite(tables) {
        -path.to_light
    } else {
        (to.position - from.position).normalize()
    };
    let of_light = match s {
        1 => 1,
        _ => edits.labels(flow::LIGHT, from, direction),
    };
    let of_importance = edits.labels(flow::IMPORTANCE, to, -direction);
    for a in 0..=MAX_EDITS as u32 {
        for b in 0..=MAX_EDITS as u32 {
            if of_light >> a & 1 != 0 && of_importance >> b & 1 != 0 {
                pairs.push([a, b]);
            }
        }
    }
    pairs
}

/// Gives the ends of the edge to vertex `s` their labels.
pub fn set_end_labels(path: &mut ChainPath, s: usize, [of_light, of_sensor]: [u32; 2]) {
    path.vertices[s - 1].labels[flow::LIGHT as usize] = of_light;
    path.vertices[s].labels[flow::IMPORTANCE as usize] = of_sensor;
}

/// Passes on the paths of one that is connected at the edge to vertex `s`.
pub fn for_ends<T: Traverse>(
    tracer: &Tracer<'_, T>,
    path: &mut ChainPath,
    s: usize,
    mut finish: impl FnMut(&mut ChainPath),
) {
    let ends = ConnectionEnds::of(&tracer.view.tables, path, s);
    for labels in end_labels(tracer, path, s) {
        set_end_labels(path, s, labels);
        for index in 0..ends.count() {
            let blurred = ends.choose(s, index);
            if let Some(i) = blurred {
                path.vertices[i].event = BLURRED;
            }
            finish(path);
            if let Some(i) = blurred {
                path.vertices[i].event = SMOOTH;
            }
        }
    }
}
