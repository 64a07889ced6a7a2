// Where the camera may go: outside the object, inside the room, above the ground.

import { type Orbit, positionAt, type ViewPoint } from "./camera";
import { type Pem, reflectiveBounds, sceneBounds } from "./pem";
import { add, length, scale, subtract, type Vec3 } from "./vectors";

const STEEPEST = 88; // degrees of elevation
const FARTHEST = 4; // times the orbit's distance, on open ground
const WALL_MARGIN = 0.97;
const OBJECT_MARGIN = 1.05;

export class ViewLimits {
  private readonly nearest: number;
  private readonly ground: number | undefined;
  private readonly pem: Pem;
  private readonly orbit: Orbit;

  constructor(pem: Pem) {
    const { lower, upper } = reflectiveBounds(pem);
    const offset = length(subtract(scale(add(lower, upper), 0.5), pem.orbit.target));
    this.pem = pem;
    this.orbit = pem.orbit;
    this.nearest = Math.min(OBJECT_MARGIN * (offset + length(subtract(upper, lower)) / 2), pem.orbit.distance);
    this.ground = pem.parts.every((part) => part.reflective) ? undefined : lower[1];
  }

  /** The allowed point closest to a point. */
  clamp(point: ViewPoint): ViewPoint {
    const azimuth_deg = point.azimuth_deg;
    let distance = Math.max(point.distance, this.nearest);
    let lowest = -STEEPEST;
    if (this.ground !== undefined) {
      const sine = (this.ground - this.orbit.target[1]) / distance;
      lowest = Math.max(lowest, (Math.asin(Math.min(Math.max(sine, -1), 1)) * 180) / Math.PI + 1);
    }
    const elevation_deg = Math.min(Math.max(point.elevation_deg, lowest), STEEPEST);
    distance = Math.min(distance, this.farthest({ azimuth_deg, elevation_deg, distance }));
    return { azimuth_deg, elevation_deg, distance };
  }

  /** The distance at which the camera meets the scene's bounds; a scene with an environment has none that matter. */
  private farthest(point: ViewPoint): number {
    const open = FARTHEST * this.orbit.distance;
    if (this.pem.environment) return open;
    const { lower, upper } = sceneBounds(this.pem);
    const { target } = this.orbit;
    const direction = subtract(positionAt(this.orbit, { ...point, distance: 1 }), target);
    const exits = ([0, 1, 2] as const).map((k) => {
      const wall: Vec3 = (direction[k] as number) > 0 ? upper : lower;
      return direction[k] === 0 ? Number.POSITIVE_INFINITY : (wall[k] - target[k]) / direction[k];
    });
    return Math.max(Math.min(open, WALL_MARGIN * Math.min(...exits)), this.nearest);
  }
}
