// The page: the question on the left, the map of its window in the middle, the results for the state on the right.

import { read, written, WINDOW } from "./address";
import { ask, giveUp, isAsking, isGivenUp, Refusal } from "./ask";
import type { Catalog, Curves, Directions, Dispersion, Form, Mode, Question, ShownMap, State, Stored, ZooEntry } from "./ask";
import { element, lazily, table, the, told, vector } from "./dom";
import { build } from "./form";
import { moving, type Moving } from "./moving";
import * as pictures from "./pictures";
import { enter } from "./token";

/** Question of an address without one: the foam rubber and the state of the README, whose map has physical and numerical parts. */
const FIRST: Question = {
  set: ["material.model=blatz-ko", "discretization.method=material-points", "discretization.grid-functions=quadratic-spline"],
  stretch: "2,1",
  window: { axes: ["stretch-1", "stretch-2"], ranges: [[0.3, 3.5], [0.3, 2.5]] },
};
/** Instructions below the map. */
const HELP = "Click a state, or move with the arrow keys.";
const TRACING = "tracing boundaries…";
/** Initial formula of a user-defined energy. */
const ENERGY = "mu/2*(I1 - 3 - 2*ln(J)) + lambda/2*ln(J)^2";

let catalog: Catalog;
let question: Question = structuredClone(FIRST);
let form: Form | null = null;
let shown: ShownMap | null = null;
let curves: Curves | null = null;
let stored: Stored | null = null;
let waves: Dispersion | null = null;
let polar: Directions | null = null;
let drawn: Moving | null = null;
let globe: { stop(): void } | null = null;
/** Key of an assignment. */
const key = (assignment: string): string => assignment.split("=")[0]!.trim();
const numbers = (text: string): number[] => text.split(",").map(Number);

// --- the state on the axes of the window

/** Coordinate of the state along an axis. */
function coordinate(axis: string): number {
  const stretch = /^stretch-([123])$/.exec(axis);
  if (stretch) return numbers(question.stretch)[Number(stretch[1]) - 1] ?? 1;
  const value = form?.fields.find((field) => field.name === axis)?.value;
  return typeof value === "number" ? value : NaN;
}

const place = (): [number, number] => [coordinate(question.window.axes[0]), coordinate(question.window.axes[1])];

/** Rounds a coordinate to four digits beyond the size of the window, so that the state after a click has readable numbers. */
function rounded(value: number, [low, high]: [number, number]): number {
  const digits = Math.max(0, 4 - Math.floor(Math.log10(high - low)));
  return Number(value.toFixed(Math.min(digits, 12)));
}

/** Moves the state to a point of the map. */
function move(at: [number, number], isPushed: boolean): void {
  const next = structuredClone(question);
  next.window.axes.forEach((axis, n) => {
    const value = rounded(at[n]!, question.window.ranges[n as 0 | 1]);
    const stretch = /^stretch-([123])$/.exec(axis);
    if (stretch) {
      const all = numbers(next.stretch);
      while (all.length < Number(stretch[1])) all.push(1);
      all[Number(stretch[1]) - 1] = value;
      next.stretch = all.join(",");
    } else {
      next.set = assigned(next.set, axis, String(value));
    }
  });
  const isOfState = next.window.axes.every((axis) => axis.startsWith("stretch"));
  show(next, isPushed ? "push" : "replace", isOfState ? "state" : "form");
}

const assigned = (set: string[], name: string, value: string): string[] => [...set.filter((own) => key(own) !== name), `${name}=${value}`];

// --- requests

type Extent = "state" | "values" | "form";

