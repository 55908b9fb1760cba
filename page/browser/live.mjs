// node browser/live.mjs ADDRESS: watches a study that goes on once "ready" is printed; the page must follow, and keep what its reader has chosen.
import { checker, comes, finish, launch, open } from "./open.mjs";

const [address] = process.argv.slice(2);
const { check, failures } = checker();
const headline = (page) => page.locator(".headline").innerText();

const browser = await launch();
const { page, requests, complaints } = await open(browser, address, { width: 1000, height: 800, scheme: "light", motion: "reduce" });
check(await comes(page, () => window.hotlap?.frames() > 0), "the scene is drawn");
await page.keyboard.press("3");
await page.locator("#time").fill("1.5");
await page.locator("#parameters .segments button").last().click();
const before = await headline(page);
console.log("ready");
check(await comes(page, (text) => document.querySelector(".headline").innerText !== text, before, 40000), "the headline follows the study");
check((await page.locator("[data-camera=top]").getAttribute("aria-pressed")) === "true", "the camera stays");
check((await page.locator("#time").inputValue()) === "1.5", "the clock stays");
check((await page.locator("#parameters .segments button").last().getAttribute("aria-pressed")) === "true", "the chosen segment stays");
check(requests.every((url) => url.startsWith(address) || url.startsWith("data:")), `nothing is asked for elsewhere: ${requests.join(" ")}`);
check(complaints.length === 0, `no errors: ${complaints.join("\n")}`);
await browser.close();
finish(failures);
