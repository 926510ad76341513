/** The look: slate greys, one blue for what can be done, and signal colours that mean the same everywhere. */
import { createTheme, type MantineColorsTuple } from "@mantine/core";

const slate: MantineColorsTuple = [
  "#d5d9e0",
  "#b4bac4",
  "#8d95a3",
  "#6a7280",
  "#4a515e",
  "#353b46",
  "#272c35",
  "#1c2027",
  "#15181e",
  "#0f1216",
];

const steel: MantineColorsTuple = [
  "#e8f2fb",
  "#d0e3f4",
  "#a2c6e8",
  "#70a8dc",
  "#478ed2",
  "#2e7ecb",
  "#1f75c8",
  "#1164b1",
  "#02599f",
  "#004d8d",
];

export const theme = createTheme({
  colors: { dark: slate, steel },
  primaryColor: "steel",
  primaryShade: { light: 7, dark: 5 },
  defaultRadius: "sm",
  cursorType: "pointer",
  respectReducedMotion: true,
  fontFamily: 'system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", "DejaVu Sans", sans-serif',
  fontFamilyMonospace: 'ui-monospace, "Cascadia Mono", "DejaVu Sans Mono", Menlo, Consolas, monospace',
  headings: { fontWeight: "650" },
  components: {
    Tooltip: { defaultProps: { withArrow: true, openDelay: 300, multiline: true, maw: 320 } },
    NumberInput: { defaultProps: { hideControls: false, decimalSeparator: "." } },
  },
});