/** Shows a question; its address is added to the history or replaces the last entry. */
function show(next: Question, address: "push" | "replace" | "keep", extent: Extent): void {
  const isOther = extent !== "state";
  question = next;
  if (isOther && stored) {
    stored = null;
    the("map-note").hidden = true;
  }
  if (address !== "keep") {
    const hash = stored ? "#map=stored" : written(question);
    if (address === "push" && hash !== location.hash) history.pushState(null, "", hash);
    else history.replaceState(null, "", hash);
  }
  if (extent === "form") void anew();
  else {
    const answered = askState();
    if (isOther) void askMap(answered);
    else {
      drawMap();
      void answered.then(askWaves);
    }
  }
}

/** Requests the form of the question, and then all results. */
async function anew(): Promise<void> {
  try {
    form = await ask<Form>("form", { set: question.set });
    if (form.missing.length > 0) {
      question.set = [...form.set, ...form.missing.map((name) => `material.${name}=1`)];
      form = await ask<Form>("form", { set: question.set });
    }
  } catch (error) {
    failed(error);
    return;
  }
  question.set = form.set;
  fit(form);
  if (!stored) history.replaceState(null, "", written(question));
  build(the("form"), form, catalog, changed);
  stateForm();
  windowForm();
  const answered = askState();
  void (stored ? answered.then(askWaves) : askMap(answered));
}

/** Second axis of a chain's map, next to its stretch: the interaction range. */
const LENGTHS = ["discretization.support", "discretization.horizon"];
/** Window of the interaction range, from slightly more than the nearest neighbor; particle spacings. */
const SEEN: [number, number] = [1.2, 4];

/** Adapts the stretches to the number of dimensions, and the window to the keys in the form. */
function fit({ dimension, fields }: Form): void {
  const given = question.stretch === "" ? [] : numbers(question.stretch);
  const stretches = given.slice(0, 3);
  while (stretches.length < dimension) stretches.push(1);
  while (stretches.length > dimension && stretches.at(-1) === 1) stretches.pop();
  question.stretch = stretches.join(",");
  const { axes, ranges } = question.window;
  const isRead = (axis: string) => (axis.startsWith("stretch-") ? Number(axis.at(-1)) <= Math.max(dimension, 1) : fields.some((own) => own.name === axis));
  axes.forEach((axis, n) => {
    if (isRead(axis) && axes[1 - n] !== axis) return;
    const free = (["stretch-1", "stretch-2"] as const).slice(0, dimension).find((own) => axes[1 - n] !== own);
    const other = LENGTHS.map((name) => fields.find((own) => own.name === name && own.slider)).find((own) => own);
    const found = free ?? other?.name ?? "discretization.spacing";
    axes[n as 0 | 1] = found;
    ranges[n as 0 | 1] = free ? [...WINDOW.ranges[0]] : other ? [...SEEN] : [0.5, 2];
  });
}

/** Applies a changed key. */
function changed(name: string, value: string, isDone: boolean): void {
  const next = structuredClone(question);
  next.set = assigned(next.set, name, value);
  if (name === "material.model" && value === "formula" && !next.set.some((own) => key(own) === "material.energy")) {
    next.set = assigned(next.set, "material.energy", ENERGY);
  }
  show(next, isDone ? "push" : "replace", isDone ? "form" : "values");
}

const asked = () => ({ set: question.set, stretch: question.stretch });

/** Requests a result for the state and draws it; the previous picture stays until then. */
const picture = <T>(name: string, draw: (answer: T) => void): Promise<void> =>
  ask<T>(name, asked()).then(
    (answer) => {
      performance.mark(`answer:${name}`);
      draw(answer);
      performance.mark(`drawn:${name}`);
    },
    (error: unknown) => {
      if (!isGivenUp(error) && name !== "state" && error instanceof Refusal) return;
      failed(error);
    },
  );

/** Number of the current request for a state. */
let state = 0;

/** Requests the results for the state and resolves with the number of the request. Pending requests for the previous state are cancelled. */
async function askState(): Promise<number> {
  const own = ++state;
  for (const name of ["directions", "dispersion"]) giveUp(name);
  stateForm();
  await Promise.all([picture<State>("state", showState), picture<Mode>("mode", showMode)]);
  return own;
}

