/** From values to pixels, and where the ticks of an axis stand. */

export type ScaleKind = "log" | "linear";

export interface Scale {
  readonly kind: ScaleKind;
  readonly low: number;
  readonly high: number;
  /** Share of the axis, 0 at `low`, 1 at `high`; NaN for what cannot be drawn. */
  at(value: number): number;
  readonly ticks: readonly number[];
}

/** Return a scale that shows all finite values; a log scale those above zero. */
export function scaleOf(values: Iterable<number>, kind: ScaleKind): Scale {
  let low = Infinity;
  let high = -Infinity;
  for (const value of values) {
    if (!Number.isFinite(value) || (kind === "log" && value <= 0)) continue;
    low = Math.min(low, value);
    high = Math.max(high, value);
  }
  if (low > high) [low, high] = kind === "log" ? [0.1, 1] : [0, 1];
  return kind === "log" ? logScale(low, high) : linearScale(Math.min(low, 0), high);
}

function logScale(low: number, high: number): Scale {
  const from = Math.log10(low) - 0.05;
  const to = Math.max(Math.log10(high) + 0.05, from + 0.3);
  const step = Math.max(1, Math.ceil((to - from) / 6));
  const ticks: number[] = [];
  for (let power = Math.ceil(from); power <= to; power += step) ticks.push(10 ** power);
  if (ticks.length < 2) {
    for (const mantissa of [2, 5]) {
      const power = Math.floor(from);
      for (const one of [mantissa * 10 ** power, mantissa * 10 ** (power + 1)]) {
        if (Math.log10(one) >= from && Math.log10(one) <= to) ticks.push(one);
      }
    }
  }
  const at = (value: number) => (value > 0 ? (Math.log10(value) - from) / (to - from) : NaN);
  return { kind: "log", low: 10 ** from, high: 10 ** to, at, ticks };
}

function linearScale(low: number, high: number): Scale {
  const span = high - low || 1;
  const raw = span / 5;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= raw) ?? raw;
  const end = low + Math.ceil(span / step) * step;
  const ticks: number[] = [];
  for (let tick = Math.ceil(low / step) * step; tick <= end + step / 2; tick += step) {
    ticks.push(Number(tick.toPrecision(12)));
  }
  return { kind: "linear", low, high: end, at: (value) => (value - low) / (end - low), ticks };
}

/** Return a number as a label of an axis. */
export function label(value: number): string {
  if (value === 0) return "0";
  const power = Math.log10(Math.abs(value));
  if (power >= 5 || power < -3) return value.toExponential(0).replace("e+", "e");
  return String(Number(value.toPrecision(3)));
}
