//! What the options of `edit` make of a material's extension.

use crate::author::medium::{self, surface_ior};
use crate::author::paint::Basis;
use crate::author::paint::coefficients::digits;
use crate::author::{Medium, Reading, nephrite, text::Node};
use crate::cli::Failure;
use crate::cli::author_args::EditArgs;
use crate::cli::author_values::TextureArg;
use crate::optics::seen_color::shares_of_seen_color;
use serde_json::{Map, Value, json};

/// A change that makes sense.
pub(super) struct Change<'a> {
    pub args: &'a EditArgs,
}

impl<'a> Change<'a> {
    /// Checks what was typed as a whole.
    pub fn new(args: &'a EditArgs) -> Result<Self, Failure> {
        let change = Self { args };
        let asked = args.remove || args.fix_surface || change.is_of_medium();
        if asked && args.material.is_empty() {
            return Err(Failure::Usage("say with --material which material to change".to_owned()));
        }
        if !asked && !args.allow_unchanged {
            let which = if args.material.is_empty() { ", and with --material which material" } else { "" };
            let options = "say what to change: --preset, --absorption, --remove, …";
            return Err(Failure::Usage(format!("nothing would change; {options}{which}")));
        }
        Ok(change)
    }

    /// Whether any option says something of the medium.
    fn is_of_medium(&self) -> bool {
        let a = self.args;
        self.makes_a_medium()
            || a.anisotropy.is_some()
            || a.ior.is_some()
            || a.density.is_some()
            || a.priority.is_some()
            || a.absorption_texture.is_some()
            || a.scattering_texture.is_some()
    }

    fn makes_a_medium(&self) -> bool {
        let a = self.args;
        a.preset.is_some()
            || a.absorption.is_some()
            || a.scattering.is_some()
            || a.color.is_some()
            || a.mean_free_path.is_some()
            || a.from_base_color
    }

    /// The members that the extension of a material is to have.
    pub fn applied_to(&self, material: &Value, index: usize) -> Result<Map<String, Value>, Failure> {
        let args = self.args;
        let old = material.pointer(&format!("/extensions/{}", nephrite::NAME)).and_then(Value::as_object);
        if old.is_none() && !self.makes_a_medium() {
            return Err(Failure::advise(
                format!("/materials/{index}: the material has no {} yet", nephrite::NAME),
                "give it a medium by --preset, by --absorption and --scattering, or by --color and --mean-free-path; \
                 or take over one of another extension by `nephrite convert --to nephrite`",
            ));
        }
        let mut members = old.cloned().unwrap_or_default();
        let mut set = |key: &str, value: Value| drop(members.insert(key.to_owned(), value));
        if let Some(preset) = args.preset {
            let medium = preset.with_one_anisotropy();
            set("absorptionCoefficient", json!(medium.sigma_a));
            set("scatteringCoefficient", json!(medium.sigma_s));
            set("scatterAnisotropy", json!(medium.g));
            set("ior", json!(medium.eta));
        }
        let per_metre = |v: [f64; 3]| json!(v.map(|v| args.unit.per_metre(v)));
        for (key, value) in [
            ("absorptionCoefficient", args.absorption.map(per_metre)),
            ("scatteringCoefficient", args.scattering.map(per_metre)),
            ("scatterAnisotropy", args.anisotropy.map(|g| json!(g))),
            ("ior", args.ior.map(|ior| json!(ior))),
            ("priority", args.priority.map(|priority| json!(priority))),
        ] {
            if let Some(value) = value {
                set(key, value);
            }
        }
        if args.preset.is_some() {
            members.remove("densityFactor");
        }
        if args.from_base_color {
            members.remove("densityFactor");
        } else if args.color.is_some() || args.mean_free_path.is_some() {
            self.set_seen_color(material, index, &mut members)?;
        }
        if let Some(density) = args.density {
            members.insert("densityFactor".to_owned(), json!(density));
        }
        for (key, texture) in
            [("absorptionTexture", args.absorption_texture), ("scatteringTexture", args.scattering_texture)]
        {
            match texture {
                Some(TextureArg::Index(index)) => {
                    drop(members.insert(key.to_owned(), json!({ "index": index })))
                }
                Some(TextureArg::None) => drop(members.remove(key)),
                None => {}
            }
        }
        Ok(members)
    }

