// node browser/study.mjs PAGE.html FOLDER [long]: plays a study's page as a reader would, and takes pictures; long: it holds a long condition.
import { mkdirSync } from "node:fs";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { checker, comes, finish, launch, open } from "./open.mjs";

const [file, folder, conditions] = process.argv.slice(2);
const address = pathToFileURL(resolve(file)).href;
const CARDS = ["parameters", "robustness", "telemetry", "response", "convergence", "endings", "effort", "sensitivity", "samples", "configuration"];
const SIZES = { desktop: { width: 1440, height: 900, scheme: "light" }, phone: { width: 360, height: 800, scheme: "dark", motion: "reduce" } };
const { check, failures } = checker();

const time = (page) => page.locator("#time").inputValue().then(Number);
const place = (page) => page.evaluate(() => window.hotlap.place());

/** What every page must have, whatever its size and colours. */
async function inspect(name, { page, requests, complaints }) {
  check(await comes(page, () => window.hotlap?.frames() > 0), `${name}: the scene is drawn`);
  for (const card of CARDS) check((await page.locator(`#${card}`).innerText()).length > 40, `${name}: ${card} says something`);
  const wide = await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
  check(wide <= 0, `${name}: nothing is wider than the page (${wide} px too much)`);
  const long = page.locator("#robustness th", { hasText: " and " });
  const lines = await long.evaluateAll((names) => names.map((one) => one.getBoundingClientRect().height / parseFloat(getComputedStyle(one).lineHeight)));
  check((lines.length > 0 || conditions !== "long") && lines.every((count) => count < 3.6), `${name}: a long condition has lines of its own (${lines.join(", ")})`);
  check(await page.locator("#static").isHidden(), `${name}: the part for readers without script is hidden`);
  check((await page.locator(".plot canvas").count()) >= 8, `${name}: all charts are drawn`);
  const unnamed = await page.evaluate(() =>
    [...document.querySelectorAll("button, select, input, canvas[role], svg[role]")].filter((one) => !one.ariaLabel && !(one instanceof HTMLElement && one.textContent.trim()) && !one.labels?.length).map((one) => one.outerHTML.slice(0, 80)),
  );
  check(unnamed.length === 0, `${name}: controls and drawings have names: ${unnamed.join(" ")}`);
  const strangers = requests.filter((url) => url !== address && !url.startsWith("data:"));
  check(strangers.length === 0, `${name}: nothing is asked for outside the page: ${strangers.join(" ")}`);
  const key = await page.locator("#convergence .key").innerText();
  check(/passed the goal/.test(key) && /tuned/.test(key) && !/reject/.test(key), `${name}: flights are said to have passed the goal, and which was kept: ${key}`);
  const shares = (await page.locator("#effort td").allInnerTexts()).filter((words) => words.includes("%"));
  check(shares.length > 3 && shares.every((words) => !/<1 %|>99 %/.test(words)), `${name}: shares of effort are numbers: ${shares.join("; ")}`);
  check(/search time \d/.test(await page.locator(".headline").innerText()), `${name}: the time is that of the search, and is called so`);
  const touch = await page.locator("#telemetry .note .by-touch").isVisible();
  check(touch === (name === "phone") && touch !== (await page.locator("#telemetry .note .by-mouse").isVisible()), `${name}: what is said of fingers and mice is what is there`);
  check(complaints.length === 0, `${name}: no errors: ${complaints.join("\n")}`);
}

/** The clock plays, and everything follows it. */
async function play(page) {
  check(await comes(page, () => Number(document.getElementById("time").value) > 0.2), "the flight plays by itself");
  const before = await place(page);
  check(await comes(page, (from) => window.hotlap.place().some((value, k) => Math.abs(value - from[k]) > 0.2), before), "the drone moves with the clock");
  await page.keyboard.press("Space");
  const stopped = await time(page);
  await page.waitForTimeout(300);
  check(stopped === (await time(page)), "space stops the clock");
  await page.keyboard.press("ArrowRight");
  check(Math.abs((await time(page)) - stopped - 0.1) < 0.02, "an arrow moves the clock by a tenth of a second");
}

/** However often someone points at a chart, the clock makes one step a frame. */
async function count(page) {
  const asked = await page.evaluate(async () => {
    const chart = document.querySelector("#telemetry .u-over");
    if (document.getElementById("play").textContent === "▶") document.getElementById("play").click();
    for (let i = 0; i < 20; i++) for (const name of ["pointerenter", "pointerleave"]) chart.dispatchEvent(new PointerEvent(name));
    const ask = window.requestAnimationFrame;
    let asked = 0;
    window.requestAnimationFrame = (call) => ask((now) => (asked++, call(now)));
    for (let frame = 0; frame < 10; frame++) await new Promise((next) => ask(next));
    window.requestAnimationFrame = ask;
    document.getElementById("play").click();
    return asked;
  });
  check(asked <= 30, `the clock makes one step a frame, not ${asked} in ten frames`);
}

