// Reflection and Fresnel (CONVENTIONS.md, "Surfaces").

const GRAZING = 0.001;

// The mirrored unit ray; one that would dive below the surface is bent back above it. ng faces the viewer.
fn mirrored(ray: vec3f, n: vec3f, ng: vec3f) -> vec3f {
  let r = ray - 2.0 * dot(ray, n) * n;
  let height = dot(r, ng);
  if (height < GRAZING) {
    return normalize(r + (GRAZING - height) * ng);
  }
  return r;
}

// [Schlick94]
fn fresnel_schlick(f0: vec3f, n_dot_v: f32) -> vec3f {
  let c = 1.0 - clamp(n_dot_v, 0.0, 1.0);
  let c2 = c * c;
  return f0 + (1.0 - f0) * (c2 * c2 * c);
}
