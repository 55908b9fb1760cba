"use strict";
// Tables that can be sorted: every head of a column becomes a button, which sorts by it, and the other way round when it is pressed again.
// A cell is compared by its data-value, else by the number it begins with, else by its words; cells without a value come last.

const NUMBER = /^[<+]?(-?\d+(\.\d+)?)/;

function valueOf(cell) {
  const words = cell.dataset.value ?? cell.textContent.trim();
  const number = NUMBER.exec(words);
  return number ? Number(number[1]) : words === "-" ? "" : words.toLowerCase();
}

function compareCells(one, other) {
  if (typeof one === "number" && typeof other === "number") return one - other;
  return String(one).localeCompare(String(other));
}

/** Sorts the rows of a table as its reader has asked for, if at all. */
function sortRows(table) {
  const { column, order } = table.dataset;
  if (column === undefined) return;
  const body = table.tBodies[0];
  const rows = [...body.rows].map((row) => ({ row, value: valueOf(row.cells[Number(column)]) }));
  const sign = order === "descending" ? -1 : 1;
  rows.sort((a, b) => (a.value === "") - (b.value === "") || sign * compareCells(a.value, b.value));
  body.append(...rows.map(({ row }) => row));
}

function sortBy(table, column) {
  const heads = [...table.tHead.rows[0].cells];
  const first = table.tBodies[0].rows[0]?.cells[column];
  const begin = first && typeof valueOf(first) === "number" ? "descending" : "ascending";
  const turned = table.dataset.order === "descending" ? "ascending" : "descending";
  table.dataset.order = table.dataset.column === String(column) ? turned : begin;
  table.dataset.column = column;
  for (const [i, head] of heads.entries()) {
    if (i === column) head.setAttribute("aria-sort", table.dataset.order);
    else head.removeAttribute("aria-sort");
  }
  sortRows(table);
}

for (const table of document.querySelectorAll("table.sortable")) {
  for (const [column, head] of [...table.tHead.rows[0].cells].entries()) {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    button.addEventListener("click", () => sortBy(table, column));
    head.append(button);
  }
}
