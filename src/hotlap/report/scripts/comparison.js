// The page of a comparison: the key hides and lights the lines of a tuner, a chart says its values where it is pointed at, and one heat map
// is shown at a time.

for (const button of document.querySelectorAll(".legend button")) {
  const { tuner } = button.dataset;
  const lines = document.querySelectorAll(`.chart [data-tuner=${tuner}]`);
  button.addEventListener("click", () => {
    const shown = button.getAttribute("aria-pressed") !== "true";
    button.setAttribute("aria-pressed", String(shown));
    for (const line of lines) line.classList.toggle("away", !shown);
  });
  const light = (on) => {
    document.body.classList.toggle("one-lit", on);
    for (const line of lines) line.classList.toggle("lit", on);
  };
  for (const [event, on] of [["pointerenter", true], ["pointerleave", false], ["focus", true], ["blur", false]]) button.addEventListener(event, () => light(on));
}

const NAMES = new Map([...document.querySelectorAll(".legend button")].map(({ dataset, textContent }) => [dataset.tuner, textContent]));
const STEP = 1.04; // of x, for a press of an arrow
const GAP = 8; // px, from the pointer to the box

/** Values of a line at x: the last that were reached; null beyond its end. */
function valuesAt(line, x) {
  if (x > Number(line.dataset.end) * 1.0001) return null;
  const steps = line.dataset.steps.split(";").map((step) => step.split(" ").map(Number));
  return steps.findLast(([from]) => from <= x * 1.0001)?.slice(1) ?? null;
}

/** Says the values of a chart in a box beside the pointer, or where the arrows have moved. */
function say(chart) {
  const box = document.createElement("div");
  box.className = "values";
  box.setAttribute("role", "status");
  box.hidden = true;
  chart.parentElement.append(box);
  const cursor = document.createElementNS("http://www.w3.org/2000/svg", "path");
  cursor.classList.add("cursor");
  chart.append(cursor);
  const { left, width, most, place } = chart.dataset;
  const whole = place.startsWith("flight");
  let at = 1;
  const show = (x) => {
    at = Math.min(Math.max(x, 1), Number(most));
    const shown = whole ? Math.round(at) : at;
    const across = Number(left) + (Number(width) * Math.log(shown)) / Math.log(Number(most));
    cursor.setAttribute("d", `M${across} 12V${chart.viewBox.baseVal.height - 40}`);
    const rows = [...chart.querySelectorAll(".line:not(.away)")].map((line) => {
      const values = valuesAt(line, shown);
      const row = document.createElement("span");
      const [middle, low, high] = values ?? [];
      const told = values === null ? "ended" : `${middle} %${low === undefined || low === high ? "" : ` (${low} to ${high})`}`;
      row.className = line.classList[1];
      row.textContent = `${NAMES.get(line.dataset.tuner)} ${told}`;
      return row;
    });
    const head = document.createElement("b");
    head.textContent = place.replace("{x}", whole ? String(shown) : shown.toFixed(shown < 10 ? 1 : 0));
    box.replaceChildren(head, ...rows);
    box.hidden = false;
    const { left: edge, width: size } = chart.getBoundingClientRect();
    const pixels = edge + (across / chart.viewBox.baseVal.width) * size;
    const right = pixels + GAP + box.offsetWidth < document.documentElement.clientWidth;
    const from = right ? pixels + GAP : Math.max(GAP, pixels - GAP - box.offsetWidth);
    box.style.left = `${Math.min(from, document.documentElement.clientWidth - GAP - box.offsetWidth) - edge}px`;
  };
  const hide = () => {
    box.hidden = true;
    cursor.removeAttribute("d");
  };
  const point = (event) => {
    const { left: edge, width: size } = chart.getBoundingClientRect();
    const across = ((event.clientX - edge) / size) * chart.viewBox.baseVal.width;
    show(Number(most) ** ((across - Number(left)) / Number(width)));
  };
  for (const name of ["pointermove", "pointerdown"]) chart.addEventListener(name, point);
  for (const name of ["pointerleave", "pointercancel", "blur"]) chart.addEventListener(name, hide);
  chart.tabIndex = 0;
  chart.addEventListener("focus", () => chart.matches(":focus-visible") && show(at));
  chart.addEventListener("keydown", (event) => {
    const way = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!way) return;
    event.preventDefault();
    show(whole ? Math.max(Math.round(at) + way, 1) : at * STEP ** way);
  });
}

for (const chart of document.querySelectorAll(".chart svg")) say(chart);

const maps = [...document.querySelectorAll("[data-measure]")];
const choice = document.createElement("div");
choice.className = "choice";
choice.setAttribute("role", "group");
choice.setAttribute("aria-label", "what the map shows");

function show(measure) {
  for (const map of maps) map.hidden = map.dataset.measure !== measure;
  for (const button of choice.children) button.setAttribute("aria-pressed", String(button.dataset.shows === measure));
}

for (const { dataset } of maps) {
  const button = document.createElement("button");
  button.type = "button";
  button.dataset.shows = dataset.measure;
  button.textContent = dataset.measure;
  button.addEventListener("click", () => show(dataset.measure));
  choice.append(button);
}
if (maps.length) {
  maps[0].before(choice);
  show(maps[0].dataset.measure);
}
