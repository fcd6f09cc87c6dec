use core::f64::consts::TAU;

use proptest::prelude::*;

use super::*;
use crate::curve::testing::{bits, config};
use crate::curve::{Branch, Circle, FnCurve, Polyline};

fn circle() -> Arc<dyn Curve> {
    Arc::new(Circle::new(DVec3::new(0.1, -0.3, 0.2), DVec3::new(0.2, 0.5, 1.0), 0.5).expect("a circle"))
}

/// An open curve without symmetry.
fn helix() -> Arc<dyn Curve> {
    Arc::new(FnCurve::new(|u| DVec3::new((5.0 * u).cos(), (5.0 * u).sin(), u + u * u)))
}

/// `count` gaps, each up to ten times another.
fn gaps(count: core::ops::Range<usize>) -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(0.1..1.0, count)
}

/// Ascending parameters with these gaps that fill [0, 1], beginning with 0.
fn filled(gaps: &[f64]) -> Vec<f64> {
    let total: f64 = gaps.iter().sum();
    let ends = gaps.iter().scan(0.0, |at, gap| {
        *at += gap / total;
        Some(*at)
    });
    core::iter::once(0.0).chain(ends.take(gaps.len() - 1)).collect()
}

/// A closed list all round the circle that begins anywhere.
fn closed(gaps: &[f64], shift: f64, begin: usize) -> CurveParameters {
    let mut list: Vec<_> = filled(gaps).iter().map(|u| wrap(u + shift)).collect();
    list.rotate_left(begin % gaps.len());
    CurveParameters::new(circle(), Extent::Closed, list, &[]).expect("ascends round the circle")
}

fn open(gaps: &[f64], corners: &[usize]) -> CurveParameters {
    let mut list = filled(gaps);
    list.push(1.0);
    CurveParameters::new(helix(), Extent::Open, list, corners).expect("ascends")
}

/// A step of the refinement rules on a whole list, as they are written: the hierarchy by the other way.
fn refined(u: &[f64], fixed: impl Fn(usize) -> bool, extent: Extent) -> Vec<f64> {
    let n = u.len() as isize;
    let at = |i: isize| u[i.rem_euclid(n) as usize] + i.div_euclid(n) as f64;
    let mut fine = Vec::new();
    for i in 0..n {
        fine.push(if fixed(i as usize) { at(i) } else { ((at(i - 1) + at(i + 1)) + 6.0 * at(i)) / 8.0 });
        if i + 1 < n || extent == Extent::Closed {
            fine.push((at(i) + at(i + 1)) / 2.0);
        }
    }
    fine
}

