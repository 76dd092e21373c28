// Where a body's links are, of its coordinates: the tree and the rules of MuJoCo.

import { Matrix4, Quaternion, Vector3 } from "three";
import type { Motion } from "./motion";
import type { Body } from "./show";

interface Move {
  slides: boolean;
  axis: Vector3;
  coordinate: number;
}

export class Skeleton {
  private readonly places: Matrix4[];
  private readonly moves: Move[][];
  private readonly step = new Matrix4();

  constructor(private readonly body: Body) {
    this.places = body.links.map((link) => placed(link.pos, link.quat));
    this.moves = body.links.map((link) => link.joints.map((joint) => ({
      slides: joint.move === "slide",
      axis: new Vector3().fromArray(joint.axis),
      coordinate: joint.coordinate,
    })));
  }

  get size(): number {
    return this.body.links.length;
  }

  /** Writes every link's place in the world. */
  pose(coordinates: Float32Array, into: Matrix4[]): void {
    this.body.links.forEach((link, index) => {
      const place = into[index]!.copy(this.places[index]!);
      if (link.parent >= 0) place.premultiply(into[link.parent]!);
      for (const { slides, axis, coordinate } of this.moves[index]!) {
        const value = coordinates[coordinate]!;
        if (slides) this.step.makeTranslation(axis.x * value, axis.y * value, axis.z * value);
        else this.step.makeRotationAxis(axis, value);
        place.multiply(this.step);
      }
    });
  }
}

/** Returns a place in a parent, of a position and a turn given as w x y z. */
export function placed(pos: number[], quat: number[]): Matrix4 {
  const [w, x, y, z] = quat as [number, number, number, number];
  return new Matrix4().compose(
    new Vector3().fromArray(pos),
    new Quaternion(x, y, z, w),
    new Vector3(1, 1, 1),
  );
}

/** Returns where a walker's links are at a time, x, y and z, m. */
export function placesOf(body: Body, motion: Motion, time: number): number[][] {
  const skeleton = new Skeleton(body);
  const links = Array.from({ length: skeleton.size }, () => new Matrix4());
  const coordinates = new Float32Array(motion.moves.length);
  motion.pose(motion.at(time), coordinates);
  skeleton.pose(coordinates, links);
  return links.map((link) => new Vector3().setFromMatrixPosition(link).toArray());
}
