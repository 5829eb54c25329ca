//! Plug-ins for glTF extensions: one file an extension, one line in [`Registry::standard`].
//!
//! An [`Extension`] hooks into the loader wherever its JSON object may appear; every hook does nothing by default.
//! Hooks run in ascending [`order`](Extension::order), so that of two extensions that set the same thing the higher
//! one wins. That is how the precedence of media is said: `NEPHRITE_materials_subsurface` over `KHR_materials_scatter`
//! over `KHR_materials_volume_scatter` over `KHR_materials_volume`. Nothing is ever added up.
//!
//! A crate that uses nephrite adds its own with [`Registry::register`] and passes the registry in
//! [`LoadOptions`](crate::asset::LoadOptions). An extension of the same name replaces the one that was there.

mod animation_pointer;
mod anisotropy;
mod camera_physical;
mod clearcoat;
mod coat;
mod diffuse_roughness;
mod diffuse_transmission;
mod dispersion;
mod draco;
mod drafts;
mod emissive_strength;
mod fuzz;
mod gpu_instancing;
mod ior;
mod iridescence;
mod lights_area;
mod lights_ies;
mod lights_image_based;
mod lights_punctual;
mod mesh_manifold;
mod mesh_quantization;
mod meshopt;
mod node_visibility;
mod scatter;
mod seen_surface;
mod sheen;
mod specular;
mod specular_glossiness;
mod subsurface;
mod texture_ktx;
mod texture_transform;
mod texture_webp;
mod transmission;
mod unlit;
mod variants;
mod volume;

use std::sync::Arc;

use glam::DAffine3;

use crate::asset::{
    AssetError, Bytes, DecodedPrimitive, ImageSource, Json, Limits, Loader, MergedVertices, MutableProperty,
    NodeContext,
};
use crate::scene::{CameraDescription, ImageData, MaterialDescription, TextureRef};

/// Usual values of [`Extension::order`]; anything between is allowed.
pub mod order {
    /// Parameters of the surface: index of refraction, specular, transmission.
    pub const SURFACE: i32 = 0;
    /// Media from the weakest claim (`KHR_materials_volume`) …
    pub const VOLUME: i32 = 100;
    /// … over `KHR_materials_volume_scatter` …
    pub const VOLUME_SCATTER: i32 = 110;
    /// … and `KHR_materials_scatter` …
    pub const SCATTER: i32 = 120;
    /// … to the strongest (`NEPHRITE_materials_subsurface`).
    pub const SUBSURFACE: i32 = 200;
}

/// A glTF extension that the loader understands.
///
/// In every hook `own` is the extension's own JSON object. Complaints go to the loader
/// ([`Loader::warn`], [`Loader::invalid`]); an error ends the load.
pub trait Extension: Send + Sync {
    /// Name as in `extensionsUsed`.
    fn name(&self) -> &str;

    /// When the hooks of this extension run among those of others: ascending, the last to set a value wins.
    fn order(&self) -> i32 {
        order::SURFACE
    }

    /// What of the extension is *not* honoured, for `inspect`; `None` if all of it is.
    fn shortfall(&self) -> Option<&str> {
        None
    }

    /// Reads the extension of a material. `material` is the glTF material, `out` what has been made of it so far.
    ///
    /// # Errors
    /// Where the extension's content makes no sense.
    fn material(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
        material: &Json<'_>,
        out: &mut MaterialDescription,
    ) -> Result<(), AssetError> {
        let _ = (loader, own, material, out);
        Ok(())
    }

    /// Called once everything has been read and images are decoded: what can be said only of the whole.
    ///
    /// # Errors
    /// Where the load is strict, and something is against the rules.
    fn finish(&self, loader: &mut Loader<'_>) -> Result<(), AssetError> {
        let _ = loader;
        Ok(())
    }

    /// Reads the extension of a `textureInfo`.
    ///
    /// # Errors
    /// Where the extension's content makes no sense.
    fn texture_info(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
        out: &mut TextureRef,
    ) -> Result<(), AssetError> {
        let _ = (loader, own, out);
        Ok(())
    }

    /// The image that a texture should use instead of its `source`; `None` to leave it.
    ///
    /// # Errors
    /// Where the extension's content makes no sense.
    fn texture_source(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
    ) -> Result<Option<ImageSource>, AssetError> {
        let _ = (loader, own);
        Ok(None)
    }

