// A clip in a scene of three.js, with right depth: hides what is behind it and is hidden by what is before it.
import {
  Camera as ThreeCamera,
  DataTexture,
  DoubleSide,
  FloatType,
  Matrix4,
  Mesh,
  NearestFilter,
  PlaneGeometry,
  RedFormat,
  Scene,
  ShaderMaterial,
  SRGBColorSpace,
  Vector2,
  Vector3,
  type WebGLRenderer,
} from "three";
import type { KinoraPlayerElement } from "./element.js";
import type { Picture } from "./messages.js";

const vertexShader = `
varying vec2 at;
void main() {
  at = vec2(0.5 + 0.5 * position.x, 0.5 - 0.5 * position.y); // rows from the top
  gl_Position = vec4(position.xy, 0.0, 1.0);
}`;
const fragmentShader = `
uniform sampler2D color;
uniform sampler2D depth; // metres of the clip
uniform float scale; // of the object
uniform mat4 projection; // of the camera that the picture was drawn for
varying vec2 at;
void main() {
  float z = scale * texture2D(depth, at).r;
  vec4 c = texture2D(color, at);
  if (z <= 0.0 || c.a < 0.01) discard;
  vec4 clip = projection * vec4(0.0, 0.0, -z, 1.0);
  gl_FragDepth = 0.5 + 0.5 * clip.z / clip.w;
  gl_FragColor = c;
  #include <colorspace_fragment>
}`;

/**
 * Draws the clip of a <kinora-player>, which keeps time (it may be hidden), from wherever the scene's camera stands. The
 * object's pose and uniform scale place it; as it is made, the clip's world has its y axis up, as three.js has. While the
 * camera moves it shows the last picture that is ready. Needs a perspective camera and an ordinary depth buffer.
 */
export class KinoraObject extends Mesh<PlaneGeometry, ShaderMaterial> {
  /** Pixels of the pictures, at most: more are sharper and slower. */
  mostPixels = 320 * 240;
  #drawing: Promise<void> | null = null;
  #drawn = "";

  constructor(readonly player: KinoraPlayerElement) {
    const uniforms = {
      color: { value: texture(new Uint8Array(4), 1, 1) },
      depth: { value: texture(new Float32Array(1), 1, 1) },
      scale: { value: 1 },
      projection: { value: new Matrix4() },
    };
    const material = new ShaderMaterial({ uniforms, vertexShader, fragmentShader, transparent: true, side: DoubleSide });
    super(new PlaneGeometry(2, 2), material);
    this.frustumCulled = false; // its plane is the picture, wherever the camera looks
    this.rotation.x = Math.PI;
  }

  override onBeforeRender = (renderer: WebGLRenderer, _scene: Scene, camera: ThreeCamera): void =>
    this.#ask(renderer, camera);

  /** Until the picture that was asked for last is there. */
  async drawn(): Promise<void> {
    await this.#drawing;
  }

  override dispose(): void {
    for (const name of ["color", "depth"]) this.material.uniforms[name]!.value.dispose();
    this.material.dispose();
    this.geometry.dispose();
  }

  #ask(renderer: WebGLRenderer, camera: ThreeCamera): void {
    const { stage } = this.player;
    if (!stage || this.#drawing) return;
    const size = renderer.getDrawingBufferSize(new Vector2());
    const shrink = Math.min(1, Math.sqrt(this.mostPixels / (size.x * size.y)));
    const [width, height] = [Math.max(1, Math.round(size.x * shrink)), Math.max(1, Math.round(size.y * shrink))];
    const { pose, scale } = poseIn(this.matrixWorld, camera.matrixWorld);
    const intrinsics = intrinsicsOf(camera.projectionMatrix, width, height);
    const { time, visible, view } = stage.wanted;
    const key = JSON.stringify([time, visible, view, pose, intrinsics]);
    if (key === this.#drawn) return;
    const projection = camera.projectionMatrix.clone();
    const request = { time, visible, view, preview: true, withDepth: true, camera: { pose, width, height, intrinsics } };
    this.#drawing = stage
      .draw(request)
      .then((picture) => {
        this.#show(picture, scale, projection);
        this.#drawn = key;
      })
      .catch(() => undefined) // the element says what is wrong
      .finally(() => (this.#drawing = null));
  }

  #show({ camera, color, depth }: Picture, scale: number, projection: Matrix4): void {
    const { uniforms } = this.material;
    uniforms.color!.value.dispose();
    uniforms.depth!.value.dispose();
    uniforms.color!.value = texture(new Uint8Array(color.buffer), camera.width, camera.height);
    uniforms.depth!.value = texture(depth!, camera.width, camera.height);
    uniforms.scale!.value = scale;
    uniforms.projection!.value = projection;
  }
}

function texture(data: Uint8Array<ArrayBuffer> | Float32Array<ArrayBuffer>, width: number, height: number): DataTexture {
  const made = new DataTexture(data, width, height);
  if (data instanceof Float32Array) {
    made.format = RedFormat;
    made.type = FloatType;
  } else {
    made.colorSpace = SRGBColorSpace;
  }
  made.minFilter = made.magFilter = NearestFilter;
  made.needsUpdate = true;
  return made;
}

/** The camera in the clip's world, with axes x right, y down, z forward, rows first; the object's scale. */
function poseIn(object: Matrix4, camera: Matrix4): { pose: number[]; scale: number } {
  const local = object.clone().invert().multiply(camera);
  const columns = [new Vector3(), new Vector3(), new Vector3()] as const;
  local.extractBasis(...columns);
  const scale = 1 / columns[0].length();
  const [x, y, z] = columns.map((column) => column.normalize());
  const p = new Vector3().setFromMatrixPosition(local);
  return { pose: [x!.x, -y!.x, -z!.x, p.x, x!.y, -y!.y, -z!.y, p.y, x!.z, -y!.z, -z!.z, p.z, 0, 0, 0, 1], scale };
}

function intrinsicsOf(projection: Matrix4, width: number, height: number) {
  const e = projection.elements; // column by column
  return {
    fx: (e[0]! * width) / 2,
    fy: (e[5]! * height) / 2,
    cx: ((1 - e[8]!) * width) / 2 - 0.5,
    cy: ((1 + e[9]!) * height) / 2 - 0.5,
  };
}
