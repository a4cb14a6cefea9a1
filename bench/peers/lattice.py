"""The hexagonal lattice (spacing 1, density 1) with stress points, and wave vectors of its zone."""

import numpy as np

# Primitive vectors a_i as rows, reciprocal vectors b_i as rows: a_i . b_j = 2 pi delta_ij.
VECTORS = np.array([[1.0, 0.0], [0.5, 0.5 * np.sqrt(3.0)]])
RECIPROCAL = 2.0 * np.pi * np.linalg.inv(VECTORS).T
# Support D_mx in units of the spacing.
SUPPORT = 2.0
# The particle, and the centroid of one of the two triangles, in lattice coordinates. The other centroid is its mirror
# image about the particle: it contributes the complex conjugate.
NODE = np.zeros(2)
TRIANGLE = np.full(2, 1.0 / 3.0)
# The three points of a cell form a hexagonal lattice of spacing 1/sqrt(3): their Voronoi cells are equal.
VOLUME_FRACTION = 1.0 / 3.0
# A particle on the rim of the support has zero weight and is no neighbor; a point needs three neighbors.
RIM = 1.0 - 1e-12
NEEDED = 3


def cells_within(place, radius, stretches=(1.0, 1.0)):
    """Lattice coordinates [N, 2] of the particles with |diag(stretches) (X_K - X_q)| < radius."""
    reach = int(np.ceil(2.0 * radius / min(stretches))) + 2
    n = np.stack(np.meshgrid(*[np.arange(-reach, reach + 1)] * 2, indexing="ij"), axis=-1).reshape(-1, 2)
    offsets = ((n - place) @ VECTORS) * np.asarray(stretches)
    return n[np.hypot(offsets[:, 0], offsets[:, 1]) < radius]


def laplacian(fractions):
    """|k|_h^2 = sum_i 2 (1 - cos k.a_i) / |a_i|^2 of k = sum_i fractions_i b_i."""
    return np.sum(4.0 * np.sin(np.pi * fractions) ** 2, axis=-1)


def zone_grid(resolution, symmetry="inversion"):
    """Points (j1, j2) / resolution of the zone without k = 0, as fractions of the reciprocal vectors [K, 2].

    `symmetry` tells which of equivalent points are kept: "none" all, "inversion" one of k and -k (D(-k) = conj D(k), at any
    state), "mirror" also one of those that the mirror symmetry of states stretched along the axes maps on each other.
    """
    j = np.stack(np.meshgrid(*[np.arange(resolution)] * 2, indexing="ij"), axis=-1).reshape(-1, 2)
    j = j[1:]
    number = lambda points: (points % resolution) @ np.array([resolution, 1])
    images = [j]
    if symmetry in ("inversion", "mirror"):
        images.append(-j)
    if symmetry == "mirror":
        # x -> -x takes a1 to -a1 and a2 to a2 - a1.
        mirrored = np.stack([-j[:, 0], j[:, 1] - j[:, 0]], axis=-1)
        images += [mirrored, -mirrored]
    kept = number(j) == np.min([number(image) for image in images], axis=0)
    return j[kept] / resolution


def wave_vectors(fractions):
    """Reference wave vectors k of fractions of the reciprocal vectors."""
    return fractions @ RECIPROCAL
