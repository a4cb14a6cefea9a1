"""Figures with matplotlib, which is imported for the first figure."""

from __future__ import annotations

from collections.abc import Callable, Sequence
import io
from typing import TYPE_CHECKING

import numpy as np

from ._arrays import Complexes, Floats
from ._errors import OnsetError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ._answers import Answer, Bands, Boundary, Dispersion

PARTICLES = "tab:blue"
CONTINUUM = "0.6"


def _axes(ax: Axes | None) -> Axes:
    """Returns the given axes, or new axes."""
    if ax is not None:
        return ax
    try:
        from matplotlib import pyplot
    except ImportError as error:
        raise OnsetError("figures require matplotlib\n  hint: pip install matplotlib") from error
    axes: Axes = pyplot.subplots(layout="constrained")[1]
    return axes


def picture(files: dict[str, bytes], ax: Axes | None) -> Axes:
    """Draws the figure of the command."""
    pictures = [data for name, data in files.items() if name.endswith(".png")]
    if not pictures:
        raise OnsetError("this answer has no figure")
    ax = _axes(ax)
    from matplotlib import image

    ax.imshow(image.imread(io.BytesIO(pictures[0]), format="png"))
    ax.set_axis_off()
    return ax


def along_wave(k: Floats, spectrum: Callable[[Floats], tuple[Complexes, Floats]], ax: Axes | None) -> Axes:
    """Draws ``omega^2`` along a wave vector, up to twice its length."""
    ax = _axes(ax)
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


def levels(particles: Complexes, continuum: Floats, ax: Axes | None) -> Axes:
    """Draws ``omega^2`` of particles and continuum for comparison."""
    ax = _axes(ax)
    ax.plot(np.arange(particles.size), particles.real, "o", color=PARTICLES, label="particles")
    ax.plot(np.arange(continuum.size), continuum, "_", color=CONTINUUM, markersize=16, label="continuum")
    ax.set_xlabel("branch")
    ax.set_ylabel("ω²")
    ax.legend()
    return ax


def _signed(omega_squared: Floats) -> Floats:
    """Returns frequencies; growth rates are negative."""
    return np.sign(omega_squared) * np.sqrt(np.abs(omega_squared))


def bands(answer: Bands, ax: Axes | None) -> Axes:
    """Draws frequencies along a path through the zone."""
    ax = _axes(ax)
    frequencies = _signed(answer.omega_squared.real)
    ax.plot(answer.lengths, _signed(answer.continuum_omega_squared), color=CONTINUUM, linewidth=0.8)
    ax.plot(answer.lengths, frequencies, color=PARTICLES)
    for corner in answer.corners:
        ax.axvline(corner, color="black", linewidth=0.5)
    ax.axhline(0.0, color="black", linewidth=0.5)
    ax.set_xticks(answer.corners, answer.labels)
    ax.set_xlim(answer.lengths[0], answer.lengths[-1])
    largest = float(np.max(frequencies)) or 1.0
    ax.set_ylim(min(0.0, 1.1 * float(np.min(frequencies))), 1.1 * largest)
    ax.set_ylabel("ω (below zero: growth rate)")
    return ax


