// Judges GLB files with the Khronos validator.
// usage: node validate_gltf.mjs FILE...    Prints what it finds; exits 1 if there is an error or a warning.
import { readFileSync } from 'node:fs';
import validator from 'gltf-validator';

let faults = 0;
for (const path of process.argv.slice(2)) {
  const { issues } = await validator.validateBytes(new Uint8Array(readFileSync(path)));
  console.log(`${path}: ${issues.numErrors} errors, ${issues.numWarnings} warnings`);
  for (const message of issues.messages.filter((m) => m.severity < 2))
    console.log(`  ${message.code} at ${message.pointer ?? message.offset}: ${message.message}`);
  faults += issues.numErrors + issues.numWarnings;
}
process.exit(faults === 0 ? 0 : 1);
