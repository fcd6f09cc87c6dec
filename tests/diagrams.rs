//! Every kind of picture, drawn of surfaces that are known in closed form, and what must hold of it.
//!
//! The pictures are left in the temporary directory of the tests, so that a person can look at them.
#![cfg(feature = "diagram")]

use std::f64::consts::TAU;
use std::path::PathBuf;

use glam::{DVec2, DVec3};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use selvedge::diagram::camera::{Camera, Frame, Lens, View};
use selvedge::diagram::canvas::{Across, Canvas, Down, Ends, Stroke, TextStyle};
use selvedge::diagram::colour::{Colour, palette};
use selvedge::diagram::colourbar::with_colour_bar;
use selvedge::diagram::colourmap::ColourScale;
use selvedge::diagram::error::DiagramError;
use selvedge::diagram::grid::{Cell, Grid};
use selvedge::diagram::overlay::{Hidden, Overlay};
use selvedge::diagram::plot::{Guide, Ladder, Series};
use selvedge::diagram::scene::Scene;
use selvedge::diagram::shade::{Paint, Surface};
use selvedge::diagram::stencil::{self, LatticeBorder, Stencil};
use selvedge::diagram::units::{Quantity, fraction};
use selvedge_components::curve::Curve;
use selvedge_components::triangles::Triangles;

const FRAME: Frame = Frame::new(800, 600);

/// Writes a picture where a person can find it.
fn keep(name: &str, picture: &Canvas) {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.png"));
    picture.save(path).expect("the temporary directory of the tests can be written");
}

