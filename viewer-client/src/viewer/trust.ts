/** The trust map: what was measured, what interpolated, what the population supplied. */

import type { TrustPlane } from "../messages";
import { svg, html } from "../plots/svg";
import { api } from "./api";
import type { Model } from "./model";
import { whenShown } from "./tabs";
import { slider } from "./widgets";

const COLOURS = ["var(--trust-1)", "var(--trust-2)", "var(--trust-3)"];

export class TrustPanel {
  private readonly map = html("div", { class: "trust-map" });
  private readonly legend = html("ul", { class: "trust-legend" });
  private readonly note = html("p", { class: "hint" });
  private phi = 90;
  private wanted = 0;

  constructor(
    place: HTMLElement,
    private readonly model: Model,
    private readonly complain: (message: string) => void,
  ) {
    place.append(
      html(
        "div",
        { class: "row" },
        slider("phi_d", { min: 0, max: 175, step: 5, value: 90, unit: "°" }, (value) => {
          this.phi = value;
          void this.load();
        }),
      ),
      this.map,
      this.legend,
      this.note,
    );
    model.on(
      ["active", "entries"],
      whenShown(place, () => void this.load()),
    );
  }

  private async load(): Promise<void> {
    const entry = this.model.active;
    const turn = ++this.wanted;
    if (!entry?.samples) {
      this.map.replaceChildren();
      this.legend.replaceChildren();
      this.note.textContent = entry ? "A table alone does not say where its values come from." : "";
      return;
    }
    try {
      const plane = await api.trust(entry.id, this.phi);
      if (turn === this.wanted) this.draw(plane);
    } catch (error) {
      this.complain((error as Error).message);
    }
  }

  private draw(plane: TrustPlane): void {
    const [columns, rows] = [plane.theta_h.length, plane.theta_d.length];
    const runs: SVGElement[] = [];
    // neighbours of one kind become one bar: hundreds of elements in place of thousands
    plane.code.forEach((line, j) => {
      let from = 0;
      for (let i = 1; i <= columns; i++) {
        const code = line[from]!;
        if (i < columns && line[i] === code) continue;
        if (code > 0) {
          const [x, y] = [from, rows - 1 - j];
          const fill = COLOURS[code - 1] ?? "none";
          runs.push(svg("rect", { x, y, width: i - from, height: 1, style: `fill:${fill}` }));
        }
        from = i;
      }
    });
    this.map.replaceChildren(
      svg(
        "svg",
        {
          viewBox: `-7 -1 ${columns + 9} ${rows + 9}`,
          class: "plot",
          role: "img",
          "aria-label": `trust map at phi_d = ${plane.phi_d} degrees: ${summary(plane)}`,
        },
        svg("rect", { x: 0, y: 0, width: columns, height: rows, class: "below" }),
        ...runs,
        ...axisTexts(columns, rows),
      ),
    );
    this.legend.replaceChildren(
      ...plane.names.map((name, n) => {
        const swatch = html("span", { class: "swatch", style: `background:${COLOURS[n] ?? ""}` });
        return html("li", {}, swatch, `${name}: ${percent(plane.shares[n] ?? 0)} of the domain`);
      }),
    );
    this.note.textContent = plane.definition;
  }
}

function percent(share: number): string {
  return `${(100 * share).toFixed(share < 0.1 ? 1 : 0)} %`;
}

function summary(plane: TrustPlane): string {
  return plane.names.map((name, n) => `${name} ${percent(plane.shares[n] ?? 0)}`).join(", ");
}

function axisTexts(columns: number, rows: number): SVGElement[] {
  const style = "font-size:2px";
  const text = (x: number, y: number, content: string, anchor = "middle") =>
    svg("text", { x, y, style, "text-anchor": anchor }, content);
  return [
    ...[0, 5, 15, 30, 60, 90].map((angle) =>
      text(Math.sqrt(angle / 90) * columns, rows + 3.4, `${angle}°`),
    ),
    ...[0, 30, 60, 90].map((angle) => text(-0.8, (1 - angle / 90) * rows + 1, `${angle}°`, "end")),
    text(columns / 2, rows + 7, "theta_h (square-root scale); upward theta_d"),
  ];
}
