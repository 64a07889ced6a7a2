import { readFileSync } from "node:fs";
import { defineConfig } from "vite";

const LICENCES = `/*! reflet-viewer, Apache-2.0. In it is ktx-parse:\n${readFileSync("node_modules/ktx-parse/LICENSE", "utf8")}*/`;

export default defineConfig({
  base: "./",
  build: {
    outDir: "../src/reflet/view/static",
    emptyOutDir: true,
    target: "es2022",
    modulePreload: false,
    // One script of a fixed name: other pages can load it and use <reflet-viewer>.
    rollupOptions: { output: { entryFileNames: "reflet-viewer.js", banner: LICENCES } },
  },
});