/// A grid of (n + 1) by (m + 1) points over [0, 1] x [0, 1], without normals.
fn patch(n: u32, m: u32, at: impl Fn(f64, f64) -> DVec3) -> Triangles {
    let mut mesh = Triangles::default();
    for j in 0..=m {
        for i in 0..=n {
            mesh.positions.push(at(f64::from(i) / f64::from(n), f64::from(j) / f64::from(m)));
        }
    }
    for j in 0..m {
        for i in 0..n {
            let a = j * (n + 1) + i;
            let (b, c, d) = (a + 1, a + n + 2, a + n + 1);
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

/// A closed torus of `n` by `m` quads, radii 1 and 0.42, with its own normals.
fn torus(n: u32, m: u32) -> Triangles {
    let mut mesh = Triangles::default();
    for i in 0..n {
        for j in 0..m {
            let (a, b) = (TAU * f64::from(i) / f64::from(n), TAU * f64::from(j) / f64::from(m));
            let out = DVec3::new(a.cos(), a.sin(), 0.0);
            let normal = b.cos() * out + b.sin() * DVec3::Z;
            mesh.positions.push(out + 0.42 * normal);
            mesh.normals.push(normal);
        }
    }
    let at = |i: u32, j: u32| (i % n) * m + j % m;
    for i in 0..n {
        for j in 0..m {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

fn bump(n: u32) -> Triangles {
    patch(n, n, |u, v| {
        let (x, y) = (2.0 * u - 1.0, 2.0 * v - 1.0);
        DVec3::new(x, y, 0.7 * (-6.0 * (x * x + y * y)).exp())
    })
}

fn saddle(n: u32) -> Triangles {
    patch(n, n, |u, v| {
        let (x, y) = (2.0 * u - 1.0, 2.0 * v - 1.0);
        DVec3::new(x, y, 0.5 * (x * x - y * y))
    })
}

/// The horizontal circle of the torus at angle `b` around its tube.
#[derive(Debug)]
struct Winding;

impl Curve for Winding {
    fn position(&self, u: f64) -> DVec3 {
        let (a, b) = (TAU * u, TAU * 5.0 * u);
        let out = DVec3::new(a.cos(), a.sin(), 0.0);
        out + 0.42 * (b.cos() * out + b.sin() * DVec3::Z)
    }

    fn closed(&self) -> bool {
        true
    }
}

/// How many pixels are not paper.
fn inked(picture: &Canvas) -> usize {
    picture.bytes().chunks_exact(4).filter(|pixel| **pixel != [255; 4]).count()
}

/// The columns and rows between which pixels are not paper.
fn inked_box(picture: &Canvas) -> [u32; 4] {
    let mut found = [u32::MAX, 0, u32::MAX, 0];
    for y in 0..picture.height() {
        for x in 0..picture.width() {
            if picture.pixel(x, y) != Some([255; 3]) {
                found = [found[0].min(x), found[1].max(x), found[2].min(y), found[3].max(y)];
            }
        }
    }
    found
}

#[test]
fn lit_surfaces_are_drawn_inside_their_margins_with_the_same_bytes_each_time() {
    let meshes = [("torus", torus(160, 64)), ("bump", bump(96)), ("saddle", saddle(64))];
    for (name, mesh) in &meshes {
        for view in [View::from_angles(-55.0, 32.0), View::from_angles(-55.0, 32.0).orthographic()] {
            let scene = Scene::of(Surface::new(mesh));
            let picture = scene.picture(&view, FRAME).expect("a finite mesh");
            let again = scene.picture(&view, FRAME).expect("a finite mesh");
            assert!(picture.png().expect("it encodes") == again.png().expect("it encodes"));
            let [left, right, top, bottom] = inked_box(&picture);
            // Six percent of 800 and of 600, less a pixel for what is partly covered.
            assert!(left >= 47 && right <= 752 && top >= 35 && bottom <= 564, "{name}: {:?}", inked_box(&picture));
            assert!(inked(&picture) > 800 * 600 / 8, "{name} is all but blank");
            keep(
                &format!("lit_{name}_{}", if view == view.orthographic() { "orthographic" } else { "perspective" }),
                &picture,
            );
        }
    }
}

#[test]
fn the_outline_of_a_sphere_is_a_circle_of_the_right_size() {
    let sphere = patch(96, 48, |u, v| {
        let (turn, tilt) = (TAU * u, 0.5 * TAU * v);
        DVec3::new(tilt.sin() * turn.cos(), tilt.sin() * turn.sin(), -tilt.cos())
    });
    let view = View::from_angles(20.0, 30.0).orthographic().with_margin(0.1);
    let picture = Scene::of(Surface::new(&sphere)).picture(&view, Frame::new(500, 500)).expect("a finite mesh");
    let area = std::f64::consts::PI * 200.0 * 200.0;
    // A pixel that is half covered counts as one: half the outline, on average.
    let rim = std::f64::consts::PI * 200.0;
    assert!((inked(&picture) as f64 - area).abs() < rim, "{} pixels for {area}", inked(&picture));
    keep("lit_sphere", &picture);
}

#[test]
fn the_back_of_a_sheet_differs_from_its_front() {
    let sheet = patch(8, 8, |u, v| DVec3::new(u, v, 0.0));
    let middle = |elevation: f64| {
        let view = View::from_angles(10.0, elevation);
        let picture = Scene::of(Surface::new(&sheet)).picture(&view, FRAME).expect("a finite mesh");
        picture.pixel(400, 300).expect("on the picture")
    };
    let ([fr, _, fb], [br, _, bb]) = (middle(80.0), middle(-80.0));
    assert!(f64::from(br) / f64::from(bb) > 1.15 * f64::from(fr) / f64::from(fb), "the back is warmer");
    let half_pipe = patch(64, 32, |u, v| {
        let turn = 0.2 + 2.6 * u;
        DVec3::new(turn.cos(), 1.6 * v, -turn.sin())
    });
    let picture = Scene::of(Surface::new(&half_pipe)).picture(&View::from_angles(-70.0, 24.0), FRAME);
    keep("lit_half_pipe", &picture.expect("a finite mesh"));
}

#[test]
fn colours_of_vertices_are_light_and_show_as_such() {
    let mut mesh = bump(64);
    mesh.colours = mesh.positions.iter().map(|p| [0.5 + 0.5 * p.x as f32, 0.2, 0.5 - 0.5 * p.x as f32]).collect();
    let scene = Scene::of(Surface::new(&mesh).painted(Paint::Vertices));
    let picture = scene.picture(&View::from_angles(-90.0, 50.0), FRAME).expect("a finite mesh");
    let [left, right, top, bottom] = inked_box(&picture);
    let y = (top + 3 * bottom) / 4;
    let (west, east) = (left + (right - left) / 8, right - (right - left) / 8);
    let [red, _, blue] = picture.pixel(west, y).expect("on the picture");
    assert!(blue > red);
    let [red, _, blue] = picture.pixel(east, y).expect("on the picture");
    assert!(red > blue);
    keep("vertex_colours", &picture);
}

/// A plane coloured by height above itself: values rise from left to right, and so do the colours.
#[test]
fn numbers_show_as_the_colours_of_their_scale_beside_a_bar() {
    let mesh = bump(160);
    let values: Vec<f64> = mesh.positions.iter().map(|p| 2.5e-5 * (-4.0 * (p.x * p.x + p.y * p.y)).exp()).collect();
    let scale = ColourScale::of(&values).expect("finite values").titled("distance");
    let surface = Surface::new(&mesh).painted(Paint::Values(&values, &scale));
    let picture = Scene::of(surface).picture(&View::from_angles(-60.0, 38.0), FRAME).expect("a finite mesh");
    let barred = with_colour_bar(&picture, &scale, 22.0).expect("a small picture");
    assert!(barred.width() > picture.width() && barred.height() == picture.height());
    keep("values_bump", &barred);

    let mesh = saddle(128);
    let values: Vec<f64> = mesh.positions.iter().map(|p| 3.2e-3 * p.z).collect();
    let scale = ColourScale::about_zero(&values).expect("finite values").titled("signed distance");
    assert_eq!(scale.low(), -scale.high());
    let surface = Surface::new(&mesh).painted(Paint::Values(&values, &scale));
    let picture = Scene::of(surface).picture(&View::from_angles(-60.0, 38.0), FRAME).expect("a finite mesh");
    keep("values_saddle", &with_colour_bar(&picture, &scale, 22.0).expect("a small picture"));

    let mesh = torus(200, 80);
    let values: Vec<f64> = mesh.positions.iter().map(|p| 1e-9 * 10.0_f64.powf(4.0 * (p.z + 0.42) / 0.84)).collect();
    let scale = ColourScale::of(&values).and_then(ColourScale::logarithmic).expect("positive values");
    let scale = scale.titled("error");
    let surface = Surface::new(&mesh).painted(Paint::Values(&values, &scale));
    let picture = Scene::of(surface).picture(&View::from_angles(-60.0, 38.0), FRAME).expect("a finite mesh");
    keep("values_torus_log", &with_colour_bar(&picture, &scale, 22.0).expect("a small picture"));
}

#[test]
fn missing_values_are_grey_and_do_no_harm() {
    let mesh = bump(64);
    let values: Vec<f64> = mesh.positions.iter().map(|p| if p.x > 0.3 { f64::NAN } else { p.z }).collect();
    let scale = ColourScale::of(&values).expect("some are finite");
    let surface = Surface::new(&mesh).painted(Paint::Values(&values, &scale));
    let picture = Scene::of(surface).picture(&View::from_angles(-90.0, 60.0), FRAME).expect("a finite mesh");
    let [_, right, top, bottom] = inked_box(&picture);
    let [red, green, blue] = picture.pixel(right - 60, (top + bottom) / 2).expect("on the picture");
    assert!(red.abs_diff(green) < 4 && green.abs_diff(blue) < 4);
    keep("values_missing", &picture);
}

#[test]
fn a_cage_and_a_curve_are_hidden_where_the_surface_hides_them() {
    let (mesh, coarse) = (torus(200, 80), torus(14, 7));
    let cage = Overlay::cage(&coarse, palette::BLUE, FRAME.width).expect("indices in range");
    let curve = Overlay::curve(&Winding, 800, Stroke::new(palette::RED, 4.0)).with_hidden(Hidden::Faint);
    let view = View::from_angles(-55.0, 38.0);
    let scene = Scene::of(Surface::new(&mesh)).with(cage);
    keep("cage_torus", &scene.picture(&view, FRAME).expect("a finite mesh"));
    keep("curve_torus", &Scene::of(Surface::new(&mesh)).with([curve]).picture(&view, FRAME).expect("a finite mesh"));
    let faces =
        Scene::of(Surface::new(&coarse).faceted())
            .with([Overlay::wireframe(&coarse, Stroke::new(palette::INK, 1.2)).expect("indices in range")]);
    keep("wire_torus", &faces.picture(&view, FRAME).expect("a finite mesh"));
}

/// A line through a sphere: outside it is drawn, inside it is not.
#[test]
fn a_line_through_a_ball_shows_outside_it_only() {
    let ball = patch(128, 64, |u, v| {
        let (turn, tilt) = (TAU * u, 0.5 * TAU * v);
        0.5 * DVec3::new(tilt.sin() * turn.cos(), tilt.sin() * turn.sin(), -tilt.cos())
    });
    let rod = vec![vec![DVec3::new(-1.0, 0.0, 0.0), DVec3::new(1.0, 0.0, 0.0)]];
    let stroke = Stroke::new(Colour::hex(0xff_00_00), 3.0);
    let red_pixels = |hidden: Hidden| {
        let line = Overlay::lines(rod.clone(), stroke).with_hidden(hidden);
        let scene = Scene::of(Surface::new(&ball)).with([line]);
        let view = View::from_angles(-90.0, 0.0).orthographic().with_margin(0.0);
        let picture = scene.picture(&view, Frame::new(600, 400)).expect("a finite mesh");
        (0..600).map(|x| picture.pixel(x, 200) == Some([255, 0, 0])).collect::<Vec<bool>>()
    };
    let seen = red_pixels(Hidden::Omit);
    // The ball covers the middle half of the rod: pixels 150 to 450.
    for (x, red) in seen.into_iter().enumerate().filter(|(x, _)| x.abs_diff(150) > 4 && x.abs_diff(450) > 4) {
        assert_eq!(red, !(150..450).contains(&x), "pixel {x}");
    }
    assert!(red_pixels(Hidden::Show).into_iter().all(|red| red));
}

#[test]
fn a_border_is_found_and_drawn_whole() {
    let mesh = saddle(12);
    let border = Overlay::border(&mesh, Stroke::new(palette::RED, 5.0)).expect("indices in range");
    assert_eq!(border.chains.len(), 1, "one border");
    assert_eq!(border.chains[0].len(), 49, "48 edges, closed");
    assert_eq!(border.chains[0].first(), border.chains[0].last());
    let fine = saddle(96);
    let cage = Overlay::cage(&mesh, palette::BLUE, FRAME.width).expect("indices in range");
    let scene = Scene::of(Surface::new(&fine)).with(cage).with([border]);
    keep("border_saddle", &scene.picture(&View::from_angles(-60.0, 30.0), FRAME).expect("a finite mesh"));
    assert!(Overlay::border(&torus(9, 5), Stroke::new(palette::RED, 1.0)).expect("in range").chains.is_empty());
}

#[test]
fn what_cannot_be_drawn_is_refused_with_its_place() {
    let view = View::from_angles(-60.0, 30.0);
    let camera = Camera::fit([DVec3::ZERO, DVec3::ONE], &view, FRAME).expect("two points");
    let mut mesh = saddle(4);
    mesh.positions[7].y = f64::NAN;
    let picture = Scene::of(Surface::new(&mesh)).draw(&camera);
    assert!(matches!(picture, Err(DiagramError::NotFinite { vertex: 7, .. })));
    let mut mesh = saddle(4);
    mesh.triangles[3][1] = 25;
    let picture = Scene::of(Surface::new(&mesh)).draw(&camera);
    assert!(matches!(picture, Err(DiagramError::IndexOutOfRange { triangle: 3, vertex: 25, count: 25 })));
    assert!(matches!(
        Overlay::wireframe(&mesh, Stroke::new(palette::INK, 1.0)),
        Err(DiagramError::IndexOutOfRange { .. })
    ));
    let mesh = saddle(4);
    let picture = Scene::of(Surface::new(&mesh).painted(Paint::Vertices)).draw(&camera);
    assert!(matches!(picture, Err(DiagramError::Count { what: "colours", found: 0, expected: 25 })));
    let scale = ColourScale::new(0.0, 1.0).expect("ascends");
    let picture = Scene::of(Surface::new(&mesh).painted(Paint::Values(&[1.0], &scale))).draw(&camera);
    assert!(matches!(picture, Err(DiagramError::Count { what: "values", found: 1, expected: 25 })));
    let line = Overlay::lines(vec![vec![DVec3::ZERO, DVec3::INFINITY]], Stroke::new(palette::INK, 1.0));
    assert!(matches!(Scene::default().with([line]).draw(&camera), Err(DiagramError::NotFinite { .. })));
    assert!(matches!(Scene::default().picture(&view, FRAME), Err(DiagramError::Nothing { .. })));
    let huge = Scene::of(Surface::new(&mesh)).picture(&view, Frame::new(u32::MAX, 3));
    assert!(matches!(huge, Err(DiagramError::Size { .. })));
}

#[test]
fn a_page_of_any_size_takes_any_numbers() {
    assert!(matches!(Canvas::new(0, 9, palette::PAPER), Err(DiagramError::Size { .. })));
    assert!(matches!(Canvas::new(1 << 14, 1 << 14, palette::PAPER), Err(DiagramError::Size { .. })));
    let odd = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN_POSITIVE, -1e9, 0.0, 1e9, 3.7];
    for size in [1, 2, 50] {
        let mut page = Canvas::new(size, size, palette::PAPER).expect("a small page");
        for a in odd {
            for b in odd {
                let (p, q) = (DVec2::new(a, b), DVec2::new(b, -a));
                let stroke = Stroke::new(palette::INK, a).dashed(b, a);
                page.line(p, q, &stroke);
                page.line(p, q, &Stroke::new(palette::INK, 2.0).dashed(a, b));
                page.polyline(&[p, q, DVec2::ONE], Ends::Closed, &Stroke::new(palette::INK, 2.0));
                page.polygon(&[p, q, DVec2::ONE, DVec2::new(5.0, 40.0)], palette::BLUE);
                page.disc(p, b, palette::RED);
                page.rectangle(p, q, palette::RED);
                page.round_rectangle(p, q, a, palette::RED);
                let style = TextStyle::new(a, palette::INK).rotated(b).with_halo(palette::PAPER, b);
                page.text("µ", p, &style);
                page.text("µ", DVec2::ONE, &style);
            }
        }
        assert!(page.png().is_ok());
    }
}

#[test]
fn trimming_leaves_what_is_drawn_and_the_margin_asked_for() {
    let mut page = Canvas::new(90, 70, palette::PAPER).expect("a small page");
    page.rectangle(DVec2::new(20.0, 30.0), DVec2::new(50.0, 45.0), palette::BLUE);
    let cut = page.trimmed(4).expect("it is smaller");
    assert_eq!((cut.width(), cut.height()), (38, 23));
    assert_eq!(inked_box(&cut), [4, 33, 4, 18]);
    assert_eq!(page.trimmed(u32::MAX).expect("it is as large"), page);
    let blank = Canvas::new(9, 9, palette::PAPER).expect("a small page");
    assert_eq!(blank.trimmed(0).expect("it is as large"), blank);
}

#[test]
fn a_file_that_cannot_be_written_is_named() {
    let page = Canvas::new(3, 3, palette::PAPER).expect("a small page");
    let why = page.save("/nowhere/at/all.png").expect_err("there is no such directory");
    assert!(matches!(why, DiagramError::Write { .. }) && why.to_string().contains("/nowhere/at/all.png"));
}

#[test]
fn letters_stand_where_they_are_anchored() {
    let mut page = Canvas::new(420, 260, palette::PAPER).expect("a small page");
    let corners = [
        (Across::Left, Down::Top, "left, top"),
        (Across::Right, Down::Top, "right, top"),
        (Across::Left, Down::Baseline, "left, baseline"),
        (Across::Right, Down::Baseline, "right, baseline"),
    ];
    for (across, down, text) in corners {
        let at = DVec2::new(
            if across == Across::Left { 240.0 } else { 200.0 },
            if down == Down::Top { 145.0 } else { 115.0 },
        );
        page.line(DVec2::new(40.0, at.y), DVec2::new(400.0, at.y), &Stroke::new(palette::MIST, 1.0));
        page.text(text, at, &TextStyle::new(22.0, palette::INK).anchored(across, down));
    }
    let samples = ["ratio 4.87 × 10⁻⁵ µm", "α β γ θ λ φ → ∞ − – ±3°"];
    for (text, y) in samples.into_iter().zip([30.0, 230.0]) {
        page.text(
            text,
            DVec2::new(210.0, y),
            &TextStyle::new(26.0, palette::BLUE).anchored(Across::Middle, Down::Middle),
        );
    }
    page.text(
        "turned",
        DVec2::new(30.0, 130.0),
        &TextStyle::new(20.0, palette::RED).anchored(Across::Middle, Down::Middle).rotated(90.0),
    );
    keep("text", &page);
    // "H" fills the height of capitals exactly: what is anchored in the middle spreads evenly.
    let mut page = Canvas::new(101, 101, palette::PAPER).expect("a small page");
    page.text("H", DVec2::splat(50.5), &TextStyle::new(50.0, palette::INK).anchored(Across::Middle, Down::Middle));
    let [left, right, top, bottom] = inked_box(&page);
    assert!((left + right).abs_diff(100) <= 1 && (top + bottom).abs_diff(100) <= 1, "{:?}", inked_box(&page));
}

fn ladder() -> Ladder {
    let lsq = [1.232e-3, 1.65e-4, 1.85e-5, 3.4e-6, 6.9e-7, 1.4e-7];
    let tail = [3.3e-8, 6.8e-9, 1.4e-9, 2.9e-10, 5.9e-11, 1.2e-11, 2.5e-12, 5.0e-13, 1.0e-13, 2.1e-14, 5.0e-15];
    let quasi = [1.3e-2, 2.45e-3, 3.67e-4, 5.4e-5, 7.9e-6, 1.34e-6];
    let single = [1.232e-3, 1.65e-4, 1.85e-5, 3.4e-6, 6.7e-7, 1.4e-7];
    Ladder {
        title: "Sphere octant, cone(1,2)".into(),
        series: vec![
            Series::from_levels("least squares", lsq.into_iter().chain(tail)),
            Series::from_levels("quasi-interpolation", quasi),
            Series::from_levels("least squares, stored in f32", single),
        ],
        guides: vec![Guide::new(4.87, (6.0, 4e-7), 15.0)],
        ..Ladder::default()
    }
}

#[test]
fn a_ladder_over_seventeen_levels_reads() {
    let picture = ladder().draw().expect("positive values");
    assert!(inked(&picture) > 5000);
    assert!(picture == ladder().draw().expect("positive values"));
    keep("ladder", &picture);
    let short = Ladder {
        title: String::new(),
        series: vec![
            Series::from_levels("cone(1,1)", [36e-3, 6.7e-3, 1.05e-3, 158e-6, 23e-6, 3.9e-6]),
            Series::from_levels("cone(1,2)", [13e-3, 2.45e-3, 367e-6, 54e-6, 7.9e-6, 1.34e-6]),
            Series::from_levels("tri4", [2.3e-3, 119e-6, 9e-6, 0.72e-6, 0.032e-6, 0.003e-6]),
            Series::from_levels("without details at the border", [48e-3, 12.5e-3, 3.1e-3, 762e-6, 190e-6, 47e-6]),
        ],
        guides: vec![Guide::new(4.0, (0.0, 6e-3), 5.0), Guide::new(13.0, (1.0, 3e-5), 4.0)],
        width: 900,
        height: 640,
        ..Ladder::default()
    };
    keep("ladder_short", &short.draw().expect("positive values"));
}

#[test]
fn values_that_have_no_logarithm_leave_gaps() {
    let values = [1e-3, f64::NAN, 0.0, -1.0, f64::INFINITY, 1e-6];
    let plot =
        |values: &[f64]| Ladder { series: vec![Series::from_levels("a", values.iter().copied())], ..Ladder::default() };
    assert!(plot(&values).draw().is_ok());
    assert!(plot(&[1e-5]).draw().is_ok());
    assert!(matches!(plot(&[0.0, f64::NAN]).draw(), Err(DiagramError::Nothing { .. })));
    assert!(matches!(Ladder::default().draw(), Err(DiagramError::Nothing { .. })));
    let odd = Guide::new(f64::NAN, (0.0, -1.0), f64::INFINITY);
    assert!(Ladder { guides: vec![odd], width: 3, height: 2, ..plot(&values) }.draw().is_ok());
    assert!(plot(&[f64::MIN_POSITIVE, f64::MAX]).draw().is_ok());
}

#[test]
fn six_error_maps_make_a_figure() {
    let mesh = bump(120);
    let frame = Frame::new(520, 400);
    let names = ["initial surface", "level 0", "level 1", "level 2", "level 3", "level 4"];
    let sizes = [1.12e-1, 1.23e-3, 1.65e-4, 1.85e-5, 3.4e-6, 6.9e-7];
    let cells: Vec<Cell> = names
        .iter()
        .zip(sizes)
        .zip(1..)
        .map(|((name, size), k)| {
            let wave = |p: &DVec3| 0.5 + 0.5 * (f64::from(k) * 2.5 * p.x).sin() * (f64::from(k) * 2.2 * p.y).cos();
            let values: Vec<f64> = mesh.positions.iter().map(|p| size * wave(p)).collect();
            let scale = ColourScale::new(0.0, size).expect("ascends");
            let surface = Surface::new(&mesh).painted(Paint::Values(&values, &scale));
            let picture = Scene::of(surface).picture(&View::from_angles(-60.0, 40.0), frame).expect("a finite mesh");
            let barred = with_colour_bar(&picture, &scale, 20.0).expect("a small picture");
            Cell::new(barred, format!("{name}: largest error {}", Quantity::Length.label(size, 3)))
        })
        .collect();
    let figure = Grid::new(3, 24.0).lettered().compose(&cells).expect("a small figure");
    assert!(figure.width() > 3 * 520 && figure.height() > 800);
    keep("figure_errors", &figure);
}

/// The share of a neighbour in Loop's rule for a vertex.
fn neighbour_weight(k: usize) -> f64 {
    let share = 3.0 / 8.0 + (TAU / k as f64).cos() / 4.0;
    (5.0 / 8.0 - share * share) / k as f64
}

#[test]
fn stencils_of_all_valences_are_drawn_with_their_weights() {
    let vertex = |k: usize| {
        let weight = neighbour_weight(k);
        let centre = fraction(1.0 - k as f64 * weight);
        Stencil::even_ring(k, &centre, &fraction(weight), format!("k = {k}"))
    };
    let all: Vec<Stencil> = (3..=12).map(vertex).collect();
    let figure = stencil::draw_all(&all, 5, 400).expect("a small figure");
    assert!(inked(&figure) > 10_000 && figure == stencil::draw_all(&all, 5, 400).expect("a small figure"));
    keep("stencils_vertex", &figure);

    let corner: Vec<String> = ["1/8", "3/8", "−1/12", "1/8"].map(String::from).to_vec();
    let lattice = [
        (-1, 0, ""),
        (0, 0, "1"),
        (1, 0, ""),
        (-1, 1, "−1"),
        (0, 1, "−1"),
        (-2, 1, ""),
        (1, 1, ""),
        (-1, 2, "1"),
        (-2, 2, ""),
        (0, 2, ""),
    ];
    let mixed = [
        Stencil::edge(["3/8", "3/8"], ["1/8", "1/8"], "edge"),
        Stencil::even_ring(6, "10/16", "1/16", "vertex, k = 6"),
        Stencil::half_ring("1/4", &["1/8".into(), String::new(), String::new(), "1/8".into()], 180.0, "smooth border"),
        Stencil::half_ring("3/4 − γ", &corner, 90.0, "convex corner"),
        Stencil::half_ring("3/8", &corner, 270.0, "concave corner"),
        Stencil::lattice(&lattice, (0, 0), LatticeBorder::RowZero, "border detail, quadratic precision"),
    ];
    keep("stencils_mixed", &stencil::draw_all(&mixed, 3, 400).expect("a small figure"));
    for k in [3, 12, 40] {
        keep(&format!("stencil_{k}"), &vertex(k).draw(400).expect("a small picture"));
    }
}

#[test]
fn a_stencil_that_is_none_is_refused() {
    let mut odd = Stencil::even_ring(5, "1", "2", "");
    odd.triangles.push([0, 1, 9]);
    assert!(matches!(odd.draw(100), Err(DiagramError::IndexOutOfRange { vertex: 9, .. })));
    let mut odd = Stencil::even_ring(5, "1", "2", "");
    odd.knots[2].at.x = f64::NAN;
    assert!(matches!(odd.draw(100), Err(DiagramError::NotFinite { vertex: 2, .. })));
    for k in 0..4 {
        assert!(Stencil::even_ring(k, "1", "2", "").draw(60).is_ok());
        assert!(Stencil::half_ring("1", &vec!["1".into(); k], f64::MAX, "").draw(1).is_ok());
    }
    assert!(Stencil::lattice(&[], (i32::MAX, i32::MIN), LatticeBorder::None, "").draw(9).is_err());
    assert!(Stencil::lattice(&[(i32::MAX, i32::MAX, "1")], (0, 0), LatticeBorder::RowZero, "").draw(9).is_ok());
}

/// Nothing in the drawing limits how many triangles there are.
#[test]
fn a_million_triangles_are_drawn() {
    let mesh = torus(1000, 500);
    assert_eq!(mesh.triangles.len(), 1_000_000);
    let picture = Scene::of(Surface::new(&mesh)).picture(&View::from_angles(-55.0, 35.0), Frame::new(600, 450));
    keep("lit_million", &picture.expect("a finite mesh"));
}

/// Numbers of any size and kind, ordinary ones most often.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![90 => -2.0..2.0_f64, 1 => prop::num::f64::ANY, 4 => Just(0.0)]
}

fn point() -> impl Strategy<Value = DVec3> {
    (number(), number(), number()).prop_map(|(x, y, z)| DVec3::new(x, y, z))
}

fn lens() -> impl Strategy<Value = Lens> {
    prop_oneof![Just(Lens::Orthographic), number().prop_map(|x| Lens::Perspective { field: 90.0 * x })]
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 1000,
        rng_seed: RngSeed::Fixed(20_260_117),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// Whatever comes in, a picture or an error comes out, and the error is about what is wrong.
    #[test]
    fn any_soup_of_triangles_is_drawn_or_refused(
        positions in prop_oneof![9 => prop::collection::vec(point(), 9), 1 => prop::collection::vec(point(), 0..9)],
        normals in prop_oneof![prop::collection::vec(point(), 9), Just(Vec::new())],
        triangles in prop::collection::vec([0..9_u32, 0..9_u32, 0..9_u32], 0..12),
        from in point(),
        up in point(),
        lens in lens(),
        margin in number(),
        size in [0..40_u32, 0..40_u32, 0..6_u32],
    ) {
        let mesh = Triangles { positions, normals, triangles, ..Triangles::default() };
        let count = mesh.positions.len();
        let values: Vec<f64> = mesh.positions.iter().map(|p| p.x).collect();
        let scale = ColourScale::new(-1.0, 1.0).expect("ascends");
        let painted = Surface::new(&mesh).painted(Paint::Values(&values, &scale));
        let lines = Overlay::lines(vec![mesh.positions.clone()], Stroke::new(palette::RED, 2.0));
        let dots = Overlay::dots(mesh.positions.clone(), 2.0, palette::BLUE);
        let overlays = [lines.with_hidden(Hidden::Faint), dots];
        let frame = Frame { width: size[0], height: size[1], samples: size[2] };
        let view = View { from, up, lens, margin };
        for surface in [Surface::new(&mesh), painted.faceted()] {
            match Scene::of(surface).with(overlays.clone()).picture(&view, frame) {
                Ok(picture) => {
                    prop_assert_eq!((picture.width(), picture.height()), (size[0], size[1]));
                    prop_assert!(mesh.positions.iter().all(|p| p.is_finite()));
                }
                Err(DiagramError::NotFinite { .. }) => {
                    prop_assert!(mesh.positions.iter().any(|p| !p.is_finite()));
                }
                Err(DiagramError::IndexOutOfRange { triangle, vertex, .. }) => {
                    prop_assert!(mesh.triangles[triangle].contains(&vertex) && vertex as usize >= count);
                }
                Err(DiagramError::Count { .. }) => prop_assert!(!mesh.normals.is_empty() && mesh.normals.len() != count),
                Err(DiagramError::Nothing { .. }) => prop_assert_eq!(count, 0),
                Err(DiagramError::Size { .. }) => prop_assert!(size[0] == 0 || size[1] == 0),
                Err(DiagramError::Direction { .. }) => prop_assert!(from.try_normalize().is_none()),
                Err(DiagramError::FieldOfView { degrees }) => prop_assert!(!(degrees > 0.0 && degrees < 180.0)),
                Err(other) => prop_assert!(false, "{}", other),
            }
        }
    }
}

/// A face fills the pixels that it covers, seen along the mean normal with y up, and nothing else.
#[test]
fn a_domain_diagram_is_seen_along_the_mean_normal() {
    use selvedge::diagram::colour::palette;
    use selvedge::diagram::domain::Domain;
    // A unit square in a tilted plane, cut by its diagonal.
    let tilt = glam::DQuat::from_rotation_x(0.7);
    let [a, b, c, d] = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| tilt * DVec3::new(x, y, 0.0));
    let faces = [[a, b, c], [a, c, d]];
    let mut page = Domain::new(&faces, 200).expect("a page");
    let at = |page: &Domain, p: DVec3| page.pixel(p).expect("a place in front");
    let (across, up) = (at(&page, b) - at(&page, a), at(&page, d) - at(&page, a));
    assert!((across.length() - up.length()).abs() < 1e-9, "not foreshortened: {across} and {up}");
    assert!(across.x > 0.0 && across.y.abs() < 1e-9 && up.y < 0.0, "y is up: {across} and {up}");
    page.fill(&faces[..1], palette::RED);
    let inside = |page: &Domain, weights: [f64; 3], face: [DVec3; 3]| {
        let p = at(page, face[0] * weights[0] + face[1] * weights[1] + face[2] * weights[2]);
        page.canvas().pixel(p.x as u32, p.y as u32)
    };
    assert_eq!(inside(&page, [0.3, 0.4, 0.3], faces[0]), Some(palette::RED.rgb));
    assert_eq!(inside(&page, [0.3, 0.3, 0.4], faces[1]), Some(palette::PAPER.rgb));
    assert!(Domain::new(&[[a, a, a]], 200).is_err(), "no normal");
}
