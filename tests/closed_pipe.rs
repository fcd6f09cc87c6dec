//! What prints ends quietly where nobody reads any more.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn the_command_line_ends_well_when_its_output_is_closed() {
    let out = std::env::temp_dir().join(format!("selvedge-pipe-{}", std::process::id()));
    let mut child = Command::new(env!("CARGO_BIN_EXE_selvedge"))
        .arg("limit")
        .arg(root().join("data/cages/loop_icosahedron.obj"))
        .arg("--out")
        .arg(&out)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    drop(child.stdout.take());
    let ended = child.wait_with_output().expect("the program ends");
    let _ = fs::remove_dir_all(&out);
    assert_eq!(String::from_utf8_lossy(&ended.stderr), "");
    assert!(ended.status.success(), "{}", ended.status);
}

/// `println!` panics there; `say!` does not.
#[test]
fn examples_and_the_command_line_print_through_say() {
    for folder in ["examples", "engine/cli"] {
        for entry in fs::read_dir(root().join(folder)).expect("the folder is there") {
            let path = entry.expect("an entry").path();
            if path.extension().is_some_and(|end| end == "rs") && !path.ends_with("say.rs") {
                let text = fs::read_to_string(&path).expect("a source file");
                let text = text.replace("eprintln!", "");
                assert!(!text.contains("println!(") && !text.contains(" print!("), "{}", path.display());
            }
        }
    }
}
