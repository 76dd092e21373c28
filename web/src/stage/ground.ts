// The ground: a strip for each walker, with a line every metre and the metres written on it.

import {
  BufferAttribute, BufferGeometry, CanvasTexture, Color, Group, LineBasicMaterial, LineSegments, Mesh,
  MeshBasicMaterial, MeshStandardMaterial, type Scene,
} from "three";
import type { Ground } from "../show";
import type { Theme } from "../theme";

const CHUNK = 64; // nodes along a mesh, so that those out of sight are not drawn
const DEPTH = 0.16; // m, of the strip's edge
const ABOVE = 0.003; // m, of lines over the ground
const NARROW = 0.8; // m, of a lane where there are several

/** A walker's strip: its middle `lane` is drawn at y, and is ground along the line `path`. */
export interface Lane {
  y: number;
  path: (x: number) => number;
}

export class Terrain {
  private readonly top = new MeshStandardMaterial({ roughness: 0.95, flatShading: true });
  private readonly edge = new MeshStandardMaterial({ roughness: 1 });
  private readonly lines = new LineBasicMaterial({ transparent: true, opacity: 0.55 });
  private readonly bold = new LineBasicMaterial();
  private readonly text = new MeshBasicMaterial({ transparent: true, depthWrite: false });
  private readonly offsets: number[];

  constructor(
    scene: Scene,
    private readonly ground: Ground,
    private readonly heights: Float32Array[],
    private readonly lanes: Lane[],
  ) {
    this.offsets = this.across();
    lanes.forEach((_, lane) => scene.add(this.strip(lane)));
    scene.add(this.numbers());
  }

  paint(theme: Theme): void {
    this.top.color = new Color(theme.ground);
    this.edge.color = new Color(theme.edge);
    for (const material of [this.lines, this.bold, this.text]) {
      material.color = new Color(theme.mark);
    }
  }

  /** Returns the ground's height in a lane, `aside` from its middle. */
  height(lane: number, x: number, aside: number): number {
    const { spacing, rows } = this.ground;
    const along = clamped((x - this.ground.x) / spacing, this.nodes - 1);
    if (rows === 1) return between(this.heights[0]!, along);
    const y = this.lanes[lane]!.path(x) + aside;
    const across = clamped((y - this.ground.y) / spacing, rows - 1);
    const row = Math.min(Math.floor(across), rows - 2);
    const near = between(this.heights[row]!, along);
    return near + (across - row) * (between(this.heights[row + 1]!, along) - near);
  }

  private get nodes(): number {
    return this.heights[0]!.length;
  }

  private get end(): number {
    return this.ground.x + (this.nodes - 1) * this.ground.spacing;
  }

  /** Returns where a strip's rows of nodes are, from its middle. */
  private across(): number[] {
    const { rows, y, width, spacing } = this.ground;
    const several = this.lanes.length > 1;
    if (rows > 1 && !several) return Array.from({ length: rows }, (_, row) => y + row * spacing);
    const wide = several ? NARROW : width;
    const parts = rows > 1 ? Math.round(wide / (2 * spacing)) : 1;
    return Array.from({ length: parts + 1 }, (_, part) => (part / parts - 0.5) * wide);
  }

  private strip(lane: number): Group {
    const strip = new Group();
    for (const geometry of this.tops(lane)) {
      const mesh = new Mesh(geometry, this.top);
      mesh.receiveShadow = true;
      strip.add(mesh);
    }
    strip.add(new Mesh(this.side(lane, this.offsets[0]!, -1), this.edge));
    strip.add(new Mesh(this.side(lane, this.offsets.at(-1)!, 1), this.edge));
    strip.add(new LineSegments(this.metres(lane, false), this.lines));
    strip.add(new LineSegments(this.metres(lane, true), this.bold));
    strip.position.y = this.lanes[lane]!.y;
    return strip;
  }

  private point(lane: number, node: number, aside: number): [number, number, number] {
    const x = this.ground.x + node * this.ground.spacing;
    return [x, aside, this.height(lane, x, aside)];
  }

  private tops(lane: number): BufferGeometry[] {
    const found: BufferGeometry[] = [];
    for (let first = 0; first < this.nodes - 1; first += CHUNK) {
      const last = Math.min(first + CHUNK, this.nodes - 1);
      const points: number[] = [];
      for (const aside of this.offsets) {
        for (let node = first; node <= last; node++) points.push(...this.point(lane, node, aside));
      }
      found.push(sheet(points, last - first + 1, this.offsets.length));
    }
    return found;
  }

