/** WebGL2 with errors that say what failed. */

export type GL = WebGL2RenderingContext;

/** Return a context that renders to floating-point targets; an Error in words without one. */
export function contextOf(canvas: HTMLCanvasElement): GL {
  const gl = canvas.getContext("webgl2", {
    alpha: true,
    antialias: false,
    depth: false,
    powerPreference: "high-performance",
    premultipliedAlpha: true,
  });
  if (!gl) {
    throw new Error(
      "this browser has no WebGL2, which the picture needs. Switch hardware acceleration on, " +
        "or use a recent Firefox, Chrome, Edge or Safari. Everything else on the page works.",
    );
  }
  if (!gl.getExtension("EXT_color_buffer_float")) {
    throw new Error("this graphics driver cannot render to floating-point textures.");
  }
  return gl;
}

function compile(gl: GL, kind: number, source: string): WebGLShader {
  const shader = gl.createShader(kind)!;
  gl.shaderSource(shader, source);
  gl.compileShader(shader);
  return shader;
}

/** A linked program and its uniforms by name. */
export class Program {
  private readonly places = new Map<string, WebGLUniformLocation | null>();
  private readonly handle: WebGLProgram;

  constructor(
    private readonly gl: GL,
    vertices: string,
    fragments: string,
  ) {
    const parts = [
      compile(gl, gl.VERTEX_SHADER, vertices),
      compile(gl, gl.FRAGMENT_SHADER, fragments),
    ];
    this.handle = gl.createProgram();
    for (const part of parts) gl.attachShader(this.handle, part);
    gl.linkProgram(this.handle);
    if (!gl.getProgramParameter(this.handle, gl.LINK_STATUS) && !gl.isContextLost()) {
      const logs = parts.map((part) => gl.getShaderInfoLog(part)).join("\n");
      throw new Error(`shader: ${gl.getProgramInfoLog(this.handle) ?? ""}\n${logs}`);
    }
    for (const part of parts) gl.deleteShader(part);
  }

  use(): this {
    this.gl.useProgram(this.handle);
    return this;
  }

  at(name: string): WebGLUniformLocation | null {
    if (!this.places.has(name)) {
      this.places.set(name, this.gl.getUniformLocation(this.handle, name));
    }
    return this.places.get(name) ?? null;
  }

  float(name: string, value: number): this {
    this.gl.uniform1f(this.at(name), value);
    return this;
  }

  int(name: string, value: number): this {
    this.gl.uniform1i(this.at(name), value);
    return this;
  }

  vector(name: string, ...value: number[]): this {
    const place = this.at(name);
    if (value.length === 2) this.gl.uniform2fv(place, value);
    else this.gl.uniform3fv(place, value);
    return this;
  }

  texture(name: string, unit: number, kind: number, texture: WebGLTexture): this {
    this.gl.activeTexture(this.gl.TEXTURE0 + unit);
    this.gl.bindTexture(kind, texture);
    return this.int(name, unit);
  }
}

/** A texture to render into, with depth if asked for. */
export class Target {
  readonly texture: WebGLTexture;
  private readonly frame: WebGLFramebuffer;
  private readonly depth: WebGLRenderbuffer | null;

  constructor(
    private readonly gl: GL,
    readonly width: number,
    readonly height: number,
    format: number,
    withDepth = false,
  ) {
    this.texture = gl.createTexture();
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
    nearest(gl, gl.TEXTURE_2D);
    this.frame = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.frame);
    const to = gl.COLOR_ATTACHMENT0;
    gl.framebufferTexture2D(gl.FRAMEBUFFER, to, gl.TEXTURE_2D, this.texture, 0);
    this.depth = null;
    if (withDepth) {
      this.depth = gl.createRenderbuffer();
      gl.bindRenderbuffer(gl.RENDERBUFFER, this.depth);
      gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT24, width, height);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, this.depth);
    }
  }

  bind(): void {
    this.gl.bindFramebuffer(this.gl.FRAMEBUFFER, this.frame);
    this.gl.viewport(0, 0, this.width, this.height);
  }

  /** Return R, G, B, A of every pixel, row 0 at the bottom. */
  read(): Float32Array {
    this.bind();
    const pixels = new Float32Array(4 * this.width * this.height);
    this.gl.readPixels(0, 0, this.width, this.height, this.gl.RGBA, this.gl.FLOAT, pixels);
    return pixels;
  }

  free(): void {
    this.gl.deleteFramebuffer(this.frame);
    this.gl.deleteTexture(this.texture);
    if (this.depth) this.gl.deleteRenderbuffer(this.depth);
  }
}

export function nearest(gl: GL, kind: number): void {
  gl.texParameteri(kind, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
  gl.texParameteri(kind, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
  gl.texParameteri(kind, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
  gl.texParameteri(kind, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
}
