// What the command writes into the page: a description in JSON, and tables of numbers as compressed bytes.

/** Kinds of vertices from 6 on; those below are D^R, D^T, G^R, G^T, S^R, S^T. */
export const VERTEX_LIGHT = 6;
export const VERTEX_BACKGROUND = 7;
export const VERTEX_SENSOR = 8;

/** The kinds in the notation of expressions. */
export const KIND_NAMES = ["D^R", "D^T", "G^R", "G^T", "S^R", "S^T", "L", "B", "E"];

/** No object. */
export const NONE = 0xffffffff;

/** A sensor: rows of four for world to camera, which looks along +z with +y up and +x to the left. */
export interface Camera {
  kind: "perspective" | "orthographic" | "other";
  to_world: number[];
  tangents: [number, number];
}

/** A spherical plot that was measured. */
export interface MeasuredPlot {
  position: [number, number, number];
  /** Columns of the frame whose last is the axis. */
  frame: [number[], number[], number[]];
  is_on_surface: boolean;
  rows: number;
  columns: number;
  integral: [number, number, number];
}

/** A box of medium in which light walks were followed. */
export interface MeasuredVolume {
  low: [number, number, number];
  high: [number, number, number];
  voxels: [number, number, number];
  walks: number;
  /** Mean fluence rate of the voxels, in W/m². */
  mean: number;
}

/** The description. */
export interface SceneData {
  title: string;
  center: [number, number, number];
  radius: number;
  image: { size: [number, number]; offset: [number, number]; film: [number, number]; has_irradiance: boolean; note: string };
  camera: Camera;
  names: { shapes: string[]; instances: string[]; materials: string[]; emitters: string[] };
  shapes: { material: string; color: [number, number, number]; is_light: boolean }[];
  emitters: { object: string; kind: "O" | "B" | "L" }[];
  regions: Record<string, { kind: number; to_unit: number[] }>;
  /** Shape, first triangle and number of triangles. */
  ranges: [number, number, number][];
  mesh: { triangles: number; of: number };
  record: { count: number; found: number; luminance: number; samples: number; expression: string | null };
  plots: MeasuredPlot[];
  volume: MeasuredVolume | null;
}

/** The recorded paths as columns; vertices go from the sensor to the light. */
export interface PathData {
  count: number;
  /** First vertex of each path, and the number of all. */
  starts: Uint32Array;
  pixels: Uint32Array;
  light: Float32Array;
  weights: Float32Array;
  kinds: Uint8Array;
  objects: Uint32Array;
  positions: Float32Array;
  throughputs: Float32Array;
}

/** Everything. */
export interface Data {
  scene: SceneData;
  paths: PathData;
  positions: Float32Array;
  indices: Uint32Array;
  image: Float32Array;
  irradiance: Float32Array | null;
  plots: Float32Array[];
  /** Of each voxel of the volume that was measured, x fastest. */
  volume: Float32Array;
}

function text(id: string): string | null {
  return document.getElementById(id)?.textContent ?? null;
}

/** The bytes of a table; the element is emptied, since nothing reads it again. */
async function bytes(name: string): Promise<ArrayBuffer | null> {
  const element = document.getElementById(`blob-${name}`);
  if (!element) return null;
  const encoded = element.textContent ?? "";
  element.textContent = "";
  const decoder = Uint8Array as unknown as { fromBase64?: (text: string) => Uint8Array<ArrayBuffer> };
  const packed = decoder.fromBase64?.(encoded) ?? Uint8Array.from(atob(encoded), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}

/** Reads all tables of the page. */
export async function readData(): Promise<Data> {
  const scene = JSON.parse(text("scene") ?? "null") as SceneData | null;
  if (!scene) throw new Error("this page has no scene: it is made by halflight inspect SCENE -o PAGE.html");
  const floats = async (name: string) => new Float32Array((await bytes(name)) ?? new ArrayBuffer(0));
  const words = async (name: string) => new Uint32Array((await bytes(name)) ?? new ArrayBuffer(0));
  const small = async (name: string) => new Uint8Array((await bytes(name)) ?? new ArrayBuffer(0));
  const plotNames = scene.plots.map((_, i) => `plot-${i}`);
  const [positions, indices, image, irradiance, pixels, light, weights, counts, kinds, objects, places, throughputs, volume, ...plots] =
    await Promise.all([
      floats("positions"),
      words("indices"),
      floats("image"),
      floats("irradiance"),
      words("path-pixels"),
      floats("path-light"),
      floats("path-weights"),
      small("path-counts"),
      small("vertex-kinds"),
      words("vertex-objects"),
      floats("vertex-positions"),
      floats("vertex-throughputs"),
      floats("volume"),
      ...plotNames.map(floats),
    ]);
  const starts = new Uint32Array(counts.length + 1);
  for (let p = 0; p < counts.length; p++) starts[p + 1] = starts[p] + counts[p];
  return {
    scene,
    paths: { count: counts.length, starts, pixels, light, weights, kinds, objects, positions: places, throughputs },
    positions,
    indices,
    image,
    irradiance: scene.image.has_irradiance ? irradiance : null,
    plots,
    volume,
  };
}

/** A name for a vertex's object. */
export function objectName(scene: SceneData, kind: number, object: number): string {
  if (kind === VERTEX_SENSOR) return "sensor";
  const isLight = kind === VERTEX_LIGHT || kind === VERTEX_BACKGROUND;
  const name = (isLight ? scene.names.emitters : scene.names.shapes)[object];
  const what = isLight ? "light" : "object";
  if (object === NONE) return what;
  const material = isLight ? "" : scene.shapes[object]?.material;
  if (!name && material) return `${what} ${object} (${material})`;
  return name ? (isLight ? `light ${name}` : name) : `${what} ${object}`;
}

/** Vertices of one kind on one object as one number, by vertex; and the kind and the object of each number. */
export interface Letters {
  word: Uint32Array;
  kinds: number[];
  objects: number[];
}

const known = new WeakMap<PathData, Letters>();

/** The letters of paths, found once: filters and clusters ask for every vertex, again and again. */
export function lettersOf(paths: PathData): Letters {
  let letters = known.get(paths);
  if (letters) return letters;
  const { starts, count, kinds, objects } = paths;
  letters = { word: new Uint32Array(starts[count]), kinds: [], objects: [] };
  const numbers = new Map<number, number>();
  for (let v = 0; v < starts[count]; v++) {
    const key = 16 * (objects[v] + 1) + kinds[v];
    let number = numbers.get(key);
    if (number === undefined) {
      number = letters.kinds.length;
      numbers.set(key, number);
      letters.kinds.push(kinds[v]);
      letters.objects.push(objects[v]);
    }
    letters.word[v] = number;
  }
  known.set(paths, letters);
  return letters;
}
