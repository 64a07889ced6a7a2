#import surface
#import pem
#import bvh
#import coat
#import glass
#import holes
#import irradiance
#import surface_light
#import highlights

// Mirrors that see themselves: the mirrored ray (of what is nearly smooth, that along its lobe's peak) is followed from mirror to mirror, through their full meshes, until it meets
// none, or a companion, a part beside them that does not reflect; rays that glass lets through likewise, to where they leave
// it. Two neighbours are carried along on the planes of the triangles that are met, for the LOD of the lookup at the end.
//
// What is met is described in bind group 0; the host's side is `reflet.render.playback.hit_buffers`:
//
//   8   storage array<vec2u>, read           for each drawn triangle 64 bits: the directions in which it may meet mirrors
//   9   storage array<HitMaterial>, read     of the parts that may be met
//   10  texture_2d_array<f32> rgba8unorm     their pictures, as stored: base colour and emission are sRGB

struct HitMaterial {
  base_color: vec3f,
  metallic: f32,
  emission: vec3f,
  normal_scale: f32,
  bits: u32,                  // PART_*
  transmission: f32,          // of glass: see Part, as of the following
  sampling: u32,
  extras: u32,
  absorption: vec3f,
  index: f32,
  alpha: f32,
  cutoff: f32,
  perceptual_roughness: f32,
  coat: u32,                  // share and roughness of its clear coat in the mean: 16 bits each
  dielectric_f0: vec3f,
  dielectric_f90: f32,
  pictures: array<vec4u, 4>,  // base colour, metallic-roughness, normal, emission: column, row, layer, width + 65536 height
}

const CELLS = 8.0;  // a side of the octahedral map that directions are divided by

// How many mirrors a ray may meet. What no material has costs nothing where pipelines are built for HIT_BITS, all that they
// have.
override MOST_HITS: u32 = 0u;
override HIT_BITS: u32 = 0xffffffffu;

@group(0) @binding(8) var<storage, read> directions: array<vec2u>;
@group(0) @binding(9) var<storage, read> hit_materials: array<HitMaterial>;
@group(0) @binding(10) var hit_pictures: texture_2d_array<f32>;

fn hit_is(material: u32, bit: u32) -> bool {
  return (HIT_BITS & bit) != 0u && (hit_materials[material].bits & bit) != 0u;
}

fn linear_from_srgb(c: vec4f) -> vec4f {
  return select(pow((c + 0.055) / 1.055, vec4f(2.4)), c / 12.92, c <= vec4f(0.04045));
}

// A material's picture, bilinear; white where it has none.
fn hit_picture(material: u32, which: u32, point: Point, srgb: bool) -> vec4f {
  let sampling = (hit_materials[material].sampling >> (8u * which)) & 255u;
  var uv = point.uv;
  if ((HIT_BITS & PART_MORE_UV) != 0u) {
    uv = coordinates(sampling, hit_materials[material].extras, point);
  }
  let place = hit_materials[material].pictures[which];
  let taps = taps_in(place, uv, sampling);
  var texels = taps_of(hit_pictures, taps);
  if (srgb) {
    texels = array<vec4f, 4>(
      linear_from_srgb(texels[0]), linear_from_srgb(texels[1]), linear_from_srgb(texels[2]), linear_from_srgb(texels[3]));
  }
  return mix(mix(texels[0], texels[1], taps.weight.x), mix(texels[2], texels[3], taps.weight.x), taps.weight.y);
}

// Whether a ray that leaves a triangle in direction d may meet a mirror.
fn may_meet(triangle: u32, d: vec3f) -> bool {
  let cell = vec2u(min(map_point(OCTAHEDRAL, d).uv * CELLS, vec2f(CELLS - 1.0)));
  let bits = directions[triangle];
  return ((select(bits.x, bits.y, cell.y >= 4u) >> ((8u * cell.y + cell.x) & 31u)) & 1u) != 0u;
}

// A triangle that a ray meets.
struct Met {
  triangle: u32,  // drawn number
  material: u32,
  a: vec3f,
  e1: vec3f,
  e2: vec3f,
  ng: vec3f,      // unit, facing the ray
  back: bool,
}

fn met_at(place: u32, ray: vec3f) -> Met {
  let first = bvh[place];
  let second = bvh[place + 1u];
  let e1 = bitcast<vec3f>(second.xyz);
  let e2 = bitcast<vec3f>(bvh[place + 2u].xyz);
  let ng = unit(cross(e1, e2), vec3f(0.0));
  let back = dot(ray, ng) > 0.0;
  return Met(first.w, second.w, bitcast<vec3f>(first.xyz), e1, e2, select(ng, -ng, back), back);
}

