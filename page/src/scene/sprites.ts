/** Marks that keep their size on the screen: numbers of gates, crosses, names. */
import { BufferAttribute, BufferGeometry, CanvasTexture, LinearFilter, Points, PointsMaterial, Sprite, SpriteMaterial, SRGBColorSpace } from "three";

const FONT = "600 26px system-ui, sans-serif";
const HEIGHT = 40; // pixels of a texture
const SIZE = 0.034; // of the height of the view
const CROSS = 17; // pixels

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

/** Crosses where flights failed, all drawn at once. */
export function crosses(places: Float32Array, colour: string, halo: string): Points {
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
  const geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(places, 3));
  const style = { size: CROSS, sizeAttenuation: false, depthTest: false, transparent: true };
  const made = new Points(geometry, new PointsMaterial({ map: texture(canvas), ...style }));
  made.renderOrder = 15;
  made.frustumCulled = false;
  return made;
}

function sprite(canvas: HTMLCanvasElement, size: number): Sprite {
  const made = new Sprite(new SpriteMaterial({ map: texture(canvas), sizeAttenuation: false, depthTest: false, transparent: true }));
  made.scale.set((size * canvas.width) / canvas.height, size, 1);
  made.renderOrder = 20;
  return made;
}

function texture(canvas: HTMLCanvasElement): CanvasTexture {
  const map = new CanvasTexture(canvas);
  map.colorSpace = SRGBColorSpace;
  map.minFilter = LinearFilter;
  map.generateMipmaps = false;
  return map;
}

function pen(canvas: HTMLCanvasElement): CanvasRenderingContext2D {
  const context = canvas.getContext("2d");
  if (!context) throw new Error("no drawing context");
  return context;
}
