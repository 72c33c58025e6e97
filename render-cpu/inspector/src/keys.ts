// The keyboard.

import { byId } from "./dom.ts";
import type { Inspector } from "./inspector.ts";

/** Does what a key stands for. */
export function onKey(inspector: Inspector, e: KeyboardEvent): void {
  const target = e.target as HTMLElement;
  const isText = target instanceof HTMLInputElement && target.type === "text";
  const help = byId<HTMLDialogElement>("help");
  if (isText || e.ctrlKey || e.metaKey || e.altKey) return;
  if (help.open) {
    if (e.key === "?") help.close();
    return;
  }
  const { state } = inspector;
  const isSlider = target instanceof HTMLInputElement && target.type === "range";
  const arrows: Record<string, [number, number]> = {
    ArrowLeft: [-0.12, 0],
    ArrowRight: [0.12, 0],
    ArrowUp: [0, -0.12],
    ArrowDown: [0, 0.12],
  };
  if (e.key in arrows) {
    if (isSlider) return;
    inspector.space.orbit(...arrows[e.key]);
    e.preventDefault();
    return;
  }
  const actions: Record<string, () => void> = {
    "1": () => inspector.set({ tool: "paths" }),
    "2": () => inspector.set({ tool: "color" }),
    "3": () => inspector.set({ tool: "plot" }),
    "4": () => inspector.set({ tool: "volume" }),
    e: () => byId("expression").focus(),
    "/": () => byId("expression").focus(),
    Escape: () => inspector.back(),
    j: () => inspector.paths.step(1),
    k: () => inspector.paths.step(-1),
    b: () => inspector.set({ by: state.by === "expression" ? "object" : "expression" }),
    n: () => inspector.set({ from: state.from === "light" ? "sensor" : "light" }),
    "[": () => inspector.set({ bundles: Math.max(1, Math.round(state.bundles / 1.5)) }),
    "]": () => inspector.set({ bundles: Math.min(120, Math.round(state.bundles * 1.5)) }),
    a: () => inspector.set({ arrows: !state.arrows }),
    l: () => inspector.set({ lines: !state.lines }),
    d: () => inspector.set({ dots: !state.dots }),
    x: () => inspector.set({ look: state.look === "solid" ? "x-ray" : state.look === "x-ray" ? "hidden" : "solid" }),
    c: () => inspector.viewSensor(),
    f: () => inspector.space.frame(),
    i: () => inspector.image.fit(),
    g: () => inspector.set({ log: !inspector.isLog }),
    q: () => inspector.set({ quantity: state.quantity === "radiance" ? "irradiance" : "radiance" }),
    "+": () => inspector.set({ exposure: state.exposure + 0.5 }),
    "=": () => inspector.set({ exposure: state.exposure + 0.5 }),
    "-": () => inspector.set({ exposure: state.exposure - 0.5 }),
    y: () => void inspector.copyLink(),
    "?": () => help.showModal(),
  };
  const action = actions[e.key.length === 1 ? e.key.toLowerCase() : e.key];
  if (!action) return;
  e.preventDefault();
  action();
}
