#import env_map
#import material
#import lobe_axis

// What a surface reflects whose BRDF is given as lobes (twin of reflet.reflectance.prefilter.brdf_map, `reflected_radiance`). The env map
// holds, for each lobe, a slice for each of some view angles of evenly spaced cosines up to 1, all one after the other as
// array layers; `table` has a column for each of these angles. Row 0: the diffuse albedo, and the angle's cosine. Row
// 1 + l, of lobe l: how far its axis leans from the mirrored direction (side 1) or the viewer's (side -1) away from the
// normal's other side, in radians; and that side.

// Radiance towards v, for n·v > 0. Takes derivatives: call it in uniform control flow.
fn reflected_by_lobes(n: vec3f, v: vec3f) -> vec3f {
  let extent = vec2i(textureDimensions(table));
  let slices = extent.x;
  let first = textureLoad(table, vec2i(0), 0).w;
  let at = clamp((dot(n, v) - first) / (1.0 - first), 0.0, 1.0) * f32(slices - 1);
  let below = min(i32(at), slices - 2);
  let share = at - f32(below);
  let rotation = env_map.map_from_world;
  let albedo = mix(textureLoad(table, vec2i(below, 0), 0).rgb, textureLoad(table, vec2i(below + 1, 0), 0).rgb, share);
  var radiance = albedo * sample_map(DIFFUSE_KIND, diffuse_map, 0, rotation * n, 0.0).rgb;
  let faces = i32(textureNumLayers(maps)) / max(slices * (extent.y - 1), 1);
  for (var l = 0; l < extent.y - 1; l++) {
    let lower = textureLoad(table, vec2i(below, 1 + l), 0);
    let apart = mix(lower.x, textureLoad(table, vec2i(below + 1, 1 + l), 0).x, share);
    let d = rotation * lobe_axis(n, v, lower.y, apart);
    let lod = map_lod(KIND, d, d + dpdx(d), d + dpdy(d), env_map.size, env_map.lod_bias, env_map.max_lod);
    let layer = (l * slices + below) * faces;
    radiance += mix(sample_map(KIND, maps, layer, d, lod).rgb, sample_map(KIND, maps, layer + faces, d, lod).rgb, share);
  }
  return radiance;
}
