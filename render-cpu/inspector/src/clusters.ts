// Paths as a tree of clusters, and clusters as bundles: the same as render-cpu/src/inspect/paths/cluster.rs and bundle.rs, which a
// test in a browser compares with these.

import type { PathData, SceneData } from "./data.ts";
import { KIND_NAMES, VERTEX_BACKGROUND, lettersOf, objectName } from "./data.ts";

export type ClusterBy = "expression" | "object";
export type ClusterFrom = "light" | "sensor";

/** Paths that share the vertices at one end; they are those from `begin` to `end` in the tree's order. */
export interface Cluster {
  labels: string[];
  begin: number;
  end: number;
  weight: number;
  /** The heaviest first, equally heavy ones by their labels. */
  children: Cluster[];
}

export interface ClusterTree {
  order: Uint32Array;
  root: Cluster;
}

/** The clusters of some paths. */
export function clusterTree(scene: SceneData, paths: PathData, chosen: Uint32Array, by: ClusterBy, from: ClusterFrom): ClusterTree {
  const { starts, weights } = paths;
  const letters = lettersOf(paths);
  const labels: string[] = [];
  const numbers = new Map<string, number>();
  // Different objects may have one name.
  const labelOf = letters.kinds.map((kind, i) => {
    const label = by === "expression" ? KIND_NAMES[kind] : objectName(scene, kind, letters.objects[i]);
    if (!numbers.has(label)) {
      numbers.set(label, labels.length);
      labels.push(label);
    }
    return numbers.get(label)!;
  });
  /** The label of a path's vertex by its place from the end where clusters begin, -1 behind the last. */
  const at = (p: number, place: number): number => {
    const length = starts[p + 1] - starts[p];
    if (place >= length) return -1;
    return labelOf[letters.word[from === "light" ? starts[p + 1] - 1 - place : starts[p] + place]];
  };
  const order = Uint32Array.from(chosen);
  const build = (begin: number, end: number, above: number): Cluster => {
    let shared = above;
    let weight = 0;
    for (let i = begin; i < end; i++) weight += weights[order[i]];
    const own: string[] = [];
    for (; begin < end; shared++) {
      const label = at(order[begin], shared);
      if (label < 0) break;
      let isCommon = true;
      for (let i = begin + 1; i < end && isCommon; i++) isCommon = at(order[i], shared) === label;
      if (!isCommon) break;
      own.push(labels[label]);
    }
    const cluster: Cluster = { labels: own, begin, end, weight, children: [] };
    const groups = new Map<number, { weight: number; name: string; paths: number[] }>();
    for (let i = begin; i < end; i++) {
      const label = at(order[i], shared);
      let group = groups.get(label);
      if (!group) groups.set(label, (group = { weight: 0, name: labels[label] ?? "", paths: [] }));
      group.weight += weights[order[i]];
      group.paths.push(order[i]);
    }
    if (groups.size < 2) return cluster;
    let next = begin;
    for (const group of [...groups.values()].sort((a, b) => b.weight - a.weight || (a.name < b.name ? -1 : 1))) {
      order.set(group.paths, next);
      cluster.children.push(build(next, next + group.paths.length, shared));
      next += group.paths.length;
    }
    return cluster;
  };
  return { order, root: build(0, order.length, 0) };
}

/** Clusters of paths that are the same all along. */
export function leaves(cluster: Cluster, found: Cluster[] = []): Cluster[] {
  if (cluster.children.length === 0) found.push(cluster);
  for (const child of cluster.children) leaves(child, found);
  return found;
}

/** Many paths as one. */
export interface Bundle {
  paths: Uint32Array;
  weight: number;
  /** Root mean square distance of each shared vertex from its mean, from the sensor. */
  spread: number[];
  /** The path that stands for all. */
  representative: number;
  scatter: number;
  /** Vertex, axis and mean where it spreads most. */
  cut: [number, number, number];
  /** What it is a part of. */
  group: number;
}

function bundleOf(paths: PathData, places: Float32Array, own: Uint32Array, group: number): Bundle {
  const { starts, weights } = paths;
  let shared = Infinity;
  let weight = 0;
  for (const p of own) {
    shared = Math.min(shared, starts[p + 1] - starts[p]);
    weight += weights[p];
  }
  const means = new Float64Array(3 * shared);
  const variances = new Float64Array(3 * shared);
  for (const p of own) {
    const share = weights[p] / weight;
    for (let i = 0, v = 3 * starts[p]; i < 3 * shared; i++, v++) means[i] += share * places[v];
  }
  let representative = own[0];
  let nearest = Infinity;
  for (const p of own) {
    const share = weights[p] / weight;
    let distance = 0;
    for (let i = 0, v = 3 * starts[p]; i < 3 * shared; i++, v++) {
      const square = (places[v] - means[i]) ** 2;
      variances[i] += share * square;
      distance += square;
    }
    if (distance < nearest) {
      nearest = distance;
      representative = p;
    }
  }
  let widest = 0;
  variances.forEach((v, i) => {
    if (v > variances[widest]) widest = i;
  });
  const spread = Array.from({ length: shared }, (_, i) =>
    Math.sqrt(variances[3 * i] + variances[3 * i + 1] + variances[3 * i + 2]),
  );
  const scatter = weight * variances.reduce((a, b) => a + b, 0);
  const cut: [number, number, number] = [Math.floor(widest / 3), widest % 3, means[widest]];
  return { paths: own, weight, spread, representative, scatter, cut, group };
}

/** Bundles of groups of paths, divided where they spread most until there are `count`; the heaviest first. */
export function bundles(paths: PathData, places: Float32Array, groups: { paths: Uint32Array; group: number }[], count: number): Bundle[] {
  const open = groups.filter((g) => g.paths.length > 0).map((g) => bundleOf(paths, places, g.paths, g.group));
  const closed: Bundle[] = [];
  while (open.length > 0 && open.length + closed.length < count) {
    let widest = 0;
    open.forEach((b, i) => {
      if (b.scatter > open[widest].scatter) widest = i;
    });
    const [bundle] = open.splice(widest, 1);
    const [vertex, axis, mean] = bundle.cut;
    const isBelow = (p: number) => places[3 * (paths.starts[p] + vertex) + axis] < mean;
    const below = bundle.paths.filter(isBelow);
    const above = bundle.paths.filter((p) => !isBelow(p));
    if (below.length === 0 || above.length === 0) {
      closed.push(bundle);
    } else {
      open.push(bundleOf(paths, places, below, bundle.group), bundleOf(paths, places, above, bundle.group));
    }
  }
  return closed.concat(open).sort((a, b) => b.weight - a.weight);
}

/** Positions of all vertices, with light from infinity half the extent of all paths from the vertex that it meets. */
export function placesOf(paths: PathData): Float32Array {
  const { starts, kinds, positions, count } = paths;
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let v = 0; v < starts[count]; v++) {
    if (kinds[v] === VERTEX_BACKGROUND) continue;
    for (let axis = 0; axis < 3; axis++) {
      const x = positions[3 * v + axis];
      if (x < low[axis]) low[axis] = x;
      if (x > high[axis]) high[axis] = x;
    }
  }
  const extent = count > 0 ? Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]) : 0;
  const places = positions.slice();
  for (let p = 0; p < count; p++) {
    for (let v = starts[p] + 1; v < starts[p + 1]; v++) {
      if (kinds[v] !== VERTEX_BACKGROUND) continue;
      for (let axis = 0; axis < 3; axis++) {
        places[3 * v + axis] = places[3 * (v - 1) + axis] + 0.5 * extent * positions[3 * v + axis];
      }
    }
  }
  return places;
}
