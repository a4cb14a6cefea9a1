// Drawings of results. All numbers are computed by the program.

import * as Plot from "@observablehq/plot";
import type { Catalog, Curves, Directions, Dispersion, Heights, ShownMap } from "./ask";
import { color } from "./dom";

type Drawn = SVGSVGElement | HTMLElement;

/** Drawing with a single accessible name in place of the names of its parts. */
export function named(picture: Drawn, name: string): Drawn {
  for (const part of picture.querySelectorAll("[aria-label]")) part.removeAttribute("aria-label");
  picture.setAttribute("role", "img");
  picture.setAttribute("aria-label", name);
  return picture;
}

/** Cells of maps as images with one pixel each, painted once and reused while the state moves. */
const painted = new WeakMap<ShownMap, string>();

function cells(shown: ShownMap, classes: Catalog["classes"]): string {
  const known = painted.get(shown);
  if (known) return known;
  const [columns, rows] = shown.axes.map((axis) => axis.states) as [number, number];
  const canvas = document.createElement("canvas");
  canvas.width = columns;
  canvas.height = rows;
  // Kept in main memory: reading back from a graphics card would wait for all pending drawing.
  const context = canvas.getContext("2d", { willReadFrequently: true })!;
  shown.classes.forEach((n, place) => {
    if (n === null) return;
    context.fillStyle = classes[n]!.color;
    context.fillRect(place % columns, rows - 1 - Math.floor(place / columns), 1, 1);
  });
  const image = canvas.toDataURL();
  painted.set(shown, image);
  return image;
}

/** Map with its known boundaries and the state. */
export function map(shown: ShownMap, curves: Curves | null, classes: Catalog["classes"], at: [number, number], width: number): Drawn {
  const [first, second] = shown.axes as [ShownMap["axes"][0], ShownMap["axes"][0]];
  const isPlane = [first, second].every((axis) => axis.name.startsWith("stretch"));
  const shape = isPlane ? (second.range[1] - second.range[0]) / (first.range[1] - first.range[0]) : 0.8;
  const margins = { marginLeft: 60, marginRight: 12, marginTop: 10, marginBottom: 42 };
  const inner = width - margins.marginLeft - margins.marginRight;
  const tall = Math.max(110, Math.min(inner * shape, 1.3 * inner));
  const lines = lined(curves);
  const of = (owner: string) => lines.filter((line) => line.of === owner).flatMap((line) => [...line.points, [NaN, NaN]]);
  return Plot.plot({
    width,
    height: tall + margins.marginTop + margins.marginBottom,
    ...margins,
    style: { background: "transparent", fontSize: "13px", overflow: "visible" },
    x: { domain: first.range, label: first.label, labelAnchor: "center", labelArrow: "none", ticks: 6 },
    y: { domain: second.range, label: second.label, labelAnchor: "center", labelArrow: "none", labelOffset: 52, ticks: 6 },
    marks: [
      Plot.image([[(first.range[0] + first.range[1]) / 2, (second.range[0] + second.range[1]) / 2]], {
        x: "0",
        y: "1",
        src: () => cells(shown, classes),
        width: inner,
        height: tall,
        preserveAspectRatio: "none",
        imageRendering: "pixelated",
      }),
      Plot.line(of("material"), { x: "0", y: "1", stroke: "#000", strokeWidth: 5 }),
      Plot.line(of("discretization"), { x: "0", y: "1", stroke: "#fff", strokeWidth: 3.4 }),
      Plot.line(of("discretization"), { x: "0", y: "1", stroke: "#d55e00", strokeWidth: 2 }),
      Plot.frame(),
      Plot.dot([at], { x: "0", y: "1", r: 7, stroke: "#fff", strokeWidth: 5, clip: true }),
      Plot.dot([at], { x: "0", y: "1", r: 7, stroke: "#000", strokeWidth: 2, clip: true }),
    ],
  });
}

function lined(curves: Curves | null): { of: string; points: [number, number][] }[] {
  return (curves?.features ?? []).map(({ properties, geometry }) => ({
    of: properties.of,
    points: geometry.type === "Polygon" ? geometry.coordinates[0]! : geometry.coordinates,
  }));
}

/** Height of a row of labels, in pixels. */
const ROW = 14;

/** Rows of the labels below an axis: each label goes to the first row in which it overlaps no other. `scale` is in pixels. */
export function staggered(ticks: [number, string][], scale: number): { at: number; name: string; row: number }[] {
  const ends: number[] = [];
  return ticks
    .sort(([a], [b]) => a - b)
    .map(([at, name]) => {
      const half = 4.2 * name.length + 3;
      const free = ends.findIndex((end) => end <= at * scale - half);
      const row = free < 0 ? ends.length : free;
      ends[row] = at * scale + half;
      return { at, name, row };
    });
}

