// Radiance coded as AV1 pictures: twin of reflet.pem.coding, whose integers and half floats this gives. FORMAT.md describes it.

import { halfFromFloat } from "../maths/half";
import { levelCount, type MapShape, PARAMETERIZATIONS } from "../maths/parameterization";
import { type Picture, readBoxes } from "./boxes";

const STEPS = 16 * 255; // decoded colours are counted in sixteenths of a code
const ROWS_CODED = 4; // levels with fewer rows are stored as they are
const ONE = halfFromFloat(1);

/** Where texels lie in a picture: `places` are numbers of pixels, row by row. */
interface Layout extends Picture {
  readonly places: Uint32Array;
  /** Number of the first texel that is stored as it is. */
  readonly exactFrom: number;
}

/** The mip levels of a coded map, finest first, each with all faces in half-float RGBA. Rejects with one sentence. */
export async function codedMapLevels(
  file: ArrayBuffer,
  shape: MapShape,
  channels: 3 | 4,
  name: string,
): Promise<Uint8Array[]> {
  const layout = atlas(shape);
  const texels = await decode(file, layout, channels, name);
  const { aspect, faceCount } = PARAMETERIZATIONS[shape.parameterization];
  let at = 0;
  return Array.from({ length: levelCount(shape) }, (_, level) => {
    const bytes = 8 * faceCount * aspect * (shape.size >> level) ** 2;
    at += bytes;
    return new Uint8Array(texels.buffer, at - bytes, bytes);
  });
}

/** A coded picture in half-float RGBA. Rejects with one sentence. */
export function codedPicture(
  file: ArrayBuffer,
  { rows, columns }: Picture,
  name: string,
): Promise<Uint16Array<ArrayBuffer>> {
  const places = Uint32Array.from({ length: rows * columns }, (_, k) => k);
  return decode(file, { rows, columns, places, exactFrom: places.length }, 3, name);
}

/** Twin of reflet.pem.coding.atlas. */
function atlas({ parameterization, size }: MapShape): Layout {
  const { aspect, faceCount } = PARAMETERIZATIONS[parameterization];
  const [down, across] = faceCount === 6 ? [2, 3] : [1, faceCount];
  const width = across * aspect * size;
  const columns = width + Math.floor(width / 2);
  const places = new Uint32Array((faceCount * aspect * (4 * size * size - 1)) / 3);
  let [texel, top, left, exactFrom] = [0, 0, 0, -1];
  for (let rows = size; rows >= 1; rows >>= 1) {
    if (rows < ROWS_CODED && exactFrom < 0) exactFrom = texel;
    for (let face = 0; face < faceCount; face++) {
      for (let row = 0; row < rows; row++) {
        const first = top + Math.floor(face / across) * rows + row;
        const begin = first * columns + left + (face % across) * aspect * rows;
        for (let column = 0; column < aspect * rows; column++) places[texel++] = begin + column;
      }
    }
    [top, left] = rows === size ? [0, width] : [top + down * rows, left];
  }
  return { rows: down * size, columns, places, exactFrom };
}

