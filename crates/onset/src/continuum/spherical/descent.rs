//! Descent from a direction to the next minimum of the smallest eigenvalue.
//!
//! The smallest eigenvalue is not smooth where it is double, but `g . Q(N) g` is smooth as a function of two unit vectors, and has the same minimum.
//! For fixed `N` the best `g` is an eigenvector of `Q(N)`. For fixed `g` the best `N` is an eigenvector of `P(g)_JL = T_iJkL g_i g_k`. Alternating
//! between them never increases the value, and Newton's method in both vectors completes the descent.

use super::form::Form;
use super::{Axes, dot};
use crate::algebra::{Each, array_of, symmetric_eigen};

/// Largest number of steps. A few steps suffice unless the minimum is flat, where each step reduces the distance by no more than a third.
const DESCENT_STEPS: usize = 200;
/// Rounding error of a form of magnitude one.
const FORM_ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Plane wave: unit direction, unit polarization and eigenvalue.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wave {
    pub(crate) direction: Axes<f64>,
    pub(crate) polarization: Axes<f64>,
    pub(crate) eigenvalue: f64,
}

/// Wave of the smallest eigenvalue in a direction of any length.
pub(crate) fn slowest(form: &Form<f64>, direction: &Axes<f64>) -> Wave {
    let length = dot(direction, direction).sqrt();
    let direction = direction.each(|component| component / length);
    let (values, vectors) = symmetric_eigen(&form.acoustic(&direction, &direction));
    Wave {
        direction,
        polarization: vectors[0],
        eigenvalue: values[0],
    }
}

/// Minimizes the eigenvalue from a wave: by Newton's method where it decreases the value, otherwise by alternating steps.
pub(crate) fn descended(form: &Form<f64>, start: Wave) -> Wave {
    let mut wave = start;
    for _ in 0..DESCENT_STEPS {
        let by_newton = newton_direction(form, &wave).map(|n| slowest(form, &n));
        let next = match by_newton {
            Some(next) if next.eigenvalue < wave.eigenvalue - FORM_ROUNDING => next,
            _ => {
                let (_, vectors) = symmetric_eigen(&polarized(form, &wave.polarization));
                slowest(form, &vectors[0])
            }
        };
        if next.eigenvalue < wave.eigenvalue - FORM_ROUNDING {
            wave = next;
            continue;
        }
        // No further decrease. A final Newton step doubles the accurate digits of the direction; alternating steps would drift if all directions are
        // equivalent.
        return match by_newton {
            Some(next) if next.eigenvalue <= wave.eigenvalue + FORM_ROUNDING => next,
            _ => wave,
        };
    }
    wave
}

/// Matrix `P(g)_JL = T_iJkL g_i g_k` of a polarization.
fn polarized(form: &Form<f64>, g: &Axes<f64>) -> [[f64; 3]; 3] {
    let entry = |j: usize, l: usize| {
        let terms = (0..9).map(|n| g[n / 3] * g[n % 3] * form.at(3 * (n / 3) + j, 3 * (n % 3) + l));
        terms.sum::<f64>()
    };
    let mut p = [[0.0; 3]; 3];
    for j in 0..3 {
        for l in 0..=j {
            p[j][l] = 0.5 * (entry(j, l) + entry(l, j));
            p[l][j] = p[j][l];
        }
    }
    p
}

/// Direction after a step of Newton's method for `g . Q(N) g` on the two unit spheres; `None` if the second derivative is not positive.
fn newton_direction(form: &Form<f64>, wave: &Wave) -> Option<Axes<f64>> {
    let (n, g) = (&wave.direction, &wave.polarization);
    let (n_across, g_across) = (across(n), across(g));
    // H = g (x) N and the four tangents of the manifold.
    let dyad = |g: &Axes<f64>, n: &Axes<f64>| -> [f64; 9] { array_of(|p| g[p / 3] * n[p % 3]) };
    let tangents = [
        dyad(&g_across[0], n),
        dyad(&g_across[1], n),
        dyad(g, &n_across[0]),
        dyad(g, &n_across[1]),
    ];
    let image =
        |h: &[f64; 9]| -> [f64; 9] { array_of(|p| (0..9).map(|q| form.at(p, q) * h[q]).sum()) };
    let product = |a: &[f64; 9], b: &[f64; 9]| -> f64 { a.iter().zip(b).map(|(x, y)| x * y).sum() };
    let of_wave = image(&dyad(g, n));
    let slope = tangents.each(|tangent| product(&tangent, &of_wave));
    let images = tangents.each(|tangent| image(&tangent));
    let mut curvature = [[0.0; 4]; 4];
    for i in 0..4 {
        for j in 0..4 {
            curvature[i][j] = product(&tangents[i], &images[j]);
        }
        curvature[i][i] -= wave.eigenvalue;
    }
    for i in 0..2 {
        for j in 0..2 {
            // Mixed derivative: both vectors change.
            let both = product(&dyad(&g_across[i], &n_across[j]), &of_wave);
            curvature[i][2 + j] += both;
            curvature[2 + j][i] += both;
        }
    }
    let (values, vectors) = symmetric_eigen(&curvature);
    let stiffest = values[3];
    if stiffest.is_nan() || stiffest <= 0.0 || values[0] < -1e-7 * stiffest {
        return None;
    }
    let mut moves = [0.0; 4];
    for (value, vector) in values.iter().zip(vectors) {
        // Along flat valleys no decrease is possible.
        if *value > 1e-10 * stiffest {
            let along: f64 = vector.iter().zip(slope).map(|(v, s)| v * s).sum();
            (0..4).for_each(|i| moves[i] -= along / value * vector[i]);
        }
    }
    let [_, _, first, second] = moves;
    Some(array_of(|i| {
        n[i] + first * n_across[0][i] + second * n_across[1][i]
    }))
}

/// Two unit vectors orthogonal to a unit vector and to each other.
pub(super) fn across(v: &Axes<f64>) -> [Axes<f64>; 2] {
    let axis = if v[0].abs() < 0.6 {
        [1.0, 0.0, 0.0]
    } else {
        [0.0, 1.0, 0.0]
    };
    let first = cross(v, &axis);
    let length = dot(&first, &first).sqrt();
    let first = first.each(|component| component / length);
    [first, cross(v, &first)]
}

fn cross(a: &Axes<f64>, b: &Axes<f64>) -> Axes<f64> {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}
