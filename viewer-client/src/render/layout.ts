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

/** Milliseconds of a frame that shading may take, beside what every frame costs. */
const TARGET = 25;
/** Light-pixels that cost next to nothing: a frame of so few shows what every frame costs. */
const LITTLE = 5e4;

/**
 * How many light-pixels a frame may take: found out by doing, since GPUs differ 1000-fold.
 *
 * A frame costs what every frame costs, and something for each light-pixel: only the second
 * gets less by asking for less.
 */
export class Pace {
  /** Milliseconds for a light-pixel. The first guess: something to see at once, anywhere. */
  private each = TARGET / 6e5;
  private overhead = 17;

  /** Light-pixels that the next frame may take. */
  get budget(): number {
    return Math.min(Math.max(TARGET / this.each, 0.8 * LITTLE), 4e9);
  }

  /** Note how many milliseconds so many light-pixels took, until the card was done with them. */
  note(asked: number, took: number): void {
    if (asked < LITTLE) this.overhead = 0.5 * (this.overhead + took);
    else this.overhead = Math.min(this.overhead, took);
    const beyond = Math.max(took - this.overhead, 1);
    // a frame that asked for little and was quick tells nothing
    if (asked > 0.3 * this.budget || beyond > TARGET) {
      this.each = 0.5 * (this.each + beyond / asked);
    }
  }
}
