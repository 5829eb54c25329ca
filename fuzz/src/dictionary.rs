//! Names and objects of glTF that mutations draw from.

use serde_json::{Value, json};

use super::mutate::Random;

/// An object for each extension of a material, with every property.
const MATERIAL: &[(&str, &str)] = &[
    (
        "KHR_materials_anisotropy",
        r#"{"anisotropyStrength":0.6,"anisotropyRotation":1.5,"anisotropyTexture":{"index":0}}"#,
    ),
    (
        "KHR_materials_clearcoat",
        r#"{"clearcoatFactor":1,"clearcoatTexture":{"index":0},"clearcoatRoughnessFactor":0.3,"clearcoatRoughnessTexture":{"index":0},"clearcoatNormalTexture":{"index":0,"scale":2}}"#,
    ),
    (
        "KHR_materials_coat",
        r#"{"coatFactor":1,"coatTexture":{"index":0},"coatRoughnessFactor":0.3,"coatRoughnessTexture":{"index":0},"coatNormalTexture":{"index":0,"scale":2},"coatIor":1.6,"coatColorFactor":[1,0.5,0.2],"coatColorTexture":{"index":0},"coatDarkeningFactor":0.5,"coatAnisotropyStrength":0.6,"coatAnisotropyRotation":1.5,"coatAnisotropyTexture":{"index":0}}"#,
    ),
    (
        "KHR_materials_diffuse_roughness",
        r#"{"diffuseRoughnessFactor":0.8,"diffuseRoughnessTexture":{"index":0}}"#,
    ),
    (
        "KHR_materials_diffuse_transmission",
        r#"{"diffuseTransmissionFactor":0.5,"diffuseTransmissionTexture":{"index":0},"diffuseTransmissionColorFactor":[1,0.5,0.2],"diffuseTransmissionColorTexture":{"index":0}}"#,
    ),
    ("KHR_materials_dispersion", r#"{"dispersion":0.3}"#),
    ("KHR_materials_emissive_strength", r#"{"emissiveStrength":10}"#),
    (
        "KHR_materials_fuzz",
        r#"{"fuzzFactor":0.7,"fuzzTexture":{"index":0},"fuzzColorFactor":[1,0.5,0.2],"fuzzColorTexture":{"index":0},"fuzzRoughnessFactor":0.4,"fuzzRoughnessTexture":{"index":0}}"#,
    ),
    ("KHR_materials_ior", r#"{"ior":1.33}"#),
    (
        "KHR_materials_iridescence",
        r#"{"iridescenceFactor":1,"iridescenceTexture":{"index":0},"iridescenceIor":1.4,"iridescenceThicknessMinimum":100,"iridescenceThicknessMaximum":400,"iridescenceThicknessTexture":{"index":0}}"#,
    ),
    (
        "KHR_materials_pbrSpecularGlossiness",
        r#"{"diffuseFactor":[1,0.5,0.2,1],"diffuseTexture":{"index":0},"specularFactor":[0.2,0.2,0.2],"glossinessFactor":0.7,"specularGlossinessTexture":{"index":0}}"#,
    ),
    (
        "KHR_materials_scatter",
        r#"{"multiscatterColorFactor":[0.9,0.5,0.1],"multiscatterColorTexture":{"index":0},"scatterAnisotropy":0.5}"#,
    ),
    (
        "KHR_materials_sheen",
        r#"{"sheenColorFactor":[1,0.5,1],"sheenColorTexture":{"index":0},"sheenRoughnessFactor":0.4,"sheenRoughnessTexture":{"index":0}}"#,
    ),
    (
        "KHR_materials_specular",
        r#"{"specularFactor":0.5,"specularTexture":{"index":0},"specularColorFactor":[1,2,0.5],"specularColorTexture":{"index":0}}"#,
    ),
    ("KHR_materials_transmission", r#"{"transmissionFactor":0.9,"transmissionTexture":{"index":0}}"#),
    ("KHR_materials_unlit", "{}"),
    (
        "KHR_materials_volume",
        r#"{"thicknessFactor":0.5,"thicknessTexture":{"index":0},"attenuationDistance":0.2,"attenuationColor":[0.9,0.5,0.1]}"#,
    ),
    ("KHR_materials_volume_scatter", r#"{"multiscatterColor":[0.9,0.5,0.1],"scatterAnisotropy":-0.5}"#),
    (
        "NEPHRITE_materials_subsurface",
        r#"{"absorptionCoefficient":[1,2,3],"absorptionTexture":{"index":0},"scatteringCoefficient":[10,20,30],"scatteringTexture":{"index":0},"scatterAnisotropy":0.4,"ior":1.4,"densityFactor":2,"priority":1}"#,
    ),
];

/// An object for each extension of something else, and the array whose entries it belongs to.
const OTHER: &[(&str, &str, &str)] = &[
    ("nodes", "KHR_lights_punctual", r#"{"light":0}"#),
    ("nodes", "EXT_lights_area", r#"{"light":0}"#),
    ("nodes", "EXT_lights_ies", r#"{"light":0,"multiplier":2,"color":[1,0.5,0.2]}"#),
    (
        "cameras",
        "EXT_camera_physical",
        r#"{"focalLength":0.05,"sensorSize":[0.036,0.024],"fStop":2.8,"focusDistance":3}"#,
    ),
    ("nodes", "KHR_node_visibility", r#"{"visible":false}"#),
    ("nodes", "EXT_mesh_gpu_instancing", r#"{"attributes":{"TRANSLATION":0,"ROTATION":1,"SCALE":0}}"#),
    (
        "meshes",
        "EXT_mesh_manifold",
        r#"{"manifoldPrimitive":{"indices":1,"attributes":{"POSITION":0}},"mergeIndices":1,"mergeValues":1}"#,
    ),
    ("textures", "EXT_texture_webp", r#"{"source":0}"#),
    ("textures", "KHR_texture_basisu", r#"{"source":0}"#),
    ("textures", "KHR_texture_ktx", r#"{"source":0,"layer":1}"#),
    (
        "bufferViews",
        "EXT_meshopt_compression",
        r#"{"buffer":0,"byteOffset":0,"byteLength":64,"byteStride":4,"count":8,"mode":"ATTRIBUTES","filter":"NONE"}"#,
    ),
    ("scenes", "EXT_lights_image_based", r#"{"light":0}"#),
];

const STRINGS: &[&str] = &[
    "",
    "0",
    "../../odd",
    "/etc/hostname",
    "file:///etc/hostname",
    "http://example.com/a.png",
    "a%2f..%2fb",
    "data:image/png;base64,iVBORw0KGgo=",
    "data:application/octet-stream;base64,AAAAAAAAAAAAAAAA",
    "data:,",
    "VEC2",
    "VEC3",
    "VEC4",
    "SCALAR",
    "MAT4",
    "BLEND",
    "MASK",
    "OPAQUE",
    "LINEAR",
    "STEP",
    "CUBICSPLINE",
    "translation",
    "rotation",
    "scale",
    "weights",
    "pointer",
    "/nodes/0/translation",
    "/materials/0/pbrMetallicRoughness/baseColorFactor",
    "/materials/0/extensions/NEPHRITE_materials_subsurface/densityFactor",
    "POSITION",
    "NORMAL",
    "TEXCOORD_1",
    "JOINTS_0",
    "perspective",
    "orthographic",
    "spot",
    "directional",
    "rect",
    "disk",
    "application/x-ies-lm-63",
    "data:,TILT=NONE%0A1 1 1 2 1 1 2 0 0 0 1 1 0 0 90 0 5 1",
    "image/webp",
    "image/ktx2",
    "KHR_draco_mesh_compression",
    "EXT_texture_avif",
    "3.0",
    "\u{1F995}",
];

const PROPERTIES: &[&str] = &[
    "byteOffset",
    "byteStride",
    "byteLength",
    "count",
    "componentType",
    "normalized",
    "sparse",
    "min",
    "max",
    "mode",
    "indices",
    "material",
    "targets",
    "weights",
    "children",
    "matrix",
    "translation",
    "rotation",
    "scale",
    "mesh",
    "skin",
    "camera",
    "alphaMode",
    "alphaCutoff",
    "doubleSided",
    "emissiveFactor",
    "metallicFactor",
    "roughnessFactor",
    "texCoord",
    "index",
    "source",
    "sampler",
    "uri",
    "bufferView",
    "extras",
    "extensionsRequired",
    "ior",
    "priority",
    "strength",
];

fn parsed(text: &str) -> Value {
    serde_json::from_str(text).expect("the dictionary is JSON")
}

/// A string that means something somewhere.
pub fn string(random: &mut Random) -> String {
    STRINGS[random.below(STRINGS.len())].to_owned()
}

/// A property that means something somewhere, and an odd value.
pub fn property(random: &mut Random) -> (String, Value) {
    (PROPERTIES[random.below(PROPERTIES.len())].to_owned(), super::mutate::odd(random))
}

/// A material extension by name, and its object.
pub fn material_extension(random: &mut Random) -> (&'static str, Value) {
    let (name, text) = MATERIAL[random.below(MATERIAL.len())];
    (name, parsed(text))
}

/// Gives an extension to an entry of the document, or to the document itself where that is a material.
pub fn add_extension(document: &mut Value, random: &mut Random) {
    let is_material = document.get("asset").is_none();
    let pick = random.below(MATERIAL.len() + OTHER.len());
    let (array, name, object) = match OTHER.get(pick.wrapping_sub(MATERIAL.len())) {
        Some(&(array, name, text)) if !is_material => (array, name, parsed(text)),
        _ => {
            let (name, object) = material_extension(random);
            ("materials", name, object)
        }
    };
    let entry = if is_material {
        Some(document)
    } else {
        let list = document.get_mut(array).and_then(Value::as_array_mut);
        list.and_then(|list| {
            let index = random.below(list.len());
            list.get_mut(index)
        })
    };
    let Some(Value::Object(entry)) = entry else { return };
    match entry.get_mut("extensions") {
        Some(Value::Object(extensions)) => drop(extensions.insert(name.to_owned(), object)),
        _ => drop(entry.insert("extensions".to_owned(), json!({ name: object }))),
    }
}
