// Particles of a mode on a line or in a plane.

import type { Mode } from "./ask";
import { color } from "./dom";

/** Period of the animation, and time between frames; seconds. */
export const PERIOD = 2;
export const PAUSE = 1 / 30;

/** Animation that runs until it is stopped. */
export interface Moving {
  amplitude: number;
  isPaused: boolean;
  stop(): void;
}

/** Displacement of a particle at a phase, relative to the largest amplitude. */
export const displacement = (own: Mode["particles"][0], phase: number, axis: number): number =>
  own.re[axis]! * Math.cos(phase) + own.im[axis]! * Math.sin(phase);

/** Animates a mode on a canvas. */
export function moving(canvas: HTMLCanvasElement, mode: Mode, amplitude: number, isPaused: boolean): Moving {
  const places = mode.particles.map((own) => own.place);
  const ends = (axis: number): [number, number] => {
    const all = places.map((place) => place[axis]!);
    return [Math.min(...all) - mode.spacing, Math.max(...all) + mode.spacing];
  };
  const [[left, right], [bottom, top]] = [ends(0), ends(1)];
  const ratio = window.devicePixelRatio || 1;
  const width = canvas.clientWidth || 480;
  const tall = Math.min(Math.max((width * (top - bottom)) / (right - left), 60), 420);
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(tall * ratio);
  canvas.style.height = `${tall}px`;
  const scale = Math.min(canvas.width / (right - left), canvas.height / (top - bottom));
  // A few dots are drawn faster without a graphics card, which some machines emulate.
  const context = canvas.getContext("2d", { willReadFrequently: true })!;
  const state: Moving & { frame: number } = { amplitude, isPaused, frame: 0, stop: () => cancelAnimationFrame(state.frame) };
  // Colors are read once, because reading them triggers a layout of the page.
  const [still, alive] = [color("line"), color(mode.stable ? "blue" : "vermilion")];
  let phase = 0;
  let last = -Infinity;
  let known = -1;
  const draw = (now: number) => {
    state.frame = requestAnimationFrame(draw);
    const isSame = state.isPaused && known === state.amplitude;
    if (isSame || now - last < 1000 * PAUSE) return;
    if (!state.isPaused && Number.isFinite(last)) phase += (Math.min(now - last, 200) / 1000 / PERIOD) * 2 * Math.PI;
    last = now;
    known = state.amplitude;
    context.clearRect(0, 0, canvas.width, canvas.height);
    const at = (n: number, size: number): [number, number] => {
      const own = mode.particles[n]!;
      const x = own.place[0]! + size * displacement(own, phase, 0);
      const y = own.place[1]! + size * displacement(own, phase, 1);
      return [canvas.width / 2 + (x - (left + right) / 2) * scale, canvas.height / 2 - (y - (bottom + top) / 2) * scale];
    };
    const radius = Math.max(2 * ratio, 0.16 * mode.spacing * scale);
    const dots = (size: number, fill: string, r: number) => {
      context.fillStyle = fill;
      context.beginPath();
      for (let n = 0; n < places.length; n++) {
        const [x, y] = at(n, size);
        context.moveTo(x + r, y);
        context.arc(x, y, r, 0, 2 * Math.PI);
      }
      context.fill();
    };
    dots(0, still, radius / 2);
    dots(state.amplitude * mode.spacing, alive, radius);
  };
  draw(performance.now());
  return state;
}
