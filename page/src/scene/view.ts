/** View: a canvas that is drawn only after a change; in a lower resolution while it moves on slow machines, in full when it rests. */
import { Color, type PerspectiveCamera, Scene, WebGLRenderer } from "three";
import { RESOLUTION } from "./lines";

const LEAST = 0.75; // pixels drawn for one of the page
const SLOW = 31; // ms from frame to frame
const QUICK = 19;
const PAUSE = 120; // ms, longer than from frame to frame
const REST = 300; // ms without a change
const WAIT = 6000; // ms after a step down, before a step up is tried

export class View {
  readonly scene = new Scene();
  readonly renderer: WebGLRenderer;
  private readonly software: boolean;
  private readonly most = Math.min(window.devicePixelRatio, 2);
  private moving = this.most;
  private used = 0;
  private wanted = false;
  private rest = 0;
  private last = 0;
  private mean = 16;
  private lowered = -Infinity;
  frames = 0;

  /** @throws Error where there is no WebGL. */
  constructor(
    readonly canvas: HTMLCanvasElement,
    private readonly prepare: () => PerspectiveCamera,
  ) {
    this.software = withoutCard();
    this.renderer = new WebGLRenderer({ canvas, antialias: !this.software, powerPreference: "high-performance" });
  }

  get height(): number {
    return this.canvas.clientHeight || 1;
  }

  paint(background: string): void {
    this.scene.background = new Color(background);
    this.invalidate();
  }

  resize(): void {
    this.used = 0;
    this.invalidate();
  }

  /** Draws with the next frame of the screen. */
  invalidate(): void {
    if (this.wanted) return;
    this.wanted = true;
    requestAnimationFrame((now) => {
      this.wanted = false;
      this.adapt(now);
      this.draw(this.moving);
      window.clearTimeout(this.rest);
      this.rest = window.setTimeout(() => this.refine(), REST + 6 * this.mean);
    });
  }

  /** An image of the present view, for print. */
  still(): string {
    this.draw(2);
    return this.canvas.toDataURL("image/png");
  }

  private draw(ratio: number): void {
    if (this.canvas.clientWidth < 2 || this.canvas.clientHeight < 2) return;
    if (ratio !== this.used) {
      this.used = ratio;
      this.renderer.setPixelRatio(ratio);
      this.renderer.setSize(this.canvas.clientWidth, this.canvas.clientHeight, false);
      this.renderer.getDrawingBufferSize(RESOLUTION);
      RESOLUTION.divideScalar(ratio); // widths are those of the page
    }
    this.renderer.render(this.scene, this.prepare());
    this.frames++;
  }

  /** Finer than the screen where edges are not smoothed otherwise. */
  private refine(): void {
    const fine = this.software ? Math.max(2, this.most) : this.most;
    if (fine !== this.used && !this.wanted) this.draw(fine);
  }

  private adapt(now: number): void {
    const spent = now - this.last;
    this.last = now;
    if (spent > PAUSE && this.frames % 2) return; // it stood still, or it is very slow
    this.mean += 0.12 * (Math.min(spent, PAUSE) - this.mean);
    if (this.frames % 16) return;
    if (this.mean > SLOW) {
      this.moving = Math.max(0.75 * this.moving, LEAST);
      this.lowered = now;
    } else if (this.mean < QUICK && now - this.lowered > WAIT) this.moving = Math.min(1.34 * this.moving, this.most);
  }
}

/** Whether there is no graphics card: smoothing edges by the processor is slow. */
function withoutCard(): boolean {
  const context = document.createElement("canvas").getContext("webgl2");
  if (!context) return false;
  const known = context.getExtension("WEBGL_debug_renderer_info");
  const name = String(context.getParameter(known ? known.UNMASKED_RENDERER_WEBGL : context.RENDERER));
  context.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}
