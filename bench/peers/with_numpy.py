"""Maps in NumPy: batches that stay in the cache, products of matrices where there are any, one thread a core.

NumPy computes one operation at a time and its threads do not share the work of one; run it with one thread a product of
matrices (OPENBLAS_NUM_THREADS=1), since the batches already occupy all cores.
"""

from functools import partial

import numpy as np

from . import eulerian, lagrangian, lattice, material
from .bins import Bins
from .threads import CORES, in_threads
from .zone import Zone, finished


def diagonal(s):
    """F of stretches [2, B]."""
    zero = np.zeros_like(s[0])
    return [[s[0], zero], [zero, s[1]]]


def extremes(zone, d11, d12d21, d22, real):
    """Scaled minimum, index of its wave vector, largest omega^2, largest square of the growth rate; arguments [B, K]."""
    mean = d11 + d22
    mean *= 0.5
    square = np.subtract(d11, mean, out=d11)
    square *= square
    square += d12d21
    growth = None
    if not real and np.any(square < 0.0):
        # (|w| - Re w) / 2 of the complex pair mean +- i sqrt(-square).
        growth = np.sqrt(np.maximum(mean * mean - square, 0.0))
        growth -= mean
        growth *= 0.5
        growth[square >= 0.0] = -np.inf
    root = np.sqrt(np.maximum(square, 0.0, out=square), out=square)
    largest = np.max(np.add(mean, root, out=d22), axis=1)
    # A complex pair grows at least as fast as its real part alone would.
    mean -= root
    fastest = -np.min(mean, axis=1)
    if growth is not None:
        np.maximum(fastest, np.max(growth, axis=1), out=fastest)
    mean *= zone.scale
    where = np.argmin(mean, axis=1)
    return [mean[np.arange(len(where)), where], where, largest, fastest]


def force_constants(neighborhood, s):
    """Phi(R) + Phi(-R) [R, 4, B]; and which states keep their neighbors [B]."""
    batch = s.shape[1]
    jacobian, sigma, a = eulerian.spatial(np, diagonal(s))
    extent1, extent2 = neighborhood.window
    dense = np.zeros(neighborhood.dense + (4, batch))
    seen = True
    for point in neighborhood.points:
        factor = point.multiplicity * lattice.VOLUME_FRACTION * jacobian
        of_i, of_k, alone, enough = eulerian.factors(np, point, diagonal(s), sigma, a, factor)
        window = np.zeros((extent1 * extent2, 7, batch))
        window[point.places] = of_k
        window = window.reshape(extent1, extent2, 7, batch)
        for own, (first, second) in zip(of_i, point.corners):
            dense[first : first + extent1, second : second + extent2] += eulerian.product(own, window)
        if alone is not None:
            dense.reshape(-1, 4, batch)[point.homes] += alone
        seen = seen & enough
    flat = dense.reshape(-1, 4, batch)
    return flat[neighborhood.forward] + flat[neighborhood.backward], seen


class LagrangianMap:
    """The extremes of states over the zone of the Lagrangian kernel."""

    def __init__(self, resolution=48, symmetry="inversion", batch=8):
        self.zone = Zone(resolution, symmetry)
        self.batch = batch
        self.h = lagrangian.zone_tensors(self.zone.fractions)

    def evaluate(self, s):
        rows = np.array(lagrangian.coefficients(np, diagonal(s)))
        d11, d12, d22 = (row.T @ self.h for row in rows)
        d12 *= d12
        return extremes(self.zone, d11, d12, d22, True)

    def __call__(self, states, cores=CORES):
        batches = [states[start : start + self.batch].T for start in range(0, len(states), self.batch)]
        parts = in_threads(self.evaluate, batches, cores)
        return finished(self.zone, *map(np.concatenate, zip(*parts)))


class EulerianMap:
    """The extremes of states over the zone of the Eulerian kernel, by bins of stretches."""

    def __init__(self, resolution=48, symmetry="inversion", batch=32, bins=8):
        self.zone = Zone(resolution, symmetry)
        self.batch = batch
        self.bins = Bins(bins)
        tables = self.bins.neighborhoods.items()
        self.cosines = {number: eulerian.cosines(n, self.zone.fractions).T.copy() for number, n in tables}

    def evaluate(self, item):
        number, s = item
        constants, seen = force_constants(self.bins.neighborhoods[number], s)
        d11, d12, d21, d22 = (constants[:, n].T @ self.cosines[number] for n in range(4))
        d12 *= d21
        return [np.where(seen, value, np.nan) for value in extremes(self.zone, d11, d12, d22, False)]

    def __call__(self, states, cores=CORES):
        mapped = partial(self.bins.map, self.evaluate, states, self.batch, cores, in_threads)
        return finished(self.zone, *mapped())
