#import bilinear

// The table of GGX: A and B of the split sum, lean and widening of its lobe (twin of reflet.reflectance.materials.material.dfg_table).
// Rows by perceptual_roughness, columns by the root of n·v, from 0 in the middle of the first texel to 1 in that of the last.

fn ggx_entry(table: texture_2d<f32>, n_dot_v: f32, perceptual_roughness: f32) -> vec4f {
  let size = vec2f(textureDimensions(table));
  return bilinear(table, (vec2f(sqrt(n_dot_v), perceptual_roughness) * (size - 1.0) + 0.5) / size, CLAMPS);
}

// Share of white light that GGX of this f0 and f90 reflects, with all that bounces between microfacets.
fn specular_albedo(f0: vec3f, f90: f32, ggx: vec4f) -> vec3f {
  return (f0 * ggx.x + f90 * ggx.y) * (1.0 + f0 * (1.0 / (ggx.x + ggx.y) - 1.0));
}
