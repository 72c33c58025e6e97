// The page as one object: the state, what follows from it, and the views that show it.

import { clusterColor, luminance, scaleOf, short, type Scale } from "./color.ts";
import type { Cluster } from "./clusters.ts";
import type { Data } from "./data.ts";
import { byId, choice, el, isSliding, refill, slider } from "./dom.ts";
import { fillHelp } from "./help.ts";
import { ImageView } from "./image-view.ts";
import { onKey } from "./keys.ts";
import { showLegend } from "./legend.ts";
import { frameOf, plotOfPaths, rasterise, type Plot, type Volume } from "./measure.ts";
import { panelOf, TOOL_NAMES } from "./panels.ts";
import { Selection } from "./selection.ts";
import { TOOLS, fromFragment, toFragment, type State } from "./state.ts";
import { connectSplitter } from "./splitter.ts";
import { ClusterView, PathView } from "./tree.ts";
import { MOST_LINES, View3d } from "./view3d.ts";

/** Rows of a plot of recorded paths. */
const PLOT_ROWS = 20;
/** Paths that a click in the image chooses at least, if there are that many nearby. */
const ENOUGH_PATHS = 12;
/** Most pixels that are marked; more would hide the image. */
const MOST_DOTS = 40_000;

export class Inspector {
  state: State;
  readonly selection: Selection;
  /** The scale of the tool that is chosen. */
  scale: Scale | null = null;
  readonly space: View3d;
  readonly image: ImageView;
  private readonly clusters: ClusterView;
  readonly paths: PathView;
  private shown: Partial<Record<"image" | "plot" | "volume" | "panel" | "lines", string>> = {};
  private readonly luminances: { radiance: Float32Array; irradiance: Float32Array | null };

  constructor(readonly data: Data) {
    this.state = fromFragment(location.hash);
    this.fit(this.state);
    this.selection = new Selection(data);
    this.luminances = {
      radiance: luminances(data.image),
      irradiance: data.irradiance && luminances(data.irradiance),
    };
    this.space = new View3d(byId("space"), data, this.selection.places, this.selection);
    this.image = new ImageView(byId("picture"), data);
    this.clusters = new ClusterView(byId("tree"));
    this.paths = new PathView(byId("paths"), byId("vertices"), data);
    this.connect();
    this.describeScene();
    if (this.state.pose) this.space.pose = this.state.pose;
    this.update();
  }

  /** Changes the state, and shows it. */
  set(changes: Partial<State>): void {
    // What was chosen in a tree that is no more says nothing.
    const isOther = (["by", "from"] as const).some((k) => changes[k] !== undefined && changes[k] !== this.state[k]);
    this.state = { ...this.state, ...(isOther ? { cluster: [] } : {}), ...changes };
    this.fit(this.state);
    this.update();
    history.replaceState(null, "", `#${toFragment(this.state)}`);
  }

  /** Whether the scale of the tool is logarithmic. A plot's is not, since the radius of a logarithm tells little. */
  get isLog(): boolean {
    return this.state.log ?? this.state.tool !== "plot";
  }

  /** Leaves nothing in a state that this scene does not have. */
  private fit(state: State): void {
    if (state.measured !== null && !this.data.scene.plots[state.measured]) state.measured = null;
    if (!this.data.scene.volume) state.medium = false;
    if (!this.data.irradiance) state.quantity = "radiance";
    if (state.tool === "plot" && !state.probe && this.data.scene.plots.length > 0) state.measured ??= 0;
  }

  private isNew(what: keyof Inspector["shown"], ...reads: unknown[]): boolean {
    const key = JSON.stringify(reads);
    const isNew = this.shown[what] !== key;
    this.shown[what] = key;
    return isNew;
  }

  private version = 0;

  private update(): void {
    const { state, selection } = this;
    if (selection.update(state)) {
      this.version++;
      this.clusters.show(selection, state);
      this.paths.show(selection);
    }
    this.showExpression();
    this.showCounts();
    // Within a volume or around a plot, lines and arrows would hide it.
    const isSeen = state.tool === "paths" || state.tool === "color";
    if (this.isNew("lines", this.version, isSeen && state.lines, isSeen && state.arrows)) this.showPaths(isSeen);
    this.showImage();
    this.showMeasures();
    this.showMarks();
    this.space.setMeshLook(state.look);
    this.showPanel();
  }

