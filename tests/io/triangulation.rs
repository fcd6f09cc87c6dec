use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::Path;

use glam::DVec3;
use proptest::prelude::*;
use selvedge::io::{Cage, Limits, Polygons, obj, triangulate};
use selvedge_components::mesh::{Connectivity, FaceId, VertexId};

fn polygon(corners: &[DVec3]) -> Polygons {
    let mut polygons = Polygons::new(corners.to_vec());
    polygons.push(&(0..corners.len() as u32).collect::<Vec<_>>()).unwrap();
    polygons
}

/// Signed area of a closed outline in the plane z = 0 (Green).
fn area(outline: &[DVec3]) -> f64 {
    let next = outline.iter().cycle().skip(1);
    outline.iter().zip(next).map(|(a, b)| 0.5 * (a.x * b.y - a.y * b.x)).sum()
}

fn corners_of(triangle: [u32; 3], polygons: &Polygons) -> [DVec3; 3] {
    triangle.map(|v| polygons.positions[v as usize])
}

/// A polygon cut is a disc: one border, which is the polygon itself, and no vertex inside.
fn is_disc_of(triangles: &[[u32; 3]], sides: usize) -> Result<(), TestCaseError> {
    prop_assert_eq!(triangles.len(), sides - 2);
    let mesh = Connectivity::new(sides, triangles).map_err(|faults| TestCaseError::fail(format!("{faults:?}")))?;
    prop_assert_eq!(mesh.border_loops(), [(0..sides).map(VertexId::new).collect::<Vec<_>>()]);
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 500, ..ProptestConfig::default() })]

    /// Star-shaped polygons of up to 64 sides, most of them far from convex: no triangle is turned
    /// over, and the areas add up, so the triangles fill the polygon once and nothing else.
    #[test]
    fn a_polygon_that_is_not_convex_is_cut_inside_its_outline(radii in prop::collection::vec(0.05_f64..1.0, 4..65)) {
        let n = radii.len();
        let step = TAU / n as f64;
        let at = |(i, r): (usize, &f64)| DVec3::new(r * (i as f64 * step).cos(), r * (i as f64 * step).sin(), 0.0);
        let outline: Vec<DVec3> = radii.iter().enumerate().map(at).collect();
        let polygons = polygon(&outline);
        let cut = triangulate(&polygons);
        is_disc_of(&cut.triangles, n)?;
        let areas: Vec<f64> = cut.triangles.iter().map(|&t| area(&corners_of(t, &polygons))).collect();
        prop_assert!(areas.iter().all(|&a| a > 0.0), "{areas:?}");
        let (sum, whole) = (areas.iter().sum::<f64>(), area(&outline));
        prop_assert!((sum - whole).abs() < 1e-14 * n as f64, "{sum} is not {whole}");
    }

    /// Corners anywhere at all, on few different places: flat, crossing, lying on each other.
    #[test]
    fn a_polygon_without_a_shape_is_cut_all_the_same(places in prop::collection::vec(prop::array::uniform3(0..3_u8), 4..65)) {
        let outline: Vec<DVec3> = places.into_iter().map(|p| DVec3::from_array(p.map(f64::from))).collect();
        is_disc_of(&triangulate(&polygon(&outline)).triangles, outline.len())?;
    }

    #[test]
    fn a_polygon_of_any_doubles_is_cut_all_the_same(bits in prop::collection::vec(prop::array::uniform3(any::<u64>()), 4..20)) {
        let outline: Vec<DVec3> = bits.into_iter().map(|p| DVec3::from_array(p.map(f64::from_bits))).collect();
        is_disc_of(&triangulate(&polygon(&outline)).triangles, outline.len())?;
    }

    /// Grids of squares with holes: sound, and no single turn of a diagonal would bring valences
    /// nearer to their targets.
    #[test]
    fn no_turn_of_a_diagonal_makes_it_better(kept in prop::collection::vec(prop::bool::weighted(0.8), 36)) {
        let polygons = squares(6, |x, y| kept[6 * y + x]);
        prop_assume!(polygons.face_count() > 0);
        let cut = triangulate(&polygons);
        let sum = |triangles: &[[u32; 3]]| spread(&polygons, triangles);
        let best = sum(&cut.triangles);
        for pair in cut.triangles.chunks(2) {
            let [a, b, c, d] = square_of(pair);
            let mut turned = cut.triangles.clone();
            let at = turned.iter().position(|t| t == &pair[0]).unwrap();
            (turned[at], turned[at + 1]) = ([b, c, d], [d, a, b]);
            prop_assert!(sum(&turned) >= best);
        }
    }
}

