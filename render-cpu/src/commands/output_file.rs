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
    let output_identity = identity(output);
    for input in inputs {
        if output_identity == identity(input) {
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

/// Makes sure that no two of the files that a command writes are the same; each with what is written there.
///
/// # Errors
/// Which ones are, in one sentence.
pub fn check_distinct(outputs: &[(&Path, &str)]) -> Result<(), String> {
    for (i, (path, what)) in outputs.iter().enumerate() {
        let same = |other: &&(&Path, &str)| identity(other.0) == identity(path);
        if let Some((_, other)) = outputs[..i].iter().find(same) {
            return Err(format!(
                "{}: {other} and {what} cannot be one file",
                path.display()
            ));
        }
    }
    Ok(())
}

/// A path by which a file is known, whether it is there or not: links are followed.
fn identity(path: &Path) -> PathBuf {
    let target = destination(path);
    let folder = match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let in_folder = || Some(folder.canonicalize().ok()?.join(target.file_name()?));
    let real = target.canonicalize().ok().or_else(in_folder);
    real.unwrap_or_else(|| target.clone())
}

/// ".exr", or ".png, .jpg or .hdr".
fn list(extensions: &[&str]) -> String {
    match extensions {
        [only] => format!(".{only}"),
        [first @ .., last] => format!(".{} or .{last}", first.join(", .")),
        [] => String::new(),
    }
}
