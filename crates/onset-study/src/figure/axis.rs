//! Axes: ranges, scales and ticks at nice numbers.

use serde::Serialize;

/// Scale of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scale {
    /// Equal differences have equal lengths.
    #[default]
    Linear,
    /// Equal ratios have equal lengths.
    Log10,
}

/// One axis of a [`Panel`](super::Panel).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Axis {
    /// Quantity on the axis, with its unit.
    pub label: String,
    /// Values at the start and at the end; the start may be the larger value.
    pub range: (f64, f64),
    /// Linear or logarithmic scale.
    pub scale: Scale,
    /// Named ticks such as Γ, X, M instead of numbers; `None` for numbers.
    pub ticks: Option<Vec<(f64, String)>>,
}

/// Tick with its label; minor ticks have an empty label.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tick {
    pub(super) at: f64,
    pub(super) label: String,
    pub(super) minor: bool,
}

impl Axis {
    /// Creates an axis with linear scale.
    pub fn linear(label: impl Into<String>, range: (f64, f64)) -> Self {
        Self {
            label: label.into(),
            range,
            scale: Scale::Linear,
            ticks: None,
        }
    }

    /// Creates an axis with logarithmic scale.
    pub fn log(label: impl Into<String>, range: (f64, f64)) -> Self {
        Self {
            scale: Scale::Log10,
            ..Self::linear(label, range)
        }
    }

    /// Sets the range to the finite `values` (on a logarithmic axis the positive ones) with a small margin.
    ///
    /// ```
    /// use onset_study::figure::Axis;
    /// let axis = Axis::linear("t (s)", (0.0, 1.0)).covering([2.0, 4.0, f64::NAN]);
    /// assert!(axis.range.0 < 2.0 && axis.range.1 > 4.0 && axis.range.1 < 4.5);
    /// ```
    pub fn covering(mut self, values: impl IntoIterator<Item = f64>) -> Self {
        let (low, high) = values
            .into_iter()
            .map(|value| self.length(value))
            .filter(|length| length.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), length| {
                (low.min(length), high.max(length))
            });
        if low <= high {
            let margin = match self.scale {
                _ if low < high => 0.04 * (high - low),
                Scale::Linear if low != 0.0 => 0.5 * low.abs(),
                _ => 0.5,
            };
            self.range = (self.number(low - margin), self.number(high + margin));
        }
        self
    }

    /// Replaces the numbers by named ticks.
    pub fn ticks<S: Into<String>>(mut self, ticks: impl IntoIterator<Item = (f64, S)>) -> Self {
        let named = ticks.into_iter().map(|(at, name)| (at, name.into()));
        self.ticks = Some(named.collect());
        self
    }

    /// Length along the axis of a number; not finite if the scale cannot show the number.
    pub(super) fn length(&self, number: f64) -> f64 {
        match self.scale {
            Scale::Linear => number,
            Scale::Log10 => number.log10(),
        }
    }

    fn number(&self, length: f64) -> f64 {
        match self.scale {
            Scale::Linear => length,
            Scale::Log10 => 10f64.powf(length),
        }
    }

    /// Range as lengths. Always finite and nonempty, for any range that the caller set.
    pub(super) fn limits(&self) -> (f64, f64) {
        let bound = 1e300;
        let (mut start, mut end) = match (self.length(self.range.0), self.length(self.range.1)) {
            (start, end) if start.is_finite() && end.is_finite() => (start, end),
            (_, end) if self.scale == Scale::Log10 && end.is_finite() => (end - 3.0, end),
            (start, _) if self.scale == Scale::Log10 && start.is_finite() => (start, start - 3.0),
            _ => (0.0, 1.0),
        };
        (start, end) = (start.clamp(-bound, bound), end.clamp(-bound, bound));
        let size = start.abs().max(end.abs());
        if (end - start).abs() <= (1e-11 * size).max(1e-290) {
            let margin = if size > 0.0 { 0.5 * size } else { 0.5 };
            (start, end) = (start - margin, end + margin);
        }
        (start, end)
    }

    /// Range of numbers over which the axis is drawn.
    pub(super) fn shown(&self) -> (f64, f64) {
        let (start, end) = self.limits();
        (self.number(start), self.number(end))
    }

    /// Position of the number between the start (0) and the end (1) of the axis.
    pub(super) fn fraction(&self, number: f64) -> Option<f64> {
        let (start, end) = self.limits();
        let fraction = (self.length(number) - start) / (end - start);
        fraction.is_finite().then_some(fraction)
    }

    /// Ticks of [`Axis::marks`] with at least three labels, or with two if the axis has no room for three: at most `most` labels, but two in any case.
    pub(super) fn labeled_marks(&self, target: usize, most: usize) -> Vec<Tick> {
        let most = most.max(2);
        let with = |least: usize, most: usize| {
            (target..=target + 8)
                .map(|target| self.marks(target))
                .find(|marks| (least..=most).contains(&labels(marks)))
        };
        with(3, most)
            .or_else(|| with(2, most))
            .or_else(|| with(2, usize::MAX))
            .unwrap_or_else(|| self.marks(target))
    }

    /// About `target` labeled ticks inside the range, in increasing order.
    pub(super) fn marks(&self, target: usize) -> Vec<Tick> {
        let (start, end) = self.limits();
        let (low, high) = (start.min(end), start.max(end));
        if let Some(named) = &self.ticks {
            let mut marks: Vec<Tick> = named
                .iter()
                .filter(|(at, _)| (low..=high).contains(&self.length(*at)))
                .map(|(at, name)| Tick::major(*at, name.clone()))
                .collect();
            marks.sort_by(|a, b| a.at.total_cmp(&b.at));
            return marks;
        }
        match self.scale {
            Scale::Linear => linear_marks(low, high, target),
            Scale::Log10 => log_marks(low, high, target),
        }
    }
}

