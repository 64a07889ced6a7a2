// Geometries of env maps: twin of reflet.envmap.geometry, and how one is turned into another for comparison.

import { add, type Bounds, scale, subtract, type Vec3 } from "./vectors";

export const KINDS = ["infinite_sphere", "sphere", "ellipsoid", "box", "hemisphere"] as const;
export type Kind = (typeof KINDS)[number];

const RELIEF = KINDS.length; // its number behind those of the shapes
const LIMIT = 64; // reflet.envmap.relief
const FAR_AWAY = 1e15; // sides of boxes that are not there: reflet.envmap.shapes

/** The true distances of what a map shows, as a cube of half floats: `inverse_distance` of reflet.envmap.relief. */
export interface Relief {
  kind: "relief";
  lower: Vec3;
  upper: Vec3;
  origin: Vec3;
  size: number;
  inverseDistance: Uint16Array;
}

export type Geometry =
  | { kind: "infinite_sphere" }
  | { kind: "sphere" | "ellipsoid"; centre: Vec3; radii: Vec3; origin: Vec3 }
  | { kind: "box"; lower: Vec3; upper: Vec3; origin: Vec3 }
  | { kind: "hemisphere"; centre: Vec3; radii: Vec3; floor: number; origin: Vec3 }
  | Relief;

/** The twelve floats that shaders read. */
export function pack(geometry: Geometry): number[] {
  if (geometry.kind === "relief") {
    const { lower, upper, origin } = geometry;
    return [RELIEF, ...lower, limit(geometry), ...upper, 0, ...origin];
  }
  const kind = KINDS.indexOf(geometry.kind);
  switch (geometry.kind) {
    case "infinite_sphere":
      return new Array<number>(12).fill(0);
    case "box":
      return [kind, ...geometry.lower, 0, ...geometry.upper, 0, ...geometry.origin];
    case "hemisphere":
      return [kind, ...geometry.centre, geometry.floor, ...geometry.radii, 0, ...geometry.origin];
    default:
      return [kind, ...geometry.centre, 0, ...geometry.radii, 0, ...geometry.origin];
  }
}

/** `Relief.limit`. */
const limit = (relief: Relief): number => LIMIT * Math.max(nearestInverse(relief), 1e-30);

/** The largest inverse distance. Half floats that are not negative order like their bits. */
export function nearestInverse({ inverseDistance }: Relief): number {
  const bits = inverseDistance.reduce((most, next) => Math.max(most, next), 0);
  const [exponent, mantissa] = [bits >> 10, bits & 1023];
  return exponent ? 2 ** (exponent - 25) * (1024 + mantissa) : 2 ** -24 * mantissa;
}

/** A corner of a box, with the sides of another where its own are not there. */
function withSides(corner: Vec3, other: Vec3): Vec3 {
  const side = (axis: 0 | 1 | 2) => (Math.abs(corner[axis]) < 0.5 * FAR_AWAY ? corner : other)[axis];
  return [side(0), side(1), side(2)];
}

const ROUND = Math.cbrt(6 / Math.PI); // half the edge of a cube times this is the radius of the ball of its volume

/** The box of about the same volume; that of the surroundings, or some of its sides, where the geometry has none. */
function boxOf(geometry: Geometry, surroundings: Bounds): Bounds {
  switch (geometry.kind) {
    case "infinite_sphere":
      return surroundings;
    case "box":
    case "relief": // where its searches start
      return {
        lower: withSides(geometry.lower, surroundings.lower),
        upper: withSides(geometry.upper, surroundings.upper),
      };
    case "hemisphere": {
      const { centre, floor } = geometry;
      const [x, y, z] = scale(geometry.radii, 1 / ROUND);
      return { lower: [centre[0] - x, floor, centre[2] - z], upper: [centre[0] + x, floor + y, centre[2] + z] };
    }
    default: {
      const half = scale(geometry.radii, 1 / ROUND);
      return { lower: subtract(geometry.centre, half), upper: add(geometry.centre, half) };
    }
  }
}

/**
 * A geometry of another kind that encloses about the same volume in the same place, with the same origin, grown by
 * `growth` about its centre. Of the same kind and with growth 1 it is the geometry itself; a relief never grows.
 */
export function asKind(geometry: Geometry, kind: Geometry["kind"], growth: number, surroundings: Bounds): Geometry {
  if (kind === "relief" || (geometry.kind === kind && growth === 1)) return geometry;
  if (kind === "infinite_sphere") return { kind };
  const box = boxOf(geometry, surroundings);
  const centre = scale(add(box.lower, box.upper), 0.5);
  const half = scale(subtract(box.upper, box.lower), 0.5 * growth);
  const origin = geometry.kind === "infinite_sphere" ? centre : geometry.origin;
  switch (kind) {
    case "box":
      return { kind, lower: subtract(centre, half), upper: add(centre, half), origin };
    case "ellipsoid":
      return { kind, centre, radii: scale(half, ROUND), origin };
    case "sphere": {
      const radius = ROUND * Math.cbrt(half[0] * half[1] * half[2]);
      return { kind, centre, radii: [radius, radius, radius], origin };
    }
    case "hemisphere": {
      const floor = box.lower[1];
      const radii: Vec3 = [ROUND * half[0], 2 * ROUND * half[1], ROUND * half[2]];
      return { kind, centre: [centre[0], floor, centre[2]], radii, floor, origin };
    }
  }
}
