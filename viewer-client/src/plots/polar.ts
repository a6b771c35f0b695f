/** The same slice as a polar diagram: angle is the detector's, radius the value. */

import type { SlicePanel } from "../messages";
import { label, type Scale } from "./scale";
import { commonScale, mark, type SliceOptions } from "./slice";
import { path, svg } from "./svg";

const RADIUS = 230;
const CENTRE: readonly [number, number] = [280, 250];

function at(theta: number, value: number, scale: Scale): [number, number] {
  const share = Math.min(Math.max(scale.at(Math.max(value, scale.low)), 0), 1);
  const angle = (theta * Math.PI) / 180;
  return [
    CENTRE[0] + share * RADIUS * Math.sin(angle),
    CENTRE[1] - share * RADIUS * Math.cos(angle),
  ];
}

/** Return the polar diagram of a slice; the light comes from the left. */
export function polarPlot(panel: SlicePanel, options: SliceOptions): SVGSVGElement {
  const shown = options.other ? [panel, options.other] : [panel];
  const scale = commonScale(shown, options.scale);
  const plot = svg("svg", {
    viewBox: "0 0 560 280",
    class: "plot polar-plot",
    role: "group",
    "aria-label": `polar diagram of f_r, light at ${panel.theta_i} degrees`,
  });
  plot.append(rings(scale), lightRay(panel.theta_i));
  for (const [n, one] of shown.entries()) {
    for (const curve of one.curves) {
      const points = one.theta_o.map((theta, k) => at(theta, curve.value[k] ?? NaN, scale));
      if (curve.low && curve.high && n === 0) {
        const low = curve.low;
        const high = curve.high;
        const up = path(one.theta_o.map((theta, k) => at(theta, high[k] ?? NaN, scale)));
        const down = path(one.theta_o.map((theta, k) => at(theta, low[k] ?? NaN, scale)).reverse());
        const d = `${up}${down.replace("M", "L")}Z`;
        plot.append(svg("path", { d, fill: curve.colour, class: "band" }));
      }
      plot.append(
        svg("path", { d: path(points), stroke: curve.colour, class: n ? "curve other" : "curve" }),
      );
    }
  }
  for (const point of panel.points) {
    plot.append(mark(point, at(point.theta_o, point.value, scale), options));
  }
  return plot;
}

function rings(scale: Scale): SVGGElement {
  const group = svg("g", { class: "axes", "aria-hidden": "true" });
  const [cx, cy] = CENTRE;
  for (const tick of scale.ticks) {
    const radius = scale.at(tick) * RADIUS;
    if (!(radius > 4 && radius <= RADIUS + 1)) continue;
    group.append(
      svg("path", {
        d: `M${cx - radius} ${cy}A${radius} ${radius} 0 0 1 ${cx + radius} ${cy}`,
        class: "grid",
        fill: "none",
      }),
      svg("text", { x: cx + radius, y: cy + 14, "text-anchor": "middle" }, label(tick)),
    );
  }
  for (const theta of [-90, -60, -30, 0, 30, 60, 90]) {
    const angle = (theta * Math.PI) / 180;
    const x2 = cx + RADIUS * Math.sin(angle);
    const y2 = cy - RADIUS * Math.cos(angle);
    group.append(svg("line", { x1: cx, y1: cy, x2, y2, class: "grid" }));
    if (Math.abs(theta) < 90) {
      const out = RADIUS + 12;
      group.append(
        svg(
          "text",
          {
            x: cx + out * Math.sin(angle),
            y: cy - out * Math.cos(angle) + 4,
            "text-anchor": "middle",
          },
          `${theta}°`,
        ),
      );
    }
  }
  return group;
}

function lightRay(thetaI: number): SVGGElement {
  const angle = (-thetaI * Math.PI) / 180;
  const [cx, cy] = CENTRE;
  const far: [number, number] = [
    cx + (RADIUS + 4) * Math.sin(angle),
    cy - (RADIUS + 4) * Math.cos(angle),
  ];
  return svg(
    "g",
    { class: "light" },
    svg("line", { x1: far[0], y1: far[1], x2: cx, y2: cy }),
    svg("circle", { cx: far[0], cy: far[1], r: 5 }, svg("title", {}, "the light")),
  );
}