/// The corners of two triangles of one square, so that they share the diagonal from the first to the
/// third.
fn square_of(pair: &[[u32; 3]]) -> [u32; 4] {
    let (s, t) = (pair[0], pair[1]);
    let lone = |of: [u32; 3], other: [u32; 3]| (0..3).find(|&i| !other.contains(&of[i])).unwrap();
    let (i, j) = (lone(s, t), lone(t, s));
    [s[(i + 2) % 3], s[i], s[(i + 1) % 3], t[j]]
}

fn squares(size: usize, kept: impl Fn(usize, usize) -> bool) -> Polygons {
    let row = size + 1;
    let at = |i: usize| DVec3::new((i % row) as f64, (i / row) as f64, 0.0);
    let mut polygons = Polygons::new((0..row * row).map(at).collect());
    for (x, y) in (0..size * size).map(|i| (i % size, i / size)).filter(|&(x, y)| kept(x, y)) {
        let first = (y * row + x) as u32;
        let row = row as u32;
        polygons.push(&[first, first + 1, first + 1 + row, first + row]).unwrap();
    }
    polygons
}

/// The sum of the fourth powers of valence less target, counted from triangles and squares alone.
fn spread(polygons: &Polygons, triangles: &[[u32; 3]]) -> i64 {
    let mut along: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    for &[a, b, c] in triangles {
        for (a, b) in [(a, b), (b, c), (c, a)] {
            *along.entry([a.min(b), a.max(b)]).or_default() += 1;
        }
    }
    let mut squares = vec![0; polygons.positions.len()];
    polygons.faces().flatten().for_each(|&v| squares[v as usize] += 1);
    let (mut valence, mut border) = (vec![0_i64; squares.len()], vec![0; squares.len()]);
    for (ends, faces) in along {
        for v in ends.map(|v| v as usize) {
            valence[v] += 1;
            border[v] += i64::from(faces == 1);
        }
    }
    // Four border edges meet where two squares touch at a corner.
    let excess = |v: usize| valence[v] - 6 + border[v];
    let told = |v: usize| if squares[v] == 1 { excess(v).max(-1) } else { excess(v) };
    (0..squares.len()).filter(|&v| squares[v] > 0).map(|v| told(v).pow(4)).sum()
}

/// Six edges at every vertex inside, four on the border, two and three in turn at the corners.
#[test]
fn a_grid_of_squares_becomes_the_regular_lattice() {
    let polygons = squares(9, |_, _| true);
    let cut = triangulate(&polygons);
    assert_eq!(cut.polygons, 81);
    let mesh = Connectivity::new(polygons.positions.len(), &cut.triangles).unwrap();
    for v in (0..mesh.vertex_count()).map(VertexId::new) {
        let target = match v.index() {
            0 | 99 => 3,
            9 | 90 => 2,
            _ if mesh.is_border(v) => 4,
            _ => 6,
        };
        assert_eq!(mesh.valence(v), target, "vertex {v}");
    }
}

