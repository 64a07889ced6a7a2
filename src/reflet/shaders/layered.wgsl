#import pem

// What a mirror reflects: local maps over distant ones. What comes through glass is in its local maps, over its reflectance.

// Triangles on the object's convex hull cannot reflect the object.
fn may_see_itself(s: Sample) -> bool {
  return part_is(PART_HAS_LOCAL) && (part_is(PART_OFF_HULL) || (s.bits & TRIANGLE_ON_HULL) == 0u);
}

// Incident radiance L + (1 - alpha) D; rays are `traced` in another program.
fn radiance_met(s: Sample, m: Mirrors, traced: bool) -> vec3f {
  return incident_radiance(m, switched_on(SHOW_LOCAL) && may_see_itself(s));
}

fn radiance_through(s: Sample, n: vec3f) -> vec3f {
  return vec3f(0.0);
}
