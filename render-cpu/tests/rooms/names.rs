//! The names of one module: what it defines, what it imports, and the paths that it writes.

use proc_macro2::{Delimiter, TokenStream, TokenTree};
use quote::ToTokens;
use std::collections::{BTreeMap, BTreeSet};
use syn::{Item, UseTree};

/// A path of names.
pub type Names = Vec<String>;

/// A name that a `use` brings into a module; `name` is `*` for all names of `path`.
#[derive(Clone)]
pub struct Import {
    pub path: Names,
    pub name: String,
}

/// A module: a file, or a module that is written inside one.
#[derive(Default)]
pub struct Module {
    /// The file in which it stands.
    pub file: usize,
    /// Names of its items.
    pub defined: BTreeSet<String>,
    pub imports: Vec<Import>,
    /// Paths of two names and more outside of imports.
    pub paths: BTreeSet<Names>,
    /// All names outside of imports.
    pub words: BTreeSet<String>,
}

/// Reads the items of a module, and those of the modules that are written inside it.
pub fn read(items: &[Item], path: Names, file: usize, modules: &mut BTreeMap<Names, Module>) {
    let mut module = Module {
        file,
        ..Module::default()
    };
    for item in items {
        match item {
            Item::Use(item) => imports(&item.tree, Vec::new(), &mut module.imports),
            Item::Mod(item) => {
                module.defined.insert(item.ident.to_string());
                if let Some((_, items)) = &item.content {
                    let inner = [&path[..], &[item.ident.to_string()]].concat();
                    read(items, inner, file, modules);
                }
            }
            item => {
                module.defined.extend(name(item));
                scan(item.to_token_stream(), &mut module);
            }
        }
    }
    modules.insert(path, module);
}

fn name(item: &Item) -> Option<String> {
    let ident = match item {
        Item::Const(item) => &item.ident,
        Item::Enum(item) => &item.ident,
        Item::Fn(item) => &item.sig.ident,
        Item::Macro(item) => item.ident.as_ref()?,
        Item::Static(item) => &item.ident,
        Item::Struct(item) => &item.ident,
        Item::Trait(item) => &item.ident,
        Item::Type(item) => &item.ident,
        Item::Union(item) => &item.ident,
        _ => return None,
    };
    Some(ident.to_string())
}

fn imports(tree: &UseTree, mut path: Names, found: &mut Vec<Import>) {
    match tree {
        UseTree::Path(tree) => {
            path.push(tree.ident.to_string());
            imports(&tree.tree, path, found);
        }
        UseTree::Name(tree) if tree.ident == "self" => {
            let name = path.last().cloned().unwrap_or_default();
            found.push(Import { path, name });
        }
        UseTree::Name(tree) => {
            let name = tree.ident.to_string();
            path.push(name.clone());
            found.push(Import { path, name });
        }
        UseTree::Rename(tree) => {
            if tree.ident != "self" {
                path.push(tree.ident.to_string());
            }
            found.push(Import {
                path,
                name: tree.rename.to_string(),
            });
        }
        UseTree::Glob(_) => found.push(Import {
            path,
            name: "*".to_owned(),
        }),
        UseTree::Group(tree) => {
            for tree in &tree.items {
                imports(tree, path.clone(), found);
            }
        }
    }
}

/// Collects paths from tokens, because the arguments of macros have no syntax of their own.
fn scan(tokens: TokenStream, module: &mut Module) {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let colon = |i: usize| matches!(tokens.get(i), Some(TokenTree::Punct(p)) if p.as_char() == ':');
    let mut i = 0;
    while i < tokens.len() {
        match &tokens[i] {
            // Comments of documentation are attributes: they are no imports.
            TokenTree::Punct(p) if p.as_char() == '#' => {
                let is_attribute = |t: &TokenTree| matches!(t, TokenTree::Group(g) if g.delimiter() == Delimiter::Bracket);
                i += if tokens.get(i + 1).is_some_and(is_attribute) {
                    2
                } else {
                    1
                };
            }
            TokenTree::Group(group) => {
                scan(group.stream(), module);
                i += 1;
            }
            TokenTree::Ident(ident) => {
                let mut path = vec![ident.to_string()];
                while colon(i + 1) && colon(i + 2) {
                    let Some(TokenTree::Ident(next)) = tokens.get(i + 3) else {
                        break;
                    };
                    path.push(next.to_string());
                    i += 3;
                }
                module.words.extend(path.iter().cloned());
                if path.len() > 1 {
                    module.paths.insert(path);
                }
                i += 1;
            }
            _ => i += 1,
        }
    }
}
