/** Calibration of cameras and floor tags, step by step, while everything runs. */
import { Alert, Stepper, Text } from "@mantine/core";
import { IconCamera, IconChecklist, IconTargetArrow } from "@tabler/icons-react";
import { Page } from "../ui/Page";
import { CollectStep } from "./CollectStep";
import { CompareStep } from "./CompareStep";
import { InForce } from "./InForce";
import { LookStep } from "./LookStep";
import { leftOver, stageOf } from "./stage";
import { useCalibration } from "./use-calibration";

const STEPS = { look: 0, collect: 1, compare: 2 } as const;

export default function CalibrationPage() {
  const { view, problem, refresh } = useCalibration();
  const stage = view && stageOf(view);
  const message = view && leftOver(view);
  return (
    <Page
      title="Calibration"
      note="Where the cameras hang and where the floor tags lie. A camera that is pushed finds its place by itself; calibrate when you have cleaned up, or want it better."
    >
      {problem !== null && (
        <Alert color="red" title="The state of the calibration is not known">
          {problem}
        </Alert>
      )}
      {!view && problem === null && <Text c="dimmed">Asking for the state of the calibration…</Text>}
      {view && stage && (
        <>
          <Stepper
            active={STEPS[stage]}
            size="sm"
            allowNextStepsSelect={false}
            data-testid="calibration-stage"
            data-stage={stage}
          >
            <Stepper.Step icon={<IconCamera size={18} />} label="Look" description="Do cameras see their floor tags?" />
            <Stepper.Step icon={<IconTargetArrow size={18} />} label="Collect" description="Some frames of each" />
            <Stepper.Step icon={<IconChecklist size={18} />} label="Compare" description="Accept or discard" />
          </Stepper>
          {message && (
            <Alert color="orange" title={message.title} data-testid="calibration-message">
              {message.text}
            </Alert>
          )}
          {stage === "look" && <LookStep onStarted={refresh} />}
          {stage === "collect" && <CollectStep view={view} />}
          {stage === "compare" && view.proposal && (
            <CompareStep proposal={view.proposal} note={view.run?.text ?? ""} onDecided={refresh} />
          )}
          <InForce current={view.current} previous={view.previous} onChanged={refresh} />
        </>
      )}
    </Page>
  );
}