  private showExpression(): void {
    const input = byId<HTMLInputElement>("expression");
    if (document.activeElement !== input) input.value = this.state.expression;
    const { mistake } = this.selection;
    const box = byId("mistake");
    input.classList.toggle("wrong", mistake !== null);
    box.hidden = mistake === null;
    if (!mistake) return;
    const text = Array.from(this.state.expression).join("");
    box.textContent = `${text}\n${" ".repeat(mistake.position)}^ ${mistake.message}`;
  }

  private showCounts(): void {
    const { selection, data } = this;
    const share = selection.totalWeight > 0 ? selection.weight(selection.selected) / selection.totalWeight : 0;
    const count = (n: number) => n.toLocaleString("en").replaceAll(",", "\u202f");
    byId("counts").replaceChildren(
      el("b", {}, count(selection.selected.length)),
      ` of ${count(data.paths.count)} paths · `,
      el("b", {}, `${(100 * share).toFixed(1)} %`),
      " of the light",
    );
    byId("path-count").textContent = `${count(selection.selected.length)} in the cluster`;
  }

  private showPaths(isSeen: boolean): void {
    const { state, selection } = this;
    this.space.setLines(selection.selected, (p) => clusterColor(selection.part[p]), isSeen && state.lines);
    this.space.setBundles(isSeen ? selection.bundles : [], (b) => clusterColor(selection.part[b.representative]));
  }

  private get isFiltered(): boolean {
    const { state } = this;
    return state.expression.trim() !== "" || state.region !== null || state.ball !== null || state.cluster.length > 0;
  }

  private showMarks(): void {
    const { state, selection, data } = this;
    const chosen = this.paths.chosen;
    let dots: Uint32Array | null = null;
    if (chosen !== null) {
      dots = data.paths.pixels.slice(2 * chosen, 2 * chosen + 2);
    } else if (state.dots && this.isFiltered && selection.selected.length <= MOST_DOTS) {
      dots = new Uint32Array(2 * selection.selected.length);
      selection.selected.forEach((p, i) => dots!.set(data.paths.pixels.subarray(2 * p, 2 * p + 2), 2 * i));
    }
    this.image.mark(state.region, dots, chosen !== null ? "255 255 255" : "255 176 32");
    const place = state.tool === "plot" ? (state.measured === null ? state.probe : null) : state.ball;
    this.space.setMark(place ? place.slice(0, 3) : null, state.reach * this.selection.unit);
  }

  private showImage(): void {
    const { state } = this;
    const isColor = state.tool === "color";
    const reads = isColor ? [state.quantity, this.isLog, state.least, state.most] : [state.exposure];
    if (this.isNew("image", isColor, ...reads)) {
      if (isColor) {
        const values = this.luminances[state.quantity] ?? this.luminances.radiance;
        this.scale = scaleOf(values, state.least, state.most, this.isLog);
        this.image.showScaled(values, this.scale);
        const unit = state.quantity === "irradiance" ? "irradiance, W/m²" : "radiance, W/(m² sr)";
        showLegend("picture-legend", this.scale, unit);
      } else {
        this.image.showToned(state.exposure);
        showLegend("picture-legend", null, "");
      }
    }
  }

  /** The plot or the volume. */
  private showMeasures(): void {
    const { state } = this;
    const scaled = [this.isLog, state.least, state.most];
    const isPlot = state.tool === "plot";
    const isVolume = state.tool === "volume";
    if (this.isNew("plot", isPlot, ...(isPlot ? [this.version, state.probe, state.reach, state.measured, scaled] : []))) {
      const plot = isPlot ? this.plot() : null;
      const scale = plot && scaleOf(plot.values, state.least, state.most, this.isLog);
      this.space.setPlot(plot, scale, 0.42);
      if (isPlot) {
        this.scale = scale;
        const what = state.measured !== null ? "radiance, W/(m² sr)" : "recorded light, per m² and sr";
        showLegend("space-legend", scale, what);
      }
    }
    if (this.isNew("volume", isVolume, ...(isVolume ? [this.version, this.box, state.medium, state.voxels, state.density, scaled] : []))) {
      const volume = isVolume ? this.volume() : null;
      const scale = volume && scaleOf(volume.values, state.least, state.most, this.isLog);
      const size = volume ? Math.max(...volume.high.map((h, i) => h - volume.low[i])) : 1;
      this.space.setVolume(volume, scale, (4 * state.density) / size);
      if (isVolume) {
        this.scale = scale;
        showLegend("space-legend", scale, state.medium ? "fluence rate, W/m²" : "recorded light, per m²");
      }
    }
    if (!isPlot && !isVolume) showLegend("space-legend", null, "");
  }

