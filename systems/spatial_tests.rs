use super::*;

/// Numbers in [0, 1), one after another.
struct Draw(u64);

impl Draw {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn point(&mut self) -> DVec3 {
        DVec3::new(self.unit(), self.unit(), self.unit())
    }

    /// Small boxes, points and slabs, some of them the same, in `unit` model units about `centre`.
    fn boxes(&mut self, count: usize, unit: f64, centre: DVec3) -> Vec<Bounds> {
        let mut all: Vec<Bounds> = Vec::new();
        for k in 0..count {
            if k % 7 == 3 {
                let again = all[(self.unit() * k as f64) as usize];
                all.push(again);
                continue;
            }
            let size = if k % 5 == 0 { DVec3::ZERO } else { 0.1 * self.point() };
            let at = self.point();
            all.push(Bounds { min: at * unit + centre, max: (at + size) * unit + centre });
        }
        all
    }
}

/// Millimetres far out, kilometres, and what f32 cannot hold at all.
const UNITS: [(f64, DVec3); 5] = [
    (1.0, DVec3::ZERO),
    (1e-3, DVec3::new(2e3, -5e3, 1e3)),
    (1e5, DVec3::new(1e7, 0.0, 0.0)),
    (1e-60, DVec3::ZERO),
    (1e200, DVec3::ZERO),
];

#[test]
fn the_nearest_box_is_the_first_of_the_nearest() {
    for (unit, centre) in UNITS {
        let mut draw = Draw(3);
        let boxes = draw.boxes(500, unit, centre);
        let tree = Bvh::new(&boxes);
        // Whole multiples of the unit, so that squares stay in range.
        let square = |b: &Bounds, p: DVec3| {
            let unitless = Bounds { min: (b.min - centre) / unit, max: (b.max - centre) / unit };
            unitless.distance_squared((p - centre) / unit) * unit * unit
        };
        for _ in 0..200 {
            let point = (draw.point() * 1.5 - 0.2) * unit + centre;
            let found = tree.nearest(point, |i| square(&boxes[i as usize], point));
            let least = boxes.iter().map(|b| square(b, point)).fold(f64::INFINITY, f64::min);
            let first = boxes.iter().position(|b| square(b, point) == least);
            if least > 0.0 && least.is_finite() {
                assert_eq!(found.map(|f| f.0 as usize), first, "{unit}");
            }
        }
    }
}

#[test]
fn no_overlap_is_missed() {
    for (unit, centre) in UNITS {
        let mut draw = Draw(4);
        let (boxes, others) = (draw.boxes(300, unit, centre), draw.boxes(200, unit, centre));
        let (tree, other) = (Bvh::new(&boxes), Bvh::new(&others));
        let mut pairs = Vec::new();
        tree.pairs(&other, |i, j| pairs.push((i, j)));
        pairs.sort_unstable();
        let count = pairs.len();
        pairs.dedup();
        assert_eq!(pairs.len(), count, "each pair comes once");
        let mut expected = 0;
        for (j, query) in others.iter().enumerate() {
            let mut visited = Vec::new();
            tree.overlapping(*query, |i| visited.push(i));
            for i in (0..boxes.len()).filter(|&i| boxes[i].overlaps(query)) {
                assert!(visited.contains(&(i as u32)));
                assert!(pairs.binary_search(&(i as u32, j as u32)).is_ok());
                expected += 1;
            }
        }
        assert!(expected > 0);
        let all = boxes.len() * others.len();
        assert!(count < all / 4, "{count} of {all} pairs were visited for {expected} that overlap");
    }
}

#[test]
fn a_line_misses_no_box() {
    for (unit, centre) in UNITS {
        let mut draw = Draw(5);
        let boxes = draw.boxes(400, unit, centre);
        let tree = Bvh::new(&boxes);
        for k in 0..200 {
            let target = boxes[k % boxes.len()];
            let through = target.min + (target.max - target.min) * draw.point();
            let mut direction = (draw.point() - 0.5) * unit;
            if k % 4 == 0 {
                direction[k % 3] = 0.0;
            }
            let origin = through - direction * 3.0;
            let mut visited = Vec::new();
            tree.along(origin, direction, [2.9, 3.1], |i, end| {
                visited.push(i);
                end
            });
            let thick = (target.max - target.min).min_element() > 0.0;
            assert!(!thick || visited.contains(&((k % boxes.len()) as u32)), "{unit}, {k}");
            assert!(visited.len() < boxes.len() / 2);
        }
    }
}

