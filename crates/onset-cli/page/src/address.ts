// The complete question is in the fragment (after #) of the address, in the form that `onset explore` prints.

import type { Question, Window } from "./ask";

export const WINDOW: Window = { axes: ["stretch-1", "stretch-2"], ranges: [[0.5, 2], [0.5, 2]] };

/** Question of an address; `stored` for the map opened by the user, null for an address without a question. */
export function read(hash: string): Question | "stored" | null {
  const parts = new URLSearchParams(hash.replace(/^#/, "").replaceAll("+", "%2B"));
  if (parts.get("map") === "stored") return "stored";
  const [set, stretch] = [parts.getAll("set"), parts.get("stretch") ?? ""];
  const axes = parts.getAll("axis").map((text) => text.split(","));
  if (set.length === 0 && stretch === "" && axes.length === 0) return null;
  const window = structuredClone(WINDOW);
  axes.slice(0, 2).forEach(([name, low, high], n) => {
    const range: [number, number] = [Number(low), Number(high)];
    if (name && range[0] < range[1] && range.every(Number.isFinite)) {
      window.axes[n as 0 | 1] = name;
      window.ranges[n as 0 | 1] = range;
    }
  });
  return { set, stretch, window };
}

/** Fragment of the address of a question. */
export function written(question: Question): string {
  const { axes, ranges } = question.window;
  const parts = question.set.map((own) => `set=${encodeURIComponent(own)}`);
  parts.push(`stretch=${encodeURIComponent(question.stretch).replaceAll("%2C", ",")}`);
  axes.forEach((name, n) => parts.push(`axis=${encodeURIComponent(name)},${ranges[n as 0 | 1].join(",")}`));
  return `#${parts.join("&")}`;
}
