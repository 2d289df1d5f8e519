//! The files of a crate do not import each other in a cycle: each can be read after those below it.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

const CRATES: &[&str] = &["services", "sim", "bench", "bindings"];

/// Path of a module in the crate; that of the crate's root is empty.
type Module = Vec<String>;

/// Imports of a module: the local name, the imported path, and whether it is only re-exported (`pub use`).
type Imports = BTreeMap<String, (Vec<String>, bool)>;

struct Source {
    file: PathBuf,
    /// Without tests and comments.
    code: String,
    imports: Imports,
}

fn sources(src: &Path, folder: &Path, found: &mut BTreeMap<Module, Source>) {
    for path in fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
        .map(|e| e.path())
    {
        if path.is_dir() && !path.ends_with("bin") {
            sources(src, &path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            let inside = path.strip_prefix(src).expect("a file of the crate");
            let mut module: Module = inside
                .with_extension("")
                .iter()
                .map(|p| p.to_string_lossy().into_owned())
                .collect();
            module.retain(|part| !["lib", "main", "mod"].contains(&part.as_str()));
            let text = fs::read_to_string(&path).expect("a source file");
            let text = text.split("#[cfg(test)]\nmod tests {").next();
            let text = text.unwrap_or_default();
            let code: Vec<&str> = text
                .lines()
                .map(|l| l.split("//").next().unwrap_or_default())
                .collect();
            let code = code.join("\n");
            let imports = imports(&code);
            found.insert(
                module,
                Source {
                    file: path,
                    code,
                    imports,
                },
            );
        }
    }
}

/// The paths of one `use`, with its braces expanded: `a::{b, c as d}` is `b` for `a::b`, and `d` for `a::c`.
fn opened(text: &str, before: &[String], is_handed_on: bool, imports: &mut Imports) {
    let (mut depth, mut from) = (0, 0);
    let mut parts = Vec::new();
    for (at, letter) in text.char_indices() {
        match letter {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&text[from..at]);
                from = at + 1;
            }
            _ => {}
        }
    }
    parts.push(&text[from..]);
    for part in parts.into_iter().map(str::trim).filter(|p| !p.is_empty()) {
        let (path, group) = part
            .split_once('{')
            .map_or((part, None), |(p, g)| (p, g.strip_suffix('}')));
        let (path, name) = path
            .split_once(" as ")
            .map_or((path, None), |(p, n)| (p, Some(n)));
        let mut whole = before.to_vec();
        whole.extend(
            path.split("::")
                .map(|s| s.trim().to_owned())
                .filter(|s| !s.is_empty() && s != "self"),
        );
        if let Some(group) = group {
            opened(group, &whole, is_handed_on, imports);
        } else if let Some(last) = whole.last().cloned() {
            imports.insert(
                name.map_or(last, |n| n.trim().to_owned()),
                (whole, is_handed_on),
            );
        }
    }
}

fn imports(code: &str) -> Imports {
    let mut found = Imports::new();
    for (path, before) in code.split("use ").skip(1).zip(code.split("use ")) {
        let before = before.rsplit('\n').next().unwrap_or_default().trim();
        if before.is_empty() || before.starts_with("pub") {
            let path = path.split(';').next().unwrap_or_default();
            opened(path, &[], before.starts_with("pub"), &mut found);
        }
    }
    found
}

/// The module that defines the target of a path, seen from `module`; none in another crate.
fn home(
    all: &BTreeMap<Module, Source>,
    module: &Module,
    path: &[String],
    steps: usize,
) -> Option<Module> {
    if steps == 0 {
        return None;
    }
    let mut here = module.clone();
    for (at, name) in path.iter().enumerate() {
        match name.as_str() {
            "crate" => here.clear(),
            "self" => {}
            "super" => {
                here.pop()?;
            }
            _ => {
                let mut child = here.clone();
                child.push(name.clone());
                if all.contains_key(&child) {
                    here = child;
                } else if let Some((import, _)) = all[&here].imports.get(name) {
                    let itself = at == 0 && import.as_slice() == &path[..1];
                    let rest: Vec<String> = import.iter().chain(&path[at + 1..]).cloned().collect();
                    return if itself {
                        None
                    } else {
                        home(all, &here, &rest, steps - 1)
                    };
                } else {
                    return (at > 0).then_some(here);
                }
            }
        }
    }
    None
}