// Where the ray from p along `ray` meets the triangle's plane, cut off far away (CONVENTIONS.md, "Surfaces").
fn on_plane(met: Met, p: vec3f, ray: vec3f) -> vec2f {
  let h = cross(ray, met.e2);
  let det = dot(met.e1, h);
  let w = p - met.a;
  let b = vec2f(dot(w, h), dot(ray, cross(w, met.e1))) / select(det, 1.0, det == 0.0);
  return select(clamp(b, vec2f(-FARTHEST_BARYCENTRIC), vec2f(FARTHEST_BARYCENTRIC)), vec2f(0.0), det == 0.0);
}

fn met_point(met: Met, ray: vec3f, b: vec2f) -> Point {
  let normal_v = vertex_value(met.triangle, 1u, b);
  var at = Point(ray, met.a + b.x * met.e1 + b.y * met.e2, normal_v.xyz, vec4f(0.0), vec2f(0.0), met.triangle, b);
  if ((HIT_BITS & PART_TEXTURES) != 0u) {
    at.uv = vec2f(vertex_value(met.triangle, 0u, b).w, normal_v.w);
    at.tangent = vec4f(
      vertex_value(met.triangle, 2u, b).xyz, vertices[3u * triangles[met.triangle].x + 2u].w);
  }
  return at;
}

fn met_normal(met: Met, at: Point) -> vec3f {
  var n = unit(at.normal, met.ng);
  if (hit_is(met.material, PART_NORMAL_TEXTURE)) {
    let texel = hit_picture(met.material, 2u, at, false).xyz;
    n = normal_mapped(n, at.tangent, texel, hit_materials[met.material].normal_scale, met.ng);
  }
  return select(n, -n, dot(n, met.ng) < 0.0);
}

// Rays as they leave a surface.
struct Leaving {
  rays: Mirrors,
  triangle: u32,  // drawn number
  side: vec3f,    // its unit normal where they leave it
  mirrored: bool,  // they did not go through it
  last: bool,     // too wide a lobe to be followed
  medium: vec3f,  // what absorbs them, per metre
}

// A ray's way from mirror to mirror.
struct Way {
  light: vec3f,       // what is met on it sends of its own, as far as it arrives
  throughput: vec3f,  // share of the light from its end that arrives; 0 where it ends on a back, or on a companion
  end: Mirrors,       // the rays of its end
  hits: vec4u,        // 1 + numbers of the first four triangles that it meets; 0 for none
}

const OFFSET = 1e-5;  // a ray starts so far off its surface, in units of the largest coordinate there

fn largest(v: vec3f) -> f32 {
  return max(max(abs(v.x), abs(v.y)), abs(v.z));
}

// What glass within what absorbs `medium` makes of it: of the ray that goes through, or of the mirrored one.
fn medium_after(medium: vec3f, absorption: vec3f, through: bool, back: bool) -> vec3f {
  return select(select(medium, vec3f(0.0), through), absorption, through != back);
}

