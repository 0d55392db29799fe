//! Within a crate no file knows one that knows it, directly or by way of others.

use std::collections::{BTreeMap, BTreeSet};
use std::{fs, io, path::Path};

/// The names that a file takes from another.
type Imports = BTreeMap<(String, String), BTreeSet<String>>;

/// What a file has to do with names.
#[derive(Default)]
struct Module {
    file: String,
    modules: BTreeSet<String>,
    /// The names that `use` brings into it, each with its path.
    used: BTreeMap<String, Vec<String>>,
    /// Paths of which it takes something; those that it only hands on are not among them.
    taken: Vec<Vec<String>>,
}

/// A crate's modules by their paths.
type Modules = BTreeMap<Vec<String>, Module>;

#[test]
fn no_file_knows_one_that_knows_it() -> io::Result<()> {
    let mut found = String::new();
    for package in fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join(".."))? {
        let source = package?.path().join("src");
        assert!(source.join("lib.rs").exists(), "no library in {}", source.display());
        let programs = fs::read_dir(source.join("bin")).into_iter().flatten().flatten().map(|program| program.path());
        for (folder, root) in [(source.clone(), "lib.rs"), (source.clone(), "main.rs")]
            .into_iter()
            .chain(programs.map(|folder| (folder, "main.rs")))
        {
            let imports = imports(root, &|file| fs::read_to_string(folder.join(file)).ok());
            for circle in circles(&imports) {
                let within = imports.iter().filter(|((a, b), _)| circle.contains(a) && circle.contains(b));
                let each = within.map(|((from, to), names)| format!("\n  {from} takes {names:?} from {to}"));
                found += &each.fold(format!("\n{}:", folder.display()), |all, one| all + &one);
            }
        }
    }
    assert!(found.is_empty(), "files that know one another:{found}");
    Ok(())
}

#[test]
fn circles_are_found_however_names_are_brought_in() {
    let circles_of = |lib: &str, a: &str, b: &str, c: &str| {
        let files = BTreeMap::from([("lib.rs", lib), ("a.rs", a), ("b/mod.rs", b), ("b/c.rs", c)]);
        circles(&imports("lib.rs", &|file| files.get(file).map(|text| (*text).to_owned())))
    };
    let lib = "mod a; mod b; pub use a::A; pub use b::{B, C as D};";
    for a in ["use crate::{b::{B, C}};", "use crate::D;", "use crate::b as d; type A = d::C;", "crate::b::c::C"] {
        for c in ["use super::super::{a::A};", "use crate::A;", "type C = super::super::a::A;"] {
            let found = circles_of(lib, a, "mod c; pub use c::C;", c);
            assert_eq!(found, [["a.rs", "b/c.rs"].map(str::to_owned).into()].into(), "{a} {c}");
        }
    }
    for (b, c, n) in [
        ("mod c; pub(crate) struct B; pub use c::{C, c};", "use super::B;", 0),
        ("mod c; pub(crate) struct B(C); pub use c::C;", "use super::B;", 1),
        ("mod c; pub(crate) struct B; use c::C;", "mod d { use super::super::B; }", 1),
        ("mod c; // c::C\n struct B; const S: &str = \"c::C\";", "use super::B;", 0),
        ("mod c; struct B; #[cfg(test)] mod tests { use super::c::C; }", "use super::B;", 0),
        ("mod c; fn f() -> char { '\\'' } #[cfg(all(test, unix))] use c::C; type B = c::D;", "use super::*;", 1),
    ] {
        assert_eq!(circles_of(lib, "", b, c).len(), n, "{b} {c}");
    }
}

/// The sets of files of which each knows every other.
fn circles(imports: &Imports) -> BTreeSet<BTreeSet<String>> {
    let known: BTreeMap<_, _> = imports.keys().map(|(from, _)| (from, known(from, imports))).collect();
    let circle =
        |a: &String| known[a].iter().filter(|b| known.get(b).is_some_and(|k| k.contains(a))).cloned().collect();
    known.keys().map(|a| circle(a)).filter(|c: &BTreeSet<_>| !c.is_empty()).collect()
}

