// node browser/studies.mjs ADDRESS FOLDER: reads the page of a folder of studies; once "ready" is printed, the study "below/new" goes on.
import { mkdirSync } from "node:fs";
import { join } from "node:path";
import { checker, comes, finish, launch, open } from "./open.mjs";

const [address, folder] = process.argv.slice(2);
const { check, failures } = checker();
const CHANGED = 12; // the column, from 1

const names = (page) => page.locator("#studies tbody tr:visible th").allInnerTexts();

async function inspect(name, { page, requests, complaints }) {
  const wide = await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
  check(wide <= 0, `${name}: nothing is wider than the page (${wide} px too much)`);
  check(requests.every((url) => url.startsWith(address) || url.startsWith("data:")), `${name}: nothing is asked for elsewhere: ${requests.join(" ")}`);
  check(complaints.length === 0, `${name}: no errors: ${complaints.join("\n")}`);
}

/** The newest study is first, words sift, and the address keeps them. */
async function sift(page) {
  const when = await page.locator(`#studies tbody tr td:nth-child(${CHANGED})`).evaluateAll((cells) => cells.map((cell) => Number(cell.dataset.value)));
  check(when.every((value, i) => i === 0 || value <= when[i - 1]), "the study that changed last is first");
  const all = await names(page);
  await page.locator("#sift").fill("done 7");
  const some = await names(page);
  check(some.length > 0 && some.length < all.length && some.every((name) => /done/.test(name)), `words sift the studies: ${some}`);
  check((await page.locator("#count").innerText()) === `${some.length} of ${all.length}`, "and say how many are left");
  await page.reload();
  check((await names(page)).join() === some.join(), "the address keeps the words");
  await page.locator("#sift").fill("");
  check((await names(page)).length === all.length, "without words all are there");
}

const browser = await launch({ drawing: false });
mkdirSync(folder, { recursive: true });
for (const [name, size] of [["desktop-light", { width: 1280, height: 900, scheme: "light" }], ["phone-dark", { width: 360, height: 800, scheme: "dark" }]]) {
  const opened = await open(browser, address, size);
  await inspect(name, opened);
  await opened.page.screenshot({ path: join(folder, `${name}.png`) });
  await opened.close();
}
const opened = await open(browser, address, { width: 1280, height: 900, scheme: "light" });
const { page } = opened;
await sift(page);
await page.locator("#sift").fill("below");
await page.locator("thead button", { hasText: /^flights/ }).click();
const row = page.locator('tr[data-name="below/new"]');
const before = await row.innerText();
await row.locator("a").focus();
console.log("ready");
check(await comes(page, (text) => document.querySelector('tr[data-name="below/new"]').innerText !== text, before, 60000), "the table follows a study that goes on");
check(await comes(page, () => document.querySelector('tr[data-name="below/new"]').dataset.state === "finished", undefined, 60000), "to its end");
check((await page.locator("#sift").inputValue()) === "below" && (await names(page)).every((name) => name.startsWith("below")), "the words stay");
check((await page.locator("th[aria-sort]").innerText()).includes("flights"), "the order stays");
check(await page.evaluate(() => document.activeElement?.closest("tr")?.dataset.name === "below/new"), "who was at a study still is");
await row.locator("a").click();
check(new URL(page.url()).pathname === "/study/below/new/", "a press leads to the page of a study");
await inspect("in the end", opened);
await browser.close();
finish(failures);
