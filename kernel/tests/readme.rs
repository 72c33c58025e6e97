//! The walk through the code in the README holds: its files and functions exist.

use std::path::Path;

#[test]
fn files_and_functions_of_the_walk_exist() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let readme = std::fs::read_to_string(root.join("README.md")).expect("a README");
    let start = readme.find("## How to read the code").expect("a section");
    let section = &readme[start..];
    let section = &section[..section[3..]
        .find("\n## ")
        .map_or(section.len(), |end| end + 3)];
    // Every second piece is between backticks.
    let pieces: Vec<&str> = section.split('`').collect();
    let (mut files, mut functions) = (0, 0);
    for i in (1..pieces.len()).step_by(2) {
        let name = pieces[i];
        if !name.ends_with(".rs") || name.contains('*') {
            continue;
        }
        let found = ["", "kernel/src", "render-cpu/src", "render-spirv/src"]
            .iter()
            .map(|folder| root.join(folder).join(name))
            .find(|path| path.is_file());
        let path = found.unwrap_or_else(|| panic!("there is no {name}"));
        files += 1;
        // A function in parentheses behind the file.
        if pieces.get(i + 1).is_some_and(|text| text.trim() == "(") {
            let function = pieces[i + 2];
            let source = std::fs::read_to_string(&path).expect("a source file");
            assert!(
                source.contains(&format!("fn {function}("))
                    || source.contains(&format!("fn {function}<")),
                "{name} has no function {function}"
            );
            functions += 1;
        }
    }
    assert!(
        files > 25 && functions > 12,
        "{files} files, {functions} functions"
    );
}
