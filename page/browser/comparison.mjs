// node browser/comparison.mjs PAGE.html FOLDER: reads the page of a comparison as a reader would, and takes pictures.
import { mkdirSync } from "node:fs";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { checker, finish, launch, open } from "./open.mjs";

const [file, folder] = process.argv.slice(2);
const address = pathToFileURL(resolve(file)).href;
const WIDE = { width: 1280, height: 900 };
const NARROW = { width: 360, height: 800 };
const { check, failures } = checker();

/** How many pixels of an element have about the colour of each tuner's line. */
async function countPixels(page, element, colours) {
  const picture = (await element.screenshot()).toString("base64");
  return page.evaluate(
    async ([data, wanted]) => {
      const image = await createImageBitmap(await (await fetch(`data:image/png;base64,${data}`)).blob());
      const context = new OffscreenCanvas(image.width, image.height).getContext("2d");
      context.drawImage(image, 0, 0);
      const pixels = context.getImageData(0, 0, image.width, image.height).data;
      return wanted.map((colour) => {
        const [r, g, b] = colour.match(/\d+/g).map(Number);
        let count = 0;
        for (let i = 0; i < pixels.length; i += 4) count += Math.abs(pixels[i] - r) + Math.abs(pixels[i + 1] - g) + Math.abs(pixels[i + 2] - b) < 60;
        return count;
      });
    },
    [picture, colours],
  );
}

const lineColours = (page) => page.locator(".legend .line").evaluateAll((lines) => lines.map((line) => getComputedStyle(line).stroke));

/** What every page must have, whatever its size and colours. */
async function inspect(name, { page, requests, complaints }) {
  const wide = await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
  check(wide <= 0, `${name}: nothing is wider than the page (${wide} px too much)`);
  const chart = page.locator(".charts .chart", { hasText: "all alike" });
  await chart.scrollIntoViewIfNeeded();
  const counts = await countPixels(page, chart, await lineColours(page));
  check(counts.every((count) => count > 120), `${name}: lines that coincide are all seen (${counts.join(", ")} pixels)`);
  const named = await page.locator(".chart svg").evaluateAll((charts) => charts.every((svg) => svg.querySelectorAll("text.name").length === 2));
  check(named, `${name}: both axes of every chart have a name`);
  check((await page.locator(".legend").count()) === 1, `${name}: there is one key`);
  const nameless = await page.locator("button, [role=img]").evaluateAll((all) => all.filter((one) => !one.ariaLabel && !one.textContent.trim()).length);
  check(nameless === 0, `${name}: controls and drawings have names`);
  check(requests.every((url) => url === address || url.startsWith("data:")), `${name}: nothing is asked for outside the page: ${requests.join(" ")}`);
  check(complaints.length === 0, `${name}: no errors: ${complaints.join("\n")}`);
}

const column = (table, n) => table.locator(`tbody tr > :nth-child(${n})`).allInnerTexts();

/** Any column sorts a table, numbers as numbers. */
async function sort(page) {
  const table = page.locator("table.sortable:not(.heat)").nth(1); // race by race
  const head = (words) => table.locator("thead button", { hasText: words });
  const numbers = async (n) => (await column(table, n)).map((text) => (text === "-" ? NaN : Number.parseFloat(text)));
  const before = (await column(table, 1)).length;
  await head("validated").click();
  const falling = await numbers(5);
  check(falling.every((value, i) => i === 0 || value <= falling[i - 1]), `a press sorts by a column, the best first: ${falling}`);
  await head("validated").click();
  const rising = await numbers(5);
  check(rising.every((value, i) => i === 0 || value >= rising[i - 1]), `another press turns the order round: ${rising}`);
  check((await table.locator("th[aria-sort=ascending]").count()) === 1, "the order is said to those who listen");
  for (const turn of ["once", "twice"]) {
    await head("lap s").click();
    const laps = await numbers(9);
    const last = laps.findLastIndex((value) => !Number.isNaN(value));
    check(Number.isNaN(laps.at(-1)) && laps.slice(0, last).every((value) => !Number.isNaN(value)), `${turn}: cells without a value come last: ${laps}`);
  }
  await head("tuner").focus();
  await page.keyboard.press("Enter");
  const names = await column(table, 2);
  check(names.every((name, i) => i === 0 || name.localeCompare(names[i - 1]) >= 0), "words are sorted too, by the keyboard");
  check((await column(table, 1)).length === before, "no row is lost");
}

