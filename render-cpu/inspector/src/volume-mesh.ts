// A box of voxels, which glow as the scale says.

import * as THREE from "three";
import { MAP, placeOf, type Scale } from "./color.ts";
import type { Volume } from "./measure.ts";

/** The box with its edges; `density` is the optical thickness of the brightest per unit of length. */
export function volumeMeshes(volume: Volume, scale: Scale, density: number): THREE.Object3D[] {
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
  return [mesh, frame];
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
