// What scripts can ask of the page: the console of a browser, and the tests.

import { bundles, clusterTree, type Cluster, type ClusterBy, type ClusterFrom } from "./clusters.ts";
import type { PathData } from "./data.ts";
import { Matcher } from "./expression/matcher.ts";
import { ExpressionError } from "./expression/syntax.ts";
import { Inspector } from "./inspector.ts";

export class ScriptedInspector extends Inspector {
  /** Which of some paths, given as records would hold them, expressions match, and where they are wrong. */
  match(texts: string[], paths: PathData): (number[] | { position: number; message: string })[] {
    return texts.map((text) => {
      try {
        return Array.from(new Matcher(text, this.data.scene).match(paths));
      } catch (error) {
        if (error instanceof ExpressionError) return { position: error.position, message: error.message };
        throw error;
      }
    });
  }

  /** The tree of all paths as the command prints it. */
  tree(by: ClusterBy, from: ClusterFrom): unknown {
    const of = (c: Cluster): unknown => ({
      labels: c.labels,
      paths: c.end - c.begin,
      weight: c.weight,
      children: c.children.map(of),
    });
    const all = Uint32Array.from({ length: this.data.paths.count }, (_, i) => i);
    return of(clusterTree(this.data.scene, this.data.paths, all, by, from).root);
  }

  /** Bundles of all paths: representative, weight and spread. */
  bundles(count: number): unknown {
    const all = Uint32Array.from({ length: this.data.paths.count }, (_, i) => i);
    const found = bundles(this.data.paths, this.selection.places, [{ paths: all, group: 0 }], count);
    return found.map((b) => ({ representative: b.representative, weight: b.weight, spread: b.spread, paths: b.paths.length }));
  }

  /** The sum of the voxels of the box. */
  voxelSum(): number {
    return this.volume().values.reduce((a, b) => a + b, 0);
  }

  /** Milliseconds since the page was asked for, once what is shown is drawn. */
  drawn(): number {
    this.space.finish();
    return performance.now();
  }

  /** Numbers of what is shown. */
  get summary(): unknown {
    const { selection } = this;
    return {
      filtered: selection.filtered.length,
      selected: selection.selected.length,
      weight: selection.weight(selection.selected),
      total: selection.totalWeight,
      bundles: selection.bundles.length,
      path: this.paths.chosen,
      mistake: selection.mistake?.message ?? null,
    };
  }
}
