//! Who renders: nephrite itself, in this process, or another program.

use super::{Case, CommandTemplate, MAX_PIXELS};
use crate::asset::{self, LoadOptions};
use crate::film::{Film, read_exr};
use crate::optics::Microfacet;
use crate::scene::Scene;
use crate::transport::{RenderControl, RenderOptions, render};

/// One picture of a case.
#[derive(Clone, Copy, Debug)]
pub struct Job<'a> {
    /// The case.
    pub case: &'a Case,
    /// Samples a pixel.
    pub spp: u32,
    /// Seed: another one, another noise.
    pub seed: u32,
}

/// Options of nephrite.
#[derive(Clone, Debug)]
pub struct Own {
    /// Name of the subsurface model.
    pub subsurface: String,
    /// Whether rough surfaces scatter more than once.
    pub microfacet: Microfacet,
    /// Threads, 0 for all.
    pub threads: usize,
}

impl Default for Own {
    fn default() -> Self {
        Self { subsurface: "random-walk".to_owned(), microfacet: Microfacet::Multiple, threads: 0 }
    }
}

/// Who renders.
#[derive(Clone, Debug)]
pub enum Renderer {
    /// nephrite, in this process.
    Own(Own),
    /// Another program.
    Command(CommandTemplate),
}

impl Renderer {
    /// Renders a picture. The error says what went wrong.
    pub(super) fn render(&self, job: &Job<'_>, control: &dyn RenderControl) -> Result<Film, String> {
        let film = match self {
            Self::Own(own) => own.render(job, control),
            Self::Command(template) => {
                let folder = tempfile::Builder::new().prefix("nephrite-").tempdir();
                let folder = folder.map_err(|e| format!("no temporary folder: {e}"))?;
                let output = folder.path().join("picture.exr");
                template.run(job, &output, &|| control.cancelled())?;
                let picture = read_exr(&output, MAX_PIXELS);
                picture
                    .map(|picture| Film::of_picture(&picture, job.spp))
                    .map_err(|e| format!("the picture cannot be read: {e}"))
            }
        }?;
        let Case { width, height, .. } = job.case;
        if (film.width(), film.height()) != (*width, *height) {
            return Err(format!(
                "the picture has {} × {} pixels; {width} × {height} were asked for",
                film.width(),
                film.height()
            ));
        }
        Ok(film)
    }

    /// Whether renders with different seeds differ.
    pub(super) fn has_seed(&self) -> bool {
        match self {
            Self::Own(_) => true,
            Self::Command(template) => template.has_seed(),
        }
    }
}

impl Own {
    fn render(&self, job: &Job<'_>, control: &dyn RenderControl) -> Result<Film, String> {
        let loaded =
            asset::load(&job.case.asset(), &LoadOptions::default()).map_err(|e| e.to_string())?.scene;
        let camera = loaded.cameras.first().cloned().ok_or("the asset has no camera")?;
        let scene = Scene::build(loaded).map_err(|e| e.to_string())?;
        let options = RenderOptions::new(camera).with(|o| {
            o.view.width = job.case.width;
            o.view.height = job.case.height;
            o.samples.count = job.spp;
            o.settings.seed = job.seed;
            o.threads = self.threads;
            o.settings.subsurface = self.subsurface.clone();
            o.settings.microfacet = self.microfacet;
        });
        let rendered = render(&scene, &options, control).map_err(|e| e.to_string())?;
        if rendered.spp < job.spp {
            return Err("interrupted".to_owned());
        }
        Ok(rendered.film)
    }
}
