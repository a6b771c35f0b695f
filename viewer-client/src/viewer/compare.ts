/** One entry against another: the table of metrics. */

import type { ComparisonTable } from "../messages";
import { html } from "../plots/svg";
import { api } from "./api";
import { titleOf, type Model } from "./model";
import { select } from "./widgets";

export class ComparePanel {
  private readonly choices = html("div", { class: "row" });
  private readonly result = html("div", { "aria-live": "polite" });

  constructor(
    place: HTMLElement,
    private readonly model: Model,
  ) {
    place.append(this.choices, this.result);
    model.on(["entries"], () => this.offer());
  }

  private offer(): void {
    const entries = this.model.entries;
    this.result.replaceChildren();
    if (entries.length < 2) {
      this.choices.replaceChildren(
        html("p", { class: "hint" }, "Open a second table, or fit by another method, to compare."),
      );
      return;
    }
    const options = entries.map((entry) => [entry.id, titleOf(entry)] as const);
    const reference = select("Reference", options, entries[0]!.id, () => {});
    const test = select("Test", options, entries[1]!.id, () => {});
    const go = html("button", { type: "button", class: "primary" }, "Compare");
    go.onclick = () => void this.compare(reference.value, test.value, go);
    this.choices.replaceChildren(reference.parentElement!, test.parentElement!, go);
  }

  private async compare(reference: string, test: string, go: HTMLButtonElement): Promise<void> {
    go.disabled = true;
    this.result.replaceChildren(html("p", {}, "Comparing…"));
    try {
      this.result.replaceChildren(...rendered(await api.comparison(reference, test)));
    } catch (error) {
      this.result.replaceChildren(html("p", { class: "problem" }, (error as Error).message));
    } finally {
      go.disabled = false;
    }
  }
}

function rendered(table: ComparisonTable): HTMLElement[] {
  const heads = ["metric", "where", "figure", "better"];
  return [
    html(
      "table",
      { class: "metrics" },
      html("thead", {}, html("tr", {}, ...heads.map((name) => html("th", { scope: "col" }, name)))),
      html(
        "tbody",
        {},
        ...table.rows.map((row) =>
          html(
            "tr",
            { "data-metric": `${row.name}/${row.where}` },
            html("th", { scope: "row" }, row.title),
            html("td", {}, row.where),
            html("td", {}, `${row.text} ${row.unit}`),
            html("td", {}, row.higher_is_better ? "higher" : "lower"),
          ),
        ),
      ),
    ),
    ...table.notes.map((note) => html("p", { class: "hint" }, note)),
  ];
}
