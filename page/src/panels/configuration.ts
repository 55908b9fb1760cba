/** Configuration: what it takes to fly the study again. */
import type { App } from "../app";
import type { Configuration } from "../data";
import { card, h, renew } from "../dom";

export function configuration(app: App): HTMLElement {
  const body = h("div", {});
  app.parts.configuration.watch((told) => renew(body, ...(told ? describe(told, app.parts.headline.value.seed) : ["Unknown."])));
  return card("configuration", "Run it again", "", body);
}

function describe(told: Configuration, seed: number): HTMLElement[] {
  const opened = told.opened.length > 1 ? `${told.opened[0]}, continued ${told.opened.slice(1).join(", ")}` : (told.opened[0] ?? "");
  const facts: readonly (readonly [string, string])[] = [
    ["configuration", told.fingerprint],
    ["seed", String(seed)],
    ["world", told.world],
    ["versions", Object.entries(told.versions).map(([name, version]) => `${name} ${version}`).join(", ")],
    ["flown", opened],
    ...Object.entries(told.files).map(([name, path]) => [name, path] as const),
  ];
  return [
    h("div", { class: "command" }, h("code", { id: "command" }, told.command), copy(told.command)),
    h("dl", { class: "pairs-of-facts" }, ...facts.filter(([, value]) => value).flatMap(([name, value]) => [h("dt", {}, name), h("dd", {}, value)])),
    h("details", {}, h("summary", {}, "all settings"), settings(told.settings)),
    h("details", {}, h("summary", {}, "the race"), h("pre", {}, told.race_toml)),
  ];
}

function settings(values: Readonly<Record<string, unknown>>): HTMLElement {
  const rows = Object.entries(values).map(([key, value]) => h("tr", {}, h("th", { scope: "row" }, key), h("td", {}, typeof value === "string" ? value : JSON.stringify(value))));
  return h("div", { class: "wide" }, h("table", { class: "settings" }, h("tbody", {}, ...rows)));
}

function copy(text: string): HTMLElement {
  const button = h("button", { type: "button", id: "copy", "aria-live": "polite" }, "copy");
  const say = (word: string): void => {
    button.textContent = word;
    setTimeout(() => (button.textContent = "copy"), 1500);
  };
  button.addEventListener("click", () => {
    copyText(text).then(
      () => say("copied"),
      () => say("select and copy"),
    );
  });
  return button;
}

async function copyText(text: string): Promise<void> {
  if (navigator.clipboard) return navigator.clipboard.writeText(text);
  const range = document.createRange(); // pages opened from a file may have no clipboard
  range.selectNodeContents(document.getElementById("command") ?? document.body);
  getSelection()?.removeAllRanges();
  getSelection()?.addRange(range);
  if (!document.execCommand("copy")) throw new Error("not copied");
}
