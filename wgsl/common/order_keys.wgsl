// Maps bits of floats to integers (keys) that compare like the floats, -0 below +0, so that no device flushes or rounds what
// is compared. No finite float has the key 0 or 0xffffffff: callers use 0 for "none", of keys and of inverted keys.

const SIGN_BIT: u32 = 0x80000000u;

fn order_keys(bits: vec3<u32>) -> vec3<u32> {
  return select(bits | vec3<u32>(SIGN_BIT), ~bits, bits >= vec3<u32>(SIGN_BIT));
}

// The bits of the floats with these keys.
fn bits_of_keys(keys: vec3<u32>) -> vec3<u32> {
  return select(~keys, keys & vec3<u32>(~SIGN_BIT), keys >= vec3<u32>(SIGN_BIT));
}

fn floats_of_keys(keys: vec3<u32>) -> vec3<f32> {
  return bitcast<vec3<f32>>(bits_of_keys(keys));
}
