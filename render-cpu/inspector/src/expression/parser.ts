// Reads path expressions in both notations, with the grammar and the messages of render-cpu/src/expression/parser.rs: a test in
// a browser compares the two on random expressions and on mistakes.

import * as s from "./syntax.ts";
import type { Atom, NameKind, NamePattern, Node, VertexTest } from "./syntax.ts";
import { ExpressionError } from "./syntax.ts";

const MAX_DEPTH = 64;
const MAX_REPEAT = 64;
const MAX_OPERATORS = 4;
const MAX_LENGTH = 4096;

/** The syntax tree of an expression, read from the light whatever the notation. Throws the first mistake. */
export function parse(text: string): Node {
  const chars = Array.from(text);
  if (chars.length > MAX_LENGTH) {
    throw new ExpressionError(MAX_LENGTH, `more than ${MAX_LENGTH} characters`);
  }
  const first = chars.find((c) => !isSpace(c) && c !== "(");
  if (first === undefined) {
    const message = "an expression begins with L, from the light, or with C, from the camera";
    throw new ExpressionError(chars.length, message);
  }
  const parser = new Parser(chars, first === "C");
  const node = parser.choice();
  parser.skipSpace();
  if (parser.peek() !== undefined) throw parser.error("this ) closes nothing");
  return first === "C" ? s.reversed(node) : node;
}

function isSpace(c: string): boolean {
  return /^\s$/u.test(c);
}

function isDigit(c: string | undefined): boolean {
  return c !== undefined && c >= "0" && c <= "9";
}

class Parser {
  private at = 0;
  private depth = 0;

  constructor(
    private readonly chars: string[],
    private readonly fromCamera: boolean,
  ) {}

  error(message: string, at = this.at): ExpressionError {
    return new ExpressionError(at, message);
  }

  peek(): string | undefined {
    return this.chars[this.at];
  }

  skipSpace(): void {
    for (let c = this.peek(); c !== undefined && isSpace(c); c = this.peek()) this.at++;
  }

  private take(c: string): boolean {
    const isNext = this.peek() === c;
    if (isNext) this.at++;
    return isNext;
  }

  choice(): Node {
    const nodes = [this.sequence()];
    while (this.take("|")) nodes.push(this.sequence());
    return nodes.length === 1 ? nodes[0] : { type: "choice", nodes };
  }

  private sequence(): Node {
    const nodes: Node[] = [];
    for (;;) {
      this.skipSpace();
      const c = this.peek();
      if (c === undefined || c === "|" || c === ")") return { type: "sequence", nodes };
      nodes.push(this.repeat());
    }
  }

  private repeat(): Node {
    let node = this.primary();
    for (let i = 0; i <= MAX_OPERATORS; i++) {
      this.skipSpace();
      const start = this.at;
      let least = 0;
      let most: number | null = null;
      switch (this.peek()) {
        case "*":
          break;
        case "+":
          least = 1;
          break;
        case "?":
          most = 1;
          break;
        case "{":
          [least, most] = this.counts();
          break;
        default:
          return node;
      }
      if (most !== 1 && node.type === "atom" && s.isEnd(node.atom)) {
        const message = "a path has one light and one sensor, which do not repeat; .* stands for any vertices";
        throw this.error(message, start);
      }
      this.at++;
      node = { type: "repeat", node, least, most };
    }
    throw this.error("too many repetitions of the same");
  }

  /** `{n,m}` up to its last brace. */
  private counts(): [number, number | null] {
    const start = this.at;
    this.at++;
    this.skipSpace();
    const low = this.number();
    this.skipSpace();
    const isRange = this.take(",");
    let high = low;
    if (isRange) {
      this.skipSpace();
      high = this.number();
    }
    this.skipSpace();
    if (this.peek() !== "}" || (low === null && high === null)) {
      throw this.error("expected {n}, {n,}, {,m} or {n,m}; a region stands right behind its letter", start);
    }
    const least = low ?? 0;
    const most = isRange ? high : least;
    if (most !== null && most < least) {
      throw this.error("the first number is larger than the second", start);
    }
    if ((most ?? least) > MAX_REPEAT) {
      throw this.error(`at most ${MAX_REPEAT} repetitions can be counted`, start);
    }
    return [least, most];
  }

