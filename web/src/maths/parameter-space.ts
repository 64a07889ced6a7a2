// Which samples of the parameter space a view needs: twin of reflet.scene.views.parameter_space.

import { type Orbit, positionAt, type ViewPoint } from "./camera";
import { length, subtract } from "./vectors";

export interface Axis {
  readonly name: string;
  readonly values: readonly number[];
  /** Of a closed axis, after which it repeats: the last sample is the first one's neighbour. */
  readonly period?: number;
}

export type Point = Readonly<Record<string, number>>;

const AZIMUTH = "azimuth_deg";

/**
 * The coordinate on an axis: on a closed one from the first sample to less than a period on; of all equivalent azimuths on an
 * open one the closest to its range.
 */
function coordinate(axis: Axis, point: Point): number {
  const first = axis.values[0] as number;
  const last = axis.values.at(-1) as number;
  const x = point[axis.name] ?? first;
  if (axis.period !== undefined) return x - axis.period * Math.floor((x - first) / axis.period);
  return axis.name === AZIMUTH ? x + 360 * Math.round((0.5 * (first + last) - x) / 360) : x;
}

/** The coordinates of a sample. */
export function pointOfSample(axes: readonly Axis[], sample: number): Point {
  const point: Record<string, number> = {};
  let rest = sample;
  for (const { name, values } of [...axes].reverse()) {
    point[name] = values[rest % values.length] as number;
    rest = Math.floor(rest / values.length);
  }
  return point;
}

/**
 * How far a point's camera stands from the sampled range: the distance between it and the camera of the closest point of
 * the range, over that one's distance from the target, as an angle. Needs samples.
 */
export function displacementDeg(axes: readonly Axis[], orbit: Orbit, point: ViewPoint): number {
  const closest: Record<string, number> = {};
  for (const axis of axes) {
    const [first, last] = [axis.values[0] as number, axis.values.at(-1) as number];
    const x = coordinate(axis, { ...point });
    closest[axis.name] = axis.period !== undefined ? x : Math.min(Math.max(x, first), last);
  }
  const own = { azimuth_deg: orbit.azimuthDeg, elevation_deg: orbit.elevationDeg, distance: orbit.distance };
  const there = positionAt(orbit, { ...own, ...closest });
  const gap = length(subtract(positionAt(orbit, point), there));
  return ((gap / length(subtract(there, orbit.target))) * 180) / Math.PI;
}

/** Multilinear weights of the samples around a point, all positive; their sum is 1. None where there are no samples. */
export function blendWeights(axes: readonly Axis[], point: Point): Map<number, number> {
  if (axes.some(({ values }) => values.length === 0)) return new Map();
  let corners: { sample: number; weight: number }[] = [{ sample: 0, weight: 1 }];
  for (const axis of axes) {
    const count = axis.values.length;
    const again = axis.period === undefined ? [] : [(axis.values[0] as number) + axis.period];
    const values = [...axis.values, ...again];
    const x = coordinate(axis, point);
    const above = values.findIndex((value) => value > x);
    const low = Math.min(Math.max((above < 0 ? values.length : above) - 1, 0), Math.max(values.length - 2, 0));
    const high = Math.min(low + 1, values.length - 1);
    const step = (values[high] as number) - (values[low] as number);
    const t = step > 0 ? Math.min(Math.max((x - (values[low] as number)) / step, 0), 1) : 0;
    const ends = [
      { index: low % count, weight: 1 - t },
      { index: high % count, weight: t },
    ].filter((end) => end.weight > 0);
    corners = corners.flatMap((corner) =>
      ends.map((end) => ({
        sample: corner.sample * count + end.index,
        weight: corner.weight * end.weight,
      })),
    );
  }
  return new Map(corners.map((corner) => [corner.sample, corner.weight]));
}

/** The one sample to show when nothing is blended, if any: that of the largest weight, the first of equals. */
export function nearestAlone(weights: ReadonlyMap<number, number>): Map<number, number> {
  const [first, ...rest] = weights;
  if (first === undefined) return new Map();
  return new Map([[rest.reduce((best, next) => (next[1] > best[1] ? next : best), first)[0], 1]]);
}

/** All samples, the closest to a point first; distances count in steps of each axis. */
export function samplesByDistance(axes: readonly Axis[], point: Point): number[] {
  let squared = [0];
  for (const axis of axes) {
    const { values, period } = axis;
    const x = coordinate(axis, point);
    const open = ((values.at(-1) as number) - (values[0] as number)) / Math.max(values.length - 1, 1) || 1;
    const step = period === undefined ? open : period / values.length;
    const apart = (value: number) => value - x - (period ?? 0) * Math.round((value - x) / (period ?? 1));
    squared = squared.flatMap((sum) => values.map((value) => sum + (apart(value) / step) ** 2));
  }
  return squared.map((_, sample) => sample).sort((a, b) => (squared[a] as number) - (squared[b] as number) || a - b);
}