/** A chart says the values of its lines, by the pointer and by the arrow keys. */
async function point(page) {
  const figure = page.locator(".charts .chart", { hasText: "all alike" });
  const chart = figure.locator("svg");
  await chart.scrollIntoViewIfNeeded();
  const { width, height } = await chart.boundingBox();
  await chart.hover({ position: { x: 0.9 * width, y: 0.4 * height } });
  const values = figure.locator(".values");
  const told = await values.innerText();
  check(/^flight \d+/.test(told) && (told.match(/100 %/g) ?? []).length === (await page.locator(".legend button").count()), `a chart says the value of every line: ${told}`);
  const box = await values.boundingBox();
  check(box.x >= 0 && box.x + box.width <= page.viewportSize().width, "on the page");
  await page.mouse.move(2, 2);
  check(await values.isHidden(), "until the pointer leaves");
  await chart.focus();
  for (let press = 0; press < 3; press++) await page.keyboard.press("ArrowLeft");
  const before = Number(/\d+/.exec(await values.innerText())[0]);
  await page.keyboard.press("ArrowRight");
  check(Number(/\d+/.exec(await values.innerText())[0]) === before + 1, "the arrows go from flight to flight");
  await page.keyboard.press("Tab");
  check(await values.isHidden(), "and the box goes with the focus");
}

/** Where a table is cut there is a shadow, and only there. */
async function shadows(page) {
  const painted = await page.locator(".wide").evaluateAll((all) => all.every((one) => getComputedStyle(one).backgroundAttachment.includes("local")));
  check(painted && (await page.locator(".wide").count()) > 0, "a table that is cut has a shadow at its edge");
}

/** The key hides a tuner everywhere, and lights it. */
async function choose(page) {
  const first = page.locator(".legend button").first();
  const lines = page.locator(".chart [data-tuner=t0]");
  const seen = () => lines.evaluateAll((all) => all.filter((one) => getComputedStyle(one).display !== "none").length);
  check((await seen()) === (await lines.count()), "all tuners are drawn");
  await first.click();
  check((await seen()) === 0 && (await first.getAttribute("aria-pressed")) === "false", "a press hides a tuner in all charts");
  await first.click();
  check((await seen()) > 0, "and shows it again");
  await first.hover();
  const faint = () => page.locator(".chart .line[data-tuner=t1]").first().evaluate((line) => Number(getComputedStyle(line).opacity));
  check((await faint()) < 0.5, "pointing at a tuner lights its lines");
  await first.blur();
  await page.mouse.move(5, 5);
  check((await faint()) === 1, "until the pointer leaves");
  const maps = () => page.locator("[data-measure]").evaluateAll((all) => all.filter((one) => one.offsetHeight > 0).map((one) => one.dataset.measure));
  for (const measure of ["flights", "confirmed", "validated"]) {
    await page.locator(`[data-shows=${measure}]`).click();
    check((await maps()).join() === measure, `the map shows ${measure} alone: ${await maps()}`);
  }
  const shades = await page.locator("[data-measure=validated] td").evaluateAll((cells) => new Set(cells.map((cell) => getComputedStyle(cell).backgroundColor)).size);
  check(shades > 2, "the map has shades");
}

mkdirSync(folder, { recursive: true });
const browser = await launch({ drawing: false });
const seen = {};
for (const scheme of ["light", "dark"]) {
  for (const [name, size] of [["desktop", WIDE], ["phone", NARROW]]) {
    const opened = await open(browser, address, { ...size, scheme });
    await inspect(`${name}, ${scheme}`, opened);
    seen[scheme] = await lineColours(opened.page);
    if (name === "desktop") await sort(opened.page);
    if (name === "desktop") await choose(opened.page);
    await point(opened.page);
    await shadows(opened.page);
    if (scheme === "dark") {
      const [paper] = await countPixels(opened.page, opened.page.locator(".chart").first(), ["rgb(255, 255, 255)"]);
      check(paper < 200, `${name}: charts are dark in the dark (${paper} white pixels)`);
    }
    await opened.page.screenshot({ path: join(folder, `${name}-${scheme}.png`), fullPage: true });
    await opened.close();
  }
}
check(seen.light.every((colour, i) => colour !== seen.dark[i]), "lines have other colours in the dark");
const still = await open(browser, address, { ...WIDE, scheme: "light", script: false });
const shown = await still.page.locator("table").evaluateAll((tables) => tables.every((table) => table.offsetHeight > 0)).catch(() => true);
check(shown && (await still.page.locator("[data-measure]").count()) === 3, "without script all can be read");
await browser.close();
finish(failures);
