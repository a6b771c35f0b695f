/** Slices: a chosen incidence, straight and polar, with the band and the samples nearby. */

import type { SlicePanel } from "../messages";
import { polarPlot } from "../plots/polar";
import type { ScaleKind } from "../plots/scale";
import { slicePlot } from "../plots/slice";
import { html } from "../plots/svg";
import { api } from "./api";
import type { Model } from "./model";
import { whenShown } from "./tabs";
import { select, slider, toggle } from "./widgets";

export class SlicesPanel {
  private readonly plots = html("div", { class: "plots" });
  private readonly note = html("p", { class: "hint" });
  private readonly angles = html("span", { class: "angles" });
  private readonly light: HTMLLabelElement;
  private shownFor: string | null = null;
  private thetaI = 45;
  private phi = 180;
  private scale: ScaleKind = "log";
  private withOther = false;
  private shown: [SlicePanel, SlicePanel | undefined] | null = null;
  private wanted = 0;

  constructor(
    place: HTMLElement,
    private readonly model: Model,
    private readonly complain: (message: string) => void,
  ) {
    const scales = [
      ["log", "logarithmic"],
      ["linear", "linear"],
    ] as const;
    this.light = slider("Light at", { min: 0, max: 89, step: 1, value: 45, unit: "°" }, (value) => {
      this.thetaI = value;
      void this.load();
    });
    place.append(
      html(
        "div",
        { class: "row" },
        this.light,
        this.angles,
        slider("Plane", { min: 0, max: 180, step: 5, value: 180, unit: "°" }, (value) => {
          this.phi = value;
          void this.load();
        }),
        select("Scale", scales, this.scale, (name) => {
          this.scale = name as ScaleKind;
          this.draw();
        }).parentElement!,
        toggle("First entry dashed", false, (on) => {
          this.withOther = on;
          void this.load();
        }),
      ),
      this.plots,
      this.note,
    );
    model.on(
      ["active", "entries"],
      whenShown(place, () => void this.load()),
    );
    model.on(["chosen"], () => this.draw());
  }

  private async load(): Promise<void> {
    const entry = this.model.active;
    const turn = ++this.wanted;
    if (!entry) {
      this.shown = null;
      this.draw();
      return;
    }
    if (entry.id !== this.shownFor) this.offerAngles(entry.samples?.incidences ?? [], entry.id);
    const first = this.model.entries[0];
    const other = this.withOther && first && first.id !== entry.id ? first : null;
    try {
      const panels = await Promise.all([
        api.slice(entry.id, this.thetaI, this.phi),
        other ? api.slice(other.id, this.thetaI, this.phi) : undefined,
      ]);
      if (turn !== this.wanted) return;
      this.shown = panels;
      this.draw();
    } catch (error) {
      this.complain((error as Error).message);
    }
  }

  /** Offer the angles at which samples lie, and begin with one of them. */
  private offerAngles(angles: readonly number[], id: string): void {
    const before = this.shownFor;
    this.shownFor = id;
    const buttons = angles.map((angle) => {
      const button = html("button", { type: "button", class: "small" }, `${angle}°`);
      button.onclick = () => {
        this.setAngle(angle);
        void this.load();
      };
      return button;
    });
    this.angles.replaceChildren(...(buttons.length ? ["measured at ", ...buttons] : []));
    if (before === null && angles.length) this.setAngle(angles[Math.floor(angles.length / 2)]!);
  }

  private setAngle(angle: number): void {
    const input = this.light.querySelector("input")!;
    input.value = String(Math.round(angle));
    this.thetaI = Number(input.value);
    this.light.querySelector("output")!.textContent = `${input.value} °`;
  }

  private draw(): void {
    if (!this.shown) {
      this.plots.replaceChildren();
      this.note.textContent = "";
      return;
    }
    const [panel, other] = this.shown;
    const options = {
      scale: this.scale,
      other,
      chosen: this.model.chosen,
      onPick: (sample: number) => this.model.choose(sample),
    };
    this.plots.replaceChildren(slicePlot(panel, options), polarPlot(panel, options));
    const banded = panel.curves.some((curve) => curve.low !== null);
    const band = banded ? "The band holds 95 %." : "No band: no uncertainty is stated.";
    if (!this.model.active?.samples) {
      this.note.textContent = `A table alone: no measurements are known. ${band}`;
      return;
    }
    const left = panel.points_left_out ? `, ${panel.points_left_out} more not drawn` : "";
    this.note.textContent =
      `${panel.points.length} measured values within 3° of the light's angle and 5° of the plane` +
      `${left}. ${band}`;
  }
}