/** Requests dispersion and directions of the state, after the faster results. */
function askWaves(own: number): void {
  if (own !== state) return;
  void picture<Directions>("directions", showDirections);
  void picture<Dispersion>("dispersion", showDispersion);
}

/** Number of the current request for a map; earlier requests are cancelled. */
let turn = 0;

/** Requests the map: first coarse, together with the state, then finer after the state is complete, and finally its boundaries. */
async function askMap(answered: Promise<number>): Promise<void> {
  giveUp("boundary");
  giveUp("map");
  const own = ++turn;
  the("plane").setAttribute("aria-busy", "true");
  let isBegun = false;
  try {
    for (let level = 0; ; level++) {
      const map = await ask<ShownMap>("map", { ...asked(), window: question.window, level });
      shown = map;
      curves = null;
      the("map-help").textContent = HELP;
      drawMap();
      performance.mark("drawn:map");
      if (level === 0) {
        isBegun = true;
        askWaves(await answered);
        if (own !== turn) return;
      }
      if (map.is_finest) break;
    }
    the("plane").removeAttribute("aria-busy");
    the("map-state").textContent = TRACING;
    curves = await ask<Curves>("boundary", { ...asked(), window: question.window });
    drawMap();
    the("map").dataset["curves"] = String(curves.features.length);
    performance.mark("drawn:boundary");
  } catch (error) {
    if (isGivenUp(error)) return;
    the("plane").removeAttribute("aria-busy");
    // A state can have waves even if its window has no map.
    if (!isBegun) void answered.then(askWaves);
    // Errors of the state are shown next to it; errors of the window alone are shown here.
    const isDrawn = shown?.is_finest === true && error instanceof Refusal;
    the("map-state").textContent = isDrawn ? "" : error instanceof Refusal ? error.message : String(error);
    the("map-help").textContent = isDrawn ? "Click a state, or move with the arrow keys. The boundaries were not traced: it would take too long." : HELP;
    performance.mark("drawn:boundary");
  }
}

/** Shows an error; the last pictures stay. */
function failed(error: unknown): void {
  if (isGivenUp(error)) return;
  const place = the("error");
  place.textContent = error instanceof Refusal ? error.message : "the program does not answer: is `onset explore` still running?";
  place.hidden = false;
  the("answer").classList.add("stale");
}

// --- the map

function drawMap(): void {
  const holder = the("map");
  if (!shown) return;
  const at = place();
  const drawing = pictures.map(shown, curves, catalog.classes, at, Math.max(holder.clientWidth, 260));
  drawing.setAttribute("aria-hidden", "true");
  holder.replaceChildren(drawing);
  const [first, second] = shown.axes;
  holder.setAttribute("aria-label", `Map of ${first!.name} and ${second!.name}; the state is at ${told(at[0])}, ${told(at[1])}`);
  const counts = new Map<number, number>();
  for (const n of shown.classes) if (n !== null) counts.set(n, (counts.get(n) ?? 0) + 1);
  const all = shown.classes.length;
  const rows = [...counts].sort((a, b) => b[1] - a[1]).map(([n, count]) => ({ ...catalog.classes[n]!, share: (100 * count) / all }));
  the("legend").replaceChildren(
    ...rows.map(({ title, color }) => {
      const swatch = element("span", { class: "swatch" });
      swatch.style.background = color;
      return element("li", {}, swatch, title);
    }),
    // Only boundaries that the window has.
    ...(["material", "discretization"] as const)
      .filter((owner) => curves?.features.some((curve) => curve.properties.of === owner))
      .map((owner) => element("li", {}, element("span", { class: `curve ${owner}` }), `boundary of the ${owner}`)),
  );
  the("map-state").textContent = !shown.is_finest ? "finer…" : curves === null && isAsking("boundary") ? TRACING : "";
  lazily(the("map-table"), () =>
    table("Shares of the window", ["verdict", "share"], rows.map(({ title, share }) => [title, `${share.toFixed(1)} %`])),
  );
}

