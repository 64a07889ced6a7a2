// Lights without extent on the device: twin of reflet.render.playback.punctual_lights, described in highlights.wgsl.

import type { PunctualLight } from "../../files/gltf-lights";
import type { Pem } from "../../scene/pem";

const LEAST_FADE = 1e-3; // of the cosines between which a cone fades

/** How many lights rough parts show: none where it is not known which samples see them. */
export const lightCount = ({ lights, visibility }: Pick<Pem, "lights" | "visibility">): number =>
  visibility.length > 0 ? lights.length : 0;

/** Their number, the lights, and the share of each that is seen from the samples of mesh colours. */
export function lightWords(pem: Pick<Pem, "lights" | "visibility">): Uint32Array {
  const count = lightCount(pem);
  const words = new Uint32Array(4 + 12 * count + 4 * Math.ceil(pem.visibility.length / 16));
  const floats = new Float32Array(words.buffer);
  words[0] = count;
  pem.lights.slice(0, count).forEach((light, k) => {
    floats.set(packed(light), 4 + 12 * k);
  });
  new Uint8Array(words.buffer).set(pem.visibility, 16 + 48 * count);
  return words;
}

/** Twin of reflet.scene.punctual_light.packed. */
export function packed({ intensity, position, direction, range, cone }: PunctualLight): number[] {
  const axis = direction.map((value) => -value);
  const rows = [...intensity, 1 / range, ...(position ? [...position, 1] : [...axis, 0])];
  if (cone === undefined) return [...rows, 0, 0, 0, 1];
  const [inner, outer] = cone.map(Math.cos) as [number, number];
  const scale = 1 / Math.max(inner - outer, LEAST_FADE);
  return [...rows, ...axis.map((value) => scale * value), -scale * outer];
}
