// node browser/failed.mjs PAGE.html FOLDER: the page of a study that failed says so, why, and what to try.
import { mkdirSync } from "node:fs";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { checker, comes, finish, launch, open } from "./open.mjs";

const [file, folder] = process.argv.slice(2);
const address = pathToFileURL(resolve(file)).href;
const { check, failures } = checker();
const MISLEADING = [/why is it better/i, /hardly matter/i, /almost no effect/i, /^best$/m];

async function look(browser, name, size) {
  const { page, complaints, close } = await open(browser, address, size);
  check(await comes(page, () => window.hotlap?.frames() > 0), `${name}: the scene is drawn`);
  const verdict = page.locator("#verdict");
  check(await verdict.isVisible(), `${name}: there is a verdict`);
  for (const words of [/not confirmed/i, /why it failed/i, /what to try/i]) check(words.test(await verdict.innerText()), `${name}: the verdict says ${words}`);
  check((await verdict.locator("li").count()) >= 3, `${name}: with reasons and things to try`);
  check((await page.evaluate(() => document.getElementById("verdict").getBoundingClientRect().top - document.getElementById("parameters").getBoundingClientRect().top)) < 0, `${name}: above the parameters`);
  const text = await page.locator("#app").innerText();
  for (const words of MISLEADING) check(!words.test(text), `${name}: nothing says ${words}`);
  check(/not solved in/.test(await page.locator(".headline").innerText()), `${name}: the headline says that it is not solved`);
  check(/cost instead/.test(await page.locator("#sensitivity").innerText()), `${name}: sensitivity is that of the cost where no gate is lost or gained`);
  check(/cost added/.test(await page.locator("#parameters").innerText()), `${name}: and so are the losses beside the parameters`);
  check(/typical flight/.test(await page.locator("#shown-flights").innerText()), `${name}: what is shown is said`);
  check(/where the flights ended that failed/.test(await page.locator("#shown-flights").innerText()), `${name}: the crosses are explained beside the scene`);
  const labels = await page.evaluate(() => window.hotlap.labels().map(({ x, y, half }) => [x, y, half]));
  const covered = labels.flatMap(([x, y, half], i) => labels.slice(i + 1).filter((other) => Math.abs(x - other[0]) < half + other[2] && Math.abs(y - other[1]) < 0.0419));
  check(labels.length > 2 && covered.length === 0, `${name}: no label of the scene covers another (${covered.length} of ${labels.length})`);
  const bands = await page.locator(".band b:first-child").evaluateAll((all) => all.every((one) => one.offsetTop < 6 && one.scrollWidth <= one.parentElement.parentElement.clientWidth));
  check(bands, `${name}: the numbers of segments are whole in the timeline`);
  const key = await page.locator("#samples .key").innerText();
  check(/passed the goal/.test(key) && /failed the goal/.test(key) && /tuned/.test(key), `${name}: pairs use the words of the convergence: ${key}`);
  check(/accepted by the chain/.test(key) && /accepted by the chain/.test(await page.locator("#convergence .key").innerText()), `${name}: a chain's acceptance is told apart from the goal`);
  const wide = await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
  check(wide <= 0, `${name}: nothing is wider than the page (${wide} px too much)`);
  check(complaints.length === 0, `${name}: no errors: ${complaints.join("\n")}`);
  await page.screenshot({ path: join(folder, `${name}.png`), fullPage: true });
  await close();
}

mkdirSync(folder, { recursive: true });
const browser = await launch();
await look(browser, "desktop", { width: 1440, height: 900, scheme: "light", motion: "reduce" });
await look(browser, "phone", { width: 360, height: 800, scheme: "dark", motion: "reduce" });
await browser.close();
finish(failures);
