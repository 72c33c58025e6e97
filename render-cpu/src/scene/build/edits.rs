//! `<edit type="retarget">`: edits of light transport, in the scene or in a file of their own.
//!
//! | property | what it says |
//! |---|---|
//! | `selection` | the paths that are edited, as a path expression that ends (light) or begins (importance) with X |
//! | `flow` | without a selection, all paths: `light` or `importance` |
//! | `source` | where what is turned would go: a transform that places the cube from -1 to 1 (or the unit ball, `shape` = `sphere`), or the name of a shape of the scene |
//! | `target` | the transform that places the same cube or ball where it shall go |
//! | `map` | instead of a target the map itself; without a source its linear part turns all directions |
//! | `intensity`, `hue`, `saturation` | factors on what is turned: a number, and the tint of a hue in degrees |
//! | `keep` | `radiance`, or of light `energy` |
//!
//! `target` and `map` may be an `<animation>` of keyframes, between which translation, rotation and scale are interpolated.

use super::integrator::Integrator;
use super::options::BuildOptions;
use super::regularization::EDITED;
use crate::expression::SceneNames;
use crate::expression::names::region;
use crate::expression::selections::compile_selections;
use crate::integrators::{self, INTEGRATORS, turns_paths};
use crate::scene::edits::SceneEdits;
use crate::scene::error::SceneError;
use crate::scene::transform::rows_and_inverse;
use crate::scene::xml::unused::warn_unused;
use crate::scene::xml::{Object, ObjectKind, Value, parse_scene};
use glam::{DMat4, DVec3};
use halflight_kernel::math::affine::IDENTITY;
use halflight_kernel::path::expression::region_kind;
use halflight_kernel::path::retarget::{Edit, MAX_EDITS, flow, source};
use halflight_kernel::scene::Tables;
use std::sync::Arc;

/// What an edit is without a selection.
const ALL_LIGHT: &str = "L X+ X";
const ALL_IMPORTANCE: &str = "X X+ E";

/// What edits are read with.
pub(super) struct EditReader<'a> {
    pub options: &'a BuildOptions,
    pub integrator: &'a Integrator,
    pub tables: &'a Tables<'a>,
    pub names: &'a SceneNames,
}

