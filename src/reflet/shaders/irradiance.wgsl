#import frame
#import mesh_colours
#import part

// Three floats of each sample, from a place on.
fn radiosity_in(cell: Cell, first: u32) -> vec3f {
  let at = first + 3u * cell.sample;
  return cell.weight.x * vec3f(radiosity[at.x], radiosity[at.x + 1u], radiosity[at.x + 2u])
    + cell.weight.y * vec3f(radiosity[at.y], radiosity[at.y + 1u], radiosity[at.y + 2u])
    + cell.weight.z * vec3f(radiosity[at.z], radiosity[at.z + 1u], radiosity[at.z + 2u]);
}

// Irradiance/pi of a triangle's front or back at barycentric coordinates b of its second and third corner, of a surface whose unit
// normal is `bend` more than the interpolated one: 0 but in scenes with normal maps, whose gradients are there.
fn irradiance_over_pi(triangle: u32, b: vec2f, back: bool, bend: vec3f) -> vec3f {
  let grid = colour_grids[triangle];
  if (grid.x == 0u) {
    return vec3f(0.0);
  }
  let cell = cell_at(grid, b, back);
  let straight = radiosity_in(cell, 0u);
  if (!any_is(PART_NORMAL_TEXTURE) || all(bend == vec3f(0.0))) {
    return straight;
  }
  let change = dot(radiosity_in(cell, arrayLength(&radiosity) / 2u), bend);
  return straight * max(1.0 + change / max(dot(straight, vec3f(0.2126, 0.7152, 0.0722)), 1e-20), 0.0);
}
