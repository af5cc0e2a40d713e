/**
 * What stands on the ground, or just above it, darkens it softly: the height of things is
 * drawn from below, blurred, and laid on the ground.
 */
import {
  Group,
  Mesh,
  MeshBasicMaterial,
  MeshDepthMaterial,
  OrthographicCamera,
  PlaneGeometry,
  type Scene,
  ShaderMaterial,
  type WebGLRenderer,
  WebGLRenderTarget,
} from "three";
import { HorizontalBlurShader } from "three/examples/jsm/shaders/HorizontalBlurShader.js";
import { VerticalBlurShader } from "three/examples/jsm/shaders/VerticalBlurShader.js";
import { MODEL_LAYER } from "./layers";
import type { Quality } from "./quality";

/** Edge of the ground that is darkened [m]. */
const SIZE = 2.4;
/** Up to here things darken the ground [m]. */
const HEIGHT = 0.35;
/** Pixels along an edge; without a GPU every pixel costs time. */
const PIXELS = { high: 512, low: 160 };
/** How soft the shadow is; two passes make it rounder than one [parts of the edge]. */
const BLURS = [3.5 / 512, 1.4 / 512];
/** Without a GPU the shadow of what moves is drawn no more often than this [ms]. */
const PERIOD_MS = { high: 0, low: 200 };

function shader(source: typeof HorizontalBlurShader | typeof VerticalBlurShader) {
  const material = new ShaderMaterial(source);
  material.depthTest = false;
  return material;
}

export class ContactShadow {
  readonly root = new Group();
  needsUpdate = true;
  private readonly target: WebGLRenderTarget;
  private readonly spare: WebGLRenderTarget;
  private readonly camera = new OrthographicCamera(
    -SIZE / 2,
    SIZE / 2,
    SIZE / 2,
    -SIZE / 2,
    0,
    HEIGHT,
  );
  private readonly depth = new MeshDepthMaterial();
  private readonly plane = new PlaneGeometry(SIZE, SIZE);
  private readonly shade: MeshBasicMaterial;
  private readonly across = shader(HorizontalBlurShader);
  private readonly along = shader(VerticalBlurShader);
  private readonly screen = new Mesh(this.plane, this.across);

  private readonly period: number;
  private drawnAt = -Infinity;

  /** @param height of the ground [m] */
  constructor(height: number, quality: Quality) {
    const pixels = PIXELS[quality];
    this.period = PERIOD_MS[quality];
    this.target = new WebGLRenderTarget(pixels, pixels);
    this.spare = new WebGLRenderTarget(pixels, pixels);
    this.shade = new MeshBasicMaterial({
      map: this.target.texture,
      transparent: true,
      depthWrite: false,
      toneMapped: false,
    });
    // looking up, with the picture's x along x
    this.camera.position.z = height;
    this.camera.up.set(0, 1, 0);
    this.camera.rotation.set(Math.PI, 0, 0);
    this.camera.layers.set(MODEL_LAYER);
    const ground = new Mesh(this.plane, this.shade);
    ground.position.z = height;
    // drawn from below, the picture is mirrored in y
    ground.scale.y = -1;
    this.shade.side = 2;
    ground.renderOrder = -3;
    this.root.add(ground);
    this.depth.onBeforeCompile = (compiled) => {
      // black, and the denser the nearer to the ground
      compiled.fragmentShader = compiled.fragmentShader.replace(
        "gl_FragColor = vec4( vec3( 1.0 - fragCoordZ ), opacity );",
        "gl_FragColor = vec4( vec3( 0.0 ), pow( 1.0 - fragCoordZ, 1.6 ) );",
      );
    };
    this.depth.depthTest = true;
  }

  paint(dark: boolean): void {
    this.shade.opacity = dark ? 0.85 : 0.5;
  }

  /** Draw the shadow anew if something moved; `isLast`: in any case, as nothing will. */
  update(renderer: WebGLRenderer, scene: Scene, isLast: boolean): void {
    const now = performance.now();
    if (!this.needsUpdate || (!isLast && now - this.drawnAt < this.period)) return;
    this.needsUpdate = false;
    this.drawnAt = now;
    const { autoUpdate, needsUpdate } = renderer.shadowMap;
    renderer.shadowMap.needsUpdate = false;
    scene.overrideMaterial = this.depth;
    renderer.setRenderTarget(this.target);
    renderer.setClearColor(0, 0);
    renderer.clear();
    renderer.render(scene, this.camera);
    scene.overrideMaterial = null;
    for (const blur of BLURS) this.blur(renderer, blur);
    renderer.setRenderTarget(null);
    renderer.shadowMap.autoUpdate = autoUpdate;
    renderer.shadowMap.needsUpdate = needsUpdate;
  }

  private blur(renderer: WebGLRenderer, width: number): void {
    const passes = [
      { material: this.across, uniform: "h", from: this.target, to: this.spare },
      { material: this.along, uniform: "v", from: this.spare, to: this.target },
    ] as const;
    for (const { material, uniform, from, to } of passes) {
      const uniforms = material.uniforms as Record<string, { value: unknown }>;
      Object.assign(uniforms.tDiffuse ?? {}, { value: from.texture });
      Object.assign(uniforms[uniform] ?? {}, { value: width });
      this.screen.material = material;
      renderer.setRenderTarget(to);
      renderer.render(this.screen, SCREEN_CAMERA);
    }
  }

  dispose(): void {
    this.target.dispose();
    this.spare.dispose();
    this.plane.dispose();
    for (const one of [this.depth, this.shade, this.across, this.along]) one.dispose();
  }
}

/** Sees exactly the plane of `SIZE`. */
const SCREEN_CAMERA = new OrthographicCamera(
  -SIZE / 2,
  SIZE / 2,
  SIZE / 2,
  -SIZE / 2,
  -1,
  1,
);
