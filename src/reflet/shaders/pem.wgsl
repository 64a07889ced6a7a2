#import surface
#import mirror
#import map_lookup
#import relief
#import gloss

// Parameterized environment maps: lookups of the layers, blended over samples of the parameter space.

// The three mirrored rays of a sub-sample: its own, and those of its neighbours to the right and down, on the same
// triangle's plane; of a rough surface along the peak of its lobe.
struct Mirrors {
  p0: vec3f,
  r0: vec3f,
  p1: vec3f,
  r1: vec3f,
  p2: vec3f,
  r2: vec3f,
  bounced: bool,  // they come from a surface that is itself seen in a mirror
  spread: f32,    // of the lobe, 0 of a mirror's
}

// Where mirrored light comes from: the shells have their own numbers, but the last one always is the far one.
const OWN_MESH = 3u;
const FAR_SHELL = 2u;
// Of luminance 1 within 2 %: green, yellow, blue, orange.
const ORIGIN_COLOURS =
  array<vec3f, 4>(vec3f(0.5, 1.2, 0.25), vec3f(1.1, 1.05, 0.1), vec3f(0.35, 1.0, 2.6), vec3f(2.4, 0.65, 0.1));

fn by_origin(light: vec3f, origin: u32) -> vec3f {
  if (!switched_on(BY_ORIGIN)) {
    return light;
  }
  return dot(light, vec3f(0.2126, 0.7152, 0.0722)) * ORIGIN_COLOURS[origin];
}

struct Lookup {
  direction: vec3f,
  lod: f32,
}

fn shell_count() -> u32 {
  return select(SHELL_COUNT, part.shell_count, SHELL_COUNT == 0xffffffffu);
}

fn shell_shown(shell: u32) -> bool {
  return shell < shell_count() && !switched_on(HIDE_SHELL << shell);
}

fn shell_kind(shell: u32) -> f32 {
  let kind = select(select(DISTANT_KIND_0, DISTANT_KIND_1, shell == 1u), DISTANT_KIND_2, shell == 2u);
  return select(kind, part.distant[shell].geometry.kind_a.x, kind < 0.0);
}

fn distant_parameterization() -> u32 {
  return select(DISTANT_PARAMETERIZATION, part.distant[0].parameterization, DISTANT_PARAMETERIZATION == 0xffffffffu);
}

fn local_parameterization() -> u32 {
  return select(LOCAL_PARAMETERIZATION, part.local.parameterization, LOCAL_PARAMETERIZATION == 0xffffffffu);
}

// Of a lookup in direction d. Seen directly, the farther neighbour decides. After a bounce it is the nearer one: planes that
// neighbours meet edge-on send the other one anywhere.
fn lookup_in(layer: Layer, parameterization: u32, m: Mirrors, d: vec3f, dx: vec3f, dy: vec3f) -> Lookup {
  if (m.bounced) {
    return Lookup(d, map_lod_nearer(parameterization, d, dx, dy, layer.size, frame.lod_bias, layer.max_lod));
  }
  return Lookup(d, map_lod(parameterization, d, dx, dy, layer.size, frame.lod_bias, layer.max_lod));
}

// A lookup as coarse as its lobe is wide, if its pixel is not wider: dx and dy are those of its tilted rays.
fn widened(found: Lookup, layer: Layer, parameterization: u32, dx: vec3f, dy: vec3f) -> Lookup {
  let lod = lobe_lod(parameterization, found.direction, dx, dy, layer.size, layer.max_lod);
  return Lookup(found.direction, max(found.lod, lod));
}

// Where each shell that is shown is looked up. Written out, as are those below: loops of other than constant length leak
// memory on llvmpipe.
fn distant_lookups(m: Mirrors) -> array<Lookup, MOST_SHELLS> {
  var all: array<Lookup, MOST_SHELLS>;
  if (shell_shown(0u)) {
    all[0] = shell_lookup(0u, m);
  }
  if (shell_shown(1u)) {
    all[1] = shell_lookup(1u, m);
  }
  if (shell_shown(2u)) {
    all[2] = shell_lookup(2u, m);
  }
  return all;
}

fn shell_lookup(shell: u32, m: Mirrors) -> Lookup {
  let kind = shell_kind(shell);
  if (kind == RELIEF) {
    return relief_lookup(shell, m);
  }
  return layer_lookup(kind, distant_parameterization(), part.distant[shell], m);
}

