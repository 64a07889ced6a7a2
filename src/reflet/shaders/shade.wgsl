#import pem
#import irradiance

// What one sub-sample shows.

// A sub-sample's surface. `visible` is false for the back of a single-sided face, which is black.
struct Sample {
  triangle: Raster,
  hits: Hits,
  ng: vec3f,      // unit, facing the viewer
  back: bool,
  visible: bool,
}

fn sample_at(t: Raster, at: vec2f) -> Sample {
  let hits = hits_of(t, at);
  let ng = unit(cross(t.e1, t.e2), vec3f(0.0));
  let back = dot(hits.here.ray, ng) > 0.0;
  return Sample(t, hits, select(ng, -ng, back), back, !back || part_is(PART_DOUBLE_SIDED));
}

// The mirrored rays of a sub-sample whose shading normal is n.
fn mirrors_of(s: Sample, n: vec3f) -> Mirrors {
  let right = s.hits.right;
  let down = s.hits.down;
  return Mirrors(
    s.hits.here.p, mirrored(s.hits.here.ray, n, s.ng),
    right.p, mirrored(right.ray, shading_normal(s.triangle, right.b, s.ng), s.ng),
    down.p, mirrored(down.ray, shading_normal(s.triangle, down.b, s.ng), s.ng));
}

// Triangles on the object's convex hull cannot reflect the object.
fn may_see_itself(s: Sample) -> bool {
  return part_is(PART_HAS_LOCAL) && (s.triangle.identity.y & TRIANGLE_ON_HULL) == 0u;
}

// LOD of a picture texture of the given size, from the same neighbours as that of env maps.
fn texture_lod(s: Sample, uv: vec2f, size: vec2u) -> f32 {
  let right = texture_uv(s.triangle, s.hits.right.b) - uv;
  let down = texture_uv(s.triangle, s.hits.down.b) - uv;
  let rho = max(length(right * vec2f(size)), length(down * vec2f(size)));
  return log2(max(rho / NEIGHBOUR_STEP, 1e-6)) + frame.texture_lod_bias;
}

fn emission_at(s: Sample) -> vec3f {
  if (!part_is(PART_EMISSION_TEXTURE)) {
    return part.emission;
  }
  let uv = texture_uv(s.triangle, s.hits.here.b);
  let lod = texture_lod(s, uv, textureDimensions(emission_texture));
  return part.emission * textureSampleLevel(emission_texture, emission_sampler, uv, lod).rgb;
}

// Radiance of a surface that does not mirror.
fn matte(s: Sample) -> vec3f {
  var albedo = part.base_color;
  if (part_is(PART_BASE_COLOR_TEXTURE)) {
    let uv = texture_uv(s.triangle, s.hits.here.b);
    let lod = texture_lod(s, uv, textureDimensions(base_color_texture));
    albedo *= textureSampleLevel(base_color_texture, base_color_sampler, uv, lod).rgb;
  }
  return emission_at(s) + albedo * irradiance_over_pi(s.triangle.identity.x, s.hits.here.b, s.back);
}

// Radiance of a reflective part: E + F (L + (1 - alpha) D).
fn reflective(s: Sample) -> vec3f {
  var base_color = part.base_color;
  var metallic = part.metallic;
  if (part_is(PART_BASE_COLOR_TEXTURE)) {
    base_color *= bilinear(base_color_texture, texture_uv(s.triangle, s.hits.here.b), part_is(PART_BASE_COLOR_CLAMPS)).rgb;
  }
  if (part_is(PART_METALLIC_ROUGHNESS_TEXTURE)) {
    let uv = texture_uv(s.triangle, s.hits.here.b);
    metallic *= bilinear(metallic_roughness_texture, uv, part_is(PART_METALLIC_ROUGHNESS_CLAMPS)).b;
  }
  let n = shading_normal(s.triangle, s.hits.here.b, s.ng);
  let incident = incident_radiance(mirrors_of(s, n), switched_on(SHOW_LOCAL) && may_see_itself(s));
  var shown = incident;
  if (switched_on(SHOW_FRESNEL)) {
    let f0 = base_color * metallic + 0.04 * (1.0 - metallic);
    shown *= fresnel_schlick(f0, dot(-s.hits.here.ray, n));
  }
  if (switched_on(SHOW_DIFFUSE)) {
    let diffuse = base_color * (1.0 - metallic);
    shown += emission_at(s) + diffuse * irradiance_over_pi(s.triangle.identity.x, s.hits.here.b, s.back);
  }
  return shown;
}

// Radiance and coverage of one sub-sample at pixel position `at` of a triangle.
fn shade(t: Raster, at: vec2f) -> vec4f {
  let s = sample_at(t, at);
  let covers = s.visible && part_is(PART_REFLECTIVE);
  if (!covers && switched_on(OBJECT_ONLY)) {
    return vec4f(0.0);
  }
  if (!s.visible) {
    return vec4f(0.0, 0.0, 0.0, 1.0);
  }
  if (covers) {
    return vec4f(reflective(s), 1.0);
  }
  return vec4f(matte(s), 1.0);
}
