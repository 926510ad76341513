/** A secret that is shown once: to copy, and then gone. */
import { Alert, Button, Code, CopyButton, Group, Text } from "@mantine/core";
import { IconCheck, IconCopy } from "@tabler/icons-react";

interface SecretProps {
  readonly what: string;
  readonly text: string;
  readonly onClose: () => void;
}

export function Secret({ what, text, onClose }: SecretProps) {
  return (
    <Alert color="teal" title={`${what} (shown this once)`} withCloseButton onClose={onClose} data-testid="secret">
      <Group wrap="nowrap" align="center">
        <Code block flex={1} style={{ overflowWrap: "anywhere", whiteSpace: "pre-wrap" }}>
          {text}
        </Code>
        <CopyButton value={text}>
          {({ copied, copy }) => (
            <Button
              size="xs"
              variant="default"
              leftSection={copied ? <IconCheck size={14} /> : <IconCopy size={14} />}
              onClick={copy}
            >
              {copied ? "Copied" : "Copy"}
            </Button>
          )}
        </CopyButton>
      </Group>
      <Text size="xs" c="dimmed" mt={6}>
        Keep it now: only a digest of it is stored.
      </Text>
    </Alert>
  );
}
