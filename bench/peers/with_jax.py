"""Maps in JAX: compiled, batched, double precision, one thread a core.

A loop takes a few wave vectors at a time, with the running extremes of a batch of states in the cache. What was measured
besides, and is several times slower on a CPU: whole arrays over zone and states with `min`, `argmin` and `max`, as one writes
at first (`plain=True` of the Lagrangian map); one reduction of several operands; a product of matrices for the whole zone
before its spectrum; force constants by `segment_sum` or a product with a table of zeros and ones.
"""

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from . import eulerian, lagrangian, lattice, material
from .bins import Bins
from .states import LOW
from .threads import CORES, in_threads
from .zone import Zone, finished

jax.config.update("jax_enable_x64", True)

# Number of wave vectors per step of the loop; more would not fit into the registers.
STEP = 4


def diagonal(s):
    """F of stretches [2, B]."""
    zero = jnp.zeros_like(s[0])
    return [[s[0], zero], [zero, s[1]]]


def numbered(zone):
    """Indices of the wave vectors as floating-point numbers: a selection then has one width."""
    return np.arange(len(zone.fractions), dtype=np.float64)


def extremes(batch):
    """The empty extremes: scaled minimum, index of its wave vector, largest omega^2, largest square of the growth rate."""
    infinity = jnp.full((batch,), jnp.inf)
    return infinity, jnp.zeros((batch,)), -infinity, -infinity


def folded(carry, mean, root, growth, scale, index):
    """The extremes with one more wave vector."""
    minimum, where, largest, fastest = carry
    scaled = (mean - root) * scale
    lower = scaled < minimum
    return (
        jnp.where(lower, scaled, minimum),
        jnp.where(lower, index, where),
        jnp.maximum(largest, mean + root),
        jnp.maximum(fastest, growth),
    )


@jax.jit
def lagrangian_extremes(h, scale, index, s):
    c11, c12, c22 = lagrangian.coefficients(jnp, diagonal(s))
    means = [0.5 * (a + b) for a, b in zip(c11, c22)]
    halves = [0.5 * (a - b) for a, b in zip(c11, c22)]

    def step(carry, x):
        h, scale, index = x
        for n in range(STEP):
            at = lambda c: c[0] * h[n, 0] + c[1] * h[n, 1] + c[2] * h[n, 2]
            mean, half, off = at(means), at(halves), at(c12)
            root = jnp.sqrt(half * half + off * off)
            carry = folded(carry, mean, root, root - mean, scale[n], index[n])
        return carry, None

    return lax.scan(step, extremes(s.shape[1]), (h, scale, index))[0]


@jax.jit
def lagrangian_extremes_plain(h, scale, index, s):
    h = h.reshape(-1, 3)
    at = lambda c: sum(h[:, n, None] * c[n][None] for n in range(3))
    d11, d12, d22 = [at(c) for c in lagrangian.coefficients(jnp, diagonal(s))]
    mean, half = 0.5 * (d11 + d22), 0.5 * (d11 - d22)
    root = jnp.sqrt(half * half + d12 * d12)
    scaled = (mean - root) * scale.reshape(-1, 1)
    return (
        jnp.min(scaled, axis=0),
        jnp.argmin(scaled, axis=0),
        jnp.max(mean + root, axis=0),
        jnp.max(root - mean, axis=0),
    )


