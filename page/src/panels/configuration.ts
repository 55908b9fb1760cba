/** Configuration: command, seed, versions and settings that repeat the study. */
import type { App } from "../app";
import type { Configuration } from "../data";
import { copyButton } from "../clipboard";
import { card, h, renew } from "../dom";
import { saveFlights, saveParameters } from "../download";

export function configuration(app: App): HTMLElement {
  const body = h("div", {});
  app.parts.configuration.watch((known) => renew(body, ...(known ? rows(app, known) : ["Unknown."])));
  return card("configuration", "Repeat this study", "", body);
}

function rows(app: App, known: Configuration): HTMLElement[] {
  const opened = known.opened.length > 1 ? `${known.opened[0]}, continued ${known.opened.slice(1).join(", ")}` : (known.opened[0] ?? "");
  const facts: readonly (readonly [string, string])[] = [
    ["configuration", known.fingerprint],
    ["seed", String(app.parts.headline.value.seed)],
    ["world", known.world],
    ["versions", Object.entries(known.versions).map(([name, version]) => `${name} ${version}`).join(", ")],
    ["flown", opened],
    ...Object.entries(known.files).map(([name, path]) => [name, path] as const),
  ];
  return [
    h("div", { class: "command" }, h("code", { id: "command" }, known.command), copyButton("copy", "copy", () => known.command)),
    h("div", { class: "command" }, save("save-flights", "shown flights (CSV)", "X", () => saveFlights(app)), known.parameters_toml ? save("save-parameters", "parameters (TOML)", "P", () => saveParameters(app)) : null),
    h("dl", { class: "pairs-of-facts" }, ...facts.filter(([, value]) => value).flatMap(([name, value]) => [h("dt", {}, name), h("dd", {}, value)])),
    h("details", {}, h("summary", {}, "all settings"), settings(known.settings)),
    h("details", {}, h("summary", {}, "the race"), h("pre", {}, known.race_toml)),
  ];
}

function settings(values: Readonly<Record<string, unknown>>): HTMLElement {
  const rows = Object.entries(values).map(([key, value]) => h("tr", {}, h("th", { scope: "row" }, key), h("td", {}, typeof value === "string" ? value : JSON.stringify(value))));
  return h("div", { class: "wide" }, h("table", { class: "settings" }, h("tbody", {}, ...rows)));
}

function save(id: string, what: string, key: string, act: () => void): HTMLElement {
  return h("button", { type: "button", id, title: `key ${key}`, onclick: act }, `download ${what}`);
}
