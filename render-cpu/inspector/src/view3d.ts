// The scene in space: its mesh, recorded paths as lines, bundles as arrows, a spherical plot, and a box of voxels.

import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import type { Bundle } from "./clusters.ts";
import type { Data } from "./data.ts";
import { ArrowBuilder } from "./arrows.ts";
import type { Scale } from "./color.ts";
import type { Plot, Volume } from "./measure.ts";
import { pick } from "./measure.ts";
import { plotMesh } from "./plot-mesh.ts";
import { pyramid } from "./sensor-mesh.ts";
import { volumeMeshes } from "./volume-mesh.ts";

/** How the mesh is drawn. */
export type MeshLook = "solid" | "x-ray" | "hidden";

/** Triangles beyond which edges are not smoothed: most of them are smaller than a pixel then. */
const SMOOTH_TRIANGLES = 400_000;
/** Most paths that are drawn as lines: more of them would cover everything, and say no more. */
export const MOST_LINES = 5000;

export class View3d {
  readonly canvas: HTMLCanvasElement;
  private readonly renderer: THREE.WebGLRenderer;
  private readonly scene = new THREE.Scene();
  private readonly camera = new THREE.PerspectiveCamera(45, 1, 0.01, 1000);
  private readonly controls: OrbitControls;
  private readonly radius: number;
  private readonly center: THREE.Vector3;
  private readonly focus: THREE.Vector3;
  private readonly unit: number;
  private sensor: THREE.LineSegments | null = null;
  private mesh!: THREE.Mesh<THREE.BufferGeometry, THREE.MeshLambertMaterial>;
  private lines!: THREE.LineSegments<THREE.BufferGeometry, THREE.LineBasicMaterial>;
  private arrows = new THREE.Group();
  private highlight = new THREE.Group();
  private plot = new THREE.Group();
  private volume = new THREE.Group();
  private mark!: THREE.Mesh;
  private isDirty = false;
  private isShown = false;
  private size = [0, 0];
  /** The field of view follows the image's until the camera is moved. */
  private isSensor = true;
  onCamera: () => void = () => {};
  onPick: (position: number[], normal: number[]) => void = () => {};

  constructor(
    private readonly container: HTMLElement,
    private readonly data: Data,
    private readonly places: Float32Array,
    seen: { focus: number[]; unit: number },
  ) {
    this.renderer = new THREE.WebGLRenderer({ antialias: data.indices.length < 3 * SMOOTH_TRIANGLES, alpha: true });
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
    this.canvas = this.renderer.domElement;
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("aria-label", "The scene in space");
    container.prepend(this.canvas);
    this.radius = data.scene.radius;
    this.center = new THREE.Vector3(...data.scene.center);
    this.focus = new THREE.Vector3().fromArray(seen.focus);
    this.unit = seen.unit;
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.enableDamping = false;
    this.controls.zoomToCursor = true;
    let isHeld = false;
    let isMoved = false;
    this.controls.addEventListener("start", () => {
      isHeld = true;
      isMoved = false;
    });
    this.controls.addEventListener("change", () => {
      if (isHeld) {
        isMoved = true;
        this.isSensor = false;
      }
      this.invalidate();
    });
    this.controls.addEventListener("end", () => {
      isHeld = false;
      if (isMoved) this.onCamera();
    });
    this.addMesh();
    this.addLines();
    this.addLights();
    this.sensor = pyramid(data.scene.camera, 0.2 * this.unit);
    if (this.sensor) this.scene.add(this.sensor);
    this.scene.add(this.arrows, this.highlight, this.plot, this.volume);
    this.addPicking();
    this.viewSensor();
    new ResizeObserver(() => this.resize()).observe(container);
    this.resize();
  }

  /** Draws at the next frame. */
  invalidate(): void {
    if (this.isDirty) return;
    this.isDirty = true;
    requestAnimationFrame(() => {
      this.isDirty = false;
      this.render();
    });
  }

  render(): void {
    this.isShown = true;
    const distance = this.camera.position.distanceTo(this.center);
    this.camera.near = Math.max(distance - 1.5 * this.radius, 0.001 * this.unit);
    this.camera.far = distance + 4 * this.radius;
    this.camera.updateProjectionMatrix();
    // Seen from its apex it would be a frame around everything.
    if (this.sensor) this.sensor.visible = !this.isSensor;
    this.renderer.render(this.scene, this.camera);
  }

