// Buffer views in the code of EXT_meshopt_compression.

import { MeshoptDecoder } from "meshoptimizer/decoder";

/** The extension's description of a view. */
export interface PackedView {
  buffer: number;
  byteOffset?: number;
  byteLength: number;
  byteStride: number;
  count: number;
  mode: string;
  filter?: string;
}

const RATIO = 2048; // its densest code spends 2 bits on 256 bytes: whatever claims more is damaged

/** The view's bytes. Rejects with one sentence where the file does not hold them. */
export async function unpacked(view: PackedView, data: ArrayBuffer, uri: string): Promise<ArrayBuffer> {
  const { byteOffset = 0, byteLength, byteStride, count, mode, filter } = view;
  const size = count * byteStride;
  if (!(byteOffset + byteLength <= data.byteLength)) throw new Error(`${uri} is truncated.`);
  if (!(size <= RATIO * byteLength))
    throw new Error(`${uri} is damaged: ${byteLength} bytes hold no ${count} elements.`);
  await MeshoptDecoder.ready;
  const out = new Uint8Array(size);
  try {
    const packed = new Uint8Array(data, byteOffset, byteLength);
    if (count > 0) MeshoptDecoder.decodeGltfBuffer(out, count, byteStride, packed, mode, filter);
  } catch {
    throw new Error(`${uri} is truncated or damaged: one of its meshes does not unpack.`);
  }
  return out.buffer;
}

/** Normalized int16 of 4 components, of which the first `width` count, as floats [glTF 2.0, 3.6.2.2]. */
export function fractions(data: ArrayBuffer, count: number, width: number): Float32Array {
  const stored = new Int16Array(data, 0, 4 * count);
  const out = new Float32Array(count * width);
  for (let k = 0; k < count; k++) {
    for (let c = 0; c < width; c++) out[k * width + c] = Math.max((stored[4 * k + c] as number) / 32767, -1);
  }
  return out;
}
