/** f_r along one slice: curves with their 95 % band, and the measurements nearby. */

import type { NearPoint, SlicePanel } from "../messages";
import { label, scaleOf, type Scale, type ScaleKind } from "./scale";
import { path, svg } from "./svg";

export interface SliceOptions {
  readonly scale: ScaleKind;
  /** Called with the index of a sample that was clicked, or chosen with Enter. */
  readonly onPick?: (sample: number) => void;
  readonly width?: number;
  readonly height?: number;
  /** A second slice drawn dashed, for comparison. */
  readonly other?: SlicePanel | undefined;
  /** The sample that is looked at. */
  readonly chosen?: number | null;
}

interface Frame {
  readonly left: number;
  readonly right: number;
  readonly top: number;
  readonly bottom: number;
  readonly scale: Scale;
}

const MOST_ABOVE = 4;
/** Where the horizontal axis begins, and how far before the right edge it ends. */
export const LEFT = 60;
export const RIGHT = 10;
const TICKS = [-90, -60, -30, 0, 30, 60, 90];

/** Return all values of a slice that its scale has to hold. */
export function* valuesOf(panel: SlicePanel): Generator<number> {
  for (const curve of panel.curves) yield* curve.value;
  for (const point of panel.points) yield point.value;
}

/** Return the values of several slices that a logarithmic scale should show. */
export function commonScale(panels: readonly SlicePanel[], kind: ScaleKind): Scale {
  const curves = panels.flatMap((panel) => panel.curves.flatMap((curve) => curve.value));
  // Six decades at most: what lies lower is next to nothing, and stands at the bottom.
  const most = Math.max(...curves);
  const least = Math.max(Math.min(...curves.filter((value) => value > 0)) / 30, most / 1e6);
  const values = panels.flatMap((panel) => [...valuesOf(panel)]);
  // The band of the first, but a very wide one must not press the curves together.
  const [high, low] = [most * MOST_ABOVE, Math.max(least, 0)];
  for (const curve of panels[0]?.curves ?? []) {
    for (const value of curve.high ?? []) values.push(Math.min(value, high));
    for (const value of curve.low ?? []) values.push(Math.max(value, low));
  }
  // A censored value near zero must not press everything else against the top.
  return scaleOf(kind === "log" ? values.filter((value) => value >= least) : values, kind);
}

/** Return the plot of a slice as an SVG element that scales with its container. */
export function slicePlot(panel: SlicePanel, options: SliceOptions): SVGSVGElement {
  const { width = 560, height = 300 } = options;
  const shown = options.other ? [panel, options.other] : [panel];
  const scale = commonScale(shown, options.scale);
  const frame: Frame = { left: LEFT, right: width - RIGHT, top: 10, bottom: height - 36, scale };
  const plot = svg("svg", {
    viewBox: `0 0 ${width} ${height}`,
    class: "plot slice-plot",
    role: "group",
    "aria-label": describe(panel),
  });
  plot.append(axes(frame, width, height), mirror(panel, frame));
  for (const one of panel.curves) plot.append(...curveMarks(panel, one, frame, false));
  if (options.other) {
    for (const one of options.other.curves) {
      plot.append(...curveMarks(options.other, one, frame, true));
    }
  }
  plot.append(...panel.points.map((point) => mark(point, place(point, frame), options)));
  return plot;
}

function describe(panel: SlicePanel): string {
  const outliers = panel.points.filter((point) => point.outlier).length;
  return (
    `f_r against the detector's angle, light at ${panel.theta_i} degrees; ` +
    `${panel.points.length} measured values nearby, ${outliers} of them outliers`
  );
}

function x(theta: number, frame: Frame): number {
  return frame.left + ((theta + 90) / 180) * (frame.right - frame.left);
}

function y(value: number, frame: Frame): number {
  const share = frame.scale.at(value);
  return frame.bottom - share * (frame.bottom - frame.top);
}

function place(point: NearPoint, frame: Frame): [number, number] {
  const held = Math.max(point.value, frame.scale.low);
  return [x(point.theta_o, frame), y(Math.min(held, frame.scale.high), frame)];
}

