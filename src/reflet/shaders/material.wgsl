// Bind group 2 of `mirror_picture`: what a surface makes of the radiance that reaches it.

struct Material {
  reflectance: vec3f,  // of a mirror, the same at all angles
}

@group(2) @binding(0) var<uniform> material: Material;

// Radiance towards the unit direction v that a surface of unit normal n reflects, of the radiance from the mirrored one.
fn reflected(incident: vec3f, n: vec3f, v: vec3f) -> vec3f {
  return material.reflectance * incident;
}
