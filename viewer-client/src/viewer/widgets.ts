/** Labelled controls. */

import { html } from "../plots/svg";

/** Return a select inside its label. */
export function select(
  label: string,
  options: readonly (readonly [string, string])[],
  value: string,
  changed: (value: string) => void,
): HTMLSelectElement {
  const box = html(
    "select",
    { "aria-label": label },
    ...options.map(([name, text]) => new Option(text, name)),
  );
  box.value = value;
  box.onchange = () => changed(box.value);
  html("label", {}, html("span", {}, label), box);
  return box;
}

interface Range {
  readonly min: number;
  readonly max: number;
  readonly step: number;
  readonly value: number;
  readonly unit: string;
}

/** Return a slider with its value beside it, inside its label. */
export function slider(
  label: string,
  range: Range,
  changed: (value: number) => void,
): HTMLLabelElement {
  const { min, max, step, value, unit } = range;
  const input = html("input", { type: "range", min, max, step, value });
  const shown = html("output", {});
  const show = () => {
    shown.textContent = `${input.value} ${unit}`;
    input.setAttribute("aria-valuetext", shown.textContent);
  };
  show();
  input.oninput = () => {
    show();
    changed(Number(input.value));
  };
  return html("label", {}, html("span", {}, label), input, shown);
}

/** Return a checkbox inside its label. */
export function toggle(
  label: string,
  on: boolean,
  changed: (on: boolean) => void,
): HTMLLabelElement {
  const box = html("input", { type: "checkbox", checked: on });
  box.onchange = () => changed(box.checked);
  return html("label", { class: "toggle" }, box, html("span", {}, label));
}

/** Return a number for a person, or a dash. */
export function figure(value: number | null | undefined, digits = 4): string {
  if (value === null || value === undefined) return "–";
  const plain = Number(value.toPrecision(digits));
  const size = Math.abs(plain);
  return size !== 0 && (size < 1e-3 || size >= 1e5) ? plain.toExponential(2) : String(plain);
}

/** Return a table of two columns. */
export function pairs(rows: readonly (readonly [string, string | Node])[]): HTMLElement {
  return html(
    "dl",
    { class: "pairs" },
    ...rows.flatMap(([name, value]) => [html("dt", {}, name), html("dd", {}, value)]),
  );
}
