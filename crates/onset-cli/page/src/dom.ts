// DOM elements, built so that no text is interpreted as markup.

type Child = Node | string | number;
type Values = Record<string, string | number | boolean | ((event: Event) => void) | undefined>;

/** Element with the given id. */
export function the<T extends HTMLElement = HTMLElement>(id: string): T {
  const found = document.getElementById(id);
  if (!found) throw new Error(`no element ${id}`);
  return found as T;
}

/** Element with attributes, listeners and children. */
export function element<K extends keyof HTMLElementTagNameMap>(name: K, values: Values = {}, ...children: Child[]): HTMLElementTagNameMap[K] {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(values)) {
    if (typeof value === "function") made.addEventListener(key, value);
    else if (value === true) made.setAttribute(key, "");
    else if (value !== false && value !== undefined) made.setAttribute(key, String(value));
  }
  made.append(...children.map((child) => (typeof child === "number" ? String(child) : child)));
  return made;
}

/** Table with a header and a caption. */
export function table(caption: string, header: string[], rows: (string | number)[][]): HTMLElement {
  const cells = (row: (string | number)[]) =>
    row.map((cell, n) => (n === 0 ? element("th", { scope: "row" }, cell) : element("td", {}, cell)));
  return element(
    "table",
    {},
    element("caption", {}, caption),
    element("thead", {}, element("tr", {}, ...header.map((name) => element("th", { scope: "col" }, name)))),
    element("tbody", {}, ...rows.map((row) => element("tr", {}, ...cells(row)))),
  );
}

/** Fills the details element with a table when it is opened. */
export function lazily(details: HTMLElement, make: () => HTMLElement): void {
  const place = details.querySelector("div")!;
  const fill = () => {
    if ((details as HTMLDetailsElement).open) place.replaceChildren(scrolled(make()));
  };
  details.ontoggle = fill;
  fill();
}

/** Scrollable container of a table, accessible by keyboard. */
function scrolled(inner: HTMLElement): HTMLElement {
  const caption = inner.querySelector("caption")?.textContent ?? "table";
  return element("div", { class: "scrolled", tabindex: 0, role: "region", "aria-label": caption }, inner);
}

/** Formats a number with six significant digits, as the command does. */
export function told(value: number | null | undefined): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e6 || size < 1e-4) return value.toExponential(5).replace(/\.?0+e/, "e").replace("e+", "e");
  return String(Number(value.toPrecision(6)));
}

/** Formats a vector with six significant digits. */
export function vector(values: number[]): string {
  // Components that are rounding errors of the largest one are shown as zero.
  const size = Math.max(...values.map(Math.abs));
  return `(${values.map((value) => told(Math.abs(value) < 1e-13 * size ? 0 : value)).join(", ")})`;
}

/** Color of the page in the current color scheme. */
export const color = (name: string): string => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
