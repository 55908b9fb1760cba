// One self-contained file: script and style stand inside the page, which hotlap fills with data.
import { createHash } from "node:crypto";
import { mkdirSync, readdirSync, readFileSync, statSync, writeFileSync } from "node:fs";
import { join, relative, sep } from "node:path";
import { defineConfig } from "vite";

const HERE = import.meta.dirname;
const OUT = join(HERE, "../src/hotlap/report/page");
const PLACES = ["<title>hotlap</title>", '<div id="static"></div>', '<script id="study-data" type="application/json"></script>'];

/** All files below a folder. */
const below = (folder) =>
  readdirSync(folder).flatMap((name) => {
    const path = join(folder, name);
    return statSync(path).isDirectory() ? below(path) : [path];
  });

/** What the page is built from; `tests/report/test_page_fresh.py` computes the same. */
const fingerprint = () => {
  const roots = readdirSync(HERE).filter((name) => /^(index\.html|package(-lock)?\.json|vite\.config\..*)$/.test(name));
  const paths = [...roots.map((name) => join(HERE, name)), ...below(join(HERE, "src"))];
  const names = paths.map((path) => relative(HERE, path).split(sep).join("/")).sort();
  const digest = createHash("sha256");
  for (const name of names) digest.update(`${name}\0`).update(readFileSync(join(HERE, name))).update("\0");
  return digest.digest("hex");
};

/** The licences of what is built in. */
const licences = () =>
  ["three", "uplot"]
    .map((name) => {
      const folder = join(HERE, "node_modules", name);
      const { version, homepage } = JSON.parse(readFileSync(join(folder, "package.json"), "utf-8"));
      return `${name} ${version} (${homepage})\n\n${readFileSync(join(folder, "LICENSE"), "utf-8").trim()}\n`;
    })
    .join(`\n${"-".repeat(80)}\n\n`);

/** Puts script and style inside, and writes the page where hotlap finds it. */
const oneFile = {
  name: "one-file",
  enforce: "post",
  generateBundle(_, bundle) {
    const files = Object.values(bundle);
    const script = files.filter((file) => file.type === "chunk").map((file) => file.code);
    const style = files.filter((file) => file.fileName.endsWith(".css")).map((file) => file.source);
    const inside = script.join("\n").trim().replace(/<(\/script|!--)/g, "\\x3c$1");
    const page = String(bundle["index.html"].source)
      .replace(/\s*<script type="module".*?<\/script>/s, "")
      .replace(/\s*<link rel="stylesheet"[^>]*>/s, "")
      .replace("<!doctype html>", () => `<!doctype html>\n<!-- hotlap page ${fingerprint()} -->`)
      .replace("</head>", () => `  <style>${style.join("\n").trim()}</style>\n  </head>`)
      .replace("</body>", () => `  <script>${inside}</script>\n  </body>`);
    for (const place of PLACES) if (page.split(place).length !== 2) throw new Error(`not exactly once in the page: ${place}`);
    mkdirSync(OUT, { recursive: true });
    writeFileSync(join(OUT, "template.html"), page);
    writeFileSync(join(OUT, "LICENSES.txt"), licences());
    for (const name of Object.keys(bundle)) delete bundle[name];
  },
};

export default defineConfig({
  root: HERE,
  plugins: [oneFile],
  build: {
    emptyOutDir: false,
    target: "es2023",
    modulePreload: false,
    cssCodeSplit: false,
    assetsInlineLimit: 1 << 20,
    chunkSizeWarningLimit: 2000,
    rollupOptions: { output: { format: "iife", inlineDynamicImports: true } },
  },
});
