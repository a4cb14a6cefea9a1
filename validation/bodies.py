#!/usr/bin/env python3
"""Critical time steps 2/omega of finite bodies, assembled and solved with NumPy and SciPy alone. Writes `bodies.json` beside itself.

Unit spacing, density and Young's modulus, neo-Hooke in the reference state (plane strain in two dimensions). Bodies are blocks of `size` spacings, without the
particles or elements of a notch (depth, width) at the middle of the first side from below, and with those below `held` along the second axis held fixed.
Total-Lagrangian SPH with the cubic spline, raw or corrected gradients and Ganzenmueller's penalty; linear finite elements, fully integrated, lumped masses;
bond-based peridynamics of constant influence, whole volumes and the continuum's micromodulus; material points (two along a side of a cell) of a block of filled cells.
"""
import itertools
import json
import math
from pathlib import Path

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as sl
from scipy.spatial import cKDTree


def tangent(poisson, dimension):
    mu, lam = 1 / 2 / (1 + poisson), poisson / (1 + poisson) / (1 - 2 * poisson)
    d = np.eye(dimension)
    a = lam * np.einsum("ij,kl->ijkl", d, d)
    a += mu * (np.einsum("ik,jl->ijkl", d, d) + np.einsum("il,jk->ijkl", d, d))
    return a.reshape(dimension**2, dimension**2)


def is_cut(x, size, notch):
    return notch is not None and abs(x[0] - size[0] / 2) < notch[1] / 2 and x[1] < notch[0]


def centers(size, notch):
    cells = itertools.product(*(range(n) for n in size))
    return [c for c in cells if not is_cut(np.array(c) + 0.5, size, notch)]


def spline(q):
    return 2 * ((1 - q) ** 3 - 4 * np.maximum(0.5 - q, 0) ** 3) * (q < 1)


def slope(q):
    return 2 * (-3 * (1 - q) ** 2 + 12 * np.maximum(0.5 - q, 0) ** 2) * (q < 1)


def sph(case):
    size, support = case["size"], case["support"]
    d = len(size)
    x = np.array(centers(size, case["notch"])) + 0.5
    height = {1: 4 / 3, 2: 40 / (7 * math.pi), 3: 8 / math.pi}[d] / support**d
    gradients = sp.lil_matrix((d * d * len(x), d * len(x)))
    bonds = []
    for own, near in enumerate(cKDTree(x).query_ball_point(x, support * (1 - 1e-12))):
        near = [other for other in near if other != own]
        apart = x[near] - x[own]
        r = np.linalg.norm(apart, axis=1)
        a = -(height * slope(r / support) / support / r)[:, None] * apart
        inverse = np.linalg.inv(apart.T @ a) if case["corrected"] else np.eye(d)
        for other, b, vector, length in zip(near, a @ inverse, apart, r):
            bonds.append((own, other, vector, height * spline(length / support) / length**2))
            for i in range(d):
                for j in range(d):
                    gradients[d * d * own + d * i + j, d * other + i] += b[j]
                    gradients[d * d * own + d * i + j, d * own + i] -= b[j]
    gradients = gradients.tocsr()
    stiffness = gradients.T @ sp.kron(sp.eye(len(x)), tangent(case["poisson"], d)) @ gradients
    if case["penalty"]:
        # Force on I: alpha/2 W/X^2 ((F_I + F_J) X - 2 x) . n n.
        missed = sp.lil_matrix((len(bonds), d * d * len(x)))
        moved = sp.lil_matrix((len(bonds), d * len(x)))
        pushed = sp.lil_matrix((d * len(x), len(bonds)))
        for k, (own, other, vector, weight) in enumerate(bonds):
            n = vector / np.linalg.norm(vector)
            for i in range(d):
                for j in range(d):
                    missed[k, d * d * own + d * i + j] += n[i] * vector[j]
                    missed[k, d * d * other + d * i + j] += n[i] * vector[j]
                moved[k, d * other + i] -= 2 * n[i]
                moved[k, d * own + i] += 2 * n[i]
                pushed[d * own + i, k] += case["penalty"] / 2 * weight * n[i]
        stiffness = stiffness + pushed.tocsr() @ (missed.tocsr() @ gradients + moved.tocsr())
    free = np.repeat(x[:, 1] > case["held"], d)
    return stiffness.tocsr(), np.ones(d * len(x)), free


