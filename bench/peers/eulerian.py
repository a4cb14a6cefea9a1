"""The Eulerian kernel on the convected lattice with a fixed support, in the exact linearization.

Per state: force constants Phi(R) in real space, once; then D(k) = sum_R Phi(R) (cos k.R - 1) at all wave vectors as one
product of matrices. States are binned by their stretches; each bin has the fixed list of neighbors that its smallest
stretches need, and particles beyond the support have zero weight. The batch is the last axis. All of it holds for any F in
the plane whose neighbors are in the list.

A force constant is a sum over a point's pairs of neighbors (I, K) with K - I = R of products of what depends on I and what
depends on K: the latter lie in windows of a dense array over lattice coordinates, which are shifted and added, one I at a
time.
"""

from dataclasses import dataclass

import numpy as np

from . import lattice, material


@dataclass(frozen=True)
class Point:
    """A quadrature point of a neighborhood."""

    is_node: bool
    # Number of equivalent points in the cell.
    multiplicity: float
    # X_K - X_q of the neighbors [N, 2], and their indices in the window.
    offsets: np.ndarray
    places: np.ndarray
    # Neighbors I of the sum, their multiplicities, and the first indices of their windows in the dense array.
    own: np.ndarray
    weights: np.ndarray
    corners: np.ndarray
    # Index of R = -I in the dense array, for each I of the sum.
    homes: np.ndarray


@dataclass(frozen=True)
class Neighborhood:
    """All that depends on neither state nor wave vector."""

    points: list
    # The extent of a window in lattice coordinates; R goes from 1 - window to window - 1.
    window: tuple
    # One of each pair R, -R in lattice coordinates, and the indices of both in the flattened dense array.
    vectors: np.ndarray
    forward: np.ndarray
    backward: np.ndarray

    @property
    def dense(self):
        """The shape of the dense array of force constants."""
        return tuple(2 * extent - 1 for extent in self.window)


def is_lost(smallest_stretches):
    """Whether a point has too few neighbors at all states with at least these stretches."""
    return any(
        len(lattice.cells_within(place, lattice.SUPPORT, smallest_stretches)) < lattice.NEEDED
        for place in (lattice.NODE, lattice.TRIANGLE)
    )


def neighborhood(smallest_stretches):
    """The neighbors of all states with at least these stretches along the axes."""
    places = (lattice.NODE, lattice.TRIANGLE)
    sets = [lattice.cells_within(place, lattice.SUPPORT, smallest_stretches) for place in places]
    window = tuple(int(max(np.ptp(cells[:, d]) for cells in sets)) + 1 for d in range(2))
    last = np.array(window) - 1
    vectors, points = set(), []
    for place, cells, multiplicity in zip(places, sets, (1.0, 2.0)):
        difference = (cells[None] - cells[:, None]).reshape(-1, 2)
        vectors |= {tuple(r) for r in difference if tuple(r) > (0, 0)}
        low, is_node = cells.min(axis=0), multiplicity == 1.0
        # About a particle, I and -I contribute the same to Phi(R) + Phi(-R).
        leading = np.array([tuple(cell) >= (0, 0) for cell in cells])
        own = np.flatnonzero(leading) if is_node else np.arange(len(cells))
        weights = np.where((cells[own] == 0).all(axis=1) | (not is_node), 1.0, 2.0)
        points.append(
            Point(
                is_node,
                multiplicity,
                (cells - place) @ lattice.VECTORS,
                (cells - low) @ np.array([window[1], 1]),
                own,
                weights,
                (last - (cells[own] - low)).astype(np.int32),
                (last - cells[own]) @ np.array([2 * window[1] - 1, 1]),
            )
        )
    # The contribution to R = 0 cancels, because a translation requires no force.
    vectors = np.array(sorted(vectors), dtype=np.int64).reshape(-1, 2)
    flat = np.array([2 * window[1] - 1, 1])
    return Neighborhood(points, window, vectors, (vectors + last) @ flat, (last - vectors) @ flat)


def all_points(smallest_stretches):
    """All quadrature points of a cell, with all of their neighbors at states with at least these stretches."""
    points = []
    for place in (lattice.NODE, lattice.TRIANGLE, 2.0 * lattice.TRIANGLE):
        cells = lattice.cells_within(place, lattice.SUPPORT, smallest_stretches)
        offsets, every = (cells - place) @ lattice.VECTORS, np.arange(len(cells))
        is_node = place is lattice.NODE
        points.append(Point(is_node, 1.0, offsets, every, every, np.ones(len(cells)), None, None))
    return points


def cosines(neighborhood, fractions):
    """cos(k.R) - 1 [K, R], without cancellation for long waves."""
    return -2.0 * np.sin(np.pi * fractions @ neighborhood.vectors.T) ** 2


