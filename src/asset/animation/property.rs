//! The glTF 2.0 Asset Object Model: which properties may be animated, of what type they are, and where they are.
//!
//! A pointer is good if the object around its property is there. A property that is absent there has a default, which
//! is what the animation replaces. Extensions that the Object Model leaves out say their own properties
//! ([`Extension::mutable_properties`](crate::extension::Extension::mutable_properties)).

use serde_json::Value;

use crate::asset::{AssetError, Loader};

/// The type of a property that can be animated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PropertyKind {
    /// `true` or `false`.
    Bool,
    /// A number.
    Float,
    /// Two numbers.
    Float2,
    /// Three numbers.
    Float3,
    /// Four numbers.
    Float4,
    /// A unit quaternion.
    Rotation,
    /// A number for each morph target.
    Weights,
    /// The number for one morph target.
    Weight,
}

impl PropertyKind {
    /// How many numbers an animation gives, if that does not depend on the mesh.
    pub(crate) fn numbers(self) -> Option<usize> {
        match self {
            Self::Bool | Self::Float | Self::Weight => Some(1),
            Self::Float2 => Some(2),
            Self::Float3 => Some(3),
            Self::Float4 | Self::Rotation => Some(4),
            Self::Weights => None,
        }
    }
}

use PropertyKind::{Bool, Float, Float2, Float3, Float4, Rotation, Weight, Weights};

/// Core properties (Object Model §4) and those of ratified extensions (§5); `{}` stands for an index.
const PROPERTIES: &[(&str, PropertyKind)] = &[
    ("/cameras/{}/orthographic/xmag", Float),
    ("/cameras/{}/orthographic/ymag", Float),
    ("/cameras/{}/orthographic/zfar", Float),
    ("/cameras/{}/orthographic/znear", Float),
    ("/cameras/{}/perspective/aspectRatio", Float),
    ("/cameras/{}/perspective/yfov", Float),
    ("/cameras/{}/perspective/zfar", Float),
    ("/cameras/{}/perspective/znear", Float),
    ("/materials/{}/alphaCutoff", Float),
    ("/materials/{}/emissiveFactor", Float3),
    ("/materials/{}/normalTexture/scale", Float),
    ("/materials/{}/occlusionTexture/strength", Float),
    ("/materials/{}/pbrMetallicRoughness/baseColorFactor", Float4),
    ("/materials/{}/pbrMetallicRoughness/metallicFactor", Float),
    ("/materials/{}/pbrMetallicRoughness/roughnessFactor", Float),
    ("/meshes/{}/weights", Weights),
    ("/meshes/{}/weights/{}", Weight),
    ("/nodes/{}/translation", Float3),
    ("/nodes/{}/rotation", Rotation),
    ("/nodes/{}/scale", Float3),
    ("/nodes/{}/weights", Weights),
    ("/nodes/{}/weights/{}", Weight),
    ("/nodes/{}/extensions/KHR_node_visibility/visible", Bool),
    ("/extensions/KHR_lights_punctual/lights/{}/color", Float3),
    ("/extensions/KHR_lights_punctual/lights/{}/intensity", Float),
    ("/extensions/KHR_lights_punctual/lights/{}/range", Float),
    ("/extensions/KHR_lights_punctual/lights/{}/spot/innerConeAngle", Float),
    ("/extensions/KHR_lights_punctual/lights/{}/spot/outerConeAngle", Float),
    ("/materials/{}/extensions/KHR_materials_anisotropy/anisotropyStrength", Float),
    ("/materials/{}/extensions/KHR_materials_anisotropy/anisotropyRotation", Float),
    ("/materials/{}/extensions/KHR_materials_clearcoat/clearcoatFactor", Float),
    ("/materials/{}/extensions/KHR_materials_clearcoat/clearcoatRoughnessFactor", Float),
    ("/materials/{}/extensions/KHR_materials_clearcoat/clearcoatNormalTexture/scale", Float),
    ("/materials/{}/extensions/KHR_materials_diffuse_transmission/diffuseTransmissionFactor", Float),
    ("/materials/{}/extensions/KHR_materials_diffuse_transmission/diffuseTransmissionColorFactor", Float3),
    ("/materials/{}/extensions/KHR_materials_dispersion/dispersion", Float),
    ("/materials/{}/extensions/KHR_materials_emissive_strength/emissiveStrength", Float),
    ("/materials/{}/extensions/KHR_materials_ior/ior", Float),
    ("/materials/{}/extensions/KHR_materials_iridescence/iridescenceFactor", Float),
    ("/materials/{}/extensions/KHR_materials_iridescence/iridescenceIor", Float),
    ("/materials/{}/extensions/KHR_materials_iridescence/iridescenceThicknessMinimum", Float),
    ("/materials/{}/extensions/KHR_materials_iridescence/iridescenceThicknessMaximum", Float),
    ("/materials/{}/extensions/KHR_materials_sheen/sheenColorFactor", Float3),
    ("/materials/{}/extensions/KHR_materials_sheen/sheenRoughnessFactor", Float),
    ("/materials/{}/extensions/KHR_materials_specular/specularFactor", Float),
    ("/materials/{}/extensions/KHR_materials_specular/specularColorFactor", Float3),
    ("/materials/{}/extensions/KHR_materials_transmission/transmissionFactor", Float),
    ("/materials/{}/extensions/KHR_materials_volume/thicknessFactor", Float),
    ("/materials/{}/extensions/KHR_materials_volume/attenuationDistance", Float),
    ("/materials/{}/extensions/KHR_materials_volume/attenuationColor", Float3),
];