function clicked(event: MouseEvent): void {
  const drawing = the("map").querySelector<SVGSVGElement>("svg");
  if (!drawing || !shown) return;
  const box = drawing.getBoundingClientRect();
  const scale = (axis: "x" | "y") => (drawing as unknown as { scale(name: string): { invert(x: number): number; domain: [number, number] } }).scale(axis);
  const width = Number(drawing.getAttribute("width")) / box.width;
  const x = scale("x").invert((event.clientX - box.left) * width);
  const y = scale("y").invert((event.clientY - box.top) * width);
  const inside = (value: number, [low, high]: [number, number]) => value >= low && value <= high;
  if (inside(x, shown.axes[0]!.range) && inside(y, shown.axes[1]!.range)) move([x, y], true);
}

function stepped(event: KeyboardEvent): void {
  const [dx, dy] = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] }[event.key] ?? [0, 0];
  if (dx === 0 && dy === 0) return;
  event.preventDefault();
  const { ranges } = question.window;
  const step = (n: 0 | 1) => (ranges[n][1] - ranges[n][0]) / (event.shiftKey ? 400 : 50);
  const [x, y] = place();
  const within = (value: number, n: 0 | 1) => Math.min(Math.max(value, ranges[n][0]), ranges[n][1]);
  move([within(x + dx! * step(0), 0), within(y + dy! * step(1), 1)], false);
}

// --- the state

/** Verdict for three-dimensional perturbations; for a sheet or a bar, the computed transverse stretches instead. */
function across(answer: State): [string, string][] {
  const space = answer.material_3d;
  if (space) return [["in 3D", `${told(space.minimum_acoustic_eigenvalue)} along ${vector(space.direction)}`]];
  const f = answer.deformation_gradient;
  const [second, third] = [told(f[1]![1]!), told(f[2]![2]!)];
  if (answer.discretization.wave_vector.length === 1) return [["lateral stretches", `${second}, ${third}`]];
  return [["thickness stretch", third]];
}

/** Answers to the question whether a law is strongly elliptic, in the words of the command. */
const IS_ELLIPTIC = { elliptic: "yes", lost: "no", undecided: "undecided" } as const;

function showState(answer: State): void {
  the("error").hidden = true;
  the("answer").classList.remove("stale");
  const { material, discretization: own } = answer;
  const sentence = the("sentence");
  sentence.textContent = answer.sentence;
  sentence.dataset["verdict"] = answer.verdict;
  sentence.dataset["state"] = question.stretch;
  the("notes").replaceChildren(...answer.notes.map((note) => element("p", { class: "note" }, note)));
  const damped = Object.entries(own.damped_time_steps ?? {}).map(([name, step]): [string, string] => [`time step, ${name}`, told(step)]);
  const bound = own.finite_bodies;
  const finite: [string, string][] = bound
    ? [["finite bodies", `stable below ${told(bound.time_step)} (${bound.proved ? "proved" : "computed"}; ${bound.ground})`]]
    : [];
  const rows: [string, string][] = [
    ["verdict", answer.mechanism ? `${answer.verdict} (${answer.mechanism})` : answer.verdict],
    ["evidence", answer.evidence],
    ["Cauchy stress", [[0, 0], [1, 1], [0, 1], [2, 2]].map(([i, j]) => `s${i! + 1}${j! + 1} ${told(material.cauchy[i!]![j!])}`).join(", ")],
    ["strongly elliptic", IS_ELLIPTIC[material.ellipticity]],
    ["smallest eigenvalue", `${told(material.minimum_acoustic_eigenvalue)} along ${vector(material.direction)}`],
    ...across(answer),
    [own.stable ? "softest mode" : "critical mode", own.mode],
    ["wave vector", `${vector(own.wave_vector)} (reference), ${vector(own.spatial_wave_vector)} (deformed)`],
    ["polarization", vector(own.polarization)],
    ["smallest ω²", told(own.minimum_omega_squared.re)],
    ["growth rate", told(own.growth_rate)],
    ["largest frequency", told(own.maximum_omega)],
    ["critical time step", `${told(own.critical_time_step)} (${own.critical_time_step_of})`],
    ...finite,
    ...damped,
  ];
  const body = the("numbers").querySelector("tbody")!;
  body.replaceChildren(...rows.map(([name, value]) => element("tr", {}, element("th", { scope: "row" }, name), element("td", {}, value))));
}

