/** A control that only some roles may use: shown to all, disabled with a hint for those who may not. */
import { Box, Tooltip } from "@mantine/core";
import type { ReactElement } from "react";
import { cloneElement } from "react";
import type { Role } from "../api/types";
import { useMay } from "../app/session";

interface GuardedProps {
  readonly needs?: Role;
  /** What the control does, when its own label does not say it. */
  readonly hint?: string;
  readonly children: ReactElement<{ disabled?: boolean }>;
}

export function Guarded({ needs = "operator", hint, children }: GuardedProps) {
  const may = useMay(needs);
  const label = may ? hint : `Your role may only look; this needs the role ${needs}.`;
  if (label === undefined) return children;
  return (
    <Tooltip label={label}>
      <Box component="span" display="inline-flex">
        {may ? children : cloneElement(children, { disabled: true })}
      </Box>
    </Tooltip>
  );
}