proptest! {
    #![proptest_config(config())]

    /// The list of every level is the list below it, refined by the rules.
    #[test]
    fn coefficients_are_the_refinement_of_the_level_below(gaps in gaps(3..9), shift in 0.0..1.0, corner in 1_usize..9) {
        let inner = [corner.min(gaps.len() - 1)];
        for border in [closed(&gaps, shift, 0), open(&gaps, &inner)] {
            let mut list: Vec<_> = border.base().to_vec();
            prop_assert!((0..).zip(&list).all(|(i, u)| border.coefficient(0, i) == *u));
            for level in 1..6 {
                list = refined(&list, |i| border.is_fixed(level - 1, i as u64), border.extent());
                prop_assert_eq!(list.len() as u64, border.vertex_count(level));
                for (i, &u) in (0..).zip(&list) {
                    prop_assert!((border.coefficient(level, i) - u).abs() < 2e-15, "level {} vertex {}", level, i);
                }
            }
        }
    }

    /// The limit is `((u_{i-1} + u_{i+1}) + 4 u_i) / 6` of the coefficients of its own level.
    #[test]
    fn parameters_are_limits_of_the_coefficients(gaps in gaps(3..9), shift in 0.0..1.0, level in 0_u32..6) {
        let border = closed(&gaps, shift, 0);
        let count = border.vertex_count(level);
        for i in 0..count {
            let lift = |k: u64, turn: f64| border.coefficient(level, k % count) + turn;
            let before = lift(i + count - 1, if i == 0 { -1.0 } else { 0.0 });
            let after = lift(i + 1, if i + 1 == count { 1.0 } else { 0.0 });
            let limit = ((before + after) + 4.0 * border.coefficient(level, i)) / 6.0;
            let off = (border.parameter(level, i) - wrap(limit)).abs();
            prop_assert!(off < 2e-15 || (off - 1.0).abs() < 2e-15, "{}", off);
        }
    }

    /// Two surfaces walk one list in opposite directions, from different vertices, at any level.
    #[test]
    fn both_sides_take_the_same_bits(gaps in gaps(3..9), shift in 0.0..1.0, a in 0_u64..9, b in 0_u64..9, level in 0_u32..7) {
        for border in [closed(&gaps, shift, 0), open(&gaps, &[])] {
            let count = border.vertex_count(level);
            let [there, back] = match border.extent() {
                Extent::Open => [Heading::Along, Heading::Against].map(|heading| Traversal::all(&border, heading)),
                Extent::Closed => [(a, Heading::Along), (b, Heading::Against)].map(|(first, heading)| Traversal { first, heading }),
            };
            let walk = |t: Traversal| (0..count).map(|k| border.sample(level, t.vertex(&border, level, k))).map(bits).collect::<Vec<_>>();
            let (mut forward, mut backward) = (walk(there), walk(back));
            // Turned round, the one walk is the other from where that one ended.
            backward.reverse();
            if border.extent() == Extent::Closed {
                let count0 = border.vertex_count(0);
                forward.rotate_right((((a % count0) << level) % count) as usize);
                backward.rotate_right(((((b % count0) << level) + 1) % count) as usize);
            }
            prop_assert_eq!(forward, backward);
            // The edge of a step joins the vertices of the step, from either side.
            for t in [there, back] {
                for k in 0..border.edge_count(level) {
                    let (from, to) = (t.vertex(&border, level, k), t.vertex(&border, level, k + 1));
                    let edge = t.edge(&border, level, k);
                    let ends = [edge, if border.extent() == Extent::Closed { (edge + 1) % count } else { edge + 1 }];
                    let walked = if t.heading == Heading::Along { [from, to] } else { [to, from] };
                    prop_assert_eq!(ends, walked);
                }
            }
        }
    }

    /// The list is the curve's: it does not matter where the caller began.
    #[test]
    fn where_a_closed_list_begins_leaves_no_trace(gaps in gaps(3..9), shift in 0.0..1.0, begin in 0_usize..9) {
        let (one, other) = (closed(&gaps, shift, 0), closed(&gaps, shift, begin));
        prop_assert_eq!(one.base(), other.base());
        prop_assert!(one.base().is_sorted());
        prop_assert!(one.samples(3).zip(other.samples(3)).all(|(p, q)| bits(p) == bits(q)));
        // The caller's first parameter is found again.
        let first = filled(&gaps).iter().map(|u| wrap(u + shift)).nth(begin % gaps.len());
        prop_assert_eq!(Some(other.base()[other.rotation()]), first);
    }

    #[test]
    fn a_sample_keeps_its_bits_at_every_finer_level(gaps in gaps(3..9), shift in 0.0..1.0, level in 0_u32..8, i in 0_u64..2000) {
        for border in [closed(&gaps, shift, 0), open(&gaps, &[1])] {
            let i = i % border.vertex_count(level);
            let sample = bits(border.sample(level, i));
            for finer in level + 1..=24 {
                prop_assert_eq!(bits(border.sample(finer, i << (finer - level))), sample);
            }
        }
    }

    /// A part of a closed list that passes the place where the curve begins has the closed list's bits
    /// wherever its own ends are not seen.
    #[test]
    fn a_part_over_the_beginning_keeps_the_bits_of_the_whole(gaps in gaps(9..16), shift in 0.0..1.0, level in 0_u32..5) {
        let whole = closed(&gaps, shift, 0);
        let count = whole.base().len();
        let first = count / 2;
        let list: Vec<_> = (0..count).map(|k| whole.base()[(first + k) % count]).collect();
        let part = CurveParameters::new(circle(), Extent::Open, list, &[]).expect("ascends round the circle");
        for k in 2_u64 << level..(count as u64 - 3) << level {
            let there = (((first as u64) << level) + k) % whole.vertex_count(level);
            prop_assert_eq!(part.parameter(level, k).to_bits(), whole.parameter(level, there).to_bits(), "vertex {}", k);
        }
    }

    #[test]
    fn a_whole_level_has_the_bits_of_its_vertices(gaps in gaps(3..9), shift in 0.0..1.0, level in 0_u32..7) {
        for border in [closed(&gaps, shift, 0), open(&gaps, &[1])] {
            let whole: Vec<_> = border.parameters(level).map(f64::to_bits).collect();
            let each: Vec<_> = (0..border.vertex_count(level)).map(|i| border.parameter(level, i).to_bits()).collect();
            prop_assert_eq!(whole, each);
        }
    }

    #[test]
    fn ascending_stays_ascending(gaps in gaps(3..9), shift in 0.0..1.0, corner in 1_usize..8) {
        let inner = [corner.min(gaps.len() - 1)];
        for border in [closed(&gaps, shift, 0), open(&gaps, &inner)] {
            let base = border.parameter(0, 0);
            let mut before = None;
            for u in border.parameters(7) {
                // Counted from the first sample, which may lie on either side of where the curve begins.
                let along = if border.extent() == Extent::Closed { wrap(u - base) } else { u };
                prop_assert!(before.is_none_or(|b| along > b), "{} after {:?}", along, before);
                before = Some(along);
            }
            // At the finest level, neighbours are still told apart.
            let i = border.vertex_count(24) / 3;
            let [a, b, c] = [i - 1, i, i + 1].map(|i| border.parameter(24, i));
            prop_assert!(wrap(b - a) > 0.0 && wrap(b - a) < 1e-6 && wrap(c - b) > 0.0 && wrap(c - b) < 1e-6);
        }
    }

    /// However uneven the parameters, the border runs on with the velocity it came with.
    #[test]
    fn velocity_is_continuous_for_uneven_parameters(gaps in gaps(3..9), shift in 0.0..1.0) {
        for border in [closed(&gaps, shift, 0), open(&gaps, &[])] {
            let joins = border.edge_count(0) - if border.extent() == Extent::Open { 1 } else { 0 };
            for edge in 0..joins {
                let (before, after) = (border.velocity_on(edge, 1.0), border.velocity_on(edge + 1, 0.0));
                let vertex = (edge + 1) << 4;
                prop_assert_eq!(bits(before), bits(border.velocity(4, vertex, Branch::Before)));
                prop_assert_eq!(bits(after), bits(border.velocity(4, vertex, Branch::After)));
                prop_assert!(before.distance(after) < 1e-9 * (before.length() + after.length()));
            }
        }
    }
}

