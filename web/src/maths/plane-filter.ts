// Phong's lobe as shift-invariant filters of a dual paraboloid: twin of reflet.reflectance.prefilter.plane_filter, which says why.

const WIDEST = 7; // texels
const REACH = (WIDEST - 1) / 2;
const LIMIT = 0.1; // of its peak, below which the lobe counts as zero

/** One of the two filters: the mip level it runs on, and its weights there, row by row, with sum 1. */
export interface PlaneFilter {
  readonly shrinkLevel: number;
  readonly weights: readonly number[];
}

/** The filters for the middle and for the rim of faces whose discs are `rows` texels wide. */
export function phongPlaneFilters(exponent: number, rows: number): readonly [PlaneFilter, PlaneFilter] {
  const angle = Math.acos(LIMIT ** (1 / exponent)); // where cosᴺ falls below the limit
  const t = Math.min(Math.tan(angle / 2), 1);
  return [
    planeFilter(exponent, rows, t, (radius) => radius),
    planeFilter(exponent, rows, (2 * t) / (1 + t), (radius) => radius / (2 - radius)),
  ];
}

/** `halfTangent` gives tan(θ/2) of the lobe at a radius in the plane. */
function planeFilter(
  exponent: number,
  rows: number,
  radius: number,
  halfTangent: (radius: number) => number,
): PlaneFilter {
  const size = 2 * Math.ceil(0.5 * rows * radius - 1e-9);
  const shrinkLevel = Math.max(Math.ceil(Math.log2(size / WIDEST)), 0);
  const texel = (2 * 2 ** shrinkLevel) / rows;
  const lobe: number[] = [];
  for (let row = -REACH; row <= REACH; row++) {
    for (let column = -REACH; column <= REACH; column++) {
      const distance = Math.hypot(column * texel, row * texel);
      const square = halfTangent(Math.min(distance, 1)) ** 2;
      const cosine = Math.max((1 - square) / (1 + square), 0);
      lobe.push(distance <= radius ? cosine ** exponent : 0);
    }
  }
  const sum = lobe.reduce((a, b) => a + b, 0);
  return { shrinkLevel, weights: lobe.map((value) => value / sum) };
}
