// The ground: a strip for each walker, with a line every metre and the metres written on it.

import {
  BufferAttribute, BufferGeometry, CanvasTexture, Color, Group, LineBasicMaterial, LineSegments, Mesh,
  MeshBasicMaterial, MeshStandardMaterial, PlaneGeometry, type Scene,
} from "three";
import type { Ground } from "../show";
import type { Theme } from "../theme";

const CHUNK = 64; // nodes along a mesh, so that those out of sight are not drawn
const DEPTH = 0.16; // m, of the strip's edge
const ABOVE = 0.003; // m, of lines over the ground

export class Terrain {
  readonly width: number;
  private readonly group = new Group();
  private readonly top = new MeshStandardMaterial({ roughness: 0.95, flatShading: true });
  private readonly edge = new MeshStandardMaterial({ roughness: 1 });
  private readonly lines = new LineBasicMaterial({ transparent: true, opacity: 0.5 });
  private readonly bold = new LineBasicMaterial();
  private readonly text = new MeshBasicMaterial({ transparent: true, depthWrite: false });
  private readonly textures: MeshBasicMaterial[] = [];

  constructor(
    scene: Scene,
    private readonly ground: Ground,
    private readonly heights: Float32Array[],
    lanes: number[],
  ) {
    this.width = ground.width;
    const tops = this.tops();
    const edges = [this.side(0, -1), this.side(this.rowsDrawn - 1, 1)];
    const [thin, thick] = this.metres();
    for (const lane of lanes) {
      const strip = new Group();
      for (const geometry of tops) {
        const mesh = new Mesh(geometry, this.top);
        mesh.receiveShadow = true;
        strip.add(mesh);
      }
      for (const geometry of edges) strip.add(new Mesh(geometry, this.edge));
      strip.add(new LineSegments(thin, this.lines), new LineSegments(thick, this.bold));
      strip.position.y = lane;
      this.group.add(strip);
    }
    this.group.add(this.numbers(lanes[0]!));
    scene.add(this.group);
  }

  paint(theme: Theme): void {
    this.top.color = new Color(theme.ground);
    this.edge.color = new Color(theme.edge);
    this.lines.color = new Color(theme.mark);
    this.bold.color = new Color(theme.mark);
    for (const material of [this.text, ...this.textures]) material.color = new Color(theme.mark);
  }

  /** Returns the ground's height, y counted from the middle of a walker's own lane. */
  height(x: number, y: number): number {
    const { spacing, rows } = this.ground;
    const along = this.clamped((x - this.ground.x) / spacing, this.nodes - 1);
    if (rows === 1) return this.between(this.heights[0]!, along);
    const across = this.clamped((y - this.ground.y) / spacing, rows - 1);
    const row = Math.min(Math.floor(across), rows - 2);
    const near = this.between(this.heights[row]!, along);
    return near + (across - row) * (this.between(this.heights[row + 1]!, along) - near);
  }

  private get nodes(): number {
    return this.heights[0]!.length;
  }

  private get rowsDrawn(): number {
    return Math.max(this.ground.rows, 2);
  }

  private rowHeights(row: number): Float32Array {
    return this.heights[this.ground.rows === 1 ? 0 : row]!;
  }

  private rowY(row: number): number {
    const { rows, width, y, spacing } = this.ground;
    return rows === 1 ? (row - 0.5) * width : y + spacing * row;
  }

  private clamped(value: number, most: number): number {
    return Math.min(Math.max(value, 0), most);
  }

  private between(heights: Float32Array, along: number): number {
    const node = Math.min(Math.floor(along), heights.length - 2);
    return heights[node]! + (along - node) * (heights[node + 1]! - heights[node]!);
  }

  private tops(): BufferGeometry[] {
    const found: BufferGeometry[] = [];
    for (let first = 0; first < this.nodes - 1; first += CHUNK) {
      const last = Math.min(first + CHUNK, this.nodes - 1);
      const points: number[] = [];
      for (let row = 0; row < this.rowsDrawn; row++) {
        const heights = this.rowHeights(row);
        for (let node = first; node <= last; node++) {
          points.push(this.ground.x + node * this.ground.spacing, this.rowY(row), heights[node]!);
        }
      }
      found.push(sheet(points, last - first + 1, this.rowsDrawn));
    }
    return found;
  }

  private side(row: number, facing: number): BufferGeometry {
    const heights = this.rowHeights(row);
    const level = (node: number) => [
      this.ground.x + node * this.ground.spacing, this.rowY(row), heights[node]!,
    ];
    const upper = Array.from(heights, (_, node) => level(node)).flat();
    const lower = upper.map((value, index) => (index % 3 === 2 ? value - DEPTH : value));
    const points = facing < 0 ? [...lower, ...upper] : [...upper, ...lower];
    return sheet(points, this.nodes, 2);
  }

  private metres(): [BufferGeometry, BufferGeometry] {
    const thin: number[] = [];
    const thick: number[] = [];
    const last = this.ground.x + (this.nodes - 1) * this.ground.spacing;
    for (let x = Math.ceil(this.ground.x); x <= last; x++) {
      const points = x % 5 === 0 ? thick : thin;
      for (let row = 0; row < this.rowsDrawn - 1; row++) {
        for (const y of [this.rowY(row), this.rowY(row + 1)]) {
          points.push(x, y, this.height(x, y) + ABOVE);
        }
      }
    }
    return [lineSet(thin), lineSet(thick)];
  }

  private numbers(lane: number): Group {
    const group = new Group();
    const last = this.ground.x + (this.nodes - 1) * this.ground.spacing;
    const plane = new PlaneGeometry(0.4, 0.2);
    for (let x = 0; x <= last; x += 1) {
      const material = this.text.clone();
      material.map = written(`${x} m`, x % 5 === 0);
      this.textures.push(material);
      const mesh = new Mesh(plane, material);
      const y = this.rowY(0) + 0.13;
      mesh.position.set(x + 0.24, lane + y, this.height(x + 0.24, y) + 2 * ABOVE);
      const rise = this.height(x + 0.44, y) - this.height(x + 0.04, y);
      mesh.rotation.y = -Math.atan2(rise, 0.4);
      group.add(mesh);
    }
    return group;
  }
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

function lineSet(points: number[]): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(points), 3));
  return geometry;
}

function written(text: string, strong: boolean): CanvasTexture {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [128, 64];
  const pen = canvas.getContext("2d")!;
  pen.fillStyle = "#fff";
  pen.globalAlpha = strong ? 1 : 0.75;
  pen.font = `${strong ? 700 : 500} 34px system-ui, sans-serif`;
  pen.textBaseline = "middle";
  pen.fillText(text, 4, 34);
  const texture = new CanvasTexture(canvas);
  texture.anisotropy = 4;
  return texture;
}
