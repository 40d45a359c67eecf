// The whole picture, for a camera that stands inside of a layer: rays enter where they begin.
uniform vec4 u_intrinsics; // fx fy cx cy, pixels
uniform vec2 u_size;       // of the picture, pixels
uniform vec3 u_camera_position;  // lattice steps
uniform mat3 u_camera_rotation;  // camera's frame to lattice steps
uniform vec4 u_camera_layer_rotation;
out vec3 v_position;
out vec3 v_view_vector;
out vec4 v_rotation;
out float v_depth;

const float kNearDepth = 0.02; // metres: nothing nearer is drawn

void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  vec2 pixel = 0.5 * (vec2(corner.x, -corner.y) + 1.0) * u_size - 0.5;
  vec3 ray = vec3((pixel - u_intrinsics.zw) / u_intrinsics.xy, 1.0);
  v_view_vector = u_camera_rotation * ray * kNearDepth;
  v_position = u_camera_position + v_view_vector;
  v_rotation = u_camera_layer_rotation;
  v_depth = kNearDepth;
  gl_Position = vec4(corner, 0.0, 1.0);
}
