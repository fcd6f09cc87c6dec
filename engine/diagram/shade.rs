//! Lit and pseudo-coloured surfaces.
//!
//! The studio stands still about the eye: a soft key light from the upper left, a fill from the
//! right, a rim light from behind, and a sky brighter than the ground. Light adds up linearly and
//! is encoded to sRGB last.

use glam::{DVec2, DVec3};
use selvedge_components::triangles::Triangles;

use super::camera::Camera;
use super::canvas::Canvas;
use super::colour::{Colour, encode_above, palette};
use super::colourmap::ColourScale;
use super::error::DiagramError;
use super::raster::{DepthBuffer, NOTHING, Seen};

/// Where the colour of a surface comes from.
#[derive(Clone, Copy, Debug)]
pub enum Paint<'a> {
    /// One colour, lit.
    Uniform(Colour),
    /// [`Triangles::colours`], lit.
    Vertices,
    /// A number at each vertex, shown by a scale; the light is turned down, so that colours can be
    /// compared with the bar. NaN is grey.
    Values(&'a [f64], &'a ColourScale),
}

/// Are normals carried over from triangle to triangle?
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Facets {
    /// [`Triangles::normals`], or where there are none the mean of the normals about each vertex.
    Smooth,
    /// Every triangle is flat.
    Flat,
}

/// A surface of a scene.
#[derive(Clone, Copy, Debug)]
pub struct Surface<'a> {
    /// Its triangles.
    pub mesh: &'a Triangles,
    /// Where its colour comes from.
    pub paint: Paint<'a>,
    /// How its normals are made.
    pub facets: Facets,
}

impl<'a> Surface<'a> {
    /// A smooth surface of the engine's own clay.
    pub const fn new(mesh: &'a Triangles) -> Self {
        Self { mesh, paint: Paint::Uniform(palette::CLAY), facets: Facets::Smooth }
    }

    /// The same surface in another paint.
    #[must_use]
    pub const fn painted(self, paint: Paint<'a>) -> Self {
        Self { paint, ..self }
    }

    /// The same surface, faceted.
    #[must_use]
    pub const fn faceted(self) -> Self {
        Self { facets: Facets::Flat, ..self }
    }

    /// Everything the drawing relies on.
    pub(super) fn check(&self) -> Result<(), DiagramError> {
        let count = self.mesh.positions.len();
        if let Some(vertex) = self.mesh.positions.iter().position(|p| !p.is_finite()) {
            let at = self.mesh.positions[vertex];
            return Err(DiagramError::NotFinite { what: "a surface", vertex, at });
        }
        for (triangle, corners) in self.mesh.triangles.iter().enumerate() {
            if let Some(&vertex) = corners.iter().find(|&&vertex| vertex as usize >= count) {
                return Err(DiagramError::IndexOutOfRange { triangle, vertex, count });
            }
        }
        let expect = |what, found| match found == count {
            true => Ok(()),
            false => Err(DiagramError::Count { what, found, expected: count }),
        };
        if !self.mesh.normals.is_empty() {
            expect("normals", self.mesh.normals.len())?;
        }
        match self.paint {
            Paint::Uniform(_) => Ok(()),
            Paint::Vertices => expect("colours", self.mesh.colours.len()),
            Paint::Values(values, _) => expect("values", values.len()),
        }
    }
}

/// A surface as a camera sees it.
pub(super) struct Layer<'a> {
    surface: Surface<'a>,
    corners: Vec<DVec3>,
    depths: Vec<f64>,
    normals: Vec<DVec3>,
    /// The number of its first triangle among those of the scene.
    first: u32,
}

impl<'a> Layer<'a> {
    /// Projects a surface that was checked.
    pub fn new(surface: Surface<'a>, camera: &Camera, first: u32) -> Self {
        let mesh = surface.mesh;
        let world = match surface.facets {
            Facets::Flat => Vec::new(),
            Facets::Smooth if !mesh.normals.is_empty() => mesh.normals.clone(),
            Facets::Smooth => mean_normals(mesh),
        };
        Self {
            surface,
            corners: mesh.positions.iter().map(|&p| camera.homogeneous(p)).collect(),
            depths: mesh.positions.iter().map(|&p| camera.depth(p)).collect(),
            normals: world.into_iter().map(|normal| camera.turn(normal)).collect(),
            first,
        }
    }