/// The files that `file` knows, directly or by way of others.
fn known(file: &String, imports: &Imports) -> BTreeSet<String> {
    let (mut known, mut open) = (BTreeSet::new(), vec![file]);
    while let Some(from) = open.pop() {
        open.extend(imports.keys().filter(|(a, b)| a == from && known.insert(b.clone())).map(|(_, b)| b));
    }
    known
}

/// What the files of the crate with this root take from one another; `text` has each file by its path.
fn imports(root: &str, text: &dyn Fn(&str) -> Option<String>) -> Imports {
    let (mut modules, mut imports) = (Modules::new(), Imports::new());
    declare(root, "", Vec::new(), text, &mut modules);
    for (at, module) in &modules {
        for path in &module.taken {
            if let Some(file) = defining(&modules, at, path, 0).filter(|file| *file != module.file) {
                let names = imports.entry((module.file.clone(), file.to_owned())).or_default();
                names.extend(path.last().cloned());
            }
        }
    }
    imports
}

/// Notes a file, if it is there, as the module `at`, and those that it declares, which are in `folder`.
fn declare(file: &str, folder: &str, at: Vec<String>, text: &dyn Fn(&str) -> Option<String>, modules: &mut Modules) {
    let Some(module) = text(file).map(|text| module(file, &text)) else { return };
    for name in &module.modules {
        let (path, at) = (format!("{folder}{name}"), [&at[..], std::slice::from_ref(name)].concat());
        for file in [".rs", "/mod.rs"].map(|end| path.clone() + end) {
            declare(&file, &format!("{path}/"), at.clone(), text, modules);
        }
    }
    modules.insert(at, module);
}

/// The file that defines what `path` means in the module `at`: none for modules themselves and for other crates.
fn defining<'a>(modules: &'a Modules, at: &[String], path: &[String], depth: usize) -> Option<&'a str> {
    let (mut at, mut known) = (at.to_vec(), false);
    for (i, name) in path.iter().enumerate() {
        let (module, last) = (modules.get(&at)?, i + 1 == path.len());
        match name.as_str() {
            "crate" => at.clear(),
            "self" => {}
            "super" => drop(at.pop()),
            // A function may have the name of its module.
            _ if module.modules.contains(name) && !(last && module.used.contains_key(name)) => at.push(name.clone()),
            // `use rand::rand` would never end.
            _ if module.used.contains_key(name) && depth < 8 => {
                return defining(modules, &at, &[&module.used[name], &path[i + 1..]].concat(), depth + 1);
            }
            _ => return known.then_some(&module.file),
        }
        known = true;
    }
    None
}

