/** How an entry was made, fitting it again, and every format it can be downloaded in. */

import type { Entry, FitRequest, MethodInfo, Setting } from "../messages";
import { html } from "../plots/svg";
import { api } from "./api";
import type { Model } from "./model";
import { figure, pairs, select } from "./widgets";

type Value = number | boolean | string | null;

export class FitPanel {
  private readonly made = html("div", {});
  private readonly refit = html("form", { class: "refit" });
  private readonly downloads = html("div", { class: "downloads" });

  constructor(
    place: HTMLElement,
    private readonly model: Model,
    private readonly started: (job: string) => void,
    private readonly complain: (message: string) => void,
  ) {
    place.append(this.refit, this.made, this.downloads);
    model.on(["active", "entries"], () => this.draw());
    model.on(["switches"], () => this.drawSwitches());
  }

  private draw(): void {
    const entry = this.model.active;
    this.refit.replaceChildren(...(entry?.samples ? this.form(entry) : []));
    this.made.replaceChildren(...(entry ? howItWasMade(entry) : []));
    this.downloads.replaceChildren(...(entry ? downloads(entry) : []));
    this.drawSwitches();
  }

  private form(entry: Entry): Node[] {
    const methods = this.model.home.methods;
    const names = methods.map((one) => [one.name, one.name] as const);
    const current = entry.fit?.method ?? methods[0]?.name ?? "";
    const fields = html("div", { class: "settings" });
    const read = new Map<string, () => Value>();
    const fill = (name: string) => {
      const method = methods.find((one) => one.name === name);
      const own = name === entry.fit?.method ? entry.fit.settings : {};
      fields.replaceChildren(...(method ? this.settings(method, own, read) : []));
    };
    const method = select("Method", names, current, fill);
    fill(current);
    const side = html("input", { type: "checkbox" });
    const go = html("button", { type: "submit", class: "primary" }, "Fit again");
    this.refit.onsubmit = (event) => {
      event.preventDefault();
      const settings = Object.fromEntries([...read].map(([name, value]) => [name, value()]));
      void this.send(entry, { method: method.value, settings }, side.checked);
    };
    return [
      html("h3", {}, "Fit again"),
      html("p", { class: "switches" }),
      html("div", { class: "row" }, method.parentElement!, go),
      html(
        "label",
        { class: "toggle" },
        side,
        html("span", {}, "beside this one, not in its place"),
      ),
      html("details", {}, html("summary", {}, "Settings"), fields),
    ];
  }

  private settings(
    method: MethodInfo,
    own: Record<string, string>,
    read: Map<string, () => Value>,
  ): HTMLElement[] {
    read.clear();
    return method.settings.map((setting) => field(setting, own[setting.name], read));
  }

  private drawSwitches(): void {
    const entry = this.model.active;
    const place = this.refit.querySelector(".switches");
    if (!entry || !place) return;
    const switches = [...this.model.switchesOf(entry.id).values()];
    const off = switches.filter((one) => one).length;
    const on = switches.length - off;
    const parts = [off ? `${off} samples switched off` : "", on ? `${on} switched on` : ""];
    place.textContent = parts.filter(Boolean).join(", ");
  }

  private async send(
    entry: Entry,
    chosen: Pick<FitRequest, "method" | "settings">,
    beside: boolean,
  ): Promise<void> {
    const switches = [...this.model.switchesOf(entry.id)];
    try {
      const job = await api.fit({
        ...(chosen as Required<typeof chosen>),
        source: entry.id,
        rejected: switches.filter(([, off]) => off).map(([sample]) => sample),
        accepted: switches.filter(([, off]) => !off).map(([sample]) => sample),
        beside,
      });
      this.started(job.id);
    } catch (error) {
      this.complain((error as Error).message);
    }
  }
}

/** Return a labelled field of a form and note how its value is read. */
function field(
  setting: Setting,
  given: string | undefined,
  read: Map<string, () => Value>,
): HTMLElement {
  const start = given === undefined || given === "None" ? setting.default : given;
  const help = html("small", {}, setting.help);
  if (setting.kind === "flag") {
    const box = html("input", { type: "checkbox", checked: start === true || start === "True" });
    read.set(setting.name, () => box.checked);
    return html("label", { class: "toggle" }, box, html("span", {}, setting.name), help);
  }
  if (setting.kind === "choice") {
    const options = setting.choices.map((one) => [one, one] as const);
    const box = select(setting.name, options, String(start), () => {});
    read.set(setting.name, () => box.value);
    box.parentElement!.append(help);
    return box.parentElement!;
  }
  const number = setting.kind === "number" || setting.kind === "integer";
  const box = html("input", {
    type: number ? "number" : "text",
    step: setting.kind === "integer" ? 1 : "any",
    value: start === null ? "" : String(start),
  });
  read.set(setting.name, () => (box.value === "" ? null : number ? Number(box.value) : box.value));
  return html("label", {}, html("span", {}, setting.name), box, help);
}

function howItWasMade(entry: Entry): Node[] {
  const nodes: Node[] = [html("h3", {}, "How it was made")];
  const fit = entry.fit;
  const rows: [string, string][] = [
    ["grid", `${entry.grid.join(" × ")} (theta_h, theta_d, phi_d)`],
    [
      "channels",
      entry.channels.length > 6 ? `${entry.channels.length} bands` : entry.channels.join(", "),
    ],
  ];
  if (entry.conversion) rows.push(["shown", entry.conversion]);
  if (entry.missing)
    rows.push(["missing", `${entry.missing} cells hold nothing; shown as the nearest`]);
  if (fit) {
    rows.push(
      ["method", fit.method],
      ["population", fit.population || "none"],
      ["outcome", `${fit.outcome}. ${fit.advice}`],
      ["iterations", String(fit.iterations)],
      [
        "residuals",
        `median |ln(value / result)| ${figure(fit.residual_before, 3)} before, ` +
          `${figure(fit.residual_after, 3)} after`,
      ],
      ["outliers", fit.outlier_rule],
    );
  }
  nodes.push(pairs(rows));
  if (fit) {
    const settings = Object.entries(fit.settings);
    nodes.push(html("details", {}, html("summary", {}, "Settings of the fit"), pairs(settings)));
  }
  for (const warning of entry.warnings) nodes.push(html("p", { class: "warning" }, warning));
  return nodes;
}

function downloads(entry: Entry): Node[] {
  const links = entry.writable.map((one) =>
    html(
      "li",
      {},
      html(
        "a",
        {
          href: api.downloadAddress(entry.id, one.kind, one.format),
          download: "",
          "data-download": `${one.kind}/${one.format}`,
        },
        `${one.kind === "record" ? "" : `${one.kind}: `}${one.title} (${one.suffix})`,
      ),
      one.loses ? html("small", {}, ` loses ${one.loses}`) : "",
    ),
  );
  return [html("h3", {}, "Download"), html("ul", {}, ...links)];
}
