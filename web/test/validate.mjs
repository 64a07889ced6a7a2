// Prints gltf-validator's report on a file: node validate.mjs scene.gltf

import { readFile } from "node:fs/promises";
import { dirname, resolve } from "node:path";
import validator from "gltf-validator";

const file = process.argv[2];
const report = await validator.validateBytes(new Uint8Array(await readFile(file)), {
  uri: file,
  externalResourceFunction: async (uri) => new Uint8Array(await readFile(resolve(dirname(file), uri))),
});
console.log(JSON.stringify(report.issues));