def path(table: str, answer: Answer, ax: Axes | None) -> Axes:
    """Draws the softest mode and the smallest acoustic eigenvalue along a path, each in its unit.

    The two diagrams replace `ax`, side by side; the first of them is returned.
    """
    ax = _axes(ax)
    told = answer.to_dict()
    lines = [line.split(",") for line in table.splitlines()]

    def column(name: str) -> Floats:
        place = lines[0].index(name)
        return np.array([float(line[place] or "nan") for line in lines[1:]])

    x = column("abscissa")
    figure, place = ax.figure, ax.get_subplotspec()
    if place is None:
        low, bottom, width, height = ax.get_position().bounds
        ax.set_position((low, bottom, 0.4 * width, height))
        right = figure.add_axes((low + 0.6 * width, bottom, 0.4 * width, height))
    else:
        halves = place.subgridspec(1, 2)
        ax.set_subplotspec(halves[0])
        right = figure.add_subplot(halves[1])
    stress = "Pa" if any("unit" in choice for choice in told["settings"].values()) else "stress"
    for axes, of, name, label, color in (
        (ax, "discretization", "minimum_scaled", "particles: min Re ω² / (c² |k|²) (−)", PARTICLES),
        (right, "material", "minimum_acoustic_eigenvalue", f"material: smallest acoustic eigenvalue ({stress})", "tab:red"),
    ):
        axes.plot(x, column(name), color=color)
        axes.axhline(0.0, color="black", linewidth=0.5)
        for change in told[f"{of}_crossings"]:
            axes.axvline(x[0] + (x[-1] - x[0]) * change["parameter"], color=CONTINUUM, linewidth=0.8, linestyle="--")
        axes.set_xlabel(told["abscissa"])
        axes.set_ylabel(label)
    return ax


def curves(answer: Boundary, ax: Axes | None) -> Axes:
    """Draws boundaries over the axes of a study."""
    ax = _axes(ax)
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


def checks(answer: Answer, ax: Axes | None) -> Axes:
    """Draws the errors of the checks of an audit."""
    ax = _axes(ax)
    told = answer.to_dict()["checks"]
    known = [check for check in told if check["error"] is not None]
    errors = [max(float(check["error"]), 1e-17) for check in known]
    colors = ["tab:red" if check["outcome"] == "failed" else PARTICLES for check in known]
    ax.barh([check["name"] for check in known], errors, color=colors)
    ax.set_xscale("log")
    ax.set_xlabel("relative error")
    return ax


def rates(answer: Answer, ax: Axes | None) -> Axes:
    """Draws growth rate and frequency: in continuous time, predicted in discrete time, and measured."""
    ax = _axes(ax)
    told = answer.to_dict()
    rates = {"continuous": told["continuous"], "predicted": told["predicted"]}
    if told["measured"] is not None:
        rates["measured"] = told["measured"]["rate"]
    for part, marker in (("growth", "^"), ("frequency", "o")):
        values = [np.nan if rate is None else rate[part] for rate in rates.values()]
        ax.plot(list(rates), values, marker, color=PARTICLES, fillstyle="none" if part == "growth" else "full", label=part)
    ax.set_ylabel("1/time")
    ax.legend()
    return ax


def amplitudes(answer: Answer, ax: Axes | None) -> Axes:
    """Draws the amplitudes of short waves over time, with the time of the first cause."""
    ax = _axes(ax)
    told = answer.to_dict()
    rows = told["moments"]
    time = [row["time"] for row in rows]
    lines = {"observed": ("observed, largest", "-"), "observed_mean": ("observed, mean", ":"), "predicted": ("predicted, waves", "--")}
    if told["time_step"] is not None:
        lines["predicted_by_step"] = ("predicted, time step", "-.")
    for name, (label, style) in lines.items():
        ax.semilogy(time, [row[name] for row in rows], style, label=label)
    ax.axhline(told["threshold"], color="gray", linewidth=0.8)
    if told["first"] is not None:
        ax.axvline(told["first"]["time"], color=PARTICLES, linewidth=0.8, label=f"first cause: {told['cause']}")
    ax.set_xlabel("time")
    ax.set_ylabel("amplitude / spacing")
    ax.legend()
    return ax


def shares(answer: Answer, ax: Axes | None) -> Axes:
    """Draws the number of states for each verdict."""
    verdicts = answer.to_dict()["verdicts"]
    return bars(list(verdicts), [share["states"] for share in verdicts.values()], "states", ax)


def bars(names: Sequence[str], values: Sequence[float], what: str, ax: Axes | None) -> Axes:
    """Draws a bar for each value."""
    ax = _axes(ax)
    ax.barh(list(names), list(values), color=PARTICLES)
    ax.set_xlabel(what)
    return ax


def scatter(answer: Dispersion, ax: Axes | None) -> Axes:
    """Draws values against the length of the wave vector."""
    ax = _axes(ax)
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
