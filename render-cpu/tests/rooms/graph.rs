//! The files of a crate, and an arrow from each to those that define what it names.

use super::names::{Import, Module, Names, read};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// Names of the longest path that is followed, re-exports included.
const LONGEST: usize = 12;

/// The files of a crate.
pub struct Graph {
    files: Vec<String>,
    modules: BTreeMap<Names, Module>,
    /// The files that a file imports, each with a name that it takes from there.
    arrows: Vec<BTreeMap<usize, String>>,
}

impl Graph {
    /// Of the crate whose root lies in a folder.
    pub fn read(folder: &Path) -> Graph {
        let mut files = Vec::new();
        collect(folder, folder, &mut files);
        files.sort();
        let mut modules = BTreeMap::new();
        for (file, name) in files.iter().enumerate() {
            let text = fs::read_to_string(folder.join(name)).expect("a file");
            let parsed = syn::parse_file(&text).unwrap_or_else(|e| panic!("{name}: {e}"));
            let mut path: Names = name
                .trim_end_matches(".rs")
                .split('/')
                .map(str::to_owned)
                .collect();
            if matches!(
                path.last().map(String::as_str),
                Some("mod" | "lib" | "main")
            ) {
                path.pop();
            }
            // A command beside its library is a crate of its own.
            if name == "main.rs" && files.iter().any(|f| f == "lib.rs") {
                continue;
            }
            read(&parsed.items, path, file, &mut modules);
        }
        let mut graph = Graph {
            arrows: vec![BTreeMap::new(); files.len()],
            files,
            modules,
        };
        graph.find_arrows();
        graph
    }

    /// Number of files.
    pub fn len(&self) -> usize {
        self.files.len()
    }

    /// Number of arrows.
    pub fn arrows(&self) -> usize {
        self.arrows.iter().map(BTreeMap::len).sum()
    }

    /// Files that reach each other, with the arrows between them.
    pub fn circles(&self) -> Vec<String> {
        let reached: Vec<BTreeSet<usize>> =
            (0..self.len()).map(|file| self.reached(file)).collect();
        let mut told: BTreeSet<usize> = BTreeSet::new();
        let mut circles = Vec::new();
        for file in 0..self.len() {
            if !reached[file].contains(&file) || told.contains(&file) {
                continue;
            }
            let members: Vec<usize> = reached[file]
                .iter()
                .copied()
                .filter(|&other| reached[other].contains(&file))
                .collect();
            told.extend(&members);
            let inside = |to: &usize| members.contains(to);
            let lines = members.iter().flat_map(|&from| {
                self.arrows[from]
                    .keys()
                    .filter(|to| inside(to))
                    .map(move |&to| self.describe(from, to))
            });
            circles.push(lines.collect::<Vec<_>>().join("; "));
        }
        circles
    }

    /// Arrows from a room to one after it. What lies in the root belongs to no room.
    pub fn arrows_up(&self, rooms: &[&str]) -> Vec<String> {
        let room = |file: usize| {
            let first = self.files[file]
                .split(['/', '.'])
                .next()
                .unwrap_or_default();
            rooms.iter().position(|&room| room == first)
        };
        let all =
            (0..self.len()).flat_map(|from| self.arrows[from].keys().map(move |&to| (from, to)));
        all.filter(|&(from, to)| matches!((room(from), room(to)), (Some(a), Some(b)) if b > a))
            .map(|(from, to)| self.describe(from, to))
            .collect()
    }

    fn describe(&self, from: usize, to: usize) -> String {
        format!(
            "{} -> {} ({})",
            self.files[from], self.files[to], self.arrows[from][&to]
        )
    }

    /// The files to which arrows lead from a file.
    fn reached(&self, file: usize) -> BTreeSet<usize> {
        let mut reached = BTreeSet::new();
        let mut left: Vec<usize> = self.arrows[file].keys().copied().collect();
        while let Some(next) = left.pop() {
            if reached.insert(next) {
                left.extend(self.arrows[next].keys());
            }
        }
        reached
    }

    fn find_arrows(&mut self) {
        let mut arrows = vec![BTreeMap::new(); self.len()];
        for (path, module) in &self.modules {
            let mut add = |to: Option<usize>, name: &str| {
                if let Some(to) = to.filter(|&to| to != module.file) {
                    arrows[module.file]
                        .entry(to)
                        .or_insert_with(|| name.to_owned());
                }
            };
            // An import counts where its name is used, so that a re-export is none.
            for word in &module.words {
                if !module.defined.contains(word) {
                    add(
                        self.definition(path, std::slice::from_ref(word), &mut BTreeSet::new()),
                        word,
                    );
                }
            }
            for names in &module.paths {
                add(
                    self.definition(path, names, &mut BTreeSet::new()),
                    &names.join("::"),
                );
            }
        }
        self.arrows = arrows;
    }

    /// The file that defines what a module calls by a path, none for what is no item of this crate. A path that ends at a module
    /// is no use of it.
    fn definition(
        &self,
        module: &[String],
        names: &[String],
        seen: &mut BTreeSet<(Names, Names)>,
    ) -> Option<usize> {
        if names.len() > LONGEST || !seen.insert((module.to_vec(), names.to_vec())) {
            return None;
        }
        let (first, rest) = names.split_first()?;
        match first.as_str() {
            "crate" => return self.definition(&[], rest, seen),
            "self" => return self.definition(module, rest, seen),
            "super" => return self.definition(module.split_last()?.1, rest, seen),
            _ => {}
        }
        let inner = [module, std::slice::from_ref(first)].concat();
        if self.modules.contains_key(&inner) {
            return self.definition(&inner, rest, seen);
        }
        let own = self.modules.get(module)?;
        if own.defined.contains(first) {
            return Some(own.file);
        }
        // Paths into other crates begin with none of these names.
        let is_ours = |import: &&Import| {
            let head = &import.path[0];
            let is_child = self
                .modules
                .contains_key(&[module, std::slice::from_ref(head)].concat());
            matches!(head.as_str(), "crate" | "self" | "super")
                || is_child
                || own
                    .imports
                    .iter()
                    .any(|other| other.name == *head && other.path[0] != *head)
        };
        // A name that is imported by itself hides those of globs.
        let is_named = own.imports.iter().any(|import| import.name == *first);
        let wanted = if is_named { first } else { "*" };
        let rest = if is_named { rest } else { names };
        let imports = own.imports.iter().filter(|import| import.name == wanted);
        imports.filter(is_ours).find_map(|import| {
            let names = [&import.path[..], rest].concat();
            self.definition(module, &names, seen)
        })
    }
}

fn collect(root: &Path, folder: &Path, files: &mut Vec<String>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            collect(root, &path, files);
        } else if path.extension().is_some_and(|e| e == "rs") {
            let name = path.strip_prefix(root).expect("a path below");
            files.push(name.to_string_lossy().replace('\\', "/"));
        }
    }
}
