"""Figures of the command, drawn by matplotlib from their descriptions: panels with two axes, and layers of arrays."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ._arrays import Floats
from ._errors import InputError, OnsetError

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import FigureBase

#: Points in a pixel, the unit of widths and diameters in a description.
POINTS = 0.75
MARKERS = {"circle": "o", "triangle": "^", "square": "s", "cross": "x"}
COLOR_MAPS = {"viridis": "viridis", "cividis": "cividis", "grey": "Greys", "red-blue": "RdBu"}


def draw(figure: Mapping[str, Any], ax: Axes | Sequence[Axes] | None = None, fig: FigureBase | None = None) -> Axes:
    """Draws a description into axes, or into a figure, or into a new figure; returns the axes of the first panel.

    Parameters
    ----------
    figure
        Description, as `Answer.figure` returns it.
    ax
        Axes, one for each panel. A single one is divided for several panels.
    fig
        Figure or subfigure in which the panels are laid out, instead of `ax`.
    """
    panels = figure["panels"]
    if ax is not None and fig is not None:
        raise InputError("a figure is drawn into `ax` or into `fig`, not into both")
    is_own = ax is None and fig is None
    placed = _laid_out(figure, fig) if ax is None else _given(ax, len(panels))
    for panel, own in zip(panels, placed, strict=True):
        _panel(panel, own)
    handles = [_handle(entry) for entry in figure["legend"]]
    if handles and len(placed) == 1 and not is_own:
        placed[0].legend(handles=handles)
    elif handles:
        columns = min(len(handles), 1 + len(placed))
        (fig or placed[0].figure).legend(handles=handles, loc="outside lower center", ncols=columns)
    if is_own and figure["title"]:
        placed[0].figure.suptitle(figure["title"])
    return placed[0]


def axes(ax: Axes | Sequence[Axes] | None, fig: FigureBase | None) -> Axes:
    """Returns the given axes, or axes in `fig`, by default in a new figure."""
    if ax is not None and fig is not None:
        raise InputError("a figure is drawn into `ax` or into `fig`, not into both")
    if ax is None:
        return _laid_out({"panels": [None], "columns": 1}, fig)[0]
    return _given(ax, 1)[0]


def _laid_out(figure: Mapping[str, Any], fig: FigureBase | None) -> list[Axes]:
    """Axes in a grid of a figure, by default of a new one."""
    panels = figure["panels"]
    columns = max(1, min(figure["columns"], len(panels)))
    rows = -(-len(panels) // columns)
    if fig is None:
        try:
            from matplotlib import pyplot
        except ImportError as error:
            raise OnsetError("figures require matplotlib\n  hint: pip install matplotlib") from error
        fig = pyplot.figure(figsize=(1.0 + 4.0 * columns, 1.0 + 3.4 * rows), layout="constrained")
    grid = fig.add_gridspec(rows, columns)
    return [fig.add_subplot(grid[divmod(number, columns)]) for number in range(len(panels))]


def _given(ax: Axes | Sequence[Axes], count: int) -> list[Axes]:
    """The axes of a caller, one for each panel; a single one is divided."""
    given: list[Axes] = list(np.ravel(np.asarray(ax, dtype=object)))
    if len(given) == count:
        return given
    if len(given) != 1:
        raise InputError(f"the figure has {count} panels, and {len(given)} axes are given\n  hint: give one axes for each panel, or `fig`")
    first = given[0]
    place = first.get_subplotspec()
    if place is None:
        raise InputError(f"the figure has {count} panels, and these axes cannot be divided\n  hint: give one axes for each panel, or `fig`")
    parts = place.subgridspec(1, count)
    first.set_subplotspec(parts[0])
    return [first, *(first.figure.add_subplot(parts[number]) for number in range(1, count))]


def _panel(panel: Mapping[str, Any], ax: Axes) -> None:
    for name in ("x", "y"):
        axis = panel[name]
        if axis["scale"] == "log10":
            ax.set(**{f"{name}scale": "log"})
        ax.set(**{f"{name}lim": axis["range"], f"{name}label": axis["label"]})
        if axis["ticks"] is not None:
            ax.set(**{f"{name}ticks": [at for at, _ in axis["ticks"]], f"{name}ticklabels": [word for _, word in axis["ticks"]]})
            ax.tick_params(axis=name, which="minor", length=0)
    if panel["title"]:
        ax.set_title(panel["title"])
    for layer in panel["layers"]:
        for kind, data in layer.items():
            LAYERS[kind](data, panel, ax)
    ax.set(xlim=panel["x"]["range"], ylim=panel["y"]["range"])
    if panel["equal_aspect"] and panel["x"]["scale"] == panel["y"]["scale"]:
        ax.set_aspect("equal")


def _pairs(points: Sequence[Any]) -> Floats:
    """Points as an array of shape (n, 2); missing numbers are NaN."""
    return np.array(points, dtype=np.float64).reshape(-1, 2)


def _edges(data: Mapping[str, Any], panel: Mapping[str, Any]) -> list[Floats]:
    """Edges of the cells of a map, even in the scale of each axis."""
    counts = {"x": data["columns"], "y": data["rows"]}

    def edges(name: str, count: int) -> Floats:
        low, high = data[name]
        if panel[name]["scale"] == "log10":
            return np.geomspace(low, high, count + 1, dtype=np.float64)
        return np.linspace(low, high, count + 1, dtype=np.float64)

    return [edges(name, count) for name, count in counts.items()]


def _regions(data: Mapping[str, Any], panel: Mapping[str, Any], ax: Axes) -> None:
    from matplotlib.colors import ListedColormap

    count = len(data["key"])
    shape = (data["rows"], data["columns"])
    classes = np.full(shape, count, dtype=np.int64)
    given = np.array(data["classes"][: classes.size], dtype=np.int64)
    classes.flat[: given.size] = given
    colors = ListedColormap([color for _, color in data["key"]])
    shown = np.ma.masked_greater_equal(classes, count)
    ax.pcolormesh(*_edges(data, panel), shown, cmap=colors, vmin=-0.5, vmax=count - 0.5, rasterized=True)


def _field(data: Mapping[str, Any], panel: Mapping[str, Any], ax: Axes) -> None:
    values = np.array(data["values"], dtype=np.float64).reshape(data["rows"], data["columns"])
    low, high = data["range"]
    shown = np.ma.masked_invalid(values)
    mesh = ax.pcolormesh(*_edges(data, panel), shown, cmap=COLOR_MAPS[data["map"]], vmin=low, vmax=high, rasterized=True)
    is_below, is_above = bool(np.any(shown < low)), bool(np.any(shown > high))
    extend = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}[is_below, is_above]
    ax.figure.colorbar(mesh, ax=ax, label=data["label"], extend=extend)


def _line(data: Mapping[str, Any], _: Mapping[str, Any], ax: Axes) -> None:
    points = _pairs(data["points"])
    ax.plot(points[:, 0], points[:, 1], color=data["color"], linestyle=data["dash"], linewidth=POINTS * data["width"])


def _points(data: Mapping[str, Any], _: Mapping[str, Any], ax: Axes) -> None:
    points = _pairs(data["points"])
    ax.plot(points[:, 0], points[:, 1], linestyle="none", markersize=POINTS * data["size"], **_marker(data))


def _marker(data: Mapping[str, Any]) -> dict[str, Any]:
    inside = data["color"] if data["filled"] else "white"
    return {"marker": MARKERS[data["marker"]], "color": data["color"], "markerfacecolor": inside}


def _arrows(data: Mapping[str, Any], _: Mapping[str, Any], ax: Axes) -> None:
    _quiver(_pairs(data["from"]), _pairs(data["to"]), data["color"], data["width"], ax)


def _quiver(tails: Floats, tips: Floats, color: Any, width: float, ax: Axes) -> None:
    """Arrows between points in the coordinates of the axes; the width is in pixels."""
    count = min(len(tails), len(tips))
    tails, along = tails[:count], tips[:count] - tails[:count]
    if count:
        ax.quiver(
            *tails.T, *along.T, color=color, angles="xy", scale_units="xy", scale=1.0, units="dots", width=width * ax.figure.dpi / 96.0, zorder=3
        )


def _balls(data: Mapping[str, Any], _: Mapping[str, Any], ax: Axes) -> None:
    from matplotlib.collections import PatchCollection
    from matplotlib.colors import to_rgb
    from matplotlib.patches import Circle

    def faded(color: str, fade: float) -> tuple[float, ...]:
        return tuple(part + 0.75 * fade * (1.0 - part) for part in to_rgb(color))

    balls = data["balls"]
    circles = [Circle(ball["at"], ball["radius"]) for ball in balls]
    colors = [faded(data["color"], ball["fade"]) for ball in balls]
    ax.add_collection(PatchCollection(circles, facecolors=colors, edgecolors="white", linewidths=0.5))
    moved = [ball for ball in balls if ball["tip"] is not None]
    colors = [faded(data["arrow_color"], ball["fade"]) for ball in moved]
    tails, tips = (_pairs([ball[name] for ball in moved]) for name in ("at", "tip"))
    _quiver(tails, tips, colors, data["arrow_width"], ax)


def _label(data: Mapping[str, Any], _: Mapping[str, Any], ax: Axes) -> None:
    from matplotlib.patheffects import withStroke

    rim = [withStroke(linewidth=2.0, foreground="white")]
    x, y = data["at"]
    ax.text(x, y, data["text"], color=data["color"], ha="center", va="center", clip_on=True, path_effects=rim)


def _rule(data: Mapping[str, Any], _: Mapping[str, Any], ax: Axes) -> None:
    across = ax.axvline if data["direction"] == "vertical" else ax.axhline
    across(data["at"], color=data["color"], linestyle=data["dash"], linewidth=POINTS)


LAYERS: dict[str, Callable[[Mapping[str, Any], Mapping[str, Any], Axes], None]] = {
    "regions": _regions,
    "field": _field,
    "line": _line,
    "points": _points,
    "arrows": _arrows,
    "balls": _balls,
    "label": _label,
    "rule": _rule,
}


def _handle(entry: Mapping[str, Any]) -> Artist:
    """Symbol of an entry of the legend."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    ((kind, symbol),) = entry["symbol"].items()
    name = entry["name"]
    if kind == "patch":
        return Patch(facecolor=symbol, edgecolor="0.5", linewidth=0.5, label=name)
    if kind == "line":
        return Line2D([], [], color=symbol["color"], linestyle=symbol["dash"], linewidth=POINTS * symbol["width"], label=name)
    if kind == "marker":
        return Line2D([], [], linestyle="none", label=name, **_marker(symbol))
    return Line2D([], [], color=symbol, marker=">", markevery=[-1], label=name)
