/** Chooser: which time charts are drawn. */
import { type App, USUAL } from "../app";
import { h, renew } from "../dom";
import { CHOICES } from "./quantities";

export function chooser(app: App): HTMLElement {
  const body = h("div", { class: "signals-list" });
  const element = h("details", { class: "signals", id: "signals" }, h("summary", { title: "key S" }, "signals"), body);
  const build = (): void => {
    const there = CHOICES.filter((choice) => choice.there?.(app.parts.traces.value) !== false);
    const groups = [...new Set(there.map((choice) => choice.group))];
    renew(
      body,
      ...groups.map((group) => h("fieldset", {}, h("legend", {}, group), ...there.filter((choice) => choice.group === group).map((choice) => box(app, choice.id, choice.quantity(app).title)))),
      h("button", { type: "button", id: "signals-usual", onclick: () => (app.signals.value = USUAL) }, "the usual ones"),
    );
  };
  app.parts.traces.watch(build);
  app.signals.after(build);
  return element;
}

function box(app: App, id: string, title: string): HTMLElement {
  const input = h("input", { type: "checkbox", id: `signal-${id}`, checked: app.signals.value.has(id), onchange: () => app.plot(id) });
  return h("label", {}, input, title);
}

/** Opens or closes the list, and puts the focus into it. */
export function toggleChooser(): void {
  const element = document.getElementById("signals") as HTMLDetailsElement | null;
  if (!element) return;
  element.open = !element.open;
  element.scrollIntoView({ block: "nearest" });
  element.querySelector<HTMLElement>(element.open ? "input" : "summary")?.focus();
}
