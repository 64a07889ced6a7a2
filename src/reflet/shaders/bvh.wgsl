#import geometry

// Rays through the tree of the scene's mirrors and companions (twin of reflet.scene.bvh.closest_hit). The host's side of this buffer is
// `reflet.render.playback.hit_buffers`.
//
//   words of a node, 2 vec4u     its box's lower corner, link   upper corner, count
//   of a triangle, 3 vec4u       first corner, drawn number     edge to the second corner, material     to the third, 0
//
// Links are places in the buffer: of a leaf's first triangle; else of the second child, the first follows its parent.
// Corners and edges are floats. `count` is that of a leaf's triangles, at most 4, 0 of inner nodes.

@group(0) @binding(7) var<storage, read> bvh: array<vec4u>;

const MOST_DEPTH = 32u;
const NOTHING = 0xffffffffu;
const FAR = 3e38;
const SLACK = 1.0000004;  // of where a ray leaves a box: three roundings

struct Hit {
  t: f32,
  at: u32,   // the triangle's place, NOTHING if none is met
  b: vec2f,  // barycentric coordinates, of the second and third corner
}

// Distance to where a ray enters a node's box, FAR where it does not before `limit`.
fn enters(node: u32, o: vec3f, inverse: vec3f, limit: f32) -> f32 {
  let a = (bitcast<vec3f>(bvh[node].xyz) - o) * inverse;
  let b = (bitcast<vec3f>(bvh[node + 1u].xyz) - o) * inverse;
  let low = min(a, b);
  let high = max(a, b) * SLACK;
  let near = max(max(low.x, low.y), max(low.z, 0.0));
  let far = min(min(high.x, high.y), min(high.z, limit));
  return select(FAR, near, near <= far);
}

// The nearest triangle that a ray from o along d meets, on either side. [MoellerTrumbore97]
fn closest_hit(o: vec3f, d: vec3f) -> Hit {
  var best = Hit(FAR, NOTHING, vec2f(0.0));
  let inverse = 1.0 / finite_slopes(d);
  if (enters(0u, o, inverse, FAR) == FAR) {
    return best;
  }
  var stack: array<u32, MOST_DEPTH>;
  var entered: array<f32, MOST_DEPTH>;  // distance to the box of each node there: what lies behind the hit is left out
  var top = 0u;
  var node = 0u;
  loop {
    let link = bvh[node].w;
    let count = bvh[node + 1u].w;
    var descends = false;
    if (count > 0u) {
      for (var at = link; at < link + 3u * count; at += 3u) {
        let e1 = bitcast<vec3f>(bvh[at + 1u].xyz);
        let e2 = bitcast<vec3f>(bvh[at + 2u].xyz);
        let h = cross(d, e2);
        let det = dot(e1, h);
        let inverse_det = 1.0 / select(det, 1.0, det == 0.0);
        let w = o - bitcast<vec3f>(bvh[at].xyz);
        let q = cross(w, e1);
        let b = vec2f(dot(w, h), dot(d, q)) * inverse_det;
        let t = dot(e2, q) * inverse_det;
        if (det != 0.0 && b.x >= 0.0 && b.y >= 0.0 && b.x + b.y <= 1.0 && t > 0.0 && t < best.t) {
          best = Hit(t, at, b);
        }
      }
    } else {
      let t_first = enters(node + 2u, o, inverse, best.t);
      let t_second = enters(link, o, inverse, best.t);
      let swap = t_second < t_first;
      descends = min(t_first, t_second) < FAR;
      if (descends) {
        if (max(t_first, t_second) < FAR) {
          stack[top] = select(link, node + 2u, swap);
          entered[top] = max(t_first, t_second);
          top++;
        }
        node = select(node + 2u, link, swap);
      }
    }
    if (!descends) {
      while (top > 0u && entered[top - 1u] >= best.t) {
        top--;
      }
      if (top == 0u) {
        break;
      }
      top--;
      node = stack[top];
    }
  }
  return best;
}