def factors(xp, point, f, sigma, a, factor):
    """The factors of the pairs (I, K) of a point: of I [I, 13, B], of K [N, 7, B], of I alone [I, 4, B] (the motion of a
    particle as a quadrature point); and whether the point sees enough. Rows of components 11, 12, 21, 22."""
    two = range(2)
    radius = lattice.SUPPORT
    x = point.offsets
    y = [(f[j][0][None] * x[:, 0, None] + f[j][1][None] * x[:, 1, None]) / radius for j in two]
    q = xp.sqrt(y[0] * y[0] + y[1] * y[1])
    p = xp.maximum(1.0 - q, 0.0)
    slope, curvature = -12.0 * p * p / radius**2, 24.0 * p / (q + 1e-300) / radius**2
    w = p * p * p * (1.0 + 3.0 * q)
    g = [slope * y[j] * radius for j in two]
    mixed = curvature * y[0] * y[1]
    h = [[slope + curvature * y[0] * y[0], mixed], [mixed, slope + curvature * y[1] * y[1]]]
    enough = xp.sum(q < lattice.RIM, axis=0) >= lattice.NEEDED

    # Shepard: phi = w / S; gradient and Hessian with respect to the point. The derivatives with respect to the particles are contracted below.
    total = xp.sum(w, axis=0)
    inverse = 1.0 / total
    s1 = [xp.sum(g[j], axis=0) for j in two]
    first = [s1[j] * inverse * inverse for j in two]
    gradient = [first[j] * w - inverse * g[j] for j in two]
    stress_h = [[sum(sigma[i][j] * h[j][k] for j in two) for k in two] for i in two]
    stress_g = [sum(sigma[i][j] * g[j] for j in two) for i in two]
    stress_s = [sum(sigma[i][j] * s1[j] for j in two) for i in two]

    def hessian():
        second = [
            [
                2.0 * s1[j] * s1[t] * inverse**3 - xp.sum(h[j][t], axis=0) * inverse * inverse
                for t in two
            ]
            for j in two
        ]
        return [
            [second[j][t] * w - first[j] * g[t] - first[t] * g[j] + inverse * h[j][t] for t in two]
            for j in two
        ]

    moved = hessian()
    on_w, on_g, on_h = [], [], factor * inverse**2 * w
    to_self = []
    for i in two:
        for k in two:
            # Sum of (grad phi_I)_j a_ijkl and sigma_il (grad phi_I)_k.
            elastic = [
                factor * (sum(a[i][j][k][l] * gradient[j] for j in two) + sigma[i][l] * gradient[k])
                for l in two
            ]
            on_w.append(sum(elastic[l] * first[l] for l in two))
            on_g.append([-elastic[t] * inverse for t in two])
            on_g[-1][k] = on_g[-1][k] + factor * (
                stress_g[i] * inverse**2 - 2.0 * stress_s[i] * inverse**3 * w
            )
            motion = factor * sum(sigma[i][j] * moved[j][k] for j in two)
            if point.is_node:
                to_self.append(motion)
            else:
                # A stress point moves with the interpolated displacement.
                on_w[-1] = on_w[-1] + motion * inverse
    count = point.weights[:, None, None]
    of_i = xp.stack([*on_w, *[b[0] for b in on_g], *[b[1] for b in on_g], on_h], axis=1)[point.own]
    of_k = xp.stack([w, *g, *[stress_h[i][k] for i in two for k in two]], axis=1)
    alone = xp.stack(to_self, axis=1)[point.own] * count if point.is_node else None
    return of_i * count, of_k, alone, enough


def product(of_i, of_k):
    """What one I [13, B] and all K [..., 7, B] add to the force constants, [..., 4, B]."""
    return (
        of_i[0:4] * of_k[..., 0:1, :]
        + of_i[4:8] * of_k[..., 1:2, :]
        + of_i[8:12] * of_k[..., 2:3, :]
        + of_i[12] * of_k[..., 3:7, :]
    )


def spatial(xp, f):
    """J, sigma_ij and a_ijkl = F_jJ F_lL A_iJkL / J at F [2][2][B]."""
    two = range(2)
    jacobian, piola, nominal = material.tangent(xp, f)
    sigma = [[sum(piola[i][m] * f[j][m] for m in two) / jacobian for j in two] for i in two]
    component = lambda i, j, k, l: (
        sum(f[j][m] * f[l][n] * nominal[i][m][k][n] for m in two for n in two) / jacobian
    )
    a = [[[[component(i, j, k, l) for l in two] for k in two] for j in two] for i in two]
    return jacobian, sigma, a
