// The overlay with the keys and the notation.

import { el } from "./dom.ts";

const KEYS: [string[], string][] = [
  [["1", "2", "3", "4"], "paths, false colour, spherical plot, volume"],
  [["E", "/"], "write an expression"],
  [["Esc"], "back: the path, the cluster, the pixels, the expression"],
  [["J", "K"], "next and previous of the heaviest paths"],
  [["B"], "clusters by expression or by object"],
  [["N"], "clusters from the light or from the sensor"],
  [["[", "]"], "fewer, more bundles"],
  [["A"], "arrows"],
  [["L"], "lines"],
  [["D"], "pixels of the paths in the image"],
  [["X"], "surfaces: solid, x-ray, hidden"],
  [["C"], "look through the sensor"],
  [["F"], "show the whole scene"],
  [["←", "→", "↑", "↓"], "turn the scene; in lists, choose"],
  [["I"], "fit the image"],
  [["G"], "logarithmic scale"],
  [["Q"], "radiance or irradiance"],
  [["+", "−"], "exposure"],
  [["Y"], "copy the address of what is shown"],
  [["?"], "this"],
];

const NOTATION: [string, string][] = [
  ["L … E", "a path from the light to the sensor"],
  ["D G S X", "diffuse, glossy, specular, any scattering"],
  ["D^R S^T", "reflected, transmitted"],
  ["O B", "light of an object, from infinity"],
  [". [DG] [^S]", "any vertex, one of several, none of them"],
  ["* + ? {2,}", "repeat what stands before"],
  ["A|B (…)", "alternatives, groups"],
  ["X[ring]", "by name: object, material or emitter, * and ?"],
  ["X{door}", "in the box or ball of a shape"],
  ["C<RD>.*L", "from the camera, as in OSL"],
];

const MOUSE: [string, string][] = [
  ["click the image", "paths of that pixel and its neighbours"],
  ["drag in the image", "paths of a rectangle of pixels"],
  ["shift-drag, wheel", "move and enlarge the image"],
  ["drag in the scene", "turn; right button moves, wheel approaches"],
  ["click a surface", "paths that pass there; the probe of a plot"],
];

function list(rows: [string, string][]): HTMLElement {
  return el("dl", {}, ...rows.flatMap(([term, text]) => [el("dt", {}, el("code", {}, term)), el("dd", {}, text)]));
}

/** Fills the overlay. */
export function fillHelp(dialog: HTMLDialogElement): void {
  const keys = KEYS.flatMap(([names, text]) => [
    el("dt", {}, ...names.flatMap((name, i) => [i > 0 ? " " : "", el("kbd", {}, name)])),
    el("dd", {}, text),
  ]);
  const close = el("button", { type: "button", onclick: () => dialog.close() }, "Close");
  dialog.replaceChildren(
    el("h1", {}, "Keys"),
    el(
      "div",
      { class: "columns" },
      el("dl", {}, ...keys),
      el("div", {}, el("h2", {}, "Mouse"), list(MOUSE), el("h2", {}, "Expressions"), list(NOTATION)),
    ),
    close,
  );
  dialog.addEventListener("click", (e) => {
    if (e.target === dialog) dialog.close();
  });
}