#[test]
fn gaps_of_one_to_ten_keep_the_border_tangent_where_straight_steps_do_not() {
    let mut uneven = vec![0.1; 4];
    uneven.extend([1.0; 4]);
    let border = closed(&uneven, 0.05, 0);
    let fine = |level: u32| {
        // Lengths of the two samples' chords on either side of the vertex where the gaps change.
        let vertex = 4_u64 << level;
        let [a, b, c] = [vertex - 1, vertex, vertex + 1].map(|i| border.sample(level, i));
        c.distance(b) / b.distance(a)
    };
    assert!((fine(16) - 1.0).abs() < 1e-4, "{}", fine(16));
    let ratio = (fine(8) - 1.0) / (fine(9) - 1.0);
    assert!((ratio - 2.0).abs() < 0.05, "the jump of the chords vanishes with the first order: {ratio}");
}

#[test]
fn the_samples_chords_converge_to_the_curve_to_second_order() {
    let border = closed(&[0.3, 1.0, 0.2, 0.7, 0.5], 0.0, 0);
    let circle = Circle::new(DVec3::new(0.1, -0.3, 0.2), DVec3::new(0.2, 0.5, 1.0), 0.5).expect("the same circle");
    let error = |level: u32| {
        let points: Vec<_> = border.samples(level).collect();
        let next = points.iter().cycle().skip(1);
        points
            .iter()
            .zip(next)
            .map(|(p, q)| 0.5 - (p + q).midpoint(DVec3::ZERO).distance(circle.centre()))
            .fold(0.0, f64::max)
    };
    for level in 3..8 {
        let ratio = error(level) / error(level + 1);
        assert!((ratio - 4.0).abs() < 0.4, "level {level}: {ratio}");
    }
}

