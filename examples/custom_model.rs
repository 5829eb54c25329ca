//! A subsurface model from another crate: one Gaussian, as skin shaders sum them (d'Eon & Luebke 2007).
//! `cargo run --release --example custom_model -- samples/jade-knot/jade-knot.glb gaussian.png`

use nephrite::optics::diffusion::{BetterDipole, Coefficients, RadialProfile};
use nephrite::subsurface::{Formula, Propagator, Radial, Registry, SubsurfaceModel};
use nephrite::{asset, film, scene::Scene, transport};
use std::{error::Error, f64::consts::TAU, path::Path};

/// R(r) = A/(2πv) e^{−r²/2v}: albedo A, variance v in m².
struct Profile(f64, f64);

impl RadialProfile for Profile {
    fn eval(&self, r: f64) -> f64 {
        self.0 / (TAU * self.1) * (-0.5 * r * r / self.1).exp()
    }
    fn total(&self) -> f64 {
        self.0
    }
}

#[derive(Clone)]
struct Gaussian;

impl Formula for Gaussian {
    fn profile(&self, c: &Coefficients) -> Box<dyn RadialProfile> {
        Box::new(Profile(BetterDipole::new(c).total(), 2.0 * c.transport_mean_free_path().powi(2)))
    }
}

impl SubsurfaceModel for Gaussian {
    fn name(&self) -> &str {
        "gaussian"
    }
    fn summary(&self) -> &str {
        "a Gaussian of the better dipole's albedo, √2 transport mean free paths wide"
    }
    fn prepare(&self, scene: &Scene) -> Box<dyn Propagator> {
        Radial::prepare(Gaussian, scene)
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let [input, output] = [1, 2].map(|i| std::env::args().nth(i).expect("usage: custom_model INPUT OUTPUT"));
    let scene = asset::load(Path::new(&input), &asset::LoadOptions::default())?.scene;
    let camera = scene.cameras.first().cloned().ok_or("the file has no camera")?;
    let mut models = Registry::standard();
    models.register(Box::new(Gaussian));
    let mut options = transport::RenderOptions::new(camera);
    (options.view.width, options.view.height, options.settings.subsurface) = (160, 120, "gaussian".into());
    let rendered = transport::render_with(&Scene::build(scene)?, &options, &(), &models)?;
    film::write(Path::new(&output), &rendered.picture, &film::WriteOptions::default())?;
    Ok(())
}
