#import fresnel
#import ggx_table
#import env_map

// Bind group 2 of `material_picture`: what a surface makes of the radiance that reaches it. Twin: reflet.reflectance.materials.material;
// the host's side is `reflet.render.device_material`.
//
//   binding  resource                     stages     contents
//   0        uniform Material, 48 bytes   fragment
//   1        texture_2d_array<f32>        fragment   the diffuse map, turned as the env map is
//   2        texture_2d<f32>              fragment   that of `ggx_table`, or the axes of `lobes`

struct Material {
  specular: vec3f,  // a mirror's reflectance, Phong's specular share, GGX's base colour, a metal's n
  kind: u32,        // MATERIAL_*
  diffuse: vec3f,   // albedo
  index: f32,       // of refraction; GGX's metallic
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

const DIELECTRIC_F0 = vec3f(0.04);

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
  return ggx_entry(table, n_dot_v, material.perceptual_roughness);
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
      return mix(specular_albedo(DIELECTRIC_F0, 1.0, ggx), specular_albedo(material.specular, 1.0, ggx), material.index);
    }
    default: {
      return material.specular;
    }
  }
}

// Weight of the diffuse map, where the other one's is `specular`. Of what is partly metal the dielectric's share has its own.
fn diffuse_weight(specular: vec3f, ggx: vec4f) -> vec3f {
  if (material.kind == MATERIAL_COATED) {
    return material.diffuse * (1.0 - specular);
  }
  if (material.kind == MATERIAL_GGX) {
    return material.diffuse * (1.0 - specular_albedo(DIELECTRIC_F0, 1.0, ggx));
  }
  return material.diffuse;
}

// Radiance that a surface of unit normal n reflects towards the viewer, of the radiance from its `lobe`.
fn reflected(incident: vec3f, n: vec3f, n_dot_v: f32, ggx: vec4f) -> vec3f {
  let specular = specular_weight(n_dot_v, ggx);
  var radiance = specular * incident;
  if (DIFFUSES) {
    radiance += diffuse_weight(specular, ggx) * sample_map(DIFFUSE_KIND, diffuse_map, 0, env_map.map_from_world * n, 0.0).rgb;
  }
  return radiance;
}