  private number(): number | null {
    const start = this.at;
    while (isDigit(this.peek())) this.at++;
    if (start === this.at) return null;
    const number = Number(this.chars.slice(start, this.at).join(""));
    if (number > MAX_REPEAT) throw this.error(`at most ${MAX_REPEAT} repetitions can be counted`, start);
    return number;
  }

  private primary(): Node {
    const start = this.at;
    switch (this.peek()) {
      case "(": {
        this.at++;
        this.depth++;
        if (this.depth > MAX_DEPTH) throw this.error("parentheses are nested too deeply", start);
        const node = this.choice();
        if (!this.take(")")) throw this.error("this ( is not closed", start);
        this.depth--;
        return node;
      }
      case "[":
        return { type: "atom", atom: this.set() };
      case "*":
      case "+":
      case "?":
      case "{":
        throw this.error("there is nothing to repeat");
      default: {
        const test = this.vertex();
        this.suffixes(test);
        return { type: "atom", atom: { tests: [test], isNegated: false } };
      }
    }
  }

  /** `[...]`, a set of vertices. */
  private set(): Atom {
    const start = this.at;
    this.at++;
    const isNegated = this.take("^");
    const tests: VertexTest[] = [];
    for (;;) {
      this.skipSpace();
      const c = this.peek();
      if (c === undefined) throw this.error("this [ is not closed", start);
      if (c === "]") break;
      const test = this.vertex();
      this.superscript(test);
      tests.push(test);
    }
    this.at++;
    if (tests.length === 0) throw this.error("this set is empty", start);
    return { tests, isNegated };
  }

  /** A letter, a dot or `<...>`. */
  private vertex(): VertexTest {
    const start = this.at;
    const c = this.peek();
    if (c === undefined) throw this.error("something is missing here");
    if (c === "<") return this.labelled();
    const test = this.letter(c);
    if (test === null) throw this.unknown(c);
    if (c === (this.fromCamera ? "E" : "C")) {
      const message = this.fromCamera
        ? "E is the sensor in expressions from the light; from the camera it is C"
        : "C begins an expression from the camera; from the light the sensor is E";
      throw this.error(message, start);
    }
    this.at++;
    return test;
  }

  private letter(c: string): VertexTest | null {
    const kinds: Record<string, number> = {
      ".": s.ANY,
      L: s.LIGHT,
      O: s.LIGHT,
      B: s.LIGHT,
      E: s.SENSOR,
      C: s.SENSOR,
      D: s.DIFFUSE,
      G: s.GLOSSY,
      S: s.SPECULAR,
      X: s.SURFACE,
      R: s.REFLECTED,
      T: s.TRANSMITTED,
    };
    if (!Object.hasOwn(kinds, c)) return null;
    const test = s.testOf(kinds[c]);
    if (c === "O") test.lights = s.OBJECT_LIGHT;
    if (c === "B") test.lights = s.BACKGROUND_LIGHT;
    return test;
  }

  private unknown(c: string): ExpressionError {
    if (c === "V") return this.error("volumes scatter nothing here, so that no path has a V");
    if (c === "s") return this.error("what passes straight through a mask is no vertex");
    const end = this.fromCamera ? "C (camera)" : "E (sensor)";
    return this.error(`'${/['"\\]/.test(c) ? `\\${c}` : c}' is none of L O B (light), D G S X (surface), R T, . and ${end}`);
  }

  /** `<` type, scattering, labels `>`. */
  private labelled(): VertexTest {
    const start = this.at;
    this.at++;
    const test = s.testOf(s.ANY);
    this.skipSpace();
    if (this.peek() === ">") throw this.error("nothing stands between < and >; any vertex is .", start);
    for (let part = 0; part < 2; part++) {
      this.skipSpace();
      const here = this.at;
      const c = this.peek();
      if (c === undefined) throw this.error("this < is not closed", start);
      if (c === ">" || c === "'" || c === '"') break;
      if (c === "[") {
        const set = this.set();
        if (set.tests.some((t) => t.names.length > 0)) {
          throw this.error("labels stand behind both letters", here);
        }
        const union = set.tests.reduce((kinds, t) => kinds | t.kinds, 0);
        test.kinds &= set.isNegated ? ~union : union;
        continue;
      }
      const own = (part === 0 ? "RTLOBCE." : "DGS.").includes(c) ? this.letter(c) : null;
      if (own === null) {
        if (c === "V" || c === "s") throw this.unknown(c);
        throw this.error(part === 0 ? "expected one of R T L O B C . first" : "expected one of D G S . second");
      }
      test.kinds &= own.kinds;
      test.lights &= own.lights;
      this.at++;
    }
    for (;;) {
      this.skipSpace();
      const c = this.peek();
      if (c === undefined) throw this.error("this < is not closed", start);
      if (c === ">") break;
      if (c === ".") {
        this.at++;
      } else if (c === "'" || c === '"') {
        const [name, here] = this.quoted();
        test.names.push({ patterns: [this.pattern(name, here)], isNegated: false });
      } else {
        throw this.error("expected a label in quotes, or >");
      }
    }
    this.at++;
    if (test.kinds === 0) throw this.error("no vertex is both", start);
    return test;
  }

