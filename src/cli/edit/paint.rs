//! `edit --from-base-color`: paint becomes medium.

use super::change::{self, Change};
use super::{material_of, set_members, thickness};
use crate::asset::painting::{PaintedMaterial, Painting};
use crate::author::paint::images::{self, NewImages};
use crate::author::paint::{Basis, Coat, Colors, PaintError, Tint, coats, document};
use crate::author::text::{Node, Tree};
use crate::author::{khronos, nephrite};
use crate::cli::Failure;
use crate::cli::authored::Authored;
use crate::cli::message::Reporter;
use serde_json::{Value, json};

/// White to half a step of 8 bits.
const WHITE: f32 = 1.0 - 0.5 / 255.0;

/// Takes the paint of the chosen materials into their media; the materials that were changed, new ones among them.
pub(super) fn run(
    tree: &mut Tree<'_>,
    images: &mut NewImages,
    authored: &Authored<'_>,
    change: &Change<'_>,
    chosen: &[usize],
    reporter: &Reporter,
) -> Result<Vec<usize>, Failure> {
    let painting = authored.painting(chosen)?;
    let mut changed = Vec::new();
    let mut cleared: Vec<[usize; 2]> = Vec::new();
    for material in &painting.materials {
        let before = material_of(tree, material.index)?.value().unwrap_or_default();
        check(authored.file.document(), &before, &painting, material, chosen)?;
        let coats = coats::coats(&painting, material, !change.args.fix_surface).map_err(failure)?;
        let ours = before.pointer(&format!("/extensions/{}", nephrite::NAME)).is_some();
        if ours && matches!(&coats[..], [Coat { colors: Colors::Uniform(c), .. }] if c.min_element() >= WHITE)
        {
            reporter.warning(format!(
                "/materials/{}: the base colour is white, so there is no paint to take; the medium stays as it is",
                material.index
            ));
            continue;
        }
        let basis = change.basis_of_paint(&before, material.index)?;
        let mut places = Vec::new();
        for (n, coat) in coats.iter().enumerate() {
            let place = match n {
                0 => material.index,
                _ => {
                    let mut copy = before.clone();
                    if let Some(name) = before.get("name").and_then(Value::as_str) {
                        copy["name"] = json!(format!("{name} {}", n + 1));
                    }
                    images::push(tree.root_mut(), "materials", &copy)
                }
            };
            let job = Job { authored, change, material, basis: &basis, before: &before };
            job.write(tree, images, coat, place)?;
            for &i in &coat.primitives {
                let primitive = &painting.primitives[i];
                let at = [primitive.mesh, primitive.index];
                document::use_material(tree.root_mut(), at, material.index, place);
                if Tint::of(primitive) != Tint::White {
                    cleared.push(at);
                }
            }
            places.push(place);
        }
        if places.len() > 1 {
            let list: Vec<String> = places.iter().map(|i| format!("/materials/{i}")).collect();
            reporter.note(format!(
                "/materials/{}: objects whose vertex colours exclude each other get materials of their own: {}",
                material.index,
                list.join(", ")
            ));
        }
        changed.extend(places);
    }
    for [mesh, primitive] in cleared {
        document::clear_vertex_colors(tree.root_mut(), mesh, primitive);
    }
    Ok(changed)
}

fn failure(error: PaintError) -> Failure {
    Failure::advise(&error, error.advice())
}

/// What cannot be taken into a medium, however it is painted.
fn check(
    document: &Value,
    before: &Value,
    painting: &Painting,
    material: &PaintedMaterial,
    chosen: &[usize],
) -> Result<(), Failure> {
    let index = material.index;
    for other in ["KHR_materials_pbrSpecularGlossiness", "KHR_materials_unlit"] {
        if before.pointer(&format!("/extensions/{other}")).is_some() {
            return Err(Failure::advise(
                format!("/materials/{index}/extensions/{other}: excludes a medium"),
                "convert the material to metallic-roughness first",
            ));
        }
    }
    if let Some(channel) = document::animated_base_color(document, index) {
        return Err(Failure::advise(
            format!("{channel}: moves the base colour of /materials/{index}, which a medium cannot follow"),
            "remove the channel, or give the medium one colour by --color",
        ));
    }
    for primitive in painting.primitives.iter().filter(|p| p.materials.contains(&index)) {
        let other = primitive.materials.iter().find(|m| !chosen.contains(m));
        if let Some(other) = other.filter(|_| Tint::of(primitive) != Tint::White) {
            return Err(Failure::advise(
                format!(
                    "{}/attributes/COLOR_0: the vertex colours are also those of a variant with /materials/{other}",
                    primitive.pointer
                ),
                format!("change it, too: --material {other}"),
            ));
        }
    }
    Ok(())
}

