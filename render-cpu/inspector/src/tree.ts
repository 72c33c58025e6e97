// The tree of clusters, and the list of the heaviest paths.

import type { Cluster } from "./clusters.ts";
import { clusterColor, css, luminance, short } from "./color.ts";
import { KIND_NAMES, objectName, type Data } from "./data.ts";
import { el } from "./dom.ts";
import type { Selection } from "./selection.ts";
import type { State } from "./state.ts";

/** Most clusters below one that are listed. */
const MOST_CHILDREN = 60;
/** Most paths that are listed. */
export const MOST_PATHS = 40;

/** A word with the sides of scattering as superscripts. */
function word(labels: string[], isExpression: boolean): Node[] {
  if (!isExpression) return [document.createTextNode(labels.join(" → "))];
  return labels.flatMap((label) => {
    const [kind, side] = label.split("^");
    return side ? [document.createTextNode(kind), el("sup", {}, side), document.createTextNode(" ")] : [document.createTextNode(`${kind} `)];
  });
}

function percent(share: number): string {
  return share >= 0.0995 ? `${(100 * share).toFixed(0)} %` : `${(100 * share).toFixed(share >= 0.00095 ? 1 : 2)} %`;
}

export class ClusterView {
  /** What someone has opened or closed; of the others those are open that hold much of the light. */
  private readonly turned = new Map<string, boolean>();
  private rows: { element: HTMLElement; line: string[]; cluster: Cluster }[] = [];
  private at = 0;
  onSelect: (line: string[]) => void = () => {};
  onHover: (cluster: Cluster | null) => void = () => {};

  constructor(private readonly container: HTMLElement) {
    container.addEventListener("keydown", (e) => this.key(e));
    container.addEventListener("pointerleave", () => this.onHover(null));
  }

  show(selection: Selection, state: State): void {
    this.rows = [];
    // What is selected is visible.
    state.cluster.forEach((_, i) => this.turned.set(state.cluster.slice(0, i).join("/"), true));
    const total = selection.tree.root.weight;
    const chosen = state.cluster.slice(0, selection.line.length - 1).join("/");
    const add = (cluster: Cluster, line: string[], depth: number, color: string | null, isUnder: boolean) => {
      const key = line.join("/");
      const isChosen = key === chosen;
      const hasChildren = cluster.children.length > 0;
      const share = total > 0 ? cluster.weight / total : 0;
      const isOpen = hasChildren && (this.turned.get(key) ?? (depth === 0 || (depth < 4 && share > 0.1)));
      const turn = el("button", { class: "turn", type: "button", tabIndex: -1, "aria-label": isOpen ? "Close" : "Open" }, hasChildren ? (isOpen ? "▼" : "▶") : "");
      const name = line.length === 0 ? (cluster.labels.length > 0 ? word(cluster.labels, state.by === "expression") : [document.createTextNode("all")]) : word(cluster.labels, state.by === "expression");
      const ownColor = isChosen && !hasChildren ? css(clusterColor(0)) : color;
      const element = el(
        "div",
        {
          class: "cluster",
          role: "treeitem",
          "aria-selected": String(isChosen),
          "aria-level": String(depth + 1),
          ...(hasChildren ? { "aria-expanded": String(isOpen) } : {}),
          style: `padding-left: ${8 + 13 * depth}px`,
          title: `${cluster.labels.join(" ")}: ${cluster.end - cluster.begin} paths, weight ${short(cluster.weight)}`,
        },
        turn,
        el("span", { class: "swatch", style: `background: ${ownColor ?? "transparent"}` }),
        el("span", { class: "word" }, ...name),
        el("span", { class: "share" }, percent(share)),
        el("span", { class: "track" }, el("i", { style: `width: ${Math.max(0.6, 100 * share)}%; background: ${ownColor ?? "#5a6372"}` })),
      );
      const toggle = () => {
        this.turned.set(key, !isOpen);
        this.show(selection, state);
      };
      turn.addEventListener("click", (e) => {
        e.stopPropagation();
        if (hasChildren) toggle();
      });
      element.addEventListener("click", () => this.onSelect(line));
      element.addEventListener("dblclick", () => hasChildren && toggle());
      element.addEventListener("pointerenter", () => this.onHover(cluster));
      this.rows.push({ element, line, cluster });
      if (!isOpen) return;
      cluster.children.slice(0, MOST_CHILDREN).forEach((child, i) => {
        const next = isChosen ? css(clusterColor(i)) : isUnder ? color : null;
        add(child, [...line, child.labels.join(" ")], depth + 1, next, isUnder || isChosen);
      });
    };
    add(selection.tree.root, [], 0, null, false);
    this.at = Math.max(0, this.rows.findIndex((r) => r.line.join("/") === chosen));
    this.container.replaceChildren(...this.rows.map((r) => r.element));
  }

