// What mirrored rays meet, on the device: twin of reflet.render.playback.hit_buffers, described in bvh.wgsl and traced.wgsl.

import type { Part } from "../../files/gltf";
import type { Bvh, Traced } from "../../scene/pem";
import { coatOf, METAL, partBits, picturesOf, sampling } from "./layouts";
import { type PicturePlace, pictureAtlas } from "./picture-atlas";

const MATERIAL_WORDS = 40;
const MOST_DEPTH = 32; // inner nodes above a leaf, as bvh.wgsl has room for
const LARGEST_LEAF = 4;

const DAMAGED = "bvh.bin is damaged: its tree is none over this scene's mirrors; copy it again, or bake again.";

export interface HitBuffers {
  readonly bvh: Uint32Array;
  readonly directions: Uint32Array;
  readonly materials: Uint32Array;
  readonly pictures: GPUTexture;
  /** All bits that any material has. */
  readonly bits: number;
}

/** Of a PEM that is not traced next to nothing. Throws where the tree is none over its mirrors. */
export function createHitBuffers(
  device: GPUDevice,
  parts: readonly Part[],
  extras: readonly number[],
  traced: Traced | undefined,
): HitBuffers {
  const isMet = ({ reflective }: Part, number: number) =>
    traced !== undefined && (reflective || isCompanion(traced.bvh, number));
  const met = parts.filter(isMet);
  const materials = createMaterials(
    device,
    met.map((part) => (part.reflective ? part : matte(part))),
    extras.filter((_, number) => isMet(parts[number] as Part, number)),
  );
  if (!traced) return { bvh: new Uint32Array(0), directions: new Uint32Array(0), ...materials };
  const triangles = parts.reduce((sum, { indices }) => sum + indices.length / 3, 0);
  const directions = new Uint32Array(2 * triangles);
  traced.bvh.order.forEach((triangle, k) => {
    directions.set(traced.bvh.directions.subarray(2 * k, 2 * k + 2), 2 * triangle);
  });
  return { bvh: bvhWords(parts, traced.bvh), directions, ...materials };
}

const isCompanion = ({ companions = [] }: Bvh, part: number): boolean => companions.includes(part);

/** A part that does not reflect without what only mirrors have: its light is diffuse, of metals too. */
function matte(part: Part): Part {
  const none = { metallic: 0, metallicRoughnessTexture: undefined };
  return { ...part, material: { ...part.material, ...none } };
}

/** Nodes, refitted to the meshes, and triangles. */
export function bvhWords(parts: readonly Part[], bvh: Bvh): Uint32Array {
  const { order, leafCounts } = bvh;
  const [nodes, count] = [leafCounts.length, order.length];
  const words = new Uint32Array(8 * nodes + 12 * count);
  const floats = new Float32Array(words.buffer);
  const corners = new Float32Array(9 * count);
  const placeOf = new Int32Array(parts.reduce((sum, { indices }) => sum + indices.length / 3, 0)).fill(-1);
  order.forEach((triangle, place) => {
    placeOf[triangle] = place;
  });
  let [first, material, found] = [0, 0, 0];
  for (const [number, { reflective, indices, positions }] of parts.entries()) {
    const isMet = reflective || isCompanion(bvh, number);
    for (let t = 0; isMet && t < indices.length / 3; t++) {
      const place = placeOf[first + t] as number;
      if (place < 0) throw new Error(DAMAGED);
      found++;
      const at = 8 * nodes + 12 * place;
      for (let k = 0; k < 9; k++) {
        const value = positions[3 * (indices[3 * t + Math.floor(k / 3)] as number) + (k % 3)] as number;
        corners[9 * place + k] = value;
        floats[at + 4 * Math.floor(k / 3) + (k % 3)] = k < 3 ? value : value - (corners[9 * place + (k % 3)] as number);
      }
      words[at + 3] = first + t;
      words[at + 7] = material;
    }
    first += indices.length / 3;
    material += Number(isMet);
  }
  if (found !== count) throw new Error(DAMAGED);
  const links = linksOf(leafCounts, count);
  for (let i = nodes - 1; i >= 0; i--) {
    const [inside, link] = [leafCounts[i] as number, links[i] as number];
    words[8 * i + 3] = inside ? 2 * nodes + 3 * link : 2 * link;
    words[8 * i + 7] = inside;
    for (let k = 0; k < 3; k++) {
      let [lower, upper] = [Number.POSITIVE_INFINITY, Number.NEGATIVE_INFINITY];
      for (let c = 9 * link + k; c < 9 * (link + inside); c += 3) {
        lower = Math.min(lower, corners[c] as number);
        upper = Math.max(upper, corners[c] as number);
      }
      for (const child of inside ? [] : [i + 1, link]) {
        lower = Math.min(lower, floats[8 * child + k] as number);
        upper = Math.max(upper, floats[8 * child + 4 + k] as number);
      }
      floats[8 * i + k] = lower;
      floats[8 * i + 4 + k] = upper;
    }
  }
  return words;
}

/** Of a leaf its first triangle, of an inner node its second child. */
function linksOf(leafCounts: Uint8Array, triangles: number): Uint32Array {
  const links = new Uint32Array(leafCounts.length);
  const waiting: { node: number; depth: number }[] = []; // for their second child
  let [depth, triangle] = [0, 0];
  leafCounts.forEach((count, i) => {
    if (i > 0 && leafCounts[i - 1]) {
      const parent = waiting.pop();
      if (!parent) throw new Error(DAMAGED);
      links[parent.node] = i;
      depth = parent.depth + 1;
    }
    if (count > LARGEST_LEAF || (count === 0 && depth === MOST_DEPTH)) throw new Error(DAMAGED);
    if (count === 0) waiting.push({ node: i, depth: depth++ });
    else links[i] = triangle;
    triangle += count;
  });
  if (waiting.length > 0 || triangle !== triangles || !leafCounts.at(-1)) throw new Error(DAMAGED);
  return links;
}

function createMaterials(
  device: GPUDevice,
  parts: readonly Part[],
  extras: readonly number[],
): { materials: Uint32Array; pictures: GPUTexture; bits: number } {
  const { texture: pictures, places } = pictureAtlas(device, parts.flatMap(picturesOf));
  const materials = new Uint32Array(MATERIAL_WORDS * Math.max(parts.length, 1)); // a binding may not be empty
  const floats = new Float32Array(materials.buffer);
  let bits = METAL;
  parts.forEach((part, k) => {
    const { baseColor, metallic, roughness, emission, normalScale, refraction } = part.material;
    const { alpha, cutoff, dielectric } = part.material;
    const at = MATERIAL_WORDS * k;
    floats.set([...baseColor, metallic, ...emission, normalScale], at);
    materials[at + 8] = partBits(part);
    materials.set([sampling(part), extras[k] as number], at + 10);
    if (refraction) {
      floats[at + 9] = refraction.transmission;
      floats.set([...refraction.absorption, refraction.index], at + 12);
    }
    floats.set([alpha, cutoff ?? 0, roughness], at + 16);
    const [share, coatRoughness] = (coatOf(part) && part.coatMean) ?? [0, 0];
    materials[at + 19] = Math.round(65535 * share) + 65536 * Math.round(65535 * coatRoughness);
    floats.set([...dielectric.f0, dielectric.f90], at + 20);
    bits |= partBits(part);
    picturesOf(part).forEach((picture, which) => {
      if (!picture) return;
      materials.set(places.get(picture.image) as PicturePlace, at + 24 + 4 * which);
    });
  });
  return { materials, pictures, bits };
}
