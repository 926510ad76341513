/**
 * The floor map: OpenLayers in metres, fed from the live store without React in between. Owns the layers, decides when to
 * draw, and tells its owner what was clicked.
 */
import OpenLayersMap from "ol/Map";
import type MapBrowserEvent from "ol/MapBrowserEvent";
import View from "ol/View";
import { defaults as defaultInteractions } from "ol/interaction/defaults";
import type { LabView, SimulatedObject, Waypoint } from "../api/types";
import { occupiedRuns, type Rectangle } from "../geometry/raster";
import type { Point } from "../geometry/points";
import { liveStore, serverNowMs, type Live } from "../live/store";
import { DraggablePoints } from "./DraggablePoints";
import { FloorPicture } from "./FloorPicture";
import { useFloor } from "./floor-state";
import { hookLayer } from "./hook-layer";
import { paintFloor, paintTraffic } from "./paint/scene";
import { paletteOf, type Palette } from "./palette";
import { floorProjection } from "./projection";
import { RobotMarks } from "./RobotMarks";
import { objectStyle, waypointStyle } from "./styles";

/** What lies under a point of the map. */
export interface Hit {
  readonly point: Point;
  readonly robot: string | null;
  readonly waypoint: Waypoint | null;
  readonly object: SimulatedObject | null;
}

export interface FloorMapActions {
  readonly onClick: (hit: Hit) => void;
  readonly onMenu: (hit: Hit, at: { clientX: number; clientY: number }) => void;
  readonly onMoveWaypoint: (waypoint: Waypoint, x: number, y: number) => Promise<boolean>;
  readonly onMoveObject: (object: SimulatedObject, x: number, y: number) => Promise<boolean>;
}

const FRAME_MS = 33;
const MARGIN_M = 0.4;
/** Things are grabbed within this distance, however small they are drawn. */
const REACH_PX = 14;
/** How often the map looks by itself whether what it shows has grown old. */
const AGEING_MS = 1000;

