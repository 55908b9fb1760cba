/** Clipboard: copies text; pages opened from a file may have no clipboard of their own. */
import { h } from "./dom";

const AWHILE = 1500; // ms

/** A button that copies a text, and says so. */
export function copyButton(id: string, name: string, text: () => string, title = ""): HTMLButtonElement {
  const button = h("button", { type: "button", id, title: title || null, "aria-live": "polite" }, name);
  const say = (word: string): void => {
    button.textContent = word;
    setTimeout(() => (button.textContent = name), AWHILE);
  };
  button.addEventListener("click", () => void copy(text()).then((done) => say(done ? "copied" : "not copied")));
  return button;
}

/** Whether it could be copied. */
async function copy(text: string): Promise<boolean> {
  try {
    if (navigator.clipboard) {
      await navigator.clipboard.writeText(text);
      return true;
    }
  } catch {
    // not allowed: the way of before
  }
  const area = h("textarea", { "aria-hidden": "true" });
  area.value = text;
  document.body.append(area);
  area.select();
  const done = document.execCommand("copy");
  area.remove();
  return done;
}