  /** Draws, and waits until it is drawn. */
  finish(): void {
    this.render();
    const context = this.renderer.getContext();
    context.readPixels(0, 0, 1, 1, context.RGBA, context.UNSIGNED_BYTE, new Uint8Array(4));
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.container;
    const isOld = width === this.size[0] && height === this.size[1];
    if (width === 0 || height === 0 || isOld) return;
    this.size = [width, height];
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    if (this.isSensor) this.fitSensor();
    // At once: a canvas of a new size is empty, and would flicker.
    if (this.isShown) this.render();
    else this.invalidate();
  }

  private addMesh(): void {
    const { positions, indices, scene } = this.data;
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
    geometry.setIndex(new THREE.BufferAttribute(indices, 1));
    geometry.boundingSphere = new THREE.Sphere(this.center.clone(), this.radius);
    const colors = new Uint8Array(positions.length).fill(180);
    scene.ranges.forEach(([shape, first, count]) => {
      const { color, is_light: isLight } = scene.shapes[shape];
      // Bright enough to see its form, whatever its albedo.
      const bytes = isLight ? [255, 240, 200] : color.map((c) => Math.round(255 * (0.04 + 0.34 * Math.min(1, c))));
      for (let i = 3 * first; i < 3 * (first + count); i++) colors.set(bytes, 3 * indices[i]);
    });
    geometry.setAttribute("color", new THREE.BufferAttribute(colors, 3, true));
    const material = new THREE.MeshLambertMaterial({ vertexColors: true, flatShading: true, side: THREE.DoubleSide });
    material.polygonOffset = true;
    material.polygonOffsetFactor = 1;
    material.polygonOffsetUnits = 1;
    this.mesh = new THREE.Mesh(geometry, material);
    this.mesh.frustumCulled = false;
    this.scene.add(this.mesh);
  }

  private addLights(): void {
    const sky = new THREE.HemisphereLight(0xe8edf8, 0x4a4844, 1.1);
    sky.position.copy(this.camera.up);
    const head = new THREE.DirectionalLight(0xffffff, 1.9);
    head.position.set(0.4, 0.7, 1);
    this.camera.add(head);
    this.camera.add(head.target);
    head.target.position.set(0, 0, -1);
    this.scene.add(sky, this.camera);
  }

