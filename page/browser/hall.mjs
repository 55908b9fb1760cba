// node browser/hall.mjs PAGE.html: looks at a track with openings and obstacles from every camera, in both colours.
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { checker, comes, finish, launch, open } from "./open.mjs";

const address = pathToFileURL(resolve(process.argv[2])).href;
const { check, failures } = checker();

/** How many pixels of the scene are of the grey of frames and obstacles. */
const drawn = (page) =>
  page.evaluate(async () => {
    const scene = document.getElementById("scene");
    await new Promise((next) => requestAnimationFrame(next));
    const canvas = new OffscreenCanvas(scene.clientWidth, scene.clientHeight);
    const pen = canvas.getContext("2d");
    pen.drawImage(await createImageBitmap(await (await fetch(window.hotlap.still())).blob()), 0, 0, canvas.width, canvas.height);
    const { data } = pen.getImageData(0, 0, canvas.width, canvas.height);
    let count = 0;
    for (let i = 0; i < data.length; i += 4) count += data[i] > 185 && data[i] < 215 && data[i] === data[i + 1] && data[i] === data[i + 2];
    return count;
  });

const browser = await launch();
const { page, complaints } = await open(browser, address, { width: 1000, height: 800, scheme: "light", motion: "reduce" });
check(await comes(page, () => window.hotlap?.frames() > 0), "the scene is drawn");
for (const key of ["2", "3", "1"]) {
  await page.keyboard.press(key);
  check((await drawn(page)) > 1000, `camera ${key}: gates and obstacles are seen`);
}
check(complaints.length === 0, `no errors: ${complaints.join("\n")}`);
await browser.close();
finish(failures);
