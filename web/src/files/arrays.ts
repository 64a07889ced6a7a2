// Arrays of binary files: plain, or as zlib streams; FORMAT.md describes the encodings.

/** An array in a binary file. */
export interface ArrayDescription {
  uri: string;
  byteOffset: number;
  shape: number[];
  encoding?: string;
  byteLength?: number;
}

export type NumberArray = Uint8Array | Int16Array | Uint16Array | Uint32Array | Float32Array;
export interface ArrayOf<T extends NumberArray> {
  new (buffer: ArrayBuffer, byteOffset: number, length: number): T;
  readonly BYTES_PER_ELEMENT: number;
}

const MOST = 1032; // bytes that one byte of a zlib stream can stand for: whatever claims more is damaged

/** The array that a file holds. Rejects with one sentence where it does not hold it; memory is bounded by the file. */
export async function arrayOf<T extends NumberArray>(
  type: ArrayOf<T>,
  { uri, byteOffset, shape, encoding, byteLength }: ArrayDescription,
  data: ArrayBuffer,
): Promise<T> {
  const size = type.BYTES_PER_ELEMENT;
  const count = shape.reduce((a, b) => a * b, 1);
  const length = encoding === undefined ? count * size : (byteLength ?? 0);
  if (!(byteOffset + length <= data.byteLength)) throw new Error(`${uri} is truncated.`);
  if (encoding === undefined) return new type(data, byteOffset, count);
  const bytes = await inflated(new Uint8Array(data, byteOffset, length), count * size, uri);
  if (encoding === "deflate") return new type(bytes, 0, count);
  if (encoding === "delta") return new type(summed(new Uint8Array(bytes), count, size), 0, count);
  throw new Error(`An array of ${uri} is encoded by ${encoding}, which this viewer does not know.`);
}

/** `size` bytes of a zlib stream, neither more nor less. */
async function inflated(packed: Uint8Array<ArrayBuffer>, size: number, uri: string): Promise<ArrayBuffer> {
  const broken = () => new Error(`${uri} is truncated or damaged: one of its arrays does not unpack.`);
  if (!(size <= MOST * packed.length)) throw broken();
  const out = new Uint8Array(size);
  const reader = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate")).getReader();
  let filled = 0;
  for (;;) {
    const { done, value } = await reader.read().catch(() => {
      throw broken();
    });
    if (done) break;
    if (filled + value.length > size) {
      reader.cancel().catch(() => {});
      throw broken();
    }
    out.set(value, filled);
    filled += value.length;
  }
  if (filled < size) throw broken();
  return out.buffer;
}

/** Whole numbers of `size` bytes from byte planes of their differences, signs in the lowest bit. */
function summed(planes: Uint8Array, count: number, size: number): ArrayBuffer {
  const words = new Uint32Array(count);
  for (let plane = size - 1; plane >= 0; plane--) {
    for (let k = 0; k < count; k++) words[k] = ((words[k] as number) << 8) | (planes[plane * count + k] as number);
  }
  let sum = 0;
  for (let k = 0; k < count; k++) {
    const folded = words[k] as number;
    sum = (sum + ((folded >>> 1) ^ -(folded & 1))) | 0;
    words[k] = sum;
  }
  if (size === 4) return words.buffer;
  return size === 2 ? new Uint16Array(words).buffer : new Uint8Array(words).buffer;
}