  private plot(): Plot | null {
    const { state, data, selection } = this;
    if (state.measured !== null) {
      const { rows, columns, position, frame, is_on_surface: isOnSurface } = data.scene.plots[state.measured];
      return { rows, columns, position, frame, isOnSurface, values: data.plots[state.measured] };
    }
    if (!state.probe) return null;
    const isOnSurface = state.probe.length === 6;
    const frame = frameOf(isOnSurface ? state.probe.slice(3) : [0, 0, 1]);
    const radius = state.reach * this.selection.unit;
    return plotOfPaths(data.paths, selection.places, selection.selected, state.probe.slice(0, 3), radius, frame, isOnSurface, PLOT_ROWS);
  }

  volume(): Volume {
    const { state, data, selection } = this;
    const measured = data.scene.volume;
    if (state.medium && measured) return { low: measured.low, high: measured.high, size: measured.voxels, values: data.volume };
    const box = this.box;
    const low = [0, 1, 2].map((a) => box[a] - 0.5 * box[3 + a]);
    const high = [0, 1, 2].map((a) => box[a] + 0.5 * box[3 + a]);
    const longest = Math.max(box[3], box[4], box[5]);
    const size = [0, 1, 2].map((a) => Math.max(2, Math.round((state.voxels * box[3 + a]) / longest)));
    return rasterise(data.paths, selection.places, selection.selected, low, high, size, false);
  }

  /** Centre and size of the box of voxels: that of the state, or one around most of what paths meet first from the sensor. */
  get box(): number[] {
    if (this.state.box) return this.state.box;
    const { kinds, positions, starts, count } = this.data.paths;
    const sum = [0, 0, 0];
    const squares = [0, 0, 0];
    let found = 0;
    for (let p = 0; p < count; p++) {
      const v = starts[p] + 1;
      if (kinds[v] > 5) continue;
      found++;
      for (let a = 0; a < 3; a++) {
        sum[a] += positions[3 * v + a];
        squares[a] += positions[3 * v + a] ** 2;
      }
    }
    if (found < 10) return [...this.data.scene.center, 1, 1, 1].map((v, i) => (i < 3 ? v : this.data.scene.radius));
    const center = sum.map((s) => s / found);
    const spread = squares.map((s, a) => 3.4 * Math.sqrt(Math.max(0, s / found - center[a] ** 2)));
    // At least half as thick as wide: light above a floor is in no flat box.
    const longest = Math.max(...spread, 1e-6 * this.data.scene.radius);
    return [...center, ...spread.map((s) => Math.max(s, 0.5 * longest))].map((v) => +v.toPrecision(6));
  }

  boxAroundProbe(): number[] {
    const center = (this.state.probe ?? this.state.ball ?? this.data.scene.center).slice(0, 3);
    const size = 6 * this.state.reach * this.selection.unit;
    return [...center, size, size, size];
  }

  private showPanel(): void {
    const { state } = this;
    const { pose: _, expression: __, cluster: ___, ...rest } = state;
    if (isSliding()) return;
    if (!this.isNew("panel", rest, this.scale, this.selection.selected.length > MOST_LINES)) return;
    refill(
      byId("tools"),
      ...TOOLS.map((tool, i) =>
        el(
          "button",
          { type: "button", role: "tab", "aria-selected": String(tool === state.tool), "data-tool": tool, title: `${TOOL_NAMES[tool]} (${i + 1})`, onclick: () => this.set({ tool }) },
          TOOL_NAMES[tool],
        ),
      ),
    );
    refill(byId("panel"), ...panelOf(this));
    refill(
      byId("cluster-tools"),
      choice("Clusters by", [["expression", "kind"], ["object", "object"]], state.by, (by) => this.set({ by })),
      choice("Clusters from", [["light", "light"], ["sensor", "sensor"]], state.from, (from) => this.set({ from })),
    );
    refill(
      byId("space-tools"),
      choice("Surfaces", [["solid", "solid"], ["x-ray", "x-ray"], ["hidden", "hidden"]], state.look, (look) => this.set({ look })),
      el("button", { type: "button", title: "Look through the sensor (C)", onclick: () => this.viewSensor() }, "sensor"),
      el("button", { type: "button", title: "The whole scene (F)", onclick: () => this.space.frame() }, "all"),
    );
    refill(
      byId("picture-tools"),
      slider("Exposure", [-8, 8, 0.25], state.exposure, (v) => `${v >= 0 ? "+" : ""}${v.toFixed(1)} EV`, (exposure) => this.set({ exposure })),
      el("button", { type: "button", title: "Fit the image (I)", onclick: () => this.image.fit() }, "fit"),
    );
  }