def reference_elements(kind):
    """The elements of a cell: corners, and quadrature points as gradients of the shape functions with their volumes."""
    d = 2 if kind in ("quadrilaterals", "triangles") else 3
    corners = list(itertools.product((0, 1), repeat=d))
    if kind in ("quadrilaterals", "bricks"):
        points = []
        for at in itertools.product((0.5 - 0.5 / 3**0.5, 0.5 + 0.5 / 3**0.5), repeat=d):
            value = [[x if c else 1 - x for c, x in zip(corner, at)] for corner in corners]
            sign = [[1 if c else -1 for c in corner] for corner in corners]
            gradient = [[sign[a][i] * math.prod(value[a][j] for j in range(d) if j != i) for i in range(d)] for a in range(2**d)]
            points.append((np.array(gradient), 0.5**d))
        return [(corners, points)]
    elements = []
    for order in itertools.permutations(range(d)):
        nodes = [np.zeros(d, int)]
        for axis in order:
            nodes.append(nodes[-1] + np.eye(d, dtype=int)[axis])
        inverse = np.linalg.inv(np.array([[1, *node] for node in nodes]))
        elements.append(([tuple(node) for node in nodes], [(inverse[1:].T, 1 / math.factorial(d))]))
    return elements


def elements(case):
    size = case["size"]
    d = len(size)
    numbers, masses, blocks = {}, [], []
    for cell in centers(size, case["notch"]):
        for corners, points in reference_elements(case["mesh"]):
            nodes = [numbers.setdefault(tuple(np.add(cell, c)), len(numbers)) for c in corners]
            volume = sum(v for _, v in points)
            own = np.zeros((d * len(nodes),) * 2)
            for gradient, v in points:
                b = np.zeros((d * d, d * len(nodes)))
                for a in range(len(nodes)):
                    for i in range(d):
                        b[d * i : d * i + d, d * a + i] = gradient[a]
                own += v * b.T @ tangent(case["poisson"], d) @ b
            blocks.append((np.array([d * n + i for n in nodes for i in range(d)]), own))
            masses += [(n, volume / len(nodes)) for n in nodes]
    count = d * len(numbers)
    rows = np.concatenate([np.repeat(u, len(u)) for u, _ in blocks])
    columns = np.concatenate([np.tile(u, len(u)) for u, _ in blocks])
    stiffness = sp.csr_matrix((np.concatenate([k.ravel() for _, k in blocks]), (rows, columns)), (count, count))
    mass = np.zeros(len(numbers))
    for n, m in masses:
        mass[n] += m
    places = np.array(list(numbers))
    return stiffness, np.repeat(mass, d), np.repeat(places[:, 1] >= case["held"], d)


def peridynamics(case):
    size, horizon = case["size"], case["horizon"]
    d = len(size)
    x = np.array(centers(size, case["notch"])) + 0.5
    trace = sum(tangent(case["poisson"], d)[(d + 1) * i, (d + 1) * j] for i in range(d) for j in range(d))
    ball = {2: 2 * math.pi / 3, 3: math.pi}[d] * horizon ** (d + 1)
    micromodulus = 2 * trace / ball
    stiffness = sp.lil_matrix((d * len(x), d * len(x)))
    for own, other in cKDTree(x).query_pairs(horizon * (1 + 1e-12)):
        vector = x[other] - x[own]
        length = np.linalg.norm(vector)
        block = micromodulus / length * np.outer(vector, vector) / length**2
        for a, b, sign in ((own, own, 1), (other, other, 1), (own, other, -1), (other, own, -1)):
            stiffness[d * a : d * a + d, d * b : d * b + d] += sign * block
    return stiffness.tocsr(), np.ones(d * len(x)), np.repeat(x[:, 1] > case["held"], d)


def linear(r):
    return (1 - abs(r), -np.sign(r)) if abs(r) < 1 else (0, 0)


def quadratic(r):
    if abs(r) < 0.5:
        return 0.75 - r * r, -2 * r
    return (0.5 * (1.5 - abs(r)) ** 2, -(1.5 - abs(r)) * np.sign(r)) if abs(r) < 1.5 else (0, 0)


