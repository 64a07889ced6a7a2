// Three-component vectors.

export type Vec3 = readonly [number, number, number];

export const add = (a: Vec3, b: Vec3): Vec3 => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const subtract = (a: Vec3, b: Vec3): Vec3 => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scale = (a: Vec3, k: number): Vec3 => [a[0] * k, a[1] * k, a[2] * k];
export const dot = (a: Vec3, b: Vec3): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const length = (a: Vec3): number => Math.sqrt(dot(a, a));

export const cross = (a: Vec3, b: Vec3): Vec3 => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];

export const normalize = (a: Vec3): Vec3 => {
  const norm = length(a);
  return [a[0] / norm, a[1] / norm, a[2] / norm];
};

/** A box along the axes. */
export interface Bounds {
  readonly lower: Vec3;
  readonly upper: Vec3;
}

export function union(boxes: readonly Bounds[]): Bounds {
  const pick = (choose: (...values: number[]) => number, which: keyof Bounds): Vec3 => [
    choose(...boxes.map((box) => box[which][0])),
    choose(...boxes.map((box) => box[which][1])),
    choose(...boxes.map((box) => box[which][2])),
  ];
  return { lower: pick(Math.min, "lower"), upper: pick(Math.max, "upper") };
}