/// Lines along axes and from far away lose digits, but no box; and lines beside all boxes visit none.
#[test]
fn a_line_misses_no_box_from_far_away_or_along_an_axis() {
    for (unit, centre) in UNITS.into_iter().take(3) {
        let mut draw = Draw(6);
        let boxes = draw.boxes(300, unit, centre);
        let tree = Bvh::new(&boxes);
        let visited = |origin: DVec3, direction: DVec3| {
            let mut visited = Vec::new();
            tree.along(origin, direction, [f64::NEG_INFINITY, f64::INFINITY], |i, end| {
                visited.push(i as usize);
                end
            });
            visited
        };
        for (k, target) in boxes.iter().enumerate().filter(|(_, b)| (b.max - b.min).min_element() > 1e-3 * unit) {
            let through = target.min.midpoint(target.max);
            let axis = [DVec3::X, DVec3::NEG_Y, DVec3::Z][k % 3];
            let aslant = (draw.point() - 0.5).normalize();
            for direction in [axis, aslant, aslant * 1e-9, aslant * 1e9] {
                for far in [0.0, 10.0, 1e6] {
                    let origin = through - direction.normalize() * (far * unit);
                    let visited = visited(origin, direction);
                    assert!(visited.contains(&k), "{unit}, {k}: {direction} from {far}");
                    assert!(visited.len() < boxes.len() / 2);
                }
            }
        }
        assert!(visited(centre + DVec3::splat(-0.5 * unit), DVec3::X).is_empty());
        for none in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY] {
            assert!(visited(centre, none).is_empty(), "{none} is no direction");
        }
    }
}

/// However many boxes there are: nodes have room for four.
#[test]
fn a_line_visits_each_box_once() {
    for count in 1..20 {
        let boxes: Vec<_> = (0..count).map(|i| Bounds::of([DVec3::splat(f64::from(i)), DVec3::splat(20.0)])).collect();
        let tree = Bvh::new(&boxes);
        let mut visited = Vec::new();
        tree.along(DVec3::splat(30.0), DVec3::new(-1.0, -1.01, -0.99), [0.0, f64::INFINITY], |i, end| {
            visited.push(i);
            end
        });
        visited.sort_unstable();
        assert!(visited.iter().copied().eq(0..count as u32), "{visited:?} of {count}");
    }
}

#[test]
fn a_line_is_cut_where_the_visitor_says() {
    let boxes: Vec<_> =
        (0..100).map(|i| Bounds::of([DVec3::X * f64::from(i), DVec3::X * (f64::from(i) + 0.5) + 1.0])).collect();
    let tree = Bvh::new(&boxes);
    let mut visited = 0;
    tree.along(DVec3::new(-1.0, 0.5, 0.5), DVec3::X, [0.0, f64::INFINITY], |i, end| {
        visited += 1;
        end.min(f64::from(i) + 1.0)
    });
    assert!(visited < 20, "{visited} boxes behind the first were visited");
}

#[test]
fn nothing_one_and_unsound_boxes_are_no_trouble() {
    let none = Bvh::new(&[]);
    assert!(none.is_empty());
    assert_eq!(none.nearest(DVec3::ZERO, |_| 0.0), None);
    none.overlapping(Bounds::of([DVec3::ZERO]), |_| unreachable!("there is nothing to overlap"));
    none.along(DVec3::ZERO, DVec3::X, [0.0, 1.0], |_, end| end);
    none.pairs(&none, |_, _| unreachable!("there is nothing to pair"));

    let one = Bvh::new(&[Bounds::of([DVec3::ONE])]);
    assert_eq!(one.nearest(DVec3::ZERO, |_| 3.0), Some((0, 3.0)));

    let unsound = [
        Bounds::EMPTY,
        Bounds { min: DVec3::NAN, max: DVec3::ONE },
        Bounds { min: DVec3::NEG_INFINITY, max: DVec3::ONE },
        Bounds::of([DVec3::ZERO]),
        Bounds::of([DVec3::splat(5.0)]),
    ];
    let tree = Bvh::new(&unsound);
    assert_eq!(tree.len(), 5);
    let mut visited = Vec::new();
    tree.overlapping(Bounds::of([DVec3::splat(4.9), DVec3::splat(5.1)]), |i| visited.push(i));
    visited.sort_unstable();
    assert_eq!(visited, [0, 1, 2, 4], "boxes that are not sound are always visited");
    assert_eq!(Bvh::new(&[Bounds::EMPTY; 3]).len(), 3);
}