  private addLines(): void {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(this.places, 3));
    const colors = new THREE.BufferAttribute(new Uint8Array(this.places.length), 3, true);
    colors.setUsage(THREE.DynamicDrawUsage);
    geometry.setAttribute("color", colors);
    const most = 2 * Math.max(0, this.data.paths.starts[this.data.paths.count] - this.data.paths.count);
    const index = new THREE.BufferAttribute(new Uint32Array(most), 1);
    index.setUsage(THREE.DynamicDrawUsage);
    geometry.setIndex(index);
    geometry.setDrawRange(0, 0);
    geometry.boundingSphere = new THREE.Sphere(this.center.clone(), 10 * this.radius);
    const material = new THREE.LineBasicMaterial({
      vertexColors: true,
      transparent: true,
      depthWrite: false,
      blending: THREE.AdditiveBlending,
    });
    this.lines = new THREE.LineSegments(geometry, material);
    this.lines.frustumCulled = false;
    this.scene.add(this.lines);
  }

  private addPicking(): void {
    const ball = new THREE.SphereGeometry(1, 24, 16);
    this.mark = new THREE.Mesh(ball, new THREE.MeshBasicMaterial({ color: 0xffb020, transparent: true, opacity: 0.35, depthWrite: false }));
    this.mark.visible = false;
    this.scene.add(this.mark);
    let down: [number, number] | null = null;
    this.canvas.addEventListener("pointerdown", (e) => (down = [e.clientX, e.clientY]));
    this.canvas.addEventListener("pointerup", (e) => {
      const moved = down && Math.hypot(e.clientX - down[0], e.clientY - down[1]);
      down = null;
      if (e.button !== 0 || moved === null || moved > 4) return;
      const found = this.pickAt(e.clientX, e.clientY);
      if (found) this.onPick(found.position, found.normal);
    });
  }

  /** The surface at a place of the window, with its normal towards the viewer. */
  private pickAt(x: number, y: number): { position: number[]; normal: number[] } | null {
    const box = this.canvas.getBoundingClientRect();
    const ray = new THREE.Raycaster();
    const at = new THREE.Vector2(((x - box.left) / box.width) * 2 - 1, 1 - ((y - box.top) / box.height) * 2);
    ray.setFromCamera(at, this.camera);
    const { positions, indices } = this.data;
    const { origin, direction } = ray.ray;
    const found = pick(positions, indices, origin.toArray(), direction.toArray());
    if (found.triangle < 0) return null;
    const corner = (i: number) => new THREE.Vector3().fromArray(positions, 3 * indices[3 * found.triangle + i]);
    const normal = corner(1).sub(corner(0)).cross(corner(2).sub(corner(0))).normalize();
    if (normal.dot(direction) > 0) normal.negate();
    return { position: ray.ray.at(found.t, new THREE.Vector3()).toArray(), normal: normal.toArray() };
  }

  /** Shows the ball that a plot is taken in. */
  setMark(position: number[] | null, radius: number): void {
    this.mark.visible = position !== null;
    if (position) {
      this.mark.position.fromArray(position);
      this.mark.scale.setScalar(radius);
    }
    this.invalidate();
  }

  setMeshLook(look: MeshLook): void {
    const { material } = this.mesh;
    this.mesh.visible = look !== "hidden";
    material.transparent = look === "x-ray";
    material.opacity = look === "x-ray" ? 0.14 : 1;
    material.depthWrite = look !== "x-ray";
    material.needsUpdate = true;
    this.invalidate();
  }

  /** Draws the segments of some paths, evenly chosen if there are too many, in the colours of `colorOf`; none if `isShown` is false. */
  setLines(chosen: Uint32Array, colorOf: (path: number) => readonly number[], isShown: boolean): void {
    const { geometry, material } = this.lines;
    const { starts } = this.data.paths;
    this.lines.visible = isShown;
    if (!isShown) return this.invalidate();
    const index = geometry.getIndex()!;
    const colors = geometry.getAttribute("color") as THREE.BufferAttribute;
    const into = index.array as Uint32Array;
    const bytes = colors.array as Uint8Array;
    let count = 0;
    const stride = Math.max(1, chosen.length / MOST_LINES);
    const drawn = Math.min(chosen.length, MOST_LINES);
    for (let i = 0; i < drawn; i++) {
      const p = chosen[Math.floor(i * stride)];
      const color = colorOf(p);
      for (let v = starts[p]; v < starts[p + 1]; v++) {
        bytes[3 * v] = color[0];
        bytes[3 * v + 1] = color[1];
        bytes[3 * v + 2] = color[2];
        // The segment to the sensor says nothing: all paths of a pinhole meet there.
        if (v > starts[p] && v + 1 < starts[p + 1]) {
          into[count++] = v;
          into[count++] = v + 1;
        }
      }
    }
    index.needsUpdate = true;
    colors.needsUpdate = true;
    geometry.setDrawRange(0, count);
    material.opacity = Math.min(0.6, Math.max(0.012, 10 / Math.pow(Math.max(1, drawn), 0.76)));
    this.invalidate();
  }

  private clear(group: THREE.Group): void {
    for (const child of [...group.children]) {
      group.remove(child);
      const mesh = child as THREE.Mesh;
      mesh.geometry?.dispose();
      const materials = Array.isArray(mesh.material) ? mesh.material : [mesh.material];
      for (const material of materials) {
        (material as THREE.ShaderMaterial | undefined)?.uniforms?.voxels?.value?.dispose?.();
        material?.dispose();
      }
    }
  }

  /** Shows bundles as arrows from the light to the last surface before the sensor. */
  setBundles(bundles: Bundle[], colorOf: (bundle: Bundle) => readonly number[]): void {
    this.clear(this.arrows);
    const heaviest = bundles.reduce((most, b) => Math.max(most, b.weight), 0);
    const build = new ArrowBuilder();
    for (const bundle of bundles) {
      const radius = this.unit * (0.0035 + 0.014 * Math.sqrt(bundle.weight / heaviest));
      build.path(this.pointsOf(bundle.representative), radius, colorOf(bundle));
    }
    for (const mesh of build.meshes(0.16)) this.arrows.add(mesh);
    this.invalidate();
  }

  /** Shows one path above everything. */
  setHighlight(path: number | null): void {
    this.clear(this.highlight);
    if (path !== null) {
      const build = new ArrowBuilder();
      build.path(this.pointsOf(path), 0.008 * this.unit, [255, 255, 255]);
      for (const mesh of build.meshes(0.7)) this.highlight.add(mesh);
    }
    this.invalidate();
  }

  /** The vertices of a path from the light, without the sensor. */
  private pointsOf(path: number): THREE.Vector3[] {
    const { starts } = this.data.paths;
    const points: THREE.Vector3[] = [];
    for (let v = starts[path + 1] - 1; v > starts[path]; v--) {
      points.push(new THREE.Vector3().fromArray(this.places, 3 * v));
    }
    return points;
  }

  /** Shows a spherical plot whose largest value is `reach` times what the sensor sees long. */
  setPlot(plot: Plot | null, scale: Scale | null, reach: number): void {
    this.clear(this.plot);
    if (!plot || !scale) return this.invalidate();
    this.plot.add(plotMesh(plot, scale, reach * this.unit));
    this.invalidate();
  }

  /** Shows a box of voxels, which emit as the scale says. */
  setVolume(volume: Volume | null, scale: Scale | null, density: number): void {
    this.clear(this.volume);
    if (!volume || !scale) return this.invalidate();
    this.volume.add(...volumeMeshes(volume, scale, density));
    this.invalidate();
  }

  /** Looks through the sensor. */
  viewSensor(): void {
    const { camera } = this.data.scene;
    const m = camera.to_world;
    const column = (i: number) => new THREE.Vector3(m[i], m[4 + i], m[8 + i]);
    const [up, forward] = [column(1).normalize(), column(2).normalize()];
    // Orbits keep the axis upright that is nearest to the sensor's.
    const axis = [0, 1, 2].reduce((a, b) => (Math.abs(up.getComponent(b)) > Math.abs(up.getComponent(a)) ? b : a));
    this.camera.up.set(0, 0, 0).setComponent(axis, Math.sign(up.getComponent(axis)) || 1);
    this.controls.object.up.copy(this.camera.up);
    // The controls keep the axis that they were made with otherwise.
    const turned = this.controls as unknown as { _quat: THREE.Quaternion; _quatInverse: THREE.Quaternion };
    turned._quat?.setFromUnitVectors(this.camera.up, new THREE.Vector3(0, 1, 0));
    turned._quatInverse?.copy(turned._quat).invert();
    const origin = new THREE.Vector3(m[3], m[7], m[11]);
    const depth = Math.max(0.2 * this.unit, this.focus.clone().sub(origin).dot(forward));
    if (camera.kind === "perspective") {
      this.camera.position.copy(origin);
      this.controls.target.copy(origin).addScaledVector(forward, depth);
    } else {
      this.camera.position.copy(this.center).addScaledVector(forward, -2.2 * this.radius);
      this.controls.target.copy(this.center);
    }
    this.isSensor = true;
    this.fitSensor();
    this.controls.update();
    this.invalidate();
  }

  /** The whole image fits into the window. */
  private fitSensor(): void {
    const { camera } = this.data.scene;
    const [w, h] = camera.kind === "perspective" ? camera.tangents : [0.42, 0.42];
    const tangent = Math.max(h, w / this.camera.aspect);
    this.camera.fov = (2 * Math.atan(tangent) * 180) / Math.PI;
    this.camera.updateProjectionMatrix();
  }

  /** Shows everything. */
  frame(): void {
    this.isSensor = false;
    const direction = this.camera.position.clone().sub(this.controls.target).normalize();
    this.camera.fov = 40;
    this.camera.position.copy(this.focus).addScaledVector(direction, Math.min(2.4 * this.radius, 4.5 * this.unit));
    this.controls.target.copy(this.focus);
    this.controls.update();
    this.invalidate();
    this.onCamera();
  }

  /** Turns around what is looked at. */
  orbit(right: number, up: number): void {
    this.isSensor = false;
    const offset = this.camera.position.clone().sub(this.controls.target);
    offset.applyAxisAngle(this.camera.up, right);
    const side = offset.clone().cross(this.camera.up).normalize();
    const turned = offset.clone().applyAxisAngle(side, up);
    if (Math.abs(turned.clone().normalize().dot(this.camera.up)) < 0.99) offset.copy(turned);
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
    this.invalidate();
    this.onCamera();
  }

  /** Position, target and field of view; null while it is the sensor. */
  get pose(): number[] | null {
    if (this.isSensor) return null;
    return [...this.camera.position.toArray(), ...this.controls.target.toArray(), this.camera.fov];
  }

  set pose(pose: number[] | null) {
    if (!pose) {
      this.viewSensor();
      return;
    }
    this.isSensor = false;
    this.camera.position.fromArray(pose);
    this.controls.target.fromArray(pose, 3);
    this.camera.fov = pose[6];
    this.controls.update();
    this.invalidate();
  }
}
