"""Figures of answers whose commands draw none."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ._arrays import Complexes, Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ._answers import Answer, Boundary, Dispersion

PARTICLES = "tab:blue"
CONTINUUM = "0.6"


def along_wave(k: Floats, spectrum: Callable[[Floats], tuple[Complexes, Floats]], ax: Axes) -> Axes:
    """Draws ``omega^2`` along a wave vector, up to twice its length."""
    if not np.any(k):
        k = np.eye(1, k.size)[0] * np.pi
    shares = np.linspace(0.0, 2.0, 201)
    particles, continuum = spectrum(shares[:, None] * k)
    ax.plot(shares, continuum, color=CONTINUUM)
    ax.plot(shares, particles.real, color=PARTICLES)
    ax.axhline(0.0, color="black", linewidth=0.5)
    ax.axvline(1.0, color="black", linewidth=0.5, linestyle=":")
    low, high = float(np.min(particles.real)), float(np.max(particles.real))
    margin = 0.05 * (high - low) or 1.0
    ax.set_ylim(low - margin, high + margin)
    ax.set_xlabel("k / k*, k* the softest wave")
    ax.set_ylabel("ω²")
    return ax


def levels(particles: Complexes, continuum: Floats, ax: Axes) -> Axes:
    """Draws ``omega^2`` of particles and continuum for comparison."""
    ax.plot(np.arange(particles.size), particles.real, "o", color=PARTICLES, label="particles")
    ax.plot(np.arange(continuum.size), continuum, "_", color=CONTINUUM, markersize=16, label="continuum")
    ax.set_xlabel("branch")
    ax.set_ylabel("ω²")
    ax.legend()
    return ax


def curves(answer: Boundary, ax: Axes) -> Axes:
    """Draws boundaries over the axes of a study."""
    told = answer.geojson()
    for of, points in answer.curves():
        color = PARTICLES if of == "discretization" else "tab:orange"
        ax.plot(points[:, 0], points[:, 1], color=color, label=of)
    first, second = told["axes"]
    ax.set_xlabel(first["name"])
    ax.set_xlim(*first["range"])
    ax.set_ylabel(second["name"])
    ax.set_ylim(*second["range"])
    named = dict(zip(*reversed(ax.get_legend_handles_labels()), strict=True))
    if named:
        ax.legend(list(named.values()), list(named))
    return ax


def checks(answer: Answer, ax: Axes) -> Axes:
    """Draws the errors of the checks of an audit."""
    told = answer.to_dict()["checks"]
    known = [check for check in told if check["error"] is not None]
    errors = [max(float(check["error"]), 1e-17) for check in known]
    colors = ["tab:red" if check["outcome"] == "failed" else PARTICLES for check in known]
    ax.barh([check["name"] for check in known], errors, color=colors)
    ax.set_xscale("log")
    ax.set_xlabel("relative error")
    return ax


def shares(answer: Answer, ax: Axes) -> Axes:
    """Draws the number of states for each verdict."""
    verdicts = answer.to_dict()["verdicts"]
    return bars(list(verdicts), [share["states"] for share in verdicts.values()], "states", ax)


def bars(names: Sequence[str], values: Sequence[float], what: str, ax: Axes) -> Axes:
    """Draws a bar for each value."""
    ax.barh(list(names), list(values), color=PARTICLES)
    ax.set_xlabel(what)
    return ax


def scatter(answer: Dispersion, ax: Axes) -> Axes:
    """Draws values against the length of the wave vector."""
    length = np.linalg.norm(answer.k, axis=-1).ravel()
    for values, color, label in (
        (answer.continuum_omega_squared, CONTINUUM, "continuum"),
        (answer.omega_squared.real, PARTICLES, "particles"),
    ):
        flat = values.reshape(length.size, -1)
        for branch in range(flat.shape[1]):
            ax.plot(length, flat[:, branch], ".", color=color, label=label if branch == 0 else None)
    ax.set_xlabel("|k|")
    ax.set_ylabel("ω²")
    ax.legend()
    return ax
