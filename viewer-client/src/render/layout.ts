/** Where the pictures stand on the canvas, in device pixels. */

export interface Cell {
  /** From the left and from the bottom. */
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
  /** Of the sphere; its middle is at (centreX, centreY) from the corner of the cell. */
  readonly radius: number;
  readonly centreX: number;
  readonly centreY: number;
}

/** Return cells of one size for `count` pictures, as nearly square as the canvas allows. */
export function cellsFor(count: number, width: number, height: number): Cell[] {
  let best = { columns: 1, size: 0 };
  for (let columns = 1; columns <= count; columns++) {
    const rows = Math.ceil(count / columns);
    const size = Math.min(width / columns, height / rows);
    if (size > best.size) best = { columns, size };
  }
  const rows = Math.ceil(count / best.columns);
  const cellWidth = Math.max(1, Math.floor(width / best.columns));
  const cellHeight = Math.max(1, Math.floor(height / rows));
  return Array.from({ length: count }, (_, n) => ({
    x: (n % best.columns) * cellWidth,
    y: height - (Math.floor(n / best.columns) + 1) * cellHeight,
    width: cellWidth,
    height: cellHeight,
    // whole numbers: the sphere then falls on the pixels of brdfit.render.Sphere
    radius: Math.max(1, Math.floor(0.46 * Math.min(cellWidth, cellHeight))),
    centreX: Math.floor(cellWidth / 2),
    centreY: Math.floor(cellHeight / 2),
  }));
}

/** How many light-pixels a frame may take: found out by doing, since GPUs differ 1000-fold. */
export class Pace {
  private perFrame = 6e5;
  private asked = 0;
  private since = 0;

  /** Light-pixels that the next frame may take. */
  get budget(): number {
    return this.perFrame;
  }

  /** Note at the start of a frame how long the one before took, if it was a full one. */
  begin(now: number): void {
    const took = now - this.since;
    if (this.asked > 0 && this.since > 0 && took < 2000) {
      if (took > 45) this.perFrame = Math.max(2e4, this.perFrame * Math.max(0.3, 30 / took));
      else if (took < 22 && this.asked > 0.5 * this.perFrame) this.perFrame *= 1.6;
    }
    this.perFrame = Math.min(this.perFrame, 4e9);
    this.since = now;
    this.asked = 0;
  }

  spend(lightPixels: number): void {
    this.asked += lightPixels;
  }

  /** Forget when the last frame was: the page was idle since. */
  rest(): void {
    this.since = 0;
  }
}
