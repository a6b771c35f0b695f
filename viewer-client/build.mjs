// Bundles the client for the browser, and records of which sources each bundle was made.
//
//   npm run build            write the bundles into the Python package
//   npm run watch            the same, again after every change
//   node build.mjs --out DIR write them into DIR instead (a test compares the two)
//
// The bundles are committed, so that nobody needs Node to install brdfit; beside each stands
// NAME.sources.json with the SHA-256 of every source, which tests/viewer/test_bundles.py holds
// against what is committed.

import { createHash } from "node:crypto";
import { mkdir, readFile, writeFile } from "node:fs/promises";
import { dirname, join, relative, resolve } from "node:path";
import { fileURLToPath } from "node:url";

import * as esbuild from "esbuild";

const HERE = dirname(fileURLToPath(import.meta.url));
const PACKAGE = resolve(HERE, "../src/brdfit");

// entry (a script or a style sheet, or a file that is copied as it is) -> where it goes
const BUNDLES = [
  { entry: "src/report/report.ts", out: "report/static/report.js" },
  { entry: "src/report/report.css", out: "report/static/report.css" },
  { entry: "src/viewer/main.ts", out: "viewer/static/viewer.js" },
  { entry: "src/viewer/viewer.css", out: "viewer/static/viewer.css" },
  { entry: "src/viewer/index.html", out: "viewer/static/index.html" },
];

// What changes every bundle.
const TOOLS = ["build.mjs", "package-lock.json"];

const OPTIONS = {
  absWorkingDir: HERE,
  bundle: true,
  charset: "utf8",
  format: "iife",
  legalComments: "inline",
  loader: { ".html": "copy" },
  logLevel: "warning",
  metafile: true,
  minify: true,
  target: ["es2022"],
  write: false,
};

async function sha256(path) {
  return createHash("sha256")
    .update(await readFile(path))
    .digest("hex");
}

async function build({ entry, out }, root) {
  const target = join(root, out);
  let content;
  let inputs = [entry];
  if (entry.endsWith(".html")) {
    content = await readFile(join(HERE, entry));
  } else {
    const result = await esbuild.build({ ...OPTIONS, entryPoints: [entry], outfile: target });
    content = result.outputFiles[0].contents;
    inputs = Object.keys(result.metafile.inputs);
  }
  const names = [...inputs, ...TOOLS].map((name) => relative(HERE, resolve(HERE, name))).sort();
  const sources = {};
  for (const name of names) sources[name] = await sha256(join(HERE, name));
  await mkdir(dirname(target), { recursive: true });
  await writeFile(target, content);
  await writeFile(`${target}.sources.json`, JSON.stringify(sources, null, 1) + "\n");
  console.log(`${out}  ${(content.length / 1024).toFixed(1)} kB`);
}

async function buildAll(root) {
  for (const bundle of BUNDLES) await build(bundle, root);
}

async function watch() {
  const { watch: watchFiles } = await import("node:fs/promises");
  for await (const _ of watchFiles(join(HERE, "src"), { recursive: true })) {
    await buildAll(PACKAGE).catch((error) => console.error(error.message));
  }
}

const outAt = process.argv.indexOf("--out");
await buildAll(outAt < 0 ? PACKAGE : resolve(process.argv[outAt + 1]));
if (process.argv.includes("--watch")) await watch();
