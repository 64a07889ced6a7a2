// Reflection (CONVENTIONS.md, "Surfaces").

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
