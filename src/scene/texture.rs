//! Texture look-ups: wrap and filter modes of glTF samplers over decoded images.