impl EditReader<'_> {
    /// The edits of a scene, and those of a file of edits behind them.
    pub fn build(&self, root: &Object) -> Result<SceneEdits, SceneError> {
        let (tables, names) = (self.tables, self.names);
        let mut objects: Vec<Arc<Object>> = edits_of(root);
        if let Some(path) = &self.options.edit {
            let parsed = parse_scene(path, &[], true)?;
            parsed.root.touch();
            for child in parsed.root.children() {
                if child.object.kind != ObjectKind::Edit {
                    let message = "a file of edits holds nothing but <edit>s";
                    return Err(child.object.error(message));
                }
            }
            let of_file = edits_of(&parsed.root);
            if of_file.is_empty() {
                return Err(parsed.root.error("there is no <edit> in the file of edits"));
            }
            for object in &of_file {
                object.touch();
                let _ = self.read(object)?;
            }
            warn_unused(&parsed.root)?;
            objects.extend(of_file);
        }
        self.check_time(&objects)?;
        let mut list = Vec::new();
        let mut texts = Vec::new();
        let mut last = None;
        for object in &objects {
            object.touch();
            let (mut edit, text) = self.read(object)?;
            let compiled = compile_selections(&[text.as_str()], tables, names)
                .map_err(|e| object.property_error("selection", e.to_string()))?;
            edit.flow = compiled.flows[0];
            if edit.flow == flow::IMPORTANCE && edit.keeps_energy != 0 {
                let message = "energy is kept of light alone; importance keeps radiance";
                return Err(object.property_error("keep", message));
            }
            if !compiled.is_possible[0] {
                let (place, element) = object.property_place("selection");
                let message = format!(
                    "no surface of the scene scatters as \"{text}\" says: the edit changes nothing"
                );
                root.warn_at(place, element, message)?;
                continue;
            }
            // What changes nothing needs no guesses.
            if edit.map == IDENTITY && edit.factor == [1.0; 3] {
                continue;
            }
            self.check_algorithm(object)?;
            if list.len() == MAX_EDITS {
                return Err(object.error(format!("a scene has at most {MAX_EDITS} edits")));
            }
            list.push(edit);
            texts.push(text);
            last = Some(object);
        }
        let Some(last) = last else {
            return Ok(SceneEdits::default());
        };
        let all: Vec<&str> = texts.iter().map(String::as_str).collect();
        let compiled = compile_selections(&all, tables, names)
            .map_err(|e| last.property_error("selection", e.to_string()))?;
        Ok(SceneEdits::new(list, texts, compiled))
    }

    /// That a time which is given chooses something.
    fn check_time(&self, objects: &[Arc<Object>]) -> Result<(), SceneError> {
        let is_animated = |object: &Arc<Object>| {
            let mut properties = object.properties.iter();
            properties.any(|p| matches!(p.value, Value::Animation(_)))
        };
        if self.options.edit_time.is_some() && !objects.iter().any(is_animated) {
            let message = "--edit-time: there is no edit with an <animation>";
            return Err(SceneError::Request(message.to_owned()));
        }
        Ok(())
    }

    /// That the algorithm renders edits.
    fn check_algorithm(&self, object: &Object) -> Result<(), SceneError> {
        let settings = &self.integrator.settings;
        if !turns_paths(settings.kind) {
            let all = INTEGRATORS.iter().filter(|i| turns_paths(i.kind));
            return Err(object.error(format!(
                "edits of light transport are not for {}: use one of {}",
                self.integrator.name,
                integrators::names(all)
            )));
        }
        if settings.regularization.is_some() {
            return Err(object.error(EDITED));
        }
        Ok(())
    }

    /// The record of an edit but for its flow, and its selection.
    fn read(&self, object: &Object) -> Result<(Edit, String), SceneError> {
        if object.plugin != "retarget" {
            let message = format!("there is no edit \"{}\"; known is retarget", object.plugin);
            return Err(object.error(message));
        }
        check_properties(object)?;
        let selection = object.get_string("selection", "")?.to_owned();
        let own_flow = object.get_string("flow", "light")?;
        let text = match (selection.as_str(), own_flow) {
            ("", "light") => ALL_LIGHT.to_owned(),
            ("", "importance") => ALL_IMPORTANCE.to_owned(),
            (_, "light" | "importance") => selection,
            (_, other) => {
                let message = format!("expected light or importance, found \"{other}\"");
                return Err(object.property_error("flow", message));
            }
        };
        let (shape, from_unit) = read_source(object, self.tables, self.names)?;
        let (from, to_unit) = match &from_unit {
            Some(matrix) => {
                let (rows, inverse) = rows_and_inverse(matrix)
                    .map_err(|e| object.property_error("source", e.to_string()))?;
                (rows, inverse)
            }
            None => (IDENTITY, IDENTITY),
        };
        let time = self.options.edit_time.unwrap_or(0.0);
        let target = transform_at(object, "target", time)?;
        let map = transform_at(object, "map", time)?;
        let (name, matrix) = match (target, map) {
            (Some(_), Some(_)) => {
                return Err(object.property_error("map", "takes either \"target\" or \"map\""));
            }
            (Some(target), None) => {
                let Some(from) = &from_unit else {
                    let message = "a target needs a source; a map does not";
                    return Err(object.property_error("target", message));
                };
                ("target", target * from.inverse())
            }
            (None, Some(map)) => ("map", map),
            (None, None) => ("map", DMat4::IDENTITY),
        };
        let matrix = snapped_to_identity(matrix);
        let (map, inverse) =
            rows_and_inverse(&matrix).map_err(|e| object.property_error(name, e.to_string()))?;
        let changes = ["target", "map", "intensity", "hue"];
        if !changes.iter().any(|name| object.properties.contains(name)) {
            let message = "this edit changes nothing: it has no target, map, intensity or hue";
            return Err(object.error(message));
        }
        let keeps_energy = match object.get_string("keep", "radiance")? {
            "radiance" => 0,
            "energy" => 1,
            other => {
                let message = format!("expected radiance or energy, found \"{other}\"");
                return Err(object.property_error("keep", message));
            }
        };
        let edit = Edit {
            flow: flow::LIGHT,
            source: shape,
            to_unit,
            from_unit: from,
            map,
            inverse,
            factor: read_factor(object)?,
            keeps_energy,
        };
        Ok((edit, text))
    }
}

/// The edits that stand in a file, in their order.
fn edits_of(root: &Object) -> Vec<Arc<Object>> {
    let edits = root.children_of(ObjectKind::Edit);
    edits.map(|child| child.object.clone()).collect()
}

/// That no property of an edit is without effect.
fn check_properties(object: &Object) -> Result<(), SceneError> {
    let has = |name: &str| object.properties.contains(name);
    let refuse = |name: &str, message: &str| Err(object.property_error(name, message));
    let is_mapped = has("target") || has("map");
    if has("selection") && has("flow") {
        return refuse("flow", "the selection says which flow is turned");
    }
    if has("saturation") && !has("hue") {
        return refuse("saturation", "it is that of a hue, which is not given");
    }
    if has("keep") && !is_mapped {
        let message = "it says what a target or a map keeps, and there is neither";
        return refuse("keep", message);
    }
    let places_source =
        (object.properties.get("source")).is_some_and(|p| !matches!(p.value, Value::String(_)));
    if has("shape") && !places_source {
        return refuse("shape", "it is that of a source which a transform places");
    }
    Ok(())
}

