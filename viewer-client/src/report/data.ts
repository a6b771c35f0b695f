/** The slices of a report, as Python packed them, and as the plots want them. */

import type { Curve, NearPoint, SlicePanel } from "../messages";

type Numbers = (number | null)[];

interface PackedCurve {
  value: Numbers;
  low: Numbers | null;
  high: Numbers | null;
}

/** [sample, row, curve, theta_o, value, outlier] */
type PackedPoint = [number, number, number, number, number, number];

interface PackedPanel {
  theta_i: number;
  curves: PackedCurve[];
  points: PackedPoint[];
  points_left_out: number;
}

/** What stands in the page; see `slice_data` in brdfit.report.page.slices. */
export interface SliceData {
  theta_o: number[];
  channels: { channel: string; style: string }[];
  /** Angles at which the light was measured. */
  measured: number[];
  start: number;
  panels: PackedPanel[];
}

export interface Choice {
  readonly points: boolean;
  readonly outliers: boolean;
}

const known = (values: Numbers): number[] => values.map((value) => value ?? NaN);

/** Return one slice with the points that are wanted. */
export function unpacked(data: SliceData, index: number, choice: Choice): SlicePanel {
  const panel = data.panels[index];
  if (!panel) throw new RangeError(`no slice ${index}`);
  const names = data.channels.map(({ channel, style }) => ({
    channel,
    // a custom property, so that the style sheet makes it dark or light
    colour: `var(--${style})`,
  }));
  const name = (n: number) => names[n] ?? { channel: "", colour: "currentColor" };
  return {
    theta_i: panel.theta_i,
    phi: 180,
    theta_o: data.theta_o,
    curves: panel.curves.map((curve, n): Curve => ({
      ...name(n),
      value: known(curve.value),
      low: curve.low && known(curve.low),
      high: curve.high && known(curve.high),
    })),
    points: panel.points
      .filter((point) => (point[5] ? choice.outliers : choice.points))
      .map(([sample, row, curve, theta_o, value, outlier]): NearPoint => ({
        ...name(curve),
        sample,
        row,
        theta_o,
        value,
        outlier: outlier === 1,
        used: true,
      })),
    points_left_out: panel.points_left_out,
  };
}
