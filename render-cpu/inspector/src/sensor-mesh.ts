// Where the sensor stands, and what it looks at.

import * as THREE from "three";
import type { Camera } from "./data.ts";

/** The pyramid of a sensor as high as `length`; none of sensors that have none. */
export function pyramid(camera: Camera, length: number): THREE.LineSegments | null {
  if (camera.kind !== "perspective") return null;
  const m = camera.to_world;
  const point = (x: number, y: number, z: number) =>
    new THREE.Vector3(
      m[0] * x + m[1] * y + m[2] * z + m[3],
      m[4] * x + m[5] * y + m[6] * z + m[7],
      m[8] * x + m[9] * y + m[10] * z + m[11],
    );
  const [w, h] = camera.tangents.map((t) => t * length);
  const corners = [point(w, h, length), point(-w, h, length), point(-w, -h, length), point(w, -h, length)];
  const apex = point(0, 0, 0);
  const points: THREE.Vector3[] = [];
  corners.forEach((c, i) => points.push(apex, c, c, corners[(i + 1) % 4]));
  const top = point(0, 1.25 * h, length);
  points.push(corners[0], top, top, corners[1]);
  const geometry = new THREE.BufferGeometry().setFromPoints(points);
  return new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: 0x9fb0c8 }));
}
