// A corner of a layer's proxy mesh, posed, as the camera sees it (fields/rendering/projected_layer.h).
in vec3 a_corner;      // camera's frame, metres
in vec3 a_position;    // lattice steps
in vec3 a_view_vector; // from the camera to the corner, turned into canonical space, lattice steps
in vec4 a_rotation;    // of the layer: a unit quaternion x y z w
uniform vec4 u_intrinsics; // fx fy cx cy, pixels
uniform vec2 u_size;       // of the picture, pixels
out vec3 v_position;
out vec3 v_view_vector;
out vec4 v_rotation;
out float v_depth;

const float kNear = 1e-3; // metres

void main() {
  v_position = a_position;
  v_view_vector = a_view_vector;
  v_rotation = a_rotation;
  v_depth = a_corner.z;
  // Pixel centres lie at whole numbers; row 0 is the upper one.
  vec2 scale = 2.0 * u_intrinsics.xy / u_size;
  vec2 shift = (2.0 * u_intrinsics.zw + 1.0) / u_size - 1.0;
  vec2 at = scale * a_corner.xy + shift * a_corner.z;
  gl_Position = vec4(at.x, -at.y, a_corner.z - 2.0 * kNear, a_corner.z);
}
