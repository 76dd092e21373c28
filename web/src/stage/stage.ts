// The scene: walkers, ground, light and camera, drawn at a time.

import {
  Color, DirectionalLight, Fog, HemisphereLight, Matrix4, PCFShadowMap, Scene, Vector3,
  WebGLRenderer,
} from "three";
import { Motion } from "../motion";
import type { Body, Show } from "../show";
import { Skeleton } from "../skeleton";
import { themeOf } from "../theme";
import { Arrows } from "./arrows";
import { Cameras } from "./cameras";
import { Figures } from "./figure";
import { Terrain, type Lane } from "./ground";
import { lay } from "./lanes";
import { Names } from "./names";
import { Quality } from "./quality";
import { Trail } from "./sticks";

const SPREAD = 1.2; // by which a foot's distance from the middle asks for more room than hips as high

export class Stage {
  readonly cameras: Cameras;
  chosen = 0;
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly skeleton: Skeleton;
  private readonly figures: Figures;
  private readonly terrain: Terrain;
  private readonly arrows: Arrows;
  private readonly trail: Trail;
  private readonly names: Names;
  private readonly lanes: Lane[];
  private readonly links: Matrix4[][];
  private readonly coordinates: Float32Array;
  private readonly sun = new DirectionalLight("#ffffff", 2.1);
  private readonly front = new DirectionalLight("#ffffff", 1);
  private readonly sky = new HemisphereLight("#ffffff", "#b8ab98", 1.5);
  private readonly hips: number;
  private readonly quality = new Quality();
  private shownTime = -1;
  private stale = true; // whether something but the time has changed
  private wasDrawn = false;