/// Number of labeled ticks.
pub(super) fn labels(marks: &[Tick]) -> usize {
    marks.iter().filter(|mark| !mark.label.is_empty()).count()
}

impl Tick {
    fn major(at: f64, label: String) -> Self {
        Self {
            at,
            label,
            minor: false,
        }
    }

    fn minor(at: f64) -> Self {
        Self {
            at,
            label: String::new(),
            minor: true,
        }
    }
}

/// Ticks at multiples of 1, 2 or 5 times a power of ten.
fn linear_marks(low: f64, high: f64, target: usize) -> Vec<Tick> {
    let rough = (high - low) / target.max(1) as f64;
    let mut power = rough.log10().floor() as i32;
    let mantissa = rough / 10f64.powi(power);
    let mut factor = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .find(|nice| mantissa <= nice * (1.0 + 1e-9))
        .unwrap_or(10.0);
    if factor == 10.0 {
        (factor, power) = (1.0, power + 1);
    }
    let step = factor * 10f64.powi(power);
    let first = (low / step - 1e-9).ceil();
    let last = (high / step + 1e-9).floor();
    let largest = (first * step).abs().max((last * step).abs());
    let scientific = largest >= 99_999.5 || power < -4;
    // All labels have the same exponent, so that they can be compared at a glance.
    let exponent =
        (scientific && largest > 0.0).then(|| (largest * (1.0 + 1e-9)).log10().floor() as i32);
    (0..=(last - first).clamp(0.0, 100.0) as i32)
        .map(|i| (first + f64::from(i)) * step)
        .map(|at| at.clamp(low, high))
        .map(|at| {
            let at = if at.abs() < 1e-6 * step { 0.0 } else { at };
            Tick::major(at, number_label(at, power, exponent))
        })
        .collect()
}

/// Ticks at powers of ten, and also at 2 and 5 times these if the range is short. `low` and `high` are exponents.
fn log_marks(low: f64, high: f64, target: usize) -> Vec<Tick> {
    let (lowest, highest) = ((low - 1e-9).ceil() as i32, (high + 1e-9).floor() as i32);
    let inside = |at: f64| (low - 1e-9..=high + 1e-9).contains(&at.log10());
    let clamp = |at: f64| at.clamp(10f64.powf(low), 10f64.powf(high));
    if highest > lowest {
        let stride = ((highest - lowest) / target.max(1) as i32 + 1).max(1);
        let mut marks = Vec::new();
        for exponent in lowest - 1..=highest {
            let decade = 10f64.powi(exponent);
            if inside(decade) {
                marks.push(if exponent.rem_euclid(stride) == 0 {
                    Tick::major(clamp(decade), format!("10{}", superscript(exponent)))
                } else {
                    Tick::minor(clamp(decade))
                });
            }
            if stride == 1 && highest - lowest < 9 {
                let between = (2..10).map(|i| f64::from(i) * decade);
                marks.extend(between.filter(|&at| inside(at)).map(Tick::minor));
            }
        }
        return marks;
    }
    let marks: Vec<Tick> = (lowest - 1..=highest)
        .flat_map(|exponent| [1.0, 2.0, 5.0].map(|factor| (factor, exponent)))
        .map(|(factor, exponent)| (factor * 10f64.powi(exponent), exponent))
        .filter(|&(at, _)| inside(at))
        .map(|(at, power)| {
            let exponent = (!(-4..5).contains(&power)).then_some(power);
            Tick::major(clamp(at), number_label(at, power, exponent))
        })
        .collect();
    if marks.len() > 2 {
        return marks;
    }
    linear_marks(10f64.powf(low), 10f64.powf(high), target)
}

