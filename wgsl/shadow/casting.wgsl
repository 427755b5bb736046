// Tells which faces cast, what their caps count, and where they are listed.

fn casts(light: ShadowLight, facing: bool) -> bool {
  return light.casting == CAST_EVERY || (light.casting == CAST_AVERTED && !facing);
}

fn has_near_cap(light: ShadowLight) -> bool {
  return light.counting == COUNT_ZP_PLUS || light.counting == COUNT_ZP_PLUS_2005;
}

// 0 if the cap counts up where its front is seen, 1 if it does where its back is seen. Near caps lie on the near plane.
// There the front of a face that faces the light is seen if the light is on the eye's side. A matrix that mirrors turns
// all faces.
fn cap_class(light: ShadowLight, facing: bool, mirrored: bool) -> u32 {
  let turned = has_near_cap(light) && light_side(light) > 0.0;
  return select(0u, 1u, (facing == turned) != mirrored);
}

// A light has four lists of cap faces: near caps of both classes in one run, from the front and from the back, and other
// caps of both classes in another run.
const CAP_COUNTS: u32 = 128u;
const FAR: u32 = 2u;

fn cap_kind(light: ShadowLight, facing: bool, mirrored: bool) -> u32 {
  return cap_class(light, facing, mirrored) + select(FAR, 0u, has_near_cap(light));
}

fn cap_capacity(kind: u32) -> u32 {
  return select(shape.near_capacity, shape.far_capacity, kind >= FAR);
}

fn cap_place(bit: u32, kind: u32, place: u32) -> u32 {
  let run = CAP_COUNTS + bit * (shape.near_capacity + shape.far_capacity) + select(0u, shape.near_capacity, kind >= FAR);
  return run + select(place, cap_capacity(kind) - 1u - place, (kind & 1u) != 0u);
}
