/** Puts the floor map on the page and connects it with what a person does there. */
import "ol/ol.css";
import { Box, useComputedColorScheme } from "@mantine/core";
import { useEffect, useEffectEvent, useRef, useState, type RefObject } from "react";
import { useLab } from "../app/lab";
import { useMay } from "../app/session";
import { addWaypoint, moveObject, moveWaypoint } from "./edits";
import classes from "./floor.module.css";
import { selectRobot, setMode, useFloor } from "./floor-state";
import { FloorMap, type Hit } from "./FloorMap";
import { MapMenu, type MenuRequest } from "./MapMenu";
import { undoNewest } from "./undo";

export function MapView({ mapRef }: { readonly mapRef: RefObject<FloorMap | null> }) {
  const target = useRef<HTMLDivElement>(null);
  const lab = useLab();
  const scheme = useComputedColorScheme();
  const mayEdit = useMay("operator");
  const [menu, setMenu] = useState<MenuRequest | null>(null);

  const onClick = useEffectEvent(({ robot, waypoint, object, point }: Hit) => {
    if (robot !== null) selectRobot(robot);
    else if (lab && mayEdit && !waypoint && !object && useFloor.getState().mode === "place")
      void addWaypoint(lab, point);
  });
  const onKey = useEffectEvent((event: KeyboardEvent) => {
    if (event.key === "Escape") setMode("select");
    const isTyping = event.target instanceof HTMLElement && event.target.closest("input, textarea") !== null;
    if (event.key.toLowerCase() === "z" && (event.ctrlKey || event.metaKey) && !isTyping) {
      event.preventDefault();
      undoNewest();
    }
  });
  const onMoveWaypoint = useEffectEvent<ConstructorParameters<typeof FloorMap>[2]["onMoveWaypoint"]>(
    async (waypoint, x, y) => (lab ? moveWaypoint(lab, waypoint, x, y) : false),
  );
  const onFirstScheme = useEffectEvent(() => scheme);

  useEffect(() => {
    if (!target.current) return;
    const map = new FloorMap(target.current, onFirstScheme(), {
      onClick: (hit) => onClick(hit),
      onMenu: (hit, { clientX, clientY }) => setMenu({ hit, clientX, clientY }),
      onMoveWaypoint: (waypoint, x, y) => onMoveWaypoint(waypoint, x, y),
      onMoveObject: moveObject,
    });
    mapRef.current = map;
    const endExposure = expose(map);
    window.addEventListener("keydown", onKey);
    return () => {
      window.removeEventListener("keydown", onKey);
      endExposure();
      mapRef.current = null;
      map.dispose();
    };
  }, [mapRef]);
  useEffect(() => mapRef.current?.setScheme(scheme), [mapRef, scheme]);
  useEffect(() => {
    if (lab) mapRef.current?.setLab(lab);
  }, [mapRef, lab]);
  useEffect(() => mapRef.current?.setEditable(mayEdit), [mapRef, mayEdit]);

  return (
    <>
      <Box
        ref={target}
        className={classes["map"] ?? ""}
        data-testid="floor-map"
        tabIndex={0}
        aria-label="Map of the floor. Drag to pan, scroll to zoom, right-click for what can be done at a place."
      />
      <MapMenu request={menu} onClose={() => setMenu(null)} />
    </>
  );
}

interface Exposed {
  readonly map: FloorMap["map"];
  /** Pixel of the page at which a point of the floor (m) is drawn. */
  readonly toPixel: (x: number, y: number) => [x: number, y: number];
}

declare global {
  interface Window {
    /** For tests and scripts in the browser's console. */
    lilliput?: Exposed;
  }
}

function expose(floor: FloorMap): () => void {
  window.lilliput = { map: floor.map, toPixel: (x, y) => floor.toPixel(x, y) };
  return () => delete window.lilliput;
}