/// Formats a number with the digits needed for ticks spaced `10^power` apart, with a true minus sign; divided by `10^exponent` if given.
fn number_label(at: f64, power: i32, exponent: Option<i32>) -> String {
    let label = match exponent {
        Some(_) if at == 0.0 => "0".to_string(),
        Some(exponent) => {
            let digits = (exponent - power).clamp(0, 15) as usize;
            let mantissa = at / 10f64.powi(exponent);
            format!("{mantissa:.digits$}×10{}", superscript(exponent))
        }
        None => {
            let digits = (-power).max(0) as usize;
            format!("{at:.digits$}")
        }
    };
    label.replace('-', "−")
}

fn superscript(exponent: i32) -> String {
    let digits = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let raise = |c: char| c.to_digit(10).map_or('⁻', |digit| digits[digit as usize]);
    exponent.to_string().chars().map(raise).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis) -> Vec<String> {
        let marks = axis.marks(6).into_iter().filter(|mark| !mark.minor);
        marks.map(|mark| mark.label).collect()
    }

    #[test]
    fn a_constant_of_any_size_is_shown_with_its_value() {
        for value in [1e-9, -3e-5, 1.0, 7e12] {
            let axis = Axis::linear("", (0.0, 1.0)).covering([value]);
            let (low, high) = axis.range;
            assert!(low < value && value < high, "{axis:?}");
            assert!((high - low) / value.abs() < 1.001, "{axis:?}");
        }
        assert_eq!(
            Axis::linear("", (0.0, 1.0)).covering([0.0]).range,
            (-0.5, 0.5)
        );
    }

    #[test]
    fn ticks_are_round_numbers_with_as_few_digits_as_possible() {
        let axis = |low, high| Axis::linear("", (low, high));
        assert_eq!(
            labels(&axis(0.0, 1.0)),
            ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]
        );
        assert_eq!(
            labels(&axis(-3.0, 3.0)),
            ["−3", "−2", "−1", "0", "1", "2", "3"]
        );
        assert_eq!(
            labels(&axis(0.0, 4.5e6)),
            ["0", "1×10⁶", "2×10⁶", "3×10⁶", "4×10⁶"]
        );
        assert_eq!(
            labels(&axis(-1e-7, 1e-7)),
            ["−1.0×10⁻⁷", "−0.5×10⁻⁷", "0", "0.5×10⁻⁷", "1.0×10⁻⁷"]
        );
    }

    #[test]
    fn ticks_stay_inside_any_range() {
        let mut state = 7u64;
        let mut random = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        for _ in 0..20_000 {
            let size = 10f64.powf(40.0 * random() - 20.0);
            let range = (size * (random() - 0.5), size * (random() - 0.5));
            let positive = (range.0.abs() + 1e-30, range.1.abs() + 1e-30);
            for (axis, range) in [
                (Axis::linear("", range), range),
                (Axis::log("", positive), positive),
            ] {
                let (low, high) = (range.0.min(range.1), range.0.max(range.1));
                let slack = 1e-12 * low.abs().max(high);
                let marks = axis.marks(6);
                let major = marks.iter().filter(|mark| !mark.minor).count();
                assert!((1..=16).contains(&major), "{major} labels in {range:?}");
                for mark in marks {
                    assert!(
                        mark.at >= low - slack && mark.at <= high + slack,
                        "{} is outside {range:?}",
                        mark.at
                    );
                }
            }
        }
    }

    #[test]
    fn log_ticks_are_powers_of_ten() {
        let marks = Axis::log("", (1e-3, 1e2)).marks(6);
        let major: Vec<_> = marks.iter().filter(|m| !m.minor).collect();
        assert_eq!(
            major.iter().map(|m| m.label.as_str()).collect::<Vec<_>>(),
            ["10⁻³", "10⁻²", "10⁻¹", "10⁰", "10¹", "10²"]
        );
        assert_eq!(marks.iter().filter(|m| m.minor).count(), 5 * 8);
        assert_eq!(
            labels(&Axis::log("", (1.5, 60.0))),
            ["2", "5", "10", "20", "50"]
        );
        assert!(labels(&Axis::log("", (1e-30, 1e30))).len() < 9);
    }

    #[test]
    fn invalid_ranges_are_made_valid() {
        for range in [
            (0.0, 0.0),
            (3.0, 3.0),
            (f64::NAN, 1.0),
            (f64::NEG_INFINITY, f64::INFINITY),
            (-1.0, -2.0),
            (f64::MIN, f64::MAX),
            (0.0, 1e-320),
        ] {
            for axis in [Axis::linear("", range), Axis::log("", range)] {
                let (start, end) = axis.limits();
                assert!(
                    start.is_finite() && end.is_finite() && start != end,
                    "{axis:?}"
                );
                axis.marks(6);
            }
        }
        assert_eq!(Axis::log("", (0.0, 10.0)).limits(), (-2.0, 1.0));
    }

    #[test]
    fn named_ticks_outside_the_range_are_omitted() {
        let axis = Axis::linear("", (0.0, 2.0)).ticks([(2.0, "M"), (0.0, "Γ"), (3.0, "X")]);
        assert_eq!(labels(&axis), ["Γ", "M"]);
    }
}
