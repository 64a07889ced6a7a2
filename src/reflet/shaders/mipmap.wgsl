// Program: the next mip level of a picture texture, each texel the mean of the four below it (the sampler is linear and
// clamps). Draw three vertices into the level; the bound view shows the level above alone.
//
//   bind group 0   0 texture_2d<f32>   1 filtering sampler

@group(0) @binding(0) var finer: texture_2d<f32>;
@group(0) @binding(1) var finer_sampler: sampler;

@vertex
fn vertex_mipmap(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
  return vec4f(vec2f(f32(vertex & 1u), f32(vertex >> 1u)) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn next_level(@builtin(position) position: vec4f) -> @location(0) vec4f {
  let size = vec2f(max(textureDimensions(finer) / 2u, vec2u(1u)));
  return textureSampleLevel(finer, finer_sampler, position.xy / size, 0.0);
}
