//! Whether a file can be written, found out before an hour is spent on what shall be in it.

use crate::atomic_file::{clean_up, destination};
use std::path::{Path, PathBuf};

/// Makes sure that a command can write `output`: its name ends in one of `extensions` (any, if there are none), its folder
/// takes files, it is no read-only or special file, and it is none of the `inputs`. Links are followed. What a killed run left
/// of an earlier attempt is removed.
///
/// # Errors
/// What is wrong, in one sentence.
pub fn check<'a>(
    output: &Path,
    extensions: &[&str],
    inputs: impl IntoIterator<Item = &'a Path>,
) -> Result<(), String> {
    let name = output.display();
    let wrong = |what: String| Err(format!("{name}: {what}"));
    let extension = output.extension().unwrap_or_default();
    if !extensions.is_empty() && !extensions.iter().any(|e| extension.eq_ignore_ascii_case(e)) {
        return wrong(format!(
            "the name of what is written ends in {}",
            list(extensions)
        ));
    }
    let target = destination(output);
    let folder = match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        return wrong(format!("there is no folder {}", folder.display()));
    }
    if let Ok(metadata) = target.metadata() {
        if !metadata.is_file() {
            return wrong("it exists and is no regular file".into());
        }
        if metadata.permissions().readonly() {
            return wrong("it is read-only".into());
        }
    }
    let real = |path: &Path| -> PathBuf { path.canonicalize().unwrap_or_else(|_| path.to_owned()) };
    let own = real(&target);
    for input in inputs {
        if own == real(input) {
            return wrong(format!(
                "it would replace {}, which is read",
                input.display()
            ));
        }
    }
    clean_up(&target);
    let probe = tempfile::Builder::new()
        .prefix(".halflight.")
        .suffix(".partial")
        .tempfile_in(folder);
    match probe {
        Ok(_) => Ok(()),
        Err(error) => wrong(format!("{} takes no files: {error}", folder.display())),
    }
}

/// ".exr", or ".png, .jpg or .hdr".
fn list(extensions: &[&str]) -> String {
    match extensions {
        [only] => format!(".{only}"),
        [first @ .., last] => format!(".{} or .{last}", first.join(", .")),
        [] => String::new(),
    }
}
