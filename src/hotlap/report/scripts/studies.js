// The page of a folder of studies: asks for rows that have changed, and keeps the order and the words that its reader has chosen.

const OFTEN = 2000; // ms
const NOTHING_NEW = 204;
const LAST = 11; // the column that says when a study changed

const table = document.querySelector("#studies table");
const body = table.tBodies[0];
const box = document.getElementById("sift");
const asked = () => box.value.toLowerCase().split(/\s+/).filter(Boolean);

/** Shows the rows that hold all words. */
function sift() {
  const words = asked();
  let shown = 0;
  for (const row of body.rows) {
    const text = row.textContent.toLowerCase();
    row.hidden = !words.every((word) => text.includes(word));
    shown += !row.hidden;
  }
  document.getElementById("count").textContent = `${shown} of ${body.rows.length}`;
}

function makeRow({ name, state, cells, values }) {
  const row = document.createElement("tr");
  Object.assign(row.dataset, { name, state });
  const head = document.createElement("th");
  head.scope = "row";
  if (state === "unreadable") head.textContent = name;
  else {
    const link = document.createElement("a");
    link.href = `study/${name.split("/").map(encodeURIComponent).join("/")}/`;
    link.textContent = name;
    head.append(link);
  }
  row.append(head);
  for (const [i, words] of cells.slice(1).entries()) {
    const cell = row.insertCell();
    cell.textContent = words;
    cell.className = table.tHead.rows[0].cells[i + 1].className;
    if (values[i + 1] !== undefined) cell.dataset.value = values[i + 1];
  }
  return row;
}

function take({ version, rows, gone }) {
  const known = new Map([...body.rows].map((row) => [row.dataset.name, row]));
  const held = document.activeElement?.closest("tbody tr")?.dataset.name;
  for (const name of gone) known.get(name)?.remove();
  for (const plain of rows) {
    const row = makeRow(plain);
    const before = known.get(plain.name);
    if (before) before.replaceWith(row);
    else body.append(row);
  }
  body.dataset.version = version;
  sortRows(table);
  sift();
  if (held !== undefined) [...body.rows].find((row) => row.dataset.name === held)?.querySelector("a")?.focus(); // a row that is moved lets go
}

async function ask() {
  let lost = false;
  try {
    const answer = await fetch(`data.json?flights=${body.dataset.version}`, { cache: "no-store" });
    if (answer.ok && answer.status !== NOTHING_NEW) take(await answer.json());
    lost = !answer.ok;
  } catch {
    lost = true;
  }
  document.getElementById("lost").textContent = lost ? "No connection to hotlap watch: this page may be out of date." : "";
  setTimeout(ask, OFTEN);
}

box.closest("p").hidden = false;
box.value = decodeURIComponent(location.hash.slice(1));
box.addEventListener("input", () => {
  history.replaceState(null, "", `#${encodeURIComponent(box.value)}`);
  sift();
});
sortBy(table, LAST);
sift();
setTimeout(ask, OFTEN);
