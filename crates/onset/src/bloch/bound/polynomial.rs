//! Test whether a matrix polynomial of third order is positive definite on a box.

use super::jet::{
    Parts, bend, mixed, norm_of, parts, quadratic_parts, seconds, slope, third, thirds,
};
use crate::algebra::{Complex, array_of, factorize, hermitian_eigen};
use nalgebra::{DMatrix, DMatrixView, DVector};

/// Matrix polynomial `G(u) = sum_m G_m u^m` for `|u_a| <= 1`, with Hermitian coefficients in the order of a jet.
pub(super) struct Polynomial<const D: usize>(pub(super) Parts);

impl<const D: usize> Polynomial<D> {
    /// Returns true if one of the sufficient tests proves that the polynomial is positive definite on the box: directly, or for its soft vectors in a
    /// rotating frame.
    pub(super) fn is_positive_definite(&self) -> bool {
        let own = self.to_second_order();
        if own.is_far_from_singular() || own.is_a_mean() {
            return true;
        }
        self.of_soft().is_some_and(|soft| {
            let soft = soft.to_second_order();
            soft.is_a_mean() || soft.is_a_sum_of_squares()
        })
    }

    fn size(&self) -> usize {
        self.0.shape().0
    }

    /// Polynomial of second order below this one. On the box `u^3` is replaced by `3 u / 4`, with an error of 1/4, and `u^2 v` by `v / 2`, with an
    /// error of 1/2.
    fn to_second_order(&self) -> Self {
        let mut lower = Parts::zeros(self.size(), self.size(), quadratic_parts::<D>());
        for n in 0..quadratic_parts::<D>() {
            lower.entries_mut(n).copy_from_slice(self.0.entries(n));
        }
        let mut rest = 0.0;
        for [a, b, c] in thirds::<D>() {
            let part = third::<D>(a, b, c);
            let (share, error) = match (a == b, b == c) {
                (true, true) => (Some((a, 0.75)), 0.25),
                (true, false) => (Some((c, 0.5)), 0.5),
                (false, true) => (Some((a, 0.5)), 0.5),
                (false, false) => (None, 1.0),
            };
            if let Some((variable, factor)) = share {
                lower.add_part(slope(variable), (&self.0, part), factor);
            }
            rest += error * norm_of(&self.0.part(part));
        }
        let mut lower = Self(lower);
        lower.lower(rest);
        lower
    }

    /// Subtracts a multiple of the identity.
    fn lower(&mut self, by: f64) {
        for i in 0..self.size() {
            self.0.part_mut(0)[(i, i)] -= Complex::new(by, 0.0);
        }
    }

    /// Returns true if the change over the box is smaller than the smallest eigenvalue at the center. For polynomials of second order.
    fn is_far_from_singular(&self) -> bool {
        let change: f64 = (1..quadratic_parts::<D>())
            .map(|n| norm_of(&self.0.part(n)))
            .sum();
        let mut least = self.0.part(0).into_owned();
        (0..self.size()).for_each(|i| least[(i, i)] -= Complex::new(change, 0.0));
        factorize(&mut least)
    }

    /// Returns true if all Bernstein coefficients are positive definite; the polynomial is a mean of them. For polynomials of second order.
    ///
    /// The test is sharp for linear polynomials, even if their slopes do not commute. For curved polynomials a sum of squares is sharper.
    fn is_a_mean(&self) -> bool {
        let mut coefficient = self.0.part(0).into_owned();
        (0..3_usize.pow(D as u32)).all(|number| {
            let mut rest = number;
            let point: [f64; D] = array_of(|_| {
                let place = [0.0, 1.0, -1.0][rest % 3];
                rest /= 3;
                place
            });
            self.set_coefficient(&mut coefficient, &point);
            factorize(&mut coefficient)
        })
    }

    /// Bernstein coefficient of a point with components -1, 0 and 1.
    fn set_coefficient(&self, sum: &mut DMatrix<Complex>, point: &[f64; D]) {
        sum.copy_from(&self.0.part(0));
        let mut add = |part: usize, factor: f64| {
            if factor != 0.0 {
                let own = sum.as_mut_slice().iter_mut();
                own.zip(self.0.entries(part))
                    .for_each(|(own, entry)| *own += entry * factor);
            }
        };
        for a in 0..D {
            add(slope(a), point[a]);
        }
        for [a, b] in seconds::<D>() {
            // `u^2` has the coefficients 1, -1 and 1.
            let factor = match a == b {
                true => 2.0 * point[a] * point[a] - 1.0,
                false => point[a] * point[b],
            };
            add(bend::<D>(a, b), factor);
        }
    }

