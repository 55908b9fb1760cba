// Sees that anybody can read pages: node browser/axe.mjs PAGE.html ...; dark and light, on a desk and a phone, axe finds nothing serious.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { basename, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { checker, finish, launch, open } from "./open.mjs";

const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const GRAVE = ["serious", "critical"];
const SCREENS = [
  { width: 1280, height: 900, scheme: "light" },
  { width: 1280, height: 900, scheme: "dark" },
  { width: 360, height: 780, scheme: "light" },
];
const { check, failures } = checker();
const browser = await launch();
for (const screen of SCREENS)
  for (const file of process.argv.slice(2)) {
    const { page, close } = await open(browser, pathToFileURL(resolve(file)).href, { ...screen, motion: "reduce" });
    await page.evaluate(axe);
    const { violations } = await page.evaluate(() => axe.run(document, { resultTypes: ["violations"], preload: false }));
    for (const { id, impact, help, nodes } of violations.filter(({ impact: how }) => GRAVE.includes(how)))
      check(false, `${basename(file)}, ${screen.width} ${screen.scheme}: ${impact}: ${id}: ${help} (${nodes.length}, ${nodes[0].html.slice(0, 110)})`);
    await close();
  }
await browser.close();
finish(failures);
