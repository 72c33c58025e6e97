// The controls of each tool.

import { short } from "./color.ts";
import { check, choice, el, numberField, row, slider } from "./dom.ts";
import type { Inspector } from "./inspector.ts";
import type { Tool } from "./state.ts";
import { MOST_LINES } from "./view3d.ts";

export const TOOL_NAMES: Record<Tool, string> = {
  paths: "Paths",
  color: "False colour",
  plot: "Spherical plot",
  volume: "Volume",
};

/** The controls of the tool that is chosen. */
export function panelOf(inspector: Inspector): Node[] {
  switch (inspector.state.tool) {
    case "paths":
      return paths(inspector);
    case "color":
      return color(inspector);
    case "plot":
      return plot(inspector);
    case "volume":
      return volume(inspector);
  }
}

function paths(inspector: Inspector): Node[] {
  const { state } = inspector;
  const set = inspector.set.bind(inspector);
  const { region, ball } = state;
  const where: (Node | string)[] = [];
  if (region) {
    const text = `${region[2]} × ${region[3]} at ${region[0]}, ${region[1]}`;
    where.push(el("button", { type: "button", title: "All pixels again", onclick: () => set({ region: null }) }, `${text}  ✕`));
  }
  if (ball) {
    const text = `near ${ball.map(short).join(", ")}`;
    where.push(el("button", { type: "button", title: "Everywhere again", onclick: () => set({ ball: null }) }, `${text}  ✕`));
  }
  return [
    row("Show", check("arrows", state.arrows, (arrows) => set({ arrows })), check("lines", state.lines, (lines) => set({ lines })), check("pixels", state.dots, (dots) => set({ dots }))),
    ...(state.lines && inspector.selection.selected.length > MOST_LINES ? [el("p", {}, `Lines of ${MOST_LINES} of these paths.`)] : []),
    row("Bundles", slider("Bundles", [1, 120, 1], state.bundles, String, (bundles) => set({ bundles }))),
    row("From", ...(where.length > 0 ? where : [el("span", { class: "name" }, "all pixels: click or drag in the image")])),
    ...(ball ? [row("Radius", slider("Radius", [-3, -0.3, 0.02], Math.log10(state.reach), (v) => short(inspector.selection.unit * 10 ** v), (v) => set({ reach: 10 ** v })))] : []),
  ];
}

function scaleRows(inspector: Inspector, unit: string): Node[] {
  const { state, scale } = inspector;
  const set = inspector.set.bind(inspector);
  return [
    row("Scale", choice("Scale", [["linear", "linear"], ["log", "log"]], inspector.isLog ? "log" : "linear", (v) => set({ log: v === "log" }))),
    row(
      "Range",
      numberField("Value of the first colour", state.least, scale ? short(scale.least) : "", (least) => set({ least })),
      "to",
      numberField("Value of the last colour", state.most, scale ? short(scale.most) : "", (most) => set({ most })),
    ),
    ...(unit ? [el("p", {}, unit)] : []),
  ];
}

function color(inspector: Inspector): Node[] {
  const { state, data } = inspector;
  return [
    row(
      "Quantity",
      data.irradiance
        ? choice("Quantity", [["radiance", "radiance"], ["irradiance", "irradiance"]], state.quantity, (quantity) => inspector.set({ quantity }))
        : "radiance",
    ),
    ...scaleRows(inspector, "Empty fields follow the image: the last colour is exceeded by a thousandth of the pixels."),
  ];
}

function plot(inspector: Inspector): Node[] {
  const { state, data } = inspector;
  const set = inspector.set.bind(inspector);
  const measured = data.scene.plots;
  const where = state.probe ? state.probe.slice(0, 3) : null;
  return [
    ...(measured.length > 0
      ? [row("Source", choice("Source", [["paths", "chosen paths"], ["measured", "measured"]], state.measured === null ? "paths" : "measured", (v) => set({ measured: v === "measured" ? 0 : null })))]
      : []),
    ...(state.measured !== null
      ? [el("p", {}, `Radiance at ${measured[state.measured]?.position.map(short).join(", ")}, path traced; integral ${short(measured[state.measured]?.integral as unknown as number)}.`)]
      : [
          row("Probe", point(inspector, where, (p) => set({ probe: p }))),
          row("Radius", slider("Radius", [-3, -0.3, 0.02], Math.log10(state.reach), (v) => short(inspector.selection.unit * 10 ** v), (v) => set({ reach: 10 ** v }))),
          el("p", {}, "Click a surface to place the probe. It shows the light that the chosen paths carry through the ball, by the direction from which it comes."),
        ]),
    ...scaleRows(inspector, ""),
  ];
}

function point(inspector: Inspector, where: number[] | null, set: (point: number[]) => void): HTMLElement {
  const begin = where ?? inspector.data.scene.center;
  const fields = begin.map((value, axis) =>
    numberField(`${"xyz"[axis]} of the point`, where ? +value.toPrecision(5) : null, "xyz"[axis], (v) => {
      if (v === null) return;
      const next = begin.slice();
      next[axis] = v;
      set(next);
    }),
  );
  fields.forEach((f) => (f.style.width = "7ch"));
  return el("span", { class: "control" }, ...fields);
}

function volume(inspector: Inspector): Node[] {
  const { state, data } = inspector;
  const set = inspector.set.bind(inspector);
  const box = inspector.box;
  const measured = data.scene.volume;
  const source = measured
    ? [row("Source", choice("Source", [["paths", "chosen paths"], ["measured", "measured"]], state.medium ? "measured" : "paths", (v) => set({ medium: v === "measured" })))]
    : [];
  const density = row("Density", slider("Density", [-1.5, 1.5, 0.05], Math.log10(state.density), (v) => (10 ** v).toFixed(2), (v) => set({ density: 10 ** v })));
  if (measured && state.medium)
    return [
      ...source,
      density,
      el("p", {}, `Fluence rate in ${measured.voxels.join(" × ")} voxels, by ${measured.walks} light walks; its mean is ${short(measured.mean)} W/m².`),
      ...scaleRows(inspector, "A box of thin mist: every voxel shows the light that passes through it, whether it comes to the image or not."),
    ];
  return [
    ...source,
    row("Centre", point(inspector, box.slice(0, 3), (p) => set({ box: [...p, ...box.slice(3)] }))),
    row("Size", point(inspector, box.slice(3), (p) => set({ box: [...box.slice(0, 3), ...p.map((v) => Math.max(1e-6, v))] }))),
    row(
      "Box",
      el("button", { type: "button", onclick: () => set({ box: null }) }, "what is seen"),
      el("button", { type: "button", onclick: () => set({ box: inspector.boxAroundProbe() }), disabled: !state.probe && !state.ball }, "around the probe"),
    ),
    row("Voxels", slider("Voxels", [8, 96, 4], state.voxels, String, (voxels) => set({ voxels }))),
    density,
    ...scaleRows(inspector, "A box of thin mist: every voxel shows the light that the chosen paths carry through it."),
  ];
}
