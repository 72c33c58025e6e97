// Where the page begins.

import { readData } from "./data.ts";
import { byId } from "./dom.ts";
import { ScriptedInspector } from "./scripts.ts";

declare global {
  interface Window {
    /** For scripts; there once everything is shown. */
    halflight?: ScriptedInspector;
  }
}

async function begin(): Promise<void> {
  const data = await readData();
  const inspector = new ScriptedInspector(data);
  byId("app").setAttribute("aria-busy", "false");
  byId("loading").hidden = true;
  window.halflight = inspector;
}

begin().catch((error: unknown) => {
  const box = byId("loading");
  box.className = "wrong";
  box.textContent = error instanceof Error ? error.message : String(error);
  throw error;
});
