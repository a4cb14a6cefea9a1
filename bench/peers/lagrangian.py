"""The Lagrangian kernel: D(k) = A : H(k), where H depends on the discretization alone and is computed once."""

import numpy as np

from . import lattice, material


def shape_gradients(place):
    """X_K - X_q [N, 2] of the neighbors, in lattice coordinates, and the gradients of their Shepard functions [N, 2]."""
    cells = lattice.cells_within(place, lattice.SUPPORT * lattice.RIM)
    y = (cells - place) @ lattice.VECTORS / lattice.SUPPORT
    p = 1.0 - np.hypot(y[:, 0], y[:, 1])
    w = p**3 * (4.0 - 3.0 * p)
    g = (-12.0 * p**2 / lattice.SUPPORT)[:, None] * y
    total = np.sum(w)
    return cells - place, np.sum(g, axis=0) * w[:, None] / total**2 - g / total


def zone_tensors(fractions):
    """H_11, H_12, H_22 [3, K] with H_JL = 1/m sum_q V_q conj(B_J) B_L: real, by the inversion symmetry of the points."""
    result = 0.0
    for place, multiplicity in ((lattice.NODE, 1.0), (lattice.TRIANGLE, 2.0)):
        offsets, gradients = shape_gradients(place)
        b = np.exp(2j * np.pi * fractions @ offsets.T) @ gradients
        b1, b2 = b[:, 0], b[:, 1]
        h = np.stack([np.abs(b1) ** 2, (b1.conj() * b2).real, np.abs(b2) ** 2])
        result = result + multiplicity * lattice.VOLUME_FRACTION * h
    return result


def coefficients(xp, f):
    """D_11, D_12, D_22 as combinations of H_11, H_12, H_22: three lists of three arrays [B]."""
    _, _, a = material.tangent(xp, f)
    return [
        [a[i][0][k][0], a[i][0][k][1] + a[i][1][k][0], a[i][1][k][1]] for i, k in ((0, 0), (0, 1), (1, 1))
    ]
