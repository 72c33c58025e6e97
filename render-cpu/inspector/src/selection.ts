// Which paths are shown: those that the expression, the pixels, the ball and the cluster leave, in this order. Every step is
// kept, and computed again only when something before it has changed.

import { bundles, clusterTree, leaves, placesOf, type Bundle, type Cluster, type ClusterTree } from "./clusters.ts";
import type { Data } from "./data.ts";
import { ExpressionError } from "./expression/syntax.ts";
import { Matcher } from "./expression/matcher.ts";
import type { State } from "./state.ts";

/** Paths of which bundles are made; of more an even choice, since nobody sees the difference but everybody the delay. */
const MOST_BUNDLED = 20_000;

export class Selection {
  readonly places: Float32Array;
  readonly totalWeight: number;
  /** The middle of what the sensor sees, and how far that reaches: a scene may be much larger. */
  readonly focus: number[];
  readonly unit: number;
  /** What is wrong with the expression; what was matched before is kept meanwhile. */
  mistake: ExpressionError | null = null;
  filtered: Uint32Array = new Uint32Array(0);
  filteredWeight = 0;
  tree!: ClusterTree;
  /** The clusters from the root to the one that is selected. */
  line: Cluster[] = [];
  selected: Uint32Array = new Uint32Array(0);
  /** By path: which part of the selected cluster it is in, the heaviest 0. */
  readonly part: Uint16Array;
  bundles: Bundle[] = [];
  private matched: Uint8Array;
  private keys: Record<string, string> = {};

  constructor(private readonly data: Data) {
    const { paths } = data;
    this.places = placesOf(paths);
    this.totalWeight = paths.weights.reduce((a, b) => a + b, 0);
    [this.focus, this.unit] = this.seen();
    this.part = new Uint16Array(paths.count);
    this.matched = new Uint8Array(paths.count).fill(1);
  }

  /** Mean and spread of what paths meet first from the sensor; of the scene without paths. */
  private seen(): [number[], number] {
    const { starts, count, kinds, positions } = this.data.paths;
    const { center, radius } = this.data.scene;
    const sum = [0, 0, 0];
    let squares = 0;
    let found = 0;
    for (let p = 0; p < count; p++) {
      const v = starts[p] + 1;
      if (v >= starts[p + 1] || kinds[v] > 5) continue;
      found++;
      for (let axis = 0; axis < 3; axis++) {
        sum[axis] += positions[3 * v + axis];
        squares += positions[3 * v + axis] ** 2;
      }
    }
    if (found < 10) return [center, 0.6 * radius];
    const mean = sum.map((s) => s / found);
    const spread = Math.sqrt(Math.max(0, squares / found - mean.reduce((a, m) => a + m * m, 0)));
    return [mean, Math.min(radius, Math.max(1.2 * spread, 1e-3 * radius))];
  }

  /** Whether a step must be computed, because what it reads is new. */
  private isNew(step: string, ...reads: unknown[]): boolean {
    const key = JSON.stringify(reads);
    const isNew = this.keys[step] !== key;
    this.keys[step] = key;
    return isNew;
  }

  /** Brings everything up to the state; whether the chosen paths have changed. */
  update(state: State): boolean {
    const { paths, scene } = this.data;
    let isNew = false;
    if (this.isNew("match", state.expression)) {
      this.mistake = null;
      try {
        const text = state.expression.trim();
        this.matched = text === "" ? new Uint8Array(paths.count).fill(1) : new Matcher(state.expression, scene).match(paths);
        isNew = true;
      } catch (error) {
        if (!(error instanceof ExpressionError)) throw error;
        this.mistake = error;
      }
    }
    const radius = state.reach * this.unit;
    if (this.isNew("filter", state.region, state.ball, state.ball && radius) || isNew) {
      this.filtered = this.filter(state.region, state.ball, radius);
      this.filteredWeight = this.weight(this.filtered);
      isNew = true;
    }
    if (this.isNew("tree", state.by, state.from) || isNew) {
      this.tree = clusterTree(scene, paths, this.filtered, state.by, state.from);
      isNew = true;
    }
    if (this.isNew("cluster", state.cluster) || isNew) {
      this.line = [this.tree.root];
      for (const labels of state.cluster) {
        const next = this.line[this.line.length - 1].children.find((c) => c.labels.join(" ") === labels);
        if (!next) break;
        this.line.push(next);
      }
      const cluster = this.cluster;
      this.selected = this.tree.order.slice(cluster.begin, cluster.end);
      cluster.children.forEach((child, i) => {
        for (let at = child.begin; at < child.end; at++) this.part[this.tree.order[at]] = i;
      });
      if (cluster.children.length === 0) for (const p of this.selected) this.part[p] = 0;
      isNew = true;
    }
    if (this.isNew("bundles", state.bundles, state.arrows) || isNew) {
      this.bundles = state.arrows ? this.bundle(state.bundles) : [];
      isNew = true;
    }
    return isNew;
  }

  get cluster(): Cluster {
    return this.line[this.line.length - 1];
  }

  weight(chosen: Uint32Array): number {
    return chosen.reduce((sum, p) => sum + this.data.paths.weights[p], 0);
  }

  private filter(region: number[] | null, ball: number[] | null, radius: number): Uint32Array {
    const { paths } = this.data;
    const { matched, places } = this;
    const chosen = new Uint32Array(paths.count);
    let count = 0;
    for (let p = 0; p < paths.count; p++) {
      if (!matched[p]) continue;
      if (region) {
        const x = paths.pixels[2 * p] - region[0];
        const y = paths.pixels[2 * p + 1] - region[1];
        if (!(x >= 0 && y >= 0 && x < region[2] && y < region[3])) continue;
      }
      if (ball) {
        let isNear = false;
        for (let v = paths.starts[p] + 1; v < paths.starts[p + 1] && !isNear; v++) {
          const square = [0, 1, 2].reduce((sum, axis) => sum + (places[3 * v + axis] - ball[axis]) ** 2, 0);
          isNear = square <= radius * radius;
        }
        if (!isNear) continue;
      }
      chosen[count++] = p;
    }
    return chosen.slice(0, count);
  }

  /** How many of the paths that match the expression begin in some pixels. */
  countIn(region: number[]): number {
    const { pixels, count } = this.data.paths;
    let found = 0;
    for (let p = 0; p < count; p++) {
      const x = pixels[2 * p] - region[0];
      const y = pixels[2 * p + 1] - region[1];
      if (this.matched[p] && x >= 0 && y >= 0 && x < region[2] && y < region[3]) found++;
    }
    return found;
  }

  /** Bundles of the clusters within the selected one that have a two-hundredth of its light at least. */
  private bundle(count: number): Bundle[] {
    const cluster = this.cluster;
    const stride = Math.ceil((cluster.end - cluster.begin) / MOST_BUNDLED);
    const groups = leaves(cluster)
      .filter((leaf) => leaf.weight >= 0.005 * cluster.weight)
      .map((leaf, group) => ({
        paths: this.tree.order.slice(leaf.begin, leaf.end).filter((_, i) => i % stride === 0),
        group,
      }));
    return bundles(this.data.paths, this.places, groups, count);
  }

  /** The heaviest of the selected paths. */
  heaviest(count: number): number[] {
    const { weights } = this.data.paths;
    const found: number[] = [];
    for (const p of this.selected) {
      if (found.length === count && weights[p] <= weights[found[count - 1]]) continue;
      let at = Math.min(found.length, count - 1);
      for (; at > 0 && weights[found[at - 1]] < weights[p]; at--) found[at] = found[at - 1];
      found[at] = p;
    }
    return found;
  }
}