/// The files whose names each file uses. A re-export (`pub use`) uses none.
fn arrows(all: &BTreeMap<Module, Source>) -> BTreeMap<&Module, BTreeSet<Module>> {
    let arrows = all.iter().map(|(module, source)| {
        let own = source
            .imports
            .values()
            .filter(|(_, is_handed_on)| !is_handed_on)
            .map(|(path, _)| path.clone());
        let is_name = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
        let inline = source
            .code
            .split(|c| !is_name(c))
            .filter(|p| p.contains("::"));
        let inline = inline.map(|p| {
            p.split("::")
                .filter(|s| !s.is_empty())
                .map(str::to_owned)
                .collect()
        });
        let used = own
            .chain(inline)
            .filter_map(|path: Vec<String>| home(all, module, &path, 8));
        (
            module,
            used.filter(|to| !to.starts_with(module) && !module.starts_with(to))
                .collect(),
        )
    });
    arrows.collect()
}

/// All files that each file reaches along the arrows.
fn reached(arrows: &BTreeMap<&Module, BTreeSet<Module>>, from: &Module) -> BTreeSet<Module> {
    let (mut reached, mut next) = (BTreeSet::new(), vec![from.clone()]);
    while let Some(module) = next.pop() {
        let new = arrows[&module]
            .iter()
            .filter(|to| reached.insert((*to).clone()));
        next.extend(new.cloned());
    }
    reached
}

/// The files of a crate that are in a cycle.
fn in_loops(src: &Path) -> Vec<String> {
    let mut all = BTreeMap::new();
    sources(src, src, &mut all);
    let arrows = arrows(&all);
    let found = arrows
        .keys()
        .filter(|module| reached(&arrows, module).contains(**module));
    let inside = found.filter_map(|module| all[*module].file.strip_prefix(src).ok());
    inside.map(|file| file.display().to_string()).collect()
}

#[test]
fn no_files_of_a_crate_import_each_other_in_a_loop() {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let mut crates = Vec::new();
    for folder in CRATES {
        let inner = fs::read_dir(root.join(folder))
            .into_iter()
            .flatten()
            .flatten();
        let inner = inner.map(|e| format!("{folder}/{}", e.file_name().to_string_lossy()));
        crates.extend(inner.chain([(*folder).to_owned()]));
    }
    crates.retain(|folder| root.join(folder).join("src").is_dir());
    assert!(crates.len() > 20, "{crates:?}");
    for folder in crates {
        let found = in_loops(&root.join(&folder).join("src"));
        assert_eq!(found, Vec::<String>::new(), "{folder}");
    }
}

#[test]
fn a_loop_is_seen_and_a_module_with_what_is_inside_it_is_none() {
    let folder = tempfile::tempdir().expect("a folder");
    let write =
        |file: &str, text: &str| fs::write(folder.path().join(file), text).expect("written");
    write("lib.rs", "mod a;\nmod b;\nmod c;\npub use b::B;\n");
    write(
        "a.rs",
        "use crate::B;\nuse crate::c::C;\npub struct A(B, C);\n",
    );
    write("c.rs", "pub struct C;\n");
    write(
        "b.rs",
        "pub struct B;\n#[cfg(test)]\nmod tests { use crate::a::A; }\n",
    );
    assert_eq!(in_loops(folder.path()), Vec::<String>::new());
    write("b.rs", "pub struct B(Box<crate::a::A>);\n");
    assert_eq!(in_loops(folder.path()), ["a.rs", "b.rs"]);
}
