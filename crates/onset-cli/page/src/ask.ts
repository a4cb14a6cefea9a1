// Requests to the program. A repeated request cancels the previous one, and the program then stops its computation.

import { SHOWN, token } from "./token";

export interface Window {
  axes: [string, string];
  ranges: [[number, number], [number, number]];
}

export interface Question {
  set: string[];
  stretch: string;
  window: Window;
}

export interface Complex {
  re: number;
  im: number;
}

export interface Field {
  name: string;
  meaning: string;
  expects: string;
  default: string;
  words: string[];
  takes: "number" | "whole" | "switch" | "text" | null;
  value: number | string | boolean | number[];
  is_default: boolean;
  slider: [number, number] | null;
}

export interface Form {
  dimension: number;
  fields: Field[];
  set: string[];
  missing: string[];
}

export interface State {
  verdict: string;
  mechanism: string | null;
  evidence: "proved" | "bounded" | "searched";
  sentence: string;
  notes: string[];
  next: string[];
  deformation_gradient: number[][];
  material: {
    model: string;
    cauchy: number[][];
    first_piola: number[][];
    ellipticity: "elliptic" | "lost" | "undecided";
    minimum_acoustic_eigenvalue: number;
    direction: number[];
  };
  /** Absent for a sheet in plane stress. */
  material_3d?: { minimum_acoustic_eigenvalue: number; direction: number[]; ellipticity: string };
  discretization: {
    stable: boolean;
    mode: string;
    minimum_omega_squared: Complex;
    minimum_scaled: number;
    wave_vector: number[];
    spatial_wave_vector: number[];
    polarization: number[];
    growth_rate: number;
    flutter: boolean;
    maximum_omega: number;
    critical_time_step: number | null;
    critical_time_step_of: string;
    finite_bodies: { time_step: number; proved: boolean; ground: string } | null;
    damped_time_steps?: Record<string, number>;
  };
}

/** Frequencies as positive values, growth rates as negative ones. */
export interface Heights {
  particles: number[];
  continuum: number[];
  flutter: number | null;
}

export interface Dispersion {
  corners: { name: string; wave_vector: number[]; length: number }[];
  lengths: number[];
  heights: Heights[];
  critical: { stable: boolean; height: number; length: number | null };
}

export interface Directions {
  shape: [number, number];
  normals: number[][];
  eigenvalues: number[][];
}

export interface Mode {
  stable: boolean;
  is_long_wave: boolean;
  wave_vector: number[];
  omega_squared: Complex;
  spacing: number;
  particles: { site: number; place: number[]; re: number[]; im: number[] }[];
}

export interface ShownMap {
  axes: { name: string; label: string; range: [number, number]; states: number }[];
  classes: (number | null)[];
  level: number;
  is_finest: boolean;
}

export interface Curves {
  features: {
    properties: { of: "material" | "discretization" };
    geometry: { type: "LineString"; coordinates: [number, number][] } | { type: "Polygon"; coordinates: [number, number][][] };
  }[];
}

export interface ZooEntry {
  title: string;
  seen: string;
  where: string;
  assumed: string;
  question: Question;
  remedy: string | null;
  remedy_question: Question | null;
}

export interface Catalog {
  version: string;
  topics: { name: string; key: string; entries: { name: string; formula: string; source: string; domain?: string }[] }[];
  classes: { name: string; title: string; color: string }[];
  zoo: ZooEntry[];
}

export interface Stored {
  title: string;
  section: string | null;
  question: Question;
  map: ShownMap;
}

/** Error message of the program. */
export class Refusal extends Error {}

const running = new Map<string, AbortController>();

/** Cancels the pending request in a place. */
export function giveUp(name: string): void {
  running.get(name)?.abort();
  running.delete(name);
}

/** Returns true while the request of a place is running. */
export const isAsking = (place: string): boolean => running.has(place);

/** Sends a request. An earlier request in the same place is cancelled and never resolves. */
export async function ask<T>(name: string, question: Partial<Question> & Record<string, unknown>, place: string = name): Promise<T> {
  giveUp(place);
  const controller = new AbortController();
  running.set(place, controller);
  const answer = await fetch(`api/${name}`, {
    method: "POST",
    headers: { "Content-Type": "application/json", [SHOWN]: token() },
    body: JSON.stringify(question),
    signal: controller.signal,
  });
  const document = (await answer.json()) as T & { error?: string };
  if (running.get(place) === controller) running.delete(place);
  if (controller.signal.aborted) throw new DOMException("given up", "AbortError");
  if (document.error !== undefined) throw new Refusal(document.error);
  return document;
}

/** Returns true if a request was cancelled. */
export const isGivenUp = (error: unknown): boolean => error instanceof DOMException && error.name === "AbortError";
