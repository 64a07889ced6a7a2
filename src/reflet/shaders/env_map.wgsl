#import map_lookup
#import ggx_lod

// Bind group 1 of programs that look up a plain env map. The host's side is `reflet.render.maps.env_map_texture`.
//
//   binding  resource                     stages     contents
//   0        uniform EnvMap, 64 bytes     fragment
//   1        texture_2d_array<f32>        fragment   the faces with all mip levels; read by loads, any float format
//   2        texture_cube<f32>            fragment   the same where the map is a cube that the hardware can filter
//   3        filtering sampler            fragment

struct EnvMap {
  map_from_world: mat3x3f,  // a rotation
  size: f32,                // rows of a face at level 0
  max_lod: f32,             // the last level
  lod_bias: f32,
  roughness: f32,           // perceptual_roughness of lookups in maps whose levels are filtered for it; -1 in others
}

// The map's parameterization, and whether binding 2 serves.
override KIND: u32 = 0u;
override BY_HARDWARE: bool = false;
// Levels of each size, one after the other in the layers of a mip level. More than one have maps filtered by roughness.
override LEVELS_A_SIZE: u32 = 1u;

@group(1) @binding(0) var<uniform> env_map: EnvMap;
@group(1) @binding(1) var maps: texture_2d_array<f32>;
@group(1) @binding(2) var cube: texture_cube<f32>;
@group(1) @binding(3) var cube_sampler: sampler;

// perceptual_roughness of a lobe widened by a pixel's footprint (twin of reflet.reflectance.materials.material_maps).
fn roughness_over(perceptual_roughness: f32, d: vec3f, dx: vec3f, dy: vec3f) -> f32 {
  let n = normalize(d);
  let right = normalize(dx) - n;
  let down = normalize(dy) - n;
  let square = perceptual_roughness * perceptual_roughness;
  return min(sqrt(sqrt(square * square + max(dot(right, right), dot(down, down)) / 24.0)), 1.0);
}

// What the map holds in a direction of its own, where the neighbouring pixels look up dx and dy. All of any length.
fn map_radiance(d: vec3f, dx: vec3f, dy: vec3f) -> vec4f {
  return map_radiance_widened(d, dx, dy, 1.0);
}

// The same for so many times the map's roughness. Software renderers go both ways of a branch, but not around in loops that
// no pixel needs: that is why there is one lookup for all.
fn map_radiance_widened(d: vec3f, dx: vec3f, dy: vec3f, widening: f32) -> vec4f {
  let by_roughness = env_map.roughness >= 0.0;
  var lod = 0.0;
  if (by_roughness) {
    lod = ggx_lod(roughness_over(env_map.roughness * widening, d, dx, dy), env_map.max_lod);
  } else {
    lod = map_lod(KIND, d, dx, dy, env_map.size, env_map.lod_bias, env_map.max_lod);
  }
  if (LEVELS_A_SIZE > 1u) {
    let at = map_point(KIND, d);
    let finer = u32(lod);
    return mix(at_level(at, finer), at_level(at, min(finer + 1u, u32(env_map.max_lod))), lod - f32(finer));
  }
  if (!BY_HARDWARE) {
    return sample_map(KIND, maps, 0, d, lod);
  }
  // The last level filtered by roughness has few texels. Where a small sun sets they would be seen.
  let first_smooth = select(env_map.max_lod + 2.0, env_map.max_lod, by_roughness);
  let plain = textureSampleLevel(cube, cube_sampler, d, min(lod, first_smooth - 1.0));
  var radiance = clamp(first_smooth - lod, 0.0, 1.0) * plain;
  for (var level = max(floor(lod), first_smooth); level < lod + 1.0; level += 1.0) {
    radiance += (1.0 - abs(lod - level)) * sample_level_smoothly(KIND, maps, 0, map_point(KIND, d), i32(level));
  }
  return radiance;
}

fn at_level(at: MapPoint, level: u32) -> vec4f {
  let layers = textureNumLayers(maps) / LEVELS_A_SIZE;
  return sample_level(KIND, maps, i32((level % LEVELS_A_SIZE) * layers), at, i32(level / LEVELS_A_SIZE));
}

// Both in directions of the world.
fn env_radiance(d: vec3f, dx: vec3f, dy: vec3f) -> vec4f {
  return env_radiance_widened(d, dx, dy, 1.0);
}

fn env_radiance_widened(d: vec3f, dx: vec3f, dy: vec3f, widening: f32) -> vec4f {
  let rotation = env_map.map_from_world;
  return map_radiance_widened(rotation * d, rotation * dx, rotation * dy, widening);
}
