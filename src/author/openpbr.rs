//! The parameters of OpenPBR Surface (Academy Software Foundation, version 1.1), as an object `openpbr` in a material's
//! `extras`, spelt as the OpenPBR specification spells them, lengths in metres. glTF has no other place for them.
//!
//! A medium that scatters is OpenPBR's *subsurface*: mean free paths 1/σt = `subsurface_radius` · `subsurface_radius_scale`
//! and a colour that OpenPBR takes to the single-scattering albedo by the formula of the Khronos drafts
//! ([`super::khronos`]), without regard to the index. A medium that only absorbs is its *transmission*:
//! σa = −ln(`transmission_color`)/`transmission_depth`.

use serde_json::{Value, json};

use super::khronos::{multiple_from_single, shares_from_multiple};
use super::medium::{Form, Medium, Reading, number, surface_ior, triple};
use super::text::Node;

/// The member of `extras` that holds the parameters.
pub const KEY: &str = "openpbr";

/// Defaults of the OpenPBR specification.
const DEFAULT_COLOR: [f64; 3] = [0.8; 3];
const DEFAULT_RADIUS_SCALE: [f64; 3] = [1.0, 0.5, 0.25];
/// Stands for an infinite mean free path, in the longest finite one.
const VERY_LONG: f64 = 1e6;

/// The medium that the OpenPBR parameters of a material describe.
pub fn read(material: &Value) -> Option<Reading> {
    let own = material.get("extras")?.get(KEY)?;
    let ior = number(own, "specular_ior").filter(|ior| *ior >= 1.0).unwrap_or_else(|| surface_ior(material));
    let mut beyond = Vec::new();
    let weight = |key: &str| number(own, key).unwrap_or(0.0);
    let (transmission, subsurface) = (weight("transmission_weight"), weight("subsurface_weight"));
    let medium = if transmission > 0.0 {
        let depth = number(own, "transmission_depth").unwrap_or(0.0);
        let color = triple(own, "transmission_color").unwrap_or([1.0; 3]);
        if depth <= 0.0 && color != [1.0; 3] {
            beyond.push(
                "transmission_color with a transmission_depth of 0 tints the surface, not the medium"
                    .to_owned(),
            );
        }
        let scatter = triple(own, "transmission_scatter").unwrap_or([0.0; 3]);
        let extinction = |i: usize| {
            if depth > 0.0 { -color[i].clamp(f64::MIN_POSITIVE, 1.0).ln() / depth } else { 0.0 }
        };
        let scattering = |i: usize| if depth > 0.0 { scatter[i].max(0.0) / depth } else { 0.0 };
        // Where more is scattered than is taken away, OpenPBR lifts all absorption until none is negative.
        let lift = (0..3).map(|i| scattering(i) - extinction(i)).fold(0.0, f64::max);
        Medium {
            sigma_a: [0, 1, 2].map(|i| extinction(i) - scattering(i) + lift),
            sigma_s: [0, 1, 2].map(scattering),
            g: number(own, "transmission_scatter_anisotropy").unwrap_or(0.0),
            ior,
        }
    } else if subsurface > 0.0 {
        let g = number(own, "subsurface_scatter_anisotropy").unwrap_or(0.0);
        let radius = number(own, "subsurface_radius").unwrap_or(1.0);
        let scale = triple(own, "subsurface_radius_scale").unwrap_or(DEFAULT_RADIUS_SCALE);
        let color = triple(own, "subsurface_color").unwrap_or(DEFAULT_COLOR);
        // Shorter than any wavelength is as good as nothing.
        const SHORTEST: f64 = 1e-12;
        let sigma_t = scale.map(|s| 1.0 / (radius * s).max(SHORTEST));
        let shares = color.map(|c| shares_from_multiple(c, g));
        Medium {
            sigma_a: [0, 1, 2].map(|i| sigma_t[i] * shares[i][1]),
            sigma_s: [0, 1, 2].map(|i| sigma_t[i] * shares[i][0]),
            g,
            ior,
        }
    } else {
        return None;
    };
    for (name, weight) in [("transmission_weight", transmission), ("subsurface_weight", subsurface)] {
        if weight > 0.0 && weight < 1.0 {
            beyond.push(format!("a {name} of {weight} mixes with other lobes; 1 is taken"));
        }
    }
    Some(Reading { medium, form: Form::OpenPbr, beyond })
}

/// Writes the parameters for a medium.
pub fn write(material: &mut Node<'_>, medium: &Medium) {
    let sigma_t = medium.sigma_t();
    let densest = sigma_t.into_iter().fold(0.0, f64::max);
    let parameters = if medium.scatters() {
        let paths = sigma_t.map(|t| if t > 0.0 { 1.0 / t } else { 0.0 });
        let longest = paths.into_iter().fold(0.0, f64::max);
        let paths = paths.map(|p| if p > 0.0 { p } else { VERY_LONG * longest });
        let radius = paths.into_iter().fold(0.0, f64::max);
        let albedo = |i: usize| if sigma_t[i] > 0.0 { medium.sigma_s[i] / sigma_t[i] } else { 0.0 };
        let color: [f64; 3] = std::array::from_fn(|i| multiple_from_single(albedo(i), medium.g));
        json!({
            "specular_ior": medium.ior,
            "subsurface_weight": 1,
            "subsurface_color": color,
            "subsurface_radius": radius,
            "subsurface_radius_scale": paths.map(|p| p / radius),
            "subsurface_scatter_anisotropy": medium.g,
        })
    } else {
        let depth = if densest > 0.0 { 1.0 / densest } else { 0.0 };
        json!({
            "specular_ior": medium.ior,
            "transmission_weight": 1,
            "transmission_color": sigma_t.map(|t| (-t * depth).exp()),
            "transmission_depth": depth,
        })
    };
    if let Some(extras) = material.object_mut("extras") {
        extras.set(KEY, &parameters);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_and_limits_are_those_of_the_specification() {
        let material =
            json!({ "extras": { "openpbr": { "subsurface_weight": 1, "subsurface_radius": 0.01 } } });
        let reading = read(&material).unwrap();
        let sigma_t = reading.medium.sigma_t();
        for (found, expected) in sigma_t.into_iter().zip([100.0, 200.0, 400.0]) {
            assert!((found - expected).abs() < 1e-9 * expected, "{sigma_t:?}");
        }
        assert_eq!(reading.medium.ior, 1.5);
        // OpenPBR: extinction 2 and 1, scattering 0.5 and 1.5: absorption 1.5 and −0.5, lifted by 0.5.
        let color = [(-2.0f64).exp(), (-1.0f64).exp(), 1.0];
        let glass = json!({ "extras": { "openpbr": { "transmission_weight": 0.5, "transmission_depth": 1,
            "transmission_color": color, "transmission_scatter": [0.5, 1.5, 0] } } });
        let reading = read(&glass).unwrap();
        for (found, expected) in reading.medium.sigma_a.into_iter().zip([2.0, 0.0, 0.5]) {
            assert!((found - expected).abs() < 1e-12, "{reading:?}");
        }
        assert!(reading.beyond[0].contains("transmission_weight"));
        assert!(read(&json!({ "extras": { "openpbr": { "base_color": [1, 1, 1] } } })).is_none());
        assert!(read(&json!({ "extras": 5 })).is_none());
    }
}
