/** Soft light from everywhere, and a key light whose shadow shows where things are. */
import {
  DirectionalLight,
  HemisphereLight,
  PMREMGenerator,
  type Scene,
  type WebGLRenderer,
} from "three";
import { RoomEnvironment } from "three/examples/jsm/environments/RoomEnvironment.js";
import type { Quality } from "./quality";

/** Half the width of what casts shadows [m]: a UR5 reaches 0.85 m, its gripper further. */
const REACH = 1.5;

export class Lighting {
  private readonly release: () => void;

  constructor(scene: Scene, renderer: WebGLRenderer, quality: Quality) {
    const high = quality === "high";
    const sky = new HemisphereLight("#ffffff", "#a9b2c0", high ? 0.45 : 1.7);
    sky.position.set(0, 0, 1);
    const key = new DirectionalLight("#fffaf2", high ? 1.75 : 1.9);
    key.position.set(1.6, -1.4, 3.2);
    const fill = new DirectionalLight("#dfe9ff", high ? 0.35 : 0.7);
    fill.position.set(-2, 1.5, 1.2);
    scene.add(sky, key, fill);
    if (!high) {
      this.release = () => undefined;
      return;
    }
    key.castShadow = true;
    key.shadow.mapSize.set(2048, 2048);
    key.shadow.radius = 5;
    key.shadow.bias = -0.0004;
    key.shadow.normalBias = 0.004;
    const { camera } = key.shadow;
    camera.left = camera.bottom = -REACH;
    camera.right = camera.top = REACH;
    camera.near = 0.5;
    camera.far = 8;

    const generator = new PMREMGenerator(renderer);
    const room = new RoomEnvironment();
    const environment = generator.fromScene(room, 0.04);
    room.dispose();
    generator.dispose();
    scene.environment = environment.texture;
    scene.environmentIntensity = 0.42;
    // the room's ceiling is at its +y
    scene.environmentRotation.set(Math.PI / 2, 0, 0);
    this.release = () => {
      environment.dispose();
      key.shadow.dispose();
    };
  }

  dispose(): void {
    this.release();
  }
}