/// Reads a file's declarations and paths.
fn module(file: &str, text: &str) -> Module {
    let tokens = tokens(text);
    let token = |i: usize| tokens.get(i).map_or("", String::as_str);
    let mut module = Module { file: file.to_owned(), ..Module::default() };
    let (mut named, mut handed_on) = (BTreeSet::new(), Vec::new());
    // How many braces are open, and where modules within the file were opened: above these `super` is the file itself.
    let (mut open, mut inner, mut i) = (0, Vec::new(), 0);
    while i < tokens.len() {
        let outside = |mut path: Vec<String>| {
            path.drain(..path.iter().take_while(|name| *name == "super").count().min(inner.len()));
            path
        };
        let (before, next) = (if i == 0 { "" } else { token(i - 1) }, token(i + 2));
        match token(i) {
            "#" if next == "cfg" && tokens[i..after(&tokens, i + 1)].iter().any(|t| t == "test") => {
                i = after(&tokens, i + 1);
                while !["", ";", "{"].contains(&token(i)) {
                    i = after(&tokens, i);
                }
                i = after(&tokens, i) - 1;
            }
            "use" => {
                let end = (i..tokens.len()).find(|i| token(*i) == ";").unwrap_or(tokens.len());
                for (name, path) in branches(&tokens[i + 1..end]) {
                    let path = outside(path);
                    match before {
                        "pub" | ")" => handed_on.push((name.clone(), path.clone())),
                        _ => module.taken.push(path.clone()),
                    }
                    module.used.insert(name, path);
                }
                i = end;
            }
            "mod" if next == ";" => drop(module.modules.insert(token(i + 1).to_owned())),
            "mod" if next == "{" => inner.push(open),
            "{" => open += 1,
            "}" => {
                open -= 1;
                inner.pop_if(|o| *o == open);
            }
            first if is_name(first) && ![".", "::", "mod"].contains(&before) => {
                named.insert(first);
                let more = (1..).take_while(|n| token(i + 2 * n - 1) == "::" && is_name(token(i + 2 * n))).count();
                if more > 0 {
                    module.taken.push(outside((0..=more).map(|n| token(i + 2 * n).to_owned()).collect()));
                }
            }
            _ => {}
        }
        i += 1;
    }
    module.taken.extend(handed_on.into_iter().filter(|(name, _)| named.contains(name.as_str())).map(|(_, path)| path));
    module
}

/// The names that the tree after a `use` brings in, with their paths.
fn branches(tree: &[String]) -> Vec<(String, Vec<String>)> {
    let brace = tree.iter().position(|t| t == "{").unwrap_or(tree.len());
    let stem: Vec<_> = tree[..brace].iter().filter(|t| *t != "::").cloned().collect();
    if brace == tree.len() {
        let path = stem.iter().take_while(|t| *t != "as").cloned().collect();
        return stem.last().map(|name| (name.clone(), path)).into_iter().collect();
    }
    let (inside, mut depth) = (&tree[brace + 1..tree.len() - 1], 0);
    let parts = inside.split(|t| {
        depth += i32::from(t == "{") - i32::from(t == "}");
        t == "," && depth == 0
    });
    let full = |(name, path): (String, Vec<String>)| match name.as_str() {
        "self" => (stem.last().cloned().unwrap_or_default(), stem.clone()),
        _ => (name, [&stem[..], &path].concat()),
    };
    parts.flat_map(branches).map(full).collect()
}

/// The place after what opens at `i`.
fn after(tokens: &[String], i: usize) -> usize {
    let mut depth = 0;
    let end = tokens[i..].iter().position(|token| {
        depth += i32::from("([{".contains(token)) - i32::from(")]}".contains(token));
        depth == 0
    });
    end.map_or(tokens.len(), |n| i + n + 1)
}

fn is_name(token: &str) -> bool {
    token.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// Names, numbers and signs, without comments, strings and characters.
fn tokens(text: &str) -> Vec<String> {
    let text = text.replace("\\\\", "_").replace("\\\"", "_").replace("\\'", "_").replace('\\', "");
    let (mut rest, mut tokens) = (&text[..], Vec::new());
    while let Some(c) = rest.chars().next() {
        let past = |from: usize, end: &str| rest[from..].find(end).map_or(rest.len(), |n| from + n + end.len());
        let word = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
        let hashes = rest[word..].chars().take_while(|c| *c == '#').count();
        let length = match c {
            '/' if rest.starts_with("//") => past(2, "\n"),
            '"' => past(1, "\""),
            '\'' if rest.chars().nth(2) == Some('\'') => past(1, "'"),
            _ if ["r", "br"].contains(&&rest[..word]) && rest[word + hashes..].starts_with('"') => {
                past(word + hashes + 1, &format!("\"{}", "#".repeat(hashes)))
            }
            _ => {
                let length = if rest.starts_with("::") { 2 } else { word.max(c.len_utf8()) };
                tokens.extend((!c.is_whitespace()).then(|| rest[..length].to_owned()));
                length
            }
        };
        rest = &rest[length..];
    }
    tokens
}