    /// Returns true if the polynomial is found to be a sum of squares on the box. For polynomials of second order.
    ///
    /// With `U = (1, u_1, ..., u_D)`, for any `T_a >= 0`
    ///
    /// `G(u) = (U x I)* S (U x I) + sum_a (1 - u_a^2) T_a`,
    ///
    /// where `S` has the blocks `S_00 = G_0 - sum_a T_a`, `S_aa = G_aa + T_a`, `S_a0 = G_a / 2` and `S_ab = G_ab / 2`. If `S` is positive definite,
    /// then `G` is positive definite on the box. The test is sharp around a minimum.
    fn is_a_sum_of_squares(&self) -> bool {
        let size = self.size();
        let mut squares = DMatrix::zeros(size * (D + 1), size * (D + 1));
        let mut set = |a: usize, b: usize, part: usize, factor: f64| {
            let mut block = squares.view_mut((a * size, b * size), (size, size));
            block.zip_apply(&self.0.part(part), |entry, own| *entry = own * factor);
        };
        set(0, 0, 0, 1.0);
        for a in 0..D {
            set(a + 1, 0, slope(a), 0.5);
            set(a + 1, a + 1, bend::<D>(a, a), 1.0);
        }
        for [a, b] in mixed::<D>() {
            set(a + 1, b + 1, bend::<D>(a, b), 0.5);
        }
        [false, true]
            .into_iter()
            .any(|is_mixed| factorize(&mut slackened::<D>(&squares, is_mixed)))
    }

    /// Polynomial of the soft vectors alone, which is positive definite only if the whole polynomial is; `None` if this construction fails.
    ///
    /// The eigenvectors of `G_0` are divided into soft and stiff ones. `A` contains the stiff eigenvalues, and `B_a` couples stiff with soft vectors.
    /// `R(u) = (1, sum_a u_a W_a)` with `W_a = -A^-1 B_a` rotates the soft vectors so that the coupling `F = (G R)_stiff` with the stiff vectors is
    /// of second order. With `E = R* G R`, `G` is positive definite if `E - F* G_stiff^-1 F` is. Since `G_stiff >= (1 - rho) A`, the second term is
    /// below `|A^-1/2 F|^2 / (1 - rho)`. For nearly incompressible solids, this separates soft from stiff branches up to the third order.
    fn of_soft(&self) -> Option<Self> {
        let eigen = hermitian_eigen(self.0.part(0).into_owned())?;
        let values = eigen.eigenvalues;
        if values.min() <= 0.0 {
            return None;
        }
        let whole = self
            .0
            .onto_rows(&eigen.eigenvectors)
            .times(&eigen.eigenvectors);
        let steep = |i: usize| {
            (0..D)
                .map(|a| row_sum(&whole.part(slope(a)), i))
                .sum::<f64>()
        };
        let (soft, stiff): (Vec<usize>, Vec<usize>) =
            (0..self.size()).partition(|i| values[*i] < steep(*i));
        let frame = Frame {
            stiffness: DVector::from_iterator(stiff.len(), stiff.iter().map(|i| values[*i])),
            whole,
            soft,
            stiff,
        };
        match frame.soft.len() {
            0 => None,
            _ => frame.turned(),
        }
    }
}

/// A polynomial in the eigenvectors of its center value, with the indices of soft and stiff vectors and the stiffnesses of the stiff vectors.
struct Frame {
    whole: Parts,
    soft: Vec<usize>,
    stiff: Vec<usize>,
    stiffness: DVector<f64>,
}

