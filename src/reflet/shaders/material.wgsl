#import fresnel
#import bilinear
#import env_map

// Bind group 2 of `material_picture`: what a surface makes of the radiance that reaches it. Twin: reflet.reflectance.materials.material;
// the host's side is `reflet.render.device_material`.
//
//   binding  resource                     stages     contents
//   0        uniform Material, 48 bytes   fragment
//   1        texture_2d_array<f32>        fragment   the diffuse map, turned as the env map is
//   2        texture_2d<f32>              fragment   A, B, lean and widening of GGX: columns by n·v, rows by
//                                                   perceptual_roughness; or the axes of `lobes`

struct Material {
  specular: vec3f,  // a mirror's reflectance, Phong's specular share, GGX's f0, a metal's n
  kind: u32,        // MATERIAL_*
  diffuse: vec3f,   // albedo
  index: f32,       // of refraction
  k: vec3f,         // of a metal
  perceptual_roughness: f32,
}

const MATERIAL_MIRROR = 0u;
const MATERIAL_DIELECTRIC = 1u;
const MATERIAL_DIELECTRIC_OVER_DIFFUSE = 2u;
const MATERIAL_COATED = 3u;
const MATERIAL_CONDUCTOR = 4u;
const MATERIAL_PHONG = 5u;
const MATERIAL_GGX = 6u;

// The diffuse map's parameterization, and whether the material uses it.
override DIFFUSE_KIND: u32 = 0u;
override DIFFUSES: bool = false;

@group(2) @binding(0) var<uniform> material: Material;
@group(2) @binding(1) var diffuse_map: texture_2d_array<f32>;
@group(2) @binding(2) var table: texture_2d<f32>;

// Where a material looks its map up.
struct Lobe {
  direction: vec3f,
  widening: f32,  // times the map's roughness
}

// A, B, lean and widening of GGX for n·v from 0 to 1; what other materials make of them is nothing.
fn ggx_at(n_dot_v: f32) -> vec4f {
  if (material.kind != MATERIAL_GGX) {
    return vec4f(0.0);
  }
  return bilinear(table, vec2f(n_dot_v, material.perceptual_roughness), true);
}

// Of a surface of unit normal n that mirrors the viewer into the unit direction r. GGX's lobe leans towards the normal and is
// wider than the one its map is filtered with (reflet.reflectance.brdfs.ggx_lobe).
fn lobe(r: vec3f, n: vec3f, ggx: vec4f) -> Lobe {
  if (material.kind != MATERIAL_GGX) {
    return Lobe(r, 1.0);
  }
  return Lobe(normalize(mix(r, n, ggx.z)), ggx.w);
}

// Weight of the radiance from the mirrored direction, for n·v from 0 to 1.
fn specular_weight(n_dot_v: f32, ggx: vec4f) -> vec3f {
  switch (material.kind) {
    case MATERIAL_DIELECTRIC, MATERIAL_DIELECTRIC_OVER_DIFFUSE, MATERIAL_COATED: {
      return vec3f(fresnel_dielectric(material.index, n_dot_v));
    }
    case MATERIAL_CONDUCTOR: {
      return fresnel_conductor(material.specular, material.k, n_dot_v);
    }
    case MATERIAL_GGX: {
      let f0 = material.specular;
      return (f0 * ggx.x + ggx.y) * (1.0 + f0 * (1.0 / (ggx.x + ggx.y) - 1.0));
    }
    default: {
      return material.specular;
    }
  }
}

// Weight of the diffuse map, where the other one's is `specular`.
fn diffuse_weight(specular: vec3f) -> vec3f {
  if (material.kind == MATERIAL_COATED || material.kind == MATERIAL_GGX) {
    return material.diffuse * (1.0 - specular);
  }
  return material.diffuse;
}

// Radiance that a surface of unit normal n reflects towards the viewer, of the radiance from its `lobe`.
fn reflected(incident: vec3f, n: vec3f, n_dot_v: f32, ggx: vec4f) -> vec3f {
  let specular = specular_weight(n_dot_v, ggx);
  var radiance = specular * incident;
  if (DIFFUSES) {
    radiance += diffuse_weight(specular) * sample_map(DIFFUSE_KIND, diffuse_map, 0, env_map.map_from_world * n, 0.0).rgb;
  }
  return radiance;
}
