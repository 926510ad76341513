/** The lab in 3D: viser in a frame, loaded again when its connection has died. */
import { Button, Center, EmptyState, Loader, useComputedColorScheme } from "@mantine/core";
import { IconCube } from "@tabler/icons-react";
import { useEffect, useRef, useState } from "react";
import { refreshSession } from "../app/session";
import { useLive } from "../live/store";
import { formatStamp } from "../ui/format";
import { usePageTitle } from "../ui/Page";
import { frameState, type FrameState } from "./frame-state";
import classes from "./scene.module.css";
import { drawsInSoftware } from "./software-rendering";

const WATCH_MS = 1000;
/** Pixels of the 3D view per pixel of the screen where no graphics card draws it. */
const COARSE = 0.5;
/** How long each state may last before the frame is loaded again. */
const PATIENCE_MS: Readonly<Record<FrameState, number>> = {
  alive: Infinity,
  dead: 4000,
  missing: 3000,
  loading: 30_000,
};

export default function ScenePage() {
  const scheme = useComputedColorScheme();
  const frame = useRef<HTMLIFrameElement>(null);
  const [state, setState] = useState<FrameState>("loading");
  const [round, setRound] = useState(0);
  const [isCoarse] = useState(drawsInSoftware);
  usePageTitle("3D");

  useEffect(() => {
    let sinceMs = Date.now();
    let last: FrameState = "loading";
    const timer = setInterval(() => {
      const now = frameState(frame.current?.contentDocument ?? null);
      if (now !== last) sinceMs = Date.now();
      last = now;
      setState((shown) => (now === "loading" && shown === "missing" ? shown : now));
      if (Date.now() - sinceMs < PATIENCE_MS[now]) return;
      if (now === "missing") void refreshSession();
      setRound((count) => count + 1);
    }, WATCH_MS);
    return () => clearInterval(timer);
  }, [round]);

  return (
    <div className={classes["stage"]} data-testid="scene" data-state={state}>
      <iframe
        key={`${round} ${scheme}`}
        ref={frame}
        className={classes["frame"]}
        src={`/viser/?hideViserLogo${scheme === "dark" ? "&darkMode" : ""}${isCoarse ? `&fixedDpr=${COARSE}` : ""}`}
        title="The lab in 3D"
        data-testid="scene-frame"
      />
      {state !== "alive" && <Cover state={state} onRetry={() => setRound(round + 1)} />}
    </div>
  );
}

function Cover({ state, onRetry }: { readonly state: FrameState; readonly onRetry: () => void }) {
  const scene = useLive((live) => live.state.health?.processes.find(({ name }) => name === "scene"));
  if (state === "loading")
    return (
      <Center className={classes["cover"] ?? ""}>
        <Loader aria-label="Loading the 3D view" />
      </Center>
    );
  const process = scene
    ? `The process scene is ${scene.state} since ${formatStamp(scene.since_ns)}${scene.last_error && ` (${scene.last_error})`}.`
    : "No process named scene is known; ./lilliput up starts it.";
  return (
    <Center className={classes["cover"] ?? ""} data-testid="scene-missing">
      <EmptyState
        icon={<IconCube />}
        title={state === "missing" ? "The 3D scene does not answer" : "The 3D scene has lost its connection"}
        description={`${process} It is tried again every few seconds.`}
      >
        <EmptyState.Actions>
          <Button variant="default" onClick={onRetry}>
            Try now
          </Button>
        </EmptyState.Actions>
      </EmptyState>
    </Center>
  );
}
