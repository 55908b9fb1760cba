/** Help: all keys, and what pointer and fingers do, over the page. */
import { h } from "../dom";
import { KEYS } from "../keys";

const POINTER: readonly (readonly [string, string])[] = [
  ["point", "the clock follows on a chart"],
  ["drag", "zoom a chart, turn the scene"],
  ["shift + drag", "move a zoomed chart"],
  ["ctrl + wheel, two fingers", "zoom"],
  ["double click", "the whole lap"],
];

/** A button that opens the list. */
export function help(): HTMLElement {
  const dialog = h("dialog", { id: "keys", "aria-labelledby": "keys-title" });
  const close = h("button", { type: "button", id: "keys-close", onclick: () => dialog.close() }, "close");
  const groups = Object.entries(KEYS).map(([name, keys]) => table(name, keys.map((key) => [key.written, key.does])));
  dialog.append(h("header", {}, h("h2", { id: "keys-title" }, "Keys"), close), h("div", { class: "keys" }, ...groups, table("pointer", POINTER)));
  dialog.addEventListener("click", (event) => event.target === dialog && dialog.close());
  const open = (): void => (dialog.open ? dialog.close() : dialog.showModal());
  return h("span", {}, h("button", { type: "button", class: "plain", id: "help", title: "key ?", onclick: open }, "keys"), dialog);
}

function table(name: string, rows: readonly (readonly [string, string])[]): HTMLElement {
  const lines = rows.map(([key, does]) => h("tr", {}, h("th", { scope: "row" }, h("kbd", {}, key)), h("td", {}, does)));
  return h("table", {}, h("caption", {}, name), h("tbody", {}, ...lines));
}
