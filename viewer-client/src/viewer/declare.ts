/** Asks what the columns of a file mean, where the file does not say it. */

import type { Setting, Upload } from "../messages";
import { html } from "../plots/svg";
import { api } from "./api";
import { select } from "./widgets";

/** Asked first; everything else stands under "More". */
const FIRST = ["directions", "values", "angles"];
const LINES = 12;
const LONGEST = 160;

/** Open the form; `done` is told of what could be read. */
export async function declareColumns(
  file: File,
  why: string,
  settings: readonly Setting[],
  done: (upload: Upload) => void,
): Promise<void> {
  const dialog = html("dialog", { class: "declare", "aria-labelledby": "declare-title" });
  const problem = html("p", { class: "problem", role: "alert" }, why);
  const values = new Map<string, () => string>();
  const fields = (wanted: boolean) =>
    settings
      .filter((one) => FIRST.includes(one.name) === wanted)
      .sort((a, b) => FIRST.indexOf(a.name) - FIRST.indexOf(b.name))
      .map((one) => field(one, values));
  const read = html("button", { type: "submit", class: "primary" }, "Read it");
  const cancel = html("button", { type: "button" }, "Cancel");
  cancel.onclick = () => dialog.close();
  const form = html(
    "form",
    { class: "refit" },
    html("div", { class: "settings" }, ...fields(true)),
    html(
      "details",
      {},
      html("summary", {}, "More"),
      html("div", { class: "settings" }, ...fields(false), others(values)),
    ),
    html("div", { class: "row" }, read, cancel),
  );
  form.onsubmit = (event) => {
    event.preventDefault();
    void send();
  };
  const send = async () => {
    read.disabled = true;
    try {
      const upload = await api.upload(file, given(values));
      dialog.close();
      done(upload);
    } catch (error) {
      problem.textContent = (error as Error).message;
    } finally {
      read.disabled = false;
    }
  };
  dialog.append(
    html("h2", { id: "declare-title" }, `What do the columns of ${file.name} mean?`),
    problem,
    await beginning(file),
    form,
  );
  dialog.onclose = () => dialog.remove();
  document.body.append(dialog);
  dialog.showModal();
}

/** Return the texts of the fields that were filled in. */
function given(values: ReadonlyMap<string, () => string>): Record<string, string> {
  const found: Record<string, string> = {};
  for (const [name, value] of values) {
    const text = value().trim();
    if (!text) continue;
    if (name !== "") {
      found[name] = text;
      continue;
    }
    for (const line of text.split("\n")) {
      const [key = "", ...rest] = line.split("=");
      if (key.trim()) found[key.trim()] = rest.join("=");
    }
  }
  return found;
}

function field(setting: Setting, values: Map<string, () => string>): HTMLElement {
  const name = setting.name.replace("_", " ");
  const help = html("small", {}, setting.help);
  if (setting.kind === "flag") {
    const box = html("input", { type: "checkbox", name: setting.name });
    values.set(setting.name, () => (box.checked ? "true" : ""));
    return html("label", { class: "toggle" }, box, html("span", {}, name), help);
  }
  if (setting.kind === "choice") {
    const options = ["", ...setting.choices].map((one) => [one, one || "not said"] as const);
    const box = select(name, options, "", () => {});
    box.name = setting.name;
    values.set(setting.name, () => box.value);
    box.parentElement!.append(help);
    return box.parentElement!;
  }
  const type = setting.kind === "number" ? "number" : "text";
  const box = html("input", { type, step: "any", name: setting.name, autocomplete: "off" });
  values.set(setting.name, () => box.value);
  return html("label", {}, html("span", {}, name), box, help);
}

function others(values: Map<string, () => string>): HTMLElement {
  const box = html("textarea", { rows: 2, name: "others", placeholder: "delimiter=;" });
  values.set("", () => box.value);
  const help = html("small", {}, "Options of one format's reader alone, NAME=VALUE, one a line.");
  return html("label", {}, html("span", {}, "others"), box, help);
}

/** Return the first lines of a file, with their numbers, or why there are none. */
async function beginning(file: File): Promise<HTMLElement> {
  const text = await file.slice(0, LINES * 2000).text();
  if (text.includes("\0")) {
    return html("p", { class: "hint" }, "The file is not text: name its columns if it has names.");
  }
  const lines = text.split(/\r\n|\r|\n/).slice(0, LINES);
  const shown = lines.map((line, n) => {
    const cut = line.length > LONGEST ? `${line.slice(0, LONGEST)}…` : line;
    return `${String(n + 1).padStart(2)}  ${cut}`;
  });
  return html(
    "pre",
    { class: "line", tabindex: 0, "aria-label": "the first lines of the file" },
    shown.join("\n"),
  );
}
