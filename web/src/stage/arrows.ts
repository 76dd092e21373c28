// The ground's force on each foot as an arrow, and the points that carry it.

import {
  Color, ConeGeometry, CylinderGeometry, DynamicDrawUsage, InstancedMesh, Matrix4, MeshBasicMaterial,
  Quaternion, SphereGeometry, Vector3, type BufferGeometry, type Scene,
} from "three";
import { Motion, type Moment } from "../motion";
import type { Body } from "../show";
import type { Theme } from "../theme";

const UP = new Vector3(0, 1, 0);
const NOWHERE = new Matrix4().makeScale(0, 0, 0);
const SMALLEST = 0.03; // of the body's weight
const LONGEST = 2.5; // times the body's weight; what is drawn longer hides the walker

export class Arrows {
  private readonly shafts: InstancedMesh;
  private readonly heads: InstancedMesh;
  private readonly dots: InstancedMesh;
  private readonly materials: MeshBasicMaterial[] = [];
  private readonly legs: number[];

  constructor(
    scene: Scene,
    private readonly body: Body,
    private readonly weight: number,
    private readonly size: number,
    count: number,
  ) {
    this.legs = [...new Set(body.points.map((point) => point.leg))];
    const radius = 0.014 * size;
    const make = (geometry: BufferGeometry, number: number) => {
      const material = new MeshBasicMaterial({ depthTest: false, transparent: true, opacity: 0.92 });
      this.materials.push(material);
      const mesh = new InstancedMesh(geometry, material, number);
      mesh.instanceMatrix.setUsage(DynamicDrawUsage);
      mesh.frustumCulled = false;
      mesh.renderOrder = 1; // over the leg that the force goes through
      scene.add(mesh);
      return mesh;
    };
    const arrows = count * this.legs.length;
    this.shafts = make(new CylinderGeometry(radius, radius, 1, 10), arrows);
    this.heads = make(new ConeGeometry(2.6 * radius, 7 * radius, 16), arrows);
    this.dots = make(new SphereGeometry(1.5 * radius, 12, 8), count * body.points.length);
  }

  set visible(visible: boolean) {
    for (const mesh of [this.shafts, this.heads, this.dots]) mesh.visible = visible;
  }

  paint(theme: Theme): void {
    for (const material of this.materials) material.color = new Color(theme.force);
  }

  /** Draws a walker's forces at a moment. */
  place(walker: number, motion: Motion, moment: Moment, links: Matrix4[]): void {
    const points = this.body.points;
    const sums = new Map(this.legs.map((leg) => [leg, { force: new Vector3(), at: new Vector3() }]));
    points.forEach((point, index) => {
      const force = new Vector3(...[0, 1, 2].map(
        (axis) => Motion.value(motion.pushes[3 * index + axis]!, moment),
      ) as [number, number, number]);
      const at = new Vector3().fromArray(point.pos).applyMatrix4(links[point.body]!);
      const sum = sums.get(point.leg)!;
      sum.at.addScaledVector(at, force.z);
      sum.force.add(force);
      const dot = walker * points.length + index;
      const loaded = force.z > SMALLEST * this.weight;
      this.dots.setMatrixAt(dot, loaded ? new Matrix4().makeTranslation(at) : NOWHERE);
    });
    this.legs.forEach((leg, index) => {
      const { force, at } = sums.get(leg)!;
      this.draw(walker * this.legs.length + index, force, at);
    });
  }

  /** Has what was placed drawn. */
  commit(): void {
    for (const mesh of [this.shafts, this.heads, this.dots]) mesh.instanceMatrix.needsUpdate = true;
  }

  private draw(place: number, force: Vector3, at: Vector3): void {
    const share = force.length() / this.weight;
    if (share < SMALLEST || force.z <= 0) {
      this.shafts.setMatrixAt(place, NOWHERE);
      this.heads.setMatrixAt(place, NOWHERE);
      return;
    }
    at.divideScalar(force.z);
    const length = 0.55 * this.size * Math.min(share, LONGEST);
    const along = force.clone().normalize();
    const turn = new Quaternion().setFromUnitVectors(UP, along);
    const middle = at.clone().addScaledVector(along, length / 2);
    const tip = at.clone().addScaledVector(along, length);
    this.shafts.setMatrixAt(place, new Matrix4().compose(middle, turn, new Vector3(1, length, 1)));
    this.heads.setMatrixAt(place, new Matrix4().compose(tip, turn, new Vector3(1, 1, 1)));
  }
}