export class FloorMap {
  readonly map: OpenLayersMap;
  private palette: Palette;
  private lab: LabView | null = null;
  private speedZones: unknown = null;
  private obstacles: { from: unknown; cells: readonly Rectangle[] } = { from: null, cells: [] };
  private readonly robots = new RobotMarks();
  private readonly picture: FloorPicture;
  private readonly waypoints: DraggablePoints<Waypoint>;
  private readonly objects: DraggablePoints<SimulatedObject>;
  private readonly endings: (() => void)[] = [];
  private drawnMs = 0;
  private nextFrame: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly target: HTMLElement,
    scheme: "light" | "dark",
    private readonly actions: FloorMapActions,
  ) {
    this.palette = paletteOf(scheme);
    this.picture = new FloorPicture(() => this.map.render());
    this.waypoints = new DraggablePoints<Waypoint>({
      zIndex: 2,
      style: (waypoint, resolution) => waypointStyle(this.palette, waypoint, resolution),
      reach: ({ radius_m }, resolution) => Math.max(radius_m, REACH_PX * resolution),
      onMove: actions.onMoveWaypoint,
    });
    this.objects = new DraggablePoints<SimulatedObject>({
      zIndex: 3,
      style: (thing) => objectStyle(this.palette, thing),
      reach: (_, resolution) => REACH_PX * resolution,
      onMove: actions.onMoveObject,
    });
    this.map = new OpenLayersMap({
      target,
      controls: [],
      interactions: defaultInteractions({ altShiftDragRotate: false, pinchRotate: false, doubleClickZoom: false }),
      view: new View({ projection: floorProjection, center: [0, 0], resolution: 0.01, constrainResolution: false }),
      layers: [
        hookLayer(0, (pen) =>
          paintFloor(pen, {
            palette: this.palette,
            lab: this.lab,
            picture: this.picture.picture,
            state: liveStore.getState().state,
            obstacles: this.obstacles.cells,
            layers: useFloor.getState().layers,
          }),
        ),
        this.waypoints.layer,
        this.objects.layer,
        hookLayer(4, (pen) => {
          const now = performance.now();
          const { layers, robot } = useFloor.getState();
          paintTraffic(pen, { palette: this.palette, layers, robots: this.robots, selected: robot, nowMs: now });
          this.afterFrame(now);
        }),
      ],
    });
    this.map.on("click", (event) => this.actions.onClick(this.hit(event.pixel)));
    this.map.on("pointermove", (event) => this.hover(event));
    const onMenu = (event: MouseEvent) => {
      event.preventDefault();
      this.actions.onMenu(this.hit(this.map.getEventPixel(event)), event);
    };
    target.addEventListener("contextmenu", onMenu);
    const ageing = setInterval(() => this.take(liveStore.getState()), AGEING_MS);
    this.endings.push(
      () => clearInterval(ageing),
      () => target.removeEventListener("contextmenu", onMenu),
      liveStore.subscribe((live) => this.take(live)),
      useFloor.subscribe(() => this.applyChoices()),
    );
    this.applyChoices();
    this.take(liveStore.getState());
  }

  dispose(): void {
    for (const end of this.endings) end();
    clearTimeout(this.nextFrame);
    this.picture.dispose();
    this.map.setTarget(undefined);
    this.map.dispose();
  }

  setScheme(scheme: "light" | "dark"): void {
    this.palette = paletteOf(scheme);
    this.waypoints.restyle();
    this.objects.restyle();
    this.map.render();
  }

  setLab(lab: LabView): void {
    const isFirst = this.lab === null;
    this.lab = lab;
    if (isFirst) this.fit();
    this.map.render();
  }

  /** Shows all areas. */
  fit(): void {
    if (!this.lab) return;
    const [minX, minY, maxX, maxY] = this.lab.bounds;
    this.map.updateSize();
    this.map.getView().fit([minX - MARGIN_M, minY - MARGIN_M, maxX + MARGIN_M, maxY + MARGIN_M]);
  }

  zoom(factor: number): void {
    this.map.getView().animate({ resolution: (this.map.getView().getResolution() ?? 0.01) / factor, duration: 150 });
  }

  /** Brings a robot to the middle, unless the whole floor can be seen anyway or `always` is set. */
  centreOn(robot: string, always: boolean): void {
    const pose = this.robots.poseOf(robot, performance.now());
    if (!pose || (!always && this.showsAll())) return;
    this.map.getView().animate({ center: [pose.x, pose.y], duration: 250 });
  }

  private showsAll(): boolean {
    const [minX = 0, minY = 0, maxX = 0, maxY = 0] = this.map.getView().calculateExtent();
    const [left, bottom, right, top] = this.lab?.bounds ?? [-Infinity, -Infinity, Infinity, Infinity];
    return minX <= left && minY <= bottom && maxX >= right && maxY >= top;
  }

  /** Pixel of the page at which a point of the floor (m) is drawn. */
  toPixel(x: number, y: number): [x: number, y: number] {
    this.map.renderSync();
    const [left = 0, top = 0] = this.map.getPixelFromCoordinate([x, y]);
    const box = this.target.getBoundingClientRect();
    return [box.left + left, box.top + top];
  }

  setEditable(editable: boolean): void {
    for (const { interaction } of [this.waypoints, this.objects]) {
      this.map.removeInteraction(interaction);
      if (editable) this.map.addInteraction(interaction);
    }
  }

  private take({ state }: Live): void {
    const now = performance.now();
    this.waypoints.update(state.waypoints);
    this.objects.update(state.objects);
    let changed = this.robots.update(state.robots, serverNowMs(), now);
    if (state.obstacles !== this.obstacles.from) {
      this.obstacles = { from: state.obstacles, cells: state.obstacles ? occupiedRuns(state.obstacles) : [] };
      changed = true;
    }
    if (state.speed_zones !== this.speedZones) {
      this.speedZones = state.speed_zones;
      changed = true;
    }
    if (changed) this.requestFrame(now);
  }

  /** Draws soon, at most 30 times a second. */
  private requestFrame(nowMs: number): void {
    clearTimeout(this.nextFrame);
    this.nextFrame = setTimeout(() => this.map.render(), Math.max(0, FRAME_MS - (nowMs - this.drawnMs)));
  }

  private afterFrame(nowMs: number): void {
    this.drawnMs = nowMs;
    if (!this.robots.isMoving(nowMs)) return;
    const { robot, follows } = useFloor.getState();
    const pose = follows && robot !== null ? this.robots.poseOf(robot, nowMs) : null;
    if (pose) this.map.getView().setCenter([pose.x, pose.y]);
    this.requestFrame(nowMs);
  }

  private applyChoices(): void {
    const { layers } = useFloor.getState();
    this.waypoints.layer.setVisible(layers.waypoints);
    if (layers.picture) this.picture.start();
    else this.picture.stop();
    this.map.render();
  }

  private hit(pixel: number[]): Hit {
    const [x = 0, y = 0] = this.map.getCoordinateFromPixel(pixel);
    const resolution = this.map.getView().getResolution() ?? 0.01;
    return {
      point: [x, y],
      robot: this.robots.at([x, y], 1 / resolution, performance.now()),
      waypoint: this.waypoints.layer.getVisible() ? this.waypoints.at([x, y], resolution) : null,
      object: this.objects.at([x, y], resolution),
    };
  }

  private hover(event: MapBrowserEvent): void {
    if (event.dragging) return;
    const { robot, waypoint, object } = this.hit(event.pixel);
    const isPlacing = useFloor.getState().mode === "place";
    const cursor = robot ? "pointer" : (waypoint ?? object) ? "grab" : isPlacing ? "crosshair" : "";
    this.target.style.cursor = cursor;
  }
}
