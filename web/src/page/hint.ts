// Says how the viewer is meant when the page took a wheel or a finger.

const SHOWN_MS = 1600;
const APPLE = /Mac|iPhone|iPad/.test(navigator.platform);

const TEXTS = {
  wheel: `${APPLE ? "⌘" : "Ctrl"} and the wheel zoom, or click the picture first`,
  finger: "Two fingers turn and zoom, one turns sideways",
} as const;

export class Hint {
  private timer = 0;

  constructor(private readonly element: HTMLElement) {}

  show(by: keyof typeof TEXTS): void {
    this.element.textContent = TEXTS[by];
    this.element.classList.add("shown");
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => this.element.classList.remove("shown"), SHOWN_MS);
  }
}