/** Dispersion diagram: frequencies as positive values, growth rates as negative ones; the largest growth rate of oscillating waves as a separate curve. */
export function dispersion(answer: Dispersion, width: number): Drawn {
  const [branches, own] = [answer.heights[0]?.particles.length ?? 0, answer.heights[0]?.continuum.length ?? 0];
  const curve = (value: (heights: Heights) => number) =>
    answer.heights.flatMap((heights, n) => {
      const at: [number, number] = [answer.lengths[n]!, value(heights)];
      // A jump of the path interrupts the curve.
      return n > 0 && answer.lengths[n - 1] === answer.lengths[n] ? [[NaN, NaN], at] : [at];
    });
  const particles = Array.from({ length: branches }, (_, n) => curve((heights) => heights.particles[n]!));
  const continuum = Array.from({ length: own }, (_, n) => curve((heights) => heights.continuum[n]!));
  const fluttering = curve((heights) => heights.flutter ?? NaN);
  const critical = answer.critical;
  const mark = critical.length === null ? [] : [[critical.length, critical.height]];
  const heights = [...particles, fluttering, mark].flat().map(([, y]) => y!).filter(Number.isFinite);
  const [low, high] = [Math.min(0, ...heights), Math.max(0, ...heights)];
  const margin = 0.08 * (high - low || 1);
  // Stable states may have slightly negative values by rounding.
  const isGrowing = low < 0 && !critical.stable;
  const ticks = new Map<number, string>();
  for (const { name, length } of answer.corners) ticks.set(length, ticks.has(length) ? `${ticks.get(length)}|${name}` : name);
  const end = answer.lengths.at(-1) ?? 1;
  const margins = { marginLeft: 52, marginRight: 20, marginTop: 24 };
  const labels = staggered([...ticks], (width - margins.marginLeft - margins.marginRight) / end);
  const rows = Math.max(0, ...labels.map(({ row }) => row));
  return Plot.plot({
    width,
    height: 260 + ROW * rows,
    ...margins,
    marginBottom: 30 + ROW * rows,
    style: { background: "transparent", fontSize: "13px" },
    x: { domain: [0, end], axis: null },
    y: { domain: [isGrowing ? low - margin : 0, high + margin], label: isGrowing ? "frequency; below 0: −(growth rate)" : "frequency" },
    marks: [
      Plot.axisX([...ticks.keys()], { tickFormat: () => "", label: null }),
      ...labels.map(({ at, name, row }) => Plot.text([[at, name]], { x: "0", text: "1", frameAnchor: "bottom", dy: 18 + ROW * row, fill: color("text"), clip: false })),
      Plot.ruleX(ticks.keys(), { stroke: color("line"), strokeDasharray: "2,3" }),
      Plot.ruleY([0], { stroke: color("text") }),
      ...continuum.map((points) => Plot.line(points, { x: "0", y: "1", stroke: color("quiet"), strokeDasharray: "6,4", clip: true })),
      ...particles.map((points) => Plot.line(points, { x: "0", y: "1", stroke: color("blue"), strokeWidth: 1.8 })),
      Plot.line(fluttering, { x: "0", y: "1", stroke: color("vermilion"), strokeWidth: 1.8 }),
      Plot.dot(mark, { x: "0", y: "1", r: 6, fill: color("vermilion"), stroke: color("ground") }),
    ],
  });
}

/** Eigenvalues of the acoustic tensor over the directions in the plane; negative eigenvalues are dashed. */
export function polar(answer: Directions, width: number): Drawn {
  const count = answer.normals.length;
  const size = Math.max(...answer.eigenvalues.flat().map(Math.abs)) || 1;
  const branches = answer.eigenvalues[0]?.length ?? 0;
  const around = (branch: number, sign: number) =>
    Array.from({ length: 2 * count + 1 }, (_, n) => {
      const side = n % (2 * count) < count ? 1 : -1;
      const value = answer.eigenvalues[n % count]![branch]!;
      if (value * sign < 0) return [NaN, NaN];
      const [x, y] = answer.normals[n % count]!;
      return [(side * x! * Math.abs(value)) / size, (side * y! * Math.abs(value)) / size];
    });
  const strokes = [color("vermilion"), color("blue")];
  const lines = Array.from({ length: branches }, (_, n) => [
    Plot.line(around(n, 1), { x: "0", y: "1", stroke: strokes[n % 2]!, strokeWidth: 2 }),
    Plot.line(around(n, -1), { x: "0", y: "1", stroke: strokes[n % 2]!, strokeWidth: 2, strokeDasharray: "3,3" }),
  ]);
  const circle = Array.from({ length: 91 }, (_, n) => [Math.cos((n * Math.PI) / 45), Math.sin((n * Math.PI) / 45)]);
  const side = Math.min(width, 300);
  return Plot.plot({
    width: side,
    height: side,
    margin: 18,
    style: { background: "transparent", fontSize: "13px" },
    x: { domain: [-1, 1], axis: null },
    y: { domain: [-1, 1], axis: null },
    marks: [
      Plot.line(circle, { x: "0", y: "1", stroke: color("line") }),
      Plot.ruleX([0], { stroke: color("line") }),
      Plot.ruleY([0], { stroke: color("line") }),
      Plot.text([[1, 0, "N₁"], [0, 1, "N₂"]], { x: "0", y: "1", text: "2", fill: color("text"), dy: -8 }),
      ...lines.flat(),
    ],
  });
}