def material_points(case):
    size = case["size"]
    d = len(size)
    function = {"linear": linear, "quadratic-spline": quadratic}[case["functions"]]
    along = [(i + 0.5) / 2 for i in range(2)]
    numbers, mass, rows, columns, values, count = {}, [], [], [], [], 0
    for cell in centers(size, case["notch"]):
        for place in itertools.product(along, repeat=d):
            at = np.add(cell, place)
            for node in itertools.product(*(range(math.floor(x) - 1, math.floor(x) + 3) for x in at)):
                parts = [function(x - n) for x, n in zip(at, node)]
                value = math.prod(v for v, _ in parts)
                if value <= 0:
                    continue
                number = numbers.setdefault(node, len(numbers))
                if number == len(mass):
                    mass.append(0)
                mass[number] += value / 2**d
                for j in range(d):
                    gradient = math.prod(parts[k][1 if k == j else 0] for k in range(d))
                    for i in range(d):
                        rows.append(d * d * count + d * i + j)
                        columns.append(d * number + i)
                        values.append(gradient / 2 ** (d / 2))
            count += 1
    gradients = sp.csr_matrix((values, (rows, columns)), (d * d * count, d * len(numbers)))
    stiffness = gradients.T @ sp.kron(sp.eye(count), tangent(case["poisson"], d)) @ gradients
    places = np.array(list(numbers))
    return stiffness.tocsr(), np.repeat(mass, d), np.repeat(places[:, 1] >= case["held"], d)


def step(case):
    solver = {"sph": sph, "finite-elements": elements, "peridynamics": peridynamics, "material-points": material_points}
    stiffness, mass, free = solver[case["method"]](case)
    scale = sp.diags(mass[free] ** -0.5)
    matrix = scale @ stiffness[free][:, free] @ scale
    if matrix.shape[0] <= 1200:
        largest = np.linalg.eigvals(matrix.toarray()).real.max()
    else:
        largest = sl.eigs(matrix, k=4, which="LR", return_eigenvectors=False, ncv=60, tol=1e-11).real.max()
    return float(2 / math.sqrt(largest))


def cases():
    for corrected, (poisson, penalty, support) in itertools.product(
        (True, False), ((0.45, 0.1, 2.6), (0.3, 0.0, 2.6), (0.3, 0.5, 2.0))
    ):
        own = dict(method="sph", corrected=corrected, poisson=poisson, penalty=penalty, support=support)
        yield own | dict(size=[20, 20] if poisson == 0.45 else [9, 11], notch=None, held=0)
        yield own | dict(size=[12, 8], notch=[3, 2], held=0)
        yield own | dict(size=[10, 4], notch=None, held=1)
    for corrected, penalty in ((True, 0.0), (True, 0.1), (False, 0.1)):
        own = dict(method="sph", corrected=corrected, poisson=0.3, penalty=penalty, support=2.1)
        yield own | dict(size=[5, 6, 5], notch=None, held=0)
        yield own | dict(size=[6, 5, 4], notch=[2, 2], held=1)
    for mesh in ("quadrilaterals", "triangles", "bricks", "tetrahedra"):
        for poisson in (0.3, 0.45):
            flat = mesh in ("quadrilaterals", "triangles")
            own = dict(method="finite-elements", mesh=mesh, poisson=poisson)
            yield own | dict(size=[8, 6] if flat else [5, 4, 4], notch=None, held=0)
            yield own | dict(size=[8, 6] if flat else [6, 4, 3], notch=[2, 2], held=0 if poisson == 0.3 else 1)
        yield own | dict(size=[1, 1] if flat else [1, 1, 1], notch=None, held=0)
    for size, horizon in (([12, 10], 3.01), ([6, 6, 6], 2.01)):
        own = dict(method="peridynamics", poisson=0.25, horizon=horizon)
        yield own | dict(size=size, notch=None, held=0)
        yield own | dict(size=size, notch=[2, 2], held=0)
        yield own | dict(size=size, notch=None, held=1)
    for functions, poisson in itertools.product(("linear", "quadratic-spline"), (0.3, 0.45)):
        own = dict(method="material-points", functions=functions, poisson=poisson)
        yield own | dict(size=[8, 8], notch=None, held=0)
        yield own | dict(size=[8, 6], notch=[2, 2], held=1)


if __name__ == "__main__":
    lines = [json.dumps(case | {"step": step(case)}) for case in cases()]
    Path(__file__).with_name("bodies.json").write_text("[\n" + ",\n".join(lines) + "\n]\n")
