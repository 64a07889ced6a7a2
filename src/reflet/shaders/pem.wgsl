#import surface
#import mirror
#import cube_lod

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

fn distant_lookup(m: Mirrors) -> Lookup {
  return layer_lookup(select(DISTANT_KIND, part.distant.geometry.kind_a.x, DISTANT_KIND < 0.0), part.distant, m);
}

fn local_lookup(m: Mirrors) -> Lookup {
  return layer_lookup(select(LOCAL_KIND, part.local.geometry.kind_a.x, LOCAL_KIND < 0.0), part.local, m);
}

fn layer_lookup(kind: f32, layer: Layer, m: Mirrors) -> Lookup {
  let d = lookup_direction(kind, layer.geometry, m.p0, m.r0);
  let dx = lookup_direction(kind, layer.geometry, m.p1, m.r1);
  let dy = lookup_direction(kind, layer.geometry, m.p2, m.r2);
  return Lookup(d, cube_lod(d, dx, dy, layer.size, frame.lod_bias, layer.max_lod));
}

fn distant_texel(l: Lookup, slot: i32) -> vec4f {
  return textureSampleLevel(distant_maps, map_sampler, l.direction, slot, l.lod);
}

fn local_texel(l: Lookup, slot: i32) -> vec4f {
  return textureSampleLevel(local_maps, map_sampler, l.direction, slot, l.lod);
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
    let slot = i32(frame.blend[k].y);
    var seen = vec4f(0.0);
    if (use_local) {
      seen = local_texel(near, slot);
    }
    if (use_distant) {
      seen += (1.0 - seen.a) * distant_texel(far, slot);
    }
    sum += frame.blend[k].x * seen.rgb;
  }
  return sum;
}
