// The image: tone-mapped or in false colours, with the pixels that paths are chosen by.

import type { Data } from "./data.ts";
import { MAP, luminance, placeOf, short, srgb, tone, type Scale } from "./color.ts";

export class ImageView {
  private readonly canvas = document.createElement("canvas");
  private readonly overlay = document.createElement("canvas");
  private readonly pixels: ImageData;
  private readonly offset: [number, number];
  private readonly size: [number, number];
  private zoom = 1;
  private origin: [number, number] = [0, 0];
  private isFitted = true;
  private drag: { from: [number, number]; to: [number, number]; pan: boolean } | null = null;
  private region: number[] | null = null;
  private dots: { pixels: Uint32Array; color: string } | null = null;
  onRegion: (region: number[] | null) => void = () => {};
  onClick: (pixel: [number, number]) => void = () => {};
  onHover: (text: string) => void = () => {};

  constructor(
    private readonly container: HTMLElement,
    private readonly data: Data,
  ) {
    this.size = data.scene.image.size;
    this.offset = data.scene.image.offset;
    this.canvas.width = this.size[0];
    this.canvas.height = this.size[1];
    this.canvas.className = "picture";
    this.overlay.className = "overlay";
    this.overlay.tabIndex = 0;
    this.overlay.setAttribute("aria-label", "The image: click a pixel, or drag a rectangle, to choose its paths");
    this.pixels = new ImageData(this.size[0], this.size[1]);
    container.prepend(this.canvas, this.overlay);
    this.listen();
    new ResizeObserver(() => this.layout()).observe(container);
    this.layout();
  }

  /** Draws the image with an exposure in stops. */
  showToned(exposure: number): void {
    const { image } = this.data;
    const scale = Math.pow(2, exposure);
    // The transfer function by a table: a power for each value would take most of the time.
    const curve = Uint8ClampedArray.from({ length: 4096 }, (_, i) => Math.round(255 * srgb(i / 4095)));
    const bytes = this.pixels.data;
    for (let i = 0; i < image.length / 3; i++) {
      for (let c = 0; c < 3; c++) bytes[4 * i + c] = curve[Math.round(4095 * tone(scale * image[3 * i + c]))];
      bytes[4 * i + 3] = 255;
    }
    this.canvas.getContext("2d")!.putImageData(this.pixels, 0, 0);
  }

  /** Draws values, one for each pixel, in the colours of a scale. */
  showScaled(values: Float32Array, scale: Scale): void {
    const bytes = this.pixels.data;
    for (let i = 0; i < values.length; i++) {
      const isFinite = Number.isFinite(values[i]);
      const entry = 3 * Math.round(1023 * (isFinite ? placeOf(scale, values[i]) : 0));
      for (let c = 0; c < 3; c++) bytes[4 * i + c] = isFinite ? MAP[entry + c] : [0, 255, 255][c];
      bytes[4 * i + 3] = 255;
    }
    this.canvas.getContext("2d")!.putImageData(this.pixels, 0, 0);
  }

  /** Marks the chosen pixels, and those of some paths. */
  mark(region: number[] | null, dots: Uint32Array | null, color = "255 255 255"): void {
    this.region = region;
    this.dots = dots ? { pixels: dots, color } : null;
    this.drawOverlay();
  }

  private layout(): void {
    const { clientWidth: width, clientHeight: height } = this.container;
    if (width === 0 || height === 0) return;
    this.overlay.width = Math.round(width * devicePixelRatio);
    this.overlay.height = Math.round(height * devicePixelRatio);
    if (this.isFitted) {
      this.zoom = Math.min((width - 24) / this.size[0], (height - 24) / this.size[1]);
      this.origin = [0.5 * (width - this.zoom * this.size[0]), 0.5 * (height - this.zoom * this.size[1])];
    }
    this.place();
  }

  /** Fits the image into its pane again. */
  fit(): void {
    this.isFitted = true;
    this.layout();
  }

  private place(): void {
    const { style } = this.canvas;
    style.width = `${this.zoom * this.size[0]}px`;
    style.height = `${this.zoom * this.size[1]}px`;
    style.transform = `translate(${this.origin[0]}px, ${this.origin[1]}px)`;
    style.imageRendering = this.zoom > 1.6 ? "pixelated" : "auto";
    this.drawOverlay();
  }