    /// Bytes that an image file of a kind that core glTF lacks will take once decoded, from its header alone; `None`
    /// if `bytes` are not of that kind, or are broken.
    fn image_bytes(&self, bytes: &[u8]) -> Option<u64> {
        let _ = bytes;
        None
    }

    /// Decodes an image file of a kind that core glTF lacks; `None` if `bytes` are not of that kind. Called for
    /// every image that is neither PNG nor JPEG, from several threads at once. The message of a failure becomes a
    /// warning. `layer` is that of an [`ImageSource`]. `limits.image_bytes` is to be kept before anything is allocated.
    fn decode_image(&self, bytes: &[u8], layer: usize, limits: &Limits) -> Option<Result<ImageData, String>> {
        let _ = (bytes, layer, limits);
        None
    }

    /// The bytes of a compressed buffer view; `None` to read it plainly.
    ///
    /// # Errors
    /// Where the extension's content makes no sense.
    fn decode_buffer_view(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
        view: &Json<'_>,
    ) -> Result<Option<Bytes>, AssetError> {
        let _ = (loader, own, view);
        Ok(None)
    }

    /// The attributes and indices of a compressed primitive; what it does not return is read from accessors.
    ///
    /// # Errors
    /// Where the extension's content makes no sense.
    fn decode_primitive(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
        primitive: &Json<'_>,
    ) -> Result<Option<DecodedPrimitive>, AssetError> {
        let _ = (loader, own, primitive);
        Ok(None)
    }

    /// The index of the material that a primitive should use instead of its `material`; `None` to leave it.
    ///
    /// # Errors
    /// Where the extension's content makes no sense.
    fn primitive_material(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
    ) -> Result<Option<usize>, AssetError> {
        let _ = (loader, own);
        Ok(None)
    }

    /// Reads the extension of a mesh: which of its vertices are one, although they are stored more than once; `None` to
    /// take equal positions for that. The loader verifies it.
    ///
    /// # Errors
    /// Where the extension's content makes no sense.
    fn merged_vertices(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
        mesh: &Json<'_>,
    ) -> Result<Option<MergedVertices>, AssetError> {
        let _ = (loader, own, mesh);
        Ok(None)
    }

    /// The transforms, relative to the node, of the several copies of a node's mesh; `None` for one plain copy.
    ///
    /// # Errors
    /// Where the extension's content makes no sense.
    fn instances(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
        node: &NodeContext,
    ) -> Result<Option<Vec<DAffine3>>, AssetError> {
        let _ = (loader, own, node);
        Ok(None)
    }

    /// Whether a node and everything below it is part of the picture. Cameras are there all the same.
    ///
    /// # Errors
    /// Where the extension's content makes no sense.
    fn visible(&self, loader: &mut Loader<'_>, own: &Json<'_>) -> Result<bool, AssetError> {
        let _ = (loader, own);
        Ok(true)
    }

    /// Reads the extension of a node of the scene, which may add lights, cameras or instances to `loader.scene`.
    ///
    /// # Errors
    /// Where the extension's content makes no sense.
    fn node(&self, loader: &mut Loader<'_>, own: &Json<'_>, node: &NodeContext) -> Result<(), AssetError> {
        let _ = (loader, own, node);
        Ok(())
    }

    /// Reads the extension of a camera. `camera` is the glTF camera, `out` what has been made of it so far.
    ///
    /// # Errors
    /// Where the extension's content makes no sense.
    fn camera(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
        camera: &Json<'_>,
        out: &mut CameraDescription,
    ) -> Result<(), AssetError> {
        let _ = (loader, own, camera, out);
        Ok(())
    }

    /// The JSON pointer of the property that a channel of an animation changes; `None` to leave that to core glTF.
    ///
    /// # Errors
    /// Where the extension's content makes no sense.
    fn animation_target(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
    ) -> Result<Option<String>, AssetError> {
        let _ = (loader, own);
        Ok(None)
    }

    /// The properties of this extension that animations may change, apart from those that the Object Model of glTF 2.0
    /// lists. Those of `KHR_texture_transform` are included, whichever texture it is on.
    fn mutable_properties(&self) -> &[MutableProperty] {
        &[]
    }