// The rays that leave a mirror or glass which is met. What it sends of its own, and what it keeps, are added to the way.
fn onward(way: ptr<function, Way>, met: Met, medium: vec3f, ray: vec3f, b: vec2f) -> Leaving {
  let rays = (*way).end;
  let here = met_point(met, ray, b);
  let right = met_point(met, rays.r1, on_plane(met, rays.p1, rays.r1));
  let down = met_point(met, rays.r2, on_plane(met, rays.p2, rays.r2));
  let n = met_normal(met, here);
  let n1 = met_normal(met, right);
  let n2 = met_normal(met, down);
  let material = hit_materials[met.material];
  let glass = hit_is(met.material, PART_REFRACTIVE);
  var base_color = material.base_color;
  var metallic = material.metallic;
  var roughness = material.perceptual_roughness;
  if (hit_is(met.material, PART_COLORS)) {
    base_color *= extra_value(material.extras, material.bits, 0u, here).rgb;
  }
  if (hit_is(met.material, PART_BASE_COLOR_TEXTURE)) {
    base_color *= hit_picture(met.material, 0u, here, true).rgb;
  }
  if (hit_is(met.material, PART_METALLIC_ROUGHNESS_TEXTURE)) {
    let texel = hit_picture(met.material, 1u, here, false);
    metallic *= texel.b;
    roughness *= texel.g;
  }
  let dielectric = vec4f(material.dielectric_f0, material.dielectric_f90);
  let rough = hit_is(met.material, PART_ROUGH);
  let straight = mirrored(ray, n, met.ng);
  let n_dot_v = mirror_cosine(ray, straight);
  var below = 1.0;
  var by_coat = 0.0;
  var coat = vec2f(0.0);
  if (hit_is(met.material, PART_COAT)) {
    coat = unpack2x16unorm(material.coat);
    let fresnel = coat_fresnel(coat.x, n_dot_v);
    let kept = ggx_entry(ggx_table, n_dot_v, coat.y);
    by_coat = fresnel * (kept.x + kept.y);
    below = 1.0 - fresnel;
  }
  var ggx = vec4f(0.0);
  var spread = rays.spread;
  if (rough) {
    ggx = ggx_entry(ggx_table, n_dot_v, roughness);
  }
  if (switched_on(SHOW_DIFFUSE) || !hit_is(met.material, PART_REFLECTIVE)) {
    var emission = material.emission;
    if (hit_is(met.material, PART_EMISSION_TEXTURE)) {
      emission *= hit_picture(met.material, 3u, here, true).rgb;
    }
    if (hit_is(met.material, PART_UNLIT)) {
      emission = base_color;
    } else if (!hit_is(met.material, PART_METAL)) {
      let share = below * select(
        diffuse_share(base_color, metallic, dielectric, rough, ggx), base_color * (1.0 - material.transmission), glass);
      let bend = select(vec3f(0.0), n - unbent_normal(here, met.ng), hit_is(met.material, PART_NORMAL_TEXTURE));
      emission += share * irradiance_over_pi(met.triangle, b, met.back, bend);
    }
    if (rough && light_count() > 0u) {
      emission += below * highlights(Shiny(
        here.p, ray, n, met.ng, base_color, metallic, dielectric, roughness, ggx, met.triangle, b, met.back));
    }
    (*way).light += (*way).throughput * emission;
  }
  if (glass) {
    let thin = hit_is(met.material, PART_THIN);
    // Greedy: what goes through stands for what is reflected, too, unless all of it is.
    if (glass_reflectance(material.index, n_dot_v, met.back, thin) < 1.0) {
      (*way).throughput *= material.transmission * base_color;
      return Leaving(
        Mirrors(
          here.p, refracted(ray, n, met.ng, material.index, met.back, thin),
          right.p, refracted(right.ray, n1, met.ng, material.index, met.back, thin),
          down.p, refracted(down.ray, n2, met.ng, material.index, met.back, thin), true, spread),
        met.triangle, -met.ng, false, false, medium_after(medium, material.absorption, true, met.back));
    }
  } else if (switched_on(SHOW_FRESNEL)) {
    let own = below * reflectance(base_color, metallic, dielectric, n_dot_v, rough, ggx);
    (*way).throughput *= own + by_coat;
    // one ray stands for both lobes: that of the one that sends more
    if (by_coat > largest(own)) {
      roughness = coat.y;
      ggx = ggx_entry(ggx_table, n_dot_v, roughness);
    }
  }
  if (rough) {
    spread = wider(spread, lobe_spread(roughness * ggx.w));
  }
  if (hit_is(met.material, PART_SURFACE) && roughness > TRACED_ROUGHNESS) {
    let light = surface_light(met.triangle, b, met.back, straight);
    (*way).light += (*way).throughput * light.rgb;
    (*way).throughput *= 1.0 - light.a;
  }
  return Leaving(
    Mirrors(
      here.p, leaning(ray, n, met.ng, ggx.z), right.p, leaning(right.ray, n1, met.ng, ggx.z),
      down.p, leaning(down.ray, n2, met.ng, ggx.z), true, spread),
    met.triangle, met.ng, !(glass && met.back), rough && roughness > TRACED_ROUGHNESS,
    medium_after(medium, material.absorption, false, glass && met.back));
}

const MOST_HOLES = 64u;  // one behind the other

// Whether a ray along d goes through what it meets.
fn goes_through_met(hit: Hit, d: vec3f) -> bool {
  let met = met_at(hit.at, d);
  if (!hit_is(met.material, PART_HOLES)) {
    return false;
  }
  let material = hit_materials[met.material];
  let at = met_point(met, d, hit.b);
  var alpha = material.alpha;
  if (hit_is(met.material, PART_COLORS)) {
    alpha *= extra_value(material.extras, material.bits, 0u, at).a;
  }
  if (hit_is(met.material, PART_BASE_COLOR_TEXTURE)) {
    alpha *= hit_picture(met.material, 0u, at, false).a;
  }
  let bits = bitcast<vec3u>(at.p);
  return !is_there(alpha, material.cutoff, threshold(bits.x ^ (bits.y << 7u) ^ (bits.z << 15u), 0u, met.triangle));
}

