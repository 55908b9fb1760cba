/** Marks that keep their size on the screen: numbers of gates, crosses, names. */
import { CanvasTexture, LinearFilter, Sprite, SpriteMaterial, SRGBColorSpace } from "three";

const FONT = "600 26px system-ui, sans-serif";
const HEIGHT = 40; // pixels of a texture
const SIZE = 0.034; // of the height of the view

/** A text, above everything. */
export function label(text: string, colour: string, halo: string, offset = 0): Sprite {
  const canvas = document.createElement("canvas");
  const context = pen(canvas);
  context.font = FONT;
  canvas.width = Math.ceil(context.measureText(text).width) + 14;
  canvas.height = HEIGHT;
  context.font = FONT; // a new size forgets it
  context.textBaseline = "middle";
  context.textAlign = "center";
  context.lineJoin = "round";
  context.lineWidth = 6;
  context.strokeStyle = halo;
  context.strokeText(text, canvas.width / 2, HEIGHT / 2 + 1);
  context.fillStyle = colour;
  context.fillText(text, canvas.width / 2, HEIGHT / 2 + 1);
  const made = sprite(canvas, SIZE);
  made.center.set(0.5, 0.5 - offset);
  return made;
}

/** A cross where a flight failed. */
export function cross(colour: string, halo: string): Sprite {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = HEIGHT;
  const context = pen(canvas);
  for (const [style, width] of [[halo, 11], [colour, 6]] as const) {
    context.strokeStyle = style;
    context.lineWidth = width;
    context.lineCap = "round";
    context.beginPath();
    context.moveTo(9, 9);
    context.lineTo(31, 31);
    context.moveTo(31, 9);
    context.lineTo(9, 31);
    context.stroke();
  }
  return sprite(canvas, 0.026);
}

function sprite(canvas: HTMLCanvasElement, size: number): Sprite {
  const map = new CanvasTexture(canvas);
  map.colorSpace = SRGBColorSpace;
  map.minFilter = LinearFilter;
  map.generateMipmaps = false;
  const made = new Sprite(new SpriteMaterial({ map, sizeAttenuation: false, depthTest: false, transparent: true }));
  made.scale.set((size * canvas.width) / canvas.height, size, 1);
  made.renderOrder = 20;
  return made;
}

function pen(canvas: HTMLCanvasElement): CanvasRenderingContext2D {
  const context = canvas.getContext("2d");
  if (!context) throw new Error("no drawing context");
  return context;
}
