// Bundles the page's program and style into ../mjxwalk/player/bundle, which ships with mjxwalk.
// `--verify` writes nothing and fails where that folder differs from what the sources make.
import { readFile, writeFile } from "node:fs/promises";
import { build } from "esbuild";

const TARGET = new URL("../mjxwalk/player/bundle/", import.meta.url);
const LIBRARIES = ["three", "uplot"];

// A script element ends at the first of these, wherever that stands in the program.
const closing = /<\/(script)/gi;

async function notice() {
  const texts = await Promise.all(LIBRARIES.map(async (name) => {
    const home = new URL(`node_modules/${name}/`, import.meta.url);
    const { version } = JSON.parse(await readFile(new URL("package.json", home), "utf8"));
    const licence = await readFile(new URL("LICENSE", home), "utf8");
    return { name: `${name} ${version}`, licence: licence.trim() };
  }));
  return texts;
}

async function bundle() {
  const licences = await notice();
  const { outputFiles } = await build({
    absWorkingDir: new URL(".", import.meta.url).pathname,
    entryPoints: { watch: "src/main.ts" },
    outdir: "out",
    bundle: true,
    minify: true,
    write: false,
    format: "iife",
    target: ["chrome107", "firefox113", "safari16.4"],
    charset: "ascii",
    legalComments: "none",
    define: { LICENCES: JSON.stringify(licences) },
  });
  const found = new Map();
  for (const file of outputFiles) {
    const name = file.path.split("/").pop();
    found.set(name, file.text.replace(closing, "<\\/$1"));
  }
  const words = licences.map(({ name, licence }) => `${name}\n\n${licence}\n`).join("\n");
  found.set("LICENCES.txt", words);
  const banner = `/*! Contains, under the MIT licence:\n\n${words.replaceAll("*/", "* /")}*/\n`;
  found.set("watch.js", banner + found.get("watch.js"));
  return found;
}

const made = await bundle();
if (process.argv.includes("--verify")) {
  for (const [name, text] of made) {
    const shipped = await readFile(new URL(name, TARGET), "utf8").catch(() => "");
    if (shipped !== text) {
      console.error(`${name} is not what its sources make; run: npm ci && node build.mjs`);
      process.exit(1);
    }
  }
} else {
  for (const [name, text] of made) {
    await writeFile(new URL(name, TARGET), text);
    console.log(`${name} ${(text.length / 1000).toFixed(0)} kB`);
  }
}
