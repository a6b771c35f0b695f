/** The picture: canvas, light, exposure, and the hand that turns them. */

import type { Entry, LightSet } from "../messages";
import { html } from "../plots/svg";
import { Material } from "../render/material";
import { Renderer, type Scene, type Settled } from "../render/renderer";
import { lightForHighlight, type Orbit, type Vec3 } from "../render/vectors";
import { api } from "./api";
import { titleOf, type Model } from "./model";
import { select, slider, toggle } from "./widgets";

const POINT = "point";
const STILL_AFTER = 160;
const START: Orbit = { yaw: 0, pitch: 0 };
// Where the light of brdfit.render.point, 30 degrees off the axis, is mirrored: at 15 degrees.
const FIRST_HIGHLIGHT = [
  -Math.sin(Math.PI / 12) / Math.SQRT2,
  Math.sin(Math.PI / 12) / Math.SQRT2,
] as const;

export class Stage {
  private readonly canvas = html("canvas", {
    tabindex: 0,
    role: "img",
    "aria-label": "rendered material",
    "aria-describedby": "keys",
  });
  private readonly labels = html("div", { class: "labels", "aria-hidden": "true" });
  private readonly message = html("p", { class: "stage-message", role: "status" });
  private readonly lightHandle = html("div", { class: "light-handle", "aria-hidden": "true" });
  private readonly renderer: Renderer | null;
  private readonly materials = new Map<string, Material>();
  private readonly lights: Map<string, LightSet>;
  private readonly lightSelect: HTMLSelectElement;
  private light = "studio";
  private orbit: Orbit = START;
  private highlight: readonly [number, number] = FIRST_HIGHLIGHT;
  private shape: Scene["shape"] = "sphere";
  private difference = false;
  private stops = 0;
  private timer = 0;
  private generation = 0;
  /** Pictures put on the screen so far. */
  private frames = 0;
  private cell: Settled["cells"][number] | null = null;

  constructor(
    private readonly place: HTMLElement,
    private readonly model: Model,
    private readonly complain: (message: string) => void,
  ) {
    this.lights = new Map(model.home.lights.map((one) => [one.name, one]));
    this.lightSelect = this.makeLightSelect();
    const frame = html("div", { class: "frame" }, this.canvas, this.labels, this.lightHandle);
    place.append(frame, this.message, this.controls());
    this.renderer = this.makeRenderer();
    this.listen(frame);
    model.on(["entries"], () => void this.load());
    model.on(["active"], () => this.drawLabels());
  }

  private makeRenderer(): Renderer | null {
    try {
      const renderer = new Renderer(this.canvas);
      renderer.onPresented = () => {
        this.canvas.dataset["presented"] ??= performance.now().toFixed(0);
        this.canvas.dataset["frames"] = String(++this.frames);
      };
      renderer.onSettled = (state) => this.settled(state);
      return renderer;
    } catch (error) {
      this.message.textContent = (error as Error).message;
      return null;
    }
  }

  private makeLightSelect(): HTMLSelectElement {
    const options = [...this.lights.values()].map((one) => [one.name, one.title] as const);
    return select("Light", options, this.light, (name) => {
      this.light = name;
      this.draw({ expose: true });
    });
  }

  private controls(): HTMLElement {
    const file = html("input", { type: "file", accept: ".exr,.hdr,.png,.jpg,.jpeg", hidden: true });
    file.onchange = () => void this.takeEnvironment(file);
    const environment = html("button", { type: "button" }, "Environment map…");
    environment.onclick = () => file.click();
    const reset = html("button", { type: "button" }, "Reset view");
    reset.onclick = () => this.reset();
    return html(
      "div",
      { class: "controls", role: "toolbar", "aria-label": "Picture" },
      select(
        "Shape",
        [
          ["sphere", "sphere"],
          ["ball", "material ball"],
        ],
        this.shape,
        (name) => {
          this.shape = name as Scene["shape"];
          this.draw({ expose: true });
        },
      ).parentElement!,
      this.lightSelect.parentElement!,
      slider("Exposure", { min: -4, max: 6, step: 0.1, value: 0, unit: "stops" }, (value) => {
        this.stops = value;
        this.renderer?.setStops(value);
      }),
      toggle("Difference", this.difference, (on) => {
        this.difference = on;
        this.draw({});
      }),
      environment,
      file,
      reset,
      html(
        "p",
        { id: "keys", class: "hint" },
        "Drag, or use the arrow keys, to turn the light around the material; under the point " +
          "light, to move its highlight. + and - change the exposure, 0 resets.",
      ),
    );
  }

