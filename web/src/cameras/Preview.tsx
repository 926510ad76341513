/** A camera's small picture, fetched four times a second while it can be seen. */
import { useEffect, useRef, useState } from "react";
import classes from "./cameras.module.css";

const PERIOD_MS = 250;
const PERIOD_WITHOUT_MS = 2000;

export function Preview({ camera, ratio }: { readonly camera: string; readonly ratio: number }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const [isMissing, setMissing] = useState(false);

  useEffect(() => {
    const target = canvas.current;
    if (!target) return;
    let timer: ReturnType<typeof setTimeout> | undefined;
    let isInSight = false;
    let isEnded = false;
    let tag: string | null = null;

    const refresh = async () => {
      let isThere = true;
      if (isInSight && !document.hidden) {
        try {
          const response = await fetch(`/api/cameras/${encodeURIComponent(camera)}/preview.jpg`, { cache: "no-cache" });
          isThere = response.ok;
          const newTag = response.headers.get("ETag");
          if (isThere && (newTag === null || newTag !== tag)) {
            tag = newTag;
            paint(target, await createImageBitmap(await response.blob()));
          }
        } catch {
          isThere = false;
        }
        if (!isEnded) setMissing(!isThere);
      }
      if (!isEnded) timer = setTimeout(() => void refresh(), isThere ? PERIOD_MS : PERIOD_WITHOUT_MS);
    };
    const observer = new IntersectionObserver((entries) => {
      isInSight = entries.some((entry) => entry.isIntersecting);
    });
    observer.observe(target);
    void refresh();
    return () => {
      isEnded = true;
      clearTimeout(timer);
      observer.disconnect();
    };
  }, [camera]);

  return (
    <div className={classes["preview"]} style={{ aspectRatio: ratio }}>
      <canvas ref={canvas} role="img" aria-label={`Picture of ${camera}`} data-testid={`preview-${camera}`} />
      {isMissing && <span className={classes["missing"]}>No picture</span>}
    </div>
  );
}

function paint(canvas: HTMLCanvasElement, image: ImageBitmap): void {
  if (canvas.width !== image.width) canvas.width = image.width;
  if (canvas.height !== image.height) canvas.height = image.height;
  canvas.getContext("2d")?.drawImage(image, 0, 0);
  image.close();
}
