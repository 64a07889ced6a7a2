#import glass
#import pem
#import irradiance

// What one sub-sample shows. Programs import `layered` or `traced` beside this, which say what a mirror reflects and
// what comes through glass.

// The mirrored rays of a sub-sample whose shading normal is n.
fn mirrors_of(s: Sample, n: vec3f) -> Mirrors {
  return Mirrors(
    s.here.p, mirrored(s.here.ray, n, s.ng),
    s.right.p, mirrored(s.right.ray, shading_normal(s.right, s.ng), s.ng),
    s.down.p, mirrored(s.down.ray, shading_normal(s.down, s.ng), s.ng), false);
}

// LOD of a picture texture of the given number and size, from the same neighbours as that of env maps.
fn texture_lod(s: Sample, which: u32, size: vec2u) -> f32 {
  let here = part_uv(which, s.here);
  let right = part_uv(which, s.right) - here;
  let down = part_uv(which, s.down) - here;
  let rho = max(length(right * vec2f(size)), length(down * vec2f(size)));
  return log2(max(rho / NEIGHBOUR_STEP, 1e-6)) + frame.texture_lod_bias;
}

fn emission_at(s: Sample) -> vec3f {
  if (!part_is(PART_EMISSION_TEXTURE)) {
    return part.emission;
  }
  let lod = texture_lod(s, 3u, textureDimensions(emission_texture));
  return part.emission * textureSampleLevel(emission_texture, emission_sampler, part_uv(3u, s.here), lod).rgb;
}

// Radiance of a surface that does not mirror.
fn matte(s: Sample) -> vec3f {
  var albedo = part.base_color * part_color(s.here).rgb;
  if (part_is(PART_BASE_COLOR_TEXTURE)) {
    let lod = texture_lod(s, 0u, textureDimensions(base_color_texture));
    albedo *= textureSampleLevel(base_color_texture, base_color_sampler, part_uv(0u, s.here), lod).rgb;
  }
  if (part_is(PART_UNLIT)) {
    return albedo;
  }
  return emission_at(s) + albedo * irradiance_over_pi(s.triangle, s.b, s.back);
}

// Radiance of a reflective part: E + F (L + (1 - alpha) D), and through glass (1 - F) of what it lets through.
fn reflective(s: Sample) -> vec3f {
  var base_color = part.base_color * part_color(s.here).rgb;
  var metallic = part.metallic;
  if (part_is(PART_BASE_COLOR_TEXTURE)) {
    base_color *= bilinear(base_color_texture, part_uv(0u, s.here), part_sampling(0u)).rgb;
  }
  if (part_is(PART_METALLIC_ROUGHNESS_TEXTURE)) {
    metallic *= bilinear(metallic_roughness_texture, part_uv(1u, s.here), part_sampling(1u)).b;
  }
  let n = shading_normal(s.here, s.ng);
  var shown = radiance_met(s, mirrors_of(s, n));
  var albedo = base_color * (1.0 - metallic);
  if (part_is(PART_REFRACTIVE)) {
    albedo = base_color * (1.0 - part.transmission);
    if (switched_on(SHOW_FRESNEL)) {
      let f = glass_reflectance(part.index, dot(-s.here.ray, n), s.back, part_is(PART_THIN));
      shown = f * shown + (1.0 - f) * part.transmission * base_color * radiance_through(s, n);
    }
  } else if (switched_on(SHOW_FRESNEL)) {
    let f0 = mix(part.dielectric_f0, base_color, metallic);
    shown *= fresnel_schlick(f0, mix(part.dielectric_f90, 1.0, metallic), dot(-s.here.ray, n));
  }
  if (switched_on(SHOW_DIFFUSE)) {
    shown += select(emission_at(s), base_color, part_is(PART_UNLIT));
    if (!part_is(PART_METAL) && !part_is(PART_UNLIT)) {
      shown += albedo * irradiance_over_pi(s.triangle, s.b, s.back);
    }
  }
  return shown;
}

// Radiance and coverage of one sub-sample.
fn shade(s: Sample) -> vec4f {
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
