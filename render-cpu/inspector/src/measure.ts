// What recorded paths say about a box of space and about a point: a volume of voxels and a spherical plot.

import type { PathData } from "./data.ts";

/** A grid of voxels over a box. */
export interface Volume {
  low: number[];
  high: number[];
  size: number[];
  values: Float32Array;
}

/**
 * Paths rasterised to voxels (Kaplanyan 2017, section 9.1.2): each adds its weight times the length of its way through a voxel,
 * over the voxel's volume. Segments to the sensor count only if asked for, since all of them meet there.
 */
export function rasterise(
  paths: PathData,
  places: Float32Array,
  chosen: Uint32Array,
  low: number[],
  high: number[],
  size: number[],
  withSensor: boolean,
): Volume {
  const values = new Float32Array(size[0] * size[1] * size[2]);
  const cell = [0, 1, 2].map((a) => (high[a] - low[a]) / size[a]);
  const perVolume = 1 / (cell[0] * cell[1] * cell[2]);
  const next = [0, 0, 0];
  const step = [0, 0, 0];
  const delta = [0, 0, 0];
  const at = [0, 0, 0];
  for (const p of chosen) {
    const first = paths.starts[p] + (withSensor ? 0 : 1);
    for (let v = first; v + 1 < paths.starts[p + 1]; v++) {
      // From a to b, t from 0 to 1, cut by the box.
      let from = 0;
      let to = 1;
      let length = 0;
      for (let axis = 0; axis < 3; axis++) {
        const a = places[3 * v + axis];
        const d = places[3 * v + 3 + axis] - a;
        length += d * d;
        if (d === 0) {
          if (a < low[axis] || a > high[axis]) to = -1;
          continue;
        }
        const t0 = (low[axis] - a) / d;
        const t1 = (high[axis] - a) / d;
        from = Math.max(from, Math.min(t0, t1));
        to = Math.min(to, Math.max(t0, t1));
      }
      if (!(from < to)) continue;
      length = Math.sqrt(length);
      // From voxel to voxel (Amanatides and Woo 1987).
      for (let axis = 0; axis < 3; axis++) {
        const a = places[3 * v + axis];
        const d = places[3 * v + 3 + axis] - a;
        const x = (a + from * d - low[axis]) / cell[axis];
        at[axis] = Math.min(size[axis] - 1, Math.max(0, Math.floor(x)));
        step[axis] = Math.sign(d);
        const border = low[axis] + (at[axis] + (d > 0 ? 1 : 0)) * cell[axis];
        next[axis] = d === 0 ? Infinity : (border - a) / d;
        delta[axis] = d === 0 ? Infinity : cell[axis] / Math.abs(d);
      }
      let t = from;
      while (t < to) {
        const axis = next[0] <= next[1] ? (next[0] <= next[2] ? 0 : 2) : next[1] <= next[2] ? 1 : 2;
        const until = Math.min(to, next[axis]);
        const index = (at[2] * size[1] + at[1]) * size[0] + at[0];
        if (until > t) values[index] += paths.weights[p] * (until - t) * length * perVolume;
        t = Math.max(t, until);
        at[axis] += step[axis];
        next[axis] += delta[axis];
        if (at[axis] < 0 || at[axis] >= size[axis]) break;
      }
    }
  }
  return { low, high, size, values };
}

/** A value for each direction: cells of latitude and longitude of equal solid angle around an axis. */
export interface Plot {
  rows: number;
  columns: number;
  position: number[];
  /** The frame whose last vector is the axis. */
  frame: number[][];
  isOnSurface: boolean;
  values: Float32Array;
}

/** Cosine with the axis at the upper edge of a row. */
export function rowEdge(plot: { rows: number; isOnSurface: boolean }, row: number): number {
  return plot.isOnSurface ? 1 - row / plot.rows : 1 - (2 * row) / plot.rows;
}

/**
 * The light that recorded paths carry through a small ball, by the direction from which it comes: the sum of their weights per solid
 * angle and cross section of the ball.
 */
