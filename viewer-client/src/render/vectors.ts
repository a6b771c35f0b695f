/** Rotations and directions in view coordinates: x right, y up, z toward the viewer. */

export type Vec3 = readonly [number, number, number];

export interface Orbit {
  /** Turn about the vertical, radians. */
  readonly yaw: number;
  /** Tilt toward the viewer, radians. */
  readonly pitch: number;
}

/** Return the rows of the rotation that takes the world into the view of an orbit. */
export function rotation({ yaw, pitch }: Orbit): readonly [Vec3, Vec3, Vec3] {
  const [cy, sy, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
  return [
    [cy, 0, sy],
    [sp * sy, cp, -sp * cy],
    [-cp * sy, sp, cp * cy],
  ];
}

export function apply(rows: readonly [Vec3, Vec3, Vec3], v: readonly number[]): Vec3 {
  const [x = 0, y = 0, z = 0] = v;
  const [a, b, c] = rows.map((row) => row[0] * x + row[1] * y + row[2] * z);
  return [a!, b!, c!];
}

export function normalized([x, y, z]: Vec3): Vec3 {
  const length = Math.hypot(x, y, z) || 1;
  return [x / length, y / length, z / length];
}

/** Return the light whose highlight stands where a unit sphere is touched at (x, y). */
export function lightForHighlight(x: number, y: number): Vec3 {
  const r = Math.hypot(x, y);
  const shrink = r > 0.98 ? 0.98 / r : 1;
  const [nx, ny] = [x * shrink, y * shrink];
  const nz = Math.sqrt(1 - nx * nx - ny * ny);
  // the mirror image of the view direction (0, 0, 1) about the normal
  return [2 * nz * nx, 2 * nz * ny, 2 * nz * nz - 1];
}
