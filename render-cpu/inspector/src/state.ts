// What the page shows, and its form in the address behind "#": only what differs from the beginning stands there.

import type { ClusterBy, ClusterFrom } from "./clusters.ts";
import type { MeshLook } from "./view3d.ts";

export const TOOLS = ["paths", "color", "plot", "volume"] as const;
export type Tool = (typeof TOOLS)[number];

export interface State {
  expression: string;
  tool: Tool;
  /** Pixels of the whole film whose paths count: left, top, width, height. */
  region: number[] | null;
  /** A point of the scene near which paths must pass. */
  ball: number[] | null;
  by: ClusterBy;
  from: ClusterFrom;
  /** Labels of the cluster that is selected, one for each level of the tree. */
  cluster: string[];
  lines: boolean;
  arrows: boolean;
  /** Marks the pixels of the paths in the image. */
  dots: boolean;
  bundles: number;
  look: MeshLook;
  quantity: "radiance" | "irradiance";
  /** Null for what suits the tool. */
  log: boolean | null;
  least: number | null;
  most: number | null;
  exposure: number;
  /** Where the spherical plot is taken: a point, and the normal if it is on a surface. */
  probe: number[] | null;
  /** Radius of its ball over the reach of what the sensor sees. */
  reach: number;
  /** A plot that was measured, instead. */
  measured: number | null;
  /** Shows the volume that was measured, and not that of recorded paths. */
  medium: boolean;
  /** Centre and size of the box of voxels. */
  box: number[] | null;
  voxels: number;
  density: number;
  /** Position, target and field of view; null for the sensor's. */
  pose: number[] | null;
}

export const BEGIN: Readonly<State> = {
  expression: "",
  tool: "paths",
  region: null,
  ball: null,
  by: "expression",
  from: "light",
  cluster: [],
  lines: true,
  arrows: true,
  dots: true,
  bundles: 24,
  look: "solid",
  quantity: "radiance",
  log: null,
  least: null,
  most: null,
  exposure: 0,
  probe: null,
  reach: 0.08,
  measured: null,
  medium: false,
  box: null,
  voxels: 48,
  density: 1,
  pose: null,
};

const NAMES: Record<keyof State, string> = {
  expression: "e",
  tool: "tool",
  region: "px",
  ball: "ball",
  by: "by",
  from: "from",
  cluster: "cluster",
  lines: "lines",
  arrows: "arrows",
  dots: "dots",
  bundles: "bundles",
  look: "mesh",
  quantity: "quantity",
  log: "log",
  least: "min",
  most: "max",
  exposure: "ev",
  probe: "probe",
  reach: "reach",
  measured: "plot",
  medium: "medium",
  box: "box",
  voxels: "voxels",
  density: "density",
  pose: "view",
};

/** The address behind "#". */
export function toFragment(state: State): string {
  const parts = new URLSearchParams();
  for (const key of Object.keys(NAMES) as (keyof State)[]) {
    const value = state[key];
    if (JSON.stringify(value) === JSON.stringify(BEGIN[key]) || value === null) continue;
    let text = String(value);
    if (key === "cluster") text = JSON.stringify(value);
    else if (Array.isArray(value)) text = (value as number[]).map((v) => +v.toPrecision(6)).join(",");
    else if (typeof value === "boolean") text = value ? "1" : "0";
    parts.set(NAMES[key], text);
  }
  return parts.toString();
}

/** The state of an address; what cannot be read is left as it is at the beginning. */
export function fromFragment(fragment: string): State {
  const parts = new URLSearchParams(fragment.replace(/^#/, ""));
  const state: State = structuredClone(BEGIN) as State;
  const get = (key: keyof State) => parts.get(NAMES[key]);
  const choice = <K extends keyof State>(key: K, values: readonly State[K][]) => {
    const found = values.find((v) => v === get(key));
    if (found !== undefined) state[key] = found;
  };
  const numbers = (key: "region" | "ball" | "probe" | "box" | "pose", lengths: number[]) => {
    const found = get(key)?.split(",").map(Number);
    if (found && lengths.includes(found.length) && found.every(Number.isFinite)) state[key] = found;
  };
  const number = (key: "bundles" | "exposure" | "reach" | "voxels" | "density" | "least" | "most" | "measured", low: number, high: number) => {
    const found = get(key);
    if (found === null || found === "" || !Number.isFinite(Number(found))) return;
    state[key] = Math.min(high, Math.max(low, Number(found)));
  };
  const flag = (key: "lines" | "arrows" | "dots" | "log" | "medium") => {
    const found = get(key);
    if (found !== null) state[key] = found === "1";
  };
  state.expression = get("expression") ?? "";
  choice("tool", TOOLS);
  choice("by", ["expression", "object"]);
  choice("from", ["light", "sensor"]);
  choice("look", ["solid", "x-ray", "hidden"]);
  choice("quantity", ["radiance", "irradiance"]);
  numbers("region", [4]);
  numbers("ball", [3]);
  numbers("probe", [3, 6]);
  numbers("box", [6]);
  numbers("pose", [7]);
  number("bundles", 1, 400);
  number("exposure", -12, 12);
  number("reach", 0.001, 1);
  number("voxels", 4, 128);
  number("density", 0.001, 1000);
  number("least", 0, 1e30);
  number("most", 0, 1e30);
  number("measured", 0, 1e6);
  flag("lines");
  flag("arrows");
  flag("dots");
  flag("log");
  flag("medium");
  try {
    const cluster: unknown = JSON.parse(get("cluster") ?? "[]");
    if (Array.isArray(cluster) && cluster.every((l) => typeof l === "string")) state.cluster = cluster;
  } catch {
    // An address that someone has shortened: no cluster is selected.
  }
  return state;
}
