//! Symmetric images of wave vectors under the symmetries of a lattice sum. One wave vector represents all others with the same spectrum.

use super::cell::{Cell, Chart};
use crate::algebra::{Each, array_of};
use crate::lattice::{Fractional, Symmetry};

/// Weights of the components. Among wave vectors with the same spectrum, only the vector with the smallest weighted sum is examined.
///
/// They are powers of the reciprocal plastic number, which satisfy no relation with integer coefficients, so that only the identity leaves all sums
/// unchanged.
const WEIGHTS: [f64; 3] = [1.0, 0.754_877_666_246_692_7, 0.569_840_290_998_053_2];
/// Rounding error of components.
const COMPONENT_ROUNDING: f64 = 1e-12;
/// Largest distance of equal sites, in lattice coordinates.
const SITE_TOLERANCE: f64 = 1e-9;

/// Maps of wave vectors, in components along the reciprocal vectors, that leave the spectrum unchanged.
#[derive(Clone, Debug)]
pub(super) struct Images<const D: usize>(Vec<[[f64; D]; D]>);

impl<const D: usize> Images<D> {
    /// Collects the maps of a symmetry group of the lattice, and of the inversion, which maps each matrix to its conjugate.
    pub(super) fn new(group: &[Symmetry<D>]) -> Self {
        let one = |sign: f64| array_of(|i| array_of(|j| if i == j { sign } else { 0.0 }));
        let mut maps: Vec<[[f64; D]; D]> = vec![one(1.0), one(-1.0)];
        for symmetry in group {
            let map = symmetry.of_components();
            if !maps.contains(&map) {
                maps.extend([map, map.each(|row| row.each(|n| -n))]);
            }
        }
        // The identity changes nothing, and the inversion leaves the examined half of the zone.
        Self(maps.split_off(2))
    }

    /// Returns true if an image of a box in the examined half also lies in this half and has a smaller weighted sum, or an equal sum at the rim.
    ///
    /// A bound on all boxes without such an image then holds for all wave vectors: the weighted sum of an omitted wave vector decreases from image to
    /// image, and the number of images is finite. On planes of a constant sum, or within rounding of them, the bound follows from the
    /// neighborhood.
    pub(super) fn are_before(&self, cell: &Cell<D>) -> bool {
        self.0.iter().any(|map| match cell.chart {
            Chart::Zone => is_before_in_zone(map, cell),
            Chart::Cone(cone) => is_before_in_cone(map, cell, cone),
        })
    }
}

/// Possible permutations of sites under a symmetry of the lattice, one for each image of the first site.
pub(super) fn exchanges<const D: usize>(
    symmetry: &Symmetry<D>,
    places: &[Fractional<D>],
) -> impl Iterator<Item = Vec<usize>> {
    places.iter().filter_map(|first| {
        let image = |place: &Fractional<D>| {
            let moved = symmetry.of_place(&(place - places[0])) + first;
            places.iter().position(|other| {
                let apart = other - moved;
                (apart - apart.map(f64::round)).amax() < SITE_TOLERANCE
            })
        };
        places.iter().map(image).collect()
    })
}

/// Center and half range of a linear function on a box.
fn range<const D: usize>(row: &[f64; D], middle: &[f64; D], half: &[f64; D]) -> [f64; 2] {
    let (mut value, mut spread) = (0.0, 0.0);
    for j in 0..D {
        value += row[j] * middle[j];
        spread += row[j].abs() * half[j];
    }
    [value, spread]
}

/// Increase of the weighted sum under a map, as a linear function of the components.
fn increase<const D: usize>(map: &[[f64; D]; D]) -> [f64; D] {
    array_of(|j| (0..D).map(|i| WEIGHTS[i] * map[i][j]).sum::<f64>() - WEIGHTS[j])
}

fn is_before_in_zone<const D: usize>(map: &[[f64; D]; D], cell: &Cell<D>) -> bool {
    let mut moved = 0.0;
    for (i, row) in map.iter().enumerate() {
        let [middle, spread] = range(row, &cell.middle, &cell.half);
        // Reciprocal vectors move the image back into the zone.
        let shift = -middle.round();
        let least = if i == 0 { 0.0 } else { -0.5 };
        if middle + shift - spread < least - COMPONENT_ROUNDING
            || middle + shift + spread > 0.5 + COMPONENT_ROUNDING
        {
            return false;
        }
        moved += WEIGHTS[i] * shift;
    }
    let [middle, spread] = range(&increase(map), &cell.middle, &cell.half);
    moved + middle + spread <= COMPONENT_ROUNDING
}

/// The image of `t (e_a + s)` is `t` times the image of `e_a + s`, and no reciprocal vector is subtracted.
fn is_before_in_cone<const D: usize>(map: &[[f64; D]; D], cell: &Cell<D>, cone: usize) -> bool {
    let (mut middle, mut half) = ([0.0; D], [0.0; D]);
    middle[cone] = 1.0;
    for (variable, n) in Cell::<D>::others(cone) {
        (middle[n], half[n]) = (cell.middle[variable], cell.half[variable]);
    }
    if middle[0].abs() < half[0] {
        return false;
    }
    // A wave vector in the other half is replaced by its opposite.
    let sign = middle[0].signum();
    let middle = middle.each(|x| sign * x);
    let farthest = cell.middle[0] + cell.half[0];
    for (i, row) in map.iter().enumerate() {
        let [image, spread] = range(row, &middle, &half);
        let is_in_half = i > 0 || image - spread >= -COMPONENT_ROUNDING;
        if !is_in_half || farthest * (image.abs() + spread) > 0.5 + COMPONENT_ROUNDING {
            return false;
        }
    }
    let [image, spread] = range(&increase(map), &middle, &half);
    image + spread <= COMPONENT_ROUNDING
}

