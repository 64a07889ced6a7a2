#import frame
#import mesh_colours

fn radiosity_sample(k: u32) -> vec3f {
  return vec3f(radiosity[3u * k], radiosity[3u * k + 1u], radiosity[3u * k + 2u]);
}

// Irradiance/pi of a triangle's front or back at barycentric coordinates b of its second and third corner.
fn irradiance_over_pi(triangle: u32, b: vec2f, back: bool) -> vec3f {
  let grid = colour_grids[triangle];
  if (grid.x == 0u) {
    return vec3f(0.0);
  }
  let cell = cell_at(grid, b, back);
  return cell.weight.x * radiosity_sample(cell.sample.x) + cell.weight.y * radiosity_sample(cell.sample.y)
    + cell.weight.z * radiosity_sample(cell.sample.z);
}
