// Builds the page from its sources into a folder: `node build.mjs FOLDER`. Equal sources give identical files on every machine.
import { build } from "esbuild";
import { createHash } from "node:crypto";
import { cpSync, mkdirSync, readdirSync, readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2] ?? join(here, "dist");
mkdirSync(out, { recursive: true });

const bundle = (entry, external) =>
  build({
    entryPoints: [join(here, "src", entry)],
    outdir: out,
    bundle: true,
    minify: true,
    format: "esm",
    target: "es2022",
    charset: "utf8",
    legalComments: "none",
    absWorkingDir: here,
    external,
    metafile: true,
  });
// The module for three-dimensional views is loaded on demand.
const results = [await bundle("page.ts", ["./space.js"]), await bundle("space.ts", []), await bundle("page.css", [])];
for (const file of ["index.html", "icon.svg"]) {
  cpSync(join(here, "src", file), join(out, file));
}

// Licenses of the bundled packages.
const packages = new Set();
for (const { metafile } of results) {
  for (const input of Object.keys(metafile.inputs)) {
    const name = /node_modules\/((?:@[^/]+\/)?[^/]+)\//.exec(input)?.[1];
    if (name) packages.add(name);
  }
}
const license = (name) => {
  const folder = join(here, "node_modules", name);
  const { version, license } = JSON.parse(readFileSync(join(folder, "package.json"), "utf8"));
  const file = readdirSync(folder).find((own) => /^licen[sc]e/i.test(own));
  const text = file ? readFileSync(join(folder, file), "utf8").trim() : "";
  return `${name} ${version} (${license})\n\n${text}\n`;
};
writeFileSync(join(out, "licenses.txt"), [...packages].sort().map(license).join(`\n${"-".repeat(72)}\n\n`));

// Checksum of the sources; a test of the command compares it without building the page.
export const sources = () => {
  const files = readdirSync(join(here, "src")).map((name) => `src/${name}`);
  const sum = createHash("sha256");
  for (const file of [...files, "build.mjs", "package-lock.json", "package.json", "tsconfig.json"].sort()) {
    sum.update(`${file}\0`).update(readFileSync(join(here, file))).update("\0");
  }
  return sum.digest("hex");
};
writeFileSync(join(out, "sources.sha256"), `${sources()}\n`);