function showMode(mode: Mode): void {
  drawn?.stop();
  const holder = the("mode");
  const amplitude = Number(the<HTMLInputElement>("amplitude").value);
  const isPaused = the("pause").getAttribute("aria-pressed") === "true";
  const isSpace = mode.wave_vector.length === 3;
  if (isSpace) {
    drawn = null;
    void import("./space.js").then(({ lattice }) => {
      drawn = lattice(holder, mode, amplitude, isPaused);
    });
  } else {
    let canvas = holder.querySelector<HTMLCanvasElement>("canvas.flat");
    if (!canvas) {
      canvas = element("canvas", { class: "flat", role: "img" });
      holder.replaceChildren(canvas);
    }
    const what = mode.is_long_wave ? "the limit of long waves" : `wave vector ${vector(mode.wave_vector)}`;
    canvas.setAttribute("aria-label", `${mode.particles.length} particles in the ${mode.stable ? "softest" : "critical"} mode, ${what}`);
    drawn = moving(canvas, mode, amplitude, isPaused);
  }
  lazily(the("mode-table"), () =>
    table(
      mode.is_long_wave ? "Particles in the mode: the limit of long waves, with a wavelength as long as the patch" : "Particles in the mode",
      ["place", "displacement, real part", "imaginary part"],
      mode.particles.map((own) => [vector(own.place), vector(own.re), vector(own.im)]),
    ),
  );
}

function showDispersion(answer: Dispersion): void {
  waves = answer;
  const label = `Dispersion along ${answer.corners.map((corner) => corner.name).join(" ")}`;
  const picture = pictures.named(pictures.dispersion(answer, Math.max(the("dispersion").clientWidth, 260)), label);
  the("dispersion").replaceChildren(picture);
  lazily(the("dispersion-table"), () => {
    const rows = answer.heights.map((own, n): (string | number)[] => [told(answer.lengths[n]), own.particles.map(told).join(", "), own.continuum.map(told).join(", ")]);
    return table("Frequencies along the path; below zero minus the growth rate", ["length", "particles", "continuum"], rows.filter((_, n) => n % 10 === 0));
  });
}

function showDirections(answer: Directions): void {
  polar = answer;
  globe?.stop();
  globe = null;
  const holder = the("directions");
  const least = answer.eigenvalues.reduce((best, own, n) => (own[0]! < answer.eigenvalues[best]![0]! ? n : best), 0);
  const label = `Eigenvalues of the acoustic tensor; the smallest is ${told(answer.eigenvalues[least]![0])} along ${vector(answer.normals[least]!)}`;
  const dimension = answer.normals[0]!.length;
  if (dimension === 3) {
    void import("./space.js").then(({ sphere }) => {
      if (polar === answer) globe = sphere(holder, answer);
    });
  } else if (dimension === 2) {
    const picture = pictures.named(pictures.polar(answer, Math.max(holder.clientWidth, 200)), label);
    holder.replaceChildren(picture);
  } else {
    holder.replaceChildren(element("p", {}, label));
  }
  const every = dimension === 3 ? 24 : 10;
  lazily(the("directions-table"), () =>
    table(
      label,
      ["direction N", "eigenvalues"],
      answer.normals.flatMap((normal, n) => (n % every === 0 ? [[vector(normal), answer.eigenvalues[n]!.map(told).join(", ")]] : [])),
    ),
  );
}

