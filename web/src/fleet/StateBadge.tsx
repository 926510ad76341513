/** A robot's state as a coloured word, in the colours of the map. */
import { Badge, useComputedColorScheme } from "@mantine/core";
import { paletteOf } from "../floor/palette";
import type { RobotSummary } from "./robot-state";

export function StateBadge({ summary }: { readonly summary: RobotSummary }) {
  const palette = paletteOf(useComputedColorScheme());
  return (
    <Badge variant="filled" color={palette.tones[summary.tone]} tt="none" autoContrast data-testid="robot-state">
      {summary.word}
    </Badge>
  );
}
