/** The interactive slices of a report: any angle of incidence, from data within the page. */

import type { SlicePanel } from "../messages";
import { polarPlot } from "../plots/polar";
import type { ScaleKind } from "../plots/scale";
import { LEFT, RIGHT, slicePlot } from "../plots/slice";
import { html } from "../plots/svg";
import { type SliceData, unpacked } from "./data";

const NOTHING_CHOSEN = "Move over the plot, or focus it and use the arrow keys, to read values.";

function number(value: number): string {
  if (!Number.isFinite(value)) return "not known";
  const shown = Number(value.toPrecision(3));
  return Math.abs(shown) >= 1e-4 && Math.abs(shown) < 1e6 ? String(shown) : shown.toExponential(2);
}

function checkbox(text: string, change: () => void): [HTMLLabelElement, HTMLInputElement] {
  const input = html("input", { type: "checkbox", checked: true });
  input.addEventListener("change", change);
  return [html("label", {}, input, ` ${text}`), input];
}

function choice(
  text: string,
  options: Record<string, string>,
  change: () => void,
): [HTMLLabelElement, HTMLSelectElement] {
  const select = html("select");
  for (const [value, shown] of Object.entries(options)) {
    select.append(html("option", { value }, shown));
  }
  select.addEventListener("change", change);
  return [html("label", {}, `${text} `, select), select];
}

class Slices {
  private readonly slider: HTMLInputElement;
  private readonly angle = html("output", { for: "incidence" });
  private readonly plot = html("div", { class: "stage", tabindex: 0, role: "group" });
  private readonly readout = html("p", { class: "readout", role: "status" }, NOTHING_CHOSEN);
  private readonly points: HTMLInputElement;
  private readonly outliers: HTMLInputElement;
  private readonly view: HTMLSelectElement;
  private readonly scale: HTMLSelectElement;
  private panel: SlicePanel;
  private cursor: number;

  constructor(
    private readonly data: SliceData,
    place: HTMLElement,
  ) {
    const redraw = () => this.draw();
    this.slider = html("input", {
      id: "incidence",
      type: "range",
      min: 0,
      max: data.panels.length - 1,
      step: 1,
      value: this.nearest(data.start),
    });
    this.slider.addEventListener("input", redraw);
    const [pointsLabel, points] = checkbox("measurements", redraw);
    const [outliersLabel, outliers] = checkbox("outliers", redraw);
    const views = { slice: "against the angle", polar: "polar" };
    const [viewLabel, view] = choice("Plot", views, redraw);
    const [scaleLabel, scale] = choice("Scale", { log: "logarithmic", linear: "linear" }, redraw);
    [this.points, this.outliers, this.view, this.scale] = [points, outliers, view, scale];
    this.panel = unpacked(data, 0, { points: true, outliers: true });
    this.cursor = Math.floor(data.theta_o.length / 2);
    const hasPoints = data.panels.some((panel) => panel.points.length > 0);
    place.append(
      html(
        "div",
        { class: "controls" },
        html("label", { for: "incidence" }, "Angle of incidence"),
        this.slider,
        this.angle,
        ...(data.measured.length > 0 ? [this.jump(-1), this.jump(1)] : []),
      ),
      html(
        "div",
        { class: "controls" },
        viewLabel,
        scaleLabel,
        ...(hasPoints ? [pointsLabel, outliersLabel] : []),
      ),
      this.plot,
      this.readout,
    );
    this.plot.addEventListener("pointermove", (event) => this.point(event));
    this.plot.addEventListener("keydown", (event) => this.key(event));
    this.draw();
  }

  private nearest(angle: number): number {
    const off = this.data.panels.map((panel) => Math.abs(panel.theta_i - angle));
    return off.indexOf(Math.min(...off));
  }

  /** A button that goes to the nearest measured angle on one side. */
  private jump(side: -1 | 1): HTMLButtonElement {
    const text = side < 0 ? "◀ measured" : "measured ▶";
    const label = `${side < 0 ? "previous" : "next"} angle at which the light was measured`;
    const button = html("button", { type: "button", "aria-label": label }, text);
    button.addEventListener("click", () => {
      const beyond = this.data.measured.filter((angle) => side * (angle - this.panel.theta_i) > 0);
      const next = side < 0 ? beyond.at(-1) : beyond[0];
      if (next !== undefined) {
        this.slider.value = String(this.nearest(next));
        this.draw();
      }
    });
    return button;
  }

  private draw(): void {
    this.panel = unpacked(this.data, this.slider.valueAsNumber, {
      points: this.points.checked,
      outliers: this.outliers.checked,
    });
    const measured = this.data.measured.includes(this.panel.theta_i);
    const shown = `${this.panel.theta_i}°${measured ? ", measured" : ""}`;
    this.angle.value = shown;
    this.slider.setAttribute("aria-valuetext", shown);
    const options = {
      scale: this.scale.value as ScaleKind,
      onPick: (sample: number) => this.tell(sample),
    };
    const polar = this.view.value === "polar";
    this.plot.replaceChildren(
      polar ? polarPlot(this.panel, options) : slicePlot(this.panel, options),
    );
    const left = this.panel.points_left_out;
    this.readout.textContent = left ? `${left} more measurements are not drawn.` : NOTHING_CHOSEN;
  }

  private tell(sample: number): void {
    const points = this.panel.points.filter((point) => point.sample === sample);
    const first = points[0];
    if (!first) return;
    const values = points.map((point) => `${point.channel} ${number(point.value)}`).join(", ");
    const what = first.outlier ? "an outlier" : "measured";
    this.readout.textContent = `row ${first.row}, ${what} at theta_o = ${first.theta_o}°: ${values} 1/sr`;
  }

  private point(event: PointerEvent): void {
    if (this.view.value === "polar") return;
    const drawing = this.plot.querySelector("svg");
    const box = drawing?.getBoundingClientRect();
    if (!drawing || !box || (event.target as Element).closest(".sample")) return;
    const width = drawing.viewBox.baseVal.width;
    const share =
      (((event.clientX - box.left) / box.width) * width - LEFT) / (width - LEFT - RIGHT);
    this.read(this.data.theta_o.findIndex((theta) => theta >= share * 180 - 90));
  }

  private key(event: KeyboardEvent): void {
    const step = { ArrowLeft: -2, ArrowRight: 2, PageUp: 20, PageDown: -20 }[event.key];
    if (step === undefined) return;
    event.preventDefault();
    this.read(Math.min(Math.max(this.cursor + step, 0), this.data.theta_o.length - 1));
  }

  private read(index: number): void {
    const theta = this.data.theta_o[index];
    if (theta === undefined) return;
    this.cursor = index;
    const values = this.panel.curves.map(({ channel, value, low, high }) => {
      const band =
        low && high ? ` (${number(low[index] ?? NaN)} to ${number(high[index] ?? NaN)})` : "";
      return `${channel} ${number(value[index] ?? NaN)}${band}`;
    });
    this.readout.textContent = `theta_o = ${theta}°: ${values.join(", ")} 1/sr`;
  }
}

const source = document.getElementById("slice-data");
const place = document.getElementById("interactive");
if (source?.textContent && place) {
  new Slices(JSON.parse(source.textContent) as SliceData, place);
  place.hidden = false;
  document.documentElement.classList.add("scripted");
}
