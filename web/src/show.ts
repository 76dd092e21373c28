// What Python wrote into the page: `mjxwalk/player/recording.py` and `bodies.py` say what each is.

export type Side = "left" | "right" | "middle";

export interface Joint {
  move: "slide" | "hinge";
  axis: number[];
  coordinate: number;
}

export interface Link {
  name: string;
  parent: number;
  pos: number[];
  quat: number[];
  joints: Joint[];
}

export interface Part {
  body: number;
  shape: "sphere" | "capsule" | "ellipsoid" | "cylinder" | "box" | "mesh";
  side: Side;
  size: number[];
  pos: number[];
  quat: number[];
  vertices: number[];
  faces: number[];
}

export interface Point {
  body: number;
  leg: number;
  side: Side;
  pos: number[];
}

export interface Stick {
  body: number;
  side: Side;
  line: number[][];
}

export interface Angle {
  name: string;
  side: Side;
  coordinate: number;
  motor: number | null;
}

export interface Body {
  name: string;
  links: Link[];
  parts: Part[];
  points: Point[];
  sticks: Stick[];
  angles: Angle[];
}

export interface Ground {
  x: number;
  y: number;
  spacing: number;
  rows: number;
  width: number;
}

export interface Figures {
  distance_m: number;
  duration_s: number;
  speed_m_s: number | null;
  cost_of_transport: number | null;
  torque_cost: number;
}

export interface Walker {
  label: string;
  frames: number;
  ending: "fall" | "budget" | "time" | "slow" | "broken" | "open";
  why: string;
  figures: Figures;
}

export interface Stored {
  channels: number;
  places: number;
  step: number;
  offset: number;
}

export interface Show {
  title: string;
  what: string;
  facts: [string, string][];
  frame_s: number;
  weight_n: number;
  body: Body;
  ground: Ground;
  walkers: Walker[];
  series: Record<string, Stored>;
}
