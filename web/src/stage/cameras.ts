// Where the scene is seen from: named views, turned by hand, that go along with the walker or stay.

import { PerspectiveCamera, Vector3 } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

export type View = "all" | "side" | "corner" | "front" | "top";

const DIRECTIONS: Record<View, [number, number, number]> = {
  all: [0.9, -0.7, 0.42],
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
  view: View | null = null;
  sharing = false; // whether all walkers are looked at
  private readonly focus = new Vector3();
  private readonly stood = new Vector3();
  private readonly looked = new Vector3();

  /** `reach` is how high one walker's scene is, `breadth` how wide all lanes are, m. */
  constructor(
    canvas: HTMLElement,
    private readonly reach: number,
    private readonly breadth: number,
    private readonly locate: () => Vector3,
    changed: () => void,
  ) {
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = true;
    this.controls.dampingFactor = 0.12;
    this.controls.maxPolarAngle = 0.52 * Math.PI;
    this.controls.minDistance = 0.6 * reach;
    this.controls.maxDistance = 20 * reach + 3 * breadth;
    this.controls.addEventListener("start", () => {
      this.view = null;
      changed();
    });
  }

  /** Looks at a walker from one of the named sides. */
  look(view: View): void {
    this.view = view;
    this.sharing = view === "all";
    this.focus.copy(this.locate());
    this.controls.target.copy(this.focus);
    const direction = new Vector3(...DIRECTIONS[view]).normalize();
    this.camera.position.copy(this.focus).addScaledVector(direction, this.distance(view));
    this.controls.update();
  }

  resize(width: number, height: number): void {
    const shape = this.camera.aspect;
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (this.view && Math.abs(shape - this.camera.aspect) > 0.02) this.look(this.view);
  }

  /** Goes after what is looked at, `atOnce` where time has jumped; returns whether it moved. */
  follow(seconds: number, atOnce: boolean): boolean {
    if (this.following) {
      const target = this.locate();
      const share = atOnce ? 1 : 1 - Math.exp(-GLIDE * seconds);
      const ahead = target.x - this.focus.x;
      const step = target.sub(this.focus).multiplyScalar(share);
      // Along its way the walker stays in the middle, however fast it is.
      step.x = ahead;
      this.focus.add(step);
      this.camera.position.add(step);
      this.controls.target.add(step);
    }
    this.controls.update(seconds);
    const still = this.camera.position.distanceToSquared(this.stood) < 1e-8
      && this.controls.target.distanceToSquared(this.looked) < 1e-8;
    this.stood.copy(this.camera.position);
    this.looked.copy(this.controls.target);
    return !still;
  }

  distanceToTarget(): number {
    return this.camera.position.distanceTo(this.controls.target);
  }

  private distance(view: View): number {
    const half = Math.tan((this.camera.fov * Math.PI) / 360);
    const high = (0.78 * this.reach) / half;
    const wide = (0.62 * this.reach) / (half * this.camera.aspect);
    const near = Math.max(high, wide);
    if (view !== "all") return near;
    return Math.max(near, (0.6 * this.breadth) / (half * Math.max(this.camera.aspect, 1.2)));
  }
}
