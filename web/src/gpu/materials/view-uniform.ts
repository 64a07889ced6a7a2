// Where pictures are drawn from: twin of reflet.render.meshes.views.

import { type Camera, clipFromWorld, NEAR_SHARE, rayBasis } from "../../maths/camera";
import { add, length, scale, subtract } from "../../maths/vectors";

export const VIEW_BYTES = 176;

/** `View` in view.wgsl, for a sample at (x, y) in each pixel; (0.5, 0.5) is its middle. */
export function viewUniform(camera: Camera, [x, y]: readonly [number, number]): ArrayBuffer {
  const data = new ArrayBuffer(VIEW_BYTES);
  const floats = new Float32Array(data);
  const clip = clipFromWorld(camera);
  for (let column = 0; column < 4; column++) {
    // What the sample sees moves to the pixel's middle.
    const w = clip[4 * column + 3] as number;
    clip[4 * column] = (clip[4 * column] as number) - ((2 * (x - 0.5)) / camera.width) * w;
    clip[4 * column + 1] = (clip[4 * column + 1] as number) + ((2 * (y - 0.5)) / camera.height) * w;
  }
  const { corner, dx, dy } = rayBasis(camera);
  floats.set(clip, 0);
  floats.set([...camera.position, NEAR_SHARE * length(subtract(camera.target, camera.position))], 16);
  floats.set(add(corner, add(scale(dx, x - 0.5), scale(dy, y - 0.5))), 20);
  floats.set(dx, 24);
  floats.set(dy, 28);
  return data;
}
