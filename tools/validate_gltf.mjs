// Runs Khronos' glTF validator over files: node validate_gltf.mjs FILE..., or --all ROOT for all
// that tools/make_assets.py writes (but the one whose texture is missing on purpose).
// Needs the npm package gltf-validator (NODE_PATH or a node_modules folder above this one);
// exits with 77 when it is not there, 1 when a file has an error or a warning.
import { createRequire } from "node:module";
import { readdirSync, readFileSync } from "node:fs";
import { dirname, join } from "node:path";

function findValidator() {
  try {
    return createRequire(import.meta.url)("gltf-validator");
  } catch {
    console.log("gltf-validator is not installed");
    process.exit(77);
  }
}

async function validate(validator, file) {
  const report = await validator.validateBytes(new Uint8Array(readFileSync(file)), {
    uri: file,
    externalResourceFunction: async (uri) =>
      new Uint8Array(readFileSync(join(dirname(file), decodeURIComponent(uri)))),
  });
  return report.issues;
}

function listFiles(words) {
  if (words[0] !== "--all") return words;
  return ["assets", "tests/data/gltf"]
    .map((folder) => join(words[1], folder))
    .flatMap((folder) => readdirSync(folder).map((name) => join(folder, name)))
    .filter((file) => /\.(gltf|glb)$/.test(file) && !file.includes("missing_texture"));
}

const validator = findValidator();
const files = listFiles(process.argv.slice(2));
let bad = 0;
for (const file of files) {
  const issues = await validate(validator, file);
  const faults = issues.messages.filter((m) => m.severity < 2);
  for (const m of faults) console.log(`${file}: ${m.pointer ?? ""}: ${m.code}: ${m.message}`);
  bad += faults.length > 0;
}
console.log(`${files.length} files, ${bad} with errors or warnings`);
process.exit(bad > 0 || files.length === 0 ? 1 : 0);
