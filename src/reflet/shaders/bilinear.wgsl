// Bilinear filtering by four loads: exact weights on every device, where texture units may round them to 8 bits.

// How an image goes on beyond its edges: along u in the lowest two bits, along v in the next. 0 it repeats, 1 it clamps, 2 it
// repeats mirrored.
const CLAMPS = 5u;

fn wrapped(i: vec2i, size: vec2i, wraps: u32) -> vec2i {
  let period = 2 * size;
  let there = ((i % period) + period) % period;
  let kind = vec2u(wraps, wraps >> 2u) & vec2u(3u);
  let mirrored = min(there, period - 1 - there);
  return select(select(there % size, clamp(i, vec2i(0), size - 1), kind == vec2u(1u)), mirrored, kind == vec2u(2u));
}

// Level 0 of an image at uv (origin top left).
fn bilinear(image: texture_2d<f32>, uv: vec2f, wraps: u32) -> vec4f {
  let size = vec2i(textureDimensions(image));
  let at = uv * vec2f(size) - 0.5;
  let corner = floor(at);
  let w = at - corner;
  let low = wrapped(vec2i(corner), size, wraps);
  let high = wrapped(vec2i(corner) + 1, size, wraps);
  let top = mix(textureLoad(image, low, 0), textureLoad(image, vec2i(high.x, low.y), 0), w.x);
  let bottom = mix(textureLoad(image, vec2i(low.x, high.y), 0), textureLoad(image, high, 0), w.x);
  return mix(top, bottom, w.y);
}

// Four texels of a picture in a layer of an atlas, and how far the point lies between them.
struct Taps4 {
  low: vec2i,
  high: vec2i,
  layer: u32,
  weight: vec2f,
}

// `place` is the picture's: column, row, layer, width + 65536 height.
fn taps_in(place: vec4u, uv: vec2f, wraps: u32) -> Taps4 {
  let corner = vec2i(place.xy);
  let size = vec2i(i32(place.w & 0xffffu), i32(place.w >> 16u));
  let at = uv * vec2f(size) - 0.5;
  let low = floor(at);
  return Taps4(
    corner + wrapped(vec2i(low), size, wraps), corner + wrapped(vec2i(low) + 1, size, wraps), place.z, at - low);
}

fn taps_of(atlas: texture_2d_array<f32>, taps: Taps4) -> array<vec4f, 4> {
  return array<vec4f, 4>(
    textureLoad(atlas, taps.low, taps.layer, 0), textureLoad(atlas, vec2i(taps.high.x, taps.low.y), taps.layer, 0),
    textureLoad(atlas, vec2i(taps.low.x, taps.high.y), taps.layer, 0), textureLoad(atlas, taps.high, taps.layer, 0));
}

fn bilinear_in(atlas: texture_2d_array<f32>, place: vec4u, uv: vec2f, wraps: u32) -> vec4f {
  let taps = taps_in(place, uv, wraps);
  let texels = taps_of(atlas, taps);
  return mix(mix(texels[0], texels[1], taps.weight.x), mix(texels[2], texels[3], taps.weight.x), taps.weight.y);
}
