"""Figures of the command, drawn by matplotlib from their descriptions: panels with two axes, and layers of arrays."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, cast

import numpy as np

from ._arrays import Floats
from ._errors import InputError, OnsetError

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import FigureBase

#: Points in a pixel, the unit of widths and diameters in a description.
POINTS = 0.75
MARKERS = {"circle": "o", "triangle": "^", "square": "s", "cross": "x", "left": r"$\leftarrow$", "right": r"$\rightarrow$"}
COLOR_MAPS = {"viridis": "viridis", "cividis": "cividis", "grey": "Greys", "red-blue": "RdBu"}


def draw(figure: Mapping[str, Any], ax: Axes | Sequence[Axes] | None = None, fig: FigureBase | None = None) -> Axes:
    """Draws a description into axes, or into a figure, or into a new figure; returns the axes of the first panel.

    Parameters
    ----------
    figure
        Description, as `Answer.figure` returns it.
    ax
        Axes, one for each panel.
    fig
        Figure or subfigure in which the panels are laid out, instead of `ax`.
    """
    if ax is not None and fig is not None:
        raise InputError("a figure is drawn into `ax` or into `fig`, not into both")
    figure = _recolored(figure)
    panels = figure["panels"]
    is_own = ax is None and fig is None
    placed = _laid_out(figure, fig) if ax is None else _given(ax, len(panels))
    for panel, own in zip(panels, placed, strict=True):
        _panel(panel, own)
    legend = figure["legend"]
    if ax is not None or (len(placed) == 1 and not is_own):
        # In axes of the caller each panel has the entries of its layers.
        for panel, own in zip(panels, placed, strict=True):
            names = _names(panel) if len(panels) > 1 else {entry["name"] for entry in legend}
            handles = [_handle(entry) for entry in legend if entry["name"] in names]
            if handles:
                own.legend(handles=handles)
    elif legend:
        _legend_below(fig or placed[0].figure, [_handle(entry) for entry in legend], 1 + len(placed))
    if is_own and figure["title"]:
        placed[0].figure.suptitle(figure["title"], wrap=True)
    return placed[0]


def _names(panel: Mapping[str, Any]) -> set[str]:
    """Names of the layers of a panel, as in the legend."""
    names: set[str] = set()
    for layer in panel["layers"]:
        for data in layer.values():
            names.update(data[key] for key in ("name", "arrow_name") if data.get(key))
            names.update(name for name, _ in data.get("key", ()))
    return names


def _legend_below(fig: FigureBase, handles: list[Artist], most: int) -> None:
    """Puts a legend below the panels, in columns, with long names in several lines."""
    room = 0.98 * cast(Any, fig).bbox.width
    for columns in range(min(len(handles), most), 0, -1):
        legend = fig.legend(handles=handles, loc="outside lower center", ncols=columns)
        width = legend.get_window_extent().width
        if width <= room:
            return
        legend.remove()
    longest = max(len(str(handle.get_label())) for handle in handles)
    for letters in range(min(longest - 1, int(longest * room / width) + 3), 11, -3):
        for handle in handles:
            lines = textwrap.wrap(str(handle.get_label()).replace("\n", " "), letters, break_long_words=False)
            handle.set_label("\n".join(lines))
        legend = fig.legend(handles=handles, loc="outside lower center", ncols=1)
        if legend.get_window_extent().width <= room:
            return
        legend.remove()
    fig.legend(handles=handles, loc="outside lower center", ncols=1)


def _is_set(name: Literal["axes.prop_cycle", "figure.figsize"]) -> bool:
    """Whether a parameter of matplotlib was changed by the user or by a style."""
    from matplotlib import rcParams, rcParamsDefault

    return bool(rcParams[name] != rcParamsDefault[name])


def _recolored(figure: Mapping[str, Any]) -> Mapping[str, Any]:
    """Description whose curves and markers have the colors of ``axes.prop_cycle``, if it was set. Greys and the colors of maps remain."""
    if not _is_set("axes.prop_cycle"):
        return figure
    from matplotlib import rcParams
    from matplotlib.colors import to_rgb

    cycle = rcParams["axes.prop_cycle"].by_key().get("color", [])
    colors: dict[str, Any] = {}

    def own(color: str) -> Any:
        rgb = to_rgb(color)
        if not cycle or max(rgb) - min(rgb) < 0.06:
            return color
        return colors.setdefault(color, cycle[len(colors) % len(cycle)])

    def layer(kind: str, data: Mapping[str, Any]) -> Mapping[str, Any]:
        return {**data, "color": own(data["color"])} if kind in ("line", "points", "arrows", "rule") else data

    def symbol(kind: str, data: Any) -> Any:
        if kind == "arrow":
            return own(data)
        return {**data, "color": own(data["color"])} if kind in ("line", "marker") else data

    panels = [
        {**panel, "layers": [{kind: layer(kind, data) for kind, data in one.items()} for one in panel["layers"]]} for panel in figure["panels"]
    ]
    legend = [{**entry, "symbol": {kind: symbol(kind, data) for kind, data in entry["symbol"].items()}} for entry in figure["legend"]]
    return {**figure, "panels": panels, "legend": legend}


def _width(pixels: float) -> float:
    """Width of a line in points, relative to ``lines.linewidth`` of the user."""
    from matplotlib import rcParams

    return float(POINTS * pixels * rcParams["lines.linewidth"] / 1.5)


def _diameter(pixels: float) -> float:
    """Diameter of a marker in points, relative to ``lines.markersize`` of the user."""
    from matplotlib import rcParams

    return float(POINTS * pixels * rcParams["lines.markersize"] / 6.0)


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
    # Rows have equal numbers of panels, if possible.
    columns = -(-len(panels) // rows)
    if fig is None:
        try:
            from matplotlib import pyplot
        except ImportError as error:
            raise OnsetError("figures require matplotlib\n  hint: pip install matplotlib") from error
        lines = [panel["lines"] or 0.0 for panel in panels if panel is not None]
        height = max([3.4, *(0.18 * count for count in lines)])
        size = None if _is_set("figure.figsize") else (1.0 + 4.0 * columns, 1.0 + height * rows)
        fig = pyplot.figure(figsize=size, layout="constrained")
    widths = [1.0 if panel is None or panel["equal_aspect"] else panel["width"] for panel in panels[:columns]]
    grid = fig.add_gridspec(rows, columns, width_ratios=widths)
    placed = [fig.add_subplot(grid[divmod(number, columns)]) for number in range(len(panels))]
    for number, panel in enumerate(panels):
        # Neighbors with the same vertical axis have its words once.
        if number % columns and panel["y"] == panels[number - 1]["y"]:
            placed[number].tick_params(labelleft=False)
            placed[number].yaxis.label.set_visible(False)
    return placed


def _given(ax: Axes | Sequence[Axes], count: int) -> list[Axes]:
    """The axes of a caller, one for each panel."""
    given: list[Axes] = list(np.ravel(np.asarray(ax, dtype=object)))
    if len(given) == count:
        return given
    several = f", for example `figure, axes = plt.subplots(1, {count})` and `plot(axes)`" if count > 1 else ""
    raise InputError(
        f"the figure has {count} panel{'s' * (count != 1)}, and {len(given)} axes {'is' if len(given) == 1 else 'are'} given\n"
        f"  hint: give one axes for each panel{several}, or a figure or subfigure: `plot(fig=figure)`"
    )


def _panel(panel: Mapping[str, Any], ax: Axes) -> None:
    for name in ("x", "y"):
        axis = panel[name]
        if axis["scale"] == "log10":
            _log_scale(ax, name, axis["range"])
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


def _log_scale(ax: Axes, name: str, ends: Sequence[float]) -> None:
    """Logarithmic scale with few numbers, which do not overlap."""
    from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

    ax.set(**{f"{name}scale": "log"})
    axis = ax.xaxis if name == "x" else ax.yaxis
    decades = abs(np.log10(ends[1] / ends[0]))
    if decades >= 2.0:
        axis.set_major_locator(LogLocator(numticks=5))
    else:
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if decades < 1.0 else (1.0, 3.0), numticks=9))
        axis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axis.set_minor_formatter(NullFormatter())


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
    ax.plot(points[:, 0], points[:, 1], color=data["color"], linestyle=data["dash"], linewidth=_width(data["width"]))


def _points(data: Mapping[str, Any], _: Mapping[str, Any], ax: Axes) -> None:
    points = _pairs(data["points"])
    if data["extent"] is not None:
        from matplotlib.collections import EllipseCollection

        size = [data["extent"]]
        marks = EllipseCollection(size, size, [0.0], units="x", offsets=points, offset_transform=ax.transData)
        marks.set(facecolor=data["color"], edgecolor="none")
        ax.add_collection(marks)
        return
    ax.plot(points[:, 0], points[:, 1], linestyle="none", **_marker(data, data["size"]))


def _marker(data: Mapping[str, Any], size: float) -> dict[str, Any]:
    """Style of a marker, whose size is in pixels. Arrows are wider than the other markers."""
    name = data["marker"]
    inside = data["color"] if data["filled"] else "white"
    wider = 2.0 if name in ("left", "right") else 1.0
    return {"marker": MARKERS[name], "markersize": wider * _diameter(size), "color": data["color"], "markerfacecolor": inside}


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
    across(data["at"], color=data["color"], linestyle=data["dash"], linewidth=_width(1.0))


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
        return Line2D([], [], color=symbol["color"], linestyle=symbol["dash"], linewidth=_width(symbol["width"]), label=name)
    if kind == "marker":
        return Line2D([], [], linestyle="none", label=name, **_marker(symbol, 8.0))
    return Line2D([], [], color=symbol, marker=">", markevery=[-1], label=name)
