// Elements without a library: what this page needs of one is these few lines.

type Child = Node | string | null | false;

/** An element with properties, listeners ("onclick" and so on) and attributes ("aria-..", "data-.."), and what is in it. */
export function el<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  properties: Record<string, unknown> = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (value === undefined || value === null) continue;
    if (name === "class") element.className = String(value);
    else if (name === "style") element.style.cssText = String(value);
    else if (name.includes("-") || name === "role" || name === "for") element.setAttribute(name, String(value));
    else (element as unknown as Record<string, unknown>)[name] = value;
  }
  element.append(...children.filter((c): c is Node | string => c !== null && c !== false));
  return element;
}

export function byId<T extends HTMLElement = HTMLElement>(id: string): T {
  const element = document.getElementById(id);
  if (!element) throw new Error(`there is no element ${id}`);
  return element as T;
}

/** A row of a panel: a name and what sets it. */
export function row(name: string, ...controls: Child[]): HTMLElement {
  return el("div", { class: "row" }, el("span", { class: "name" }, name), el("span", { class: "control" }, ...controls));
}

/** Buttons of which one is pressed. */
export function choice<T extends string>(
  label: string,
  values: readonly (readonly [T, string])[],
  chosen: T,
  set: (value: T) => void,
): HTMLElement {
  const buttons = values.map(([value, text]) =>
    el("button", { type: "button", "aria-pressed": String(value === chosen), "data-value": value, onclick: () => set(value) }, text),
  );
  return el("span", { class: "choice", role: "group", "aria-label": label }, ...buttons);
}

export function check(label: string, isOn: boolean, set: (isOn: boolean) => void): HTMLElement {
  const input = el("input", { type: "checkbox", checked: isOn });
  input.addEventListener("change", () => set(input.checked));
  return el("label", { class: "check" }, input, label);
}

let held: HTMLInputElement | null = null;
addEventListener("pointerup", () => (held = null));

/** Whether a slider is being dragged: it must not be replaced meanwhile. */
export function isSliding(): boolean {
  return held !== null;
}

/** What tells a control from others of its panel. */
function nameOf(control: Element): string {
  const own = control.getAttribute("data-value") ?? control.getAttribute("data-tool") ?? control.getAttribute("aria-label");
  const group = control.closest("[role=group]")?.getAttribute("aria-label") ?? "";
  return `${group}/${own ?? control.parentElement?.textContent ?? ""}`;
}

/** Replaces what is in an element; where the focus was in it, it goes to the control of the same name. */
export function refill(element: HTMLElement, ...children: Child[]): void {
  const focused = element.contains(document.activeElement) ? nameOf(document.activeElement!) : null;
  element.replaceChildren(...children.filter((c): c is Node | string => c !== null && c !== false));
  if (focused === null) return;
  const same = [...element.querySelectorAll<HTMLElement>("button, input")].find((c) => nameOf(c) === focused);
  same?.focus();
}

/** A slider with its value as text behind it. */
export function slider(
  label: string,
  [low, high, step]: [number, number, number],
  value: number,
  show: (value: number) => string,
  set: (value: number) => void,
): HTMLElement {
  const text = el("output", {}, show(value));
  const input = el("input", { type: "range", min: String(low), max: String(high), step: String(step), value: String(value), "aria-label": label });
  input.addEventListener("pointerdown", () => (held = input));
  input.addEventListener("input", () => {
    text.textContent = show(Number(input.value));
    set(Number(input.value));
  });
  return el("span", { class: "slider" }, input, text);
}

/** A number that may be left out. */
export function numberField(label: string, value: number | null, placeholder: string, set: (value: number | null) => void): HTMLElement {
  const input = el("input", { type: "text", inputMode: "decimal", value: value === null ? "" : String(value), placeholder, "aria-label": label, class: "number" });
  input.addEventListener("change", () => {
    const number = input.value.trim() === "" ? null : Number(input.value);
    const isGood = number === null || Number.isFinite(number);
    input.classList.toggle("wrong", !isGood);
    if (isGood) set(number);
  });
  return input;
}
