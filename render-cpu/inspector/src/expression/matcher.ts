// Which of many recorded paths an expression matches: a nondeterministic automaton of the expression, made deterministic as
// far as the paths need it. Vertices of one kind on one object (and in the same regions) are one letter, so that a path costs one
// look-up per vertex.

import type { PathData, SceneData } from "../data.ts";
import { VERTEX_BACKGROUND, VERTEX_LIGHT, VERTEX_SENSOR, lettersOf } from "../data.ts";
import { parse } from "./parser.ts";
import * as s from "./syntax.ts";
import type { Atom, NamePattern, Node } from "./syntax.ts";
import { ExpressionError } from "./syntax.ts";

const MAX_STATES = 20000;
const MAX_REGIONS = 8;

/** What atoms ask of a vertex. */
interface Letter {
  kinds: number;
  lights: number;
  object: string;
  material: string;
  emitter: string;
  inside: number;
}

/** That nothing has a name. */
function nothingNamed(pattern: NamePattern): string {
  const what = pattern.kind === "any" ? "nothing" : `no ${pattern.kind}`;
  const before = pattern.glob.split(":")[0];
  const isUnknown =
    pattern.kind === "any" && pattern.glob.includes(":") && !["object", "material", "emitter"].includes(before);
  const hint = isUnknown ? "; before a colon stands object, material or emitter" : "";
  return `the scene has ${what} named "${pattern.glob}"${hint}`;
}

/** An automaton with steps over letters and steps over nothing. */
class Nfa {
  readonly atoms: (Atom | null)[] = [];
  readonly next: number[] = [];
  readonly free: number[][] = [];

  private state(): number {
    if (this.atoms.length >= MAX_STATES) throw new ExpressionError(0, "this expression is too complex");
    this.atoms.push(null);
    this.next.push(-1);
    this.free.push([]);
    return this.atoms.length - 1;
  }

  /** Adds what leads through a node to `end`; returns where it begins. */
  add(node: Node, end: number): number {
    switch (node.type) {
      case "atom": {
        const state = this.state();
        this.atoms[state] = node.atom;
        this.next[state] = end;
        return state;
      }
      case "sequence":
        return node.nodes.reduceRight((behind, part) => this.add(part, behind), end);
      case "choice": {
        const state = this.state();
        for (const part of node.nodes) this.free[state].push(this.add(part, end));
        return state;
      }
      case "repeat": {
        let begin = end;
        if (node.most === null) {
          begin = this.state();
          this.free[begin].push(end, this.add(node.node, begin));
        } else {
          for (let i = node.least; i < node.most; i++) {
            const optional = this.state();
            this.free[optional].push(end, this.add(node.node, begin));
            begin = optional;
          }
        }
        for (let i = 0; i < node.least; i++) begin = this.add(node.node, begin);
        return begin;
      }
    }
  }

  end(): number {
    return this.state();
  }

  /** All states that are reached without a letter, in order. */
  closure(states: Iterable<number>): number[] {
    const found = new Set<number>();
    const stack = [...states];
    for (let state = stack.pop(); state !== undefined; state = stack.pop()) {
      if (found.has(state)) continue;
      found.add(state);
      stack.push(...this.free[state]);
    }
    return [...found].sort((a, b) => a - b);
  }
}

/** An expression over the paths of a scene. */
export class Matcher {
  private readonly nfa = new Nfa();
  private readonly end: number;
  private readonly states: number[][] = [];
  private readonly known = new Map<string, number>();
  private readonly table: Int32Array[] = [];
  private readonly accepting: boolean[] = [];
  private readonly regions: { name: string; toUnit: number[]; isBall: boolean }[] = [];
  private readonly patterns = new Map<string, RegExp>();

  /** Throws an ExpressionError for a mistake. */
  constructor(
    text: string,
    private readonly scene: SceneData,
  ) {
    const tree = parse(text);
    this.check(tree);
    this.end = this.nfa.end();
    this.intern(this.nfa.closure([this.nfa.add(tree, this.end)]));
  }

  /** Names and regions must be there. */
  private check(node: Node): void {
    if (node.type === "repeat") {
      if (node.most !== 0) this.check(node.node);
      return;
    }
    if (node.type !== "atom") return node.nodes.forEach((n) => this.check(n));
    for (const test of node.atom.tests) {
      for (const pattern of test.names.flatMap((n) => n.patterns)) {
        const key = pattern.glob;
        if (!this.patterns.has(key)) this.patterns.set(key, globExpression(key));
        if (!/[*?]/.test(key) && !this.exists(pattern)) {
          throw new ExpressionError(pattern.at, nothingNamed(pattern));
        }
      }
      for (const { name, at } of test.regions) {
        if (this.regions.some((r) => r.name === name)) continue;
        const region = Object.hasOwn(this.scene.regions, name) ? this.scene.regions[name] : undefined;
        if (!region) throw new ExpressionError(at, `the scene has no shape "${name}" for a region`);
        if (this.regions.length === MAX_REGIONS) throw new ExpressionError(at, `more than ${MAX_REGIONS} regions`);
        this.regions.push({ name, toUnit: region.to_unit, isBall: region.kind === 1 });
      }
    }
  }

  private exists(pattern: NamePattern): boolean {
    const { names, emitters } = this.scene;
    const is = (kind: string) => pattern.kind === "any" || pattern.kind === kind;
    const any = (list: string[]) => list.includes(pattern.glob);
    return (
      (is("object") && (any(names.shapes) || any(names.instances) || any(emitters.map((e) => e.object)))) ||
      (is("material") && any(names.materials)) ||
      (is("emitter") && any(names.emitters))
    );
  }

