//! Vertex colours into a picture, through texture coordinates.
//!
//! Triangles are drawn at texel centres in the coordinates of the texture, before its wrapping, and each texel that a
//! triangle goes to is brought back as the sampler does. A texel takes the colour of the triangle that it lies deepest in;
//! next to a triangle, within the reach of bilinear filters, it takes the nearest colour of it. Whether that was right is
//! judged by the result: the picture is looked up at points of all triangles and compared with the colours there, by area.

use super::{PaintError, Why};
use crate::asset::painting::PaintedPrimitive;
use crate::scene::{TextureDescription, TextureRef, Wrap};
use glam::{Vec2, Vec4};

/// Texels around a triangle that filters may look up.
const REACH: f32 = 1.5;
/// Visits of texels beyond which texture coordinates are taken for a repeated texture.
const MOST_VISITS: f64 = 2.7e8;
/// Texels of a triangle in the mean, and sides of pictures that are raised to that.
const TEXELS_OF_TRIANGLE: f64 = 64.0;
const LONGEST_RAISED: u32 = 2048;
/// A difference of square roots of linear colours that is seen, and the share of surface that may be off by it: edges
/// between flat colours.
const SEEN: f32 = 0.08;
const TOLERATED: f64 = 0.01;

/// Where a texture is looked up, and how.
#[derive(Clone, Copy, Debug)]
pub struct Unwrapping {
    /// Its sampler.
    pub texture: TextureDescription,
    /// Set of coordinates and their transform.
    pub reference: TextureRef,
}

/// A picture of colours at vertices.
#[derive(Debug)]
pub struct Baked {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Row by row; what no triangle comes near has the mean of the others.
    pub colors: Vec<Vec4>,
}

/// A triangle in texels.
struct Flat {
    corners: [Vec2; 3],
    colors: [Vec4; 3],
    /// Which primitive it is of, and its area in space.
    primitive: usize,
    area: f64,
}

/// Draws the colours of primitives, `plain` ones as white, into a picture of at least `size`.
pub(crate) fn bake(
    primitives: &[(&PaintedPrimitive, bool)],
    unwrapping: &Unwrapping,
    size: [u32; 2],
) -> Result<Baked, PaintError> {
    let mut triangles = flat(primitives, unwrapping)?;
    let [width, height] = raised(&triangles, size);
    let scale = Vec2::new(width as f32, height as f32);
    triangles.iter_mut().for_each(|t| t.corners = t.corners.map(|c| c * scale));
    let visits: f64 = triangles.iter().map(|t| t.texels().map_or(f64::INFINITY, |r| r.visits())).sum();
    let pointer = |i: usize| primitives[i].0.pointer.clone();
    if visits > MOST_VISITS {
        let most = triangles.iter().max_by(|a, b| a.reach().total_cmp(&b.reach())).map_or(0, |t| t.primitive);
        return Err(PaintError::Shared { pointer: pointer(most), share: 1.0, why: Why::Tiling });
    }
    let wraps = [unwrapping.texture.wrap_u, unwrapping.texture.wrap_v];
    let baked = draw(&triangles, [width, height], wraps);
    judge(&triangles, &baked, wraps, primitives.len()).map_err(|(worst, share, why)| PaintError::Shared {
        pointer: pointer(worst),
        share,
        why,
    })?;
    Ok(baked)
}

/// All triangles, in units of the texture.
fn flat(primitives: &[(&PaintedPrimitive, bool)], unwrapping: &Unwrapping) -> Result<Vec<Flat>, PaintError> {
    let set = unwrapping.reference.uv_set;
    let mut all = Vec::new();
    for (i, (primitive, plain)) in primitives.iter().enumerate() {
        let shape = &primitive.shape;
        let uvs = shape.uvs.get(set).filter(|uvs| uvs.len() == shape.positions.len());
        let uvs = uvs.ok_or_else(|| PaintError::NoTexCoords { pointer: primitive.pointer.clone(), set })?;
        for corners in &shape.triangles {
            let [a, b, c] = corners.map(|v| shape.positions[v as usize].as_dvec3());
            let color = |v: u32| match shape.colors.get(v as usize) {
                Some(color) if !plain => color.clamp(Vec4::ZERO, Vec4::ONE),
                _ => Vec4::ONE,
            };
            let at = |v: u32| unwrapping.reference.transform.transform_point2(uvs[v as usize]);
            all.push(Flat {
                corners: corners.map(at).map(|p| if p.is_finite() { p } else { Vec2::ZERO }),
                colors: corners.map(color),
                primitive: i,
                area: 0.5 * (b - a).cross(c - a).length(),
            });
        }
    }
    Ok(all)
}

