// node browser/verdict.mjs PAGE.html WORDS: the page of a study that failed says exactly this of its new flights.
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { checker, comes, finish, launch, open } from "./open.mjs";

const [file, words] = process.argv.slice(2);
const { check, failures } = checker();
const browser = await launch();
const { page, complaints, close } = await open(browser, pathToFileURL(resolve(file)).href, { width: 1440, height: 900, scheme: "light", motion: "reduce" });
check(await comes(page, () => window.hotlap?.frames() > 0), "the scene is drawn");
const said = await page.locator("#verdict li").first().innerText();
check(said === words, `the verdict says ${said}`);
check(complaints.length === 0, `no errors: ${complaints.join("\n")}`);
await close();
await browser.close();
finish(failures);
