//! Comparisons written out.

pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

pub(crate) fn smaller(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}