def force_constants(neighborhood, s):
    """Phi(R) + Phi(-R) [R, 4 B]; and which states keep their neighbors [B]."""
    batch, zero = s.shape[1], np.int32(0)
    f = diagonal(s)
    window = neighborhood.window + (4, batch)
    dense = jnp.zeros(neighborhood.dense + (4, batch))
    # Without barriers the compiler computes the kernel anew for each pair.
    jacobian, sigma, a = lax.optimization_barrier(eulerian.spatial(jnp, f))
    seen = True
    for point in neighborhood.points:
        factor = point.multiplicity * lattice.VOLUME_FRACTION * jacobian
        of_i, of_k, alone, enough = eulerian.factors(jnp, point, f, sigma, a, factor)
        of_k = jnp.zeros((np.prod(neighborhood.window), 7, batch)).at[point.places].set(of_k)
        of_i, of_k = lax.optimization_barrier((of_i, of_k.reshape(neighborhood.window + (7, batch))))

        def add(n, dense, of_i=of_i, of_k=of_k, corners=jnp.asarray(point.corners)):
            corner = (corners[n, 0], corners[n, 1], zero, zero)
            block = eulerian.product(lax.dynamic_index_in_dim(of_i, n, 0, False), of_k)
            return lax.dynamic_update_slice(dense, lax.dynamic_slice(dense, corner, window) + block, corner)

        dense = lax.fori_loop(0, len(point.own), add, dense)
        if alone is not None:
            flat = dense.reshape((-1, 4, batch)).at[point.homes].add(alone)
            dense = flat.reshape(dense.shape)
        seen = seen & enough
    flat = dense.reshape(-1, 4 * batch)
    return flat[neighborhood.forward] + flat[neighborhood.backward], seen


@jax.jit
def eulerian_extremes(cosines, scale, index, constants, seen):
    batch = seen.shape[0]

    def step(carry, x):
        cosines, scale, index = x
        # The barrier keeps this a product of matrices.
        d = lax.optimization_barrier(cosines @ constants).reshape(STEP, 4, batch)
        for n in range(STEP):
            mean, half = 0.5 * (d[n, 0] + d[n, 3]), 0.5 * (d[n, 0] - d[n, 3])
            square = half * half + d[n, 1] * d[n, 2]
            root = jnp.sqrt(jnp.maximum(square, 0.0))
            # (|w| - Re w) / 2 of the complex pair mean +- i sqrt(-square).
            complex_growth = 0.5 * (jnp.sqrt(jnp.maximum(mean * mean - square, 0.0)) - mean)
            growth = jnp.where(square < 0.0, complex_growth, root - mean)
            carry = folded(carry, mean, root, growth, scale[n], index[n])
        return carry, None

    minimum, *rest = lax.scan(step, extremes(batch), (cosines, scale, index))[0]
    lost = lambda value: jnp.where(seen, value, jnp.nan)
    return (lost(minimum), *map(lost, rest))


def eulerian_matrices_plain(points, k, s):
    """D(k) [K, 4] of one state, as one writes it at first: Fourier sums over a fixed list of neighbors."""
    f = diagonal(s[:, None])
    jacobian, sigma, a = eulerian.spatial(jnp, f)
    d, seen = 0.0, True
    for point in points:
        of_i, of_k, alone, enough = eulerian.factors(jnp, point, f, sigma, a, lattice.VOLUME_FRACTION * jacobian)
        of_i, of_k = of_i[..., 0], of_k[..., 0]
        phases = jnp.exp(1j * (k @ point.offsets.T))
        # A translation requires no force: D(0) = 0.
        for waves, sign in ((phases, 1.0), (jnp.ones((1, len(point.offsets))), -1.0)):
            left, right = waves.conj() @ of_i, waves @ of_k
            part = left[:, 12:13] * right[:, 3:7]
            for n in range(3):
                part = part + left[:, 4 * n : 4 * n + 4] * right[:, n : n + 1]
            if alone is not None:
                part = part + waves.conj() @ alone[..., 0]
            d = d + sign * part
        seen = seen & enough[0]
    return d, seen


