/** Pointer: on a time chart, pointing moves the clock, dragging chooses a part, with shift it moves it, two fingers or ctrl and the wheel zoom. */
import type { App } from "../app";
import { h } from "../dom";

const DRAG = 6; // px, from which a press is a drag
const WHEEL = 0.0025; // of a zoom, for each pixel of the wheel

interface Press {
  readonly at: number;
  readonly moves: boolean;
  last: number;
}

/**
 * @param over what lies over the plot.
 * @param timeAt time [s] at a place [px] from its left edge.
 */
export function listenToPointer(app: App, over: HTMLElement, timeAt: (pixels: number) => number): void {
  const { clock, zoom } = app;
  const chosen = h("div", { class: "chosen", hidden: true });
  const fingers = new Map<number, number>();
  let press: Press | null = null;
  over.append(chosen);
  const x = (event: MouseEvent): number => event.clientX - over.getBoundingClientRect().left;
  const seek = (event: PointerEvent): void => clock.seek(timeAt(x(event)));
  const end = (): void => {
    fingers.clear();
    press = null;
    chosen.hidden = true;
  };
  over.addEventListener("pointerenter", () => clock.freeze());
  over.addEventListener("pointerdown", (event) => {
    fingers.set(event.pointerId, x(event));
    if (event.pointerType === "mouse" && event.button === 0) {
      press = { at: x(event), moves: event.shiftKey, last: x(event) };
      over.setPointerCapture(event.pointerId);
    } else seek(event);
  });
  over.addEventListener("pointermove", (event) => {
    if (fingers.size === 2 && fingers.has(event.pointerId)) return pinch(app, fingers, event.pointerId, x(event), timeAt);
    if (!press) return seek(event);
    if (press.moves) {
      const [start, finish] = zoom.shown;
      zoom.pan((timeAt(press.last) - timeAt(x(event))) / (finish - start));
      press.last = x(event);
      return;
    }
    const [left, right] = [Math.max(0, Math.min(press.at, x(event))), Math.min(over.clientWidth, Math.max(press.at, x(event)))];
    chosen.hidden = right - left < DRAG;
    chosen.style.left = `${left}px`;
    chosen.style.width = `${right - left}px`;
  });
  over.addEventListener("pointerup", (event) => {
    const began = press;
    const drag = began && !began.moves && Math.abs(x(event) - began.at) >= DRAG;
    if (drag) zoom.show(...([timeAt(began.at), timeAt(x(event))].sort((a, b) => a - b) as [number, number]));
    else if (began && !began.moves) seek(event);
    end();
  });
  over.addEventListener("dblclick", () => zoom.clear());
  over.addEventListener("wheel", (event) => wheel(app, event, timeAt(x(event))), { passive: false });
  for (const name of ["pointerleave", "pointercancel"]) {
    over.addEventListener(name, () => {
      end();
      clock.release();
    });
  }
}

function pinch(app: App, fingers: Map<number, number>, moved: number, to: number, timeAt: (pixels: number) => number): void {
  const [other] = [...fingers].filter(([id]) => id !== moved).map(([, place]) => place);
  const before = Math.abs((fingers.get(moved) ?? to) - other);
  const now = Math.abs(to - other);
  if (before > DRAG && now > DRAG) app.zoom.by(now / before, timeAt(other));
  fingers.set(moved, to);
}

/** The wheel alone moves the page. */
function wheel(app: App, event: WheelEvent, time: number): void {
  const sideways = event.shiftKey ? event.deltaX || event.deltaY : Math.abs(event.deltaX) > 2 * Math.abs(event.deltaY) ? event.deltaX : 0;
  if (event.ctrlKey || event.metaKey) app.zoom.by(Math.exp(-WHEEL * event.deltaY), time);
  else if (sideways && app.zoom.range.value) app.zoom.pan(0.4 * WHEEL * sideways);
  else return;
  event.preventDefault();
}
