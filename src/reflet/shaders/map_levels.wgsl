// Program: the next mip level of an env map of any parameterization, each texel the mean of the four below it, weighted
// by solid angle (twin of reflet.envmap.mip_reduction). One thread a texel, z = face.
//
//   bind group 0   0 texture_2d_array<f32>: the level above alone   1 storage texture: this level
//                  2 texture_2d_array<f32>: the weights of the texels above

@group(0) @binding(0) var finer: texture_2d_array<f32>;
@group(0) @binding(1) var coarser: texture_storage_2d_array<rgba16float, write>;
@group(0) @binding(2) var weights: texture_2d_array<f32>;

@compute @workgroup_size(8, 8)
fn next_map_level(@builtin(global_invocation_id) id: vec3u) {
  let texel = vec2i(id.xy);
  let face = i32(id.z);
  if (any(texel >= vec2i(textureDimensions(coarser)))) {
    return;
  }
  var sum = vec4f(0.0);
  var flux = vec4f(0.0);
  var weight = 0.0;
  for (var k = 0; k < 4; k++) {
    let at = 2 * texel + vec2i(k & 1, k >> 1u);
    let value = textureLoad(finer, at, face, 0);
    let share = textureLoad(weights, at, face, 0).x;
    sum += value;
    flux += share * value;
    weight += share;
  }
  // Beyond the rim of a round map there is no solid angle, but its continuation.
  textureStore(coarser, texel, face, select(0.25 * sum, flux / weight, weight > 0.0));
}
