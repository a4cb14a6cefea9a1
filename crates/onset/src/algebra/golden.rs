//! Golden section, one evaluation a step.

/// An interval in which a function is sought at its smallest (or largest), with what was found at two places within it.
pub(crate) struct GoldenSection<T> {
    low: f64,
    high: f64,
    /// The lower and the upper place within.
    pub(crate) inner: [(f64, T); 2],
}

/// The share of the interval that is kept.
fn ratio() -> f64 {
    0.5 * (5.0_f64.sqrt() - 1.0)
}

impl<T: Copy> GoldenSection<T> {
    /// The interval with its first two places.
    ///
    /// # Errors
    /// What the function says against one of them.
    pub(crate) fn new<E>(
        low: f64,
        high: f64,
        at: &mut impl FnMut(f64) -> Result<T, E>,
    ) -> Result<Self, E> {
        let (a, b) = (high - ratio() * (high - low), low + ratio() * (high - low));
        Ok(Self {
            low,
            high,
            inner: [(a, at(a)?), (b, at(b)?)],
        })
    }

    /// Keeps the part about the lower place, or else that about the upper one.
    ///
    /// # Errors
    /// What the function says against the new place.
    pub(crate) fn narrow<E>(
        &mut self,
        keeps_lower: bool,
        at: &mut impl FnMut(f64) -> Result<T, E>,
    ) -> Result<(), E> {
        let [lower, upper] = self.inner;
        self.inner = if keeps_lower {
            self.high = upper.0;
            let a = self.high - ratio() * (self.high - self.low);
            [(a, at(a)?), lower]
        } else {
            self.low = lower.0;
            let b = self.low + ratio() * (self.high - self.low);
            [upper, (b, at(b)?)]
        };
        Ok(())
    }

    /// The middle of what is left.
    pub(crate) fn middle(&self) -> f64 {
        0.5 * (self.low + self.high)
    }
}

#[cfg(test)]
mod tests {
    use super::GoldenSection;
    use std::convert::Infallible;

    #[test]
    fn forty_steps_find_a_minimum_with_forty_two_evaluations() {
        let mut asked = 0;
        let mut at = |x: f64| -> Result<f64, Infallible> {
            asked += 1;
            Ok((x - 0.3).abs())
        };
        let Ok(mut section) = GoldenSection::new(-1.0, 2.0, &mut at);
        for _ in 0..40 {
            let Ok(()) = section.narrow(section.inner[0].1 <= section.inner[1].1, &mut at);
        }
        assert!((section.middle() - 0.3).abs() < 1e-8);
        assert_eq!(asked, 42);
    }
}
