/** The viewer: what the page consists of, and how its parts hear of each other. */

import type { Entry, Home, Job, Upload } from "../messages";
import { html } from "../plots/svg";
import { api, Refused } from "./api";
import { ComparePanel } from "./compare";
import { declareColumns } from "./declare";
import { FitPanel } from "./fit";
import { JobTray, type Offer } from "./jobs";
import { Model } from "./model";
import { SamplesPanel } from "./samples";
import { SlicesPanel } from "./slices";
import { Stage } from "./stage";
import { tabs } from "./tabs";
import { TrustPanel } from "./trust";

const place = (id: string) => document.getElementById(id)!;

/** What is wrong with a file that a person may put right by saying what its columns mean. */
const DECLARABLE = [
  "FormatError",
  "UnknownFormat",
  "NotThisFormat",
  "CorruptFile",
  "UsageError",
  "SampleError",
];

class Page {
  private readonly model: Model;
  private readonly tray: JobTray;
  private readonly chips = html("div", { class: "chips", role: "group", "aria-label": "Entries" });

  constructor(model: Model) {
    this.model = model;
    this.tray = new JobTray(place("jobs"), (job) => this.finished(job));
    const complain = (message: string) => this.tray.complain(message);
    place("bar").append(...this.bar());
    new Stage(place("stage"), model, complain);
    tabs(place("panels"), [
      ["samples", "Samples", (body) => new SamplesPanel(body, model, complain)],
      ["slices", "Slices", (body) => new SlicesPanel(body, model, complain)],
      ["trust", "Trust", (body) => new TrustPanel(body, model, complain)],
      ["compare", "Compare", (body) => new ComparePanel(body, model)],
      [
        "fit",
        "Fit and download",
        (body) => new FitPanel(body, model, (job) => this.tray.follow(job), complain),
      ],
    ]);
    model.on(["entries", "active"], () => this.drawChips());
    listenForDrops((file) => void this.take(file));
  }

  /** Show what was asked for, and follow the fits that began at the start. */
  async start(coming: readonly Promise<Entry | null>[]): Promise<void> {
    const found = await Promise.all(coming);
    this.model.open(found.filter((entry): entry is Entry => entry !== null));
    for (const job of this.model.home.jobs) this.tray.follow(job);
  }

  private bar(): Node[] {
    const file = html("input", { type: "file", hidden: true, id: "file" });
    file.onchange = () => {
      for (const one of file.files ?? []) void this.take(one);
      file.value = "";
    };
    const open = html("button", { type: "button" }, "Open a file…");
    open.onclick = () => file.click();
    const theme = html("button", { type: "button", "aria-label": "Dark or light" }, "◐");
    theme.onclick = () => {
      const dark = matchMedia("(prefers-color-scheme: dark)").matches;
      const now = document.documentElement.dataset["theme"] ?? (dark ? "dark" : "light");
      document.documentElement.dataset["theme"] = now === "dark" ? "light" : "dark";
      this.model.themeChanged();
    };
    matchMedia("(prefers-color-scheme: dark)").onchange = () => this.model.themeChanged();
    return [
      html("h1", {}, "brdfit"),
      this.chips,
      html("span", { class: "space" }),
      open,
      file,
      theme,
    ];
  }

  private drawChips(): void {
    const { entries, activeId } = this.model;
    this.chips.replaceChildren(...entries.map((entry, n) => this.chip(entry, n, activeId)));
    document.title = this.model.active ? `${this.model.active.name} – brdfit` : "brdfit";
  }

  private chip(entry: Entry, n: number, activeId: string | null): HTMLElement {
    const show = html(
      "button",
      { type: "button", "aria-pressed": String(entry.id === activeId), "data-entry": entry.id },
      entry.name,
      html("small", {}, entry.fit ? ` ${entry.fit.method}` : ` ${entry.kind}`),
    );
    show.onclick = () => this.model.activate(entry.id);
    const first = html(
      "button",
      {
        type: "button",
        class: "small",
        title: "make it the first: the reference",
        hidden: n === 0,
      },
      "↤",
    );
    first.setAttribute("aria-label", `make ${entry.name} the reference`);
    first.onclick = () => this.model.promote(entry.id);
    const close = html("button", { type: "button", class: "small" }, "×");
    close.setAttribute("aria-label", `close ${entry.name}`);
    close.onclick = () => this.model.remove(entry.id);
    return html("span", { class: "chip" }, show, first, close);
  }

  private async take(file: File): Promise<void> {
    if (file.size > this.model.home.upload_limit) {
      const limit = this.model.home.upload_limit >> 20;
      this.tray.complain(`${file.name}: is larger than the ${limit} MB that can be dropped here.`);
      return;
    }
    const declare = (why: string) => ({
      title: "Say what its columns mean…",
      act: () => {
        const settings = this.model.home.reading;
        void declareColumns(file, why, settings, (upload) => void this.taken(upload, declare));
      },
    });
    try {
      await this.taken(await api.upload(file, {}), declare);
    } catch (error) {
      const { message } = error as Error;
      const readable = error instanceof Refused && DECLARABLE.includes(error.kind);
      this.tray.complain(message, readable ? declare(message) : undefined);
    }
  }

  /** Show a table that was read, or fit measurements. */
  private async taken(upload: Upload, declare: (why: string) => Offer): Promise<void> {
    try {
      for (const warning of upload.warnings) this.tray.complain(warning, declare(warning));
      if (upload.entry) this.model.add(await api.entry(upload.entry));
      else this.tray.follow((await api.fit({ source: upload.id })).id);
    } catch (error) {
      this.tray.complain((error as Error).message);
    }
  }

  private async finished(job: Job): Promise<void> {
    if (!job.entry) return;
    try {
      this.model.add(await api.entry(job.entry), job.replaces);
    } catch (error) {
      this.tray.complain((error as Error).message);
    }
  }
}

function listenForDrops(take: (file: File) => void): void {
  const veil = place("drop");
  const files = (event: DragEvent) => event.dataTransfer?.types.includes("Files") ?? false;
  addEventListener("dragover", (event) => {
    if (!files(event)) return;
    event.preventDefault();
    veil.hidden = false;
  });
  addEventListener("dragleave", (event) => {
    if (event.relatedTarget === null) veil.hidden = true;
  });
  addEventListener("drop", (event) => {
    veil.hidden = true;
    if (!files(event)) return;
    event.preventDefault();
    for (const file of event.dataTransfer?.files ?? []) take(file);
  });
}

/** Ask for what the address names, else for what was opened at the start, tables included. */
function askFor(home: Home): Promise<Entry | null>[] {
  const named = location.hash.slice(1).split(",").filter(Boolean);
  return (named.length ? named : home.entries).map((id) => {
    api.tableAhead(id);
    return api.entry(id).catch(() => null);
  });
}

async function start(): Promise<void> {
  try {
    const home = await api.home();
    const coming = askFor(home);
    await new Page(new Model(home)).start(coming);
  } catch (error) {
    const text = error instanceof Refused ? error.message : String(error);
    document.body.replaceChildren(html("p", { class: "problem", role: "alert" }, text));
    if (!(error instanceof Refused)) throw error;
  }
}

void start();
