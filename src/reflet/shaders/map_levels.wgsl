// Program: the next mip level of an env map of any parameterization, each texel the mean of the four that it covers, by
// their weights (twin of reflet.envmap.resampling.mip_reduction, `mean_weights`). One thread a texel, z = face.
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
  var total = 0.0;
  for (var k = 0; k < 4; k++) {
    let at = 2 * texel + vec2i(k & 1, k >> 1u);
    let value = textureLoad(finer, at, face, 0);
    let weight = textureLoad(weights, at, face, 0).x;
    sum += value;
    flux += weight * value;
    total += weight;
  }
  // Outside the disc of a sphere map nothing has weight.
  textureStore(coarser, texel, face, select(0.25 * sum, flux / total, total > 0.0));
}