  viewSensor(): void {
    this.space.viewSensor();
    this.set({ pose: null });
  }

  private describeScene(): void {
    const { scene, paths } = this.data;
    document.title = `${scene.title} · Halflight inspector`;
    byId("title").textContent = scene.title;
    const count = (n: number) => n.toLocaleString("en").replaceAll(",", "\u202f");
    const thinned = scene.mesh.triangles < scene.mesh.of ? ` of ${count(scene.mesh.of)}` : "";
    byId("facts").textContent = [
      `${count(scene.mesh.triangles)}${thinned} triangles`,
      `${count(paths.count)} of ${count(scene.record.found)} paths${scene.record.expression ? ` of ${scene.record.expression}` : ""}`,
      `${scene.image.size.join(" × ")} pixels, ${scene.image.note}`,
    ].join("   ·   ");
  }

  private connect(): void {
    const expression = byId<HTMLInputElement>("expression");
    expression.addEventListener("input", () => this.set({ expression: expression.value, cluster: [] }));
    expression.addEventListener("keydown", (e) => {
      if (e.key === "Enter" || e.key === "Escape") expression.blur();
    });
    byId("clear").addEventListener("click", () => this.clear());
    byId("link").addEventListener("click", () => void this.copyLink());
    const help = byId<HTMLDialogElement>("help");
    fillHelp(help);
    byId("help-button").addEventListener("click", () => help.showModal());
    this.image.onRegion = (region) => this.set({ region, cluster: [] });
    // One pixel has few of the recorded paths, or none: a click takes as many neighbours as it needs for some.
    this.image.onClick = (pixel) => {
      const regions = [0, 1, 2, 3, 5, 8, 12, 18].map((reach) => this.image.around(pixel, reach));
      const region = regions.find((r) => this.selection.countIn(r) >= ENOUGH_PATHS) ?? regions[regions.length - 1];
      this.set({ region, cluster: [] });
    };
    this.image.onHover = (text) => (byId("hover").textContent = text);
    this.space.onCamera = () => this.set({ pose: this.space.pose?.map((v) => +v.toPrecision(6)) ?? null });
    this.space.onPick = (position, normal) => {
      const tiny = 1e-6 * this.data.scene.radius;
      const at = position.map((v) => (Math.abs(v) < tiny ? 0 : +v.toPrecision(6)));
      if (this.state.tool === "plot" || this.state.tool === "volume") {
        this.set({ probe: [...at, ...normal.map((v) => +v.toPrecision(6))], measured: null });
      } else {
        this.set({ ball: at, cluster: [] });
      }
    };
    this.clusters.onSelect = (cluster) => this.set({ cluster });
    this.clusters.onHover = (cluster) => this.hoverCluster(cluster);
    this.paths.onChoose = (path) => {
      this.space.setHighlight(path);
      this.showMarks();
    };
    this.paths.onHover = (path) => this.space.setHighlight(path ?? this.paths.chosen);
    addEventListener("hashchange", () => {
      this.state = fromFragment(location.hash);
      this.fit(this.state);
      this.space.pose = this.state.pose;
      this.update();
    });
    addEventListener("keydown", (e) => onKey(this, e));
    connectSplitter();
  }

  private hoverCluster(cluster: Cluster | null): void {
    byId("hover").textContent = cluster
      ? `${cluster.labels.join(" ")}   ·   ${(cluster.end - cluster.begin).toLocaleString("en")} paths   ·   weight ${short(cluster.weight)}`
      : "";
  }

  private clear(): void {
    this.paths.choose(null);
    byId<HTMLInputElement>("expression").value = "";
    this.set({ expression: "", region: null, ball: null, cluster: [] });
  }

  /** Takes back the last of what was chosen. */
  back(): void {
    const { state } = this;
    if (this.paths.chosen !== null) this.paths.choose(null);
    else if (state.cluster.length > 0) this.set({ cluster: [] });
    else if (state.region || state.ball) this.set({ region: null, ball: null });
    else if (state.expression) this.clear();
  }

  async copyLink(): Promise<void> {
    const hover = byId("hover");
    try {
      await navigator.clipboard.writeText(location.href);
      hover.textContent = "the address is in the clipboard";
    } catch {
      // Browsers keep the clipboard from pages that are files.
      hover.textContent = location.href;
    }
  }
}

function luminances(image: Float32Array): Float32Array {
  const found = new Float32Array(image.length / 3);
  for (let i = 0; i < found.length; i++) found[i] = luminance(image[3 * i], image[3 * i + 1], image[3 * i + 2]);
  return found;
}
