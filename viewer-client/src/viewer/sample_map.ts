/** One map of the samples on a canvas: thousands of dots, the nearest to a click is chosen. */

import type { SampleColumns } from "../messages";
import { html } from "../plots/svg";

export type MapKind = "half" | "hemisphere";
export type ColourBy = "value" | "residual" | "weight";

const SIZE = 320;
const EDGE = { left: 34, right: 8, top: 8, bottom: 30 };
const REACH = 14;

interface Dot {
  readonly sample: number;
  readonly x: number;
  readonly y: number;
}

export class SampleMap {
  readonly element: HTMLElement;
  private readonly canvas: HTMLCanvasElement;
  private readonly legend = html("div", { class: "legend" });
  private dots: Dot[] = [];
  private chosen: number | null = null;

  constructor(
    private readonly kind: MapKind,
    private readonly pick: (sample: number) => void,
  ) {
    const title =
      kind === "half"
        ? "theta_h (square-root) and theta_d"
        : "detector seen from above, light at right";
    this.canvas = html("canvas", {
      tabindex: 0,
      role: "application",
      class: "sample-map",
      "data-map": kind,
      "aria-label": `map of the samples: ${title}. Arrow keys go to the neighbouring sample.`,
    });
    this.element = html("figure", {}, html("figcaption", {}, title), this.canvas, this.legend);
    this.canvas.addEventListener("click", (event) => this.click(event));
    this.canvas.addEventListener("keydown", (event) => this.key(event));
  }

  draw(
    columns: SampleColumns | null,
    colour: ColourBy,
    chosen: number | null,
    switches: ReadonlyMap<number, boolean>,
  ): void {
    this.chosen = chosen;
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    this.canvas.width = this.canvas.height = SIZE * ratio;
    const pen = this.canvas.getContext("2d")!;
    pen.scale(ratio, ratio);
    const ink = (name: string) => resolved(this.element, name);
    this.axes(pen, ink("--line"), ink("--faint"));
    this.dots = [];
    if (!columns) {
      this.legend.replaceChildren();
      return;
    }
    const paint = ramp(columns, colour);
    const count = columns.sample.length;
    const size = Math.max(1.6, Math.min(4, 90 / Math.sqrt(count)));
    // outliers last, so that they lie on top
    const order = [...Array(count).keys()].sort(
      (a, b) => Number(columns.outlier[a]) - Number(columns.outlier[b]),
    );
    for (const n of order) {
      const at = this.place(columns, n);
      if (!at) continue;
      const sample = columns.sample[n]!;
      this.dots.push({ sample, x: at[0], y: at[1] });
      const off = switches.get(sample) ?? !columns.used[n];
      pen.globalAlpha = off ? 0.35 : 0.9;
      pen.fillStyle = pen.strokeStyle = columns.outlier[n] ? ink("--outlier") : paint.colour(n);
      if (columns.outlier[n]) cross(pen, at, size + 1.2);
      else disk(pen, at, size, off);
      if (sample === chosen) {
        pen.globalAlpha = 1;
        pen.strokeStyle = ink("--accent");
        pen.lineWidth = 3;
        pen.beginPath();
        pen.arc(at[0], at[1], size + 5, 0, 7);
        pen.stroke();
        pen.lineWidth = 1;
      }
    }
    pen.globalAlpha = 1;
    this.legend.replaceChildren(
      html("span", {}, paint.low),
      html("span", { class: "ramp", style: `background:${paint.css}` }),
      html("span", {}, paint.high),
      html("span", { class: "outlier-mark" }, "× outlier"),
    );
  }

  private place(columns: SampleColumns, n: number): readonly [number, number] | null {
    const width = SIZE - EDGE.left - EDGE.right;
    const height = SIZE - EDGE.top - EDGE.bottom;
    if (this.kind === "half") {
      const [h, d] = [columns.theta_h[n], columns.theta_d[n]];
      if (h == null || d == null) return null;
      return [EDGE.left + Math.sqrt(h / 90) * width, EDGE.top + (1 - d / 90) * height];
    }
    const [theta, turn] = [columns.theta_o[n], columns.turn[n]];
    if (theta == null || turn == null || theta > 90) return null;
    const angle = (turn * Math.PI) / 180;
    const radius = ((theta / 90) * Math.min(width, height)) / 2;
    return [
      EDGE.left + width / 2 + radius * Math.cos(angle),
      EDGE.top + height / 2 - radius * Math.sin(angle),
    ];
  }

  private axes(pen: CanvasRenderingContext2D, line: string, faint: string): void {
    const width = SIZE - EDGE.left - EDGE.right;
    const height = SIZE - EDGE.top - EDGE.bottom;
    pen.strokeStyle = line;
    pen.fillStyle = faint;
    pen.font = "10px system-ui, sans-serif";
    pen.textAlign = "center";
    if (this.kind === "half") {
      for (const angle of [0, 5, 15, 30, 60, 90]) {
        const x = EDGE.left + Math.sqrt(angle / 90) * width;
        segment(pen, x, EDGE.top, x, EDGE.top + height);
        pen.fillText(`${angle}°`, x, EDGE.top + height + 12);
      }
      pen.fillText("theta_h", EDGE.left + width / 2, SIZE - 4);
      pen.textAlign = "right";
      for (const angle of [0, 30, 60, 90]) {
        const y = EDGE.top + (1 - angle / 90) * height;
        segment(pen, EDGE.left, y, EDGE.left + width, y);
        pen.fillText(`${angle}°`, EDGE.left - 4, y + 3);
      }
      return;
    }
    const [cx, cy, r] = [EDGE.left + width / 2, EDGE.top + height / 2, Math.min(width, height) / 2];
    for (const angle of [30, 60, 90]) {
      pen.beginPath();
      pen.arc(cx, cy, (angle / 90) * r, 0, 7);
      pen.stroke();
      pen.fillText(`${angle}°`, cx, cy - (angle / 90) * r + 11);
    }
    segment(pen, cx - r, cy, cx + r, cy);
    segment(pen, cx, cy - r, cx, cy + r);
    pen.fillText("theta_o outward; mirror side left", cx, SIZE - 4);
  }

