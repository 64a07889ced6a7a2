#import fresnel
#import mirror

// Glass: exact Fresnel reflectance and Snell's law (twin: reflet.trace.glass). Rays that meet a back come from the inside; a
// thin sheet has none, and is gone through straight.

const LEAST_REFLECTANCE = 1e-3;

// 1 where light is reflected totally. `index` is that of the inside over that of the outside.
fn glass_reflectance(index: f32, n_dot_v: f32, back: bool, thin: bool) -> f32 {
  let once = fresnel_dielectric(select(index, 1.0 / index, back && !thin), n_dot_v);
  return max(select(once, 2.0 * once / (1.0 + once), thin), LEAST_REFLECTANCE);
}

// The unit ray beyond the surface; both normals face the ray. Where it is reflected totally it grazes the surface.
fn refracted(ray: vec3f, n: vec3f, ng: vec3f, index: f32, back: bool, thin: bool) -> vec3f {
  if (thin) {
    return ray;
  }
  let ratio = select(1.0 / index, index, back);
  let c = -dot(ray, n);
  let r = ratio * ray + (ratio * c - sqrt(max(1.0 - ratio * ratio * (1.0 - c * c), 0.0))) * n;
  let height = dot(r, ng);
  return normalize(select(r, r - (height + GRAZING) * ng, height > -GRAZING));
}
