/** Takes apart what brdfit.report.packed_table packs: half floats of f_r / scale. */

export interface PackedShape {
  /** n_theta_h, n_theta_d, n_phi_d */
  readonly grid: readonly [number, number, number];
  /** f_r is the half float times this. */
  readonly scale: number;
}

/**
 * Return the bits of half floats, R G B of a cell side by side, phi_d running fastest.
 *
 * `plain` holds, after inflation, the low bytes of all differences along the flat index, one
 * channel after another, then their high bytes.
 */
export function unpackHalf(plain: Uint8Array, cells: number): Uint16Array {
  const total = 3 * cells;
  if (plain.length !== 2 * total) {
    throw new Error(`packed table: found ${plain.length} bytes but ${2 * total} were expected`);
  }
  const half = new Uint16Array(total);
  for (let channel = 0; channel < 3; channel++) {
    let sum = 0;
    let from = channel * cells;
    for (let to = channel; to < total; to += 3, from++) {
      sum = (sum + plain[from]! + (plain[from + total]! << 8)) & 0xffff;
      half[to] = sum;
    }
  }
  return half;
}
