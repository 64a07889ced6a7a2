// Bilinear filtering by four loads: exact weights on every device, where texture units may round them to 8 bits.

fn wrapped(i: vec2i, size: vec2i, clamps: bool) -> vec2i {
  return select(((i % size) + size) % size, clamp(i, vec2i(0), size - 1), clamps);
}

// Level 0 of an image at uv (origin top left).
fn bilinear(image: texture_2d<f32>, uv: vec2f, clamps: bool) -> vec4f {
  let size = vec2i(textureDimensions(image));
  let at = uv * vec2f(size) - 0.5;
  let corner = floor(at);
  let w = at - corner;
  let low = wrapped(vec2i(corner), size, clamps);
  let high = wrapped(vec2i(corner) + 1, size, clamps);
  let top = mix(textureLoad(image, low, 0), textureLoad(image, vec2i(high.x, low.y), 0), w.x);
  let bottom = mix(textureLoad(image, vec2i(low.x, high.y), 0), textureLoad(image, high, 0), w.x);
  return mix(top, bottom, w.y);
}
