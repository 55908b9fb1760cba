// node browser/tool.mjs PAGE.html FOLDER: zoom, signals, link, download and keys of a study's page, and its responses.
import { mkdirSync, readFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { checker, comes, finish, launch, open } from "./open.mjs";

const [file, folder] = process.argv.slice(2);
const address = pathToFileURL(resolve(file)).href;
const DESKTOP = { width: 1440, height: 900, scheme: "light", motion: "reduce" };
const PHONE = { width: 360, height: 800, scheme: "dark", motion: "reduce" };
const { check, failures } = checker();

const shown = (page) => page.locator("#shown").innerText();
const time = (page) => page.locator("#time").inputValue().then(Number);
const hash = (page) => page.evaluate(() => decodeURIComponent(location.hash));
const plots = (page) => page.locator("#telemetry .chart:not([hidden])").count();
const wide = (page) => page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);

/** From and to [s] that the charts show; NaN for all. */
const range = async (page) => ((await shown(page)).match(/[\d.]+/g) ?? [NaN, NaN]).map(Number);

async function opened(browser, where, size = DESKTOP) {
  const one = await open(browser, where, size);
  check(await comes(one.page, () => window.hotlap?.frames() > 0), "the scene is drawn");
  return one;
}

/** By dragging, with the wheel and by keys; the clock and the charts stay together. */
async function zoom(page) {
  const chart = page.locator("#telemetry .u-over").first();
  await chart.scrollIntoViewIfNeeded();
  const box = await chart.boundingBox();
  const whole = Number(await page.locator("#time").getAttribute("max"));
  const at = (share) => [box.x + share * box.width, box.y + box.height / 2];
  await page.mouse.move(...at(0.25));
  await page.mouse.down();
  await page.mouse.move(...at(0.4), { steps: 4 });
  await page.mouse.move(...at(0.5), { steps: 4 });
  await page.mouse.up();
  const [from, to] = await range(page);
  check(Math.abs(from - 0.25 * whole) < 0.06 * whole && Math.abs(to - 0.5 * whole) < 0.06 * whole, `dragging shows what was dragged over (${from} to ${to} of ${whole})`);
  await page.mouse.move(...at(0.5));
  check(Math.abs((await time(page)) - (from + to) / 2) < 0.05 * (to - from), "pointing at the middle of a zoomed chart moves the clock there");
  await page.keyboard.down("Shift");
  await page.mouse.down();
  await page.mouse.move(...at(0.3), { steps: 4 });
  await page.mouse.up();
  await page.keyboard.up("Shift");
  check((await range(page))[0] > from, "dragging with shift moves the chart");
  await page.keyboard.down("Control");
  await page.mouse.wheel(0, -200);
  await page.keyboard.up("Control");
  const narrow = await range(page);
  check(narrow[1] - narrow[0] < 0.9 * (to - from), "ctrl and the wheel zoom");
  await page.mouse.dblclick(...at(0.5));
  check((await shown(page)) === "", "a double click shows the whole lap");
  await page.mouse.move(5, 5);
  for (let press = 0; press < 4; press++) await page.keyboard.press("+");
  const [start, end] = await range(page);
  check(end - start < 0.25 * whole, "key + zooms in");
  await page.keyboard.press("[");
  check((await range(page))[0] < start || start === 0, "key [ goes back");
  await page.locator("#time").fill("0.5");
  const [low, high] = await range(page);
  check(low <= 0.5 && 0.5 <= high, "a clock that leaves what is shown takes the charts along");
  await page.keyboard.press("0");
  check((await shown(page)) === "", "key 0 shows the whole lap");
}

async function signals(page) {
  const before = await plots(page);
  await page.keyboard.press("s");
  check(await page.locator("#signals[open]").isVisible(), "key s opens the signals");
  check((await page.evaluate(() => document.activeElement?.type)) === "checkbox", "and puts the focus on the first");
  await page.keyboard.press("Space");
  check((await plots(page)) === before - 1, "space hides the chart of the signal with the focus");
  for (const id of ["tilt", "z", "rotor-most", "roll-rate"]) await page.locator(`#signal-${id}`).check();
  check((await plots(page)) === before + 3, "ticked signals are drawn");
  check((await page.locator("#telemetry .chart:not([hidden]) canvas").count()) === before + 3, "each on a canvas");
  await page.locator("#signals-usual").click();
  check((await plots(page)) === before, "the usual ones come back");
  await page.keyboard.press("s");
}

