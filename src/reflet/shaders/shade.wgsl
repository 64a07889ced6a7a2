#import glass
#import pem
#import irradiance
#import surface_light
#import highlights
#import coat

// What one sub-sample shows. Programs import `layered` or `traced` beside this, which say what a mirror reflects and
// what comes through glass.

// What a sub-sample's surface is made of.
struct Gloss {
  metallic: f32,
  roughness: f32,  // 0 of mirrors
  n_dot_v: f32,    // of the normal that mirrors
  ggx: vec4f,      // of the table; 0 of mirrors
}

// Of a sub-sample whose shading normal is n.
fn gloss_at(s: Sample, n: vec3f) -> Gloss {
  var gloss = Gloss(
    part.metallic, part.perceptual_roughness, mirror_cosine(s.here.ray, mirrored(s.here.ray, n, s.ng)), vec4f(0.0));
  if (part_is(PART_METALLIC_ROUGHNESS_TEXTURE)) {
    let texel = bilinear(metallic_roughness_texture, part_uv(1u, s.here), part_sampling(1u));
    gloss.metallic *= texel.b;
    gloss.roughness *= texel.g;
  }
  if (part_is(PART_ROUGH)) {
    gloss.ggx = ggx_entry(ggx_table, gloss.n_dot_v, gloss.roughness);
  } else {
    gloss.roughness = 0.0;
  }
  return gloss;
}

// The mirrored rays of a sub-sample whose shading normal is n.
fn mirrors_of(s: Sample, n: vec3f, gloss: Gloss) -> Mirrors {
  return mirrors_about(s, n, shading_normal(s.right, s.ng), shading_normal(s.down, s.ng), gloss.roughness, gloss.ggx);
}

// The same about its own normal and its neighbours', which lean as its own does.
fn mirrors_about(s: Sample, n: vec3f, n1: vec3f, n2: vec3f, roughness: f32, ggx: vec4f) -> Mirrors {
  let lean = ggx.z;
  var spread = 0.0;
  if (part_is(PART_ROUGH)) {
    spread = lobe_spread(roughness * ggx.w);
  }
  return Mirrors(
    s.here.p, leaning(s.here.ray, n, s.ng, lean),
    s.right.p, leaning(s.right.ray, n1, s.ng, lean),
    s.down.p, leaning(s.down.ray, n2, s.ng, lean), false, spread);
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

// Diffuse light that reaches a sub-sample of shading normal n, over pi. Where anything is of glass first surfaces go without bends:
// Chromium's rasterizer in software does not get over programs that hold both.
fn diffuse_light(s: Sample, n: vec3f) -> vec3f {
  var bend = vec3f(0.0);
  if (part_is(PART_NORMAL_TEXTURE) && !any_is(PART_REFRACTIVE)) {
    bend = n - unbent_normal(s.here, s.ng);
  }
  return irradiance_over_pi(s.triangle, s.b, s.back, bend);
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
  return emission_at(s) + albedo * diffuse_light(s, shading_normal(s.here, s.ng));
}

// What the lobe about some rays gathers, of a sub-sample as rough as that whose shading normal is n.
fn lobe_light(s: Sample, n: vec3f, m: Mirrors, roughness: f32) -> vec3f {
  let traced = roughness <= TRACED_ROUGHNESS * (1.0 + 0.25 * chances.z);  // no seam between the two, if there is time
  let shown = radiance_met(s, m, traced);
  if (!part_is(PART_SURFACE) || traced || !switched_on(SHOW_LOCAL)) {
    return shown;
  }
  let light = surface_light(s.triangle, s.b, s.back, mirrored(s.here.ray, n, s.ng));
  return max(by_origin(light.rgb, OWN_MESH) + (1.0 - light.a) * shown, vec3f(0.0));
}

// Radiance of a reflective part: E + F (L + (1 - alpha) D), and through glass (1 - F) of what it lets through.
fn reflective(s: Sample) -> vec3f {
  var base_color = part.base_color * part_color(s.here).rgb;
  if (part_is(PART_BASE_COLOR_TEXTURE)) {
    base_color *= bilinear(base_color_texture, part_uv(0u, s.here), part_sampling(0u)).rgb;
  }
  let n = shading_normal(s.here, s.ng);
  let gloss = gloss_at(s, n);
  // Not in a branch, though what mirrors by its coat alone shows nothing of it: lookups within one leak memory on llvmpipe.
  var shown = lobe_light(s, n, mirrors_of(s, n, gloss), gloss.roughness);
  let dielectric = vec4f(part.dielectric_f0, part.dielectric_f90);
  var albedo = diffuse_share(base_color, gloss.metallic, dielectric, part_is(PART_ROUGH), gloss.ggx);
  if (part_is(PART_REFRACTIVE)) {
    albedo = base_color * (1.0 - part.transmission);
    if (switched_on(SHOW_FRESNEL)) {
      let f = glass_reflectance(part.index, gloss.n_dot_v, s.back, part_is(PART_THIN));
      shown = f * shown + (1.0 - f) * part.transmission * base_color * radiance_through(s, n);
    }
  } else if (switched_on(SHOW_FRESNEL)) {
    shown *= reflectance(base_color, gloss.metallic, dielectric, gloss.n_dot_v, part_is(PART_ROUGH), gloss.ggx);
  }
  var below = 1.0;
  var on_coat = vec3f(0.0);
  if (part_is(PART_COAT)) {
    let coat = coat_at(s);
    below = 1.0 - coat.fresnel;
    albedo *= below;
    if (switched_on(SHOW_DIFFUSE)) {
      on_coat = highlights(Shiny(
        s.here.p, s.here.ray, coat.n, s.ng, vec3f(0.0), 0.0, vec4f(coat.fresnel), coat.roughness, vec4f(1.0, 0.0, coat.ggx.zw),
        s.triangle, s.b, s.back));
    }
    if (switched_on(SHOW_FRESNEL)) {
      let m = mirrors_about(s, coat.n, coat.n1, coat.n2, coat.roughness, coat.ggx);
      shown = below * shown
        + coat.fresnel * (coat.ggx.x + coat.ggx.y) * lobe_light(s, coat.n, m, coat.roughness);
    }
  }
  if (switched_on(SHOW_DIFFUSE)) {
    shown += select(emission_at(s), base_color, part_is(PART_UNLIT));
    if (!part_is(PART_METAL) && !part_is(PART_UNLIT)) {
      shown += albedo * diffuse_light(s, n);
    }
    if (part_is(PART_ROUGH)) {
      shown += on_coat + below * highlights(Shiny(
        s.here.p, s.here.ray, n, s.ng, base_color, gloss.metallic, dielectric, gloss.roughness, gloss.ggx, s.triangle, s.b, s.back));
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
