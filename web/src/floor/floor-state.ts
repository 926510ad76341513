/** What the operator has chosen on the floor page: a robot, a mode of the pointer, and which layers are shown. */
import { create } from "zustand";
import { persist } from "zustand/middleware";

export const LAYERS = {
  picture: "Floor picture",
  grid: "Grid",
  zones: "Zones",
  speeds: "Speed limits",
  cameras: "Camera views",
  routes: "Routes",
  obstacles: "Obstacles",
  boxes: "Obstacle boxes",
  waypoints: "Waypoints",
} as const;

export type LayerName = keyof typeof LAYERS;
export type PointerMode = "select" | "place";

interface FloorState {
  readonly robot: string | null;
  readonly mode: PointerMode;
  readonly follows: boolean;
  readonly layers: Readonly<Record<LayerName, boolean>>;
}

const SHOWN: Readonly<Record<LayerName, boolean>> = {
  picture: true,
  grid: true,
  zones: true,
  speeds: true,
  cameras: false,
  routes: true,
  obstacles: true,
  boxes: true,
  waypoints: true,
};

export const useFloor = create<FloorState>()(
  persist((): FloorState => ({ robot: null, mode: "select", follows: false, layers: SHOWN }), {
    name: "lilliput-floor",
    partialize: ({ robot, layers }) => ({ robot, layers }),
    merge: (stored, state) => {
      const { robot, layers } = (stored ?? {}) as Partial<FloorState>;
      return { ...state, robot: robot ?? null, layers: { ...SHOWN, ...layers } };
    },
  }),
);

export function selectRobot(robot: string | null): void {
  useFloor.setState({ robot, ...(robot === null && { follows: false }) });
}

export function setMode(mode: PointerMode): void {
  useFloor.setState({ mode });
}

export function setFollows(follows: boolean): void {
  useFloor.setState({ follows });
}

export function toggleLayer(layer: LayerName): void {
  useFloor.setState(({ layers }) => ({ layers: { ...layers, [layer]: !layers[layer] } }));
}
