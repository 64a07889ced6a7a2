// LOD of a perceptual_roughness from 0 to 1 in maps whose levels are filtered by GGX; twin of reflet.reflectance.prefilter.ggx_levels,
// GEOMETRIC, where it is derived.
fn ggx_lod(perceptual_roughness: f32, max_lod: f32) -> f32 {
  let alpha = perceptual_roughness * perceptual_roughness / 0.0055;  // in those of level 0
  return log2(1.0 + alpha * alpha) * (max_lod / log2(1.0 + 1.0 / (0.0055 * 0.0055)));
}