def eulerian_extremes_plain(points, k, scale, s):
    """The extremes of one state."""
    d, seen = eulerian_matrices_plain(points, k, s)
    mean, half = 0.5 * (d[:, 0] + d[:, 3]), 0.5 * (d[:, 0] - d[:, 3])
    root = jnp.sqrt(half * half + d[:, 1] * d[:, 2])
    omega_squared = jnp.stack([mean - root, mean + root])
    scaled = jnp.min(omega_squared.real, axis=0) * scale
    growth = 0.5 * (jnp.abs(omega_squared) - omega_squared.real)
    found = jnp.min(scaled), jnp.argmin(scaled), jnp.max(omega_squared.real), jnp.max(growth)
    return tuple(jnp.where(seen, value, jnp.nan) for value in found)


class LagrangianMap:
    """The extremes of states over the zone of the Lagrangian kernel."""

    def __init__(self, resolution=48, symmetry="inversion", batch=1024, plain=False):
        self.zone = Zone(resolution, symmetry, STEP)
        self.batch = batch
        self.evaluate = lagrangian_extremes_plain if plain else lagrangian_extremes
        h = lagrangian.zone_tensors(self.zone.fractions).T
        tables = (h.reshape(-1, STEP, 3), *(t.reshape(-1, STEP) for t in (self.zone.scale, numbered(self.zone))))
        self.tables = jax.device_put(tables)

    def __call__(self, states, cores=CORES):
        count = len(states)
        padded = np.concatenate([states, np.repeat(states[-1:], -count % self.batch, axis=0)])
        batches = padded.reshape(-1, self.batch, 2).transpose(0, 2, 1)
        work = lambda s: [np.asarray(x) for x in self.evaluate(*self.tables, s)]
        parts = in_threads(work, batches, cores)
        columns = [np.concatenate(column)[:count] for column in zip(*parts)]
        return finished(self.zone, *columns)


class EulerianMap:
    """The extremes of states over the zone of the Eulerian kernel, by bins of stretches."""

    def __init__(self, resolution=48, symmetry="inversion", batch=256, bins=8, of=None):
        self.zone = Zone(resolution, symmetry, STEP)
        self.batch = batch
        # Another map's bins are taken with their compiled force constants: these do not depend on the zone.
        self.bins = of.bins if of else Bins(bins)
        self.constants = of.constants if of else {
            number: jax.jit(lambda s, neighbors=neighbors: force_constants(neighbors, s))
            for number, neighbors in self.bins.neighborhoods.items()
        }
        self.cosines = {}
        for number, neighbors in self.bins.neighborhoods.items():
            table = eulerian.cosines(neighbors, self.zone.fractions)
            self.cosines[number] = jax.device_put(table.reshape(-1, STEP, table.shape[1]))
        tables = (t.reshape(-1, STEP) for t in (self.zone.scale, numbered(self.zone)))
        self.scale, self.index = jax.device_put(tuple(tables))

    def evaluate(self, item):
        number, s = item
        constants, seen = self.constants[number](s)
        result = eulerian_extremes(self.cosines[number], self.scale, self.index, constants, seen)
        return [np.asarray(x) for x in result]

    def __call__(self, states, cores=CORES):
        return finished(self.zone, *self.bins.map(self.evaluate, states, self.batch, cores, in_threads))


class PlainEulerianMap:
    """The same as one writes it at first: `vmap` over states, all points of the zone, complex exponentials."""

    def __init__(self, resolution=48, batch=16):
        self.zone = Zone(resolution, "none")
        self.batch = batch
        points = eulerian.all_points((LOW, LOW))
        k, scale = lattice.wave_vectors(self.zone.fractions), self.zone.scale
        self.evaluate = jax.jit(jax.vmap(lambda s: eulerian_extremes_plain(points, k, scale, s)))

    def __call__(self, states, cores=CORES):
        count = len(states)
        padded = np.concatenate([states, np.repeat(states[-1:], -count % self.batch, axis=0)])
        work = lambda s: [np.asarray(x) for x in self.evaluate(s)]
        parts = in_threads(work, padded.reshape(-1, self.batch, 2), cores)
        columns = [np.concatenate(column)[:count] for column in zip(*parts)]
        return finished(self.zone, *columns)