impl Frame {
    /// Polynomial of the soft vectors, rotated with the stiff ones.
    fn turned<const D: usize>(&self) -> Option<Polynomial<D>> {
        let (soft, stiff) = (self.soft.len(), self.stiff.len());
        // `rho`: the change of all terms except the constant, relative to it.
        let change: f64 = (1..parts::<D>()).map(|n| self.stiff_size(n)).sum();
        if change >= 1.0 {
            return None;
        }
        let block = |n: usize, rows: &[usize], columns: &[usize]| {
            let part = self.whole.part(n);
            DMatrix::from_fn(rows.len(), columns.len(), |i, j| {
                part[(rows[i], columns[j])]
            })
        };
        let slopes: [DMatrix<Complex>; D] = std::array::from_fn(|a| {
            let mut own = block(slope(a), &self.stiff, &self.soft);
            for (mut row, stiffness) in own.row_iter_mut().zip(&self.stiffness) {
                row /= Complex::new(-*stiffness, 0.0);
            }
            own
        });
        let turning: f64 = slopes.iter().map(|slope| slope.norm()).sum();
        // Soft and stiff rows of `G R`; the first order of the stiff rows vanishes.
        let mut own = Parts::zeros(soft, soft, parts::<D>());
        let mut coupled = Parts::zeros(stiff, soft, parts::<D>());
        for n in 0..parts::<D>() {
            own.part_mut(n).copy_from(&block(n, &self.soft, &self.soft));
            if n > D {
                coupled
                    .part_mut(n)
                    .copy_from(&block(n, &self.stiff, &self.soft));
            }
        }
        let one = Complex::new(1.0, 0.0);
        let products = turned_parts::<D>();
        for (n, a, before) in &products {
            let across = block(*before, &self.soft, &self.stiff);
            own.part_mut(*n).gemm(one, &across, &slopes[*a], one);
            if *n > D {
                let among = block(*before, &self.stiff, &self.stiff);
                coupled.part_mut(*n).gemm(one, &among, &slopes[*a], one);
            }
        }
        for (n, a, before) in products {
            own.part_mut(n)
                .gemm_ad(one, &slopes[a], &coupled.part(before), one);
        }
        let (mut coupling, mut last) = (0.0, 0.0);
        for n in D + 1..parts::<D>() {
            let part = coupled.part(n);
            let squares = part.row_iter().zip(&self.stiffness);
            coupling += squares
                .map(|(row, stiffness)| row.norm_squared() / stiffness)
                .sum::<f64>()
                .sqrt();
            if n >= quadratic_parts::<D>() {
                last += part.norm();
            }
        }
        // Terms of the products beyond the third order.
        let size = |rows: &[usize]| -> f64 {
            let thirds = quadratic_parts::<D>()..parts::<D>();
            thirds.map(|n| block(n, rows, &self.stiff).norm()).sum()
        };
        let (across, along) = (size(&self.soft), size(&self.stiff));
        let mut turned = Polynomial(own);
        if stiff > 0 {
            coupling += turning * along / self.stiffness.min().sqrt();
            let beyond = turning * (across + last + turning * along);
            turned.lower(beyond + coupling * coupling / (1.0 - change));
        }
        Some(turned)
    }

    /// Norm of a coefficient among stiff vectors, relative to their stiffnesses.
    fn stiff_size(&self, n: usize) -> f64 {
        let part = self.whole.part(n);
        let mut sum = 0.0;
        for (i, row) in self.stiff.iter().enumerate() {
            for (j, column) in self.stiff.iter().enumerate() {
                let unit = self.stiffness[i] * self.stiffness[j];
                sum += part[(*row, *column)].norm_sqr() / unit;
            }
        }
        sum.sqrt()
    }
}

/// Terms of the product of a polynomial with a linear one without constant: index of the product, variable, and index of the first factor.
fn turned_parts<const D: usize>() -> Vec<(usize, usize, usize)> {
    let mut products = Vec::with_capacity(D * quadratic_parts::<D>());
    products.extend((0..D).map(|a| (slope(a), a, 0)));
    for [a, b] in seconds::<D>() {
        let part = bend::<D>(a, b);
        products.push((part, a, slope(b)));
        if a != b {
            products.push((part, b, slope(a)));
        }
    }
    for [a, b, c] in thirds::<D>() {
        let part = third::<D>(a, b, c);
        products.push((part, a, bend::<D>(b, c)));
        if b != a {
            products.push((part, b, bend::<D>(a, c)));
        }
        if c != b {
            products.push((part, c, bend::<D>(a, b)));
        }
    }
    products
}

/// `S` with diagonal `T_a`. Without mixed terms, `max(0, |B_a| / 2 - X_a)` is the best choice for a single vector.
fn slackened<const D: usize>(squares: &DMatrix<Complex>, is_mixed: bool) -> DMatrix<Complex> {
    let count = squares.nrows() / (D + 1);
    let mut slackened = squares.clone();
    let entry = |row: usize, column: usize| match row < column {
        true => squares[(column, row)].norm(),
        false => squares[(row, column)].norm(),
    };
    for row in count..squares.nrows() {
        let linear: f64 = (0..count).map(|column| entry(row, column)).sum();
        let others = (count..squares.nrows()).filter(|column| *column != row);
        let mixed: f64 = others.map(|column| entry(row, column)).sum();
        let wanted = linear + if is_mixed { mixed } else { 0.0 };
        let slack = (wanted - squares[(row, row)].re).max(0.0);
        slackened[(row, row)] += slack;
        slackened[(row % count, row % count)] -= slack;
    }
    slackened
}

fn row_sum(matrix: &DMatrixView<'_, Complex>, row: usize) -> f64 {
    matrix.row(row).iter().map(|entry| entry.norm()).sum()
}

#[cfg(test)]
mod tests {
    use super::{Parts, Polynomial};
    use crate::algebra::{Complex, array_of, factorize};
    use crate::bloch::bound::jet::{derivatives, parts, products};
    use nalgebra::{DMatrix, SVector};
    use proptest::prelude::*;
    use proptest::test_runner::TestRunner;
    use std::cell::Cell;

    fn hermitian(size: usize, entries: &[f64]) -> DMatrix<Complex> {
        let part = DMatrix::from_fn(size, size, |i, j| {
            Complex::new(entries[i * size + j], entries[size * size + i * size + j])
        });
        &part + part.adjoint()
    }

