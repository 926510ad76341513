/** Colours of the floor map. Red means stop, green a place to go, blue a box that is clear, in both schemes. */
import type { Tone } from "../fleet/robot-state";

export interface Palette {
  readonly ground: string;
  readonly grid: string;
  readonly gridMajor: string;
  readonly gridText: string;
  readonly area: string;
  readonly zone: string;
  readonly zoneFill: string;
  readonly speed: string;
  readonly speedFill: string;
  readonly camera: string;
  readonly route: string;
  readonly waypoint: string;
  readonly waypointFill: string;
  readonly obstacle: string;
  readonly box: string;
  readonly boxFill: string;
  readonly blocked: string;
  readonly blockedFill: string;
  readonly chip: string;
  readonly chipText: string;
  readonly object: string;
  readonly tones: Readonly<Record<Tone, string>>;
}

const signals = {
  waypoint: "#1faa59",
  waypointFill: "rgba(31, 170, 89, 0.22)",
  obstacle: "rgba(225, 29, 40, 0.78)",
  box: "#2f8fff",
  boxFill: "rgba(47, 143, 255, 0.20)",
  blocked: "#ff2d3d",
  blockedFill: "rgba(255, 45, 61, 0.28)",
  object: "#b7791f",
} as const;

const light: Palette = {
  ...signals,
  ground: "#e9ecf0",
  grid: "rgba(40, 55, 75, 0.14)",
  gridMajor: "rgba(40, 55, 75, 0.30)",
  gridText: "#51606f",
  area: "#3f4c5c",
  zone: "#8447c9",
  zoneFill: "rgba(132, 71, 201, 0.10)",
  speed: "#a15c00",
  speedFill: "rgba(214, 137, 16, 0.16)",
  camera: "#0a7ea4",
  route: "#0f8f47",
  chip: "rgba(255, 255, 255, 0.92)",
  chipText: "#17202b",
  tones: {
    driving: "#0d8f7b",
    waiting: "#d97706",
    manual: "#8b3fd1",
    idle: "#4a6785",
    fault: "#d0021b",
    offline: "#858f9b",
  },
};

const dark: Palette = {
  ...signals,
  ground: "#0f1216",
  grid: "rgba(190, 205, 225, 0.10)",
  gridMajor: "rgba(190, 205, 225, 0.24)",
  gridText: "#8d95a3",
  area: "#aab4c2",
  zone: "#b98af0",
  zoneFill: "rgba(185, 138, 240, 0.12)",
  speed: "#f2b84b",
  speedFill: "rgba(242, 184, 75, 0.16)",
  camera: "#45b8dc",
  route: "#35c777",
  chip: "rgba(21, 24, 30, 0.88)",
  chipText: "#eef1f5",
  tones: {
    driving: "#19b89f",
    waiting: "#f59e0b",
    manual: "#b06af0",
    idle: "#7d9cbd",
    fault: "#ff3b4b",
    offline: "#7b8490",
  },
};

export function paletteOf(scheme: "light" | "dark"): Palette {
  return scheme === "dark" ? dark : light;
}
