/** Materials: URDF has only colours, so the colour determines the gloss. */
import {
  Color,
  type Material,
  MeshLambertMaterial,
  MeshStandardMaterial,
  SRGBColorSpace,
  type Texture,
} from "three";
import type { Quality } from "./quality";

export type Solid = MeshStandardMaterial | MeshLambertMaterial;

export interface Finish {
  roughness: number;
  metalness: number;
}

/** Return how a surface of this colour (sRGB, 0 to 1) shines: greys are metal, the rest is plastic. */
export function finishOf(red: number, green: number, blue: number): Finish {
  const brightest = Math.max(red, green, blue);
  const saturation =
    brightest > 0 ? (brightest - Math.min(red, green, blue)) / brightest : 0;
  if (saturation > 0.12) return { roughness: 0.48, metalness: 0 };
  if (brightest < 0.3) return { roughness: 0.6, metalness: 0 };
  return { roughness: 0.42, metalness: brightest < 0.6 ? 0.75 : 0.45 };
}

/** Materials from urdf-loader and the mesh loaders. */
export type Coloured = Material & { color?: Color; map?: Texture | null };

/** Materials by colour, each made once. */
export class Materials {
  private readonly made = new Map<string, Solid>();
  private readonly glowing = new Map<Solid, Solid>();
  private readonly plain = new Map<Solid, Solid>();

  constructor(private readonly quality: Quality) {}

  /** @param rgba sRGB, 0 to 1 */
  of(rgba: readonly [number, number, number, number], map?: Texture | null): Solid {
    const key = `${rgba.join(" ")} ${map?.uuid ?? ""}`;
    const known = this.made.get(key);
    if (known) return known;
    const [red, green, blue, opacity] = rgba;
    const look = {
      color: new Color().setRGB(red, green, blue, SRGBColorSpace),
      opacity,
      transparent: opacity < 1,
      map: map ?? null,
    };
    const material =
      this.quality === "low"
        ? new MeshLambertMaterial(look)
        : new MeshStandardMaterial({ ...look, ...finishOf(red, green, blue) });
    this.made.set(key, material);
    return material;
  }

  /** Ours for a material of urdf-loader, which takes a URDF's sRGB numbers for linear ones. */
  ofUrdf(material: Coloured): Solid {
    const { r, g, b } = material.color ?? new Color(0.8, 0.8, 0.8);
    return this.of([r, g, b, material.opacity], material.map);
  }

  /** Ours for a material that a mesh file brought. */
  ofModel(material: Coloured): Solid {
    const colour = (material.color ?? new Color(0.8, 0.8, 0.8)).getRGB(
      { r: 0, g: 0, b: 0 },
      SRGBColorSpace,
    );
    return this.of([colour.r, colour.g, colour.b, material.opacity], material.map);
  }

  /** The same material, lit up. */
  glowingOf(material: Solid, glow: string): Solid {
    const glowing = this.glowing.get(material) ?? material.clone();
    this.glowing.set(material, glowing);
    this.plain.set(glowing, material);
    glowing.emissive.set(glow);
    glowing.emissiveIntensity = 0.35;
    return glowing;
  }

  /** The material that `material` lights up, or itself. */
  plainOf(material: Solid): Solid {
    return this.plain.get(material) ?? material;
  }

  dispose(): void {
    for (const material of [...this.made.values(), ...this.glowing.values()]) {
      material.map?.dispose();
      material.dispose();
    }
  }
}