    impl<const D: usize> Polynomial<D> {
        fn at(&self, u: [f64; D]) -> DMatrix<Complex> {
            let mut sum = DMatrix::zeros(self.size(), self.size());
            for (n, monomial) in products(&u).into_iter().enumerate().take(parts::<D>()) {
                sum += self.0.part(n) * Complex::new(monomial, 0.0);
            }
            sum
        }

        fn of(coefficients: &[DMatrix<Complex>]) -> Self {
            let (rows, columns) = coefficients[0].shape();
            let mut parts = Parts::zeros(rows, columns, coefficients.len());
            for (n, own) in coefficients.iter().enumerate() {
                parts.part_mut(n).copy_from(own);
            }
            Self(parts)
        }
    }

    /// Tests a random polynomial. If the test succeeds, the polynomial must be positive definite on a grid of points. Returns whether it succeeds.
    fn is_right<const D: usize>(
        entries: &[f64],
        [shift, stiff, size]: [f64; 3],
        points: usize,
    ) -> Result<bool, TestCaseError> {
        let orders = derivatives::<D>();
        let mut coefficients: Vec<DMatrix<Complex>> = (0..parts::<D>())
            .map(|n| {
                let part = hermitian(3, &entries[18 * n..18 * (n + 1)]);
                let factor = if n == 0 {
                    0.2
                } else {
                    size.powi(orders[n].order as i32)
                };
                part * Complex::new(factor, 0.0)
            })
            .collect();
        for i in 0..3 {
            let own = size * shift + if i == 2 { stiff } else { 0.0 };
            coefficients[0][(i, i)] += Complex::new(own, 0.0);
        }
        let polynomial = Polynomial::<D>::of(&coefficients);
        let is_proved =
            factorize(&mut coefficients[0].clone()) && polynomial.is_positive_definite();
        if is_proved {
            for number in 0..points.pow(D as u32) {
                let u = array_of(|a| {
                    let place = number / points.pow(a as u32) % points;
                    2.0 * place as f64 / (points - 1) as f64 - 1.0
                });
                prop_assert!(factorize(&mut polynomial.at(u)), "{u:?}");
            }
        }
        Ok(is_proved)
    }

    #[test]
    fn the_test_of_positive_definiteness_has_no_false_positives() {
        let numbers = (
            proptest::collection::vec(-1.0..1.0f64, 20 * 18),
            0.0..12.0f64,
            0.0..60.0f64,
            0.02..1.0f64,
        );
        let proved = [Cell::new(0), Cell::new(0)];
        TestRunner::new(ProptestConfig::with_cases(2000))
            .run(&numbers, |(entries, shift, stiff, size)| {
                let numbers = [shift, stiff, size];
                for (proved, is_proved) in proved.iter().zip([
                    is_right::<2>(&entries, numbers, 20)?,
                    is_right::<3>(&entries, numbers, 7)?,
                ]) {
                    proved.set(proved.get() + usize::from(is_proved));
                }
                Ok(())
            })
            .expect("all are");
        assert!(proved.iter().all(|proved| proved.get() > 200), "{proved:?}");
    }

    /// A soft vector with `(u - u0).H (u - u0) + floor`, coupled to a stiff one: the minimum on the box is `floor`.
    #[test]
    fn the_test_is_sharp_around_the_minimum_of_a_soft_vector() {
        let bottom = SVector::from([0.3, -0.4]);
        let h = nalgebra::Matrix2::new(2e-4, 1.2e-4, 1.2e-4, 1e-4);
        let coupling = [Complex::new(0.02, 0.01), Complex::new(-0.015, 0.02)];
        let proves = |floor: f64| {
            let soft = |x: f64| {
                let mut part = DMatrix::<Complex>::zeros(2, 2);
                part[(0, 0)] = Complex::new(x, 0.0);
                part
            };
            let bent = |a: usize, b: usize| h[(a, b)] + (coupling[a] * coupling[b].conj()).re;
            let slope = -2.0 * h * bottom;
            let mut constant = soft(bottom.dot(&(h * bottom)) + floor);
            constant[(1, 1)] = Complex::new(1.0, 0.0);
            let coupled = |a: usize| {
                let mut part = soft(slope[a]);
                part[(0, 1)] = coupling[a];
                part[(1, 0)] = coupling[a].conj();
                part
            };
            let mut parts = vec![constant, coupled(0), coupled(1)];
            parts.extend([soft(bent(0, 0)), soft(2.0 * bent(0, 1)), soft(bent(1, 1))]);
            parts.extend((0..4).map(|_| soft(0.0)));
            Polynomial::<2>::of(&parts).is_positive_definite()
        };
        assert!(proves(1e-9));
        assert!(!proves(-1e-9));
    }
}
