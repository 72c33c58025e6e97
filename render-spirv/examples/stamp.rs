//! The last step of `render-spirv/build-shaders`, with the module's name and the compiler's: forbids drivers to fuse arithmetic,
//! and writes the stamp.

use halflight_spirv::module::{MODULES, words_of};
use halflight_spirv::no_contraction::decorated;
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
    let words = decorated(&words_of(&std::fs::read(module.path(&root))?));
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    std::fs::write(module.path(&root), bytes)?;
    std::fs::write(module.stamp_path(&root), module.stamp(&root, &compiler)?)?;
    Ok(())
}