/// The kind of a source, and the map that places its cube or ball.
fn read_source(
    object: &Object,
    tables: &Tables<'_>,
    names: &SceneNames,
) -> Result<(u32, Option<DMat4>), SceneError> {
    let shape = match object.get_string("shape", "box")? {
        "box" => source::BOX,
        "sphere" => source::BALL,
        other => {
            let message = format!("expected box or sphere, found \"{other}\"");
            return Err(object.property_error("shape", message));
        }
    };
    let Some(property) = object.properties.get("source") else {
        return Ok((source::EVERYWHERE, None));
    };
    match &property.value {
        Value::Transform(matrix) => Ok((shape, Some(*matrix))),
        Value::String(name) => {
            let Some(region) = region(tables, names, name) else {
                let message = format!("the scene has no shape \"{name}\" for a source");
                return Err(object.property_error("source", message));
            };
            let to_unit = DMat4::from_cols_array(&columns(&region.to_unit));
            let kind = if region.kind == region_kind::SPHERE {
                source::BALL
            } else {
                source::BOX
            };
            Ok((kind, Some(flat_along_z(to_unit.inverse(), kind))))
        }
        other => {
            let message = format!("expected a transform or a name, found {}", other.describe());
            Err(object.property_error("source", message))
        }
    }
}

/// The same box with its z along its shortest side, whose middle is the plane that counts.
fn flat_along_z(matrix: DMat4, kind: u32) -> DMat4 {
    if kind == source::BALL {
        return matrix;
    }
    let lengths = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|v| v.truncate().length());
    let shortest = (0..3).min_by(|a, b| lengths[*a].total_cmp(&lengths[*b]));
    match shortest {
        Some(0) => DMat4::from_cols(matrix.y_axis, matrix.z_axis, matrix.x_axis, matrix.w_axis),
        Some(1) => DMat4::from_cols(matrix.z_axis, matrix.x_axis, matrix.y_axis, matrix.w_axis),
        _ => matrix,
    }
}

fn columns(rows: &[f32; 12]) -> [f64; 16] {
    let mut columns = [0.0; 16];
    for row in 0..3 {
        for column in 0..4 {
            columns[4 * column + row] = f64::from(rows[4 * row + column]);
        }
    }
    columns[15] = 1.0;
    columns
}

/// A transform, or an animation at a time.
fn transform_at(object: &Object, name: &str, time: f64) -> Result<Option<DMat4>, SceneError> {
    let Some(property) = object.properties.get(name) else {
        return Ok(None);
    };
    match &property.value {
        Value::Transform(matrix) => Ok(Some(*matrix)),
        Value::Animation(keys) => Ok(Some(interpolated(keys, time))),
        other => {
            let message = format!("expected a transform, found {}", other.describe());
            Err(object.property_error(name, message))
        }
    }
}

/// Keyframes, which are in the order of time, at a time: translation, rotation and scale between two of them.
fn interpolated(keys: &[(f64, DMat4)], time: f64) -> DMat4 {
    let after = keys.partition_point(|(at, _)| *at <= time);
    if after == 0 || after == keys.len() {
        return keys[after.min(keys.len() - 1)].1;
    }
    let ((t0, a), (t1, b)) = (&keys[after - 1], &keys[after]);
    let share = (time - t0) / (t1 - t0);
    let (scale_a, turn_a, move_a) = a.to_scale_rotation_translation();
    let (scale_b, turn_b, move_b) = b.to_scale_rotation_translation();
    DMat4::from_scale_rotation_translation(
        scale_a.lerp(scale_b, share),
        turn_a.slerp(turn_b, share),
        move_a.lerp(move_b, share),
    )
}

/// The identity where a map differs from it by rounding alone.
fn snapped_to_identity(matrix: DMat4) -> DMat4 {
    let scale = 1.0 + matrix.w_axis.truncate().abs().max_element();
    if matrix.abs_diff_eq(DMat4::IDENTITY, 1e-9 * scale) {
        return DMat4::IDENTITY;
    }
    matrix
}

fn read_factor(object: &Object) -> Result<[f32; 3], SceneError> {
    let intensity = object.get_float_in("intensity", 1.0, 0.0, 1e6)?;
    let is_tinted = object.properties.get("hue").is_some();
    let hue = object.get_float("hue", 0.0)?;
    let saturation = object.get_float_in("saturation", 1.0, 0.0, 1.0)?;
    let mut tint = DVec3::ONE;
    if is_tinted {
        // The brightest colour of the hue, then as bright as white.
        let channel = |offset: f64| {
            let x = ((hue / 60.0 + offset).rem_euclid(6.0) - 3.0).abs() - 1.0;
            1.0 - saturation * (1.0 - x.clamp(0.0, 1.0))
        };
        tint = DVec3::new(channel(0.0), channel(4.0), channel(2.0));
        tint /= tint.dot(DVec3::new(0.2126, 0.7152, 0.0722));
    }
    Ok((tint * intensity).as_vec3().to_array())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keyframes_are_met_and_turned_between() {
        let turn = DMat4::from_rotation_z(1.0);
        let keys = [(1.0, DMat4::IDENTITY), (3.0, turn)];
        assert_eq!(interpolated(&keys, 0.0), DMat4::IDENTITY);
        assert_eq!(interpolated(&keys, 3.0), turn);
        assert_eq!(interpolated(&keys, 9.0), turn);
        let half = interpolated(&keys, 2.0);
        assert!(half.abs_diff_eq(DMat4::from_rotation_z(0.5), 1e-12));
    }
}
