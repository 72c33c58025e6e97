// The scene in space: its mesh, recorded paths as lines, bundles as arrows, a spherical plot, and a box of voxels.

import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import type { Bundle } from "./clusters.ts";
import type { Data } from "./data.ts";
import { MAP, placeOf, type Scale } from "./color.ts";
import type { Plot, Volume } from "./measure.ts";
import { pick, rowEdge } from "./measure.ts";

/** How the mesh is drawn. */
export type MeshLook = "solid" | "x-ray" | "hidden";

const ARROW_SIDES = 8;
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
    this.addSensor();
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

  /** The sensor's pyramid. */
  private addSensor(): void {
    const { camera } = this.data.scene;
    if (camera.kind !== "perspective") return;
    const m = camera.to_world;
    const length = 0.2 * this.unit;
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
    this.sensor = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: 0x9fb0c8 }));
    this.scene.add(this.sensor);
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
    this.addArrows(this.arrows, build);
    this.invalidate();
  }

  /** Shows one path above everything. */
  setHighlight(path: number | null): void {
    this.clear(this.highlight);
    if (path !== null) {
      const build = new ArrowBuilder();
      build.path(this.pointsOf(path), 0.008 * this.unit, [255, 255, 255]);
      this.addArrows(this.highlight, build, 0.7);
    }
    this.invalidate();
  }

  private addArrows(group: THREE.Group, build: ArrowBuilder, hiddenOpacity = 0.16): void {
    if (build.indices.length === 0) return;
    const geometry = build.geometry();
    const seen = new THREE.MeshLambertMaterial({ vertexColors: true, flatShading: false });
    const hidden = new THREE.MeshBasicMaterial({
      vertexColors: true,
      transparent: true,
      opacity: hiddenOpacity,
      depthWrite: false,
      depthFunc: THREE.GreaterDepth,
    });
    const behind = new THREE.Mesh(geometry, hidden);
    behind.renderOrder = 2;
    const before = new THREE.Mesh(geometry, seen);
    for (const mesh of [before, behind]) {
      mesh.frustumCulled = false;
      group.add(mesh);
    }
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
        const length = reach * this.unit * place;
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
    this.plot.add(mesh);
    this.invalidate();
  }

  /** Shows a box of voxels, which emit as the scale says. */
  setVolume(volume: Volume | null, scale: Scale | null, density: number): void {
    this.clear(this.volume);
    if (!volume || !scale) return this.invalidate();
    const { low, high, size, values } = volume;
    const texels = new Uint8Array(values.length);
    for (let i = 0; i < values.length; i++) texels[i] = Math.round(255 * placeOf(scale, values[i]));
    const voxels = new THREE.Data3DTexture(texels, size[0], size[1], size[2]);
    voxels.format = THREE.RedFormat;
    voxels.minFilter = voxels.magFilter = THREE.LinearFilter;
    voxels.unpackAlignment = 1;
    voxels.needsUpdate = true;
    const map = new Uint8Array(4 * 256).fill(255);
    for (let i = 0; i < 256; i++) map.set(MAP.subarray(3 * Math.round((1023 * i) / 255)).subarray(0, 3), 4 * i);
    const colors = new THREE.DataTexture(map, 256, 1);
    colors.minFilter = colors.magFilter = THREE.LinearFilter;
    colors.needsUpdate = true;
    const extent = new THREE.Vector3(...high.map((h, i) => h - low[i]));
    const corner = new THREE.Vector3(...low);
    const box = new THREE.BoxGeometry(extent.x, extent.y, extent.z);
    const middle = corner.clone().addScaledVector(extent, 0.5);
    const material = new THREE.ShaderMaterial({
      glslVersion: THREE.GLSL3,
      uniforms: {
        voxels: { value: voxels },
        colors: { value: colors },
        corner: { value: corner },
        extent: { value: extent },
        density: { value: density },
      },
      vertexShader: VOLUME_VERTEX,
      fragmentShader: VOLUME_FRAGMENT,
      side: THREE.BackSide,
      transparent: true,
      depthTest: false,
      depthWrite: false,
      premultipliedAlpha: true,
      blending: THREE.CustomBlending,
      blendSrc: THREE.OneFactor,
      blendDst: THREE.OneMinusSrcAlphaFactor,
    });
    const mesh = new THREE.Mesh(box, material);
    mesh.position.copy(middle);
    mesh.renderOrder = 3;
    const frame = new THREE.LineSegments(
      new THREE.EdgesGeometry(box),
      new THREE.LineBasicMaterial({ color: 0x8fa3c0, transparent: true, opacity: 0.8 }),
    );
    frame.position.copy(middle);
    this.volume.add(mesh, frame);
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

/** Arrows of many paths in one mesh. */
class ArrowBuilder {
  readonly positions: number[] = [];
  readonly normals: number[] = [];
  readonly colors: number[] = [];
  readonly indices: number[] = [];

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

  geometry(): THREE.BufferGeometry {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.Float32BufferAttribute(this.positions, 3));
    geometry.setAttribute("normal", new THREE.Float32BufferAttribute(this.normals, 3));
    geometry.setAttribute("color", new THREE.Float32BufferAttribute(this.colors, 3));
    geometry.setIndex(this.indices);
    return geometry;
  }
}

const VOLUME_VERTEX = `
out vec3 world;
void main() {
  world = (modelMatrix * vec4(position, 1.0)).xyz;
  gl_Position = projectionMatrix * viewMatrix * vec4(world, 1.0);
}`;

// From the back faces to the eye, front to back, in steps of half a voxel of a grid of 48.
const VOLUME_FRAGMENT = `
precision highp float;
precision highp sampler3D;
uniform sampler3D voxels;
uniform sampler2D colors;
uniform vec3 corner;
uniform vec3 extent;
uniform float density;
in vec3 world;
out vec4 fragment;
void main() {
  vec3 eye = (cameraPosition - corner) / extent;
  vec3 away = (world - corner) / extent - eye;
  vec3 t0 = -eye / away;
  vec3 t1 = (1.0 - eye) / away;
  vec3 near = min(t0, t1);
  float from = max(0.0, max(near.x, max(near.y, near.z)));
  vec3 last = max(t0, t1);
  float to = min(last.x, min(last.y, last.z));
  const int STEPS = 96;
  float stride = (to - from) / float(STEPS);
  float thickness = length(away * stride) * density;
  vec4 sum = vec4(0.0);
  for (int i = 0; i < STEPS; i++) {
    float value = texture(voxels, eye + away * (from + (float(i) + 0.5) * stride)).r;
    float alpha = 1.0 - exp(-thickness * value * value * 12.0);
    vec3 color = texture(colors, vec2(0.2 + 0.8 * value, 0.5)).rgb;
    sum += (1.0 - sum.a) * alpha * vec4(color, 1.0);
  }
  fragment = sum;
}`;
