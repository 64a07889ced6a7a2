// The boxes that an AVIF file is made of, one of our own among them: twin of reflet.pem.coding.boxes.

const OURS = "6a1c2f7e3b0d5d5a9d0e52454d415031";
const NESTS = new Map([
  ["meta", 4],
  ["iprp", 0],
  ["ipco", 0],
]);
const SEQUENCE_HEADER = 1;

export interface Picture {
  readonly rows: number;
  readonly columns: number;
}

/** What an AVIF file of ours says before anything is decoded: our own box, and the sizes that its headers announce. */
export interface AvifHeaders {
  readonly own: Uint8Array;
  readonly announced: readonly Picture[];
}

/** Throws where a box is missing or cut short. */
export function readBoxes(file: Uint8Array): AvifHeaders {
  const announced: Picture[] = [];
  let own: Uint8Array | undefined;
  let pictures = 0;
  for (const { kind, contents } of boxes(file)) {
    if (kind === "uuid" && hex(contents.subarray(0, 16)) === OURS) own = contents.subarray(16);
    if (kind === "ispe") announced.push({ rows: uint32(contents, 8), columns: uint32(contents, 4) });
    if (kind === "mdat") {
      pictures += 1;
      announced.push(sequencePicture(contents));
    }
  }
  if (own === undefined || pictures !== 1) throw new Error("not a single picture with a box of ours");
  return { own, announced };
}

function* boxes(data: Uint8Array): Generator<{ kind: string; contents: Uint8Array }> {
  for (let at = 0; at < data.length; ) {
    const size = at + 8 <= data.length ? uint32(data, at) : 0;
    if (size < 8 || at + size > data.length) throw new Error("a box is cut short");
    const kind = String.fromCharCode(...data.subarray(at + 4, at + 8));
    const contents = data.subarray(at + 8, at + size);
    yield { kind, contents };
    const skipped = NESTS.get(kind);
    if (skipped !== undefined) yield* boxes(contents.subarray(skipped));
    at += size;
  }
}

/** By the sequence header of a still picture in AV1's low-overhead format. */
function sequencePicture(units: Uint8Array): Picture {
  for (let at = 0; at + 2 <= units.length; ) {
    const head = units[at] as number;
    at += 1 + ((head >> 2) & 1);
    let size = 0;
    for (let shift = 0, more = (head >> 1) & 1; more && at < units.length; shift += 7) {
      const byte = units[at++] as number;
      size += (byte & 127) * 2 ** shift;
      more = byte >> 7;
    }
    if (((head >> 3) & 15) === SEQUENCE_HEADER) return stillPicture(units.subarray(at, at + size));
    at += size;
  }
  throw new Error("no AV1 picture");
}

function stillPicture(header: Uint8Array): Picture {
  const bits = Array.from(header, (byte) => byte.toString(2).padStart(8, "0")).join("");
  const number = (from: number, count: number) => Number.parseInt(bits.slice(from, from + count), 2) + 1;
  const [wide, high] = [number(10, 4), number(14, 4)];
  if (!bits.startsWith("00011") || bits.length < 18 + wide + high) throw new Error("no AV1 still picture");
  return { columns: number(18, wide), rows: number(18 + wide, high) };
}

function uint32(data: Uint8Array, at: number): number {
  if (at + 4 > data.length) throw new Error("a box is cut short");
  return new DataView(data.buffer, data.byteOffset + at, 4).getUint32(0);
}

const hex = (data: Uint8Array) => Array.from(data, (byte) => byte.toString(16).padStart(2, "0")).join("");
