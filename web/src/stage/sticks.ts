// A walker's recent past: stick figures that fade into the sky.

import {
  Color, CylinderGeometry, DynamicDrawUsage, InstancedMesh, Matrix4, MeshBasicMaterial, Quaternion,
  Vector3, type Scene,
} from "three";
import type { Motion } from "../motion";
import type { Body } from "../show";
import type { Skeleton } from "../skeleton";
import type { Theme } from "../theme";
import type { Lane } from "./ground";

const INTERVAL = 0.16; // s between figures
const FIGURES = 14; // of a walker
const RADIUS = 0.0055; // m
const UP = new Vector3(0, 1, 0);

interface Segment {
  body: number;
  from: Vector3;
  to: Vector3;
  colour: "left" | "right" | "middle";
}

export class Trail {
  private readonly segments: Segment[];
  private readonly mesh: InstancedMesh;
  private readonly coordinates: Float32Array;
  private readonly links: Matrix4[];
  private newest = -1;
  private colours: Color[] = [];

  constructor(
    scene: Scene,
    body: Body,
    private readonly skeleton: Skeleton,
    private readonly motions: Motion[],
    private readonly lanes: Lane[],
  ) {
    this.segments = body.sticks.flatMap((stick) => stick.line.slice(1).map((point, index) => ({
      body: stick.body,
      from: new Vector3().fromArray(stick.line[index]!),
      to: new Vector3().fromArray(point),
      colour: stick.side,
    })));
    const size = this.segments.length * FIGURES * motions.length;
    const rod = new CylinderGeometry(RADIUS, RADIUS, 1, 5, 1, true);
    this.mesh = new InstancedMesh(rod, new MeshBasicMaterial(), size);
    this.mesh.instanceMatrix.setUsage(DynamicDrawUsage);
    this.mesh.frustumCulled = false;
    this.mesh.setColorAt(0, new Color());
    this.coordinates = new Float32Array(motions[0]!.moves.length);
    this.links = Array.from({ length: skeleton.size }, () => new Matrix4());
    scene.add(this.mesh);
  }

  set visible(visible: boolean) {
    this.mesh.visible = visible;
  }

  paint(theme: Theme, chosen: number): void {
    const sky = new Color(theme.sky);
    const sides = new Map((["left", "right", "middle"] as const).map((side) => [side, new Color(theme[side])]));
    this.colours = this.motions.flatMap((_, walker) => this.segments.flatMap((segment) =>
      Array.from({ length: FIGURES }, (_, age) => {
        const share = (0.62 - 0.55 * (age / FIGURES)) * (walker === chosen ? 1 : 0.4);
        return sky.clone().lerp(sides.get(segment.colour)!, share);
      }),
    ));
    this.newest = -1;
  }

  /** Draws the figures before a time. */
  show(time: number): void {
    const newest = Math.floor(time / INTERVAL);
    if (newest === this.newest) return;
    this.newest = newest;
    let place = 0;
    this.motions.forEach((motion, walker) => {
      const end = Math.floor(Math.min(motion.duration, time) / INTERVAL);
      for (let figure = 0; figure < FIGURES; figure++) {
        const number = end - figure;
        if (number < 0) continue;
        motion.pose(motion.at(number * INTERVAL), this.coordinates);
        this.skeleton.pose(this.coordinates, this.links);
        const { y, path } = this.lanes[walker]!;
        const aside = y - path(this.coordinates[0]!);
        this.segments.forEach((segment, index) => {
          this.mesh.setMatrixAt(place, this.rod(segment, aside));
          const colour = (walker * this.segments.length + index) * FIGURES + figure;
          this.mesh.setColorAt(place, this.colours[colour]!);
          place++;
        });
      }
    });
    this.mesh.count = place;
    this.mesh.instanceMatrix.needsUpdate = true;
    this.mesh.instanceColor!.needsUpdate = true;
  }

  private readonly a = new Vector3();
  private readonly b = new Vector3();
  private readonly turn = new Quaternion();
  private readonly made = new Matrix4();

  private rod(segment: Segment, aside: number): Matrix4 {
    const place = this.links[segment.body]!;
    this.a.copy(segment.from).applyMatrix4(place);
    this.b.copy(segment.to).applyMatrix4(place);
    const middle = this.a.clone().add(this.b).multiplyScalar(0.5);
    middle.y += aside;
    this.b.sub(this.a);
    const length = this.b.length();
    this.turn.setFromUnitVectors(UP, this.b.divideScalar(length || 1));
    return this.made.compose(middle, this.turn, new Vector3(1, length, 1));
  }
}
