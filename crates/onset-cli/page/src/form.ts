// Form of a question: one control for each key that law and method read, as listed by the program.

import type { Catalog, Field, Form } from "./ask";
import { element, told } from "./dom";

/** Change of a key; `isDone` is false while a slider is moving. */
export type Change = (name: string, value: string, isDone: boolean) => void;

const TITLES: Record<string, string> = { material: "Material", discretization: "Discretization" };

/** Rebuilds the form and keeps the keyboard focus. */
export function build(place: HTMLElement, form: Form, catalog: Catalog, change: Change): void {
  const focused = document.activeElement?.id;
  const sections = Object.entries(TITLES).map(([section, title]) => {
    const own = form.fields.filter((field) => field.name.startsWith(`${section}.`));
    return element("fieldset", {}, element("legend", {}, title), ...own.map((field) => control(field, catalog, change)));
  });
  place.replaceChildren(...sections);
  if (focused) document.getElementById(focused)?.focus({ preventScroll: true });
}

/** Description of a word in the catalog. */
function described(catalog: Catalog, field: Field): HTMLElement[] {
  const topic = catalog.topics.find((own) => own.key === field.name);
  const entry = topic?.entries.find((own) => own.name === field.value);
  return entry?.formula ? [element("p", { class: "formula" }, entry.formula)] : [];
}

function control(field: Field, catalog: Catalog, change: Change): HTMLElement {
  const id = `field-${field.name}`;
  const label = element("label", { for: id, title: field.meaning }, field.name.split(".")[1]!);
  const send = (isDone: boolean) => (event: Event) => change(field.name, (event.target as HTMLInputElement).value, isDone);
  const hint = `${field.meaning}; ${field.expects}`;
  const row = (...inner: HTMLElement[]) =>
    element("div", { class: field.is_default ? "field" : "field set", "data-key": field.name }, label, ...inner);
  if (field.takes === null) {
    const options = field.words.map((word) => element("option", { value: word, selected: word === field.value }, word));
    return row(element("select", { id, title: hint, change: send(true) }, ...options), ...described(catalog, field));
  }
  if (field.takes === "switch") {
    const changed = (event: Event) => change(field.name, String((event.target as HTMLInputElement).checked), true);
    return row(element("input", { id, type: "checkbox", title: hint, checked: field.value === true, change: changed }));
  }
  if (field.takes === "text") {
    const value = Array.isArray(field.value) ? field.value.join(",") : String(field.value);
    if (field.words.length > 0) {
      const list = element("datalist", { id: `${id}-words` }, ...field.words.map((word) => element("option", { value: word })));
      return row(element("input", { id, list: list.id, value, title: hint, spellcheck: "false", change: send(true) }), list, ...described(catalog, field));
    }
    const area = element("textarea", { id, title: hint, rows: 2, spellcheck: "false", input: send(false), change: send(true) }, value);
    return row(area);
  }
  const value = Number(field.value);
  const number = element("input", { id, type: "number", step: "any", value: told(value) === String(value) ? value : String(field.value), title: hint, change: send(true) });
  if (!field.slider) return row(number);
  const [low, high] = field.slider;
  const step = field.takes === "whole" ? 1 : (high - low) / 200;
  const slider = element("input", {
    type: "range",
    min: low,
    max: high,
    step,
    value,
    "aria-label": `${field.name.split(".")[1]!} slider`,
    input: (event) => {
      number.value = String(Number(Number((event.target as HTMLInputElement).value).toPrecision(5)));
      change(field.name, number.value, false);
    },
    change: (event) => {
      number.value = String(Number(Number((event.target as HTMLInputElement).value).toPrecision(5)));
      change(field.name, number.value, true);
    },
  });
  slider.id = `${id}-slider`;
  return row(number, slider);
}
