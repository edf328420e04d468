//! Command lines of the programs without a window: what is wrong is one line on stderr, and the exit code is 2.
#![allow(dead_code, reason = "each program uses a part")]

use bevy_drape::ClothUntanglingMethod;
use clap::Parser;

/// The arguments; ends the process if they are wrong, or if only help is asked for.
pub fn parse<T: Parser>(program: &str) -> T {
    T::try_parse().unwrap_or_else(|error| {
        if error.use_stderr() {
            complain(program, &one_line(&error.to_string()));
            std::process::exit(2)
        }
        error.exit()
    })
}

/// Tells what went wrong.
#[expect(clippy::print_stderr, reason = "a program speaks on its terminal")]
pub fn complain(program: &str, line: &str) {
    eprintln!("{program}: {line}");
}

/// An error of clap without advice on how to get help.
fn one_line(error: &str) -> String {
    let said = error.split("\n\nUsage").next().unwrap_or(error).split("\n\nFor more").next().unwrap_or(error);
    let words: Vec<&str> = said.trim_start_matches("error: ").split_whitespace().collect();
    words.join(" ")
}

/// A method of untangling by its name, in any of the usual spellings.
pub fn method(text: &str) -> Result<ClothUntanglingMethod, String> {
    let plain = |name: &str| name.to_lowercase().replace(['-', '_'], "");
    let known = ClothUntanglingMethod::ALL.iter().copied().find(|m| plain(&format!("{m:?}")) == plain(text));
    known.ok_or_else(|| "must be history, local-gradient, global-gradient or by-end-type".into())
}
