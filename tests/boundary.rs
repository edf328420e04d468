//! The solver is free of the engine.

use std::path::Path;

fn sources(folder: &Path, found: &mut Vec<std::path::PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder of sources") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

#[test]
fn nothing_in_the_solver_names_the_engine() {
    let mut found = Vec::new();
    sources(&drape_tests::root().join("src/solver"), &mut found);
    assert!(found.len() > 10, "{} files", found.len());
    for path in found {
        let text = std::fs::read_to_string(&path).expect("a source file");
        for (number, line) in text.lines().enumerate() {
            let code = line.split("//").next().unwrap_or_default();
            for word in ["bevy", "Entity", "Handle<", "Commands", "Instant", "SystemTime"] {
                assert!(!code.contains(word), "{}:{}: {line}", path.display(), number + 1);
            }
            let outside = code.contains("crate::") && !code.contains("crate::solver");
            assert!(!outside, "{}:{} reaches out of the solver: {line}", path.display(), number + 1);
        }
    }
}
