// Opens pages in Chromium, drawn by the processor, and notes whatever goes wrong.
import { chromium } from "playwright-core";

const CHROMIUM = process.env.CHROMIUM ?? "/usr/bin/chromium";
const ALWAYS = ["--headless", "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"];
const PATIENCE = 90000; // ms: a busy processor draws slowly
const DRAWING = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"];

/** A browser; without WebGL if so asked. */
export const launch = ({ drawing = true } = {}) =>
  chromium.launch({ executablePath: CHROMIUM, args: [...ALWAYS, ...(drawing ? DRAWING : ["--disable-3d-apis"])] });

/** A page with what it asked for and what it complained of. */
export async function open(browser, address, { width, height, scheme, motion = "no-preference", script = true }) {
  const context = await browser.newContext({ viewport: { width, height }, colorScheme: scheme, reducedMotion: motion, javaScriptEnabled: script });
  const page = await context.newPage();
  page.setDefaultTimeout(PATIENCE);
  page.setDefaultNavigationTimeout(PATIENCE);
  const [requests, complaints] = [[], []];
  page.on("request", (request) => requests.push(request.url()));
  page.on("pageerror", (error) => complaints.push(error.stack ?? String(error)));
  page.on("console", (message) => message.type() === "error" && complaints.push(message.text()));
  await page.goto(address);
  return { page, requests, complaints, close: () => context.close() };
}

/** Collects what does not hold. */
export function checker() {
  const failures = [];
  const check = (holds, what) => {
    if (!holds) failures.push(what);
  };
  return { check, failures };
}

/** Waits until something holds, and says whether it came to hold. */
export async function comes(page, condition, argument, timeout = PATIENCE) {
  try {
    await page.waitForFunction(condition, argument, { timeout });
    return true;
  } catch {
    return false;
  }
}

/** Ends with what failed, as the exit code says. */
export function finish(failures) {
  for (const failure of failures) console.error(`failed: ${failure}`);
  process.exitCode = failures.length ? 1 : 0;
}