/// A coat that becomes the medium of a material.
struct Job<'a> {
    authored: &'a Authored<'a>,
    change: &'a Change<'a>,
    material: &'a PaintedMaterial,
    basis: &'a Basis,
    /// The material as it was.
    before: &'a Value,
}

impl Job<'_> {
    fn write(
        &self,
        tree: &mut Tree<'_>,
        images: &mut NewImages,
        coat: &Coat,
        place: usize,
    ) -> Result<(), Failure> {
        let index = self.material.index;
        let painted = self.basis.paint(&coat.colors);
        let name = self
            .before
            .get("name")
            .and_then(Value::as_str)
            .map_or(format!("material {place}"), str::to_owned);
        let sampler = self.material.sampler;
        let info = self.material.info.as_ref();
        let mut add = |what: &str, png: Result<Vec<u8>, PaintError>| {
            let texture =
                images.texture(tree.root_mut(), &format!("{name} {what}"), png.map_err(failure)?, sampler);
            Ok::<Value, Failure>(document::texture_info(info, texture))
        };
        let mut coefficient = |what: &str, texels: &Option<(u32, Vec<[u16; 3]>)>| {
            let png = texels.as_ref().map(|(width, texels)| images::png_of_coefficients(*width, texels));
            png.map(|png| add(what, png)).transpose()
        };
        let absorption = coefficient("absorption", &painted.absorption)?;
        let scattering = coefficient("scattering", &painted.scattering)?;
        let alpha = coat
            .alpha
            .texels
            .as_ref()
            .map(|(width, texels)| add("alpha", images::png_of_alpha(*width, texels)));
        let alpha = alpha.transpose()?;

        let mut members = self.change.applied_to(self.before, index)?;
        members.insert("absorptionCoefficient".to_owned(), json!(painted.sigma_a));
        members.insert("scatteringCoefficient".to_owned(), json!(painted.sigma_s));
        document::set_texture(&mut members, "absorptionTexture", absorption);
        document::set_texture(&mut members, "scatteringTexture", scattering);
        if self.basis.g != 0.0 || members.contains_key("scatterAnisotropy") {
            members.insert("scatterAnisotropy".to_owned(), json!(self.basis.g));
        }
        // A density multiplies the coefficients of the mean free path that was asked for.
        if let Some(density) = self.change.args.density {
            members.insert("densityFactor".to_owned(), json!(density));
        }
        let material = material_of(tree, place)?;
        set_members(material, self.before, &members);
        document::neutralise(material, &coat.alpha, alpha);
        if self.change.args.fix_surface {
            change::fix_surface(material, self.before);
        }
        if !self.change.args.no_fallback {
            let density = self.change.args.density.unwrap_or(1.0);
            let mut mean = painted.mean(self.basis);
            mean.sigma_a = mean.sigma_a.map(|v| v * density);
            mean.sigma_s = mean.sigma_s.map(|v| v * density);
            let scene = self.authored.loaded.as_ref().ok().map(|loaded| &loaded.scene);
            khronos::write(material, &mean, thickness(&mean, index, scene), true);
        }
        Ok(())
    }
}

/// Removes the vertex colours of everything that shows these materials, and tells where others need them.
pub(super) fn clear_vertex_colors(
    tree: &mut Tree<'_>,
    document: &Value,
    chosen: &[usize],
    reporter: &Reporter,
) {
    let root: &mut Node<'_> = tree.root_mut();
    for &index in chosen {
        for ([mesh, primitive], materials) in document::colored_primitives(document, index) {
            match materials.iter().find(|m| !chosen.contains(m)) {
                Some(other) => reporter.warning(format!(
                    "/meshes/{mesh}/primitives/{primitive}/attributes/COLOR_0: stays, since a variant shows it with /materials/{other}"
                )),
                None => drop(document::clear_vertex_colors(root, mesh, primitive)),
            }
        }
    }
}
