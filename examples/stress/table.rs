//! What was measured, as numbers.

use serde_json::Value;

/// Sorts the times and takes one at a percentile.
pub fn percentile(times: &mut [f64], p: usize) -> f64 {
    times.sort_by(f64::total_cmp);
    times.get((times.len() * p / 100).min(times.len().saturating_sub(1))).copied().unwrap_or_default()
}

/// One line of JSON, or a table.
pub fn print(line: &Value, json: bool) {
    if json {
        println!("{line}");
    } else if let Some(table) = line.as_object() {
        table.iter().for_each(|(name, value)| println!("{name:>20}  {value}"));
    }
}
