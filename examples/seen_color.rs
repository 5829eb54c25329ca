//! Draws `docs/authoring/seen-color.png`: the colour one sees against the multi-scatter albedo of the Khronos drafts, for
//! several indices and anisotropies.
//!
//!     cargo run --release --example seen_color -- docs/authoring/seen-color.png

use nephrite::film::figure::{Axis, PALETTE, Plot, REFERENCE, Series, Style};
use nephrite::optics::diffusion::inversion::{similarity, single_from_similarity};
use nephrite::optics::seen_color::seen_color;
use std::error::Error;
use std::path::Path;

const POINTS: u32 = 60;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("give the name of a .png")?;
    let curve = |g: f64, eta: f64| {
        let point = |i: u32| {
            let rho = f64::from(i) / f64::from(POINTS);
            (rho, seen_color(single_from_similarity(similarity(rho), g).clamp(0.0, 1.0), g, eta))
        };
        (0..=POINTS).map(point).collect::<Vec<_>>()
    };
    let mut series = Vec::new();
    for (i, eta) in [1.0, 1.2, 1.33, 1.5, 1.8].into_iter().enumerate() {
        let line = Series::new(format!("index {eta}, g 0"), Style::Line, curve(0.0, eta));
        series.push(Series { color: Some(PALETTE[i]), ..line });
    }
    let forward: Vec<_> = curve(0.8, 1.5).into_iter().step_by(4).collect();
    series
        .push(Series { color: Some(PALETTE[3]), ..Series::new("index 1.5, g 0.8", Style::Markers, forward) });
    let same = Series::new("seen as written", Style::Line, [(0.0, 0.0), (1.0, 1.0)]);
    series.push(Series { color: Some(REFERENCE), ..same });
    let plot = Plot {
        title: "What a multi-scatter albedo looks like".to_owned(),
        x: Axis::linear("multi-scatter albedo ρ (KHR_materials_scatter, OpenPBR)").with_range(0.0, 1.0),
        y: Axis::linear("seen colour C").with_range(0.0, 1.0),
        series,
        width: 900,
        height: 760,
    };
    plot.draw()?.write_png(Path::new(&path), &[])?;
    Ok(())
}
