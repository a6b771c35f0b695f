/** The material ball: a sphere with a groove on a rounded foot, a surface of revolution. */

export interface Mesh {
  /** x, y, z, then the normal, of every vertex. */
  readonly vertices: Float32Array;
  readonly indices: Uint16Array;
}

type Point = readonly [number, number];

const ROUND = 96;

/** Return (radius, height) along the outline from top to bottom. */
function outline(): Point[][] {
  const centre = 0.24;
  const radius = 0.74;
  const arc = (from: number, to: number, steps: number, r = radius, y0 = centre, x0 = 0): Point[] =>
    Array.from({ length: steps + 1 }, (_, k) => {
      const angle = ((from + ((to - from) * k) / steps) * Math.PI) / 180;
      return [x0 + r * Math.sin(angle), y0 + r * Math.cos(angle)] as const;
    });
  const inner = radius - 0.055;
  return [
    arc(0, 96, 48),
    // the groove: an inner band
    arc(97, 107, 8, inner),
    arc(108, 152, 24),
    // the foot: a disk with a rounded rim
    [
      [0.0, -0.5],
      [0.46, -0.5],
    ],
    arc(0, 90, 10, 0.09, -0.59, 0.46),
    [
      [0.55, -0.59],
      [0.58, -0.86],
    ],
  ];
}

/** Return the mesh, about 1.7 high and centred on the origin. */
export function materialBall(): Mesh {
  const vertices: number[] = [];
  const indices: number[] = [];
  for (const line of outline()) {
    const first = vertices.length / 6;
    line.forEach(([r, y], k) => {
      const [r0, y0] = line[Math.max(k - 1, 0)]!;
      const [r1, y1] = line[Math.min(k + 1, line.length - 1)]!;
      const length = Math.hypot(r1 - r0, y1 - y0) || 1;
      const [nr, ny] = [-(y1 - y0) / length, (r1 - r0) / length];
      for (let turn = 0; turn <= ROUND; turn++) {
        const angle = (turn / ROUND) * 2 * Math.PI;
        const [c, s] = [Math.cos(angle), Math.sin(angle)];
        vertices.push(r * c, y, r * s, nr * c, ny, nr * s);
      }
    });
    for (let k = 0; k + 1 < line.length; k++) {
      for (let turn = 0; turn < ROUND; turn++) {
        const a = first + k * (ROUND + 1) + turn;
        const b = a + ROUND + 1;
        indices.push(a, b, a + 1, a + 1, b, b + 1);
      }
    }
  }
  return { vertices: new Float32Array(vertices), indices: new Uint16Array(indices) };
}
