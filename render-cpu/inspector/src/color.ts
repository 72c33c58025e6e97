// Colours: the tone curve of the command's pictures, its perceptual colour map (render-cpu/src/compare/heatmap.rs), and scales.

/** Transfer function of sRGB. */
export function srgb(linear: number): number {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * Math.pow(linear, 1 / 2.4) - 0.055;
}

/** Identity up to 0.8, then a soft shoulder towards 1. */
export function tone(x: number): number {
  if (!(x > 0)) return 0;
  return x <= 0.8 ? x : 0.8 + 0.2 * (1 - Math.exp(-(x - 0.8) / 0.2));
}

export function luminance(r: number, g: number, b: number): number {
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}

function clamp(x: number): number {
  return Math.min(1, Math.max(0, x));
}

/** A colour of the map as bytes, place 0 to 1: lightness rises evenly in Oklab from blue over magenta and red to yellow. */
function mapColor(place: number): [number, number, number] {
  const t = clamp(place);
  const lightness = 0.13 + 0.84 * t;
  const hue = ((-80 + 185 * t) * Math.PI) / 180;
  const chroma = 0.03 + 0.16 * Math.max(0, Math.sin(Math.PI * Math.pow(t, 0.9)));
  const [a, b] = [chroma * Math.cos(hue), chroma * Math.sin(hue)];
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
  const byte = (linear: number) => Math.round(255 * srgb(clamp(linear)));
  return [
    byte(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
    byte(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
    byte(-0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s),
  ];
}

/** 1024 colours of the map, three bytes each. */
export const MAP: Uint8Array = Uint8Array.from(Array.from({ length: 1024 }, (_, i) => mapColor(i / 1023)).flat());

/** How values become colours. */
export interface Scale {
  least: number;
  most: number;
  isLog: boolean;
}

/** A scale from what is given, the rest by the values: the largest is that which a thousandth of them exceed. */
export function scaleOf(values: Float32Array, least: number | null, most: number | null, isLog: boolean): Scale {
  const sorted = values.filter((v) => Number.isFinite(v)).sort();
  const largest = sorted.length > 0 ? sorted[Math.round((sorted.length - 1) * 0.999)] : 1;
  const top = most ?? (largest > 0 ? largest : 1);
  return { least: Math.min(least ?? (isLog ? top * 1e-4 : 0), top), most: top, isLog };
}

/** Place of a value, 0 for the first colour and 1 for the last. */
export function placeOf(scale: Scale, value: number): number {
  const { least, most, isLog } = scale;
  if (!isLog) return most > least ? clamp((value - least) / (most - least)) : value >= most ? 1 : 0;
  const low = Math.log(Math.max(least, 1e-30));
  const high = Math.log(Math.max(most, 1e-30));
  return high > low ? clamp((Math.log(Math.max(value, 1e-30)) - low) / (high - low)) : value >= most ? 1 : 0;
}

/** The value at a place. */
export function valueAt(scale: Scale, place: number): number {
  if (!scale.isLog) return scale.least + (scale.most - scale.least) * place;
  const least = Math.max(scale.least, 1e-30);
  return least * Math.pow(scale.most / least, place);
}

/** Three digits of a number. */
export function short(value: number): string {
  if (value === 0) return "0";
  if (!Number.isFinite(value)) return String(value);
  const digits = 2 - Math.floor(Math.log10(Math.abs(value)));
  if (digits >= 0 && digits <= 5) return value.toFixed(digits);
  return digits < 0 && digits >= -3 ? value.toFixed(0) : value.toExponential(2);
}

/** Colours of clusters that red-green blindness leaves apart (after Okabe and Ito 2008); the last for all others. */
export const CLUSTER_COLORS: [number, number, number][] = [
  [255, 176, 32],
  [86, 180, 233],
  [64, 200, 150],
  [240, 228, 90],
  [226, 106, 60],
  [214, 135, 190],
  [120, 140, 255],
  [170, 176, 186],
];

export function clusterColor(index: number): [number, number, number] {
  return CLUSTER_COLORS[Math.min(index, CLUSTER_COLORS.length - 1)];
}

export function css(color: readonly number[]): string {
  return `rgb(${color.join(" ")})`;
}