async function decode(
  file: ArrayBuffer,
  layout: Layout,
  channels: 3 | 4,
  name: string,
): Promise<Uint16Array<ArrayBuffer>> {
  const count = layout.places.length;
  const exact = count - layout.exactFrom;
  const { own, announced } = headersOf(file, name);
  // A copy: numbers lie at multiples of their size.
  const beside = own.slice().buffer;
  const brightest = beside.byteLength < 16 ? 0 : (new Uint32Array(beside, 12, 1)[0] as number);
  const most = new Float32Array(beside.byteLength < 16 ? new ArrayBuffer(12) : beside, 0, 3);
  const largest = Math.max(...most);
  const hasGain = largest > 1;
  const planes = 3 + Number(hasGain) + Number(channels === 4);
  const rows = planes * layout.rows;
  if (
    beside.byteLength !== 16 + 10 * brightest + 2 * channels * exact ||
    !(Math.min(...most) >= 0 && largest <= 65504) ||
    announced.some((picture) => picture.rows !== rows || picture.columns !== layout.columns)
  ) {
    throw new Error(`${name} does not hold what scene.gltf says, or is damaged.`);
  }
  const pixels = await greyPixels(file, { rows, columns: layout.columns }, name);

  const white = most.map((each) => each / Math.fround(Math.max(largest, 1)));
  const linear = Float32Array.from({ length: STEPS + 1 }, (_, k) => linearFromSrgb(k / STEPS));
  const channel = Array.from(white, (each) => linear.map((value) => each * value)) as [
    Float32Array,
    Float32Array,
    Float32Array,
  ];
  const gains = Float32Array.from({ length: 256 }, (_, code) => Math.max(largest, 1) ** (code / 255));
  const alphas = Uint16Array.from({ length: 256 }, (_, code) => halfFromFloat(Math.fround(code / 255)));
  const plane = 4 * layout.rows * layout.columns;
  const [ofGain, ofAlpha] = [3 * plane, (planes - 1) * plane];
  const clamp = (code: number) => (code < 0 ? 0 : Math.min(code, STEPS));
  const out = new Uint16Array(4 * count);
  for (let texel = 0; texel < count; texel++) {
    const at = 4 * (layout.places[texel] as number);
    const y = 4096 * (pixels[at] as number) + 128;
    const cb = (pixels[at + plane] as number) - 128;
    const cr = (pixels[at + 2 * plane] as number) - 128;
    const gain = hasGain ? (gains[pixels[at + ofGain] as number] as number) : 1;
    const [red, green, blue] = channel;
    out[4 * texel] = halfFromFloat((red[clamp((y + 6450 * cr) >> 8)] as number) * gain);
    out[4 * texel + 1] = halfFromFloat((green[clamp((y - 767 * cb - 1917 * cr) >> 8)] as number) * gain);
    out[4 * texel + 2] = halfFromFloat((blue[clamp((y + 7601 * cb) >> 8)] as number) * gain);
    out[4 * texel + 3] = channels === 4 ? (alphas[pixels[at + ofAlpha] as number] as number) : ONE;
  }
  const numbers = new Uint32Array(beside, 16, brightest);
  const halves = new Uint16Array(beside, 16 + 4 * brightest);
  numbers.forEach((texel, k) => {
    if (texel < count) out.set(halves.subarray(3 * k, 3 * k + 3), 4 * texel);
  });
  for (let k = 0; k < exact; k++) {
    const from = 3 * brightest + channels * k;
    out.set(halves.subarray(from, from + channels), 4 * (layout.exactFrom + k));
  }
  return out;
}

function headersOf(file: ArrayBuffer, name: string): ReturnType<typeof readBoxes> {
  try {
    return readBoxes(new Uint8Array(file));
  } catch {
    throw new Error(`${name} is not a coded map or picture of reflet's, or is truncated.`);
  }
}

/** The grey picture of an AVIF file, four equal bytes a pixel but for the last. */
async function greyPixels(file: ArrayBuffer, { rows, columns }: Picture, name: string): Promise<Uint8Array> {
  const options: ImageBitmapOptions = { colorSpaceConversion: "none", premultiplyAlpha: "none" };
  const instead = "try another browser, or write the maps again by reflet encode --codec none.";
  if (typeof VideoFrame === "undefined") {
    throw new Error(`${name} cannot be decoded: this browser lacks WebCodecs' VideoFrame; ${instead}`);
  }
  const bitmap = await createImageBitmap(new Blob([file], { type: "image/avif" }), options).catch(() => {
    throw new Error(`${name} is damaged, or this browser knows no AVIF pictures; ${instead}`);
  });
  // Not through a canvas: some browsers change what is read from one, lest it tell who reads.
  const frame = new VideoFrame(bitmap, { timestamp: 0 });
  bitmap.close();
  const pixels = new Uint8Array(4 * rows * columns);
  try {
    if (!["RGBA", "RGBX", "BGRA", "BGRX"].includes(frame.format ?? "") || frame.codedWidth !== columns) {
      throw new Error(
        `This browser decodes pictures as ${frame.format}, which the viewer cannot read; try another one.`,
      );
    }
    await frame.copyTo(pixels, { layout: [{ offset: 0, stride: 4 * columns }] });
  } finally {
    frame.close();
  }
  return pixels;
}

const linearFromSrgb = (y: number) => (y <= 12.92 * 0.0031308 ? y / 12.92 : ((y + 0.055) / 1.055) ** 2.4);
