//! Writes the stamp of the module: the last step of `render-spirv/build-shaders`.
//!
//! The module's bytes are read from the file, not from this program, which may hold older ones.

use halflight_spirv::module::{bytes_hash, source_hash};
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let compiler = std::env::args().nth(1).unwrap_or_default();
    let crate_root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let root = crate_root.join("..");
    let module = std::fs::read(crate_root.join("spirv/halflight.spv"))?;
    let stamp = format!(
        "sources {:016x}\ncompiler {compiler}\nmodule {:016x}\n",
        source_hash(&root)?,
        bytes_hash(&module)
    );
    std::fs::write(crate_root.join("spirv/halflight.stamp"), stamp)?;
    Ok(())
}
