#import exact
#import traced
#import shade
#import holes

// Program: which mirrors each sub-sample's ray meets, one sub-sample a pixel.

// 1 + the numbers of the first four triangles, into rgba32uint; 0 for none, and where nothing is traced.
@fragment
fn probe_hits(in: Raster) -> @location(0) vec4u {
  let s = exact_sample(in, sub_sample_at(in.position, in.identity.z));
  if (goes_through(s, in.position, in.identity.z)) {
    discard;
  }
  if (!s.visible || !part_is(PART_REFLECTIVE)) {
    return vec4u(0u);
  }
  let n = shading_normal(s.here, s.ng);
  let gloss = gloss_at(s, n);
  if (gloss.roughness > TRACED_ROUGHNESS) {
    return vec4u(0u);
  }
  return follow(mirrored_from(s, mirrors_of(s, n, gloss))).hits;
}