// --- the small forms

/** Input fields for the stretches. */
function stateForm(): void {
  const holder = the("state-form");
  const values = numbers(question.stretch);
  const inputs = [...holder.querySelectorAll("input")];
  if (inputs.length === values.length) {
    inputs.forEach((input, n) => {
      if (input !== document.activeElement) input.value = String(values[n]);
    });
    return;
  }
  const send = () => {
    const all = [...holder.querySelectorAll("input")].map((input) => input.value.trim());
    show({ ...structuredClone(question), stretch: all.join(",") }, "push", "state");
  };
  holder.replaceChildren(
    ...values.map((value, n) =>
      element(
        "span",
        {},
        element("label", { for: `stretch-${n + 1}` }, `stretch λ${"₁₂₃"[n]}`),
        element("input", { id: `stretch-${n + 1}`, type: "number", step: "any", min: "0", value, change: send }),
      ),
    ),
  );
}

/** Input fields for the window of the map. */
function windowForm(): void {
  const { axes, ranges } = question.window;
  const isNumber = (own: Form["fields"][0]) => own.takes === "number";
  const stretches = ["stretch-1", "stretch-2", "stretch-3"].slice(0, form?.dimension ?? 2);
  const names = [...stretches, ...(form?.fields ?? []).filter(isNumber).map((own) => own.name)];
  const send = () => {
    const next = structuredClone(question);
    for (const n of [0, 1] as const) {
      const value = (name: string) => the<HTMLInputElement>(`axis-${n}-${name}`).value;
      const isOther = value("name") !== axes[n];
      next.window.axes[n] = value("name");
      const slider = form?.fields.find((own) => own.name === value("name"))?.slider;
      next.window.ranges[n] = isOther ? [...(slider ?? WINDOW.ranges[0])] : [Number(value("low")), Number(value("high"))];
    }
    show(next, "push", "form");
  };
  const row = (n: 0 | 1) => {
    const title = n === 0 ? "Rightward" : "Upward";
    return element(
      "div",
      { class: "row" },
      element("label", { for: `axis-${n}-name` }, title),
      element("select", { id: `axis-${n}-name`, change: send }, ...names.map((name) => element("option", { value: name, selected: name === axes[n] }, name))),
      element("input", { id: `axis-${n}-low`, type: "number", step: "any", value: ranges[n][0], "aria-label": `${title}, from`, change: send }),
      element("input", { id: `axis-${n}-high`, type: "number", step: "any", value: ranges[n][1], "aria-label": `${title}, to`, change: send }),
    );
  };
  the("window-form").replaceChildren(row(0), row(1));
}

/** Shows an entry of the zoo. */
function showEntry(entry: ZooEntry): void {
  const remedy = entry.remedy_question;
  const source = /^https?:\/\//.test(entry.where) ? element("a", { href: entry.where, rel: "noreferrer", target: "_blank" }, entry.where) : entry.where;
  the("entry").hidden = false;
  the<HTMLDetailsElement>("entry").open = true;
  the("entry")
    .querySelector("div")!
    .replaceChildren(
      element("p", {}, entry.seen),
      element("p", {}, "Seen at ", source),
      element("p", {}, `Assumed: ${entry.assumed}`),
      ...(remedy ? [element("p", {}, `Remedy: ${entry.remedy ?? ""} `, element("button", { type: "button", click: () => show(opened(remedy), "push", "form") }, "Show it"))] : []),
    );
}

const opened = (own: Question): Question => structuredClone({ set: own.set, stretch: own.stretch, window: own.window });