    /// The number after that of its last triangle.
    pub fn end(&self) -> u32 {
        self.first + self.surface.mesh.triangles.len() as u32
    }

    /// Enters its triangles into the buffer.
    pub fn rasterise(&self, buffer: &mut DepthBuffer, camera: &Camera) {
        for (id, triangle) in (self.first..).zip(&self.surface.mesh.triangles) {
            if let Some((seen, corners)) = self.seen(triangle, camera) {
                buffer.draw(id, &seen, corners);
            }
        }
    }

    fn seen(&self, triangle: &[u32; 3], camera: &Camera) -> Option<(Seen, [DVec3; 3])> {
        let corners = triangle.map(|vertex| self.corners[vertex as usize]);
        let depths = triangle.map(|vertex| self.depths[vertex as usize]);
        Seen::new(corners, depths, camera).map(|seen| (seen, corners))
    }

    /// Linear light that triangle `id` sends to the eye at a pixel.
    fn light(&self, id: u32, at: DVec2, camera: &Camera) -> [f32; 3] {
        let triangle = &self.surface.mesh.triangles[(id - self.first) as usize];
        let Some((seen, _)) = self.seen(triangle, camera) else { return [0.0; 3] };
        let weights = seen.barycentric(at);
        let eye = camera.towards_eye(at);
        let normal = self.normal(triangle, weights, &seen, camera);
        match self.surface.paint {
            Paint::Uniform(colour) => lit(side(colour.to_linear(), &seen), normal, eye),
            Paint::Vertices => {
                let colours = triangle.map(|vertex| self.surface.mesh.colours[vertex as usize]);
                let mixed = [0, 1, 2].map(|c| (0..3).map(|i| weights[i] as f32 * colours[i][c]).sum());
                lit(side(mixed, &seen), normal, eye)
            }
            Paint::Values(values, scale) => {
                let value = (0..3).map(|i| weights[i] * values[triangle[i] as usize]).sum();
                dimly_lit(side(scale.colour(value), &seen), normal)
            }
        }
    }

    /// The unit normal on the side that is seen, along the picture's axes.
    fn normal(&self, triangle: &[u32; 3], weights: [f64; 3], seen: &Seen, camera: &Camera) -> DVec3 {
        let smooth = match self.surface.facets {
            Facets::Smooth => (0..3).map(|i| weights[i] * self.normals[triangle[i] as usize]).sum::<DVec3>(),
            Facets::Flat => DVec3::ZERO,
        };
        let outward = smooth.try_normalize().unwrap_or_else(|| {
            let [a, b, c] = triangle.map(|vertex| self.surface.mesh.positions[vertex as usize]);
            camera.turn((b - a).cross(c - a)).normalize_or(DVec3::Z)
        });
        if seen.front { outward } else { -outward }
    }
}

/// The mean of the unit normals of the triangles about each vertex, weighed by their angles there
/// [Thuermer, Wuethrich 1998]: it does not depend on how flat parts are cut into triangles.
fn mean_normals(mesh: &Triangles) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; mesh.positions.len()];
    for triangle in &mesh.triangles {
        let at = triangle.map(|vertex| mesh.positions[vertex as usize]);
        let Some(normal) = (at[1] - at[0]).cross(at[2] - at[0]).try_normalize() else { continue };
        for i in 0..3 {
            let (next, last) = (at[(i + 1) % 3] - at[i], at[(i + 2) % 3] - at[i]);
            normals[triangle[i] as usize] += next.angle_between(last) * normal;
        }
    }
    normals
}

/// The back of a surface is warmer than its front.
fn side(colour: [f32; 3], seen: &Seen) -> [f32; 3] {
    const BACK: [f32; 3] = [0.98, 0.68, 0.48];
    if seen.front { colour } else { [0, 1, 2].map(|i| colour[i] * BACK[i]) }
}

