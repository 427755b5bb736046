// Tells which faces cast, what their caps count, and where they are listed.

fn casts(light: ShadowLight, facing: bool) -> bool {
  return light.casting == CAST_EVERY || (light.casting == CAST_AVERTED && !facing);
}

fn has_near_cap(light: ShadowLight) -> bool {
  return light.counting == COUNT_ZP_PLUS || light.counting == COUNT_ZP_PLUS_2005;
}

// Whether there are caps besides near caps: with z-fail, where the volume ends at the range, and where the caster is not in
// the depth buffer, so that the eye sees through its faces. A volume that ends behind all receivers needs no dark cap.
fn has_far_caps(light: ShadowLight, flags: u32) -> bool {
  return light.counting == COUNT_Z_FAIL || (light.end > 0.0 && shape.end_at_range != 0u) || (flags & PROXY) != 0u;
}

// A light has four lists of cap faces: near caps of both classes in one run, from the front and from the back, and other
// caps of both classes in another run. Caps of the first class count up where their front is seen, those of the second
// where their back is. A matrix that mirrors turns all faces.
const CAP_COUNTS: u32 = 128u;
const FAR: u32 = 2u;

// On the near plane the front of a face that faces the light is seen if the light is on the eye's side.
fn near_kind(light: ShadowLight, facing: bool, mirrored: bool) -> u32 {
  let turned = light_side(light) > 0.0;
  return select(0u, 1u, (facing == turned) != mirrored);
}

fn far_kind(facing: bool, mirrored: bool) -> u32 {
  return FAR + select(0u, 1u, facing == mirrored);
}

fn cap_capacity(kind: u32) -> u32 {
  return select(shape.near_capacity, shape.far_capacity, kind >= FAR);
}

fn cap_place(bit: u32, kind: u32, place: u32) -> u32 {
  let run = CAP_COUNTS + bit * (shape.near_capacity + shape.far_capacity) + select(0u, shape.near_capacity, kind >= FAR);
  return run + select(place, cap_capacity(kind) - 1u - place, (kind & 1u) != 0u);
}
