/** How much the graphics may cost: soft shadows on a GPU, plain shading without one. */
import { signal } from "@preact/signals";
import { recall, remember } from "../ui/memory";

export type Quality = "low" | "high";

const QUALITIES = ["low", "high"] as const;
/** Renderers that draw on the CPU name themselves so. */
const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;

/** Return what suits the renderer of this name. */
export function qualityFor(renderer: string): Quality {
  return SOFTWARE.test(renderer) ? "low" : "high";
}

/** Return the name of what draws, or undefined where there is no WebGL. */
function rendererName(): string | undefined {
  const gl = document.createElement("canvas").getContext("webgl2");
  if (!gl) return undefined;
  const extension = gl.getExtension("WEBGL_debug_renderer_info");
  const name: unknown = gl.getParameter(
    extension ? extension.UNMASKED_RENDERER_WEBGL : gl.RENDERER,
  );
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  return String(name);
}

function wanted(search: string): Quality | undefined {
  const asked = new URLSearchParams(search).get("quality");
  return QUALITIES.find((one) => one === asked) ?? recall("quality", QUALITIES);
}

/** Null where there is no WebGL. */
export const quality = signal<Quality | null>(initial());

function initial(): Quality | null {
  const name = rendererName();
  if (name === undefined) return null;
  return wanted(window.location.search) ?? qualityFor(name);
}

/** Choose for this visit and the next. */
export function chooseQuality(chosen: Quality): void {
  quality.value = chosen;
  remember("quality", chosen);
}
