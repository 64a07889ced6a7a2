#import geometry

// Relief: where a ray meets distances that a cube map holds (twin of reflet.envmap.relief, which derives it).

const FETCHES = 4u;            // a constant: loops of other lengths leak memory on llvmpipe
const FLAT = 1e-9;             // of the limit: steps whose two changes are alike know nothing of the root
const SETTLED = 3.814697265625e-6;  // of w, 2^-18: steps that small are rounding
const STEP = 1.52587890625e-5; // of the limit, 2^-16: the first step up from the infinitely far

// M(w) = max|d|·q(d) of d = r + w·a.
fn relief_along(reliefs: texture_cube_array<f32>, k: i32, linear: sampler, a: vec3f, r: vec3f, w: f32) -> f32 {
  let d = r + w * a;
  let largest = max(abs(d.x), max(abs(d.y), abs(d.z)));
  return largest * textureSampleLevel(reliefs, linear, d, k, 0.0).x;
}

// w = 1/t of the hit of the unit ray r from p on relief k: the lookup direction is r + w·(p - origin).
fn inverse_hit(g: Geometry, reliefs: texture_cube_array<f32>, k: i32, linear: sampler, p: vec3f, r: vec3f) -> f32 {
  let a = p - g.origin.yzw;
  let limit = g.floor_b.x;
  let t = box_exit(g, p, finite_slopes(r));
  var low = 0.0;
  var high = limit;
  var before = select(limit, 1.0 / t, t * limit > 1.0);
  var m_before = relief_along(reliefs, k, linear, a, r, before);
  if (m_before > before) {
    low = before;
  } else {
    high = before;
  }
  var w = min(m_before, limit);
  for (var fetch = 1u; fetch < FETCHES; fetch++) {
    let m = relief_along(reliefs, k, linear, a, r, w);
    if (m > w) {
      low = max(low, w);
    } else {
      high = min(high, w);
    }
    let change = (m - m_before) - (w - before);
    let flat = abs(change) <= FLAT * limit;
    let after = select(w - (m - w) * (w - before) / select(change, 1.0, flat), m, flat);
    let slack = SETTLED * w;  // a step to an end of the bracket, such as the infinitely far, is within it
    let settled = abs(w - before) <= slack;
    let outside = (after < low - slack || after > high + slack) && abs(after - w) > slack;
    let beyond = select(2.0 * low + STEP * limit, 0.5 * (low + high), high < limit);
    before = w;
    m_before = m;
    w = select(clamp(select(after, beyond, outside), 0.0, limit), w, settled);
  }
  return w;
}
