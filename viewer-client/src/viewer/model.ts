/** What this tab looks at. Nothing here is the server's: two tabs never meet. */

import type { Entry, Home } from "../messages";

/** Return what to call an entry where several stand side by side. */
export function titleOf(entry: Entry): string {
  return entry.fit ? `${entry.name} · ${entry.fit.method}` : entry.name;
}

type Topic = "entries" | "active" | "chosen" | "switches" | "theme";

export class Model {
  entries: Entry[] = [];
  activeId: string | null = null;
  chosen: number | null = null;
  /** Samples that are switched off or on, and wait for the next fit, by entry. */
  private readonly switches = new Map<string, Map<number, boolean>>();
  private readonly listeners = new Map<Topic, (() => void)[]>();

  constructor(readonly home: Home) {}

  on(topics: readonly Topic[], listener: () => void): void {
    for (const topic of topics) {
      this.listeners.set(topic, [...(this.listeners.get(topic) ?? []), listener]);
    }
  }

  private tell(topic: Topic): void {
    for (const listener of this.listeners.get(topic) ?? []) listener();
  }

  get active(): Entry | null {
    return this.entries.find((entry) => entry.id === this.activeId) ?? null;
  }

  /** Show what there is at the start. */
  open(entries: readonly Entry[]): void {
    this.entries = [...entries];
    this.activeId = entries[0]?.id ?? null;
    this.changed();
  }

  /** Show an entry, in the place of the one that it is a refit of if that is shown. */
  add(entry: Entry, replaces: string | null = null): void {
    const at = this.entries.findIndex((one) => one.id === replaces);
    if (at >= 0) this.entries = this.entries.map((one, n) => (n === at ? entry : one));
    else this.entries = [...this.entries, entry];
    const chosen = at >= 0 && replaces === this.activeId ? this.chosen : null;
    this.activeId = entry.id;
    this.chosen = chosen;
    this.changed();
  }

  remove(id: string): void {
    this.entries = this.entries.filter((entry) => entry.id !== id);
    if (this.activeId === id) {
      this.activeId = this.entries[0]?.id ?? null;
      this.chosen = null;
    }
    this.changed();
  }

  /** Make an entry the first: the reference of every comparison. */
  promote(id: string): void {
    const first = this.entries.filter((entry) => entry.id === id);
    this.entries = [...first, ...this.entries.filter((entry) => entry.id !== id)];
    this.changed();
  }

  activate(id: string): void {
    if (id === this.activeId) return;
    this.activeId = id;
    this.chosen = null;
    this.tell("active");
    this.tell("chosen");
  }

  choose(sample: number | null): void {
    this.chosen = sample;
    this.tell("chosen");
  }

  /** Switch a sample of the active entry off or on; it counts from the next fit on. */
  setSwitch(sample: number, off: boolean, isOff: boolean): void {
    const entry = this.activeId;
    if (!entry) return;
    const own = this.switches.get(entry) ?? new Map<number, boolean>();
    if (off === isOff) own.delete(sample);
    else own.set(sample, off);
    this.switches.set(entry, own);
    this.tell("switches");
  }

  switchesOf(entry: string): ReadonlyMap<number, boolean> {
    return this.switches.get(entry) ?? new Map<number, boolean>();
  }

  themeChanged(): void {
    this.tell("theme");
  }

  private changed(): void {
    const ids = this.entries.map((entry) => entry.id).join(",");
    history.replaceState(null, "", ids ? `#${ids}` : location.pathname);
    this.tell("entries");
    this.tell("active");
    this.tell("chosen");
    this.tell("switches");
  }
}
