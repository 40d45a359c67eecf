// From where a pixel's ray enters a layer to the nearest surface in it that lies behind the one drawn before: the steps
// of fields/rendering/tile_marcher.cpp and ray_marching_simd.cpp, one ray for each fragment.
in vec3 v_position;
in vec3 v_view_vector;
in vec4 v_rotation;
in float v_depth;
uniform vec4 u_intrinsics; // fx fy cx cy, pixels
uniform vec2 u_size;       // of the picture, pixels
uniform highp isampler3D u_brick_index; // number of the brick, or -1
uniform highp sampler3D u_atlas;        // densities: 9 samples per side for each brick
uniform int u_bricks_per_side;
uniform int u_atlas_bricks;         // per side
uniform float u_step;               // metres between samples
uniform float u_optical_length;     // of a step
uniform float u_resolution;         // lattice steps per side of the field's box
uniform int u_layer;
uniform bool u_deforms;
uniform highp isampler2D u_cells_of_brick; // two texels per brick: numbers of its cells, x fastest; -1: none
uniform highp sampler2D u_cell_corners;    // eight texels per cell: camera's frame, metres
uniform highp sampler2D u_drawn;           // colour times opacity, then opacity, of what was drawn before
uniform highp sampler2D u_before;          // position and depth of the surface drawn before
uniform bool u_has_before;
layout(location = 0) out vec4 o_position; // relative to the field's box; depth, metres
layout(location = 1) out vec4 o_sigma;    // its deviation along the ray; opacity
layout(location = 2) out vec4 o_rotation; // x y z of a quaternion with w >= 0; 1 + the layer

const float kNearDepth = 0.02;   // metres
const float kMinProgress = 0.01; // lattice steps per sample
const float kOpaque = 0.004;
const float kMinShare = 0.004;
const float kRunEnds = 1e-3;
const float kRunBegins = 1e-2;
const float kLowest = -8.0; // raw density of byte 0
const float kRange = 19.0;  // to byte 255
const int kMaxSteps = 4096;
const int kRow = 2048; // texels in a row of a table

ivec2 texel(int number) { return ivec2(number % kRow, number / kRow); }

int brick_at(vec3 at) {
  if (any(lessThan(at, vec3(0.0))) || any(greaterThanEqual(at, vec3(float(8 * u_bricks_per_side))))) return -1;
  return texelFetch(u_brick_index, ivec3(at) >> 3, 0).r;
}

float raw_density(int brick, vec3 at) {
  ivec3 cell = ivec3(brick % u_atlas_bricks, brick / u_atlas_bricks % u_atlas_bricks,
                     brick / (u_atlas_bricks * u_atlas_bricks));
  vec3 inside = at - 8.0 * floor(at / 8.0);
  float level = textureLod(u_atlas, (vec3(9 * cell) + inside + 0.5) / float(9 * u_atlas_bricks), 0.0).r;
  return kLowest + kRange * level;
}

// Two of Newton's steps to where the motion, interpolated among the corners of their cell, carries to `point`.
vec3 refined(vec3 at, vec3 point) {
  for (int step = 0; step < 2; ++step) {
    int brick = brick_at(at);
    if (brick < 0) break;
    vec3 in_cells = at / 4.0;
    ivec3 low = ivec3(in_cells);
    ivec3 octant = low & 1;
    ivec4 cells = texelFetch(u_cells_of_brick, texel(2 * brick + octant.z), 0);
    int cell = cells[octant.x + 2 * octant.y];
    if (cell < 0) break;
    vec3 f = in_cells - vec3(low);
    vec3 value = vec3(0.0);
    mat3 jacobian = mat3(0.0);
    for (int c = 0; c < 8; ++c) {
      vec3 corner = texelFetch(u_cell_corners, texel(8 * cell + c), 0).xyz;
      vec3 side = vec3(float(c & 1), float((c >> 1) & 1), float(c >> 2));
      vec3 w = mix(1.0 - f, f, side);
      vec3 direction = 2.0 * side - 1.0;
      value += w.x * w.y * w.z * corner;
      jacobian[0] += direction.x * w.y * w.z * corner;
      jacobian[1] += direction.y * w.x * w.z * corner;
      jacobian[2] += direction.z * w.x * w.y * corner;
    }
    vec3 residual = point - value;
    vec3 c0 = cross(jacobian[1], jacobian[2]);
    vec3 by = vec3(dot(c0, residual), dot(cross(jacobian[2], jacobian[0]), residual),
                   dot(cross(jacobian[0], jacobian[1]), residual)) / dot(jacobian[0], c0);
    float squared = dot(by, by);
    if (!(squared < 1.0)) break;
    at += 4.0 * by;
    if (squared < 0.1 * 0.1 / 16.0) break;
  }
  return at;
}

