#import tone

// Program: adds one picture to the sum of pictures. Clear all buffers before the first.
//
// `accumulate` does so and no more. For samples where they count, the first pictures, one sample a pixel each, are added by
// `accumulate_spread`, which keeps the range of each pixel's display values too; then `decide` writes down which pixels need
// no more, `enough.wgsl` keeps those out of all further pictures, and `accumulate` adds these: 0 where nothing was drawn.
//
//   bind group 0   0 texture_2d<f32> (any float format, not filtered)   1 storage array<vec4f>, read and written: the sum
//                  2 uniform Criterion, 16 bytes   3 storage array<vec2u>, read and written: the spread
//                  4 storage array<u32>, written by `decide`: after how many samples a pixel had enough, 0 while it takes all
//   Buffers are row-major. `accumulate` binds 0 and 1, `accumulate_spread` 0 to 3, `decide` 2 to 4.

struct Criterion {
  exposure: f32,
  curve: u32,    // TONE_*
  width: u32,    // of the picture in pixels
  count: u32,    // pictures added when it is decided
}

// The range of display values, or of coverage, above which samples disagree. On a mirror that sees itself those are three of
// the object's pixels in ten: all 256 there show 39.6 dB, where 64 have 38.1. At 0.35 they are a quarter, and edges of a moving
// picture have 0.3 dB more error. By its own samples alone a pixel would lose 3 dB at the same cost: what is thin lies between
// few samples.
const DISAGREEMENT = 0.3;

@group(0) @binding(0) var addend: texture_2d<f32>;
@group(0) @binding(1) var<storage, read_write> sum: array<vec4f>;
@group(0) @binding(2) var<uniform> criterion: Criterion;
@group(0) @binding(3) var<storage, read_write> spread: array<vec2u>;  // largest values, and largest of 1 - value: 8 bits each
@group(0) @binding(4) var<storage, read_write> enough: array<u32>;

@compute @workgroup_size(8, 8)
fn accumulate(@builtin(global_invocation_id) id: vec3u) {
  let size = textureDimensions(addend);
  if (id.x >= size.x || id.y >= size.y) {
    return;
  }
  let k = id.y * size.x + id.x;
  sum[k] = sum[k] + textureLoad(addend, vec2i(id.xy), 0);
}

fn larger(packed: u32, value: vec4f) -> u32 {
  return pack4x8unorm(max(unpack4x8unorm(packed), value));
}

@compute @workgroup_size(8, 8)
fn accumulate_spread(@builtin(global_invocation_id) id: vec3u) {
  let size = textureDimensions(addend);
  if (id.x >= size.x || id.y >= size.y) {
    return;
  }
  let k = id.y * size.x + id.x;
  let value = textureLoad(addend, vec2i(id.xy), 0);
  sum[k] = sum[k] + value;
  let shown = vec4f(tone_mapped(max(value.rgb, vec3f(0.0)) * criterion.exposure, criterion.curve), value.a);
  spread[k] = vec2u(larger(spread[k].x, shown), larger(spread[k].y, 1.0 - shown));
}

// A pixel takes more if its samples disagree among themselves and with those of the four pixels beside it.
@compute @workgroup_size(8, 8)
fn decide(@builtin(global_invocation_id) id: vec3u) {
  let width = criterion.width;
  let height = arrayLength(&spread) / width;
  if (id.x >= width || id.y >= height) {
    return;
  }
  let k = id.y * width + id.x;
  var beside = array(
    k, select(k, k - 1u, id.x > 0u), select(k, k + 1u, id.x + 1u < width),
    select(k, k - width, id.y > 0u), select(k, k + width, id.y + 1u < height));
  var most = vec4f(0.0);
  var most_below_1 = vec4f(0.0);
  for (var j = 0u; j < 5u; j++) {
    let both = spread[beside[j]];
    most = max(most, unpack4x8unorm(both.x));
    most_below_1 = max(most_below_1, unpack4x8unorm(both.y));
  }
  let more = any(most + most_below_1 > vec4f(1.0 + DISAGREEMENT));
  enough[k] = select(criterion.count, 0u, more);
}
