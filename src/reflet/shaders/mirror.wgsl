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

// The cosine between the viewer and the unit normal that mirrors `ray` to r: n·v, but of a ray that is bent, whose n may even
// face away from the viewer.
fn mirror_cosine(ray: vec3f, r: vec3f) -> f32 {
  return min(0.5 * length(r - ray), 1.0);
}