    /// Both coefficients from the colour and the mean free path; one that is not given is that of the medium before.
    fn set_seen_color(
        &self,
        material: &Value,
        index: usize,
        members: &mut Map<String, Value>,
    ) -> Result<(), Failure> {
        let before = medium_before(material, members);
        let basis = self.basis(material, index, members)?;
        let shares: [[f64; 2]; 3] = match (self.args.color, before) {
            (Some(color), _) => shares_of_colors(color, basis.g, basis.ior),
            (None, Some(m)) if m.sigma_t().iter().all(|t| *t > 0.0) => {
                [0, 1, 2].map(|i| [m.sigma_s[i] / m.sigma_t()[i], m.sigma_a[i] / m.sigma_t()[i]])
            }
            (None, _) => return Err(missing(index, "colour", "--color")),
        };
        members.remove("densityFactor");
        for (key, share) in [("absorptionCoefficient", 1), ("scatteringCoefficient", 0)] {
            let value = [0, 1, 2].map(|i| digits(basis.sigma_t[i] * shares[i][share]));
            members.insert(key.to_owned(), json!(value));
        }
        Ok(())
    }

    /// What colours are put into: the extinction of the mean free path that is given, else of the medium that `members`
    /// and the material say; their anisotropy and index.
    fn basis(&self, material: &Value, index: usize, members: &Map<String, Value>) -> Result<Basis, Failure> {
        let before = medium_before(material, members);
        let ior = material.pointer("/extensions/KHR_materials_ior").map_or(1.5, |_| surface_ior(material));
        let (g, ior) =
            before.map_or((0.0, ior), |m| (m.g, if members.contains_key("ior") { m.ior } else { ior }));
        let sigma_t = match self.args.mean_free_path {
            Some(lengths) => lengths.map(|l| 1.0 / self.args.unit.metres(l)),
            None => before
                .map(|m| m.sigma_t())
                .filter(|t| t.iter().all(|t| *t > 0.0))
                .ok_or_else(|| missing(index, "mean free path", "--mean-free-path"))?,
        };
        Ok(Basis { sigma_t, g, ior })
    }

    /// What the colours of a material's paint are put into; of a material that has no extension of ours yet, the medium
    /// that another one describes counts.
    pub fn basis_of_paint(&self, material: &Value, index: usize) -> Result<Basis, Failure> {
        let mut members = self.applied_to(material, index)?;
        let ours = material.pointer(&format!("/extensions/{}", nephrite::NAME)).is_some();
        let other = medium::read(material).filter(|_| !ours && self.args.preset.is_none());
        if let Some(Reading { medium, .. }) = other {
            for (key, value) in [
                ("absorptionCoefficient", json!(medium.sigma_a)),
                ("scatteringCoefficient", json!(medium.sigma_s)),
                ("scatterAnisotropy", json!(medium.g)),
                ("ior", json!(medium.ior)),
            ] {
                members.entry(key).or_insert(value);
            }
        }
        self.basis(material, index, &members)
    }
}

/// The medium of a material whose extension has these members.
fn medium_before(material: &Value, members: &Map<String, Value>) -> Option<Medium> {
    let mut with = material.clone();
    with["extensions"] = json!({ nephrite::NAME: members });
    nephrite::read(&with).map(|reading| reading.medium)
}

fn missing(index: usize, what: &str, option: &str) -> Failure {
    Failure::advise(
        format!("/materials/{index}: the medium has no {what} that could be kept"),
        format!("give {option}, too"),
    )
}

/// Channels of one colour are inverted once.
fn shares_of_colors(color: [f64; 3], g: f64, eta: f64) -> [[f64; 2]; 3] {
    let red = shares_of_seen_color(color[0], g, eta);
    let green = if color[1] == color[0] { red } else { shares_of_seen_color(color[1], g, eta) };
    let blue = match color[2] {
        c if c == color[0] => red,
        c if c == color[1] => green,
        c => shares_of_seen_color(c, g, eta),
    };
    [red, green, blue]
}

/// Sets what would hide or tint a medium.
pub(super) fn fix_surface(material: &mut Node<'_>, before: &Value) {
    if let Some(surface) = material.object_mut("pbrMetallicRoughness") {
        surface.set("metallicFactor", &json!(0));
        surface.remove("baseColorFactor");
        surface.remove("baseColorTexture");
    }
    if before.get("alphaMode").is_some() {
        material.remove("alphaMode");
        material.remove("alphaCutoff");
    }
}
