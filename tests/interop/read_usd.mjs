// What TinyUSDZ, a reader of USD of others, finds in a file, as JSON: {"meshes": [{"name", "triangles", "low", "high",
// "texture"}]} with the box around the vertices in the file's world, at the first time sample. Exits 1 if it is refused.
// usage: node read_usd.mjs FILE.usda
import { readFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath, pathToFileURL } from 'node:url';

const file = process.argv[2];
const folder = join(dirname(fileURLToPath(import.meta.url)), 'node_modules/tinyusdz');
const data = readFileSync(file);
const wasmBinary = readFileSync(join(folder, 'tinyusdz.wasm'));

// The package is built for browsers and refuses Node.js where it sees it.
const { process: node } = globalThis;
globalThis.window = globalThis;
globalThis.process = undefined;
const { default: load } = await import(pathToFileURL(join(folder, 'tinyusdz.js')));
const { TinyUSDZLoaderNative } = await load({ wasmBinary });
globalThis.process = node;

const reader = new TinyUSDZLoaderNative();
if (!reader.loadFromBinary(data, file)) {
  console.error(reader.error());
  process.exit(1);
}

// Rows are vectors there: x y z 1 times the matrix.
function boxOf(points, m) {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < points.length; i += 3) {
    for (let k = 0; k < 3; ++k) {
      const value = points[i] * m[k] + points[i + 1] * m[4 + k] + points[i + 2] * m[8 + k] + m[12 + k];
      low[k] = Math.min(low[k], value);
      high[k] = Math.max(high[k], value);
    }
  }
  return { low, high };
}

const meshes = [];
function visit(node) {
  if (node.nodeType === 'mesh') {
    const mesh = reader.getMesh(node.contentId);
    const material = reader.getMaterial(mesh.materialId);
    const texture = reader.getTexture(material.emissiveColorTextureId);
    meshes.push({ name: node.primName, triangles: mesh.faceVertexIndices.length / 3,
                  texture: reader.getImage(texture.textureImageId).uri, ...boxOf(mesh.points, node.globalMatrix) });
  }
  for (const child of node.children) visit(child);
}
visit(reader.getDefaultRootNode());
console.log(JSON.stringify({ meshes }));