/// Range of what has none.
const ANY: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

/// Fields of view, radians, that a camera can have.
const LENS: [f64; 2] = [1e-6, std::f64::consts::PI - 1e-6];

/// Properties without a default, which a file has to state before it may animate them.
const WITHOUT_DEFAULT: &[&str] =
    &["xmag", "ymag", "zfar", "znear", "yfov", "aspectRatio", "range", "attenuationDistance"];

/// What an extension says of a property of its own that can be animated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MutableProperty {
    /// JSON pointer with `{}` for every index.
    pub template: &'static str,
    /// Its type.
    pub kind: PropertyKind,
    /// Least and greatest value, to which splines that overshoot are brought.
    pub range: [f64; 2],
}

impl MutableProperty {
    /// A property of that type whose components are between `least` and `greatest`.
    pub const fn within(template: &'static str, kind: PropertyKind, least: f64, greatest: f64) -> Self {
        Self { template, kind, range: [least, greatest] }
    }
}

/// A property of the document that can be animated.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Property {
    /// The tokens of its pointer.
    pub path: Vec<String>,
    pub kind: PropertyKind,
    /// Least and greatest value.
    pub range: [f64; 2],
    /// Numbers of a value.
    pub numbers: usize,
}

impl Loader<'_> {
    /// What a pointer stands for; `from` is the place that says it.
    ///
    /// # Errors
    /// Where it is no property that can be animated, or where there is nothing that could have it.
    pub(super) fn property(&mut self, pointer: &str, from: &str) -> Result<Property, AssetError> {
        let shown = crate::asset::error::shorten(pointer);
        let fail = |why: &str| AssetError::invalid(from, format!("`{shown}` {why}"));
        let path = tokens(pointer).ok_or_else(|| fail("is no JSON pointer"))?;
        let (kind, range) = self.kind(&path).ok_or_else(|| fail("is no property that can be animated"))?;
        let depth = path.len() - if kind == Weight { 2 } else { 1 };
        let around = path[..depth].iter().try_fold(self.document, |value, token| child(value, token));
        let around = around.filter(|v| v.is_object()).ok_or_else(|| fail("points to nothing"))?;
        let leaf = path.last().map_or("", String::as_str);
        if around.get(leaf).is_none() && WITHOUT_DEFAULT.contains(&leaf) {
            self.invalid(from, format!("`{shown}` is not in the file and has no default"))?;
        }
        let numbers = match kind {
            Weights | Weight => {
                let targets = self.targets(around);
                let index = if kind == Weight { leaf.parse().unwrap_or(usize::MAX) } else { 0 };
                if index >= targets {
                    return Err(fail(&format!("points beyond the {targets} morph targets")));
                }
                if kind == Weight { 1 } else { targets }
            }
            _ => kind.numbers().unwrap_or(1),
        };
        if path.first().is_some_and(|t| t == "nodes")
            && matches!(leaf, "translation" | "rotation" | "scale")
            && around.get("matrix").is_some()
        {
            let message = format!("`{shown}` has a matrix beside it, which is taken apart");
            self.invalid(from, message)?;
        }
        Ok(Property { path, kind, range, numbers })
    }

    /// Type and range of the property at a path.
    fn kind(&self, path: &[String]) -> Option<(PropertyKind, [f64; 2])> {
        if let [first, .., extensions, name, leaf] = path
            && first == "materials"
            && extensions == "extensions"
            && name == "KHR_texture_transform"
        {
            return match leaf.as_str() {
                "offset" | "scale" => Some((Float2, ANY)),
                "rotation" => Some((Float, ANY)),
                _ => None,
            };
        }
        let mut own = self.options.registry.iter().flat_map(|e| e.mutable_properties());
        if let Some(property) = own.find(|p| matches(p.template, path)) {
            return Some((property.kind, property.range));
        }
        let (_, kind) = PROPERTIES.iter().find(|(template, _)| matches(template, path))?;
        let range = if path.last().is_some_and(|leaf| leaf == "yfov") { LENS } else { ANY };
        Some((*kind, range))
    }

    /// Number of morph targets of a mesh, or of the mesh of a node.
    fn targets(&self, json: &Value) -> usize {
        let mesh = match json.get("mesh").and_then(Value::as_u64) {
            Some(index) => self.document.pointer(&format!("/meshes/{index}")),
            None => Some(json),
        };
        let targets = mesh.and_then(|m| m.pointer("/primitives/0/targets"));
        targets.and_then(Value::as_array).map_or(0, Vec::len)
    }
}

