/** Fits that run: their progress, a button to stop each, and what came of them. */

import type { Job } from "../messages";
import { html } from "../plots/svg";
import { api } from "./api";

export interface Offer {
  readonly title: string;
  readonly act: () => void;
}

export class JobTray {
  constructor(
    private readonly place: HTMLElement,
    private readonly finished: (job: Job) => Promise<void>,
  ) {}

  /** Follow a job until it ends. */
  follow(id: string): void {
    const bar = html("progress", { max: 1, "aria-label": "progress" });
    const title = html("strong", {}, "fit");
    const state = html("span", { class: "state" }, "waiting");
    const stop = html("button", { type: "button", class: "small" }, "Cancel");
    const card = html("div", { class: "job", "data-job": id }, title, state, bar, stop);
    this.place.append(card);
    const stopWatching = api.watch(id, (job) => {
      title.textContent = job.title;
      card.dataset["state"] = job.state;
      if (job.total > 0) bar.value = job.done / job.total;
      else bar.removeAttribute("value");
      const seconds = job.seconds >= 1 ? `, ${job.seconds.toFixed(0)} s` : "";
      state.textContent = job.state === "running" ? `${job.label}${seconds}` : job.state;
      if (job.state === "waiting" || job.state === "running") return;
      bar.remove();
      if (job.state === "done") {
        stop.remove();
        void this.finished(job).finally(() => card.remove());
        return;
      }
      stop.textContent = "Close";
      stop.onclick = () => card.remove();
      if (job.message) card.append(html("p", { class: "problem" }, job.message));
      if (job.state === "cancelled") setTimeout(() => card.remove(), 4000);
    });
    stop.onclick = () => {
      stop.disabled = true;
      api.cancel(id).catch(() => {
        stopWatching();
        card.remove();
      });
    };
  }

  /** Say what went wrong, until it is closed; `offer` is what can be done about it. */
  complain(message: string, offer?: Offer): void {
    const close = html("button", { type: "button", class: "small" }, "Close");
    const text = html("p", { class: "problem" }, message);
    const card = html("div", { class: "job", role: "alert" }, text, close);
    close.onclick = () => card.remove();
    if (offer) {
      const act = html("button", { type: "button", class: "small" }, offer.title);
      act.onclick = () => {
        card.remove();
        offer.act();
      };
      close.before(act);
    }
    this.place.append(card);
  }
}
