//! Warnings about unused properties.
//!
//! After a scene is built, every property of the objects that were built should have been queried; one that was not is
//! misspelt, or belongs to another plugin or to an unsupported feature.

use std::collections::HashSet;
use std::sync::Arc;

use super::object::Object;
use super::object::Value;
use crate::scene::error::SceneError;

/// Warns about every unused property of the objects that were built.
///
/// # Errors
/// The first such warning, when the scene is read strictly.
pub fn warn_unused(root: &Arc<Object>) -> Result<(), SceneError> {
    let mut seen = HashSet::from([root.index]);
    let mut pending = vec![root.clone()];
    while let Some(object) = pending.pop() {
        // An object that was never built is reported where it is referred to.
        if !object.touched() {
            continue;
        }
        for property in object.properties.iter() {
            if !property.queried() {
                let message = format!("{} does not use this; it is ignored", object.element());
                object
                    .diagnostics
                    .warn(&property.location, property.element(), message)?;
            } else if let Value::Object(child) = &property.value
                && seen.insert(child.index)
            {
                pending.push(child.clone());
            }
        }
    }
    Ok(())
}