/// A lamp of the studio.
struct Lamp {
    /// Towards it, along the picture's axes (right, up, towards the eye), unit length.
    towards: DVec3,
    /// How far around the edge of its shadow it still reaches: the sine of that angle.
    wrap: f64,
    /// Its light, linear.
    light: [f32; 3],
}

/// A wide warm lamp from the upper left.
const KEY: Lamp = Lamp {
    towards: DVec3::new(-0.495_365_248_565, 0.614_252_908_220, 0.614_252_908_220),
    wrap: 0.12,
    light: [0.86, 0.83, 0.78],
};
/// A weak cool one from the right.
const FILL: Lamp = Lamp {
    towards: DVec3::new(0.857_536_562_919, 0.100_886_654_461, 0.504_433_272_305),
    wrap: 0.30,
    light: [0.10, 0.12, 0.15],
};
/// One behind the object, low on the right: it lifts the dark side off its own shadow, and does not
/// pale the lit side against the paper.
const RIM: Lamp = Lamp {
    towards: DVec3::new(0.591_363_663_628, -0.483_842_997_513, -0.645_123_996_685),
    wrap: 0.25,
    light: [0.20, 0.20, 0.22],
};
/// From all sides: above, and below.
const SKY: [f32; 3] = [0.18, 0.195, 0.22];
const GROUND: [f32; 3] = [0.145, 0.135, 0.125];

impl Lamp {
    fn falls_on(&self, normal: DVec3) -> f32 {
        ((normal.dot(self.towards) + self.wrap) / (1.0 + self.wrap)).max(0.0) as f32
    }
}

/// The light that falls on a surface with this normal; about one where it faces the key light.
fn exposure(normal: DVec3) -> [f32; 3] {
    let up = (0.5 + 0.5 * normal.y) as f32;
    let [key, fill, rim] = [&KEY, &FILL, &RIM].map(|lamp| lamp.falls_on(normal));
    [0, 1, 2].map(|i| {
        let around = GROUND[i] + up * (SKY[i] - GROUND[i]);
        around + key * KEY.light[i] + fill * FILL.light[i] + rim * RIM.light[i]
    })
}

/// Matt with a faint broad gloss, a little darker where it turns away, so that outlines stand out
/// from the paper.
fn lit(colour: [f32; 3], normal: DVec3, eye: DVec3) -> [f32; 3] {
    const GLOSS: f64 = 0.07;
    let half = (KEY.towards + eye).normalize_or(KEY.towards);
    let gloss = (GLOSS * normal.dot(half).max(0.0).powi(36)) as f32;
    let grazing = 1.0 - normal.dot(eye).abs().min(1.0);
    let edge = (1.0 - 0.35 * grazing.powi(3)) as f32;
    let light = exposure(normal);
    [0, 1, 2].map(|i| colour[i] * light[i] * edge + gloss)
}

/// Only as much light and shade as shows the shape.
fn dimly_lit(colour: [f32; 3], normal: DVec3) -> [f32; 3] {
    let green = f64::from(exposure(normal)[1]);
    let shade = (0.66 + 0.36 * green).min(1.0) as f32;
    colour.map(|channel| channel * shade)
}

