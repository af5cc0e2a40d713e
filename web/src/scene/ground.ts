/** The ground: a grid of tenths of a metre that fades out, and what catches the shadow. */
import {
  Color,
  DoubleSide,
  Group,
  Mesh,
  PlaneGeometry,
  ShaderMaterial,
  ShadowMaterial,
} from "three";

/** How far the grid reaches [m]. */
const REACH = 4;

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

export class Ground {
  readonly root = new Group();
  private readonly grid = new ShaderMaterial({
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    uniforms: {
      line: { value: new Color() },
      axisX: { value: new Color() },
      axisY: { value: new Color() },
    },
    transparent: true,
    depthWrite: false,
    side: DoubleSide,
  });
  private readonly shade = new ShadowMaterial({ opacity: 0.2, depthWrite: false });
  private readonly plane = new PlaneGeometry(2 * REACH, 2 * REACH);

  /** @param solid whether there is a ground, or only a grid to see where things are */
  constructor(solid: boolean) {
    const grid = new Mesh(this.plane, this.grid);
    grid.renderOrder = -1;
    this.root.add(grid);
    if (!solid) return;
    const shade = new Mesh(this.plane, this.shade);
    shade.receiveShadow = true;
    shade.renderOrder = -2;
    this.root.add(shade);
  }

  paint(colours: { line: string; x: string; y: string; dark: boolean }): void {
    const uniforms = this.grid.uniforms as Record<string, { value: Color }>;
    uniforms.line?.value.set(colours.line);
    uniforms.axisX?.value.set(colours.x);
    uniforms.axisY?.value.set(colours.y);
    this.shade.opacity = colours.dark ? 0.5 : 0.2;
  }

  dispose(): void {
    this.plane.dispose();
    this.grid.dispose();
    this.shade.dispose();
  }
}
