#import exact
#import layered
#import shade
#import holes

// Programs that look into the picture's workings, one sub-sample a pixel: raw lookups, and visible triangles.

fn blended_distant(m: Mirrors) -> vec4f {
  let all = distant_lookups(m);
  let base_share = frame.blend[BASE_MAP].x;
  var sum = vec4f(0.0);
  if (samples_shown()) {
    for (var k = 0u; k < blend_count(); k++) {
      sum += (1.0 - base_share) * frame.blend[k].x * distant_texel(all, k);
    }
  }
  if (base_shown()) {
    sum += base_share * distant_texel(all, BASE_MAP);
  }
  return sum;
}

fn blended_local(m: Mirrors) -> vec4f {
  let l = local_lookup(m);
  var sum = vec4f(0.0);
  for (var k = 0u; k < blend_count(); k++) {
    sum += frame.blend[k].x * local_texel(l, k);
  }
  return sum;
}

fn mirrors_at(s: Sample) -> Mirrors {
  let n = shading_normal(s.here, s.ng);
  return mirrors_of(s, n, gloss_at(s, n));
}

// The four channels of the distant maps, the shells composited; of one shell alone as the lookup gives them. 0 where nothing
// reflects.
@fragment
fn probe_distant(in: Raster) -> @location(0) vec4f {
  let s = exact_sample(in, sub_sample_at(in.position, in.identity.z));
  if (goes_through(s, in.position, in.identity.z)) {
    discard;
  }
  if (!s.visible || !part_is(PART_REFLECTIVE)) {
    return vec4f(0.0);
  }
  return blended_distant(mirrors_at(s));
}

// The local map's four channels; 0 where no local map is looked up.
@fragment
fn probe_local(in: Raster) -> @location(0) vec4f {
  let s = exact_sample(in, sub_sample_at(in.position, in.identity.z));
  if (goes_through(s, in.position, in.identity.z)) {
    discard;
  }
  if (!s.visible || !part_is(PART_REFLECTIVE) || !may_see_itself(s)) {
    return vec4f(0.0);
  }
  return blended_local(mirrors_at(s));
}

// 1 + the number of the visible triangle of a reflective part, into r32uint; 0 elsewhere.
@fragment
fn probe_triangle(in: Raster) -> @location(0) u32 {
  let s = exact_sample(in, sub_sample_at(in.position, in.identity.z));
  if (goes_through(s, in.position, in.identity.z)) {
    discard;
  }
  return select(0u, (s.bits >> 1u) + 1u, s.visible && part_is(PART_REFLECTIVE));
}
