//! How much a file may ask for.

use crate::scene::DerivedLimits;

/// How much a file may ask for, so that a small hostile file cannot take the whole machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of all files together, and of what is decompressed from them (except images).
    pub file_bytes: u64,
    /// Numbers, strings, arrays, objects and so on of the JSON document; each takes up to 200 bytes.
    pub json_values: u64,
    /// Nodes of the document.
    pub nodes: u64,
    /// Instances of the scene.
    pub instances: u64,
    /// Vertices of all meshes together, and elements of an accessor.
    pub vertices: u64,
    /// Triangles of all meshes together.
    pub triangles: u64,
    /// Bytes of all decoded images together: 4 a pixel, 8 for 16-bit images, 16 for floats.
    pub image_bytes: u64,
    /// Elements of morph targets, joint influences and keyframes that are read, together.
    pub pose_elements: u64,
    /// Bytes of what is derived from all that, to be rendered.
    pub derived: DerivedLimits,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            file_bytes: 4 << 30,
            json_values: 8_000_000,
            nodes: 4_000_000,
            instances: 4_000_000,
            vertices: 50_000_000,
            triangles: 50_000_000,
            image_bytes: 1 << 30,
            pose_elements: 1_000_000_000,
            derived: DerivedLimits::default(),
        }
    }
}

impl Limits {
    /// Names of the limits as [`AssetError::Limit`](super::AssetError::Limit) and
    /// [`SceneError::Limit`](crate::scene::SceneError::Limit) have them, with hyphens.
    pub const NAMES: [&str; 12] = [
        "file-bytes",
        "json-values",
        "nodes",
        "instances",
        "vertices",
        "triangles",
        "image-bytes",
        "pose-elements",
        "pyramid-bytes",
        "environment-bytes",
        "hierarchy-bytes",
        "light-bytes",
    ];

    /// Sets the limit of that name; false if there is none.
    pub fn set(&mut self, name: &str, value: u64) -> bool {
        let limit = match name {
            "file-bytes" => &mut self.file_bytes,
            "json-values" => &mut self.json_values,
            "nodes" => &mut self.nodes,
            "instances" => &mut self.instances,
            "vertices" => &mut self.vertices,
            "triangles" => &mut self.triangles,
            "image-bytes" => &mut self.image_bytes,
            "pose-elements" => &mut self.pose_elements,
            "pyramid-bytes" => &mut self.derived.pyramid_bytes,
            "environment-bytes" => &mut self.derived.environment_bytes,
            "hierarchy-bytes" => &mut self.derived.hierarchy_bytes,
            "light-bytes" => &mut self.derived.light_bytes,
            _ => return false,
        };
        *limit = value;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::Limits;

    #[test]
    fn every_name_sets_a_limit_of_its_own() {
        let mut seen = vec![Limits::default()];
        for name in Limits::NAMES {
            let mut limits = Limits::default();
            assert!(limits.set(name, 7) && !seen.contains(&limits), "{name}");
            seen.push(limits);
        }
        assert!(!Limits::default().set("depth", 7));
    }
}
