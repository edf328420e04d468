//! What a run without a window says, and where it says it.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "an example that runs without a window talks to the terminal")]

/// A line of the report.
pub fn say(title: &str, line: &str) {
    println!("{title}: {line}");
}

/// A line about what is missing or went wrong.
pub fn complain(title: &str, line: &str) {
    eprintln!("{title}: {line}");
}
