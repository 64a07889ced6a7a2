#import frame
#import mesh_colours
#import parameterization

// What rough surfaces mirror of their own object (reflet.scene.surfaces.surface_layer): mesh colours whose samples are sites,
// each of which has an octahedral map.

const ROWS = 4096u;           // sites, a row of texels each, in a layer of `surface_maps`

fn site_of(sample: u32) -> u32 {
  let pair = colour_grids[2u * arrayLength(&triangles) + sample / 2u];
  return select(pair.x, pair.y, (sample & 1u) != 0u);
}

// A texel's place in a site's row; beyond the map's edge, which is folded, that of the one that lies there.
fn map_texel(at: vec2i, side: i32) -> i32 {
  let within = clamp(at, vec2i(0), vec2i(side - 1));
  let column = select(within.x, side - 1 - within.x, at.y != within.y);
  let row = select(within.y, side - 1 - within.y, at.x != within.x);
  return row * side + column;
}

struct Taps {
  texel: vec4i,
  weight: vec4f,
}

fn site_light(site: u32, taps: Taps) -> vec4f {
  let row = i32(site % ROWS);
  let layer = site / ROWS;
  return taps.weight.x * textureLoad(surface_maps, vec2i(taps.texel.x, row), layer, 0)
    + taps.weight.y * textureLoad(surface_maps, vec2i(taps.texel.y, row), layer, 0)
    + taps.weight.z * textureLoad(surface_maps, vec2i(taps.texel.z, row), layer, 0)
    + taps.weight.w * textureLoad(surface_maps, vec2i(taps.texel.w, row), layer, 0);
}

// Light of a triangle's front or back at barycentric coordinates b that is mirrored along r, which does not lean, and the share
// of distant light that does not arrive.
fn surface_light(triangle: u32, b: vec2f, back: bool, r: vec3f) -> vec4f {
  let grid = colour_grids[arrayLength(&triangles) + triangle];
  if (grid.x == 0u) {
    return vec4f(0.0);
  }
  let side = i32(sqrt(f32(textureDimensions(surface_maps).x)) + 0.5);  // a row has its square
  let place = map_point(OCTAHEDRAL, r).uv * f32(side) - 0.5;
  let low = vec2i(floor(place));
  let w = place - floor(place);
  let taps = Taps(
    vec4i(map_texel(low, side), map_texel(low + vec2i(1, 0), side), map_texel(low + vec2i(0, 1), side), map_texel(low + 1, side)),
    vec4f((1.0 - w.x) * (1.0 - w.y), w.x * (1.0 - w.y), (1.0 - w.x) * w.y, w.x * w.y));
  let cell = cell_at(grid, b, back);
  return cell.weight.x * site_light(site_of(cell.sample.x), taps) + cell.weight.y * site_light(site_of(cell.sample.y), taps)
    + cell.weight.z * site_light(site_of(cell.sample.z), taps);
}
