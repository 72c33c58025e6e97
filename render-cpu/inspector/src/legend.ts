// The bar of colours with its values.

import { MAP, short, valueAt, type Scale } from "./color.ts";
import { byId, el } from "./dom.ts";

/** Shows a scale in an element, or hides it. */
export function showLegend(id: string, scale: Scale | null, what: string): void {
  const box = byId(id);
  box.hidden = scale === null;
  if (!scale) return;
  const bar = el("canvas", { width: 256, height: 1 });
  const context = bar.getContext("2d")!;
  const row = context.createImageData(256, 1);
  for (let i = 0; i < 256; i++) {
    const entry = 3 * Math.round((1023 * i) / 255);
    row.data.set([MAP[entry], MAP[entry + 1], MAP[entry + 2], 255], 4 * i);
  }
  context.putImageData(row, 0, 0);
  const ticks = [0, 0.25, 0.5, 0.75, 1].map((place) => el("span", { style: `left: ${100 * place}%` }, short(valueAt(scale, place))));
  box.replaceChildren(el("div", { class: "what" }, what + (scale.isLog ? ", logarithmic" : "")), bar, el("div", { class: "ticks" }, ...ticks));
}
