#import surface
#import mirror
#import map_lookup
#import relief

// Parameterized environment maps: lookups of the layers, blended over samples of the parameter space.

// The three mirrored rays of a sub-sample: its own, and those of its neighbours to the right and down, on the same
// triangle's plane.
struct Mirrors {
  p0: vec3f,
  r0: vec3f,
  p1: vec3f,
  r1: vec3f,
  p2: vec3f,
  r2: vec3f,
}

struct Lookup {
  direction: vec3f,
  lod: f32,
}

fn distant_parameterization() -> u32 {
  return select(DISTANT_PARAMETERIZATION, part.distant.parameterization, DISTANT_PARAMETERIZATION == 0xffffffffu);
}

fn local_parameterization() -> u32 {
  return select(LOCAL_PARAMETERIZATION, part.local.parameterization, LOCAL_PARAMETERIZATION == 0xffffffffu);
}

fn distant_lookup(m: Mirrors) -> Lookup {
  let geometry = select(DISTANT_KIND, part.distant.geometry.kind_a.x, DISTANT_KIND < 0.0);
  if (geometry == RELIEF) {
    return relief_lookup(m);
  }
  return layer_lookup(geometry, distant_parameterization(), part.distant, m);
}

// The neighbours' rays are cut off where the sample's own meets the relief.
fn relief_lookup(m: Mirrors) -> Lookup {
  let layer = part.distant;
  let origin = layer.geometry.origin.yzw;
  let w = inverse_hit(layer.geometry, distant_relief, cube_sampler, m.p0, m.r0);
  let d = m.r0 + w * (m.p0 - origin);
  let dx = m.r1 + w * (m.p1 - origin);
  let dy = m.r2 + w * (m.p2 - origin);
  return Lookup(d, map_lod(distant_parameterization(), d, dx, dy, layer.size, frame.lod_bias, layer.max_lod));
}

fn local_lookup(m: Mirrors) -> Lookup {
  let geometry = select(LOCAL_KIND, part.local.geometry.kind_a.x, LOCAL_KIND < 0.0);
  return layer_lookup(geometry, local_parameterization(), part.local, m);
}

// In the world's frame: the LOD of the one view-dependent map, the gazing ball, is the same in any.
fn layer_lookup(geometry: f32, parameterization: u32, layer: Layer, m: Mirrors) -> Lookup {
  let d = lookup_direction(geometry, layer.geometry, m.p0, m.r0);
  let dx = lookup_direction(geometry, layer.geometry, m.p1, m.r1);
  let dy = lookup_direction(geometry, layer.geometry, m.p2, m.r2);
  return Lookup(d, map_lod(parameterization, d, dx, dy, layer.size, frame.lod_bias, layer.max_lod));
}

// What blended sample k shows. The hardware filters cubes; other maps are filtered here, seamlessly.
fn distant_texel(l: Lookup, k: u32) -> vec4f {
  let slot = i32(frame.blend[k].y);
  let kind = distant_parameterization();
  if (kind == CUBE) {
    return textureSampleLevel(distant_cubes, cube_sampler, l.direction, slot, l.lod);
  }
  return sample_map(kind, distant_maps, slot * face_count(kind), in_map(kind, l.direction, k), l.lod);
}

fn local_texel(l: Lookup, k: u32) -> vec4f {
  let slot = i32(frame.blend[k].y);
  let kind = local_parameterization();
  if (kind == CUBE) {
    return textureSampleLevel(local_cubes, cube_sampler, l.direction, slot, l.lod);
  }
  return sample_map(kind, local_maps, slot * face_count(kind), in_map(kind, l.direction, k), l.lod);
}

// A direction in the frame of the map of blended sample k.
fn in_map(kind: u32, d: vec3f, k: u32) -> vec3f {
  if (kind == GAZING_BALL) {
    return frame.map_from_world[k] * d;
  }
  return d;
}

// L + (1 - alpha) D of every blended sample, then their weighted sum: each sample's distant map counts as far as that
// sample truly saw past the object. [Hakura01, sec. 4] gives the compositing of one sample.
fn incident_radiance(m: Mirrors, use_local: bool) -> vec3f {
  let use_distant = switched_on(SHOW_DISTANT);
  var near: Lookup;
  if (use_local) {
    near = local_lookup(m);
  }
  var far: Lookup;
  if (use_distant) {
    far = distant_lookup(m);
  }
  var sum = vec3f(0.0);
  for (var k = 0u; k < blend_count(); k++) {
    var seen = vec4f(0.0);
    if (use_local) {
      seen = local_texel(near, k);
    }
    if (use_distant) {
      seen += (1.0 - seen.a) * distant_texel(far, k);
    }
    sum += frame.blend[k].x * seen.rgb;
  }
  return sum;
}
