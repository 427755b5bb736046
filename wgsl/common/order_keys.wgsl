// Integers with the order of floats, from the floats' bits, so that no device can flush or round what is compared.

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