  private side(lane: number, aside: number, facing: number): BufferGeometry {
    const upper = Array.from({ length: this.nodes }, (_, node) => this.point(lane, node, aside)).flat();
    const lower = upper.map((value, index) => (index % 3 === 2 ? value - DEPTH : value));
    return sheet(facing < 0 ? [...lower, ...upper] : [...upper, ...lower], this.nodes, 2);
  }

  /** Returns the lines across, every fifth metre or the others. */
  private metres(lane: number, fifth: boolean): BufferGeometry {
    const points: number[] = [];
    for (let x = Math.ceil(this.ground.x); x <= this.end; x++) {
      if ((x % 5 === 0) !== fifth) continue;
      this.offsets.slice(1).forEach((next, index) => {
        for (const aside of [this.offsets[index]!, next]) {
          points.push(x, aside, this.height(lane, x, aside) + ABOVE);
        }
      });
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array(points), 3));
    return geometry;
  }

  /** Returns the metres written along the near edge. */
  private numbers(): Mesh {
    const count = Math.floor(this.end) + 1;
    const aside = this.offsets[0]! + 0.03;
    const points: number[] = [];
    const places: number[] = [];
    const faces: number[] = [];
    for (let metre = 0; metre < count; metre++) {
      for (const [right, far] of [[0, 0], [1, 0], [0, 1], [1, 1]] as const) {
        const x = metre + 0.04 + 0.4 * right;
        points.push(x, aside + 0.2 * far, this.height(0, x, aside + 0.2 * far) + 2 * ABOVE);
        places.push(...cell(metre, count, right, far));
      }
      const at = 4 * metre;
      faces.push(at, at + 1, at + 2, at + 1, at + 3, at + 2);
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array(points), 3));
    geometry.setAttribute("uv", new BufferAttribute(new Float32Array(places), 2));
    geometry.setIndex(faces);
    this.text.map = written(count);
    const mesh = new Mesh(geometry, this.text);
    mesh.position.y = this.lanes[0]!.y;
    return mesh;
  }
}

function clamped(value: number, most: number): number {
  return Math.min(Math.max(value, 0), most);
}

function between(heights: Float32Array, along: number): number {
  const node = Math.min(Math.floor(along), heights.length - 2);
  return heights[node]! + (along - node) * (heights[node + 1]! - heights[node]!);
}

/** Returns a sheet of rows of points, seen from the side where they run to the right and up. */
function sheet(points: number[], columns: number, rows: number): BufferGeometry {
  const faces: number[] = [];
  for (let row = 0; row < rows - 1; row++) {
    for (let column = 0; column < columns - 1; column++) {
      const at = row * columns + column;
      faces.push(at, at + 1, at + columns, at + 1, at + columns + 1, at + columns);
    }
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(points), 3));
  geometry.setIndex(faces);
  geometry.computeVertexNormals();
  return geometry;
}

const [COLUMNS, WIDE, HIGH] = [16, 128, 64]; // of the sheet that all numbers are written on

/** Returns where on the sheet a corner of a number is. */
function cell(metre: number, count: number, right: number, far: number): [number, number] {
  const rows = Math.ceil(count / COLUMNS);
  const [column, row] = [metre % COLUMNS, Math.floor(metre / COLUMNS)];
  return [(column + right) / COLUMNS, 1 - (row + 1 - far) / rows];
}

function written(count: number): CanvasTexture {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [COLUMNS * WIDE, Math.ceil(count / COLUMNS) * HIGH];
  const pen = canvas.getContext("2d")!;
  pen.fillStyle = "#fff";
  pen.textBaseline = "middle";
  for (let metre = 0; metre < count; metre++) {
    const strong = metre % 5 === 0;
    pen.globalAlpha = strong ? 1 : 0.75;
    pen.font = `${strong ? 700 : 500} 34px system-ui, sans-serif`;
    const [column, row] = [metre % COLUMNS, Math.floor(metre / COLUMNS)];
    pen.fillText(`${metre} m`, column * WIDE + 4, (row + 0.53) * HIGH);
  }
  const texture = new CanvasTexture(canvas);
  texture.anisotropy = 4;
  return texture;
}
