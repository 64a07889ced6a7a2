// Half floats, which WebGPU's textures hold.

const LARGEST = 65504;
const BELOW = 0x38800000; // bits of 2^-14, from where on halves lie as close as floats of 10 bits do
const HALF_BITS = 0x3f000000; // of 0.5, whose neighbours are 2^-24 apart as small halves are

const float = new Float32Array(1);
const bits = new Uint32Array(float.buffer);

/** The bits of the half float nearest to a float from 0 to 65504, ties to even. */
export function halfFromFloat(value: number): number {
  float[0] = value;
  const whole = bits[0] as number;
  if (whole < BELOW) {
    float[0] = value + 0.5;
    return (bits[0] as number) - HALF_BITS;
  }
  return (whole - 0x38000000 + 0xfff + ((whole >>> 13) & 1)) >>> 13;
}

/** RGB as half-float RGBA, alpha 1, clamped to what half floats hold. */
export function halfTexels(rgb: Float32Array): Uint16Array<ArrayBuffer> {
  const out = new Uint16Array((rgb.length / 3) * 4).fill(halfFromFloat(1));
  for (let k = 0; k < rgb.length; k++) {
    out[Math.floor(k / 3) * 4 + (k % 3)] = halfFromFloat(Math.min(Math.max(rgb[k] as number, 0), LARGEST));
  }
  return out;
}
