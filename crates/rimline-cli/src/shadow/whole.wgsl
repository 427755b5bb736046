// The picture's light as one texture.

@group(1) @binding(0) var scene: texture_2d<f32>;

fn scene_at(pixel: vec2<i32>) -> vec3<f32> {
  return textureLoad(scene, pixel, 0).rgb;
}