  private key(e: KeyboardEvent): void {
    const row = this.rows[this.at];
    if (!row) return;
    const turn = row.element.querySelector<HTMLElement>(".turn")!;
    const isOpen = row.element.getAttribute("aria-expanded") === "true";
    const select = (i: number) => {
      const next = this.rows[Math.min(this.rows.length - 1, Math.max(0, i))];
      this.onSelect(next.line);
      this.rows[this.at]?.element.scrollIntoView({ block: "nearest" });
    };
    switch (e.key) {
      case "ArrowDown":
        select(this.at + 1);
        break;
      case "ArrowUp":
        select(this.at - 1);
        break;
      case "ArrowRight":
        if (row.cluster.children.length > 0 && !isOpen) turn.click();
        else select(this.at + 1);
        break;
      case "ArrowLeft":
        if (isOpen && row.line.length > 0) turn.click();
        else if (row.line.length > 0) this.onSelect(row.line.slice(0, -1));
        break;
      default:
        return;
    }
    e.preventDefault();
    e.stopPropagation();
  }
}

export class PathView {
  private listed: number[] = [];
  chosen: number | null = null;
  onChoose: (path: number | null) => void = () => {};
  onHover: (path: number | null) => void = () => {};

  constructor(
    private readonly list: HTMLElement,
    private readonly details: HTMLElement,
    private readonly data: Data,
  ) {
    list.addEventListener("pointerleave", () => this.onHover(null));
    list.addEventListener("keydown", (e) => {
      if (e.key !== "ArrowDown" && e.key !== "ArrowUp") return;
      this.step(e.key === "ArrowDown" ? 1 : -1);
      e.preventDefault();
      e.stopPropagation();
    });
  }

  show(selection: Selection): void {
    const { paths } = this.data;
    this.listed = selection.heaviest(MOST_PATHS);
    if (this.chosen !== null && !this.listed.includes(this.chosen)) this.choose(null);
    const total = selection.weight(selection.selected);
    this.list.replaceChildren(
      ...this.listed.map((p) => {
        const labels = Array.from(paths.kinds.subarray(paths.starts[p], paths.starts[p + 1]), (k) => KIND_NAMES[k]).reverse();
        const row = el(
          "div",
          { class: "path", role: "option", "aria-selected": String(p === this.chosen), "data-path": String(p) },
          el("span", { class: "swatch", style: `background: ${css(this.lightColor(p))}` }),
          el("span", { class: "word" }, ...word(labels, true)),
          el("span", { class: "at" }, `${paths.pixels[2 * p]}, ${paths.pixels[2 * p + 1]}`),
          el("span", { class: "share" }, percent(paths.weights[p] / total)),
        );
        row.addEventListener("click", () => this.choose(this.chosen === p ? null : p));
        row.addEventListener("pointerenter", () => this.onHover(p));
        return row;
      }),
    );
    this.describe();
  }

  choose(path: number | null): void {
    this.chosen = path;
    for (const row of this.list.children) {
      const isOwn = (row as HTMLElement).dataset.path === String(path);
      row.setAttribute("aria-selected", String(isOwn));
      if (isOwn) row.scrollIntoView({ block: "nearest" });
    }
    this.describe();
    this.onChoose(path);
  }

  /** The next path of the list. */
  step(by: number): void {
    if (this.listed.length === 0) return;
    const at = this.chosen === null ? -1 : this.listed.indexOf(this.chosen);
    const next = at < 0 ? (by > 0 ? 0 : this.listed.length - 1) : (at + by + this.listed.length) % this.listed.length;
    this.choose(this.listed[next]);
  }

  /** The colour of a path's light, as bright as can be. */
  private lightColor(p: number): number[] {
    const rgb = [0, 1, 2].map((c) => Math.max(0, this.data.paths.light[3 * p + c]));
    const most = Math.max(...rgb, 1e-30);
    return rgb.map((v) => Math.round(255 * Math.pow(v / most, 1 / 2.2)));
  }

  private describe(): void {
    const p = this.chosen;
    if (p === null) {
      this.details.replaceChildren();
      return;
    }
    const { paths, scene } = this.data;
    const rows: Node[] = [];
    for (let v = paths.starts[p + 1] - 1; v >= paths.starts[p]; v--) {
      const [kind, object] = [paths.kinds[v], paths.objects[v]];
      const at = [0, 1, 2].map((a) => short(paths.positions[3 * v + a])).join(" ");
      const rgb = [0, 1, 2].map((c) => paths.throughputs[3 * v + c]);
      const material = kind < 6 ? (scene.shapes[object]?.material ?? "") : "";
      const name = objectName(scene, kind, object);
      rows.push(
        el(
          "tr",
          {},
          el("td", {}, ...word([KIND_NAMES[kind]], true)),
          el("td", { title: `${name} ${material}` }, name, " ", el("small", {}, name.includes(material) ? "" : material)),
          el("td", { class: "n", title: at }, at),
          el("td", { class: "n", title: `RGB ${rgb.map(short).join(" ")}` }, short(luminance(rgb[0], rgb[1], rgb[2]))),
        ),
      );
    }
    const head = el("tr", {}, ...["", "object", "position", "carries"].map((t) => el("th", {}, t)));
    this.details.replaceChildren(el("table", {}, el("thead", {}, head), el("tbody", {}, ...rows)));
  }
}
