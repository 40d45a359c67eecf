// What the page's decoder makes of the conformance corpus.
import assert from "node:assert/strict";
import { existsSync } from "node:fs";
import path from "node:path";
import { claim, root } from "./browser.mjs";

claim("the conformance corpus decodes to the same bits as natively", async ({ browser, source }) => {
  const program = "build/wasm/bin/conformance_page.mjs";
  if (!existsSync(path.join(root, program))) return console.log(`  not tested: there is no ${program}; run web/build`);
  const page = await browser.newPage();
  page.setDefaultTimeout(90000);
  await page.goto(source.address);
  const differences = await page.evaluate(async ([address, program]) => {
    const { default: create } = await import(address + program);
    const m = await create();
    const found = {};
    for (let i = 0; i < m._conformance_files(); ++i) {
      const name = m.UTF8ToString(m._conformance_file(i));
      const bytes = new Uint8Array(await (await fetch(`${address}tests/conformance/${name}`)).arrayBuffer());
      const at = m._malloc(bytes.length);
      m.HEAPU8.set(bytes, at);
      found[name] = m.UTF8ToString(m._conformance_difference(i, at, bytes.length));
      m._free(at);
    }
    return found;
  }, [source.address, program]);
  assert.ok(Object.keys(differences).length >= 4);
  for (const [name, difference] of Object.entries(differences)) assert.equal(difference, "", name);
  await page.close();
});