export function plotOfPaths(
  paths: PathData,
  places: Float32Array,
  chosen: Uint32Array,
  position: number[],
  radius: number,
  frame: number[][],
  isOnSurface: boolean,
  rows: number,
): Plot {
  const columns = 2 * rows;
  const values = new Float32Array(rows * columns);
  const solidAngle = ((isOnSurface ? 2 : 4) * Math.PI) / (rows * columns);
  const perCell = 1 / (solidAngle * Math.PI * radius * radius);
  for (const p of chosen) {
    for (let v = paths.starts[p]; v + 1 < paths.starts[p + 1]; v++) {
      let square = 0;
      let along = 0;
      for (let axis = 0; axis < 3; axis++) {
        const d = places[3 * v + 3 + axis] - places[3 * v + axis];
        square += d * d;
        along += d * (position[axis] - places[3 * v + axis]);
      }
      const t = Math.min(1, Math.max(0, along / square));
      let distance = 0;
      const local = [0, 0, 0];
      for (let axis = 0; axis < 3; axis++) {
        const d = places[3 * v + 3 + axis] - places[3 * v + axis];
        distance += (places[3 * v + axis] + t * d - position[axis]) ** 2;
        for (let i = 0; i < 3; i++) local[i] += frame[i][axis] * d;
      }
      if (!(distance <= radius * radius) || !(square > 0)) continue;
      const z = local[2] / Math.sqrt(square);
      if (isOnSurface && z <= 0) continue;
      const row = Math.floor((isOnSurface ? 1 - z : 0.5 * (1 - z)) * rows);
      const turn = Math.atan2(local[1], local[0]) / (2 * Math.PI);
      const column = Math.floor((turn < 0 ? turn + 1 : turn) * columns);
      values[Math.min(rows - 1, row) * columns + Math.min(columns - 1, column)] += paths.weights[p] * perCell;
    }
  }
  return { rows, columns, position, frame, isOnSurface, values };
}

/** Two directions that are at right angles to a unit one and to each other. */
export function frameOf(n: number[]): number[][] {
  const sign = n[2] >= 0 ? 1 : -1;
  const a = -1 / (sign + n[2]);
  const b = n[0] * n[1] * a;
  return [[1 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]], [b, sign + n[1] * n[1] * a, -n[1]], n];
}

/** The nearest triangle on a ray: its distance and index, the distance infinite if there is none. */
export function pick(positions: Float32Array, indices: Uint32Array, origin: number[], direction: number[]): { t: number; triangle: number } {
  const [ox, oy, oz] = origin;
  const [dx, dy, dz] = direction;
  let t = Infinity;
  let triangle = -1;
  for (let i = 0; i < indices.length; i += 3) {
    const [a, b, c] = [3 * indices[i], 3 * indices[i + 1], 3 * indices[i + 2]];
    const e1x = positions[b] - positions[a];
    const e1y = positions[b + 1] - positions[a + 1];
    const e1z = positions[b + 2] - positions[a + 2];
    const e2x = positions[c] - positions[a];
    const e2y = positions[c + 1] - positions[a + 1];
    const e2z = positions[c + 2] - positions[a + 2];
    const px = dy * e2z - dz * e2y;
    const py = dz * e2x - dx * e2z;
    const pz = dx * e2y - dy * e2x;
    const determinant = e1x * px + e1y * py + e1z * pz;
    if (determinant === 0) continue;
    const sx = ox - positions[a];
    const sy = oy - positions[a + 1];
    const sz = oz - positions[a + 2];
    const u = (sx * px + sy * py + sz * pz) / determinant;
    if (u < 0 || u > 1) continue;
    const qx = sy * e1z - sz * e1y;
    const qy = sz * e1x - sx * e1z;
    const qz = sx * e1y - sy * e1x;
    const v = (dx * qx + dy * qy + dz * qz) / determinant;
    if (v < 0 || u + v > 1) continue;
    const found = (e2x * qx + e2y * qy + e2z * qz) / determinant;
    if (found > 1e-6 && found < t) {
      t = found;
      triangle = i / 3;
    }
  }
  return { t, triangle };
}
