// Sees that every page of the documentation fits: node browser/docs.mjs FOLDER [--axe]
// Nothing is wider than the screen; on screens of a desk no table, picture, program or formula is cut either. --axe: and pages of all kinds can
// be read by anybody.
import { readdirSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join, relative, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { checker, finish, launch, open } from "./open.mjs";

const folder = resolve(process.argv[2]);
const axe = process.argv.includes("--axe") && readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const WIDTHS = [360, 1280, 1440, 1920];
const DESK = 1280; // from here on tables fit too
const KINDS = ["index.html", "tutorial.html", "claims.html", "world_rotorpy.html", "reproduced/real_world.html", "api/calls.html"]; // axe takes long
const GRAVE = ["serious", "critical"];
const { check, failures } = checker();

const pages = readdirSync(folder, { recursive: true, withFileTypes: true })
  .filter((entry) => entry.isFile() && entry.name.endsWith(".html") && !/^(genindex|search|py-modindex)/.test(entry.name))
  .map((entry) => join(entry.parentPath ?? entry.path, entry.name));

/** What is wider than its place, in words. */
const cut = (desk) => {
  const wide = [];
  const root = document.scrollingElement;
  if (root.scrollWidth > root.clientWidth) wide.push(`the page: ${root.scrollWidth} of ${root.clientWidth}`);
  if (!desk) return wide;
  for (const box of document.querySelectorAll(".table-wrapper, article pre, article .math.block, article img")) {
    const room = box.tagName === "IMG" ? box.parentElement : box;
    const needed = box.tagName === "IMG" ? box.getBoundingClientRect().width : box.scrollWidth;
    if (needed > room.clientWidth + 1) wide.push(`${box.className || box.tagName.toLowerCase()} "${box.textContent.trim().slice(0, 40)}": ${needed} of ${room.clientWidth}`);
  }
  return wide;
};

const browser = await launch({ drawing: false });
for (const width of WIDTHS) {
  const { page, complaints, close } = await open(browser, "about:blank", { width, height: 900, scheme: width === WIDTHS[1] ? "dark" : "light" });
  for (const file of pages) {
    await page.goto(pathToFileURL(file).href);
    for (const wide of await page.evaluate(cut, width >= DESK)) check(false, `${relative(folder, file)} at ${width}: ${wide}`);
    if (!axe || width > DESK || !KINDS.includes(relative(folder, file))) continue;
    await page.evaluate(axe);
    const { violations } = await page.evaluate(() => axe.run(document, { resultTypes: ["violations"], preload: false }));
    for (const { id, impact, help, nodes } of violations.filter(({ impact: how }) => GRAVE.includes(how)))
      check(false, `${relative(folder, file)} at ${width}: ${impact}: ${id}: ${help} (${nodes.length}, ${nodes[0].html.slice(0, 90)})`);
  }
  check(complaints.length === 0, `complaints at ${width}: ${complaints.slice(0, 3)}`);
  await close();
}
await browser.close();
check(pages.length > 0, `no pages in ${folder}`);
finish(failures);
