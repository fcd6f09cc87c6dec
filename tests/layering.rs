//! What the crates cannot keep apart: kernels know no world, libraries do not print, every stage has
//! a system in a file of its own kind.

use std::fs;
use std::path::{Path, PathBuf};

use selvedge::schedule::STAGES;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Every Rust file under `folder`, with its lines of code: comments and tests are taken out.
fn code(folder: &str) -> Vec<(PathBuf, Vec<String>)> {
    fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).expect("the folder is there") {
            let path = entry.expect("it can be listed").path();
            if path.is_dir() {
                walk(&path, found);
            } else if path.extension().is_some_and(|e| e == "rs") {
                found.push(path);
            }
        }
    }
    let mut files = Vec::new();
    walk(&root().join(folder), &mut files);
    files.sort();
    let read = |path: PathBuf| {
        let text = fs::read_to_string(&path).expect("it is text");
        let code = text.split("#[cfg(test)]").next().unwrap_or_default();
        let lines = code.lines().map(|line| line.split("//").next().unwrap_or_default().to_string());
        (path, lines.collect())
    };
    files.into_iter().map(read).collect()
}

/// Does `line` name `word`, and not as a part of another?
fn names(line: &str, word: &str) -> bool {
    let part = |c: char| c.is_alphanumeric() || c == '_';
    line.match_indices(word).any(|(at, _)| {
        !line[..at].chars().next_back().is_some_and(part) && !line[at + word.len()..].chars().next().is_some_and(part)
    })
}

fn offenders(folder: &str, words: &[&str], allowed: impl Fn(&Path) -> bool) -> Vec<String> {
    let mut found = Vec::new();
    for (path, lines) in code(folder).iter().filter(|(path, _)| !allowed(path)) {
        for (number, line) in lines.iter().enumerate() {
            if let Some(word) = words.iter().find(|word| names(line, word)) {
                found.push(format!("{}:{} names {word}", path.display(), number + 1));
            }
        }
    }
    found
}

#[test]
fn only_files_named_system_know_the_world() {
    let world = ["World", "Query", "Commands", "Res", "ResMut", "Local", "Schedule"];
    let is_system = |path: &Path| path.file_name().is_some_and(|name| name == "system.rs");
    assert_eq!(offenders("systems", &world, is_system), Vec::<String>::new());
    assert_eq!(offenders("components", &world, |_| false), Vec::<String>::new());
    // The check can fail: the systems themselves do name it.
    assert!(!offenders("systems", &world, |_| false).is_empty());
}

#[test]
fn libraries_do_not_print() {
    let printing = ["println", "eprintln", "print", "eprint", "dbg"].map(|name| format!("{name}!"));
    for folder in ["components", "systems", "engine"] {
        // The command line is what a user talks to, and a test what a developer reads.
        let inside = |path: &Path, folder: &str| path.components().any(|c| c.as_os_str() == folder);
        let talks = |path: &Path| path.ends_with("engine/main.rs") || inside(path, "cli") || inside(path, "tests");
        for (path, lines) in code(folder).iter().filter(|(path, _)| !talks(path)) {
            let prints = lines.iter().find(|line| printing.iter().any(|p| line.trim_start().starts_with(p.as_str())));
            assert_eq!(prints, None, "{}", path.display());
        }
    }
}

#[test]
fn dependencies_run_from_the_engine_to_the_systems_to_the_components() {
    let manifest = |folder: &str| fs::read_to_string(root().join(folder).join("Cargo.toml")).expect("a manifest");
    let depends = |folder: &str, on: &str| manifest(folder).lines().any(|line| line.starts_with(on));
    assert!(depends("systems", "selvedge-components"));
    for (folder, on) in [("components", "selvedge-systems"), ("components", "selvedge."), ("systems", "selvedge.")] {
        assert!(!depends(folder, on), "{folder} depends on {on}");
    }
}

#[test]
fn every_stage_has_its_system_and_every_system_its_stage() {
    let mut found = Vec::new();
    for (path, lines) in code("systems").iter().filter(|(path, _)| path.ends_with("system.rs")) {
        for line in lines {
            if let Some(name) = line.strip_prefix("pub fn ").and_then(|rest| rest.split(['(', '<']).next()) {
                found.push(name.to_string());
                let folder = path.parent().expect("a file is in a folder");
                let docs = fs::read_to_string(folder.join("mod.rs")).expect("a stage's folder says what it is");
                assert!(docs.starts_with("//! "), "{}", folder.display());
            }
        }
    }
    found.sort();
    let mut listed: Vec<String> = STAGES.iter().map(|stage| stage.system.to_string()).collect();
    listed.sort();
    assert_eq!(found, listed);
}