  private drawOverlay(): void {
    const context = this.overlay.getContext("2d")!;
    context.setTransform(devicePixelRatio, 0, 0, devicePixelRatio, 0, 0);
    context.clearRect(0, 0, this.overlay.width, this.overlay.height);
    const x = (film: number) => this.origin[0] + this.zoom * (film - this.offset[0]);
    const y = (film: number) => this.origin[1] + this.zoom * (film - this.offset[1]);
    if (this.dots) {
      const size = Math.max(1.5, this.zoom);
      context.fillStyle = `rgb(${this.dots.color} / 0.75)`;
      const { pixels } = this.dots;
      for (let i = 0; i < pixels.length; i += 2) {
        context.fillRect(x(pixels[i]), y(pixels[i + 1]), size, size);
      }
    }
    const frame = this.drag && !this.drag.pan ? this.dragged() : this.region;
    if (frame) {
      const box: [number, number, number, number] = [x(frame[0]), y(frame[1]), this.zoom * frame[2], this.zoom * frame[3]];
      context.fillStyle = "rgb(8 10 14 / 0.42)";
      context.beginPath();
      context.rect(x(this.offset[0]), y(this.offset[1]), this.zoom * this.size[0], this.zoom * this.size[1]);
      context.rect(...box);
      context.fill("evenodd");
      context.strokeStyle = "#ffb020";
      context.lineWidth = 1.5;
      context.strokeRect(box[0] - 0.5, box[1] - 0.5, box[2] + 1, box[3] + 1);
    }
  }

  /** The pixel of the whole film at a place of the window, not cut at the image's rim. */
  private pixel(e: MouseEvent): [number, number] {
    const box = this.overlay.getBoundingClientRect();
    const at = [e.clientX - box.left, e.clientY - box.top];
    return [0, 1].map((i) => Math.floor((at[i] - this.origin[i]) / this.zoom) + this.offset[i]) as [number, number];
  }

  /** The square of pixels around one, cut at the image's rim. */
  around([x, y]: [number, number], reach: number): number[] {
    const [left, width] = this.inside(x - reach, x + reach + 1, 0);
    const [top, height] = this.inside(y - reach, y + reach + 1, 1);
    return [left, top, width, height];
  }

  private inside(low: number, high: number, axis: number): [number, number] {
    const first = Math.max(low, this.offset[axis]);
    return [first, Math.max(0, Math.min(high, this.offset[axis] + this.size[axis]) - first)];
  }

  private dragged(): number[] {
    const { from, to } = this.drag!;
    const axes = [0, 1].map((i) => this.inside(Math.min(from[i], to[i]), Math.max(from[i], to[i]) + 1, i));
    return [axes[0][0], axes[1][0], axes[0][1], axes[1][1]];
  }

  private listen(): void {
    const { overlay } = this;
    overlay.addEventListener("pointerdown", (e) => {
      const at = this.pixel(e);
      this.drag = { from: at, to: at, pan: e.button === 1 || e.button === 2 || e.shiftKey };
      overlay.setPointerCapture(e.pointerId);
    });
    overlay.addEventListener("pointermove", (e) => {
      const at = this.pixel(e);
      this.onHover(this.describe(at));
      if (!this.drag) return;
      if (this.drag.pan) {
        this.isFitted = false;
        this.origin = [this.origin[0] + e.movementX, this.origin[1] + e.movementY];
        this.place();
      } else {
        this.drag.to = at;
        this.drawOverlay();
      }
    });
    overlay.addEventListener("pointerup", (e) => {
      if (!this.drag) return;
      const { from, pan } = this.drag;
      this.drag.to = this.pixel(e);
      const region = this.dragged();
      const isClick = Math.max(Math.abs(this.drag.to[0] - from[0]), Math.abs(this.drag.to[1] - from[1])) * this.zoom < 4;
      this.drag = null;
      if (pan) return;
      if (!isClick) return this.onRegion(region[2] > 0 && region[3] > 0 ? region : null);
      if (region[2] > 0 && region[3] > 0) this.onClick(from);
      else this.onRegion(null);
    });
    overlay.addEventListener("pointerleave", () => this.onHover(""));
    overlay.addEventListener("contextmenu", (e) => e.preventDefault());
    overlay.addEventListener(
      "wheel",
      (e) => {
        e.preventDefault();
        const box = overlay.getBoundingClientRect();
        const factor = Math.exp(-0.0015 * e.deltaY);
        const zoom = Math.min(64, Math.max(0.05, this.zoom * factor));
        const at = [e.clientX - box.left, e.clientY - box.top];
        this.origin = [0, 1].map((i) => at[i] - ((at[i] - this.origin[i]) * zoom) / this.zoom) as [number, number];
        this.zoom = zoom;
        this.isFitted = false;
        this.place();
      },
      { passive: false },
    );
  }

  private describe([x, y]: [number, number]): string {
    const at = [x - this.offset[0], y - this.offset[1]];
    if (at[0] < 0 || at[1] < 0 || at[0] >= this.size[0] || at[1] >= this.size[1]) return "";
    const i = at[1] * this.size[0] + at[0];
    const rgb = [0, 1, 2].map((c) => this.data.image[3 * i + c]);
    const parts = [`pixel ${x}, ${y}`, `radiance ${rgb.map(short).join("  ")} W/(m² sr)`, `luminance ${short(luminance(rgb[0], rgb[1], rgb[2]))}`];
    if (this.data.irradiance) {
      const e = [0, 1, 2].map((c) => this.data.irradiance![3 * i + c]);
      parts.push(`irradiance ${short(luminance(e[0], e[1], e[2]))} W/m²`);
    }
    return parts.join("   ·   ");
  }
}