/// The fewest edges that the busiest of the 64 corners can end with is 4, all diagonals in a zigzag.
#[test]
fn a_polygon_of_many_sides_is_not_cut_into_a_fan() {
    let at = |i: usize| DVec3::new((i as f64 / 64.0 * TAU).cos(), (i as f64 / 64.0 * TAU).sin(), 0.0);
    let polygons = polygon(&(0..64).map(at).collect::<Vec<_>>());
    let mesh = Connectivity::new(64, &triangulate(&polygons).triangles).unwrap();
    let highest = (0..64).map(|v| mesh.valence(VertexId(v))).max();
    assert!(highest <= Some(5), "{highest:?}");
}

/// Two squares back to back: their diagonals cross, or they would lie along each other.
#[test]
fn no_diagonal_lies_along_another() {
    let corners = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
    let mut pillow = Polygons::new(corners.to_vec());
    pillow.push(&[0, 1, 2, 3]).unwrap();
    pillow.push(&[3, 2, 1, 0]).unwrap();
    let cage = Cage::from_polygons(pillow).unwrap();
    assert_eq!(Connectivity::new(4, &cage.triangles).unwrap().edge_count(), 6);
}

/// The one diagonal of a dart that lies inside it, whatever the valences would have.
#[test]
fn a_dart_is_cut_through_its_notch() {
    let outline = [DVec3::new(0.0, 1.0, 0.0), DVec3::new(-1.0, -1.0, 0.0), DVec3::ZERO, DVec3::new(1.0, -1.0, 0.0)];
    for turn in 0..4 {
        let mut turned = outline;
        turned.rotate_left(turn);
        let polygons = polygon(&turned);
        let cut = triangulate(&polygons);
        let along_notch = |t: &[u32; 3]| {
            let corners = corners_of(*t, &polygons);
            corners.contains(&outline[0]) && corners.contains(&outline[2])
        };
        assert!(cut.triangles.iter().all(along_notch), "{:?}", cut.triangles);
    }
}

#[test]
fn sources_name_the_face_of_each_triangle() {
    let mut polygons = Polygons::new((0..9).map(|i| DVec3::new(f64::from(i), f64::from(i * i), 0.0)).collect());
    polygons.push(&[0, 1, 2]).unwrap();
    polygons.push(&[2, 3, 4, 5, 6]).unwrap();
    polygons.push(&[6, 7, 8, 0]).unwrap();
    let cut = triangulate(&polygons);
    assert_eq!(cut.sources, [0, 1, 1, 1, 2, 2].map(FaceId));
    assert_eq!(cut.polygons, 2);
    for (t, f) in cut.triangles.iter().zip(&cut.sources) {
        assert!(t.iter().all(|v| polygons.face(f.index()).contains(v)));
    }
}

/// A file made to be slow: many faces of as many sides as there may be. Cutting one looks at each of its
/// corners at most once for each, so what a corner can cost is bounded by that limit.
#[test]
fn faces_of_as_many_sides_as_there_may_be_are_cut() {
    let sides = Limits::default().sides as u32;
    let faces = 100;
    let mut polygons = Polygons::new(Vec::new());
    for f in 0..faces {
        let at = |i: u32| {
            // Alternately on two circles: every second corner is reflex.
            let (angle, r) = (f64::from(i) / f64::from(sides) * TAU, 1.0 - 0.4 * f64::from(i % 2));
            DVec3::new(r * angle.cos(), r * angle.sin(), f64::from(f))
        };
        polygons.positions.extend((0..sides).map(at));
        polygons.push(&(f * sides..(f + 1) * sides).collect::<Vec<_>>()).unwrap();
    }
    let cut = triangulate(&polygons);
    assert_eq!(cut.triangles.len(), (faces * (sides - 2)) as usize);
    assert!(sides <= 256);
}

#[test]
fn the_same_file_is_cut_the_same_way() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/cages/spot_control_mesh.obj");
    let bytes = std::fs::read(path).unwrap();
    let cut = || triangulate(&obj::read(&bytes, &Limits::default()).unwrap());
    assert_eq!(cut(), cut());
}
