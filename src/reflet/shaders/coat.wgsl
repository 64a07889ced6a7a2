#import surface
#import gloss
#import frame

// Clear coats: a second lobe above what a part is made of (CONVENTIONS.md, "Surfaces").
//
//   bind group 1   13   texture_2d_array<f32> rgba8unorm   the part's pictures of its coat, wherever `coat_pictures` of Part says

@group(1) @binding(13) var coat_atlas: texture_2d_array<f32>;

const COAT_F0 = 0.04;  // of index 1.5; twin: reflet.scene.material

// A coat where a sub-sample sees it.
struct Coat {
  fresnel: f32,    // share of light that what is below lacks
  roughness: f32,
  n: vec3f,        // its own shading normal, and its neighbours'
  n1: vec3f,
  n2: vec3f,
  ggx: vec4f,
}

// Share of the light that a coat takes away from what is below.
fn coat_fresnel(share: f32, n_dot_v: f32) -> f32 {
  return share * fresnel_schlick(vec3f(COAT_F0), 1.0, n_dot_v).x;
}

// 0 the coat's share in red, 1 its roughness in green, 2 its normals; white where there is none.
fn coat_picture(which: u32, at: Point) -> vec4f {
  let place = part.coat_pictures[which];
  if (place.w == 0u) {
    return vec4f(1.0);
  }
  let sampling = (part.coat_sampling >> (8u * which)) & 255u;
  var uv = at.uv;
  if (part_is(PART_MORE_UV)) {
    uv = coordinates(sampling, part.extras, at);
  }
  return bilinear_in(coat_atlas, place, uv, sampling);
}

// The coat's unit normal: as `shading_normal`.
fn coat_normal(at: Point, ng: vec3f) -> vec3f {
  if (part.coat_pictures[2].w == 0u) {
    return unbent_normal(at, ng);
  }
  let texel = coat_picture(2u, at).xyz;
  let n = normal_mapped(unit(at.normal, ng), at.tangent, texel, part.coat_normal_scale, ng);
  return select(n, -n, dot(n, ng) < 0.0);
}

fn coat_at(s: Sample) -> Coat {
  let n = coat_normal(s.here, s.ng);
  let n_dot_v = mirror_cosine(s.here.ray, mirrored(s.here.ray, n, s.ng));
  let roughness = part.coat_roughness * coat_picture(1u, s.here).g;
  return Coat(
    coat_fresnel(part.coat * coat_picture(0u, s.here).r, n_dot_v), roughness, n, coat_normal(s.right, s.ng),
    coat_normal(s.down, s.ng), ggx_entry(ggx_table, n_dot_v, roughness));
}
