#import frame

// Numbers of about 48 bits: a float32 value and the rest that rounding took away from it.

struct Precise {
  value: vec3f,
  rest: vec3f,
}

// a itself, but compilers cannot know: some "simplify" (a + b) - a to b, which is what rounding is all about.
fn opaque(a: vec3f) -> vec3f {
  return bitcast<vec3f>(bitcast<vec3u>(a) | vec3u(frame.zero));
}

// a with its lower 12 bits cleared: products of two such parts are exact.
fn upper_part(a: vec3f) -> vec3f {
  return bitcast<vec3f>(bitcast<vec3u>(a) & vec3u(0xfffff000u));
}

// [Dekker71]
fn precise_product(a: Precise, b: Precise) -> Precise {
  let value = a.value * b.value;
  let a1 = upper_part(a.value);
  let b1 = upper_part(b.value);
  let a2 = a.value - a1;
  let b2 = b.value - b1;
  let rest = ((a1 * b1 - value) + a1 * b2 + a2 * b1) + a2 * b2;
  return Precise(value, rest + (a.value * b.rest + a.rest * b.value));
}

// [Knuth97, sec. 4.2.2]
fn precise_sum(a: Precise, b: Precise) -> Precise {
  let sum = opaque(a.value + b.value);
  let b_seen = opaque(sum - a.value);
  let rest = (a.value - (sum - b_seen)) + (b.value - b_seen) + (a.rest + b.rest);
  let value = opaque(sum + rest);
  return Precise(value, rest - (value - sum));
}

fn precise_difference(a: Precise, b: Precise) -> Precise {
  return precise_sum(a, Precise(-b.value, -b.rest));
}