/** Slider, charts and segments are linked. */
async function link(page) {
  await page.locator("#time").fill("1");
  const early = await place(page);
  await page.locator("#time").fill("3");
  check(await comes(page, (from) => Math.abs(window.hotlap.place()[0] - from[0]) + Math.abs(window.hotlap.place()[1] - from[1]) > 0.1, early), "the slider moves the drone");
  const chart = page.locator("#telemetry .u-over").first();
  await chart.scrollIntoViewIfNeeded();
  const box = await chart.boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  const middle = Number(await page.locator("#time").getAttribute("max")) / 2;
  check(Math.abs((await time(page)) - middle) < 0.05 * middle, "pointing at the middle of a chart moves the clock to the middle");
  await page.mouse.move(5, 5);
  const button = page.locator("#parameters .segments button").last();
  await button.scrollIntoViewIfNeeded();
  await button.hover();
  const segment = await button.getAttribute("data-segment");
  check((await page.locator(`.band.lit[data-segment="${segment}"]`).count()) > 0, "pointing at a segment lights it on the slider");
  await button.click();
  check((await button.getAttribute("aria-pressed")) === "true", "a segment can be chosen");
}

/** Flights, cameras, axes and colours can be switched. */
async function choose(page) {
  const chips = page.locator(".chip");
  const count = await chips.count();
  check(count > 0, "there are flights to show");
  const lines = () => page.locator("#telemetry .readout .flight").count();
  const before = await lines();
  await chips.last().click();
  check((await lines()) < before, "a chip hides a flight in the charts");
  await chips.last().click();
  check((await lines()) === before, "and shows it again");
  for (const [key, camera] of [["1", "follow"], ["3", "top"], ["2", "orbit"]]) {
    await page.keyboard.press(key);
    check((await page.locator(`[data-camera=${camera}]`).getAttribute("aria-pressed")) === "true", `key ${key}: camera ${camera}`);
  }
  await page.locator("[data-axis=distance]").click();
  check((await page.locator("[data-axis=distance]").getAttribute("aria-pressed")) === "true", "charts can be drawn along the track");
  await page.locator("[data-axis=time]").click();
  const face = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  const light = await face();
  await page.locator("#theme").click();
  check(light !== (await face()), "colours can be switched");
  await page.locator("#theme").click();
  await page.locator("#copy").click();
  check(await comes(page, () => document.getElementById("copy").textContent !== "copy"), "the command can be copied");
}

async function desktop(browser) {
  const opened = await open(browser, address, SIZES.desktop);
  const { page } = opened;
  await comes(page, () => window.hotlap?.frames() > 0);
  await play(page);
  await count(page);
  await link(page);
  await choose(page);
  await inspect("desktop", opened);
  await page.evaluate(() => window.scrollTo(0, 0));
  await page.waitForTimeout(600);
  await page.screenshot({ path: join(folder, "desktop.png"), fullPage: true });
  await page.pdf({ path: join(folder, "print.pdf"), format: "A4", printBackground: true, preferCSSPageSize: true });
  await opened.close();
}

async function phone(browser) {
  const opened = await open(browser, address, SIZES.phone);
  const { page } = opened;
  await inspect("phone", opened);
  const rested = await time(page);
  check(rested > 0, "without motion the lap is shown from its end");
  await page.waitForTimeout(300);
  check(rested === (await time(page)), "nothing moves for readers who want no motion");
  const order = await page.evaluate(() => document.getElementById("scene").getBoundingClientRect().top < document.getElementById("parameters").getBoundingClientRect().top);
  check(order, "the scene comes first on a phone");
  await page.screenshot({ path: join(folder, "phone.png"), fullPage: true });
  await opened.close();
}

/** Without script, and without WebGL, there is still something to read. */
async function without() {
  const browser = await launch({ drawing: false });
  const still = await open(browser, address, { ...SIZES.desktop, script: false });
  check((await still.page.locator("#static").innerText()).length > 200, "without script the study can be read");
  await still.page.screenshot({ path: join(folder, "without-script.png") });
  await still.close();
  const flat = await open(browser, address, SIZES.phone);
  check(await comes(flat.page, () => document.querySelector(".map svg") !== null), "without WebGL the map is shown");
  check((await flat.page.locator("#convergence canvas").count()) > 0, "without WebGL the charts are drawn");
  await flat.close();
  await browser.close();
}

mkdirSync(folder, { recursive: true });
const browser = await launch();
await desktop(browser);
await phone(browser);
await browser.close();
await without();
finish(failures);