// The nearest surface that a ray does not go through. The tree is walked in one place: compilers write it out wherever it is
// called.
fn closest_surface(o: vec3f, d: vec3f) -> Hit {
  var passed = 0.0;
  var hit = Hit(FAR, NOTHING, vec2f(0.0));
  for (var k = 0u; k < MOST_HOLES; k++) {
    hit = closest_hit(o + passed * d, d);
    hit.t += passed;
    if ((HIT_BITS & PART_HOLES) == 0u || hit.at == NOTHING || !goes_through_met(hit, d)) {
      break;
    }
    passed = hit.t + OFFSET * max(largest(o + hit.t * d), hit.t);
  }
  return hit;
}

// Follows the rays of a sub-sample. After MOST_HITS mirrors they end as if there were no more.
fn follow(start: Leaving) -> Way {
  var way = Way(vec3f(0.0), vec3f(1.0), start.rays, vec4u(0u));
  var leaving = start;
  for (var k = 0u; k < MOST_HITS; k++) {
    let last = way.end;
    if (leaving.mirrored && !may_meet(leaving.triangle, last.r0)) {
      break;
    }
    let extent = max(largest(last.p0), largest(vertices[3u * triangles[leaving.triangle].x].xyz));
    let hit = closest_surface(last.p0 + OFFSET * extent * leaving.side, last.r0);
    if (hit.at == NOTHING) {
      break;
    }
    let met = met_at(hit.at, last.r0);
    if (k < 4u) {
      way.hits[k] = (triangles[met.triangle].w >> 1u) + 1u;
    }
    if (met.back && !hit_is(met.material, PART_DOUBLE_SIDED)) {
      way.throughput = vec3f(0.0);
      break;
    }
    if ((HIT_BITS & PART_REFRACTIVE) != 0u) {
      way.throughput *= exp(-hit.t * leaving.medium);
    }
    leaving = onward(&way, met, leaving.medium, last.r0, hit.b);
    if (!hit_is(met.material, PART_REFLECTIVE)) {
      way.throughput = vec3f(0.0);
      break;
    }
    way.end = leaving.rays;
    if (leaving.last) {
      break;
    }
  }
  return way;
}

// The mirrored rays of a sub-sample as they leave it.
fn mirrored_from(s: Sample, m: Mirrors) -> Leaving {
  let inside = part_is(PART_REFRACTIVE) && s.back;
  return Leaving(m, s.triangle, s.ng, !inside, false, select(vec3f(0.0), part.absorption, inside));
}

// Incident radiance: what the mirrors that are met send, and the distant light where the ray leaves them.
fn radiance_met(s: Sample, m: Mirrors, traced: bool) -> vec3f {
  return radiance_along(mirrored_from(s, m), traced && switched_on(SHOW_LOCAL));
}

// The rays as one of their lobe, if any is drawn. Neighbours turn as it does; none of them goes below the surface.
fn drawn(start: Leaving) -> Leaving {
  let m = start.rays;
  if (chances.x == 0.0 || m.spread == 0.0) {
    return start;
  }
  var by = drawn_offset(m.r0, m.spread);
  by += max(1e-3 - dot(m.r0 + by, start.side), 0.0) * start.side;
  var turned = start;
  turned.rays = Mirrors(
    m.p0, normalize(m.r0 + by), m.p1, normalize(m.r1 + by), m.p2, normalize(m.r2 + by), m.bounced, 0.0);
  return turned;
}

// The rays are followed, of a lobe one, or else they meet nothing and the lobe is looked up. What is looked up in the end is so
// in one place: programs would hold the lookup twice.
fn radiance_along(start: Leaving, followed: bool) -> vec3f {
  var way = Way(vec3f(0.0), vec3f(1.0), start.rays, vec4u(0u));
  if (followed) {
    way = follow(drawn(start));
    if (way.hits[0] == 0u) {
      way.end = start.rays;
    }
  }
  let seen = way.light + way.throughput * incident_radiance(way.end, false);
  if (way.hits[0] == 0u) {
    return seen;
  }
  return by_origin(seen, OWN_MESH);
}

// The same of the rays that go through the sub-sample's glass; n is its shading normal.
fn radiance_through(s: Sample, n: vec3f) -> vec3f {
  let thin = part_is(PART_THIN);
  let rays = Mirrors(
    s.here.p, refracted(s.here.ray, n, s.ng, part.index, s.back, thin),
    s.right.p, refracted(s.right.ray, shading_normal(s.right, s.ng), s.ng, part.index, s.back, thin),
    s.down.p, refracted(s.down.ray, shading_normal(s.down, s.ng), s.ng, part.index, s.back, thin), false, 0.0);
  return radiance_along(
    Leaving(rays, s.triangle, -s.ng, false, false, select(part.absorption, vec3f(0.0), s.back)), true);
}
