#import pem
#import irradiance

// What one sub-sample shows.

// A sub-sample's surface. `visible` is false for the back of a single-sided face, which is black.
struct Sample {
  triangle: Triangle,
  hit: Hit,
  ng: vec3f,      // unit, facing the viewer
  back: bool,
  visible: bool,
}

fn sample_at(triangle: u32, at: vec2f) -> Sample {
  let t = load_triangle(triangle);
  let hit = hit_plane(t, at);
  let back = dot(hit.ray, t.normal) > 0.0;
  let ng = normalize(t.normal);
  return Sample(t, hit, select(ng, -ng, back), back, !back || part_is(PART_DOUBLE_SIDED));
}

// The mirrored rays of a sub-sample whose shading normal is n.
fn mirrors_of(s: Sample, n: vec3f, at: vec2f) -> Mirrors {
  let right = hit_plane(s.triangle, at + vec2f(NEIGHBOUR_STEP, 0.0));
  let down = hit_plane(s.triangle, at + vec2f(0.0, NEIGHBOUR_STEP));
  return Mirrors(
    s.hit.p, mirrored(s.hit.ray, n, s.ng),
    right.p, mirrored(right.ray, shading_normal(s.triangle, right.b, s.ng), s.ng),
    down.p, mirrored(down.ray, shading_normal(s.triangle, down.b, s.ng), s.ng));
}

// Triangles on the object's convex hull cannot reflect the object in their fronts.
fn may_see_itself(s: Sample) -> bool {
  return part_is(PART_HAS_LOCAL) && (s.back || (s.triangle.bits & TRIANGLE_ON_HULL) == 0u);
}

// LOD of a picture texture of the given size, from the same neighbours as that of env maps.
fn texture_lod(s: Sample, uv: vec2f, size: vec2u, at: vec2f) -> f32 {
  let right = texture_uv(s.triangle, hit_plane(s.triangle, at + vec2f(1.0, 0.0)).b) - uv;
  let down = texture_uv(s.triangle, hit_plane(s.triangle, at + vec2f(0.0, 1.0)).b) - uv;
  let rho = max(length(right * vec2f(size)), length(down * vec2f(size)));
  return log2(max(rho, 1e-6)) + frame.texture_lod_bias;
}

fn emission_at(s: Sample, at: vec2f) -> vec3f {
  if (!part_is(PART_EMISSION_TEXTURE)) {
    return part.emission;
  }
  let uv = texture_uv(s.triangle, s.hit.b);
  let lod = texture_lod(s, uv, textureDimensions(emission_texture), at);
  return part.emission * textureSampleLevel(emission_texture, emission_sampler, uv, lod).rgb;
}

// Radiance of a surface that does not mirror.
fn matte(triangle: u32, s: Sample, at: vec2f) -> vec3f {
  var albedo = part.base_color;
  if (part_is(PART_BASE_COLOR_TEXTURE)) {
    let uv = texture_uv(s.triangle, s.hit.b);
    let lod = texture_lod(s, uv, textureDimensions(base_color_texture), at);
    albedo *= textureSampleLevel(base_color_texture, base_color_sampler, uv, lod).rgb;
  }
  return emission_at(s, at) + albedo * irradiance_over_pi(triangle, s.hit.b, s.back);
}

// Radiance of a reflective part: E + F (L + (1 - alpha) D).
fn reflective(triangle: u32, s: Sample, at: vec2f) -> vec3f {
  var base_color = part.base_color;
  var metallic = part.metallic;
  if (part_is(PART_BASE_COLOR_TEXTURE)) {
    base_color *= bilinear(base_color_texture, texture_uv(s.triangle, s.hit.b), part_is(PART_BASE_COLOR_CLAMPS)).rgb;
  }
  if (part_is(PART_METALLIC_ROUGHNESS_TEXTURE)) {
    let uv = texture_uv(s.triangle, s.hit.b);
    metallic *= bilinear(metallic_roughness_texture, uv, part_is(PART_METALLIC_ROUGHNESS_CLAMPS)).b;
  }
  let n = shading_normal(s.triangle, s.hit.b, s.ng);
  let incident = incident_radiance(mirrors_of(s, n, at), switched_on(SHOW_LOCAL) && may_see_itself(s));
  var shown = incident;
  if (switched_on(SHOW_FRESNEL)) {
    let f0 = base_color * metallic + 0.04 * (1.0 - metallic);
    shown *= fresnel_schlick(f0, dot(-s.hit.ray, n));
  }
  if (switched_on(SHOW_DIFFUSE)) {
    let diffuse = base_color * (1.0 - metallic);
    shown += emission_at(s, at) + diffuse * irradiance_over_pi(triangle, s.hit.b, s.back);
  }
  return shown;
}

// Radiance and coverage of one sub-sample at pixel position `at` on a triangle.
fn shade(triangle: u32, at: vec2f) -> vec4f {
  let s = sample_at(triangle, at);
  let covers = s.visible && part_is(PART_REFLECTIVE);
  if (!covers && switched_on(OBJECT_ONLY)) {
    return vec4f(0.0);
  }
  if (!s.visible) {
    return vec4f(0.0, 0.0, 0.0, 1.0);
  }
  if (covers) {
    return vec4f(reflective(triangle, s, at), 1.0);
  }
  return vec4f(matte(triangle, s, at), 1.0);
}
