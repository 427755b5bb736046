// Stage `depth_cube`: puts the six depth maps around a light into one texture, three in a row. First dispatch of an encode of
// `DepthMapCube`, unless an earlier list of cells is drawn. One invocation a texel of the result.
// Reads six depth textures, and six of objects if OBJECTS. A map of another size, such as one texel, is not there and casts
// nothing. Writes `cube_texture` and `cube_objects`, which all later stages and draws have as `depth_texture` and
// `object_texture`: depths from 0 to 1, none subnormal or NaN, and the far end where nothing casts; no object is written there.
// Samples of maps that lie on one ray (cube.wgsl) get the nearest of their depths and the object of the first map that has it, so
// cells of both maps at an edge of the cube decide from the same samples. Keys, which are integers, decide.

#import depth_map/cube
#import depth_map/samples

@group(0) @binding(2) var texture_1: texture_2d<f32>;
@group(0) @binding(3) var texture_2: texture_2d<f32>;
@group(0) @binding(4) var texture_3: texture_2d<f32>;
@group(0) @binding(5) var texture_4: texture_2d<f32>;
@group(0) @binding(6) var texture_5: texture_2d<f32>;
@group(0) @binding(7) var cube_texture: texture_storage_2d<r32float, write>;

@group(0) @binding(8) var objects_0: texture_2d<u32>;
@group(0) @binding(9) var objects_1: texture_2d<u32>;
@group(0) @binding(10) var objects_2: texture_2d<u32>;
@group(0) @binding(11) var objects_3: texture_2d<u32>;
@group(0) @binding(12) var objects_4: texture_2d<u32>;
@group(0) @binding(13) var objects_5: texture_2d<u32>;
@group(0) @binding(14) var cube_objects: texture_storage_2d<r32uint, write>;

const BLOCK: u32 = 256u;

// Whether there are objects.
override OBJECTS: bool = true;

// The key of a texel of a map: an integer that grows with the distance from the light.
fn loaded(map: texture_2d<f32>, at: vec2<u32>) -> u32 {
  if (any(textureDimensions(map) != depth_map.size)) {
    return FAR_KEY;
  }
  return sample_key(bitcast<u32>(textureLoad(map, at, 0).x));
}

fn key_of_face(face: u32, at: vec2<u32>) -> u32 {
  switch face {
    case 0u: {
      return loaded(depth_texture, at);
    }
    case 1u: {
      return loaded(texture_1, at);
    }
    case 2u: {
      return loaded(texture_2, at);
    }
    case 3u: {
      return loaded(texture_3, at);
    }
    case 4u: {
      return loaded(texture_4, at);
    }
    default: {
      return loaded(texture_5, at);
    }
  }
}

fn object_of_face(face: u32, at: vec2<u32>) -> u32 {
  switch face {
    case 0u: {
      return textureLoad(objects_0, at, 0).x;
    }
    case 1u: {
      return textureLoad(objects_1, at, 0).x;
    }
    case 2u: {
      return textureLoad(objects_2, at, 0).x;
    }
    case 3u: {
      return textureLoad(objects_3, at, 0).x;
    }
    case 4u: {
      return textureLoad(objects_4, at, 0).x;
    }
    default: {
      return textureLoad(objects_5, at, 0).x;
    }
  }
}

// A workgroup takes further blocks only where the device may not have a workgroup for each.
@compute @workgroup_size(BLOCK)
fn depth_cube(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let side = depth_map.size.x;
  // Turns: 1.
  for (var block = group.x + groups.x * group.y; block < depth_map.blocks; block += groups.x * groups.y) {
    let texel = block * BLOCK + local;
    let at = vec2<u32>(texel % (3u * side), texel / (3u * side));
    if (at.y < 2u * side) {
      let direction = direction_of(at.x / side + 3u * (at.y / side), at % side);
      var key = FAR_KEY;
      var nearest = 6u;
      for (var face = 0u; face < 6u; face++) {
        if (has_direction(face, direction)) {
          let own = key_of_face(face, sample_of(face, direction));
          nearest = select(nearest, face, own < key);
          key = min(key, own);
        }
      }
      textureStore(cube_texture, at, vec4<f32>(bitcast<f32>(bits_of_key(key)), 0.0, 0.0, 0.0));
      if (OBJECTS && nearest < 6u) {
        textureStore(cube_objects, at, vec4<u32>(object_of_face(nearest, sample_of(nearest, direction)), 0u, 0u, 0u));
      }
    }
  }
}
