#import view

// The direction by which a surface looks up a map that is shown as it is (reflet.reflectance.materials.map_material).

const LOOKUP_REFLECTION = 0u;
const LOOKUP_NORMAL = 1u;
const LOOKUP_VIEW_REFLECTION = 2u;
const LOOKUP_VIEW_NORMAL = 3u;

override LOOKUP: u32 = 0u;

// Of a surface of unit normal n that the unit ray meets; not for LOOKUP_REFLECTION, which is `mirrored`.
fn shown_direction(n: vec3f, ray: vec3f) -> vec3f {
  if (LOOKUP == LOOKUP_NORMAL) {
    return n;
  }
  let z = -ray;
  let x = normalize(view.ray_dx - dot(view.ray_dx, z) * z);
  let seen = vec3f(dot(n, x), dot(n, cross(z, x)), dot(n, z));
  if (LOOKUP == LOOKUP_VIEW_REFLECTION) {
    return 2.0 * seen.z * seen - vec3f(0.0, 0.0, 1.0);
  }
  return seen;
}

// The longest change over a step of one pixel, in whatever direction of the picture, where those along its axes are dx and
// dy: the longer half axis of the ellipse that a circle of radius 1 becomes. Unlike the longer of the two it does not
// depend on how the picture lies, so that drawn lines have one width all around.
fn longest(dx: vec3f, dy: vec3f) -> vec3f {
  let difference = 0.5 * (dot(dx, dx) - dot(dy, dy));
  let mixed = dot(dx, dy);
  let both = length(vec2f(difference, mixed));
  let cosine = select(difference / both, 1.0, both == 0.0);  // of twice the angle
  let along = sqrt(max(0.5 + 0.5 * cosine, 0.0)) * dx;
  let across = sqrt(max(0.5 - 0.5 * cosine, 0.0)) * dy;
  return select(along - across, along + across, mixed >= 0.0);
}