void main() {
  ivec2 here = ivec2(gl_FragCoord.xy);
  float before = 0.0;
  if (u_has_before) {
    if (texelFetch(u_drawn, here, 0).a >= 1.0 - kOpaque) discard;
    before = texelFetch(u_before, here, 0).w;
    if (before <= 0.0) discard; // nothing was left to be met
    before += 2.0 * u_step;     // that surface again, from another entry
  }
  vec3 ray = vec3((vec2(gl_FragCoord.x, u_size.y - gl_FragCoord.y) - 0.5 - u_intrinsics.zw) / u_intrinsics.xy, 1.0);
  float depth_step = u_step / length(ray);
  float steps = v_depth / depth_step; // from the camera
  vec3 direction = v_view_vector / steps;
  if (!(dot(direction, direction) > kMinProgress * kMinProgress)) discard;
  // Samples lie on a ladder of depths that does not know of the hull.
  float rung = ceil(steps - 0.5);
  float entry_depth = rung * depth_step;
  vec3 origin = v_position + (rung - steps) * direction;
  float at_step = entry_depth < kNearDepth ? ceil((kNearDepth - entry_depth) / depth_step) : 0.0;

  float begin = at_step, transmittance = 1.0, median = -1.0, weighted = 0.0, squared = 0.0;
  bool left = false;
  for (int i = 0; i < kMaxSteps; ++i) {
    float middle = at_step + 0.5;
    vec3 at = origin + middle * direction;
    int brick = brick_at(at);
    left = brick < 0;
    if (left && i == 0) { // a sample on the hull itself may lie outside by rounding
      begin = at_step += 1.0;
      continue;
    }
    bool ended = left;
    if (!left) {
      float passed = exp(-exp(raw_density(brick, at)) * u_optical_length);
      float weight = transmittance * (1.0 - passed);
      weighted += weight * (middle - begin);
      squared += weight * (middle - begin) * (middle - begin);
      if (transmittance > 0.5 && transmittance - weight <= 0.5) median = middle;
      transmittance -= weight;
      at_step += 1.0;
      ended = transmittance <= kOpaque || (passed > 1.0 - kRunEnds && transmittance < 1.0 - kRunBegins);
    }
    if (!ended) continue;
    float opacity = 1.0 - transmittance;
    float mean = begin + weighted / max(opacity, 1e-12);
    if (median < 0.0) median = mean;
    float depth = entry_depth + median * depth_step;
    if (opacity > kMinShare && depth > before) {
      float normaliser = 1.0 / opacity;
      float variance = squared * normaliser - (mean - begin) * (mean - begin);
      vec3 position = origin + mean * direction;
      if (u_deforms) position = refined(position, (entry_depth + mean * depth_step) * ray);
      o_position = vec4(position / u_resolution, depth);
      o_sigma = vec4(sqrt(max(variance, 0.0)) * direction / u_resolution, opacity);
      vec4 rotation = normalize(v_rotation);
      o_rotation = vec4(rotation.w < 0.0 ? -rotation.xyz : rotation.xyz, float(u_layer + 1));
      gl_FragDepth = depth / (1.0 + depth);
      return;
    }
    if (left || transmittance <= kOpaque) break;
    begin = at_step;
    transmittance = 1.0;
    median = -1.0;
    weighted = squared = 0.0;
  }
  discard;
}
