/** The samples on two maps and in a list; the one that is chosen, in every detail. */

import type { Entry, SampleColumns, SampleDetail } from "../messages";
import { html } from "../plots/svg";
import { api } from "./api";
import type { Model } from "./model";
import { SampleMap, type ColourBy, type MapKind } from "./sample_map";
import { figure, pairs, select } from "./widgets";

const MOST_LISTED = 300;

export class SamplesPanel {
  private readonly maps: SampleMap[];
  private readonly list = html("div", { class: "outlier-list" });
  private readonly detail = html("div", { class: "detail", "aria-live": "polite" });
  private readonly note = html("p", { class: "hint" });
  private columns: SampleColumns | null = null;
  private colour: ColourBy = "residual";
  private shownFor: string | null = null;
  private drawing = false;

  constructor(
    place: HTMLElement,
    private readonly model: Model,
    private readonly complain: (message: string) => void,
  ) {
    const make = (kind: MapKind) => new SampleMap(kind, (sample) => model.choose(sample));
    this.maps = [make("half"), make("hemisphere")];
    const colour = select(
      "Colour by",
      [
        ["residual", "residual"],
        ["value", "value"],
        ["weight", "weight"],
      ],
      this.colour,
      (name) => {
        this.colour = name as ColourBy;
        this.draw();
      },
    );
    place.append(
      html("div", { class: "row" }, colour.parentElement!),
      html("div", { class: "maps" }, ...this.maps.map((map) => map.element)),
      this.note,
      html("div", { class: "columns" }, this.list, this.detail),
    );
    model.on(["active", "entries"], () => void this.load());
    model.on(["chosen"], () => {
      this.draw();
      void this.showDetail();
    });
    model.on(["switches"], () => {
      this.draw();
      this.drawList();
      void this.showDetail();
    });
    model.on(["theme"], () => this.draw());
  }

  private async load(): Promise<void> {
    const entry = this.model.active;
    if (entry?.id === this.shownFor) return;
    this.shownFor = entry?.id ?? null;
    this.columns = null;
    if (entry?.samples) {
      try {
        const columns = await api.samples(entry.id);
        if (this.shownFor !== entry.id) return;
        this.columns = columns;
      } catch (error) {
        this.complain((error as Error).message);
      }
    }
    this.note.textContent = this.describe(entry);
    this.draw();
    this.drawList();
  }

  private describe(entry: Entry | null): string {
    if (!entry) return "";
    const samples = entry.samples;
    if (!samples) return "A table alone: no samples of it are known.";
    const off = samples.rejected ? `, ${samples.rejected} switched off` : "";
    const more = this.columns?.left_out
      ? `; ${this.columns.left_out} more are not drawn, no outlier among them`
      : "";
    return (
      `${samples.source}: ${samples.count} samples, ${samples.used} used${off}, ` +
      `${samples.outliers} taken for outliers${more}. ${samples.convention}`
    );
  }

  /** Draw the maps before the next frame, however often that is asked for. */
  private draw(): void {
    if (this.drawing) return;
    this.drawing = true;
    requestAnimationFrame(() => {
      this.drawing = false;
      this.drawMaps();
    });
  }

  private drawMaps(): void {
    const entry = this.model.active;
    const switches = entry ? this.model.switchesOf(entry.id) : new Map<number, boolean>();
    for (const map of this.maps) {
      map.element.hidden = this.columns === null;
      map.draw(this.columns, this.colour, this.model.chosen, switches);
    }
  }

  private drawList(): void {
    const columns = this.columns;
    if (!columns) {
      this.list.replaceChildren();
      return;
    }
    const size = (n: number) => Math.abs(columns.residual[n] ?? 0);
    const outliers = columns.sample
      .map((_, n) => n)
      .filter((n) => columns.outlier[n] || !columns.used[n])
      .sort((a, b) => size(b) - size(a));
    const rows = outliers.slice(0, MOST_LISTED).map((n) => this.listRow(columns, n));
    const more = outliers.length - rows.length;
    this.list.replaceChildren(
      html("h3", {}, "Outliers and unused samples, largest residual first"),
      rows.length
        ? html(
            "table",
            {},
            html(
              "thead",
              {},
              html(
                "tr",
                {},
                ...["row", "ln(value / result)", "weight", ""].map((name) =>
                  html("th", { scope: "col" }, name),
                ),
              ),
            ),
            html("tbody", {}, ...rows),
          )
        : html("p", {}, "There are none."),
      more > 0 ? html("p", { class: "hint" }, `and ${more} more`) : "",
    );
  }