#[cfg(test)]
mod tests {
    use super::{Images, WEIGHTS};
    use crate::bloch::bound::cell::{Cell, Chart};
    use crate::lattice::{BravaisLattice, LatticeKind, Symmetry};
    use nalgebra::SVector;
    use std::f64::consts::TAU;

    /// Components of a wave vector, moved into the examined half of the zone, up to inversion.
    fn folded<const D: usize>(lattice: &BravaisLattice<D>, k: &SVector<f64, D>) -> SVector<f64, D> {
        let x = lattice.vectors().tr_mul(k) / TAU;
        let x = x.map(|x| x - x.round());
        if x[0] < 0.0 { -x } else { x }
    }

    fn sum<const D: usize>(x: &SVector<f64, D>) -> f64 {
        x.iter().zip(WEIGHTS).map(|(x, weight)| x * weight).sum()
    }

    /// Fraction of equally large boxes that are examined. Asserts that each corner of an omitted box has an image with a smaller sum.
    fn examined_share<const D: usize>(
        lattice: &BravaisLattice<D>,
        group: &[Symmetry<D>],
        n: usize,
    ) -> f64 {
        let images = Images::new(group);
        let half = 0.25 / n as f64;
        let mut kept = 0;
        for number in 0..n * (2 * n).pow(D as u32 - 1) {
            let mut rest = number;
            let middle: [f64; D] = std::array::from_fn(|a| {
                let count = if a == 0 { n } else { 2 * n };
                let place = rest % count;
                rest /= count;
                let start = if a == 0 { 0.0 } else { -0.5 };
                start + (2 * place + 1) as f64 * half
            });
            let chart = Chart::Zone;
            if !images.are_before(&Cell {
                chart,
                middle,
                half: [half; D],
            }) {
                kept += 1;
                continue;
            }
            for corner in 0..1 << D {
                let side = |a: usize| if corner >> a & 1 == 0 { 0.98 } else { -0.98 };
                let x = SVector::<f64, D>::from_fn(|a, _| middle[a] + side(a) * half);
                let k = lattice.reciprocal() * x;
                let is_before = |symmetry: &Symmetry<D>| {
                    sum(&folded(lattice, &(symmetry.map * k))) < sum(&x) - 1e-9
                };
                assert!(group.iter().any(is_before), "{x}");
            }
        }
        kept as f64 / (n * (2 * n).pow(D as u32 - 1)) as f64
    }

    #[test]
    fn omitted_boxes_have_earlier_images_and_the_number_of_boxes_falls_with_the_group_order() {
        // Inversion maps the examined half to the other half.
        let of_plane = |kind: LatticeKind| {
            let lattice = kind.lattice::<2>(1.0).unwrap();
            let group = Symmetry::all(&lattice);
            examined_share(&lattice, &group, 32) * (group.len() / 2) as f64
        };
        let of_space = |kind: LatticeKind| {
            let lattice = kind.lattice::<3>(1.0).unwrap();
            let group = Symmetry::all(&lattice);
            examined_share(&lattice, &group, 12) * (group.len() / 2) as f64
        };
        for share in [
            of_plane(LatticeKind::Square),
            of_plane(LatticeKind::Hexagonal),
        ] {
            assert!((1.0..1.3).contains(&share), "{share}");
        }
        for kind in [
            LatticeKind::SimpleCubic,
            LatticeKind::FaceCenteredCubic,
            LatticeKind::BodyCenteredCubic,
        ] {
            let share = of_space(kind);
            assert!((1.0..3.0).contains(&share), "{kind:?} {share}");
        }
        // The identity and the inversion alone omit no box.
        let lattice = LatticeKind::SimpleCubic.lattice::<3>(1.0).unwrap();
        let alone = &Symmetry::all(&lattice)[..1];
        assert_eq!(examined_share(&lattice, alone, 4), 1.0);
    }

    /// The image of a long wave is a long wave, and no reciprocal vector is subtracted.
    #[test]
    fn boxes_of_long_waves_are_omitted_only_if_all_their_waves_have_earlier_images() {
        let lattice = LatticeKind::FaceCenteredCubic.lattice::<3>(1.0).unwrap();
        let group = Symmetry::all(&lattice);
        let images = Images::new(&group);
        let (mut left_out, mut all) = (0, 0);
        for number in 0..3 * 16 * 16 {
            let place = |n: usize| (2 * n + 1) as f64 / 16.0 - 1.0;
            let cell = Cell {
                chart: Chart::Cone(number / 256),
                middle: [0.06, place(number / 16 % 16), place(number % 16)],
                half: [0.06, 1.0 / 16.0, 1.0 / 16.0],
            };
            all += 1;
            if !images.are_before(&cell) {
                continue;
            }
            left_out += 1;
            for corner in 0..8 {
                let side = |a: usize| if corner >> a & 1 == 0 { 0.98 } else { -0.98 };
                let mut own = cell;
                own.middle = std::array::from_fn(|a| cell.middle[a] + side(a) * cell.half[a]);
                let k = own.wave_vector(lattice.reciprocal());
                let x = folded(&lattice, &k);
                let is_before = |symmetry: &Symmetry<3>| {
                    sum(&folded(&lattice, &(symmetry.map * k))) < sum(&x) - 1e-9 * x.norm()
                };
                assert!(group.iter().any(is_before), "{x}");
            }
        }
        assert!(left_out > all / 2, "{left_out} of {all}");
    }
}
