// The walkers' bodies: each part once, drawn for all walkers together.

import {
  BufferAttribute, BufferGeometry, CapsuleGeometry, Color, CylinderGeometry, DynamicDrawUsage,
  InstancedMesh, Matrix4, MeshStandardMaterial, SphereGeometry, type Scene,
} from "three";
import { RoundedBoxGeometry } from "three/addons/geometries/RoundedBoxGeometry.js";
import type { Body, Part, Side } from "../show";
import { placed } from "../skeleton";
import type { Theme } from "../theme";

const FADED = 0.55; // of a walker that is not the one looked at, towards the sky

export class Figures {
  private readonly meshes: InstancedMesh[];
  private readonly places: Matrix4[];
  private readonly made = new Matrix4();

  constructor(scene: Scene, private readonly body: Body, private readonly count: number) {
    this.places = body.parts.map((part) => placed(part.pos, part.quat));
    this.meshes = body.parts.map((part) => {
      const material = new MeshStandardMaterial({ roughness: 0.62, flatShading: part.shape === "mesh" });
      const mesh = new InstancedMesh(shape(part, count > 4 ? 0.6 : 1), material, count);
      mesh.instanceMatrix.setUsage(DynamicDrawUsage);
      mesh.castShadow = mesh.receiveShadow = true;
      mesh.frustumCulled = false;
      scene.add(mesh);
      return mesh;
    });
  }

  /** Puts a walker's parts where its links are. */
  place(walker: number, links: Matrix4[]): void {
    this.body.parts.forEach((part, index) => {
      this.made.multiplyMatrices(links[part.body]!, this.places[index]!);
      this.meshes[index]!.setMatrixAt(walker, this.made);
    });
  }

  /** Has what was placed drawn. */
  commit(): void {
    for (const mesh of this.meshes) mesh.instanceMatrix.needsUpdate = true;
  }

  paint(theme: Theme, chosen: number): void {
    const sky = new Color(theme.sky);
    this.body.parts.forEach((part, index) => {
      const own = new Color(colourOf(theme, part.side));
      for (let walker = 0; walker < this.count; walker++) {
        const colour = walker === chosen ? own : own.clone().lerp(sky, FADED);
        this.meshes[index]!.setColorAt(walker, colour);
      }
      this.meshes[index]!.instanceColor!.needsUpdate = true;
    });
  }
}

export function colourOf(theme: Theme, side: Side): string {
  return theme[side];
}

/** Returns a part's surface; `detail` says how finely it is cut. */
function shape(part: Part, detail: number): BufferGeometry {
  const [first, second, third] = part.size as [number, number, number];
  if (part.shape === "sphere") return new SphereGeometry(first, 32 * detail, 20 * detail);
  if (part.shape === "ellipsoid") {
    return new SphereGeometry(1, 32 * detail, 20 * detail).scale(first, second, third);
  }
  if (part.shape === "cylinder") {
    return new CylinderGeometry(first, first, 2 * second, 32 * detail).rotateX(Math.PI / 2);
  }
  if (part.shape === "capsule") {
    return new CapsuleGeometry(first, 2 * second, 8 * detail, 24 * detail).rotateX(Math.PI / 2);
  }
  if (part.shape === "box") {
    const round = 0.45 * Math.min(first, second, third);
    return new RoundedBoxGeometry(2 * first, 2 * second, 2 * third, Math.round(4 * detail), round);
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(part.vertices), 3));
  geometry.setIndex(part.faces);
  geometry.computeVertexNormals();
  return geometry;
}