  /** What may stand right behind a letter. */
  private suffixes(test: VertexTest): void {
    for (;;) {
      this.superscript(test);
      const behind = this.chars[this.at + 1];
      const c = this.peek();
      if (c === "[" && !this.fromCamera) {
        this.names(test);
      } else if (c === "{" && behind !== undefined && !isDigit(behind) && behind !== "," && behind !== " ") {
        this.region(test);
      } else {
        return;
      }
    }
  }

  /** `^R` or `^T`. */
  private superscript(test: VertexTest): void {
    const start = this.at;
    if (!this.take("^")) return;
    const side = this.peek();
    if (side !== "R" && side !== "T") throw this.error("expected R or T behind ^");
    test.kinds &= side === "R" ? s.REFLECTED : s.TRANSMITTED;
    if (test.kinds === 0) throw this.error("no vertex is both", start);
    this.at++;
  }

  /** `[name, ...]` behind a letter. */
  private names(test: VertexTest): void {
    const start = this.at;
    if (test.kinds === s.SENSOR) throw this.error("the sensor has no names");
    this.at++;
    const isNegated = this.take("^");
    const patterns: NamePattern[] = [];
    for (;;) {
      this.skipSpace();
      let here = this.at;
      let name: string;
      const c = this.peek();
      if (c === undefined) throw this.error("this [ is not closed", start);
      if (c === "'" || c === '"') {
        [name, here] = this.quoted();
      } else if (c === "^") {
        throw this.error("^ stands once, before all names: none of them is meant");
      } else {
        for (let n = this.peek(); n !== undefined && n !== "]" && n !== ","; n = this.peek()) this.at++;
        name = this.chars.slice(here, this.at).join("").trim();
      }
      patterns.push(this.pattern(name, here));
      this.skipSpace();
      const next = this.peek();
      if (next === undefined) throw this.error("this [ is not closed", start);
      if (next === "]") break;
      if (next !== ",") throw this.error("expected , or ] behind the name");
      this.at++;
    }
    this.at++;
    test.names.push({ patterns, isNegated });
  }

  /** Text in quotes, and where it begins. */
  private quoted(): [string, number] {
    const start = this.at;
    const end = this.chars.indexOf(this.chars[start], start + 1);
    if (end < 0) throw this.error("this quote is not closed");
    this.at = end + 1;
    return [this.chars.slice(start + 1, end).join(""), start + 1];
  }

  private pattern(name: string, at: number): NamePattern {
    let kind: NameKind = "any";
    let glob = name;
    for (const prefixed of ["object", "material", "emitter"] as const) {
      if (name.startsWith(`${prefixed}:`)) {
        kind = prefixed;
        glob = name.slice(prefixed.length + 1).trimStart();
        break;
      }
    }
    if (glob === "") throw this.error("expected a name", at);
    return { kind, glob, at };
  }

  /** `{name}` behind a letter. */
  private region(test: VertexTest): void {
    const start = this.at;
    if ((test.kinds & ~s.SURFACE) !== 0) {
      throw this.error("regions are of vertices on surfaces: D, G, S or X");
    }
    this.at++;
    let name: string;
    let here = this.at;
    const c = this.peek();
    if (c === "'" || c === '"') {
      [name, here] = this.quoted();
    } else {
      for (let n = this.peek(); n !== undefined && n !== "}"; n = this.peek()) this.at++;
      name = this.chars.slice(here, this.at).join("").trim();
    }
    if (!this.take("}")) throw this.error("this { is not closed", start);
    if (name === "") throw this.error("expected the name of a region", here);
    test.regions.push({ name, at: here });
  }
}
