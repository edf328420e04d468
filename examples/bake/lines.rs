//! The report as lines to read.
#![expect(clippy::print_stdout, reason = "a program speaks on its terminal")]

use serde_json::Value;

/// What is wrong with the maps of a cloth.
pub fn maps(found: &Value) {
    let name = found["cloth"].as_str().unwrap_or_default();
    for map in ["max_distance", "backstop_distance", "drive"] {
        match found[map].as_array().map(Vec::as_slice) {
            None => {}
            Some([]) => println!("{name}: the map of {map} is sound"),
            Some(list) => list.iter().for_each(|line| println!("{name}: {map}: {}", line.as_str().unwrap_or_default())),
        }
    }
}

/// What a clip did to a cloth.
pub fn clip(found: &Value) {
    let text = |value: &Value| value.as_str().unwrap_or_default().to_string();
    let count = |value: &Value| value.as_u64().unwrap_or_default();
    let number = |value: &Value| value.as_f64().unwrap_or_default();
    println!("{}, {}, {} frames", text(&found["cloth"]), text(&found["clip"]), count(&found["frames"]));
    let deep = |what: &str, deep: &Value| match count(&deep["vertices"]) {
        0 => println!("    {what} is in no body"),
        vertices => println!(
            "    {what} is in bodies: {vertices} free vertices ({:.1} %), {:.0} mm deep at worst (frame {}, vertex {})",
            100.0 * number(&deep["share"]),
            1.0e3 * number(&deep["worst_depth"]),
            count(&deep["worst_frame"]),
            count(&deep["worst_vertex"]),
        ),
    };
    deep("the skin", &found["skin_in_bodies"]);
    let stretched = &found["skin_stretched"];
    match count(&stretched["edges"]) {
        0 => println!("    the skin stretches no edge by more than {:.0} %", 100.0 * number(&stretched["strain_limit"])),
        edges => println!(
            "    the skin stretches {edges} edges ({:.1} %) by more than {:.0} %, to {:.2} times their length at worst (frame {}, vertices {} and {})",
            100.0 * number(&stretched["share"]),
            100.0 * number(&stretched["strain_limit"]),
            number(&stretched["worst_ratio"]),
            count(&stretched["worst_frame"]),
            count(&stretched["worst_vertices"][0]),
            count(&stretched["worst_vertices"][1]),
        ),
    }
    deep("the cloth", &found["cloth_in_bodies"]);
    println!(
        "    the cloth crosses something in {} frames, in {} places at most; {} frames are held; it is taken back {} times; its worst edge is {:.2} of its length",
        count(&found["crossing_frames"]),
        count(&found["most_crossings"]),
        count(&found["held_frames"]),
        count(&found["recoveries"]),
        number(&found["worst_edge"]),
    );
}