  private click(event: MouseEvent): void {
    const box = this.canvas.getBoundingClientRect();
    const scale = SIZE / box.width;
    const [x, y] = [(event.clientX - box.left) * scale, (event.clientY - box.top) * scale];
    let best: Dot | null = null;
    let least = REACH * REACH;
    for (const dot of this.dots) {
      const distance = (dot.x - x) ** 2 + (dot.y - y) ** 2;
      // the last drawn lies on top
      if (distance <= least) [best, least] = [dot, distance];
    }
    if (best) this.pick(best.sample);
  }

  private key(event: KeyboardEvent): void {
    const directions: Record<string, readonly [number, number]> = {
      ArrowLeft: [-1, 0],
      ArrowRight: [1, 0],
      ArrowUp: [0, -1],
      ArrowDown: [0, 1],
    };
    const toward = directions[event.key];
    if (!toward || this.dots.length === 0) return;
    event.preventDefault();
    const here = this.dots.find((dot) => dot.sample === this.chosen);
    if (!here) {
      this.pick(this.dots[0]!.sample);
      return;
    }
    let best: Dot | null = null;
    let least = Infinity;
    for (const dot of this.dots) {
      const [dx, dy] = [dot.x - here.x, dot.y - here.y];
      const ahead = dx * toward[0] + dy * toward[1];
      const aside = Math.abs(dx * toward[1]) + Math.abs(dy * toward[0]);
      if (ahead > 0.01 && ahead + 2 * aside < least) [best, least] = [dot, ahead + 2 * aside];
    }
    if (best) this.pick(best.sample);
  }
}

/** Return a custom property as the colour that it means under the present theme. */
function resolved(element: HTMLElement, name: string): string {
  const before = element.style.color;
  element.style.color = `var(${name})`;
  const colour = getComputedStyle(element).color;
  element.style.color = before;
  return colour;
}

function segment(pen: CanvasRenderingContext2D, x1: number, y1: number, x2: number, y2: number) {
  pen.beginPath();
  pen.moveTo(x1, y1);
  pen.lineTo(x2, y2);
  pen.stroke();
}

function cross(pen: CanvasRenderingContext2D, [x, y]: readonly [number, number], r: number): void {
  pen.lineWidth = 1.8;
  segment(pen, x - r, y - r, x + r, y + r);
  segment(pen, x - r, y + r, x + r, y - r);
  pen.lineWidth = 1;
}

function disk(
  pen: CanvasRenderingContext2D,
  [x, y]: readonly [number, number],
  r: number,
  hollow: boolean,
): void {
  pen.beginPath();
  pen.arc(x, y, r, 0, 7);
  if (hollow) pen.stroke();
  else pen.fill();
}

interface Ramp {
  colour(n: number): string;
  readonly css: string;
  readonly low: string;
  readonly high: string;
}

// Blue to red through grey for residuals, dark to light for amounts.
const SIGNED = ["#2c5fb3", "#86a8dc", "#9a9a9a", "#e09a70", "#b9481f"];
const AMOUNT = ["#3b2a6d", "#355f8d", "#22918b", "#6bbf59", "#e8d02a"];

/** Return the colour at `t` in [0, 1] between those of a ramp. */
function blend(colours: readonly string[], t: number): string {
  const at = t * (colours.length - 1);
  const below = Math.min(Math.floor(at), colours.length - 2);
  const [a, b] = [colours[below]!, colours[below + 1]!];
  const mixed = [1, 3, 5].map((k) => {
    const [from, to] = [a, b].map((hex) => parseInt(hex.slice(k, k + 2), 16));
    return Math.round(from! + (to! - from!) * (at - below));
  });
  return `rgb(${mixed.join(" ")})`;
}

function ramp(columns: SampleColumns, by: ColourBy): Ramp {
  const signed = by === "residual";
  const column = columns[by];
  const raw = (n: number) => {
    const value = column[n];
    if (value == null) return NaN;
    return by === "value" ? Math.log(Math.max(value, 1e-12)) : value;
  };
  // an outlier has a mark of its own: the colours are for the others
  const finite = column.map((_, n) => (columns.outlier[n] ? NaN : raw(n))).filter(Number.isFinite);
  finite.sort((a, b) => a - b);
  const quantile = (q: number) => finite[Math.floor(q * (finite.length - 1))] ?? 0;
  let [low, high] = [quantile(0.02), quantile(0.98)];
  if (signed) {
    high = Math.max(Math.abs(low), Math.abs(high), 0.05);
    low = -high;
  }
  if (by === "weight") [low, high] = [0, 1];
  const colours = signed ? SIGNED : AMOUNT;
  const shown = (value: number) => (by === "value" ? Math.exp(value) : value).toPrecision(2);
  return {
    colour(n) {
      const value = raw(n);
      if (!Number.isFinite(value)) return "#999999";
      const t = Math.max(0, Math.min(1, (value - low) / (high - low || 1)));
      return blend(colours, t);
    },
    css: `linear-gradient(to right, ${colours.join(", ")})`,
    low: `${by === "residual" ? "ln(value / result) " : ""}${shown(low)}`,
    high: shown(high),
  };
}