/// The size of a picture that has some texels for a triangle of middle size: `size` times a power of two.
fn raised(triangles: &[Flat], [mut width, mut height]: [u32; 2]) -> [u32; 2] {
    let area: f64 = triangles.iter().map(|t| f64::from(t.doubled_area().abs()) / 2.0).sum();
    let wanted = TEXELS_OF_TRIANGLE * triangles.len() as f64 / area.max(1e-6);
    while f64::from(width) * f64::from(height) < wanted && width.max(height) * 2 <= LONGEST_RAISED {
        (width, height) = (2 * width, 2 * height);
    }
    [width, height]
}

/// Texels from and to, both included.
struct Rectangle {
    low: [i64; 2],
    high: [i64; 2],
}

impl Rectangle {
    fn visits(&self) -> f64 {
        (0..2).map(|i| (self.high[i] - self.low[i] + 1).max(0) as f64).product()
    }
}

impl Flat {
    fn doubled_area(&self) -> f32 {
        let [a, b, c] = self.corners;
        (b - a).perp_dot(c - a)
    }

    /// The texels that it may be drawn to; `None` where that is beyond all bounds.
    fn texels(&self) -> Option<Rectangle> {
        const FARTHEST: f32 = 1e6;
        let [a, b, c] = self.corners;
        let (low, high) = (a.min(b).min(c) - REACH - 0.5, a.max(b).max(c) + REACH - 0.5);
        let fits = low.min_element() > -FARTHEST && high.max_element() < FARTHEST;
        let [low, high] = [low.ceil(), high.floor()].map(|p| [p.x as i64, p.y as i64]);
        fits.then_some(Rectangle { low, high })
    }

    fn reach(&self) -> f32 {
        let [a, b, c] = self.corners;
        (a.max(b).max(c) - a.min(b).min(c)).max_element()
    }