  constructor(
    private readonly place: HTMLElement,
    show: Show,
    private readonly motions: Motion[],
    heights: Float32Array[],
    changed: () => void,
    choose: (walker: number) => void,
  ) {
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true, powerPreference: "high-performance" });
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFShadowMap;
    const canvas = this.renderer.domElement;
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `${show.what} of ${show.title}, walking in 3D`);
    place.prepend(canvas);
    this.skeleton = new Skeleton(show.body);
    this.lanes = lay(motions, show.ground);
    this.coordinates = new Float32Array(motions[0]!.moves.length);
    this.links = motions.map(() => Array.from({ length: this.skeleton.size }, () => new Matrix4()));
    this.hips = this.hipHeight();
    this.terrain = new Terrain(this.scene, show.ground, heights, this.lanes);
    this.figures = new Figures(this.scene, show.body, motions.length);
    this.arrows = new Arrows(this.scene, show.body, show.weight_n, this.hips, motions.length);
    this.trail = new Trail(this.scene, show.body, this.skeleton, motions, this.lanes);
    const room = Math.max(this.hips, SPREAD * this.farthestFoot(show.body));
    this.cameras = new Cameras(
      canvas, 2.05 * room, this.lanes.at(-1)!.y, () => this.target(), changed,
    );
    this.names = new Names(place, show.walkers, choose);
    this.lit();
    new ResizeObserver(() => this.resize()).observe(place);
    this.resize();
    this.paint();
    this.draw(0, 0, true);
    this.cameras.look(motions.length > 1 ? "all" : "corner");
  }

  set showsTrail(visible: boolean) {
    this.trail.visible = visible;
    this.stale = true;
  }

  set showsForces(visible: boolean) {
    this.arrows.visible = visible;
    this.stale = true;
  }

  /** Gives the graphics card's memory back. */
  dispose(): void {
    this.cameras.controls.dispose();
    this.renderer.dispose();
    this.renderer.forceContextLoss();
  }

  choose(walker: number): void {
    this.chosen = walker;
    this.paint();
  }

  /** Takes the colours that hold now. */
  paint(): void {
    const theme = themeOf(this.place);
    this.scene.fog = new Fog(new Color(theme.sky), 1, 2);
    this.sky.intensity = theme.dark ? 1.5 : 2.1;
    this.sun.intensity = theme.dark ? 2.4 : 2.2;
    this.front.intensity = theme.dark ? 0.8 : 1.1;
    this.figures.paint(theme, this.chosen);
    this.terrain.paint(theme);
    this.arrows.paint(theme);
    this.trail.paint(theme, this.chosen);
    this.shownTime = NaN;
    this.stale = true;
  }

  /** Draws a time if there is anything new to see; `jumped` where time did not just go on. */
  draw(time: number, seconds: number, jumped: boolean): void {
    const moved = time !== this.shownTime;
    if (moved) {
      this.motions.forEach((motion, walker) => this.pose(motion, walker, time));
      this.figures.commit();
      this.arrows.commit();
      this.trail.show(time);
      this.shownTime = time;
    }
    const turned = this.cameras.follow(seconds, jumped);
    const draws = moved || turned || this.stale;
    if (draws && this.wasDrawn && this.quality.count(seconds)) this.resize();
    this.wasDrawn = draws;
    if (!draws) return;
    this.stale = false;
    this.light();
    this.renderer.render(this.scene, this.cameras.camera);
    this.names.show(this.cameras.camera, this.heads(), this.chosen, time, this.motions);
  }

  private pose(motion: Motion, walker: number, time: number): void {
    const moment = motion.at(time);
    const links = this.links[walker]!;
    motion.pose(moment, this.coordinates);
    this.skeleton.pose(this.coordinates, links);
    const { y, path } = this.lanes[walker]!;
    const aside = y - path(this.coordinates[0]!);
    for (const link of links) link.elements[13]! += aside;
    this.figures.place(walker, links);
    this.arrows.place(walker, motion, moment, links);
  }

  /** Returns what is looked at: a walker, or the middle of the lanes, at a height that does not bob. */
  private target(): Vector3 {
    const [x, y] = this.rootOf(this.chosen);
    const aside = y - this.lanes[this.chosen]!.y;
    const height = 0.92 * this.hips + 0.8 * this.terrain.height(this.chosen, x, aside);
    return new Vector3(x, this.cameras.sharing ? this.middle : y, height);
  }

  private get middle(): number {
    return 0.5 * this.lanes.at(-1)!.y;
  }

  private rootOf(walker: number): [number, number, number] {
    const place = this.links[walker]![0]!.elements;
    return [place[12]!, place[13]!, place[14]!];
  }

  private heads(): Vector3[] {
    return this.motions.map((_, walker) => {
      const [x, y, z] = this.rootOf(walker);
      return new Vector3(x, y, z + 1.0 * this.hips);
    });
  }

  private hipHeight(): number {
    this.motions[0]!.pose({ frame: 0, fraction: 0 }, this.coordinates);
    this.skeleton.pose(this.coordinates, this.links[0]!);
    return this.links[0]![0]!.elements[14]!;
  }

  /** Returns how far from below the hips the feet are, where a walker starts, m. */
  private farthestFoot(body: Body): number {
    const [x, y] = this.rootOf(0);
    return Math.max(...body.points.map((point) => {
      const place = new Vector3().fromArray(point.pos).applyMatrix4(this.links[0]![point.body]!);
      return Math.hypot(place.x - x, place.y - y);
    }), 0);
  }

  private lit(): void {
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(2048, 2048);
    this.sun.shadow.radius = 3;
    this.sun.shadow.bias = -0.0004;
    this.sun.shadow.normalBias = 0.012;
    const reach = Math.min(5 * this.hips + 0.8 * this.middle, 14);
    Object.assign(this.sun.shadow.camera, {
      left: -reach, right: reach, top: reach, bottom: -reach, near: 0.1, far: 40,
    });
    this.front.position.set(0.5, -1, 0.35); // from where walkers are mostly seen
    this.scene.add(this.sun, this.sun.target, this.sky, this.front);
  }

  private light(): void {
    const far = this.cameras.distanceToTarget();
    const fog = this.scene.fog as Fog;
    [fog.near, fog.far] = [1.2 * far + 3 * this.hips, 2.2 * far + 17 * this.hips];
    const { x, y } = this.target();
    this.sun.target.position.set(x, y, 0);
    this.sun.position.set(x - 3.4, y - 4.2, 9);
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.place;
    if (!width || !height) return;
    this.renderer.setPixelRatio(this.quality.pixels);
    this.renderer.setSize(width, height);
    this.sun.castShadow = this.quality.shadows;
    this.stale = true;
    this.cameras.resize(width, height);
  }
}
