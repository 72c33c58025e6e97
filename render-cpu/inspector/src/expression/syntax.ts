// The syntax tree of a path expression, as in render-cpu/src/expression/syntax.rs: kinds of vertices are bits of one number.

/** Kinds of scattering: D^R, D^T, G^R, G^T, S^R, S^T are the bits 0 to 5. */
export const DIFFUSE = 0b000011;
export const GLOSSY = 0b001100;
export const SPECULAR = 0b110000;
export const SURFACE = DIFFUSE | GLOSSY | SPECULAR;
export const REFLECTED = 0b010101;
export const TRANSMITTED = 0b101010;
export const LIGHT = 1 << 6;
export const SENSOR = 1 << 7;
export const ANY = SURFACE | LIGHT | SENSOR;

/** Kinds of emitters: of a surface, from infinity on all sides, others. */
export const OBJECT_LIGHT = 1;
export const BACKGROUND_LIGHT = 2;
export const OTHER_LIGHT = 4;
export const ANY_LIGHT = 7;

/** Names of what a pattern is for. */
export type NameKind = "any" | "object" | "material" | "emitter";

/** A pattern of names with * and ?, and where it stands in the text. */
export interface NamePattern {
  kind: NameKind;
  glob: string;
  at: number;
}

/** One of the patterns must fit, or none of them. */
export interface NameTest {
  patterns: NamePattern[];
  isNegated: boolean;
}

/** A set of vertices. */
export interface VertexTest {
  kinds: number;
  lights: number;
  names: NameTest[];
  regions: { name: string; at: number }[];
}

/** Vertices that some test accepts, or that none accepts. */
export interface Atom {
  tests: VertexTest[];
  isNegated: boolean;
}

/** A node of the tree, read from the light. */
export type Node =
  | { type: "atom"; atom: Atom }
  | { type: "sequence"; nodes: Node[] }
  | { type: "choice"; nodes: Node[] }
  | { type: "repeat"; node: Node; least: number; most: number | null };

/** All vertices of some kinds. */
export function testOf(kinds: number): VertexTest {
  return { kinds, lights: ANY_LIGHT, names: [], regions: [] };
}

/** Whether an atom stands for ends of paths alone, which are no more than one each. */
export function isEnd(atom: Atom): boolean {
  return !atom.isNegated && atom.tests.every((test) => (test.kinds & SURFACE) === 0);
}

/** The same read from the other end. */
export function reversed(node: Node): Node {
  switch (node.type) {
    case "atom":
      return node;
    case "sequence":
      return { type: "sequence", nodes: node.nodes.map(reversed).reverse() };
    case "choice":
      return { type: "choice", nodes: node.nodes.map(reversed) };
    case "repeat":
      return { ...node, node: reversed(node.node) };
  }
}

/** A mistake, behind `position` characters of the text. */
export class ExpressionError extends Error {
  constructor(
    readonly position: number,
    message: string,
  ) {
    super(message);
  }
}