async function exported(kind: string): Promise<void> {
  try {
    const { text } = await ask<{ text: string }>("export", { ...asked(), window: question.window, form: kind });
    if (kind === "svg" || kind === "csv") {
      const address = URL.createObjectURL(new Blob([text], { type: kind === "svg" ? "image/svg+xml" : "text/csv" }));
      element("a", { href: address, download: `onset-map.${kind}` }).click();
      setTimeout(() => URL.revokeObjectURL(address), 10_000);
      return;
    }
    toCopy(text);
  } catch (error) {
    failed(error);
  }
}

/** Shows a text to copy, and copies it to the clipboard if permitted. */
function toCopy(text: string): void {
  the("export").hidden = false;
  const area = the<HTMLTextAreaElement>("export-text");
  area.value = text;
  area.focus();
  area.select();
  void navigator.clipboard?.writeText(text).catch(() => {});
}

// --- initialization

async function showStored(): Promise<void> {
  try {
    stored = await ask<Stored>("stored", {});
  } catch (error) {
    failed(error);
    return;
  }
  question = opened(stored.question);
  shown = stored.map;
  curves = null;
  const note = the("map-note");
  note.textContent = `Stored: ${stored.title}${stored.section ? `, ${stored.section}` : ""}`;
  note.hidden = false;
  drawMap();
  await anew();
}

/** Shows the question of the address. */
async function follow(): Promise<void> {
  await enter();
  const asks = read(location.hash);
  if (asks === "stored") void showStored();
  else {
    stored = null;
    the("map-note").hidden = true;
    show(asks ?? structuredClone(FIRST), "keep", "form");
  }
}

async function begin(): Promise<void> {
  for (const id of ["form", "state-form", "window-form"]) the(id).addEventListener("submit", (event) => event.preventDefault());
  the("map").addEventListener("click", clicked);
  the("map").addEventListener("keydown", stepped);
  for (const button of document.querySelectorAll<HTMLButtonElement>("button[data-form]")) {
    button.addEventListener("click", () => void exported(button.dataset["form"]!));
  }
  the("link").addEventListener("click", () => toCopy(location.href));
  the("anew").addEventListener("click", () => show(structuredClone(FIRST), "push", "form"));
  the<HTMLInputElement>("amplitude").addEventListener("input", (event) => {
    if (drawn) drawn.amplitude = Number((event.target as HTMLInputElement).value);
  });
  const pause = (isPaused: boolean) => {
    the("pause").setAttribute("aria-pressed", String(isPaused));
    if (drawn) drawn.isPaused = isPaused;
  };
  the("pause").addEventListener("click", () => pause(the("pause").getAttribute("aria-pressed") !== "true"));
  if (matchMedia("(prefers-reduced-motion: reduce)").matches) pause(true);
  the<HTMLInputElement>("study").addEventListener("change", async (event) => {
    const file = (event.target as HTMLInputElement).files?.[0];
    if (!file) return;
    try {
      const { question: own } = await ask<{ question: Question }>("open", { text: await file.text() });
      show(opened(own), "push", "form");
    } catch (error) {
      failed(error);
    }
  });
  addEventListener("popstate", () => void follow());
  let width = innerWidth;
  addEventListener("resize", () => {
    if (width === innerWidth) return;
    width = innerWidth;
    drawMap();
    if (waves) showDispersion(waves);
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    if (waves) showDispersion(waves);
    if (polar) showDirections(polar);
  });
  try {
    await enter();
    catalog = await ask<Catalog>("catalog", {});
  } catch (error) {
    failed(error);
    return;
  }
  the("version").textContent = catalog.version;
  const zoo = the<HTMLSelectElement>("zoo");
  zoo.append(...catalog.zoo.map((entry, n) => element("option", { value: n }, entry.title)));
  zoo.addEventListener("change", () => {
    const entry = catalog.zoo[Number(zoo.value)];
    if (zoo.value === "" || !entry) return;
    showEntry(entry);
    show(opened(entry.question), "push", "form");
  });
  await follow();
}

void begin();
