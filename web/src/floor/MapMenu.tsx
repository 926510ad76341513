/** What can be done at a place of the map: the menu of a right click or a long press. */
import { Menu } from "@mantine/core";
import { IconCurrentLocation, IconMapPin, IconPackage, IconSend, IconTrash, IconUser } from "@tabler/icons-react";
import { useLab } from "../app/lab";
import { useMay } from "../app/session";
import { isAssigned } from "../fleet/robot-state";
import { useLive } from "../live/store";
import { addObject, addWaypoint, removeObject, removeWaypoint, sendRobot } from "./edits";
import { selectRobot, useFloor } from "./floor-state";
import type { Hit } from "./FloorMap";

export interface MenuRequest {
  readonly hit: Hit;
  readonly clientX: number;
  readonly clientY: number;
}

interface MapMenuProps {
  readonly request: MenuRequest | null;
  readonly onClose: () => void;
}

export function MapMenu({ request, onClose }: MapMenuProps) {
  const lab = useLab();
  const may = useMay("operator");
  const selected = useFloor((floor) => floor.robot);
  const robot = useLive((live) => (selected === null ? undefined : live.state.robots[selected]));
  if (!request || !lab) return null;
  const { point, waypoint, object, robot: robotHere } = request.hit;
  const [x, y] = point;
  return (
    <Menu opened onClose={onClose} position="bottom-start" width={260} withinPortal closeOnItemClick>
      <Menu.Target>
        <div style={{ position: "fixed", left: request.clientX, top: request.clientY }} />
      </Menu.Target>
      <Menu.Dropdown data-testid="map-menu">
        <Menu.Label>
          x {x.toFixed(2)} m, y {y.toFixed(2)} m
        </Menu.Label>
        {robotHere !== null && (
          <Menu.Item leftSection={<IconCurrentLocation size={16} />} onClick={() => selectRobot(robotHere)}>
            Select {robotHere}
          </Menu.Item>
        )}
        {waypoint && (
          <Menu.Item
            color="red"
            disabled={!may}
            leftSection={<IconTrash size={16} />}
            onClick={() => void removeWaypoint(waypoint)}
          >
            Delete waypoint {waypoint.id}
          </Menu.Item>
        )}
        {object && (
          <Menu.Item
            color="red"
            disabled={!may}
            data-testid="menu-remove-object"
            leftSection={<IconTrash size={16} />}
            onClick={() => void removeObject(object)}
          >
            Remove {object.id}
          </Menu.Item>
        )}
        <Menu.Item
          disabled={!may}
          data-testid="menu-add-waypoint"
          leftSection={<IconMapPin size={16} />}
          onClick={() => void addWaypoint(lab, point)}
        >
          Add waypoint here
        </Menu.Item>
        <Menu.Item
          disabled={!may || !robot}
          data-testid="menu-send-robot"
          leftSection={<IconSend size={16} />}
          onClick={() => robot && void sendRobot(lab, robot, point)}
        >
          {!robot
            ? "Send a robot here (select one first)"
            : `Send ${robot.id} here${isAssigned(robot) ? " (ends its route)" : ""}`}
        </Menu.Item>
        {lab.simulated && (
          <>
            <Menu.Divider />
            <Menu.Label>Simulated floor</Menu.Label>
            <Menu.Item
              disabled={!may}
              data-testid="menu-add-pallet"
              leftSection={<IconPackage size={16} />}
              onClick={() => void addObject("pallet", point)}
            >
              Put a pallet here
            </Menu.Item>
            <Menu.Item
              disabled={!may}
              data-testid="menu-add-person"
              leftSection={<IconUser size={16} />}
              onClick={() => void addObject("person", point)}
            >
              Put a person here
            </Menu.Item>
          </>
        )}
        {!may && <Menu.Label>Your role may only look.</Menu.Label>}
      </Menu.Dropdown>
    </Menu>
  );
}