#[test]
fn samples_lie_on_the_curve_and_ends_and_corners_stay() {
    let square = Polyline::closed(vec![DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y]).expect("a square");
    let points = square.points().to_vec();
    let list = vec![0.0, 0.05, 0.2, 0.25, 0.4, 0.5, 0.6, 0.75, 0.8, 0.97];
    let border = CurveParameters::new(Arc::new(square), Extent::Closed, list, &[]).expect("corners are listed");
    let fixed: Vec<_> = (0..10).filter(|&i| border.is_fixed(0, i)).collect();
    assert_eq!(fixed, [0, 3, 5, 7]);
    for level in [0, 1, 5, 24] {
        for (corner, point) in fixed.iter().zip(&points) {
            assert_eq!(bits(border.sample(level, corner << level)), bits(*point));
            assert!(border.is_fixed(level, corner << level) && !border.is_fixed(level, (corner << level) + 1));
        }
    }
    // Next to a corner the spline runs straight in: the second differences vanish there.
    let [a, b, c] = [0, 1, 2].map(|i| border.parameter(20, (3 << 20) + i));
    assert!(((c - b) - (b - a)).abs() < 1e-15);
}

#[test]
fn part_of_a_closed_curve_may_pass_where_the_curve_begins() {
    let drop = FnCurve::new(|u: f64| DVec3::new((TAU * u).cos(), (TAU * u).sin(), u * (1.0 - u)))
        .closed()
        .with_corners(vec![0.1]);
    let drop: Arc<dyn Curve> = Arc::new(drop);
    let part = CurveParameters::new(drop.clone(), Extent::Open, vec![0.7, 0.9, 0.1, 0.3], &[]).expect("ascends");
    assert_eq!((part.vertex_count(3), part.edge_count(3)), (25, 24));
    assert!(part.is_fixed(0, 0) && !part.is_fixed(0, 1) && part.is_fixed(0, 2) && part.is_fixed(0, 3));
    let ends =
        [part.parameter(9, 0), part.parameter(9, 2 << 9), part.parameter(9, 3 << 9), part.parameter(9, u64::MAX)];
    assert_eq!(ends, [0.7, 0.1, 0.3, 0.3]);
    let along: Vec<_> = part.parameters(5).map(|u| wrap(u - 0.7)).collect();
    assert!(along.is_sorted_by(|a, b| a < b));
    // All round, from the corner to the corner.
    let all = CurveParameters::new(drop, Extent::Open, vec![0.1, 0.5, 0.9, 0.1], &[]).expect("once round");
    assert_eq!([all.parameter(2, 0), all.parameter(2, 12)], [0.1, 0.1]);
}

#[test]
fn even_parameters_keep_corners_and_are_even() {
    let bent = Polyline::open(vec![DVec3::ZERO, 3.0 * DVec3::X, DVec3::new(3.0, 1.0, 0.0)]).expect("bent");
    let border = CurveParameters::even(Arc::new(bent), 8).expect("a list");
    assert_eq!(border.base(), [0.0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0]);
    assert!(border.is_fixed(0, 6));
    for edges in 0..20 {
        let ring = CurveParameters::even(circle(), edges).expect("a list");
        assert_eq!(ring.edge_count(0), u64::from(edges.max(3)));
        let triangle = Polyline::closed(vec![DVec3::ZERO, DVec3::X, DVec3::Y]).expect("a triangle");
        let around = CurveParameters::even(Arc::new(triangle), edges).expect("a list");
        assert!(around.edge_count(0) >= 3 && around.edge_count(0) <= u64::from(edges.max(2)) + 1);
    }
    let broken = FnCurve::new(|u| DVec3::X * u).with_corners(vec![0.7, 0.2, 1e30]);
    assert!(CurveParameters::even(Arc::new(broken), 5).is_err());
}