  private reset(): void {
    this.orbit = START;
    this.highlight = FIRST_HIGHLIGHT;
    this.draw({ expose: true });
  }

  private async takeEnvironment(input: HTMLInputElement): Promise<void> {
    const file = input.files?.[0];
    input.value = "";
    if (!file) return;
    try {
      const found = await api.environment(file);
      for (const warning of found.warnings) this.complain(warning);
      this.lights.set(found.name, found);
      const known = [...this.lightSelect.options].some((one) => one.value === found.name);
      if (!known) this.lightSelect.add(new Option(found.title, found.name));
      this.lightSelect.value = this.light = found.name;
      this.draw({ expose: true });
    } catch (error) {
      this.complain((error as Error).message);
    }
  }

  private async load(): Promise<void> {
    const generation = ++this.generation;
    const wanted = new Set(this.model.entries.map((entry) => entry.id));
    for (const [id, material] of this.materials) {
      if (wanted.has(id)) continue;
      material.free();
      this.materials.delete(id);
    }
    this.message.textContent = wanted.size ? "" : "Nothing to show yet: open or drop a file.";
    const missing = this.model.entries.filter((entry) => !this.materials.has(entry.id));
    try {
      await Promise.all(missing.map((entry) => this.fetchMaterial(entry)));
    } catch (error) {
      this.complain((error as Error).message);
    }
    if (generation !== this.generation) return;
    this.resize();
    this.draw({ expose: true });
  }

  private async fetchMaterial(entry: Entry): Promise<void> {
    if (!this.renderer) return;
    const plain = await api.table(entry.id);
    const [h = 0, d = 0, p = 0] = entry.grid;
    const shape = { grid: [h, d, p] as const, scale: entry.scale };
    const material = new Material(this.renderer.context, shape, plain);
    this.materials.set(entry.id, material);
    void api.albedo(entry.id).then((albedo) => {
      material.setAlbedo(albedo.value);
      if (this.currentLights().surround.some((one) => one > 0)) this.draw({ expose: true });
    });
  }

  private currentLights(): LightSet {
    const found = this.lights.get(this.light)!;
    if (this.light !== POINT) return found;
    return { ...found, direction: [[...this.pointDirection()]] };
  }

  private pointDirection(): Vec3 {
    return lightForHighlight(...this.highlight);
  }

  private draw(options: { moving?: boolean; expose?: boolean }): void {
    delete this.canvas.dataset["settled"];
    if (!this.renderer) return;
    const materials = this.model.entries.flatMap((entry) => this.materials.get(entry.id) ?? []);
    const point = this.light === POINT;
    this.renderer.show(
      {
        materials,
        lights: this.currentLights(),
        orbit: point && this.shape === "sphere" ? START : this.orbit,
        shape: this.shape,
        difference: this.difference,
        stops: this.stops,
      },
      options,
    );
    window.clearTimeout(this.timer);
    if (options.moving) {
      this.timer = window.setTimeout(() => this.draw({ expose: false }), STILL_AFTER);
    }
  }

  private settled(state: Settled): void {
    this.cell = state.cells[0] ?? null;
    this.canvas.dataset["settled"] = String(this.generation);
    this.canvas.dataset["exposure"] = state.exposure.toPrecision(8);
    if (state.difference === null) delete this.canvas.dataset["difference"];
    else this.canvas.dataset["difference"] = state.difference.toFixed(4);
    this.canvas.dataset["cells"] = JSON.stringify(state.cells);
    this.drawLabels(state);
  }

  private lastState: Settled | null = null;

