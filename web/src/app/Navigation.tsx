/** The pages: a rail at the side, a bar at the bottom of a phone. */
import {
  IconActivityHeartbeat,
  IconCamera,
  IconChartCandle,
  IconCube,
  IconHistory,
  IconMap2,
  IconRoute,
  IconTargetArrow,
  IconUsers,
  type Icon,
} from "@tabler/icons-react";
import { NavLink } from "react-router";
import type { Role } from "../api/types";
import { useMay } from "./session";
import classes from "./shell.module.css";

interface Entry {
  readonly to: string;
  readonly label: string;
  readonly icon: Icon;
  readonly needs?: Role;
}

const ENTRIES: readonly Entry[] = [
  { to: "/floor", label: "Floor", icon: IconMap2 },
  { to: "/routes", label: "Routes", icon: IconRoute },
  { to: "/cameras", label: "Cameras", icon: IconCamera },
  { to: "/calibration", label: "Calibrate", icon: IconTargetArrow },
  { to: "/3d", label: "3D", icon: IconCube },
  { to: "/events", label: "Events", icon: IconHistory },
  { to: "/logs", label: "Logs", icon: IconChartCandle },
  { to: "/system", label: "System", icon: IconActivityHeartbeat },
  { to: "/admin", label: "Users", icon: IconUsers, needs: "admin" },
];

export function Navigation() {
  const isAdmin = useMay("admin");
  return (
    <nav className={classes["nav"]} aria-label="Pages">
      {ENTRIES.filter((entry) => entry.needs === undefined || isAdmin).map(({ to, label, icon: EntryIcon }) => (
        <NavLink key={to} to={to} className={classes["navLink"] ?? ""} data-testid={`nav-${to.slice(1)}`}>
          <EntryIcon size={22} stroke={1.6} />
          <span>{label}</span>
        </NavLink>
      ))}
    </nav>
  );
}
