use glam::DVec3;
use selvedge_components::{curve::*, mesh::*, subdivision::*};
use selvedge_systems::{subdivision::fit::*, subdivision::quasi::*, target::Projection};
use std::sync::Arc;
#[derive(Debug)]
struct ArcC(DVec3, DVec3);
impl Curve for ArcC {
    fn position(&self, u: f64) -> DVec3 {
        let w = std::f64::consts::FRAC_PI_2;
        0.5 * (((1.0 - u) * w).sin() * self.0 + (u * w).sin() * self.1)
    }
}
fn main() {
    let text = std::fs::read_to_string("/work/shared/data/plates/octant.json").unwrap();
    let j: serde_json::Value = serde_json::from_str(&text).unwrap();
    for name in ["cone(1,1)", "cone(1,2)"] {
        let m = &j["meshes"][name];
        let n = m["vertices"].as_u64().unwrap() as usize;
        let f: Vec<[u32; 3]> = serde_json::from_value(m["triangles"].clone()).unwrap();
        let s: Vec<Vec<u32>> = serde_json::from_value(m["sides"].clone()).unwrap();
        let mesh = Connectivity::new(n, &f).unwrap();
        let x = [DVec3::X, DVec3::Y, DVec3::Z];
        let mut points = vec![DVec3::ZERO; n];
        let mut fixed = vec![false; n];
        let mut sides = vec![];
        for (k, ids) in s.iter().enumerate() {
            let c = Arc::new(CurveParameters {
                curve: Arc::new(ArcC(x[k], x[(k + 1) % 3])),
                u: (0..ids.len()).map(|i| i as f64 / (ids.len() - 1) as f64).collect(),
            });
            for (i, &v) in ids.iter().enumerate() {
                points[v as usize] = c.sample(0, i as u64);
                fixed[v as usize] = true;
            }
            sides.push(Side {
                vertices: ids.iter().map(|&v| VertexId(v)).collect(),
                ends: Ends::Corners,
                border: Border::Given { curve: c, first: 0, heading: Heading::Along },
            });
        }
        for _ in 0..2000 {
            for v in 0..n {
                if !fixed[v] {
                    let nb: Vec<_> = mesh.neighbours(VertexId(v as u32)).collect();
                    points[v] = nb.iter().map(|w| points[w.index()]).sum::<DVec3>() / nb.len() as f64;
                }
            }
        }
        for (rule, cr) in [
            (Rule::LeastSquares, CornerRule::Lattice),
            (Rule::Quasi { boundary: BoundaryStencil::Quadratic, corner: CornerStencil::Mean }, CornerRule::Seed),
            (Rule::Quasi { boundary: BoundaryStencil::Cubic, corner: CornerStencil::Mended }, CornerRule::Lattice),
        ] {
            let surface = Arc::new(LoopSurface {
                mesh: Arc::new(mesh.clone()),
                points: points.clone(),
                sides: sides.clone(),
                corner_rule: cr,
                details: Details::default(),
            });
            let t = std::time::Instant::now();
            let mut fit = FitWork::new(
                surface.clone(),
                Arc::new(Projection(|p: DVec3| p.normalize() * 0.5)),
                FitOptions { rule, last_level: 5, ..Default::default() },
            )
            .unwrap();
            let o = fit.run().unwrap();
            print!("{name} {rule:?} init {:.4e}:", fit.initial().unwrap().max);
            for r in fit.ladder() {
                print!(" {:.3e}", r.max);
            }
            println!(
                " mean {:.2e} details {} {:?} {:?}",
                fit.ladder().last().unwrap().mean,
                fit.details().count(),
                o,
                t.elapsed()
            );
        }
        let surface = Arc::new(LoopSurface {
            mesh: Arc::new(mesh.clone()),
            points: points.clone(),
            sides: sides.clone(),
            corner_rule: CornerRule::Lattice,
            details: Details::default(),
        });
        let t = std::time::Instant::now();
        let mut fit = FitWork::new(
            surface.clone(),
            Arc::new(Projection(|p: DVec3| p.normalize() * 0.5)),
            FitOptions {
                last_level: 16,
                region: Region::Around { vertex: VertexId(0), rings: 8, from_level: 6 },
                ..Default::default()
            },
        )
        .unwrap();
        let o = fit.run().unwrap();
        let l = fit.ladder();
        for w in l.windows(2) {
            println!(
                "{} here {:.3e} ratio {:.3} details {} samples {}",
                w[1].level,
                w[1].max_here,
                w[0].max_here / w[1].max_here,
                w[1].details,
                w[1].samples
            );
        }
        println!("{o:?} {:?}", t.elapsed());
        for eps in [13e-6, 1e-6, 1e-7] {
            let t = std::time::Instant::now();
            let mut fit = FitWork::new(
                surface.clone(),
                Arc::new(Projection(|p: DVec3| p.normalize() * 0.5)),
                FitOptions { last_level: 16, tolerance: Some(eps), ..Default::default() },
            )
            .unwrap();
            let o = fit.run().unwrap();
            let l = fit.ladder().last().unwrap();
            println!("{eps:e} {:.3e} details {} level {} {o:?} {:?}", l.max, l.details, l.level, t.elapsed());
        }
    }
}