// The neighbours' rays are cut off where the sample's own meets the relief.
fn relief_lookup(shell: u32, m: Mirrors) -> Lookup {
  let layer = part.distant[shell];
  let origin = layer.geometry.origin.yzw;
  let w = inverse_hit(layer.geometry, reliefs, i32(shell), cube_sampler, m.p0, m.r0);
  let d = m.r0 + w * (m.p0 - origin);
  let dx = m.r1 + w * (m.p1 - origin);
  let dy = m.r2 + w * (m.p2 - origin);
  let found = lookup_in(layer, distant_parameterization(), m, d, dx, dy);
  if (!any_is(PART_ROUGH) || m.spread == 0.0) {
    return found;
  }
  let from_origin = w * (m.p0 - origin);
  return widened(
    found, layer, distant_parameterization(), tilted(m.r0, m.spread, false) + from_origin,
    tilted(m.r0, m.spread, true) + from_origin);
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
  let found = lookup_in(layer, parameterization, m, d, dx, dy);
  if (!any_is(PART_ROUGH) || m.spread == 0.0) {
    return found;
  }
  return widened(
    found, layer, parameterization, lookup_direction(geometry, layer.geometry, m.p0, tilted(m.r0, m.spread, false)),
    lookup_direction(geometry, layer.geometry, m.p0, tilted(m.r0, m.spread, true)));
}

// What blended sample k, or the base, shows: the shells, each over the next.
fn distant_texel(all: array<Lookup, MOST_SHELLS>, k: u32) -> vec4f {
  var seen = vec4f(0.0);
  if (shell_shown(0u)) {
    seen = shell_texel(0u, all[0], k);
  }
  if (shell_shown(1u)) {
    seen += (1.0 - seen.a) * shell_texel(1u, all[1], k);
  }
  if (shell_shown(2u)) {
    seen += (1.0 - seen.a) * shell_texel(2u, all[2], k);
  }
  return seen;
}

// The hardware filters cubes; other maps are filtered here, seamlessly.
fn shell_texel(shell: u32, l: Lookup, k: u32) -> vec4f {
  let texel = stored_shell_texel(shell, l, k);
  return vec4f(by_origin(texel.rgb, select(shell, FAR_SHELL, shell + 1u == shell_count())), texel.a);
}

fn stored_shell_texel(shell: u32, l: Lookup, k: u32) -> vec4f {
  let map = i32(frame.blend[k].y) * i32(shell_count()) + i32(shell);
  let kind = distant_parameterization();
  if (kind == CUBE) {
    return textureSampleLevel(distant_cubes, cube_sampler, l.direction, map, l.lod);
  }
  return sample_map(kind, distant_maps, map * face_count(kind), in_map(kind, l.direction, k), l.lod);
}

fn local_texel(l: Lookup, k: u32) -> vec4f {
  let texel = stored_local_texel(l, k);
  return vec4f(by_origin(texel.rgb, OWN_MESH), texel.a);
}

fn stored_local_texel(l: Lookup, k: u32) -> vec4f {
  let slot = i32(frame.blend[k].y);
  let kind = local_parameterization();
  if (kind == CUBE) {
    return textureSampleLevel(local_cubes, cube_sampler, l.direction, slot, l.lod);
  }
  return sample_map(kind, local_maps, slot * face_count(kind), in_map(kind, l.direction, k), l.lod);
}

// A direction in the frame of the map of blended sample k, or of the base.
fn in_map(kind: u32, d: vec3f, k: u32) -> vec3f {
  if (kind == GAZING_BALL) {
    return frame.map_from_world[k] * d;
  }
  return d;
}

// L + (1 - alpha) D of every blended sample, then their weighted sum: each sample's distant map counts as far as that
// sample truly saw past the object. [Hakura01, sec. 4] gives the compositing of one sample. Of D the base brings its share,
// the same for all samples, and all where there are none.
fn incident_radiance(m: Mirrors, use_local: bool) -> vec3f {
  let use_distant = switched_on(SHOW_DISTANT);
  let base_share = frame.blend[BASE_MAP].x;
  var near: Lookup;
  if (use_local) {
    near = local_lookup(m);
  }
  var far: array<Lookup, MOST_SHELLS>;
  if (use_distant) {
    far = distant_lookups(m);
  }
  var sum = vec3f(0.0);
  var past = select(0.0, 1.0, blend_count() == 0u);  // the share of the samples that see past the object
  for (var k = 0u; k < blend_count(); k++) {
    var seen = vec4f(0.0);
    if (use_local) {
      seen = local_texel(near, k);
    }
    past += frame.blend[k].x * (1.0 - seen.a);
    if (use_distant && samples_shown()) {
      seen += (1.0 - base_share) * (1.0 - seen.a) * distant_texel(far, k);
    }
    sum += frame.blend[k].x * seen.rgb;
  }
  if (use_distant && base_shown()) {
    sum += base_share * past * distant_texel(far, BASE_MAP).rgb;
  }
  return sum;
}
