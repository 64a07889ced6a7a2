// The camera and its orbit: twins of reflet.scene.views.camera and reflet.scene.views.parameter_space.

import { cross, dot, length, normalize, scale, subtract, type Vec3 } from "./vectors";

export const NEAR_SHARE = 1e-3; // of the distance to the target, as in reflet.render.playback.layouts
const UP: Vec3 = [0, 1, 0];

/** A point of the parameter space: coordinates by axis name, as in scene.gltf. */
export interface ViewPoint {
  azimuth_deg: number;
  elevation_deg: number;
  distance: number;
}

export interface Orbit {
  readonly target: Vec3;
  readonly azimuthDeg: number;
  readonly elevationDeg: number;
  readonly distance: number;
  readonly fovDeg: number;
}

/** An orbit as scene.gltf has it. */
export type OrbitDescription = Omit<Orbit, "target"> & { target: number[] };

export const readOrbit = ({ target, ...rest }: OrbitDescription): Orbit => ({
  ...rest,
  target: [target[0] as number, target[1] as number, target[2] as number],
});

export interface Camera {
  readonly position: Vec3;
  readonly target: Vec3;
  readonly fovDeg: number;
  readonly width: number;
  readonly height: number;
  /** Pixels by which the target stands to the left of the picture's middle. */
  readonly shift?: number;
}

export const pointOf = (orbit: Orbit): ViewPoint => ({
  azimuth_deg: orbit.azimuthDeg,
  elevation_deg: orbit.elevationDeg,
  distance: orbit.distance,
});

/** Where the camera stands at a point. */
export function positionAt(orbit: Orbit, point: ViewPoint): Vec3 {
  const phi = (point.azimuth_deg * Math.PI) / 180;
  const theta = (point.elevation_deg * Math.PI) / 180;
  const offset: Vec3 = [Math.cos(phi) * Math.cos(theta), Math.sin(theta), -Math.sin(phi) * Math.cos(theta)];
  return [
    orbit.target[0] + point.distance * offset[0],
    orbit.target[1] + point.distance * offset[1],
    orbit.target[2] + point.distance * offset[2],
  ];
}

export function cameraAt(orbit: Orbit, point: ViewPoint, width: number, height: number): Camera {
  return { position: positionAt(orbit, point), target: orbit.target, fovDeg: orbit.fovDeg, width, height };
}

/** The ray through pixel coordinates (x, y) is corner + x·dx + y·dy. */
export interface RayBasis {
  readonly corner: Vec3;
  readonly dx: Vec3;
  readonly dy: Vec3;
}

function frameOf(camera: Camera): { right: Vec3; up: Vec3; forward: Vec3 } {
  const forward = normalize(subtract(camera.target, camera.position));
  const right = normalize(cross(forward, UP));
  return { right, up: cross(right, forward), forward };
}

/** Rows of the rotation into the camera's frame: right, up and back. */
export function viewFromWorld(camera: Camera): readonly [Vec3, Vec3, Vec3] {
  const { right, up, forward } = frameOf(camera);
  return [right, up, scale(forward, -1)];
}

export function rayBasis(camera: Camera): RayBasis {
  const { right, up, forward } = frameOf(camera);
  const half = Math.tan((camera.fovDeg * Math.PI) / 180 / 2);
  const dx = scale(right, (2 * half) / camera.height);
  const dy = scale(up, (-2 * half) / camera.height);
  const corner = subtract(
    subtract(forward, scale(dx, camera.width / 2 - (camera.shift ?? 0))),
    scale(dy, camera.height / 2),
  );
  return { corner, dx, dy };
}

/**
 * Rows (x, y, z) that take a point v from the eye to its depth z·v and pixel (x·v, y·v)/(z·v): the inverse of the matrix
 * with columns dx, dy, corner.
 */
export function pixelFromView({ corner, dx, dy }: RayBasis): readonly [Vec3, Vec3, Vec3] {
  const determinant = dot(dx, cross(dy, corner));
  const row = (a: Vec3, b: Vec3): Vec3 => {
    const [x, y, z] = cross(a, b);
    return [x / determinant, y / determinant, z / determinant];
  };
  return [row(dy, corner), row(corner, dx), row(dx, dy)];
}

/** Columns of the matrix to clip space with reversed depth and an infinite far plane. */
export function clipFromWorld(camera: Camera): number[] {
  const { right, up, forward } = frameOf(camera);
  const y = 1 / Math.tan((camera.fovDeg * Math.PI) / 180 / 2);
  const x = (y * camera.height) / camera.width;
  const near = NEAR_SHARE * length(subtract(camera.target, camera.position));
  const row = (axis: Vec3, k: number) => [...scale(axis, k), -k * dot(axis, camera.position)];
  const depth = row(forward, 1);
  const shift = (2 * (camera.shift ?? 0)) / camera.width;
  const across = row(right, x).map((value, k) => value - shift * (depth[k] as number));
  const rows = [across, row(up, y), [0, 0, 0, near], depth];
  return [0, 1, 2, 3].flatMap((column) => rows.map((r) => r[column] as number));
}
