//! The font that is part of this program: Noto Sans (SIL Open Font License 1.1).

use ttf_parser::Face;

/// The font; none only if the program is damaged.
pub(super) fn face() -> Option<Face<'static>> {
    Face::parse(notosans::REGULAR_TTF, 0).ok()
}

/// The width of a text at a size.
pub(super) fn width(text: &str, size: f64) -> f64 {
    let Some(face) = face() else {
        return 0.55 * size * f64::from(u32::try_from(text.chars().count()).unwrap_or(0));
    };
    let units: u32 = text
        .chars()
        .map(|c| {
            let glyph = face.glyph_index(c).unwrap_or_default();
            u32::from(face.glyph_hor_advance(glyph).unwrap_or(0))
        })
        .sum();
    size * f64::from(units) / f64::from(face.units_per_em())
}
