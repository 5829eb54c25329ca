//! Texture look-ups: wrap and filter modes of glTF samplers over decoded images.
pub(crate) fn sample_texture(
    _: &super::SceneDescription,
    _: &super::TextureRef,
    _: glam::Vec2,
) -> glam::Vec4 {
    glam::Vec4::ONE
}
