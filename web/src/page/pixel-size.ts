// How many pixels of the screen an element covers.

type Tell = (width: number, height: number) => void;

/** Tells it, now and whenever the element's place, the page's zoom or the screen changes, until the signal is aborted. */
export function followPixelSize(element: HTMLElement, tell: Tell, signal: AbortSignal): void {
  let exact: ResizeObserverSize | undefined; // where the browser says it
  const measure = () => {
    const width = pixels(element.clientWidth, exact?.inlineSize);
    const height = pixels(element.clientHeight, exact?.blockSize);
    tell(width, height);
  };
  const observer = new ResizeObserver(([entry]) => {
    exact = entry?.devicePixelContentBoxSize?.[0];
    measure();
  });
  try {
    observer.observe(element, { box: "device-pixel-content-box" });
  } catch {
    observer.observe(element); // Safari
  }
  signal.addEventListener("abort", () => observer.disconnect());
  followRatio(measure, signal);
  measure(); // observers tell it after the next frame only
}

/** What is exact by the element's place on the screen is within a pixel of what its size comes to; else it is outdated. */
function pixels(length: number, exact: number | undefined): number {
  const rounded = Math.round(length * devicePixelRatio);
  return exact !== undefined && Math.abs(exact - length * devicePixelRatio) <= 1 ? exact : rounded;
}

/** Calls after each change of the page's ratio of pixels: a query holds for one ratio, so each change asks another. */
function followRatio(changed: () => void, signal: AbortSignal): void {
  const again = () => {
    changed();
    followRatio(changed, signal);
  };
  matchMedia(`(resolution: ${devicePixelRatio}dppx)`).addEventListener("change", again, { once: true, signal });
}
