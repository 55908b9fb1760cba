/** Configuration: command, seed, versions and settings that repeat the study. */
import type { App } from "../app";
import type { Configuration } from "../data";
import { card, h, renew } from "../dom";

export function configuration(app: App): HTMLElement {
  const body = h("div", {});
  app.parts.configuration.watch((known) => renew(body, ...(known ? rows(known, app.parts.headline.value.seed) : ["Unknown."])));
  return card("configuration", "Repeat this study", "", body);
}

function rows(known: Configuration, seed: number): HTMLElement[] {
  const opened = known.opened.length > 1 ? `${known.opened[0]}, continued ${known.opened.slice(1).join(", ")}` : (known.opened[0] ?? "");
  const facts: readonly (readonly [string, string])[] = [
    ["configuration", known.fingerprint],
    ["seed", String(seed)],
    ["world", known.world],
    ["versions", Object.entries(known.versions).map(([name, version]) => `${name} ${version}`).join(", ")],
    ["flown", opened],
    ...Object.entries(known.files).map(([name, path]) => [name, path] as const),
  ];
  return [
    h("div", { class: "command" }, h("code", { id: "command" }, known.command), copy(known.command)),
    h("dl", { class: "pairs-of-facts" }, ...facts.filter(([, value]) => value).flatMap(([name, value]) => [h("dt", {}, name), h("dd", {}, value)])),
    h("details", {}, h("summary", {}, "all settings"), settings(known.settings)),
    h("details", {}, h("summary", {}, "the race"), h("pre", {}, known.race_toml)),
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
