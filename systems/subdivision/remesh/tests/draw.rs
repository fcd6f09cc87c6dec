//! Pictures of stages, for looking at: written where `SELVEDGE_DRAW` says.

use std::fmt::Write;
use std::path::PathBuf;

use glam::DVec3;

/// Triangles seen from above.
pub fn triangles(name: &str, points: &[DVec3], triangles: &[[u32; 3]], fill: impl Fn(usize) -> &'static str) {
    let Some(folder) = std::env::var_os("SELVEDGE_DRAW") else { return };
    let low = points.iter().fold(DVec3::INFINITY, |m, p| m.min(*p));
    let high = points.iter().fold(DVec3::NEG_INFINITY, |m, p| m.max(*p));
    let scale = 1000.0 / (high - low).truncate().max_element();
    let at = |p: DVec3| ((p.x - low.x) * scale + 10.0, (high.y - p.y) * scale + 10.0);
    let mut svg = String::from("<svg xmlns='http://www.w3.org/2000/svg' width='1020' height='1020'>\n");
    for (f, corners) in triangles.iter().enumerate() {
        let [a, b, c] = corners.map(|v| at(points[v as usize]));
        let style = format!("fill='{}' stroke='black' stroke-width='0.7'", fill(f));
        let _ = writeln!(svg, "<path d='M{} {} L{} {} L{} {}Z' {style}/>", a.0, a.1, b.0, b.1, c.0, c.1);
    }
    svg.push_str("</svg>\n");
    let _ = std::fs::write(PathBuf::from(folder).join(name), svg);
}
