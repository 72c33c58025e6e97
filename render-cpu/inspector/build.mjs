// Builds dist/inspector.html, the page without data, and its stamp. With two arguments, PAGE.html NEW.html, it writes the data of a
// page that exists into the new template instead: to look at a change without building anything else.

import { build } from "esbuild";
import { readFile, readdir, writeFile } from "node:fs/promises";
import { join } from "node:path";

const MARK = "<!-- data -->";

const script = await build({
  entryPoints: ["src/main.ts"],
  bundle: true,
  minify: true,
  format: "esm",
  target: "es2022",
  write: false,
  legalComments: "none",
  logLevel: "warning",
});
const style = await build({ entryPoints: ["src/style.css"], minify: true, write: false });
const three = JSON.parse(await readFile("node_modules/three/package.json", "utf8"));
const licence = (await readFile("node_modules/three/LICENSE", "utf8")).trim();
const notice = `/*! Halflight inspector, MIT or Apache-2.0. Contains three.js ${three.version} (https://threejs.org):\n\n${licence}\n*/\n`;
const html = (await readFile("src/index.html", "utf8"))
  .replace("/* style */", () => style.outputFiles[0].text.trim())
  .replace("/* script */", () => notice + script.outputFiles[0].text.trim());

const [page, changed] = process.argv.slice(2);
if (page) {
  const old = await readFile(page, "utf8");
  const data = old.slice(old.indexOf('<script type="application/json" id="scene">'), old.lastIndexOf('<script type="module">'));
  await writeFile(changed, html.replace(MARK, () => data));
} else {
  await writeFile("dist/inspector.html", html);
  await writeFile("dist/inspector.stamp", await stamp(html));
}

/** FNV-1a over bytes, 64 bits, as source_stamp.rs of the crate computes it. */
function fnv(hash, bytes) {
  let [high, low] = hash;
  for (const byte of bytes) {
    low = (low ^ byte) >>> 0;
    // Times 0x100000001b3, in parts of which no product exceeds 2^53.
    const product = low * 0x1b3;
    const carry = Math.floor(product / 0x100000000);
    high = (Math.imul(high, 0x1b3) + carry + ((low << 8) >>> 0)) >>> 0;
    low = product >>> 0;
  }
  return [high, low];
}

async function files(folder) {
  const entries = await readdir(folder, { withFileTypes: true });
  const nested = entries.map((e) => (e.isDirectory() ? files(join(folder, e.name)) : [join(folder, e.name)]));
  return (await Promise.all(nested)).flat();
}

/** In the order of paths, part by part. */
function byParts(a, b) {
  const [left, right] = [a, b].map((name) => name.split(/[\\/]/));
  const differs = left.findIndex((part, i) => part !== right[i]);
  if (differs < 0) return left.length - right.length;
  return right[differs] === undefined || left[differs] > right[differs] ? 1 : -1;
}

/** A hash of all sources and one of the page. */
async function stamp(text) {
  const sources = ["build.mjs", "package-lock.json", "package.json", "tsconfig.json", ...(await files("src"))].sort(byParts);
  let hash = [0xcbf29ce4, 0x84222325];
  const encode = (text) => new TextEncoder().encode(text);
  for (const name of sources) {
    hash = fnv(hash, encode(`${name.split("\\").join("/")}/`));
    hash = fnv(hash, encode((await readFile(name, "utf8")).replaceAll("\r", "")));
  }
  const hex = ([high, low]) => high.toString(16).padStart(8, "0") + low.toString(16).padStart(8, "0");
  return `sources ${hex(hash)}\npage ${hex(fnv([0xcbf29ce4, 0x84222325], encode(text)))}\n`;
}