/// Writes what the samples see onto the canvas; where they see nothing, the canvas stays.
///
/// A triangle is shaded once a pixel, at the mean of the samples that see it.
pub(super) fn develop(buffer: &DepthBuffer, layers: &[Layer<'_>], camera: &Camera, canvas: &mut Canvas) {
    let n = buffer.per_side();
    let offsets: Vec<DVec2> = (0..n * n).map(|k| buffer.offset(k % n, k / n)).collect();
    let mut groups: Vec<Group> = Vec::with_capacity(n * n);
    for y in 0..canvas.height() {
        for (x, pixel) in canvas.row_mut(y).iter_mut().enumerate() {
            gather(buffer, x, y as usize, &offsets, &mut groups);
            if matches!(groups[..], [Group { owner: NOTHING, .. }]) {
                continue;
            }
            let corner = DVec2::new(x as f64, f64::from(y));
            let ground = Colour { rgb: [pixel[0], pixel[1], pixel[2]], alpha: 255 }.to_linear();
            let mut sum = [0.0_f32; 3];
            for group in &groups {
                let at = corner + group.sum / f64::from(group.count);
                let light = match layers.iter().find(|layer| group.owner < layer.end()) {
                    // What is brighter than the page is cut off triangle by triangle, so that edges stay smooth.
                    Some(layer) => layer.light(group.owner, at, camera).map(|c| c.min(1.0)),
                    None => ground,
                };
                sum = [0, 1, 2].map(|i| sum[i] + group.count as f32 * light[i]);
            }
            let level = threshold(x as u32, y);
            let [red, green, blue] = sum.map(|light| encode_above(light / (n * n) as f32, level));
            *pixel = [red, green, blue, 255];
        }
    }
}

/// Samples of one pixel that see the same triangle.
struct Group {
    owner: u32,
    count: u32,
    /// The sum of their places, seen from the corner of the pixel.
    sum: DVec2,
}

/// Sorts the samples of a pixel by what they see.
fn gather(buffer: &DepthBuffer, x: usize, y: usize, offsets: &[DVec2], groups: &mut Vec<Group>) {
    groups.clear();
    for (j, offsets) in offsets.chunks(buffer.per_side()).enumerate() {
        for (&owner, &at) in buffer.owners(x, y, j).iter().zip(offsets) {
            match groups.iter_mut().find(|group| group.owner == owner) {
                Some(group) => {
                    group.count += 1;
                    group.sum += at;
                }
                None => groups.push(Group { owner, count: 1, sum: at }),
            }
        }
    }
}

/// The part of a step of code above which a pixel takes the next one: it differs from pixel to
/// pixel, so that smooth shades have no bands [Jimenez 2014, interleaved gradient noise].
fn threshold(x: u32, y: u32) -> f32 {
    let along = (0.067_110_56 * f64::from(x) + 0.005_837_15 * f64::from(y)).fract();
    (52.982_918_9 * along).fract() as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lamps_stand_in_unit_directions() {
        for lamp in [KEY, FILL, RIM] {
            assert!((lamp.towards.length() - 1.0).abs() < 1e-11);
        }
    }

    #[test]
    fn nothing_is_black_and_what_faces_the_key_is_brightest() {
        let brightest = exposure(KEY.towards)[1];
        assert!((0.9..1.1).contains(&brightest));
        for i in 0..2000 {
            let (z, turn) = (f64::from(i) / 999.5 - 1.0, 2.4 * f64::from(i));
            let flat = (1.0 - z * z).max(0.0).sqrt();
            let normal = DVec3::new(flat * turn.cos(), flat * turn.sin(), z);
            assert!((0.1..1.08 * brightest).contains(&exposure(normal)[1]));
            assert!(lit([0.5; 3], normal, DVec3::Z).iter().all(|light| *light > 0.03));
        }
    }

    /// Over any square of a few pixels, thresholds are spread evenly over a step.
    #[test]
    fn thresholds_are_spread_evenly() {
        for corner in [0, 100, 1234] {
            let square = (0..8).flat_map(|y| (0..8).map(move |x| threshold(corner + x, corner + y)));
            let mean = square.sum::<f32>() / 64.0;
            assert!((mean - 0.5).abs() < 0.04, "{mean}");
        }
    }

    /// Cutting a flat side of a cube into more triangles does not tilt the normals of its corners.
    #[test]
    fn mean_normals_do_not_depend_on_the_diagonals() {
        let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(1.0, 1.0, 0.0)];
        let walls = [[0, 3, 2], [0, 1, 3]];
        let whole = [[0, 4, 1], [0, 2, 4]];
        let mesh = |ground: &[[u32; 3]]| Triangles {
            positions: positions.clone(),
            triangles: walls.iter().chain(ground).copied().collect(),
            ..Triangles::default()
        };
        let cut = mean_normals(&mesh(&whole))[0];
        let uncut = mean_normals(&mesh(&[[0, 2, 1]]))[0];
        assert!(cut.distance(uncut) < 1e-15);
        assert!((cut.normalize() + DVec3::ONE.normalize()).length() < 1e-12, "the corner of a cube looks outward");
    }
}
