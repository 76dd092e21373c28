// What walkers are called, over their heads; pressed, a name makes its walker the one looked at.

import { Vector3, type PerspectiveCamera } from "three";
import type { Motion } from "../motion";
import type { Walker } from "../show";
import { make } from "../ui/dom";

const CROWDED = 560; // px, of a scene too narrow for more than one name

export class Names {
  private readonly tags: HTMLButtonElement[];
  private readonly seen = new Vector3();

  constructor(private readonly place: HTMLElement, walkers: Walker[], choose: (walker: number) => void) {
    const alone = walkers.length === 1;
    this.tags = alone ? [] : walkers.map((walker, index) => {
      // The list beside the scene serves those who do not point at things.
      const tag = make("button", { class: "name", type: "button", tabindex: "-1", "aria-hidden": "true" });
      tag.textContent = walker.label;
      tag.addEventListener("click", () => choose(index));
      place.append(tag);
      return tag;
    });
  }

  /** Puts the names where heads are seen. */
  show(camera: PerspectiveCamera, heads: Vector3[], chosen: number, time: number, motions: Motion[]): void {
    const { clientWidth: width, clientHeight: height } = this.place;
    this.tags.forEach((tag, walker) => {
      const far = heads[walker]!.distanceTo(camera.position);
      this.seen.copy(heads[walker]!).project(camera);
      const inSight = Math.abs(this.seen.x) < 1.05 && Math.abs(this.seen.y) < 1.05 && this.seen.z < 1;
      tag.hidden = !inSight || (walker !== chosen && (far > 45 || width < CROWDED));
      if (tag.hidden) return;
      const x = (0.5 + 0.5 * this.seen.x) * width;
      const y = (0.5 - 0.5 * this.seen.y) * height;
      tag.style.transform = `translate(-50%, -100%) translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
      tag.style.zIndex = String(100 - walker);
      tag.classList.toggle("chosen", walker === chosen);
      const motion = motions[walker]!;
      tag.classList.toggle("fallen", motion.walker.ending === "fall" && motion.hasEnded(time));
    });
  }
}