  private fits(pattern: NamePattern, letter: Letter): boolean {
    const expression = this.patterns.get(pattern.glob)!;
    const own = (name: string) => name !== "" && expression.test(name);
    switch (pattern.kind) {
      case "any":
        return own(letter.object) || own(letter.material) || own(letter.emitter);
      default:
        return own(letter[pattern.kind]);
    }
  }

  private accepts(atom: Atom, letter: Letter): boolean {
    const holds = atom.tests.some(
      (test) =>
        (test.kinds & letter.kinds) !== 0 &&
        (letter.kinds !== s.LIGHT || (test.lights & letter.lights) !== 0) &&
        test.names.every((n) => n.patterns.some((p) => this.fits(p, letter)) !== n.isNegated) &&
        test.regions.every((r) => ((letter.inside >> this.regions.findIndex((o) => o.name === r.name)) & 1) !== 0),
    );
    return holds !== atom.isNegated;
  }

  private intern(states: number[]): number {
    const key = states.join();
    const old = this.known.get(key);
    if (old !== undefined) return old;
    if (this.states.length >= MAX_STATES) throw new ExpressionError(0, "this expression is too complex");
    this.known.set(key, this.states.length);
    this.states.push(states);
    this.accepting.push(states.includes(this.end));
    return this.states.length - 1;
  }

  /** Bits of the regions that a point lies in. */
  private inside(x: number, y: number, z: number): number {
    let bits = 0;
    this.regions.forEach(({ toUnit: m, isBall }, i) => {
      const u = m[0] * x + m[1] * y + m[2] * z + m[3];
      const v = m[4] * x + m[5] * y + m[6] * z + m[7];
      const w = m[8] * x + m[9] * y + m[10] * z + m[11];
      const isIn = isBall ? u * u + v * v + w * w <= 1 : Math.max(Math.abs(u), Math.abs(v), Math.abs(w)) <= 1;
      if (isIn) bits |= 1 << i;
    });
    return bits;
  }

  private letter(kind: number, object: number, inside: number): Letter {
    const { names, emitters, shapes } = this.scene;
    if (kind === VERTEX_SENSOR) {
      return { kinds: s.SENSOR, lights: 0, object: "", material: "", emitter: "", inside: 0 };
    }
    if (kind === VERTEX_LIGHT || kind === VERTEX_BACKGROUND) {
      const { object: of, kind: light } = emitters[object];
      const lights = light === "O" ? s.OBJECT_LIGHT : light === "B" ? s.BACKGROUND_LIGHT : s.OTHER_LIGHT;
      return { kinds: s.LIGHT, lights, object: of, material: "", emitter: names.emitters[object] ?? "", inside: 0 };
    }
    const material = shapes[object].material;
    return { kinds: 1 << kind, lights: 0, object: names.shapes[object] ?? "", material, emitter: "", inside };
  }

  /** The letter of each vertex: its kind and object, and the regions that it lies in if the expression asks for some. */
  private word(paths: PathData): { word: Uint32Array; letters: Letter[] } {
    const plain = lettersOf(paths);
    if (this.regions.length === 0) {
      return { word: plain.word, letters: plain.kinds.map((kind, i) => this.letter(kind, plain.objects[i], 0)) };
    }
    const { positions } = paths;
    const word = new Uint32Array(plain.word.length);
    const letters: Letter[] = [];
    const numbers = new Map<number, number>();
    for (let v = 0; v < word.length; v++) {
      const kind = plain.kinds[plain.word[v]];
      const inside = kind < VERTEX_LIGHT ? this.inside(positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]) : 0;
      const key = plain.word[v] * 256 + inside;
      let number = numbers.get(key);
      if (number === undefined) {
        number = letters.length;
        numbers.set(key, number);
        letters.push(this.letter(kind, plain.objects[plain.word[v]], inside));
      }
      word[v] = number;
    }
    return { word, letters };
  }

  /** 1 for each path that matches. */
  match(paths: PathData): Uint8Array {
    const { count, starts } = paths;
    const { word, letters } = this.word(paths);
    this.table.length = 0;
    const matched = new Uint8Array(count);
    for (let p = 0; p < count; p++) {
      let state = 0;
      // From the light, which is the last vertex.
      for (let v = starts[p + 1] - 1; v >= starts[p]; v--) {
        const row = (this.table[state] ??= new Int32Array(letters.length).fill(-1));
        let next = row[word[v]];
        if (next < 0) {
          const letter = letters[word[v]];
          const reached = this.states[state]
            .filter((n) => this.nfa.atoms[n] !== null && this.accepts(this.nfa.atoms[n]!, letter))
            .map((n) => this.nfa.next[n]);
          next = this.intern(this.nfa.closure(reached));
          row[word[v]] = next;
        }
        state = next;
        if (this.states[state].length === 0) break;
      }
      matched[p] = this.accepting[state] ? 1 : 0;
    }
    return matched;
  }
}

function globExpression(glob: string): RegExp {
  const escaped = Array.from(glob).map((c) =>
    c === "*" ? ".*" : c === "?" ? "." : c.replace(/[\\^$.*+?()[\]{}|/-]/, "\\$&"),
  );
  return new RegExp(`^${escaped.join("")}$`, "su");
}
