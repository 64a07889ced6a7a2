// Where the camera may go: outside the object, inside the room, above the ground.

import { type Part, reflectiveBounds, sceneBounds } from "../files/gltf";
import { type Orbit, positionAt, type ViewPoint } from "../maths/camera";
import { add, length, scale, subtract, type Vec3 } from "../maths/vectors";

const STEEPEST = 88; // degrees of elevation
const FARTHEST = 4; // times the orbit's distance, on open ground
const WALL_MARGIN = 0.97;
const OBJECT_MARGIN = 1.05;

/** What limits a camera; `environment` is anything where the scene lies in the open. */
export interface Surroundings {
  readonly parts: readonly Part[];
  readonly orbit: Orbit;
  readonly environment: unknown;
}

export class ViewLimits {
  private readonly nearest: number;
  private readonly ground: number | undefined;

  constructor(private readonly scene: Surroundings) {
    const { lower, upper } = reflectiveBounds(scene);
    const offset = length(subtract(scale(add(lower, upper), 0.5), scene.orbit.target));
    this.nearest = Math.min(OBJECT_MARGIN * (offset + length(subtract(upper, lower)) / 2), scene.orbit.distance);
    this.ground = scene.parts.every((part) => part.reflective) ? undefined : lower[1];
  }

  /** The allowed point closest to a point. */
  clamp(point: ViewPoint): ViewPoint {
    const azimuth_deg = point.azimuth_deg;
    let distance = Math.max(point.distance, this.nearest);
    let lowest = -STEEPEST;
    if (this.ground !== undefined) {
      const sine = (this.ground - this.scene.orbit.target[1]) / distance;
      lowest = Math.max(lowest, (Math.asin(Math.min(Math.max(sine, -1), 1)) * 180) / Math.PI + 1);
    }
    const elevation_deg = Math.min(Math.max(point.elevation_deg, lowest), STEEPEST);
    distance = Math.min(distance, this.farthest({ azimuth_deg, elevation_deg, distance }));
    return { azimuth_deg, elevation_deg, distance };
  }

  /** The distance at which the camera meets the scene's bounds; a scene with an environment has none that matter. */
  private farthest(point: ViewPoint): number {
    const open = FARTHEST * this.scene.orbit.distance;
    if (this.scene.environment) return open;
    const { lower, upper } = sceneBounds(this.scene);
    const { target } = this.scene.orbit;
    const direction = subtract(positionAt(this.scene.orbit, { ...point, distance: 1 }), target);
    const exits = ([0, 1, 2] as const).map((k) => {
      const wall: Vec3 = (direction[k] as number) > 0 ? upper : lower;
      return direction[k] === 0 ? Number.POSITIVE_INFINITY : (wall[k] - target[k]) / direction[k];
    });
    return Math.max(Math.min(open, WALL_MARGIN * Math.min(...exits)), this.nearest);
  }
}
