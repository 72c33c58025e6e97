// The bar between the scene and the image.

import { byId } from "./dom.ts";

/** Lets the bar between scene and image be moved. */
export function connectSplitter(): void {
  const splitter = byId("splitter");
  const main = splitter.parentElement!;
  let isDragged = false;
  const move = (width: number) => {
    const most = main.clientWidth - byId("tools").clientWidth - 165;
    main.style.setProperty("--split", `${Math.min(most, Math.max(160, width))}px`);
  };
  splitter.addEventListener("pointerdown", (e) => {
    isDragged = true;
    splitter.setPointerCapture(e.pointerId);
  });
  splitter.addEventListener("pointermove", (e) => isDragged && move(e.clientX));
  splitter.addEventListener("pointerup", () => (isDragged = false));
  splitter.addEventListener("dblclick", () => main.style.removeProperty("--split"));
  splitter.addEventListener("keydown", (e) => {
    const by = e.key === "ArrowLeft" ? -24 : e.key === "ArrowRight" ? 24 : 0;
    if (by === 0) return;
    move(byId("space").clientWidth + by);
    e.preventDefault();
    e.stopPropagation();
  });
}
