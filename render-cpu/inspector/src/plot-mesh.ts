// A spherical plot as a surface, whose distance from the probe is the value in that direction.

import * as THREE from "three";
import { MAP, placeOf, type Scale } from "./color.ts";
import { rowEdge, type Plot } from "./measure.ts";

/** The surface, `most` units long at the end of the scale. */
export function plotMesh(plot: Plot, scale: Scale, most: number): THREE.Mesh {
  const { rows, columns, values, frame } = plot;
  const positions: number[] = [];
  const colors: number[] = [];
  const indices: number[] = [];
  const value = (row: number, column: number) =>
    values[Math.min(rows - 1, Math.max(0, row)) * columns + ((column + columns) % columns)];
  for (let row = 0; row <= rows; row++) {
    const z = rowEdge(plot, row);
    const sine = Math.sqrt(Math.max(0, 1 - z * z));
    for (let column = 0; column <= columns; column++) {
      // Corners are the mean of the cells around them.
      const mean = (value(row - 1, column - 1) + value(row - 1, column) + value(row, column - 1) + value(row, column)) / 4;
      const place = placeOf(scale, mean);
      const angle = (2 * Math.PI * column) / columns;
      const local = [sine * Math.cos(angle), sine * Math.sin(angle), z];
      const length = most * place;
      for (let axis = 0; axis < 3; axis++) {
        const d = frame[0][axis] * local[0] + frame[1][axis] * local[1] + frame[2][axis] * local[2];
        positions.push(plot.position[axis] + length * d);
      }
      const entry = 3 * Math.round(1023 * place);
      for (let c = 0; c < 3; c++) colors.push(Math.pow(MAP[entry + c] / 255, 2.2));
      if (row < rows && column < columns) {
        const a = row * (columns + 1) + column;
        const b = a + columns + 1;
        indices.push(a, b, a + 1, a + 1, b, b + 1);
      }
    }
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(positions, 3));
  geometry.setAttribute("color", new THREE.Float32BufferAttribute(colors, 3));
  geometry.setIndex(indices);
  const material = new THREE.MeshLambertMaterial({ vertexColors: true, flatShading: true, side: THREE.DoubleSide });
  material.emissive.setScalar(0.12);
  const mesh = new THREE.Mesh(geometry, material);
  mesh.frustumCulled = false;
  return mesh;
}
