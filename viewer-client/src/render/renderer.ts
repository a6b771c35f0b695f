/** Draws materials side by side on one canvas: one light, one exposure, one view for all. */

import { materialBall } from "./ball";
import { contextOf, Program, Target, type GL } from "./gl";
import { cellsFor, Pace, type Cell } from "./layout";
import type { Material } from "./material";
import * as shaders from "./shaders";
import { apply, rotation, type Orbit } from "./vectors";

export interface Lights {
  readonly direction: readonly (readonly number[])[];
  readonly irradiance: readonly (readonly number[])[];
  readonly surround: readonly number[];
}

export interface Scene {
  readonly materials: readonly Material[];
  readonly lights: Lights;
  readonly orbit: Orbit;
  readonly shape: "sphere" | "ball";
  /** Show how the second of the materials differs from the first, in a picture of its own. */
  readonly difference: boolean;
  /** Stops of exposure, on top of what brings the 95th percentile to 0.8. */
  readonly stops: number;
}

export interface Settled {
  /** The factor from linear light to the screen, stops included. */
  readonly exposure: number;
  /** Mean Delta E00 over the disk, where a difference is shown. */
  readonly difference: number | null;
  readonly cells: readonly Cell[];
}

interface Images {
  readonly share: number;
  readonly normals: Target;
  readonly linear: Target[];
}

const LEVEL = 0.8;
const PERCENTILE = 0.95;
const MOST_DIFFERENT = 10;
/** Pixels of a picture in motion for one on the screen, along an edge. */
const COARSEST = 0.1;

export class Renderer {
  /** Called when something is on the screen, however coarse. */
  onPresented: () => void = () => {};
  /** Called when the picture is as good as it gets. */
  onSettled: (state: Settled) => void = () => {};
  private readonly gl: GL;
  private readonly programs;
  private readonly ball: { array: WebGLVertexArrayObject; count: number };
  private readonly empty: WebGLVertexArrayObject;
  private readonly pace = new Pace();
  private scene: Scene | null = null;
  private shown: Images | null = null;
  private coming: Images | null = null;
  private next = 0;
  private busy: { sync: WebGLSync; asked: number; since: number } | null = null;
  private moving = false;
  private stale = true;
  private exposure = 1;
  private requested = false;

  constructor(readonly canvas: HTMLCanvasElement) {
    const gl = (this.gl = contextOf(canvas));
    const screen = (fragments: string) => new Program(gl, shaders.FULL_SCREEN, fragments);
    this.programs = {
      sphere: screen(shaders.SPHERE_NORMALS),
      mesh: new Program(gl, shaders.MESH_VERTICES, shaders.MESH_NORMALS),
      shade: screen(shaders.SHADE),
      tones: screen(shaders.TONES),
      difference: screen(shaders.DIFFERENCE),
      ramp: screen(shaders.SHOW_DIFFERENCE),
    };
    this.empty = gl.createVertexArray();
    this.ball = uploadBall(gl);
  }

  get context(): GL {
    return this.gl;
  }

  /** Show a scene; `moving` while a hand is at it: coarser, but at once. */
  show(scene: Scene, options: { moving?: boolean; expose?: boolean } = {}): void {
    this.scene = scene;
    this.moving = options.moving ?? false;
    this.stale ||= options.expose ?? false;
    this.restart();
  }

  /** Show the same scene under other stops of exposure. */
  setStops(stops: number): void {
    if (!this.scene) return;
    this.scene = { ...this.scene, stops };
    if (this.shown) this.present(this.shown);
  }

  /** Draw everything anew, after the canvas has changed its size. */
  restart(): void {
    this.release(this.coming);
    this.coming = null;
    this.request();
  }

  private request(): void {
    if (this.requested) return;
    this.requested = true;
    requestAnimationFrame((now) => {
      this.requested = false;
      this.frame(now);
    });
  }

