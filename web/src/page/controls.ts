// Orbiting by mouse, touch, wheel and keyboard, and leaving to the page what is the page's.

const DEGREES_PER_HALF_TURN = 180; // a drag across the shorter side of the picture
const DEGREES_PER_KEY = 2;
const ZOOM_PER_KEY = 1.05;
const ZOOM_PER_WHEEL_PIXEL = 1.001;
const PIXELS_PER_WHEEL_LINE = 20;
const MOST_OF_A_PINCH = 50; // pixels: a pinch on a touchpad comes as a wheel with Ctrl, in small steps
const PINCH_STEPS = 10; // of the wheel, for one of these
const UNDECIDED = 8; // pixels that a finger moves before it is clear whether the page scrolls by it

export interface Motion {
  /** Turns the camera, in degrees. */
  turn(azimuth: number, elevation: number): void;
  /** Multiplies its distance. */
  zoom(factor: number): void;
  /** A drag to the right with shift held, or a key for it, in degrees. Returns false where that means nothing. */
  shiftDrag(degrees: number): boolean;
  /** A lamp, where there may be one: on or off, and around by so many degrees. */
  toggleLamp(): void;
  moveLamp(degrees: number): void;
  /** Back to where it began. */
  home(): void;
}

/** What the page has to say. */
export interface Page {
  /** Whether the wheel and one finger are the viewer's alone. */
  readonly captured: boolean;
  /** Whether the viewer has the focus, and with it the wheel. */
  readonly focused: boolean;
  /** The page took what could have been meant for the viewer. */
  passed(by: "wheel" | "finger"): void;
}

/** Lets an element steer the camera until the signal is aborted. */
export function steer(element: HTMLElement, motion: Motion, page: Page, signal: AbortSignal): void {
  const pointers = new Map<number, Grip>();

  const spread = () => {
    const [a, b] = [...pointers.values()];
    return a && b ? Math.hypot(a.x - b.x, a.y - b.y) : 0;
  };

  const on = <K extends keyof HTMLElementEventMap>(
    type: K,
    listener: (event: HTMLElementEventMap[K]) => void,
    options: AddEventListenerOptions = {},
  ) => element.addEventListener(type, listener, { signal, ...options });

  on("pointerdown", (event) => {
    if (event.button !== 0) return;
    const touchAction = event.pointerType === "mouse" ? "none" : getComputedStyle(element).touchAction;
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY, touchAction });
    element.setPointerCapture(event.pointerId);
  });

  on("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (before === undefined) return;
    if (event.buttons === 0) {
      pointers.delete(event.pointerId); // let go where nobody told: over a menu, in another window
      return;
    }
    if (pointers.size === 1 && !isOurs(before, event)) return;
    const spreadBefore = spread();
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY, touchAction: "none" });
    // The scene follows the pointers' middle: to the right, so the camera goes left, where azimuths are smaller.
    const degrees = DEGREES_PER_HALF_TURN / Math.min(element.clientWidth, element.clientHeight) / pointers.size;
    if (event.shiftKey && motion.shiftDrag((event.clientX - before.x) * degrees)) return;
    motion.turn((before.x - event.clientX) * degrees, (event.clientY - before.y) * degrees);
    if (pointers.size === 2 && spreadBefore > 0 && spread() > 0) motion.zoom(spreadBefore / spread());
  });

  const release = (event: PointerEvent) => pointers.delete(event.pointerId);
  on("pointerup", release);
  on("lostpointercapture", release);
  on("pointercancel", (event) => {
    if (pointers.size === 1 && event.pointerType !== "mouse") page.passed("finger"); // the page scrolls by it
    release(event);
  });

  // Two fingers are ours, whatever CSS leaves to the page.
  const keepTwo = (event: TouchEvent) => {
    if (event.targetTouches.length > 1 && event.cancelable) event.preventDefault();
  };
  on("touchstart", keepTwo, { passive: false });
  on("touchmove", keepTwo, { passive: false });

  on(
    "wheel",
    (event) => {
      const zooms = event.ctrlKey || event.metaKey;
      if (!zooms && !page.captured && !page.focused) {
        page.passed("wheel");
        return;
      }
      event.preventDefault();
      const pixels = wheelPixels(event, element);
      const steps = event.ctrlKey && Math.abs(pixels) < MOST_OF_A_PINCH ? PINCH_STEPS : 1;
      motion.zoom(ZOOM_PER_WHEEL_PIXEL ** (steps * pixels));
    },
    { passive: false },
  );

  const keys: Record<string, () => void> = {
    ArrowLeft: () => motion.turn(-DEGREES_PER_KEY, 0),
    ArrowRight: () => motion.turn(DEGREES_PER_KEY, 0),
    ArrowUp: () => motion.turn(0, DEGREES_PER_KEY),
    ArrowDown: () => motion.turn(0, -DEGREES_PER_KEY),
    "+": () => motion.zoom(1 / ZOOM_PER_KEY),
    "=": () => motion.zoom(1 / ZOOM_PER_KEY),
    "-": () => motion.zoom(ZOOM_PER_KEY),
    Home: () => motion.home(),
    "[": () => motion.shiftDrag(-DEGREES_PER_KEY),
    "]": () => motion.shiftDrag(DEGREES_PER_KEY),
    l: () => motion.toggleLamp(),
    ",": () => motion.moveLamp(-DEGREES_PER_KEY),
    ".": () => motion.moveLamp(DEGREES_PER_KEY),
  };
  on("keydown", (event) => {
    const act = event.ctrlKey || event.metaKey || event.altKey ? undefined : keys[event.key];
    if (act === undefined) return;
    event.preventDefault();
    act();
  });
}

/** Where a pointer was, and which of its motions CSS leaves to the page: "none" once it is ours. */
interface Grip {
  readonly x: number;
  readonly y: number;
  readonly touchAction: string;
}

/** Whether a motion is the viewer's. The browser cancels the pointers whose motions are the page's, but a little late. */
function isOurs({ x, y, touchAction }: Grip, { clientX, clientY }: PointerEvent): boolean {
  const [across, down] = [Math.abs(clientX - x), Math.abs(clientY - y)];
  if (touchAction === "none") return true;
  if (Math.max(across, down) < UNDECIDED) return false;
  return touchAction === "pan-y" ? across > down : touchAction === "pan-x" && down > across;
}

function wheelPixels({ deltaY, deltaMode }: WheelEvent, { clientHeight }: HTMLElement): number {
  switch (deltaMode) {
    case WheelEvent.DOM_DELTA_LINE:
      return deltaY * PIXELS_PER_WHEEL_LINE;
    case WheelEvent.DOM_DELTA_PAGE:
      return deltaY * clientHeight;
    default:
      return deltaY;
  }
}
