/** A table on the graphics card. */

import { nearest, type GL, type Program } from "./gl";
import { unpackHalf, type PackedShape } from "./packed";

export class Material {
  private readonly table: WebGLTexture;
  private readonly albedo: WebGLTexture;
  private readonly grid: readonly [number, number, number];
  private readonly scale: number;

  constructor(
    private readonly gl: GL,
    shape: PackedShape,
    plain: Uint8Array,
  ) {
    const [nH, nD, nPhi] = shape.grid;
    this.grid = [nPhi, nD, nH];
    this.scale = shape.scale;
    this.table = gl.createTexture();
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_3D, this.table);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 2);
    gl.texStorage3D(gl.TEXTURE_3D, 1, gl.RGB16F, nPhi, nD, nH);
    const half = unpackHalf(plain, nPhi * nD * nH);
    const at = [gl.TEXTURE_3D, 0, 0, 0, 0, nPhi, nD, nH] as const;
    gl.texSubImage3D(...at, gl.RGB, gl.HALF_FLOAT, half);
    gl.texParameteri(gl.TEXTURE_3D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_3D, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
    // phi_d = pi is phi_d = 0 again; beyond the last node the other two are constant
    gl.texParameteri(gl.TEXTURE_3D, gl.TEXTURE_WRAP_S, gl.REPEAT);
    gl.texParameteri(gl.TEXTURE_3D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_3D, gl.TEXTURE_WRAP_R, gl.CLAMP_TO_EDGE);
    this.albedo = gl.createTexture();
    this.setAlbedo([
      [0, 0, 0],
      [0, 0, 0],
    ]);
  }

  /** Take the directional albedo at evenly spaced cosines from 0.02 to 1. */
  setAlbedo(value: readonly (readonly number[])[]): void {
    const gl = this.gl;
    const pixels = new Float32Array(value.flatMap(([r = 0, g = 0, b = 0]) => [r, g, b, 1]));
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.albedo);
    const form = [gl.TEXTURE_2D, 0, gl.RGBA32F, value.length, 1, 0] as const;
    gl.texImage2D(...form, gl.RGBA, gl.FLOAT, pixels);
    nearest(gl, gl.TEXTURE_2D);
  }

  bind(program: Program): void {
    program
      .texture("brdf", 1, this.gl.TEXTURE_3D, this.table)
      .texture("albedo", 2, this.gl.TEXTURE_2D, this.albedo)
      .vector("grid", ...this.grid)
      .float("scale", this.scale);
  }

  free(): void {
    this.gl.deleteTexture(this.table);
    this.gl.deleteTexture(this.albedo);
  }
}