  private frame(now: number): void {
    const scene = this.scene;
    if (!scene || scene.materials.length === 0 || this.gl.isContextLost()) return;
    if (!this.done(now)) {
      this.request();
      return;
    }
    const cell = this.cells(scene)[0]!;
    const lights = Math.max(scene.lights.direction.length, 1);
    this.coming ??= this.begin(scene, cell, lights);
    const pixels = this.coming.normals.width * this.coming.normals.height;
    const each = pixels * scene.materials.length;
    const most = Math.max(1, Math.floor(this.pace.budget / each));
    // what is coarse was made to fit one frame: under a hand that moves, the next would drop it
    const last = this.coming.share < 1 ? lights : Math.min(lights, this.next + most);
    const asked = (last - this.next) * each;
    for (; this.next < last; this.next += shaders.LIGHTS_AT_ONCE) {
      this.addLights(
        scene,
        this.coming,
        this.next,
        Math.min(last, this.next + shaders.LIGHTS_AT_ONCE),
      );
    }
    this.next = last;
    this.mark(asked, now);
    if (last < lights) {
      this.request();
      return;
    }
    this.release(this.shown);
    this.shown = this.coming;
    this.coming = null;
    if (this.stale) this.expose(this.shown);
    const whole = this.shown.share === 1;
    this.present(this.shown, whole);
    if (whole) {
      this.stale = false;
    } else if (!this.moving) {
      this.request();
    }
  }

  /** Remember what was asked of the graphics card, and when. */
  private mark(asked: number, now: number): void {
    const sync = this.gl.fenceSync(this.gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    this.gl.flush();
    if (sync) this.busy = { sync, asked, since: now };
  }

  /** Whether the card has done what it was asked: more would only wait in line. */
  private done(now: number): boolean {
    if (!this.busy) return true;
    const { sync, asked, since } = this.busy;
    if (this.gl.getSyncParameter(sync, this.gl.SYNC_STATUS) !== this.gl.SIGNALED) return false;
    this.gl.deleteSync(sync);
    this.busy = null;
    this.pace.note(asked, now - since);
    return true;
  }

  private cells(scene: Scene): Cell[] {
    const count = scene.materials.length + (this.compares(scene) ? 1 : 0);
    return cellsFor(count, this.canvas.width, this.canvas.height);
  }

  private compares(scene: Scene): boolean {
    return scene.difference && scene.materials.length > 1;
  }

  private begin(scene: Scene, cell: Cell, lights: number): Images {
    const total = cell.width * cell.height * lights * scene.materials.length;
    // Something to see at once: what one frame can do, then the whole.
    const fits = Math.sqrt(Math.min(1, this.pace.budget / total));
    const coarse = this.moving || this.shown === null;
    const share = coarse ? Math.max(fits, COARSEST) : 1;
    const [width, height] = [Math.ceil(cell.width * share), Math.ceil(cell.height * share)];
    const gl = this.gl;
    const images: Images = {
      share: share >= 0.999 ? 1 : share,
      normals: new Target(gl, width, height, gl.RGBA32F, true),
      linear: scene.materials.map(() => new Target(gl, width, height, gl.RGBA16F)),
    };
    this.drawNormals(scene, cell, images);
    for (const image of images.linear) {
      image.bind();
      gl.clearBufferfv(gl.COLOR, 0, [0, 0, 0, 0]);
    }
    this.next = 0;
    return images;
  }

  private drawNormals(scene: Scene, cell: Cell, { normals, share }: Images): void {
    const gl = this.gl;
    normals.bind();
    gl.clearBufferfv(gl.COLOR, 0, [0, 0, 1, 0]);
    const scaled = (value: number) => value * share;
    if (scene.shape === "sphere") {
      this.programs.sphere
        .use()
        .vector("centre", scaled(cell.centreX), scaled(cell.centreY))
        .float("radius", scaled(cell.radius));
      this.fill();
      return;
    }
    gl.clearBufferfv(gl.DEPTH, 0, [1]);
    gl.enable(gl.DEPTH_TEST);
    const extent = [(2 * cell.radius) / cell.width, (2 * cell.radius) / cell.height] as const;
    const program = this.programs.mesh.use().vector("extent", ...extent);
    const rows = rotation({ yaw: scene.orbit.yaw, pitch: scene.orbit.pitch + 0.22 });
    const columns = [0, 1, 2].flatMap((c) => rows.map((row) => row[c]!));
    gl.uniformMatrix3fv(program.at("turn"), false, columns);
    gl.bindVertexArray(this.ball.array);
    gl.drawElements(gl.TRIANGLES, this.ball.count, gl.UNSIGNED_SHORT, 0);
    gl.disable(gl.DEPTH_TEST);
  }

  private addLights(scene: Scene, images: Images, from: number, to: number): void {
    const gl = this.gl;
    const rows = rotation(scene.orbit);
    const direction = new Float32Array(3 * shaders.LIGHTS_AT_ONCE);
    const irradiance = new Float32Array(3 * shaders.LIGHTS_AT_ONCE);
    const count = Math.min(to, scene.lights.direction.length) - from;
    for (let n = 0; n < count; n++) {
      direction.set(apply(rows, scene.lights.direction[from + n]!), 3 * n);
      irradiance.set(scene.lights.irradiance[from + n]!, 3 * n);
    }
    const program = this.programs.shade
      .use()
      .int("count", Math.max(count, 0))
      .vector("surround", ...(from === 0 ? scene.lights.surround : [0, 0, 0]))
      .texture("normals", 0, gl.TEXTURE_2D, images.normals.texture);
    gl.uniform3fv(program.at("direction"), direction);
    gl.uniform3fv(program.at("irradiance"), irradiance);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE);
    images.linear.forEach((image, n) => {
      image.bind();
      scene.materials[n]?.bind(program);
      this.fill();
    });
    gl.disable(gl.BLEND);
  }