/** What is chosen stands in the address, and a page with that address shows it. */
async function link(browser, page) {
  await page.keyboard.press("3");
  await page.keyboard.press("a");
  await page.locator("#time").fill("2.5");
  for (let press = 0; press < 2; press++) await page.keyboard.press("+");
  await page.locator(".chip").last().click();
  await page.keyboard.press("s");
  await page.locator("#signal-tilt").check();
  check(await comes(page, () => /camera=top/.test(location.hash) && /t=2.5/.test(location.hash) && /tilt/.test(location.hash)), "the address keeps the view");
  const said = await hash(page);
  check(/zoom=/.test(said) && /axis=distance/.test(said) && /flights=/.test(said), `all of it: ${said}`);
  await page.locator("#link").click();
  check(await comes(page, () => document.getElementById("link").textContent !== "link"), "the link can be copied");
  const other = await opened(browser, address + said);
  check((await time(other.page)) === 2.5, "the other page stands at the same time");
  check((await shown(other.page)) === (await shown(page)), "and shows the same part of the lap");
  check((await other.page.locator("[data-camera=top]").getAttribute("aria-pressed")) === "true", "from the same camera");
  check((await other.page.locator(".chip[aria-pressed=true]").count()) === (await page.locator(".chip[aria-pressed=true]").count()), "with the same flights");
  check((await plots(other.page)) === (await plots(page)), "and the same signals");
  check(other.complaints.length === 0, `without errors: ${other.complaints.join("\n")}`);
  await other.close();
  const odd = await opened(browser, `${address}#camera=under&zoom=9,1&t=x&eye=1,2&segment=999&signals=`);
  check(odd.complaints.length === 0, `a fragment that makes no sense is no error: ${odd.complaints.join("\n")}`);
  await odd.close();
  await page.locator(".chip").last().click();
}

/** Turning the scene is kept, too. */
async function turn(page) {
  await page.keyboard.press("2");
  const box = await page.locator("#scene").boundingBox();
  await page.mouse.move(box.x + 300, box.y + 200);
  await page.mouse.down();
  await page.mouse.move(box.x + 400, box.y + 230, { steps: 3 });
  await page.mouse.up();
  check(await comes(page, () => /eye=/.test(location.hash)), "the address keeps how the scene is turned");
  await page.keyboard.press("r");
  check(await comes(page, () => !/eye=/.test(location.hash)), "key r shows the whole track again");
}

async function download(page) {
  const take = async (act) => {
    const [given] = await Promise.all([page.waitForEvent("download"), act()]);
    return { name: given.suggestedFilename(), text: readFileSync(await given.path(), "utf-8") };
  };
  const flights = await take(() => page.keyboard.press("x"));
  const [head, ...rows] = flights.text.trim().split("\n");
  const columns = head.split(",");
  check(flights.name.endsWith(".csv") && columns[0] === "flight" && columns[1] === "time [s]", `the flights are a table: ${head}`);
  check(rows.length > 100 && rows.every((row) => row.split(",").length === columns.length), "with as many values in each row as there are columns");
  const visible = await page.locator(".chip[aria-pressed=true]").count();
  check(new Set(rows.map((row) => row.split(",")[0])).size === visible, "of the flights that are shown");
  const parameters = await take(() => page.locator("#save-parameters").click());
  check(parameters.name.endsWith("parameters.toml") && /\[\[segment\]\]/.test(parameters.text), "the parameters are a file that hotlap reads");
}

async function keys(page) {
  await page.keyboard.press("?");
  check(await page.locator("#keys[open]").isVisible(), "key ? shows all keys");
  check((await page.locator("#keys tr").count()) >= 20, "the list names them");
  await page.screenshot({ path: join(folder, "keys.png") });
  await page.keyboard.press("Escape");
  check(!(await page.locator("#keys").isVisible()), "escape closes the list");
  const id = await page.locator(".chip").last().getAttribute("id");
  const key = { "chip-best": "t", "chip-first": "f", "chip-default": "d" }[id];
  const pressed = () => page.locator(`#${id}`).getAttribute("aria-pressed");
  const before = await pressed();
  await page.keyboard.press(key);
  check((await pressed()) !== before, `key ${key} switches ${id}`);
  await page.keyboard.press(key);
  await page.keyboard.press(">");
  check((await page.locator("#rate").inputValue()) === "2", "key > makes the clock faster");
}

async function response(page) {
  const card = page.locator("#response");
  check((await card.locator("svg").count()) >= 3, "spectra are drawn");
  check((await card.locator("path.curve").count()) > 3, "with a line for each flight");
  check(/Hz/.test(await card.locator("svg").first().getAttribute("aria-label")), "their peaks are said in words");
  check(/half of it after \d+ ms/.test(await card.innerText()), "a step response is told");
  check((await card.locator("polygon.spread").count()) > 0, "with its uncertainty");
}

mkdirSync(folder, { recursive: true });
const browser = await launch();
const { page, requests, complaints } = await opened(browser, address);
await zoom(page);
await signals(page);
await link(browser, page);
await turn(page);
await keys(page);
await download(page);
await response(page);
check(requests.every((url) => url.startsWith("data:") || url.startsWith("blob:") || url.split("#")[0] === address), `nothing is asked for outside the page: ${requests.join(" ")}`);
check(complaints.length === 0, `no errors: ${complaints.join("\n")}`);
const phone = await opened(browser, `${address}#zoom=1,3&signals=error,tilt`, PHONE);
check((await wide(phone.page)) <= 0, "nothing is wider than a phone");
await phone.page.locator("#help").click();
check((await phone.page.evaluate(() => { const list = document.getElementById("keys"); return list.scrollWidth - list.clientWidth; })) <= 0, "the list of keys fits a phone");
await phone.page.screenshot({ path: join(folder, "keys-phone.png") });
await browser.close();
finish(failures);
