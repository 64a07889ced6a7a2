#import frame

// Mesh colours [Yuksel10]: irradiance/pi on a triangle's own grid (reflet.scene.surfaces.irradiance).

// Sample (i, j) of a grid (resolution, first sample).
fn radiosity_sample(grid: vec2u, i: u32, j: u32) -> vec3f {
  let k = 3u * (grid.y + (i * (2u * grid.x + 3u - i)) / 2u + j);
  return vec3f(radiosity[k], radiosity[k + 1u], radiosity[k + 2u]);
}

// Irradiance/pi of a triangle's front or back at barycentric coordinates b of its second and third corner. The grid of a
// double-sided face's back follows that of its front.
fn irradiance_over_pi(triangle: u32, b: vec2f, back: bool) -> vec3f {
  var grid = colour_grids[triangle];
  if (grid.x == 0u) {
    return vec3f(0.0);
  }
  let r = grid.x;
  grid.y += select(0u, (r + 1u) * (r + 2u) / 2u, back);
  var inside = max(b, vec2f(0.0));
  inside = inside / max(inside.x + inside.y, 1.0);
  let at = inside * f32(r);
  let i = min(u32(at.x), r - 1u);
  let j = min(u32(at.y), r - 1u - i);
  let w = at - vec2f(f32(i), f32(j));
  let right = radiosity_sample(grid, i + 1u, j);
  let up = radiosity_sample(grid, i, j + 1u);
  // The cell's upper small triangle exists only off the long edge, where i + j + 2 <= r.
  if (w.x + w.y <= 1.0 || i + j + 2u > r) {
    let corner = radiosity_sample(grid, i, j);
    return corner + w.x * (right - corner) + w.y * (up - corner);
  }
  let far = radiosity_sample(grid, i + 1u, j + 1u);
  return far + (1.0 - w.x) * (up - far) + (1.0 - w.y) * (right - far);
}