#[test]
fn what_is_no_list_is_refused_and_placed() {
    use ParameterError::{CornerIndex, MissedCorner, NotAscending, OpenCurve, OutOfRange, TooFew};
    let around = |list: &[f64]| CurveParameters::new(circle(), Extent::Closed, list.to_vec(), &[]).err();
    let along =
        |list: &[f64], corners: &[usize]| CurveParameters::new(helix(), Extent::Open, list.to_vec(), corners).err();
    assert_eq!(around(&[0.1, 0.5]), Some(TooFew { count: 2, needed: 3 }));
    assert_eq!(along(&[0.1], &[]), Some(TooFew { count: 1, needed: 2 }));
    assert_eq!(around(&[0.1, 0.5, 1.0]), Some(OutOfRange { index: 2, u: 1.0 }));
    assert!(matches!(along(&[0.0, f64::NAN], &[]), Some(OutOfRange { index: 1, .. })));
    assert_eq!(along(&[0.0, 0.5, 0.5, 1.0], &[]), Some(NotAscending { index: 2, u: 0.5, before: 0.5 }));
    assert_eq!(along(&[0.7, 0.9, 0.1], &[]), Some(NotAscending { index: 2, u: 0.1, before: 0.9 }));
    assert_eq!(around(&[0.5, 0.9, 0.2, 0.1]), Some(NotAscending { index: 3, u: 0.1, before: 0.2 }));
    assert_eq!(around(&[0.5, 0.9, 0.2, 0.6]), Some(NotAscending { index: 3, u: 0.6, before: 0.2 }));
    assert_eq!(around(&[0.5, 0.9, 0.2, 0.5]), Some(NotAscending { index: 3, u: 0.5, before: 0.2 }));
    assert_eq!(around(&[0.5, 0.4, 0.3]), Some(NotAscending { index: 2, u: 0.3, before: 0.4 }));
    let open_curve = CurveParameters::new(helix(), Extent::Closed, vec![0.1, 0.2, 0.3], &[]).err();
    assert_eq!(open_curve, Some(OpenCurve));
    assert_eq!(along(&[0.0, 1.0], &[2]), Some(CornerIndex { index: 2, count: 2 }));
    let bent = Arc::new(Polyline::open(vec![DVec3::ZERO, DVec3::X, DVec3::ONE]).expect("bent"));
    let corner = bent.corners()[0];
    let missed = |list: Vec<f64>| CurveParameters::new(bent.clone(), Extent::Open, list, &[]).err();
    assert_eq!(missed(vec![0.0, 1.0]), Some(MissedCorner { u: corner }));
    assert_eq!(missed(vec![0.0, corner, 1.0]), None);
    assert_eq!(missed(vec![0.0, corner / 2.0]), None);
}

#[test]
fn no_level_and_no_index_panics() {
    for border in [closed(&[0.3, 0.5, 0.2], 0.3, 1), open(&[0.3, 0.5, 0.2], &[])] {
        for level in [0, 1, 24, 52, 61, 62, 63, 64, 65, 1000, 1023, 5000, u32::MAX] {
            for vertex in [0, 1, 7, u64::MAX / 2, u64::MAX - 1, u64::MAX] {
                let u = border.parameter(level, vertex);
                assert!((0.0..=1.0).contains(&u), "level {level} vertex {vertex}: {u}");
                let _ = (
                    border.coefficient(level, vertex),
                    border.is_fixed(level, vertex),
                    border.parameter_on(vertex, 0.3),
                );
                for heading in [Heading::Along, Heading::Against] {
                    let walk = Traversal { first: vertex, heading };
                    let _ = (walk.vertex(&border, level, vertex), walk.edge(&border, level, vertex));
                }
            }
        }
        assert!(border.parameter_on(0, f64::NAN).is_nan());
    }
}
