// The page of a comparison: the key hides and lights the lines of a tuner, and one heat map is shown at a time.

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
