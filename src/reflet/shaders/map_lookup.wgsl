#import parameterization
#import cube_lod

// Lookups in maps of any parameterization: their LOD (twin of reflet.envmap.lod) and the texture filter (twin of
// reflet.envmap.texture_filter), seamless and with float weights on every device.

// LOD of a lookup in direction d, from the directions dx and dy of the neighbours right and down; all of any length.
fn map_lod(kind: u32, d: vec3f, dx: vec3f, dy: vec3f, size: f32, lod_bias: f32, max_lod: f32) -> f32 {
  if (kind == CUBE) {
    return cube_lod(d, dx, dy, size, lod_bias, max_lod);
  }
  let n = normalize(d);
  let right = normalize(dx) - n;
  let down = normalize(dy) - n;
  let rho_squared = max(dot(right, right), dot(down, down)) * sampling_rate(kind, n) * size * size;
  return clamp(0.5 * log2(max(rho_squared, 1e-12)) + lod_bias, 0.0, max_lod);
}

// The same by the nearer of the two neighbours.
fn map_lod_nearer(kind: u32, d: vec3f, dx: vec3f, dy: vec3f, size: f32, lod_bias: f32, max_lod: f32) -> f32 {
  return min(map_lod(kind, d, dx, dx, size, lod_bias, max_lod), map_lod(kind, d, dy, dy, size, lod_bias, max_lod));
}

const EVEN_CUBE = 0.4052847345693511;  // texels a steradian of a cube of size 1 whose texels were π/2 of its rows apart

// LOD of a lobe that is looked up in direction d, and whose tilted rays are in dx and dy: by the mean of their angles. Twin of
// the end of reflet.envmap.compiled_lookup.place.
fn lobe_lod(kind: u32, d: vec3f, dx: vec3f, dy: vec3f, size: f32, max_lod: f32) -> f32 {
  let n = normalize(d);
  let right = normalize(dx) - n;
  let down = normalize(dy) - n;
  var rate = EVEN_CUBE;
  if (kind != CUBE) {
    rate = sampling_rate(kind, n);
  }
  let rho_squared = sqrt(dot(right, right) * dot(down, down)) * rate * size * size;
  return clamp(0.5 * log2(max(rho_squared, 1e-12)), 0.0, max_lod);
}

// Trilinear lookup in direction d of any length; a map's faces are array layers from first_layer on. `lod` lies in
// [0, levels - 1].
fn sample_map(kind: u32, maps: texture_2d_array<f32>, first_layer: i32, d: vec3f, lod: f32) -> vec4f {
  let at = map_point(kind, d);
  let finer = i32(lod);
  let fine = sample_level(kind, maps, first_layer, at, finer);
  let fraction = lod - f32(finer);
  if (fraction == 0.0) {
    return fine;
  }
  return mix(fine, sample_level(kind, maps, first_layer, at, finer + 1), fraction);
}

// Bilinear lookup in one level. Where a cube's corner lacks one of four texels, the mean of the others stands for it.
fn sample_level(kind: u32, maps: texture_2d_array<f32>, first_layer: i32, at: MapPoint, level: i32) -> vec4f {
  // Shifted, not asked for: Mesa's llvmpipe answers for all pixels of a group what it answers for the first.
  let extent = max(vec2i(textureDimensions(maps)) >> vec2u(u32(level)), vec2i(1));
  let place = at.uv * vec2f(extent) - 0.5;
  let low = clamp(vec2i(floor(place)), vec2i(-1), extent - 1);
  let share = place - vec2f(low);
  var sum = vec4f(0.0);
  var weighted = vec4f(0.0);
  var missing = 0.0;
  for (var k = 0; k < 4; k++) {
    let step = vec2i(k & 1, k >> 1u);
    let weights = select(1.0 - share, share, step == vec2i(1));
    let weight = weights.x * weights.y;
    let texel = across_seams(kind, i32(at.face), low + step, extent.y);
    if (texel.z < 0) {
      missing = weight;
    } else {
      let value = textureLoad(maps, texel.xy, first_layer + texel.z, level);
      sum += value;
      weighted += weight * value;
    }
  }
  return weighted + missing / 3.0 * sum;
}

// The same by quadratic B-splines, nine texels: no jumps of the gradient give away where texels are, and light spreads by half
// a texel. Where a cube's corner lacks a texel, the others stand for it.
fn sample_level_smoothly(kind: u32, maps: texture_2d_array<f32>, first_layer: i32, at: MapPoint, level: i32) -> vec4f {
  let extent = max(vec2i(textureDimensions(maps)) >> vec2u(u32(level)), vec2i(1));
  let place = at.uv * vec2f(extent);
  let middle = clamp(vec2i(floor(place)), vec2i(0), extent - 1);
  let share = place - vec2f(middle);
  let low = 0.5 * (1.0 - share) * (1.0 - share);
  let high = 0.5 * share * share;
  var sum = vec4f(0.0);
  var present = 0.0;
  for (var k = 0; k < 9; k++) {
    let step = vec2i(k % 3, k / 3) - 1;
    let weights = select(select(low, high, step == vec2i(1)), 1.0 - low - high, step == vec2i(0));
    let texel = across_seams(kind, i32(at.face), middle + step, extent.y);
    if (texel.z >= 0) {
      let weight = weights.x * weights.y;
      sum += weight * textureLoad(maps, texel.xy, first_layer + texel.z, level);
      present += weight;
    }
  }
  return sum / present;
}
