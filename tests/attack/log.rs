//! What is warned of: once for each cause, until something is done again.

/// Causes that were told of since something was done.
#[derive(Default)]
pub struct Told(Vec<String>);

impl Told {
    /// Something was done: everything may be told again.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// The first line of a cause that was told before.
    pub fn again<'a>(&mut self, lines: &'a [String]) -> Option<&'a str> {
        lines.iter().find_map(|line| {
            let cause = cause(line);
            let again = self.0.contains(&cause);
            self.0.push(cause);
            again.then_some(line.as_str())
        })
    }
}

/// A warning without its numbers; names of entities, such as `12v3`, stay.
fn cause(line: &str) -> String {
    let is_entity = |word: &str| {
        word.split_once('v').is_some_and(|(a, b)| [a, b].iter().all(|n| !n.is_empty() && n.bytes().all(|c| c.is_ascii_digit())))
    };
    let is_number = |word: &str| word.bytes().any(|c| c.is_ascii_digit()) || word.contains("NaN") || word.contains("inf");
    let words = line.split(|c: char| c.is_whitespace() || "`(),:".contains(c)).filter(|word| !word.is_empty());
    let words: Vec<&str> = words.map(|word| if !is_entity(word) && is_number(word) { "#" } else { word }).collect();
    words.join(" ")
}
