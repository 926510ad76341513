/** Makes a simulated camera stall, vanish, send garbage or hang elsewhere, to see how the system takes it. */
import { Button, Menu } from "@mantine/core";
import { act } from "../api/action";
import { call } from "../api/client";
import type { CameraFault } from "../api/types";
import { useMay } from "../app/session";
import { Guarded } from "../ui/Guarded";

/** What can be tried, in the words of the menu; the bump is of two centimetres. */
const FAULTS: readonly { readonly label: string; readonly fault: Pick<CameraFault, "kind"> & Partial<CameraFault> }[] =
  [
    { label: "Stall: no more frames", fault: { kind: "stall" } },
    { label: "Unplug", fault: { kind: "unplug" } },
    { label: "Garbage: random pixels", fault: { kind: "noise" } },
    { label: "Frames of half the size", fault: { kind: "resize" } },
    { label: "Cover half of the view", fault: { kind: "cover", cover_share: 0.5 } },
    { label: "Bump by 2 cm", fault: { kind: "bump", shift_x_m: 0.02 } },
  ];

interface FaultMenuProps {
  readonly camera: string;
  readonly fault: CameraFault | null;
}

export function FaultMenu({ camera, fault }: FaultMenuProps) {
  const may = useMay("operator");
  const path = { camera_id: camera };
  if (fault)
    return (
      <Guarded>
        <Button
          size="compact-xs"
          variant="light"
          color="orange"
          data-testid={`end-fault-${camera}`}
          onClick={() => void act(`Ending the fault of ${camera}`, () => call("delete", PATH, { path }))}
        >
          End simulated {fault.kind}
        </Button>
      </Guarded>
    );
  return (
    <Menu position="bottom-end" withinPortal>
      <Menu.Target>
        <Button
          size="compact-xs"
          variant="subtle"
          color="gray"
          disabled={!may}
          title={may ? "What does the system do when this camera fails?" : "This needs the role operator."}
          data-testid={`try-fault-${camera}`}
        >
          Try a fault
        </Button>
      </Menu.Target>
      <Menu.Dropdown>
        {FAULTS.map(({ label, fault: chosen }) => (
          <Menu.Item
            key={chosen.kind}
            data-testid={`fault-${chosen.kind}`}
            onClick={() =>
              void act(`Trying a fault of ${camera}`, () =>
                call("put", PATH, { path, body: { ...HARMLESS, ...chosen } }),
              )
            }
          >
            {label}
          </Menu.Item>
        ))}
      </Menu.Dropdown>
    </Menu>
  );
}

const PATH = "/api/sim/cameras/{camera_id}/fault";
const HARMLESS = { cover_share: 1, shift_x_m: 0, shift_y_m: 0, shift_z_m: 0, tilt_x: 0, tilt_y: 0 };
