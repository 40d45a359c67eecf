// Colours of the surfaces of one layer: the field's hidden features at two points of each and its colour net once
// (fields/rendering/tile_shader.cpp, fields/network/reference.h).
uniform highp sampler2D u_position; // relative to the field's box; depth
uniform highp sampler2D u_sigma;    // deviation along the ray; opacity
uniform highp sampler2D u_rotation; // x y z; 1 + the layer
uniform highp sampler2D u_table;    // hash table: two texels per entry
uniform highp sampler2D u_nets;     // weights, four columns to a texel: density, surface, second, third, vectors
uniform int u_levels;
uniform ivec4 u_level[8]; // resolution, offset, size, 1 if hashed
uniform float u_near;     // relative to the field's box: surfaces thinner than that are one point
uniform int u_layer;
layout(location = 0) out vec4 o_color; // sRGB times opacity, then opacity

const int kRow = 2048; // texels in a row of a table
const float kOpacityEpsilon = 1e-3;

int next_texel; // of the nets

vec4 weights() {
  vec4 row = texelFetch(u_nets, ivec2(next_texel % kRow, next_texel / kRow), 0);
  ++next_texel;
  return row;
}

uint vertex_entry(ivec4 level, uvec3 at) {
  if (level.w != 0) return (at.x ^ (at.y * 2654435761u) ^ (at.z * 805459861u)) & uint(level.z - 1);
  uint n = uint(level.x) + 1u;
  return (at.z * n + at.y) * n + at.x;
}

void features_at(ivec4 level, vec3 position, out vec4 low, out vec4 high) {
  vec3 scaled = clamp(position, 0.0, 1.0) * float(level.x);
  uvec3 cell = min(uvec3(scaled), uvec3(level.x - 1));
  vec3 f = scaled - vec3(cell);
  low = vec4(0.0);
  high = vec4(0.0);
  for (int c = 0; c < 8; ++c) {
    uvec3 side = uvec3(c & 1, (c >> 1) & 1, c >> 2);
    vec3 w = mix(1.0 - f, f, vec3(side));
    int first = 2 * (level.y + int(vertex_entry(level, cell + side)));
    float weight = w.x * w.y * w.z;
    low += weight * texelFetch(u_table, ivec2(first % kRow, first / kRow), 0);
    high += weight * texelFetch(u_table, ivec2((first + 1) % kRow, (first + 1) / kRow), 0);
  }
}

void add_hidden(vec3 position, float share, inout vec4 hidden[4]) {
  vec4 sum[4] = vec4[4](vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0));
  next_texel = 0;
  for (int l = 0; l < u_levels; ++l) {
    vec4 low, high;
    features_at(u_level[l], position, low, high);
    for (int i = 0; i < 8; ++i) {
      float value = i < 4 ? low[i] : high[i - 4];
      for (int o = 0; o < 4; ++o) sum[o] += value * weights();
    }
  }
  for (int o = 0; o < 4; ++o) hidden[o] += share * max(sum[o], 0.0);
}

vec3 rotated(vec4 q, vec3 v) { return v + 2.0 * cross(q.xyz, q.w * v + cross(q.xyz, v)); }

void main() {
  ivec2 here = ivec2(gl_FragCoord.xy);
  vec4 turn = texelFetch(u_rotation, here, 0);
  if (int(turn.w + 0.5) != u_layer + 1) discard;
  vec3 position = texelFetch(u_position, here, 0).xyz;
  vec4 sigma = texelFetch(u_sigma, here, 0);
  float opacity = sigma.w;
  vec4 hidden[4] = vec4[4](vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0));
  if (dot(sigma.xyz, sigma.xyz) < u_near * u_near) {
    add_hidden(position, 1.0, hidden);
  } else {
    add_hidden(position - sigma.xyz, 0.5, hidden);
    add_hidden(position + sigma.xyz, 0.5, hidden);
  }
  float normaliser = opacity / (opacity + kOpacityEpsilon);
  for (int o = 0; o < 4; ++o) hidden[o] *= normaliser;
  next_texel = 32 * u_levels;
  vec4 first[8] = vec4[8](vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0));
  for (int i = 0; i < 16; ++i) {
    float value = hidden[i / 4][i % 4];
    for (int o = 0; o < 8; ++o) first[o] += value * weights();
  }
  for (int o = 0; o < 8; ++o) first[o] += weights();
  int surface_vectors = next_texel;
  next_texel += 24 + 256 + 32;
  vec3 vector = vec3(0.0);
  for (int i = 0; i < 16; ++i) vector += hidden[i / 4][i % 4] * weights().xyz;
  vector = rotated(vec4(turn.xyz, sqrt(max(0.0, 1.0 - dot(turn.xyz, turn.xyz)))), vector);
  next_texel = surface_vectors;
  for (int i = 0; i < 3; ++i) {
    for (int o = 0; o < 8; ++o) first[o] += vector[i] * weights();
  }
  vec4 second[8] = vec4[8](vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0));
  for (int i = 0; i < 32; ++i) {
    float value = max(first[i / 4][i % 4], 0.0);
    for (int o = 0; o < 8; ++o) second[o] += value * weights();
  }
  vec4 third = vec4(0.0);
  for (int i = 0; i < 32; ++i) third += max(second[i / 4][i % 4], 0.0) * weights();
  o_color = vec4(opacity / (1.0 + exp(-third.rgb)), opacity);
}
