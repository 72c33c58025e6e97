//! Writes the stamp of a module: the last step of `render-spirv/build-shaders`, with the module's name and the compiler's.

use halflight_spirv::module::MODULES;
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let name = arguments.next().unwrap_or_default();
    let compiler = arguments.next().unwrap_or_default();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let module = MODULES
        .iter()
        .find(|m| m.name == name)
        .ok_or_else(|| format!("there is no module \"{name}\""))?;
    std::fs::write(module.stamp_path(&root), module.stamp(&root, &compiler)?)?;
    Ok(())
}
