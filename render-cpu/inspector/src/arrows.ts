// Arrows along paths, as one mesh.

import * as THREE from "three";

const ARROW_SIDES = 8;

/** Arrows of many paths in one mesh. */
export class ArrowBuilder {
  private readonly positions: number[] = [];
  private readonly normals: number[] = [];
  private readonly colors: number[] = [];
  private readonly indices: number[] = [];

  path(points: THREE.Vector3[], radius: number, color: readonly number[]): void {
    for (let i = 0; i + 1 < points.length; i++) this.segment(points[i], points[i + 1], radius, color);
  }

  private segment(a: THREE.Vector3, b: THREE.Vector3, radius: number, color: readonly number[]): void {
    const along = b.clone().sub(a);
    const length = along.length();
    if (!(length > 0)) return;
    along.divideScalar(length);
    const head = Math.min(0.5 * length, 7 * radius);
    const side = new THREE.Vector3(Math.abs(along.x) < 0.7 ? 1 : 0, Math.abs(along.x) < 0.7 ? 0 : 1, 0).cross(along).normalize();
    const other = along.clone().cross(side);
    const neck = b.clone().addScaledVector(along, -head);
    this.cone(a, neck, radius, radius, along, side, other, color);
    this.cone(neck, b, Math.min(0.5 * head, 2.8 * radius), 0, along, side, other, color);
  }

  private cone(
    a: THREE.Vector3,
    b: THREE.Vector3,
    radiusA: number,
    radiusB: number,
    along: THREE.Vector3,
    side: THREE.Vector3,
    other: THREE.Vector3,
    color: readonly number[],
  ): void {
    const first = this.positions.length / 3;
    const slope = (radiusA - radiusB) / Math.max(1e-12, a.distanceTo(b));
    const linear = color.map((c) => Math.pow(c / 255, 2.2));
    for (let i = 0; i < ARROW_SIDES; i++) {
      const angle = (2 * Math.PI * i) / ARROW_SIDES;
      const out = side.clone().multiplyScalar(Math.cos(angle)).addScaledVector(other, Math.sin(angle));
      const normal = out.clone().addScaledVector(along, slope).normalize();
      for (const [end, radius] of [[a, radiusA], [b, radiusB]] as const) {
        this.positions.push(...end.clone().addScaledVector(out, radius).toArray());
        this.normals.push(...normal.toArray());
        this.colors.push(...linear);
      }
      const [p, q] = [first + 2 * i, first + 2 * ((i + 1) % ARROW_SIDES)];
      this.indices.push(p, q, p + 1, q, q + 1, p + 1);
    }
  }

  private geometry(): THREE.BufferGeometry {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.Float32BufferAttribute(this.positions, 3));
    geometry.setAttribute("normal", new THREE.Float32BufferAttribute(this.normals, 3));
    geometry.setAttribute("color", new THREE.Float32BufferAttribute(this.colors, 3));
    geometry.setIndex(this.indices);
    return geometry;
  }

  /** What is seen, and behind surfaces the same as faint as `hiddenOpacity`. */
  meshes(hiddenOpacity: number): THREE.Mesh[] {
    if (this.indices.length === 0) return [];
    const geometry = this.geometry();
    const hidden = new THREE.MeshBasicMaterial({
      vertexColors: true,
      transparent: true,
      opacity: hiddenOpacity,
      depthWrite: false,
      depthFunc: THREE.GreaterDepth,
    });
    const behind = new THREE.Mesh(geometry, hidden);
    behind.renderOrder = 2;
    const meshes = [new THREE.Mesh(geometry, new THREE.MeshLambertMaterial({ vertexColors: true })), behind];
    for (const mesh of meshes) mesh.frustumCulled = false;
    return meshes;
  }
}
