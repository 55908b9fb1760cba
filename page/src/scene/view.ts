/** View: a canvas that is drawn when something changed, less finely where that takes long. */
import { Color, Scene, WebGLRenderer } from "three";
import type { PerspectiveCamera } from "three";

const LEAST = 0.6; // pixels drawn for one of the page
const SLOW = 30; // ms a frame
const QUICK = 9;

export class View {
  readonly scene = new Scene();
  readonly renderer: WebGLRenderer;
  private wanted = false;
  private ratio = Math.min(window.devicePixelRatio, 2);
  private mean = 16;
  frames = 0;

  /** @throws Error where there is no WebGL. */
  constructor(
    readonly canvas: HTMLCanvasElement,
    private readonly prepare: () => PerspectiveCamera,
  ) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, powerPreference: "high-performance" });
    this.renderer.setPixelRatio(this.ratio);
  }

  get height(): number {
    return this.canvas.clientHeight || 1;
  }

  paint(background: string): void {
    this.scene.background = new Color(background);
    this.invalidate();
  }

  resize(width: number, height: number): void {
    this.renderer.setSize(width, height, false);
    this.invalidate();
  }

  /** Draws with the next frame of the screen. */
  invalidate(): void {
    if (this.wanted) return;
    this.wanted = true;
    requestAnimationFrame(() => {
      this.wanted = false;
      this.draw();
    });
  }

  /** A picture of what is seen, for print. */
  still(): string {
    this.draw();
    return this.canvas.toDataURL("image/png");
  }

  private draw(): void {
    const start = performance.now();
    this.renderer.render(this.scene, this.prepare());
    this.frames++;
    this.adapt(performance.now() - start);
  }

  private adapt(spent: number): void {
    this.mean += 0.1 * (spent - this.mean);
    if (this.frames % 20) return;
    const most = Math.min(window.devicePixelRatio, 2);
    const factor = this.mean > SLOW ? 0.8 : this.mean < QUICK ? 1.25 : 1;
    const ratio = Math.min(Math.max(this.ratio * factor, LEAST), most);
    if (ratio === this.ratio) return;
    this.ratio = ratio;
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(this.canvas.clientWidth, this.canvas.clientHeight, false);
  }
}
