// Where walkers are drawn: alone as they walked, several side by side with their paths laid straight.

import type { Motion } from "../motion";
import type { Ground } from "../show";
import type { Lane } from "./ground";

const PITCH = 0.9; // m from lane to lane
const SMOOTH = 0.8; // m to either side over which a path is averaged

/** Returns every walker's lane. */
export function lay(motions: Motion[], ground: Ground): Lane[] {
  if (motions.length === 1) return [{ y: 0, path: () => 0 }];
  return motions.map((motion, walker) => ({
    y: walker * PITCH,
    path: ground.rows > 1 ? path(motion, ground) : () => 0,
  }));
}

/** Returns the line that a walker in space followed: its y over x, without the steps' sway. */
function path(motion: Motion, ground: Ground): (x: number) => number {
  const [xs, ys] = [motion.moves[0]!, motion.moves[1]!];
  const { x: start, spacing } = ground;
  const sums: number[] = [];
  const counts: number[] = [];
  xs.forEach((x, frame) => {
    const middle = Math.round((x - start) / spacing);
    const reach = Math.round(SMOOTH / spacing);
    for (let node = Math.max(middle - reach, 0); node <= middle + reach; node++) {
      sums[node] = (sums[node] ?? 0) + ys[frame]!;
      counts[node] = (counts[node] ?? 0) + 1;
    }
  });
  const nodes: number[] = [];
  const first = counts.findIndex((count) => count > 0);
  for (let node = 0; node < counts.length; node++) {
    const from = Math.max(node, first);
    nodes[node] = counts[from] ? sums[from]! / counts[from]! : nodes[node - 1]!;
  }
  return (x) => {
    const along = Math.min(Math.max((x - start) / spacing, 0), nodes.length - 1.001);
    const node = Math.floor(along);
    return nodes[node]! + (along - node) * (nodes[node + 1]! - nodes[node]!);
  };
}