  private listRow(columns: SampleColumns, n: number): HTMLTableRowElement {
    const sample = columns.sample[n]!;
    const pick = html(
      "button",
      { type: "button", class: "link", "data-sample": sample },
      `row ${columns.row[n]}`,
    );
    pick.onclick = () => this.model.choose(sample);
    const used = columns.used[n]!;
    return html(
      "tr",
      {},
      html("td", {}, pick),
      html("td", {}, figure(columns.residual[n], 3)),
      html("td", {}, columns.weight[n]?.toFixed(2) ?? "–"),
      html("td", {}, used ? "outlier" : "unused"),
    );
  }

  private async showDetail(): Promise<void> {
    const entry = this.model.active;
    const sample = this.model.chosen;
    if (!entry || sample === null) {
      this.detail.replaceChildren(
        html(
          "p",
          { class: "hint" },
          entry?.samples ? "Choose a sample on a map or in the list." : "",
        ),
      );
      return;
    }
    try {
      const detail = await api.sample(entry.id, sample);
      if (this.model.chosen !== sample || this.model.active !== entry) return;
      this.detail.replaceChildren(...this.detailNodes(entry, detail));
    } catch (error) {
      this.complain((error as Error).message);
    }
  }

  private detailNodes(entry: Entry, detail: SampleDetail): Node[] {
    const isOff = detail.rejected;
    const wanted = this.model.switchesOf(entry.id).get(detail.sample) ?? isOff;
    const flip = html(
      "button",
      { type: "button", class: "switch", "aria-pressed": String(!wanted) },
      wanted ? "Switch on" : "Switch off",
    );
    flip.onclick = () => this.model.setSwitch(detail.sample, !wanted, isOff);
    const note = wanted === isOff ? "" : " counts from the next fit on";
    const verdict = detail.outlier ? "outlier" : detail.rejected ? "switched off" : "believed";
    const degrees = (value: number | null) => `${figure(value, 4)}°`;
    return [
      html("h3", {}, `Row ${detail.row} of ${detail.source}: ${verdict}`),
      html("p", {}, flip, html("em", {}, note)),
      detail.line === null
        ? html(
            "p",
            { class: "hint" },
            "The row itself cannot be shown: the file is not text, or not at hand.",
          )
        : html(
            "pre",
            {
              class: "line",
              tabindex: 0,
              "aria-label": `row ${detail.row} as it stands in the file`,
            },
            detail.header ? html("span", { class: "faint" }, `${detail.header}\n`) : "",
            detail.line,
          ),
      pairs([
        ["light", `${degrees(detail.theta_i)}, azimuth ${degrees(detail.phi_i)}`],
        ["detector", `${degrees(detail.theta_o)}, azimuth ${degrees(detail.phi_o)}`],
        [
          "half/difference",
          `${degrees(detail.theta_h)}, ${degrees(detail.theta_d)}, ${degrees(detail.phi_d)}`,
        ],
        ["weight", detail.weight?.toFixed(3) ?? "–"],
        ["flags", detail.flags.join(", ") || "none"],
      ]),
      channelTable(detail),
      detail.band ? html("p", { class: "hint" }, `No 95 % band: ${detail.band}.`) : "",
      detail.prediction ? html("p", { class: "hint" }, `Predictions: ${detail.prediction}.`) : "",
    ].filter((node): node is HTMLElement => node !== "");
  }
}

function channelTable(detail: SampleDetail): HTMLElement {
  const heads = ["channel", "value", "prediction", "95 % band", "ln(value / result)", ""];
  return html(
    "div",
    { class: "scroll" },
    html(
      "table",
      {},
      html("thead", {}, html("tr", {}, ...heads.map((name) => html("th", { scope: "col" }, name)))),
      html(
        "tbody",
        {},
        ...detail.channels.map((one) => {
          const band = one.low === null ? "–" : `${figure(one.low, 3)} … ${figure(one.high, 3)}`;
          const outside =
            one.low !== null &&
            one.high !== null &&
            one.value !== null &&
            (one.value < one.low || one.value > one.high);
          return html(
            "tr",
            { class: outside ? "outside" : "" },
            html("th", { scope: "row" }, one.channel),
            html("td", {}, figure(one.value)),
            html("td", {}, figure(one.prediction)),
            html("td", {}, band),
            html("td", {}, figure(one.residual, 3)),
            html("td", {}, one.state === "used" ? "" : one.state),
          );
        }),
      ),
    ),
  );
}