    /// How far outside of the triangle a point is, below 0 inside, and the colour at the nearest of its points.
    fn look(&self, p: Vec2) -> (f32, Vec4) {
        let [a, b, c] = self.corners;
        let doubled = self.doubled_area();
        let blend = |w: [f32; 3]| self.colors[0] * w[0] + self.colors[1] * w[1] + self.colors[2] * w[2];
        // Each opposite to the corner of its number.
        let edges = [(b, c), (c, a), (a, b)];
        let longest = edges.map(|(from, to)| from.distance(to)).into_iter().fold(0.0, f32::max);
        // A sliver, or a point: what counts is how far its edges are.
        let mut inside = doubled.abs() > 1e-6 * longest.max(1.0);
        let mut depth = f32::INFINITY;
        let mut weights = [0.0; 3];
        if inside {
            for (i, (from, to)) in edges.into_iter().enumerate() {
                let across = (to - from).perp_dot(p - from) * doubled.signum();
                weights[i] = across / doubled.abs();
                depth = depth.min(across / from.distance(to).max(f32::MIN_POSITIVE));
                inside &= across >= 0.0;
            }
        }
        if inside {
            return (-depth, blend(weights));
        }
        let mut nearest = (f32::INFINITY, Vec4::ONE);
        for (i, (from, to)) in edges.into_iter().enumerate() {
            let along = to - from;
            let t = ((p - from).dot(along) / along.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
            let distance = p.distance(from + along * t);
            if distance < nearest.0 {
                let mut w = [0.0; 3];
                (w[(i + 1) % 3], w[(i + 2) % 3]) = (1.0 - t, t);
                nearest = (distance, blend(w));
            }
        }
        nearest
    }
}

fn draw(triangles: &[Flat], [width, height]: [u32; 2], wraps: [Wrap; 2]) -> Baked {
    let count = width as usize * height as usize;
    let mut colors = vec![Vec4::ZERO; count];
    let mut depths = vec![f32::INFINITY; count];
    for triangle in triangles {
        let Some(Rectangle { low, high }) = triangle.texels() else { continue };
        for y in low[1]..=high[1] {
            let row = brought_back(y, height, wraps[1]) * width as usize;
            for x in low[0]..=high[0] {
                let (outside, color) = triangle.look(Vec2::new(x as f32 + 0.5, y as f32 + 0.5));
                let at = row + brought_back(x, width, wraps[0]);
                if outside <= REACH && outside < depths[at] {
                    (depths[at], colors[at]) = (outside, color);
                }
            }
        }
    }
    let drawn = || depths.iter().zip(&colors).filter(|(depth, _)| depth.is_finite());
    let sum: glam::DVec4 = drawn().map(|(_, color)| color.as_dvec4()).sum();
    let mean = (sum / drawn().count().max(1) as f64).as_vec4();
    colors.iter_mut().zip(&depths).filter(|(_, d)| !d.is_finite()).for_each(|(color, _)| *color = mean);
    Baked { width, height, colors }
}

/// The column or row that a sampler takes for one outside.
fn brought_back(i: i64, n: u32, wrap: Wrap) -> usize {
    let n = i64::from(n);
    let i = match wrap {
        Wrap::Repeat => i.rem_euclid(n),
        Wrap::MirroredRepeat => {
            let i = i.rem_euclid(2 * n);
            if i < n { i } else { 2 * n - 1 - i }
        }
        Wrap::ClampToEdge => i.clamp(0, n - 1),
    };
    usize::try_from(i).unwrap_or(0)
}

/// Compares what a bilinear filter finds with what the vertices say; else the primitive that is worst, the share of all
/// surface that is off, and why.
fn judge(
    triangles: &[Flat],
    baked: &Baked,
    wraps: [Wrap; 2],
    primitives: usize,
) -> Result<(), (usize, f64, Why)> {
    const POINTS: [[f32; 3]; 4] = [
        [1.0 / 3.0; 3],
        [2.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0],
        [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0],
        [1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0],
    ];
    let look_up = |p: Vec2| {
        let (base, t) = ((p - 0.5).floor(), (p - 0.5).fract_gl());
        let texel = |dx: i64, dy: i64| {
            let x = brought_back(base.x as i64 + dx, baked.width, wraps[0]);
            baked.colors[brought_back(base.y as i64 + dy, baked.height, wraps[1]) * baked.width as usize + x]
        };
        texel(0, 0).lerp(texel(1, 0), t.x).lerp(texel(0, 1).lerp(texel(1, 1), t.x), t.y)
    };
    let root = |c: Vec4| c.max(Vec4::ZERO).map(f32::sqrt);
    let mut off = vec![0.0; primitives];
    let (mut all, mut tiled, mut tiny) = (0.0, 0.0, 0.0);
    let size = Vec2::new(baked.width as f32, baked.height as f32);
    for triangle in triangles {
        for weights in POINTS {
            let blend = |v: [Vec4; 3]| v[0] * weights[0] + v[1] * weights[1] + v[2] * weights[2];
            let p = blend(triangle.corners.map(|c| c.extend(0.0).extend(0.0))).truncate().truncate();
            let part = triangle.area / POINTS.len() as f64;
            all += part;
            if (root(look_up(p)) - root(blend(triangle.colors))).abs().max_element() > SEEN {
                off[triangle.primitive] += part;
                let outside = p.min_element() < 0.0 || p.x > size.x || p.y > size.y;
                tiled += if outside { part } else { 0.0 };
                tiny += if triangle.reach() < 1.0 { part } else { 0.0 };
            }
        }
    }
    let sum: f64 = off.iter().sum();
    if sum <= TOLERATED * all {
        return Ok(());
    }
    let worst = (0..primitives).max_by(|&a, &b| off[a].total_cmp(&off[b])).unwrap_or(0);
    let why = match () {
        () if 2.0 * tiled > sum => Why::Tiling,
        () if 2.0 * tiny > sum => Why::Tiny,
        () => Why::Overlap,
    };
    Err((worst, sum / all, why))
}
