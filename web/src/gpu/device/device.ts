// The graphics device of the browser.

const TRIES = 6; // after a loss: the browser may be starting its graphics process again
const PAUSE_MS = 250;

/** Opens a device; rejects with one sentence where there is none. */
export async function openDevice(): Promise<GPUDevice> {
  if (!navigator.gpu) throw new Error(`This picture is drawn with WebGPU, ${whyNone()}`);
  const adapter = await navigator.gpu.requestAdapter({ powerPreference: "high-performance" });
  if (adapter === null) {
    throw new Error(
      "This picture is drawn with WebGPU, and this browser found no graphics adapter for it: hardware acceleration may " +
        "be switched off in its settings, or the graphics driver is one that it does not trust.",
    );
  }
  const { maxTextureDimension2D, maxBufferSize, maxStorageBufferBindingSize } = adapter.limits;
  return adapter.requestDevice({
    requiredLimits: { maxTextureDimension2D, maxBufferSize, maxStorageBufferBindingSize },
  });
}

/** Opens a device where there was one a moment ago. */
export async function reopenDevice(): Promise<GPUDevice> {
  for (let k = 1; k < TRIES; k++) {
    const device = await openDevice().catch(() => undefined);
    if (device) return device;
    await new Promise((resolve) => setTimeout(resolve, PAUSE_MS * k));
  }
  return openDevice();
}

function whyNone(): string {
  if (window.isSecureContext) {
    return "and this browser does not offer it; try a current Chrome, Edge, Safari or Firefox.";
  }
  const { hostname, host, port, pathname } = location;
  const here = port || "8080";
  return (
    `which browsers offer to pages over https and from localhost only, not to http://${host}. Open it over https, or ` +
    `run ssh -N -L ${here}:${hostname}:${port || "80"} ${hostname} and open http://localhost:${here}${pathname}`
  );
}
