//! Where in a RON text an error is, and what may have been meant.

use ron::error::SpannedError;

/// A place in a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Place {
    /// From 1.
    pub line: usize,
    /// From 1.
    pub column: usize,
    /// The field it is in, such as `solver.substep_rate`; empty outside of any.
    pub field: String,
}

impl Place {
    /// Where an error is: at a field that is unknown or given twice, else at what could not be read.
    pub(super) fn of(text: &str, error: &SpannedError) -> Self {
        let named = match &error.code {
            ron::Error::NoSuchStructField { found, .. } => Some(found.as_str()),
            ron::Error::DuplicateStructField { field, .. } => Some(*field),
            _ => None,
        };
        let (start, end) = (&error.span.start, &error.span.end);
        let mut path = Path::default();
        path.follow(
            text,
            offset(
                text,
                if named.is_some() { end.line } else { start.line },
                if named.is_some() { end.col } else { start.col },
            ),
        );
        let mut names: Vec<&str> = path.fields.iter().flatten().copied().collect();
        let at = match (named, path.word) {
            (Some(name), Some((word, at))) if word == name => {
                if path.fields.last().copied().flatten() != Some(name) {
                    names.push(name);
                }
                Some(at)
            }
            _ => None,
        };
        let (line, column) = at.map_or((start.line, start.col), |at| position(text, at));
        Self { line, column, field: names.join(".") }
    }
}

/// What leads to a place in a text: a name for each bracket that is open, if the place is in a named field there.
#[derive(Default)]
struct Path<'a> {
    fields: Vec<Option<&'a str>>,
    /// The last word before the place, and where it begins `[B]`.
    word: Option<(&'a str, usize)>,
}

impl<'a> Path<'a> {
    /// Reads up to byte `end`, past strings and comments.
    fn follow(&mut self, text: &'a str, end: usize) {
        let mut chars = text.char_indices().peekable();
        while let Some((at, c)) = chars.next() {
            if at >= end {
                return;
            }
            match c {
                '"' => {
                    while let Some((_, c)) = chars.next() {
                        match c {
                            '\\' => drop(chars.next()),
                            '"' => break,
                            _ => {}
                        }
                    }
                }
                '/' if chars.peek().is_some_and(|(_, next)| *next == '/') => {
                    chars.by_ref().find(|(_, c)| *c == '\n');
                }
                '/' if chars.peek().is_some_and(|(_, next)| *next == '*') => {
                    let mut last = ' ';
                    chars.next();
                    chars.by_ref().find(|(_, c)| core::mem::replace(&mut last, *c) == '*' && *c == '/');
                }
                '(' | '[' | '{' => self.fields.push(None),
                ')' | ']' | '}' => drop(self.fields.pop()),
                ',' => self.name(None),
                ':' => self.name(self.word.map(|(word, _)| word)),
                _ if c.is_alphabetic() || c == '_' => {
                    let mut to = at + c.len_utf8();
                    while let Some((next, c)) = chars.next_if(|(_, c)| c.is_alphanumeric() || *c == '_') {
                        to = next + c.len_utf8();
                    }
                    self.word = Some((&text[at..to], at));
                }
                _ => {}
            }
        }
    }

    fn name(&mut self, name: Option<&'a str>) {
        if let Some(field) = self.fields.last_mut() {
            *field = name;
        }
    }
}

/// The byte at which a line and column (from 1) begin.
fn offset(text: &str, line: usize, column: usize) -> usize {
    let start: usize = text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
    let rest = text.get(start..).unwrap_or("");
    start + rest.char_indices().nth(column.saturating_sub(1)).map_or(rest.len(), |(at, _)| at)
}

/// The line and column (from 1) of a byte.
fn position(text: &str, at: usize) -> (usize, usize) {
    let before = text.get(..at).unwrap_or(text);
    let line = before.rsplit('\n').next().unwrap_or(before);
    (before.matches('\n').count() + 1, line.chars().count() + 1)
}

/// The name that is nearest to `word`, if any is near: fewer than half of its letters differ.
pub(super) fn nearest<'a>(word: &str, names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let near = names.map(|name| (distance(word, name), name)).min_by_key(|(distance, _)| *distance)?;
    (2 * near.0 < word.chars().count().max(3)).then_some(near.1)
}

/// Letters to insert, delete or replace to come from one word to another (Levenshtein 1966).
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, from) in a.chars().enumerate() {
        let mut diagonal = core::mem::replace(&mut row[0], i + 1);
        for (j, to) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(from != *to);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distance_counts_insertions_deletions_and_replacements() {
        assert_eq!(distance("kitten", "sitting"), 3);
        assert_eq!(distance("", "drag"), 4);
        assert_eq!(distance("drag", "drag"), 0);
    }

    #[test]
    fn what_is_nearest_is_near_or_nothing() {
        let names = || ["density", "drag", "damping"].into_iter();
        assert_eq!(nearest("densty", names()), Some("density"));
        assert_eq!(nearest("dragg", names()), Some("drag"));
        assert_eq!(nearest("wavelength", names()), None);
    }

    #[test]
    fn a_path_skips_strings_and_comments_and_leaves_closed_brackets() {
        let text = r#"(a: (x: "b: (", /* c: ( */ y: 1), d: (e: 2)) // f: ("#;
        let path = |end: usize| {
            let mut path = Path::default();
            path.follow(text, end);
            path.fields.into_iter().flatten().collect::<Vec<_>>().join(".")
        };
        assert_eq!(path(text.find("1)").expect("there")), "a.y");
        assert_eq!(path(text.find("2)").expect("there")), "d.e");
        assert_eq!(path(text.len()), "");
    }
}