function axes(frame: Frame, width: number, height: number): SVGGElement {
  const group = svg("g", { class: "axes", "aria-hidden": "true" });
  for (const tick of TICKS) {
    const at = x(tick, frame);
    group.append(
      svg("line", { x1: at, x2: at, y1: frame.top, y2: frame.bottom, class: "grid" }),
      svg("text", { x: at, y: frame.bottom + 14, "text-anchor": "middle" }, `${tick}°`),
    );
  }
  for (const tick of frame.scale.ticks) {
    const at = y(tick, frame);
    if (at < frame.top - 1 || at > frame.bottom + 1) continue;
    group.append(
      svg("line", { x1: frame.left, x2: frame.right, y1: at, y2: at, class: "grid" }),
      svg("text", { x: frame.left - 6, y: at + 4, "text-anchor": "end" }, label(tick)),
    );
  }
  group.append(
    svg(
      "text",
      { x: (frame.left + frame.right) / 2, y: height - 6, "text-anchor": "middle", class: "title" },
      "theta_o (mirror side > 0)",
    ),
    svg(
      "text",
      {
        x: 12,
        y: (frame.top + frame.bottom) / 2,
        "text-anchor": "middle",
        class: "title",
        transform: `rotate(-90 12 ${(frame.top + frame.bottom) / 2})`,
      },
      "f_r (1/sr)",
    ),
  );
  if (width < 1) group.remove();
  return group;
}

function mirror(panel: SlicePanel, frame: Frame): SVGLineElement {
  const at = x(panel.theta_i, frame);
  return svg("line", { x1: at, x2: at, y1: frame.top, y2: frame.bottom, class: "mirror" });
}

function curveMarks(
  panel: SlicePanel,
  curve: SlicePanel["curves"][number],
  frame: Frame,
  dashed: boolean,
): SVGPathElement[] {
  const clamp = (value: number) =>
    frame.scale.kind === "log" ? Math.max(value, frame.scale.low) : value;
  const points = (values: readonly number[]) =>
    panel.theta_o.map((theta, n): [number, number] => [
      x(theta, frame),
      y(Math.min(clamp(values[n] ?? NaN), frame.scale.high), frame),
    ]);
  const marks: SVGPathElement[] = [];
  if (curve.low && curve.high && !dashed) {
    const up = path(points(curve.high));
    const down = path(points(curve.low).reverse()).replace("M", "L");
    marks.push(
      svg("path", {
        d: `${up}${down}Z`,
        fill: curve.colour,
        class: "band",
        "data-channel": curve.channel,
      }),
    );
  }
  marks.push(
    svg(
      "path",
      {
        d: path(points(curve.value)),
        stroke: curve.colour,
        class: dashed ? "curve other" : "curve",
        "data-channel": curve.channel,
      },
      svg("title", {}, curve.channel),
    ),
  );
  return marks;
}

/** Return the mark of a measured value: a dot, or a cross for an outlier. */
export function mark(
  point: NearPoint,
  [left, top]: readonly [number, number],
  options: Pick<SliceOptions, "onPick" | "chosen">,
): SVGElement {
  const kind = point.outlier ? "outlier" : point.used ? "" : "off";
  const chosen = options.chosen === point.sample ? " chosen" : "";
  const shape = point.outlier
    ? svg("path", { d: `M${left - 4} ${top - 4}l8 8m0 -8l-8 8` })
    : svg("circle", { cx: left, cy: top, r: chosen ? 4.5 : 2.4, fill: point.colour });
  shape.setAttribute("class", `sample ${kind}${chosen}`);
  const what = point.outlier ? "outlier" : point.used ? "measured" : "switched off or unusable";
  shape.append(
    svg("title", {}, `row ${point.row}, ${point.channel}: ${point.value.toPrecision(4)} (${what})`),
  );
  const { onPick } = options;
  if (onPick) shape.addEventListener("click", () => onPick(point.sample));
  return shape;
}