  private drawLabels(state: Settled | null = this.lastState): void {
    this.lastState = state;
    if (!state) return;
    const ratio = this.canvas.width / Math.max(this.canvas.clientWidth, 1);
    const names = this.model.entries.map(titleOf);
    if (state.cells.length > names.length) {
      const mean = state.difference === null ? "" : ` ${state.difference.toFixed(2)} on average`;
      names.push(`ΔE00${mean}; yellow: 10`);
    }
    this.labels.replaceChildren(
      ...state.cells.map((cell, n) => {
        const top = (this.canvas.height - cell.y - cell.height) / ratio;
        const style = `left:${cell.x / ratio}px;top:${top}px;` + `width:${cell.width / ratio}px;`;
        const active = this.model.entries[n]?.id === this.model.activeId;
        return html("span", { style, class: active ? "active" : "" }, names[n] ?? "");
      }),
    );
    this.canvas.setAttribute("aria-label", `rendered: ${names.join("; ")}`);
    const handle = this.lightHandle.style;
    const cell = state.cells[0];
    const marked = this.light === POINT && this.shape === "sphere";
    handle.display = marked && cell ? "block" : "none";
    if (cell) {
      const [x, y] = this.highlight;
      const top = this.canvas.height - cell.y - cell.centreY;
      handle.left = `${(cell.x + cell.centreX + x * cell.radius) / ratio}px`;
      handle.top = `${(top - y * cell.radius) / ratio}px`;
    }
  }

  private listen(frame: HTMLElement): void {
    let held: readonly [number, number] | null = null;
    this.canvas.addEventListener("pointerdown", (event) => {
      held = [event.clientX, event.clientY];
      this.canvas.setPointerCapture(event.pointerId);
      if (this.light === POINT) this.touch(event);
    });
    this.canvas.addEventListener("pointermove", (event) => {
      if (!held) return;
      if (this.light === POINT) {
        this.touch(event);
        return;
      }
      const [x, y] = held;
      held = [event.clientX, event.clientY];
      this.turn((event.clientX - x) * 0.01, (event.clientY - y) * 0.01);
    });
    const release = () => (held = null);
    this.canvas.addEventListener("pointerup", release);
    this.canvas.addEventListener("pointercancel", release);
    this.canvas.addEventListener("keydown", (event) => this.key(event));
    new ResizeObserver(() => {
      if (this.resize()) this.draw({ moving: true });
    }).observe(frame);
  }

  private touch(event: PointerEvent): void {
    const ratio = this.canvas.width / Math.max(this.canvas.clientWidth, 1);
    const box = this.canvas.getBoundingClientRect();
    const cell = this.cell;
    if (!cell) return;
    const x = (event.clientX - box.left) * ratio;
    const y = this.canvas.height - (event.clientY - box.top) * ratio;
    const inCell = [(x % cell.width) - cell.centreX, (y % cell.height) - cell.centreY] as const;
    this.moveHighlight(inCell[0] / cell.radius, inCell[1] / cell.radius);
  }

  private moveHighlight(x: number, y: number): void {
    const far = Math.max(1, Math.hypot(x, y) / 0.98);
    this.highlight = [x / far, y / far];
    this.draw({ moving: true });
    this.drawLabels();
  }

  private turn(yaw: number, pitch: number): void {
    const limit = Math.PI / 2;
    this.orbit = {
      yaw: this.orbit.yaw + yaw,
      pitch: Math.max(-limit, Math.min(limit, this.orbit.pitch + pitch)),
    };
    this.draw({ moving: true });
  }

  private key(event: KeyboardEvent): void {
    const step = event.shiftKey ? 0.3 : 0.08;
    const moves: Record<string, readonly [number, number]> = {
      ArrowLeft: [-step, 0],
      ArrowRight: [step, 0],
      ArrowUp: [0, step],
      ArrowDown: [0, -step],
    };
    const move = moves[event.key];
    if (move) {
      if (this.light === POINT)
        this.moveHighlight(this.highlight[0] + move[0], this.highlight[1] + move[1]);
      else this.turn(move[0], -move[1]);
    } else if (event.key === "+" || event.key === "-") {
      const range = this.place.querySelector<HTMLInputElement>("input[type=range]")!;
      range.value = String(Number(range.value) + (event.key === "+" ? 0.5 : -0.5));
      range.dispatchEvent(new Event("input"));
    } else if (event.key === "0") {
      this.reset();
    } else {
      return;
    }
    event.preventDefault();
  }

  private resize(): boolean {
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const width = Math.round(this.canvas.clientWidth * ratio);
    const height = Math.round(this.canvas.clientHeight * ratio);
    if (width < 2 || height < 2) return false;
    if (this.canvas.width === width && this.canvas.height === height) return false;
    this.canvas.width = width;
    this.canvas.height = height;
    return true;
  }
}