    /// Reads the extension of the document, or of the scene that is shown, before anything else is read.
    ///
    /// # Errors
    /// Where the extension's content makes no sense.
    fn document(&self, loader: &mut Loader<'_>, own: &Json<'_>) -> Result<(), AssetError> {
        let _ = (loader, own);
        Ok(())
    }
}

/// The extensions that a load understands, in the order in which their hooks run.
#[derive(Clone)]
pub struct Registry {
    extensions: Vec<Arc<dyn Extension>>,
}

impl Registry {
    /// A registry that knows no extension.
    pub fn empty() -> Self {
        Self { extensions: Vec::new() }
    }

    /// The extensions of this crate.
    pub fn standard() -> Self {
        let mut registry = Self::empty();
        let table: Vec<Box<dyn Extension>> = vec![
            Box::new(animation_pointer::AnimationPointer),
            Box::new(anisotropy::Anisotropy),
            Box::new(camera_physical::CameraPhysical),
            Box::new(clearcoat::Clearcoat),
            Box::new(coat::Coat),
            Box::new(diffuse_roughness::DiffuseRoughness(diffuse_roughness::FIRST_NAME)),
            Box::new(diffuse_roughness::DiffuseRoughness(diffuse_roughness::NAME)),
            Box::new(diffuse_transmission::DiffuseTransmission),
            Box::new(dispersion::Dispersion),
            Box::new(draco::Draco),
            Box::new(emissive_strength::EmissiveStrength),
            Box::new(fuzz::Fuzz),
            Box::new(gpu_instancing::GpuInstancing),
            Box::new(ior::Ior),
            Box::new(iridescence::Iridescence),
            Box::new(lights_area::LightsArea),
            Box::new(lights_ies::LightsIes),
            Box::new(lights_image_based::LightsImageBased),
            Box::new(lights_punctual::LightsPunctual),
            Box::new(mesh_manifold::MeshManifold),
            Box::new(mesh_quantization::MeshQuantization),
            Box::new(meshopt::Meshopt("EXT_meshopt_compression")),
            Box::new(meshopt::Meshopt("KHR_meshopt_compression")),
            Box::new(node_visibility::NodeVisibility),
            Box::new(sheen::Sheen),
            Box::new(specular::Specular),
            Box::new(specular_glossiness::SpecularGlossiness),
            Box::new(texture_ktx::TextureKtx("KHR_texture_basisu")),
            Box::new(texture_ktx::TextureKtx("KHR_texture_ktx")),
            Box::new(texture_ktx::TextureKtx("EXT_texture_astc")),
            Box::new(texture_transform::TextureTransform),
            Box::new(texture_webp::TextureWebp),
            Box::new(transmission::Transmission),
            Box::new(unlit::Unlit),
            Box::new(variants::Variants),
            Box::new(volume::Volume),
            Box::new(scatter::VolumeScatter),
            Box::new(scatter::Scatter),
            Box::new(subsurface::Subsurface),
        ];
        for extension in table {
            registry.register(extension);
        }
        registry
    }

    /// Adds an extension, in place of one of the same name.
    pub fn register(&mut self, extension: Box<dyn Extension>) {
        self.extensions.retain(|e| e.name() != extension.name());
        let place = self.extensions.partition_point(|e| e.order() <= extension.order());
        self.extensions.insert(place, extension.into());
    }

    /// The extensions, in the order in which their hooks run.
    pub fn iter(&self) -> impl Iterator<Item = &dyn Extension> {
        self.extensions.iter().map(|e| &**e)
    }

    /// The extension of that name.
    pub fn get(&self, name: &str) -> Option<&dyn Extension> {
        self.iter().find(|e| e.name() == name)
    }
}

impl Default for Registry {
    fn default() -> Self {
        Self::standard()
    }
}

impl std::fmt::Debug for Registry {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_list().entries(self.iter().map(Extension::name)).finish()
    }
}

#[cfg(test)]
mod compressed_tests;
#[cfg(test)]
mod draft_tests;
#[cfg(test)]
mod light_tests;
#[cfg(test)]
mod material_tests;
#[cfg(test)]
mod scatter_tests;
#[cfg(test)]
mod tests;
