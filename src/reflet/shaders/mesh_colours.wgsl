// Mesh colours [Yuksel10]: samples on a triangle's own grid (reflet.scene.surfaces.irradiance).

// Three samples around a point of a triangle, and their weights.
struct Cell {
  sample: vec3u,
  weight: vec3f,
}

// `grid` is (resolution, first sample), of a resolution of at least 1; b are barycentric coordinates of the triangle's second
// and third corner. The grid of a double-sided face's back follows that of its front.
fn cell_at(grid: vec2u, b: vec2f, back: bool) -> Cell {
  let r = grid.x;
  let first = grid.y + select(0u, (r + 1u) * (r + 2u) / 2u, back);
  var inside = max(b, vec2f(0.0));
  inside = inside / max(inside.x + inside.y, 1.0);
  let at = inside * f32(r);
  let i = min(u32(at.x), r - 1u);
  let j = min(u32(at.y), r - 1u - i);
  let w = at - vec2f(f32(i), f32(j));
  let corner = first + (i * (2u * r + 3u - i)) / 2u + j;
  let right = corner + r + 1u - i;
  // The cell's upper small triangle exists only off the long edge, where i + j + 2 <= r.
  if (w.x + w.y <= 1.0 || i + j + 2u > r) {
    return Cell(vec3u(corner, right, corner + 1u), vec3f(1.0 - w.x - w.y, w.x, w.y));
  }
  return Cell(vec3u(right + 1u, right, corner + 1u), vec3f(w.x + w.y - 1.0, 1.0 - w.y, 1.0 - w.x));
}
