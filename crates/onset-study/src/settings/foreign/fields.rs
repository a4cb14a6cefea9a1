//! Lines with fields of fixed width or between commas, as LS-DYNA and Radioss have them.

use super::{Trouble, number};

/// Data line of a block.
#[derive(Clone, Copy, Debug)]
pub(super) struct Card<'t> {
    pub line: usize,
    pub text: &'t str,
}

impl<'t> Card<'t> {
    /// The fields: between commas if the line has any, otherwise of the given widths; missing fields are empty.
    pub fn fields<const N: usize>(self, widths: [usize; N]) -> [&'t str; N] {
        if self.text.contains(',') {
            let mut fields = self.text.split(',');
            return widths.map(|_| fields.next().unwrap_or("").trim());
        }
        let mut rest = self.text;
        widths.map(|width| {
            let end = rest
                .char_indices()
                .nth(width)
                .map_or(rest.len(), |(at, _)| at);
            let (own, others) = rest.split_at(end);
            rest = others;
            own.trim()
        })
    }

    /// Fields of one width as numbers; empty fields are zero.
    pub fn numbers<const N: usize>(self, width: usize) -> Result<[f64; N], Trouble> {
        let mut numbers = [0.0; N];
        for (own, field) in numbers.iter_mut().zip(self.fields([width; N])) {
            *own = number(field, self.line)?;
        }
        Ok(numbers)
    }
}

/// Pairs of moduli and exponents with nonzero moduli.
pub(super) fn terms(
    line: usize,
    moduli: &[f64],
    exponents: &[f64],
) -> Result<Vec<(f64, f64)>, Trouble> {
    let pairs = moduli.iter().copied().zip(exponents.iter().copied());
    let terms: Vec<(f64, f64)> = pairs.filter(|(modulus, _)| *modulus != 0.0).collect();
    if terms.is_empty() {
        return Err(Trouble::new(
            line,
            "all moduli are 0",
            "expected the moduli mu1, mu2, ... and exponents alpha1, alpha2, ... of Ogden's law",
        ));
    }
    match terms.iter().any(|(_, exponent)| *exponent == 0.0) {
        true => Err(Trouble::new(
            line,
            "an exponent alpha is 0 where its modulus is not",
            "expected an exponent for every modulus",
        )),
        false => Ok(terms),
    }
}
