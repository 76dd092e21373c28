// Where the scene is seen from: named views, turned by hand, that go along with the walker or stay.

import { PerspectiveCamera, Vector3 } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

export type View = "side" | "corner" | "front" | "top";

const DIRECTIONS: Record<View, [number, number, number]> = {
  side: [0, -1, 0.09],
  corner: [0.55, -0.8, 0.32],
  front: [1, -0.1, 0.16],
  top: [-0.02, -0.25, 1],
};
const GLIDE = 7; // 1/s, how fast the camera goes after the walker

export class Cameras {
  readonly camera = new PerspectiveCamera(32, 1, 0.05, 200);
  readonly controls: OrbitControls;
  following = true;
  view: View | null = "corner";
  private readonly focus = new Vector3();
  private readonly wanted = new Vector3();

  /** `reach` is how high the scene should be seen, m. */
  constructor(canvas: HTMLElement, private readonly reach: number, changed: () => void) {
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = true;
    this.controls.dampingFactor = 0.12;
    this.controls.maxPolarAngle = 0.52 * Math.PI;
    this.controls.minDistance = 0.6 * reach;
    this.controls.maxDistance = 30 * reach;
    this.controls.addEventListener("start", () => {
      this.view = null;
      changed();
    });
  }

  /** Looks at a walker from one of the named sides. */
  look(view: View): void {
    this.view = view;
    this.controls.target.copy(this.wanted);
    this.focus.copy(this.wanted);
    const direction = new Vector3(...DIRECTIONS[view]).normalize();
    this.camera.position.copy(this.focus).addScaledVector(direction, this.distance());
    this.controls.update();
  }

  resize(width: number, height: number): void {
    const shape = this.camera.aspect;
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (this.view && Math.abs(shape - this.camera.aspect) > 0.02) this.look(this.view);
  }

  /** Goes after what is to be seen; `at once` where time has jumped. */
  follow(target: Vector3, seconds: number, atOnce: boolean): void {
    this.wanted.copy(target);
    if (this.following) {
      const share = atOnce ? 1 : 1 - Math.exp(-GLIDE * seconds);
      const step = target.clone().sub(this.focus).multiplyScalar(share);
      // Along its way the walker stays in the middle, however fast it is.
      step.x = target.x - this.focus.x;
      this.focus.add(step);
      this.camera.position.add(step);
      this.controls.target.add(step);
    }
    this.controls.update(seconds);
  }

  distanceToTarget(): number {
    return this.camera.position.distanceTo(this.controls.target);
  }

  private distance(): number {
    const half = Math.tan((this.camera.fov * Math.PI) / 360);
    const high = (0.78 * this.reach) / half;
    const wide = (0.62 * this.reach) / (half * this.camera.aspect);
    return Math.max(high, wide);
  }
}
