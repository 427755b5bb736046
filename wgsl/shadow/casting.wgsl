// Tells which faces cast, and what their caps count.

fn casts(light: ShadowLight, facing: bool) -> bool {
  return light.casting == CAST_EVERY || (light.casting == CAST_AVERTED && !facing);
}

// A light has a list of cap faces for each class.
const LISTS: u32 = 2u;

// Where a list begins; the light is counted from the first of its batch.
fn list_begin(light: u32, kind: u32, capacity: u32) -> u32 {
  return (LISTS * light + kind) * capacity;
}

// 0 if the cap counts up where its front is seen, 1 if it does where its back is seen. With ZP+ caps lie on the near
// plane. There the front of a face that faces the light is seen if the light is on the eye's side.
fn cap_class(light: ShadowLight, facing: bool) -> u32 {
  let has_near_cap = light.counting == COUNT_ZP_PLUS || light.counting == COUNT_ZP_PLUS_2005;
  let turned = has_near_cap && light_side(light) > 0.0;
  return select(0u, 1u, facing == turned);
}
