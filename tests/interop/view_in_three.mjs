// Draws files with three.js, and splats with a viewer on top of it, in a headless Chromium.
// usage: node view_in_three.mjs JOB.json    JOB: {"camera": {w, h, fx, fy, cx, cy}, "times": [seconds],
// "views": [{"file": a .glb or .usda, or all of them a .ply of splats, "out": prefix, "pose": of a camera that stands
// elsewhere, as in transforms.json}]}; paths are relative to the job's folder. Writes <out>_<number of the time>.png.
// Prints what the page complains of; exits 1 if it fails.
import { spawn } from 'node:child_process';
import { createReadStream, mkdtempSync, readFileSync, rmSync, statSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { tmpdir } from 'node:os';
import { dirname, extname, join, normalize, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';

const SECONDS = 240;
const here = dirname(fileURLToPath(import.meta.url));
const jobPath = resolve(process.argv[2]);
const jobFolder = dirname(jobPath);
const types = { '.js': 'text/javascript', '.html': 'text/html', '.json': 'application/json', '.wasm': 'application/wasm' };

// /three/… and /splats/… are the packages, /job/… the job's folder, /view.html the page.
function fileOf(path) {
  const inside = normalize(decodeURIComponent(path));
  if (inside.startsWith('/three/')) return join(here, 'node_modules/three', inside.slice(7));
  if (inside.startsWith('/splats/')) return join(here, 'node_modules/@mkkellogg/gaussian-splats-3d/build', inside.slice(8));
  if (inside.startsWith('/job/')) return join(jobFolder, inside.slice(5));
  return inside === '/view.html' ? join(here, 'view_in_three.html') : inside === '/job.json' ? jobPath : null;
}

function body(request) {
  return new Promise((done) => {
    const parts = [];
    request.on('data', (part) => parts.push(part));
    request.on('end', () => done(Buffer.concat(parts)));
  });
}

let finish;
const finished = new Promise((done) => (finish = done));
const server = createServer(async (request, response) => {
  const path = new URL(request.url, 'http://localhost').pathname;
  if (request.method === 'POST') {
    const bytes = await body(request);
    if (path.startsWith('/job/')) writeFileSync(fileOf(path), bytes);
    else finish(bytes.toString());
    return response.end();
  }
  const file = fileOf(path);
  if (!file || !statSync(file, { throwIfNoEntry: false })?.isFile()) return response.writeHead(404).end();
  response.writeHead(200, { 'content-type': types[extname(file)] ?? 'application/octet-stream' });
  createReadStream(file).pipe(response);
});
await new Promise((done) => server.listen(0, '127.0.0.1', done));

const profile = mkdtempSync(join(tmpdir(), 'kinora-chromium-'));
const chromium = spawn('chromium', [
  '--headless=new', '--no-sandbox', '--disable-dev-shm-usage', '--no-first-run', '--disable-extensions',
  '--disable-background-networking', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
  `--user-data-dir=${profile}`,
  `http://127.0.0.1:${server.address().port}/view.html`], { stdio: 'ignore', detached: true });
chromium.on('error', (error) => finish(`chromium cannot be started: ${error.message}`));
chromium.on('exit', (code) => finish(`chromium ended with ${code}`));
const timer = setTimeout(() => finish(`nothing within ${SECONDS} s`), 1000 * SECONDS);
const said = await finished;
clearTimeout(timer);
chromium.removeAllListeners('exit');
const ended = new Promise((done) => chromium.on('exit', done));
try {
  process.kill(-chromium.pid, 'SIGKILL'); // its own process group
  await ended;
} catch {
  // it is gone already
}
server.close();
server.closeAllConnections();
for (let attempt = 0; attempt < 10; ++attempt) {
  try {
    rmSync(profile, { recursive: true, force: true });
    break;
  } catch {
    await new Promise((done) => setTimeout(done, 100)); // its children are still ending
  }
}
const complaints = said.replace(/^ok\n?/, '');
if (complaints) console.log(complaints);
process.exit(said.startsWith('ok') ? 0 : 1);