/// The tokens of a JSON pointer (RFC 6901).
fn tokens(pointer: &str) -> Option<Vec<String>> {
    let path = pointer.strip_prefix('/')?;
    Some(path.split('/').map(|token| token.replace("~1", "/").replace("~0", "~")).collect())
}

fn matches(template: &str, path: &[String]) -> bool {
    let mut tokens = path.iter();
    let digits = |t: &str| !t.is_empty() && t.bytes().all(|b| b.is_ascii_digit());
    let all = template.split('/').skip(1).all(|wanted| {
        tokens.next().is_some_and(|token| if wanted == "{}" { digits(token) } else { token == wanted })
    });
    all && tokens.next().is_none()
}

fn child<'v>(value: &'v Value, token: &str) -> Option<&'v Value> {
    match value {
        Value::Object(object) => object.get(token),
        Value::Array(array) => array.get(token.parse::<usize>().ok()?),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn templates_match_whole_pointers_only() {
        let path = |p: &str| tokens(p).expect("a pointer");
        assert!(matches("/nodes/{}/scale", &path("/nodes/12/scale")));
        for wrong in ["/nodes/x/scale", "/nodes/1/scale/0", "/nodes/1", "/nodes//scale", "/a/nodes/1/scale"] {
            assert!(!matches("/nodes/{}/scale", &path(wrong)), "{wrong}");
        }
        assert_eq!(tokens("/a~1b/~01"), Some(vec!["a/b".to_owned(), "~1".to_owned()]));
        assert_eq!(tokens("nodes"), None);
    }
}
