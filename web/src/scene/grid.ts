/** The grid on the ground, of tenths of a metre, fading out; as a shader, or as lines where pixels are dear. */
import {
  BufferGeometry,
  Color,
  DoubleSide,
  Float32BufferAttribute,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  type Object3D,
  PlaneGeometry,
  ShaderMaterial,
} from "three";
import type { Quality } from "./quality";

/** How far the grid reaches [m]. */
export const REACH = 4;

export interface GridColours {
  line: string;
  x: string;
  y: string;
}

export interface Grid {
  readonly object: Object3D;
  paint: (colours: GridColours) => void;
  dispose: () => void;
}

export function gridFor(quality: Quality): Grid {
  return quality === "high" ? shadedGrid() : lineGrid();
}

// ---- on a GPU -----------------------------------------------------------------------

const VERTEX = /* glsl */ `
  varying vec2 place;
  void main() {
    place = position.xy;
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  }
`;

// lines one pixel wide at any distance; where they would run together they fade
const FRAGMENT = /* glsl */ `
  uniform vec3 line, axisX, axisY;
  varying vec2 place;

  float lines(float size) {
    vec2 cell = place / size;
    vec2 width = fwidth(cell);
    vec2 near = abs(fract(cell - 0.5) - 0.5) / max(width, 1e-6);
    vec2 sharp = (1.0 - min(near, 1.0)) * (1.0 - smoothstep(0.15, 0.5, width));
    return max(sharp.x, sharp.y);
  }

  void main() {
    float fade = 1.0 - smoothstep(0.25, 1.0, length(place) / ${REACH.toFixed(1)});
    float alpha = max(0.45 * lines(0.1), lines(0.5));
    vec2 middle = 1.0 - min(abs(place) / max(fwidth(place) * 1.2, 1e-6), 1.0);
    vec3 colour = mix(line, axisX, middle.y);
    colour = mix(colour, axisY, middle.x * (1.0 - middle.y));
    alpha = max(alpha, 0.8 * max(middle.x, middle.y));
    gl_FragColor = vec4(colour, alpha * fade * fade);
    #include <colorspace_fragment>
  }
`;

function shadedGrid(): Grid {
  const uniforms = {
    line: { value: new Color() },
    axisX: { value: new Color() },
    axisY: { value: new Color() },
  };
  const material = new ShaderMaterial({
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    uniforms,
    transparent: true,
    depthWrite: false,
    side: DoubleSide,
  });
  const geometry = new PlaneGeometry(2 * REACH, 2 * REACH);
  return {
    object: new Mesh(geometry, material),
    paint: ({ line, x, y }) => {
      uniforms.line.value.set(line);
      uniforms.axisX.value.set(x);
      uniforms.axisY.value.set(y);
    },
    dispose: () => {
      geometry.dispose();
      material.dispose();
    },
  };
}

// ---- without one --------------------------------------------------------------------

/** Between lines, and the length of the pieces that they fade in [m]. */
const SPACING = 0.25;

function lineGrid(): Grid {
  const positions: number[] = [];
  const count = REACH / SPACING;
  for (let i = -count; i <= count; i++) {
    for (let j = -count; j < count; j++) {
      const [line, from, to] = [i * SPACING, j * SPACING, (j + 1) * SPACING];
      if (Math.hypot(line, Math.min(Math.abs(from), Math.abs(to))) > REACH) continue;
      positions.push(from, line, 0, to, line, 0, line, from, 0, line, to, 0);
    }
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new Float32BufferAttribute(positions, 3));
  const material = new LineBasicMaterial({
    vertexColors: true,
    transparent: true,
    depthWrite: false,
    toneMapped: false,
  });
  return {
    object: new LineSegments(geometry, material),
    paint: (colours) => {
      geometry.setAttribute("color", lineColours(positions, colours));
    },
    dispose: () => {
      geometry.dispose();
      material.dispose();
    },
  };
}

/** Return colours with alpha for the ends of pieces: those on an axis have the axis's. */
function lineColours(positions: readonly number[], colours: GridColours) {
  const [line, x, y] = [colours.line, colours.x, colours.y].map(
    (one) => new Color(one),
  );
  const values: number[] = [];
  for (let i = 0; i < positions.length; i += 6) {
    const [ax = 0, ay = 0, , bx = 0, by = 0] = positions.slice(i, i + 6);
    const onX = ay === 0 && by === 0;
    const onY = ax === 0 && bx === 0;
    const colour = (onX ? x : onY ? y : line) ?? new Color();
    for (const reach of [Math.hypot(ax, ay), Math.hypot(bx, by)]) {
      const fade = Math.max(0, 1 - reach / REACH) ** 1.5;
      values.push(colour.r, colour.g, colour.b, fade * (onX || onY ? 0.8 : 1));
    }
  }
  return new Float32BufferAttribute(values, 4);
}