  /** Bring the 95th percentile of the first picture to 0.8, as `brdfit render` does. */
  private expose(images: Images): void {
    const light = images.linear[0]!.read();
    const normals = images.normals.read();
    const seen: number[] = [];
    const step = Math.max(1, Math.floor(light.length / 4 / 200_000));
    for (let n = 0; n < light.length; n += 4 * step) {
      if (normals[n + 3]! < 0.5) continue;
      seen.push(light[n]!, light[n + 1]!, light[n + 2]!);
    }
    const sorted = Float32Array.from(seen).sort();
    const level = sorted[Math.floor(PERCENTILE * (sorted.length - 1))] ?? 0;
    if (level > 0 && Number.isFinite(level)) this.exposure = LEVEL / level;
  }

  private present(images: Images, whole = images.share === 1): void {
    const scene = this.scene!;
    const gl = this.gl;
    const cells = this.cells(scene);
    const exposure = this.exposure * 2 ** scene.stops;
    let difference: Target | null = null;
    if (this.compares(scene) && images.linear.length > 1) {
      difference = this.differ(images, exposure);
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clearBufferfv(gl.COLOR, 0, [0, 0, 0, 0]);
    const place = (program: Program, cell: Cell) => {
      gl.viewport(cell.x, cell.y, cell.width, cell.height);
      return program.use().vector("origin", cell.x, cell.y).float("share", images.share);
    };
    images.linear.forEach((image, n) => {
      const cell = cells[n];
      if (!cell) return;
      place(this.programs.tones, cell)
        .float("exposure", exposure)
        .texture("linear", 0, gl.TEXTURE_2D, image.texture)
        .texture("normals", 1, gl.TEXTURE_2D, images.normals.texture);
      this.fill();
    });
    const last = cells[images.linear.length];
    let mean: number | null = null;
    if (difference && last) {
      place(this.programs.ramp, last)
        .float("most", MOST_DIFFERENT)
        .texture("difference", 0, gl.TEXTURE_2D, difference.texture);
      this.fill();
      if (whole) mean = meanOverDisk(difference.read());
    }
    difference?.free();
    this.onPresented();
    if (whole) this.onSettled({ exposure, difference: mean, cells });
  }

  private differ(images: Images, exposure: number): Target {
    const gl = this.gl;
    const { width, height } = images.normals;
    const target = new Target(gl, width, height, gl.RGBA16F);
    target.bind();
    this.programs.difference
      .use()
      .float("exposure", exposure)
      .texture("one", 0, gl.TEXTURE_2D, images.linear[0]!.texture)
      .texture("two", 1, gl.TEXTURE_2D, images.linear[1]!.texture)
      .texture("normals", 2, gl.TEXTURE_2D, images.normals.texture);
    this.fill();
    return target;
  }

  private fill(): void {
    this.gl.bindVertexArray(this.empty);
    this.gl.drawArrays(this.gl.TRIANGLES, 0, 3);
  }

  private release(images: Images | null): void {
    images?.normals.free();
    for (const image of images?.linear ?? []) image.free();
  }
}

function meanOverDisk(pixels: Float32Array): number | null {
  let sum = 0;
  let count = 0;
  for (let n = 0; n < pixels.length; n += 4) {
    if (pixels[n + 3]! < 0.5) continue;
    sum += pixels[n]!;
    count++;
  }
  return count ? sum / count : null;
}

function uploadBall(gl: GL): { array: WebGLVertexArrayObject; count: number } {
  const { vertices, indices } = materialBall();
  const array = gl.createVertexArray();
  gl.bindVertexArray(array);
  gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ARRAY_BUFFER, vertices, gl.STATIC_DRAW);
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.STATIC_DRAW);
  for (const [place, offset] of [
    [0, 0],
    [1, 12],
  ] as const) {
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, 3, gl.FLOAT, false, 24, offset);
  }
  return { array, count: indices.length };
}
