/** Tabs by the book: arrow keys move, Home and End jump, one panel shows. */

import { html } from "../plots/svg";

export type Tab = readonly [id: string, title: string, fill: (body: HTMLElement) => void];

const SHOWN = "brdfit-shown";

/** Return a function that does `work` at once while `body` shows, else when it next does. */
export function whenShown(body: HTMLElement, work: () => void): () => void {
  let waits = false;
  body.addEventListener(SHOWN, () => {
    if (waits) work();
    waits = false;
  });
  return () => {
    if (body.hidden) waits = true;
    else work();
  };
}

/** Fill `place` with a list of tabs and their panels; the first one shows. */
export function tabs(place: HTMLElement, all: readonly Tab[]): void {
  const list = html("div", { role: "tablist", "aria-label": "Panels" });
  const heads = all.map(([id, title]) =>
    html(
      "button",
      { type: "button", role: "tab", id: `tab-${id}`, "aria-controls": `panel-${id}` },
      title,
    ),
  );
  const bodies = all.map(([id]) =>
    html("div", {
      role: "tabpanel",
      id: `panel-${id}`,
      "aria-labelledby": `tab-${id}`,
      class: "panel",
    }),
  );
  const show = (n: number) => {
    heads.forEach((head, k) => {
      head.setAttribute("aria-selected", String(k === n));
      head.tabIndex = k === n ? 0 : -1;
      bodies[k]!.hidden = k !== n;
    });
    bodies[n]!.dispatchEvent(new Event(SHOWN));
  };
  heads.forEach((head, n) => {
    head.onclick = () => show(n);
    head.onkeydown = (event) => {
      const count = heads.length;
      const moves: Record<string, number> = {
        ArrowRight: (n + 1) % count,
        ArrowLeft: (n + count - 1) % count,
        Home: 0,
        End: count - 1,
      };
      const to = moves[event.key];
      if (to === undefined) return;
      event.preventDefault();
      show(to);
      heads[to]!.focus();
    };
  });
  list.append(...heads);
  place.append(list, ...bodies);
  all.forEach(([, , fill], n) => fill(bodies[n]!));
  show(0);
}
