// Orbiting by mouse, touch, wheel and keyboard.

const DEGREES_PER_HALF_TURN = 180; // a drag across the shorter side of the picture
const DEGREES_PER_KEY = 2;
const ZOOM_PER_KEY = 1.05;
const ZOOM_PER_WHEEL_PIXEL = 1.001;
const PIXELS_PER_WHEEL_LINE = 20;

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

/** Lets an element steer the camera until the signal is aborted. */
export function steer(element: HTMLElement, motion: Motion, signal: AbortSignal): void {
  const pointers = new Map<number, { x: number; y: number }>();

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
    element.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  });

  on("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (before === undefined) return;
    const spreadBefore = spread();
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (pointers.size === 1) {
      // The scene follows the pointer: to the right, so the camera goes left, where azimuths are smaller.
      const degrees = DEGREES_PER_HALF_TURN / Math.min(element.clientWidth, element.clientHeight);
      if (event.shiftKey && motion.shiftDrag((event.clientX - before.x) * degrees)) return;
      motion.turn((before.x - event.clientX) * degrees, (event.clientY - before.y) * degrees);
    } else if (pointers.size === 2 && spread() > 0) {
      motion.zoom(spreadBefore / spread());
    }
  });

  const release = (event: PointerEvent) => pointers.delete(event.pointerId);
  on("pointerup", release);
  on("pointercancel", release);

  on(
    "wheel",
    (event) => {
      event.preventDefault();
      const pixels = event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? 1 : PIXELS_PER_WHEEL_LINE);
      motion.zoom(ZOOM_PER_WHEEL_PIXEL ** pixels);
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
